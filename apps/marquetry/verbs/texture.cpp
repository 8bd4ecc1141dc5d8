// marquetry texture MESH --cameras FILE -o OUT: a mesh and photographs with cameras become a textured model.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "mq/atlas/overlap_depth.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "mq/mesh/geometry.h"
#include "mq/model/bake_target.h"
#include "mq/model/model_paints.h"
#include "mq/model/photograph_costs.h"
#include "mq/model/photograph_page.h"
#include "mq/model/photograph_store.h"
#include "mq/model/photograph_texture.h"
#include "mq/model/photographs.h"
#include "mq/model/unwrapped_model.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/baking.h"
#include "verbs/shared/input_pictures.h"
#include "verbs/shared/partials.h"
#include "verbs/shared/photographs.h"
#include "verbs/shared/render_request.h"

namespace mq::app {
namespace {

/// Whether it has texture coordinates, and these are wanted.
bool keeps_coordinates(const OptionValues& options, const TexturedModel& scene) {
  return !options.flag("unwrap") && !scene.model.mesh.corner_uvs.empty();
}

constexpr double read_share = 0.02;  ///< of the progress, before it is known what follows

/// Shares of the progress in which stages come to their ends together with their time: seconds of one core as measured
/// (`PhotographCosts`), of all.
struct Shares {
  double unwrap = 0, assemble, look, take, solve, page = 0, write;

  Shares(const OptionValues& options, bool unwraps, int side, std::span<const Photograph> photographs) {
    const double texels = double(side) * side, millions = texels / 1e6;
    const PhotographCosts costs = photograph_costs(photographs, texels, asked_photograph_options(options));
    if (unwraps) unwrap = 5;
    assemble = 1.8 * millions, look = costs.looked(), take = costs.take;
    solve = 4.5 * millions, write = 0.2 + 0.6 * millions;
    if (options.has("picture")) page = 3.4;
    const double all = (unwrap + assemble + look + take + solve + page + write) / (1 - read_share);
    for (double* share : {&unwrap, &assemble, &look, &take, &solve, &page, &write}) *share /= all;
  }
};

/// Throws where the mesh's own texture coordinates cannot hold what photographs show of each place, with the way out.
void require_places_of_their_own(const TexturedModel& scene) {
  const std::string file = scene.model.path.string();
  const std::string unwrapped = "give the mesh new texture coordinates with --unwrap";
  if (scene.atlas && scene.atlas->charts.empty())
    throw InvalidInput(file + ": no triangle has an area in the texture: " + unwrapped);
  try {
    require_usable(scene.defects(), file);
  } catch (const InvalidInput& error) {
    throw InvalidInput(error.what() + (scene.atlas && refused(scene.atlas->defects) ? "; or " + unwrapped : ""));
  }
  constexpr double deepest = 8;  // of parts alike that share a place, as the sides of a column do
  const OverlapDepth overlaps = overlap_depth(scene.surface, *scene.atlas);
  require(overlaps.mean <= deepest,
          fmt::format("{}: in its texture {:.0f} triangles lie on each other, and {:.0f} % of the texels in use are "
                      "covered more than once: as photographs show these places, each would be painted over the "
                      "others; {}",
                      file, overlaps.mean, 100 * overlaps.share, unwrapped));
}

/// The mesh with texture coordinates and black pictures of the size that it will have.
void prepare_textures(Run& run, int side, const Shares& shares, TexturedModel& scene) {
  const OptionValues& options = run.options();
  const bool keeps = keeps_coordinates(options, scene);
  if (!keeps) {
    UnwrapOptions wanted;
    wanted.width = wanted.height = side;
    const Step step(run, "unwrap", shares.unwrap);
    about(scene.model, [&] { put_unwrapped(unwrap(scene.surface, wanted, step), scene); });
  }
  LoadOptions load{.weld = asked_weld(options), .missing = MissingPictures::assume, .assumed_side = side};
  if (keeps) load.atlas = asked_flipped(options);
  if (!keeps || options.has("size")) load.side = side;
  scene = textured_again(std::move(scene.model), load, run.terminal());
  run.defects = Json::array();  // those of the mesh are among these
  run.found(scene.defects());
  run.warn(scene.defects());
  require_places_of_their_own(scene);
  if (load.side)
    for (Texture& picture : scene.model.textures) {
      Texture fresh;
      fresh.name = picture.name, fresh.wrap = picture.wrap;
      picture = std::move(fresh);
    }
  require(options.text("unseen") != "keep" || has_pictures(scene),
          scene.model.path.string() + ": --unseen keep: it has no picture to keep; name one after it");
  add_missing_pictures(scene);
  int unnamed = 0;
  for (Texture& picture : scene.model.textures)
    if (picture.name.empty()) {
      const std::filesystem::path output = options.text("output");
      picture.name = output.has_filename() ? output.stem().string() : scene.model.path.stem().string();
      if (unnamed++ > 0) picture.name += fmt::format("_{}", unnamed);
    }
  if (scene.model.colors.channels > 0) leave_out_colours(scene.model, run.terminal());
}

/// "12 of 14 photographs used, 2 left out: IMG_111.jpg (is not there), ...".
std::string summary_of(const GivenPhotographs& given, const PhotographTexture& found) {
  std::vector<std::string> left_out;
  for (const auto& [picture, why] : given.left_out)
    left_out.push_back(fmt::format("{} ({})", std::filesystem::path(picture).filename().string(),
                                   why.starts_with(picture + ": ") ? why.substr(picture.size() + 2) : why));
  std::int64_t used = 0;
  for (std::size_t v = 0; v < found.views.size(); ++v) {
    const std::string& why = found.views[v].left_out;
    const std::string picture = given.photographs[v].picture.string();
    used += found.views[v].texels > 0;
    if (!why.empty())
      left_out.push_back(fmt::format("{} ({})", given.photographs[v].picture.filename().string(),
                                     why.starts_with(picture + ": ") ? why.substr(picture.size() + 2) : why));
  }
  std::string text = fmt::format("{} of {} used", used, counted(std::int64_t(given.count()), "photograph"));
  if (!left_out.empty())
    text += fmt::format(", {} left out: {}", left_out.size(), fmt::join(left_out, ", "));
  return text;
}

void report_photographs(Run& run, const GivenPhotographs& given, const PhotographTexture& found) {
  const std::vector<Photograph>& photographs = given.photographs;
  Json views = Json::array(), left_out = Json::array();
  for (const auto& [picture, why] : given.left_out) left_out.push_back({{"picture", picture}, {"why", why}});
  run.result["left_out"] = left_out;
  for (std::size_t v = 0; v < photographs.size(); ++v) {
    const PhotographTexture::View& view = found.views[v];
    views.push_back({{"picture", photographs[v].picture.string()},
                     {"texels", view.texels},
                     {"patches", view.patches},
                     {"rejected", view.rejected},
                     {"gain", {view.gain[0], view.gain[1], view.gain[2]}},
                     {"exponent", view.exponent},
                     {"moved", view.moved}});
    if (!view.left_out.empty()) views.back()["left_out"] = view.left_out;
  }
  const double all = double(found.labels.size());
  const auto share = [&](std::size_t from, std::size_t to) {
    std::int64_t sum = 0;
    for (std::size_t k = from; k < std::min(to, found.seen_by.size()); ++k) sum += found.seen_by[k];
    return double(sum) / all;
  };
  const double undecided = double(found.undecided) / all;
  run.result["views"] = views;
  run.result["falloff"] = {found.falloff.k1, found.falloff.k2};
  run.result["patches"] = found.patches;
  run.result["unseen"] = std::ranges::count(found.labels, unseen);
  run.result["seen"] = {{"by_none", share(0, 1)},
                        {"by_one", share(1, 2)},
                        {"by_two", share(2, 3)},
                        {"by_more", share(3, found.seen_by.size())},
                        {"undecided", undecided}};
  const Agreement& agreement = found.agreement;
  run.result["apart"] = {{"here", agreement.here}, {"elsewhere", agreement.elsewhere}};
  if (agreement.is_accidental())
    run.terminal().warning(fmt::format(
        "these photographs do not seem to show this mesh from these cameras: what they show at one place is {:.0f} % "
        "apart, at different places {:.0f} %: look whether the cameras are of these photographs (names in order?) and "
        "of this mesh, with the verb cameras and its --picture",
        100 * std::expm1(agreement.here), 100 * std::expm1(agreement.elsewhere)));
  constexpr double some = 0.01, much = 0.3, most = 0.9;
  if (undecided > some && run.options().text("outliers") == "reject")
    run.terminal().warning(fmt::format("{:.1f} % of the texture is shown by two photographs alone that disagree: what one "
                                       "of them shows there may be a passer-by or a reflection: look at these places, "
                                       "and take another photograph of them",
                                       100 * undecided));
  if (share(0, 1) > much)
    run.terminal().warning(fmt::format(
        "no photograph shows {:.0f} % of the texture: {}{}", 100 * share(0, 1),
        run.options().text("unseen") == "keep" ? "colours there are kept"
                                               : "colours there are guessed from what is around",
        share(0, 1) > most ? "; are mesh and cameras of the same units and coordinates? The verb cameras and its "
                             "--picture show them"
                           : ""));
  run.print(fmt::format("{}; of the texture {:.1f} % is seen by none, {:.1f} % by one, {:.1f} % by two, "
                        "{:.1f} % by more\n",
                        summary_of(given, found), 100 * share(0, 1), 100 * share(1, 2), 100 * share(2, 3),
                        100 * share(3, found.seen_by.size())));
}

Filtered put_together(Run& run, const TextureSignal& target, double weight, const PhotographTexture& found,
                      double share) {
  Filtered filtered;
  solve_as_asked(run, target, [&](const SolverFactory& factory, const SolvingShares&) {
    const Step step(run, "solve", share);
    const Stitcher stitcher(target.space(), weight, found.regions, factory, {}, Stitcher::Systems::one_each);
    filtered = stitcher.stitch(found.values, found.beyond, found.offset, step);
    return filtered.report;
  });
  return filtered;
}

/// What no photograph shows has the model's own values, as a region of its own, so that no step is left around it.
void keep_unseen(const TextureSignal& target, PhotographTexture& found) {
  const Signal own = target.values();
  const int number = int(found.views.size()) + 1;
  for (std::size_t i = 0; i < found.regions.size(); ++i)
    if (found.regions[i] == unseen) {
      found.regions[i] = number;
      found.values.row(Eigen::Index(i)) = own.row(Eigen::Index(i));
    }
}

void draw_page(Run& run, const TexturedModel& scene, const TextureSignal& target,
               std::span<const Photograph> photographs, const PhotographTexture& found, double share) {
  const Step step(run, "draw the page", share);
  std::vector<std::string> names;
  for (const Photograph& photograph : photographs) names.push_back(photograph.picture.filename().string());
  const Image<float> page = draw_photographs(scene, target, found, names, asked_up(run.options()));
  for (const std::string& note : write_image(run.options().text("picture"), page)) run.terminal().remark(note);
}

/// Of options, what cannot be, before any work.
void check_options(const OptionValues& options) {
  require_picture_name(options, "picture");
  require(options.has("picture") || !asks_for(options, "up"), "--up: it is of --picture: give it too");
  if (options.text("unseen") == "keep")
    for (const char* name : {"size", "unwrap"})
      require(!asks_for(options, name),
              fmt::format("--unseen keep: it keeps the texels of the model's own picture, of which --{} leaves none: "
                          "leave out one of them",
                          name));
}

/// Why no photograph shows anything, as far as places tell.
std::string why_nothing_is_seen(const Surface& surface, std::span<const Photograph> photographs) {
  constexpr double far = 30;  // model's diagonals
  const Box box = bounding_box(surface.mesh);
  std::vector<double> distances;
  for (const Photograph& photograph : photographs)
    distances.push_back((photograph.camera.center() - (box.low + box.high) / 2).norm());
  std::ranges::nth_element(distances, distances.begin() + std::ssize(distances) / 2);
  const double times = distances[distances.size() / 2] / box.diagonal();
  if (times > far || times < 1 / far)
    return fmt::format("most cameras stand {:.3g} times its size from its middle: export both in the same units and "
                       "coordinates",
                       times);
  std::vector<PinholeCamera> cameras;
  for (const Photograph& photograph : photographs) cameras.push_back(photograph.camera);
  if (axes_seem_exchanged(surface.mesh, cameras)) return exchanged_axes_hint;
  return "check the cameras with the verb cameras, alpha of the photographs, and --steepest, --bias and --outline";
}

Exit texture(Run& run) {
  const OptionValues& options = run.options();
  check_options(options);
  TexturedModel scene = read_textured_model(run, MissingPictures::unneeded, read_share);
  require(!scene.is_picture, scene.model.path.string() +
                                 ": is a picture; photographs with cameras are projected onto the mesh of a model");
  const bool keeps_unseen = options.text("unseen") == "keep";
  require(!keeps_unseen || keeps_coordinates(options, scene),
          scene.model.path.string() + ": --unseen keep: it has no texture coordinates, so no texture to keep");
  const GivenPhotographs given = read_photographs(run);
  const std::vector<Photograph>& photographs = given.photographs;
  std::vector<std::filesystem::path> pages;
  if (options.has("picture")) pages.emplace_back(options.text("picture"));
  const auto will_write = [&](const Outputs& outputs) {
    std::vector<std::filesystem::path> paths = outputs.paths();
    paths.insert(paths.end(), pages.begin(), pages.end());
    run.will_write(paths, outputs.folders());
  };
  const bool keeps = keeps_coordinates(options, scene);
  std::optional<Outputs> outputs;
  if (!keeps) {
    outputs = unwrapped_outputs(options, scene.model, {});
    require(outputs->is_model(), options.text("output") +
                                     ": a picture alone cannot hold the texture coordinates that the mesh gets: give "
                                     "a model (.obj, .ply, .gltf, .glb)");
    will_write(*outputs);
    if (run.dry_run()) return Exit::done;
  }
  const int side =
      options.has("size") ? int(options.integer("size")) : side_for_photographs(scene.surface, photographs);
  const Shares shares(options, !keeps, side, photographs);
  prepare_textures(run, side, shares, scene);
  check_pictures(options, scene, {"labels"});
  if (keeps) {
    outputs.emplace(options.text("output"), scene.model, Outputs::Kind::pictures);
    will_write(*outputs);
    if (run.dry_run()) return Exit::done;
  }

  std::unique_ptr<TextureSignal> target;
  std::optional<PhotographTexture> found;
  about(scene.model, [&] {
    {
      const Step step(run, "assemble", shares.assemble);
      target = make_texture_signal(run, scene, {.values = value_space(options), .depth = asked_depth(options)}, step);
    }
    const double both = shares.look + shares.take;
    const Step step(run, "photographs", both);
    PhotographTextureOptions wanted_options = asked_photograph_options(options);
    if (options.has("resume")) wanted_options.resume = options.text("resume");
    std::vector<int> wanted;
    if (!options.texts("labels").empty())
      wanted = asked_photographs(options, scene, *target, int(photographs.size()));
    const PhotographTexturing work(scene, *target, photographs, wanted_options, run.terminal(),
                                   step.progress().step("look", shares.look / both));
    found = work.make(wanted, step.progress().step("take", shares.take / both));
  });
  report_photographs(run, given, *found);
  require(std::ranges::any_of(found->labels, [](int label) { return label != unseen; }),
          scene.model.path.string() + ": no photograph shows any of it: " +
              why_nothing_is_seen(scene.surface, photographs));
  const SurfaceScale scale = target->space().scale();
  const double weight = spread_weight(options, scale);
  if (keeps_unseen) keep_unseen(*target, *found);
  Filtered filtered;
  about(scene.model, [&] { filtered = put_together(run, *target, weight, *found, shares.solve); });
  run.result.update(change_json(found->values, filtered.signal, value_space(options).space));
  run.result["alpha"] = weight / scale.area;
  run.result["length"] = std::sqrt(weight);

  target->put(target->values(), filtered.signal, scene.model);
  set_depth(options, scene.model);
  if (options.has("picture")) draw_page(run, scene, *target, photographs, *found, shares.page);
  const Step step(run, "write", shares.write);
  write_outputs(run, *outputs, std::move(scene.model), step);
  for (const std::filesystem::path& page : pages) run.result["outputs"].push_back(page.string());
  if (options.has("resume")) forget_stored_photographs(options.text("resume"));
  return Exit::done;
}

}  // namespace

Verb texture_verb() {
  using Type = Option::Type;
  OptionTable table("texture", "Make a textured model of a mesh and photographs with cameras.");
  table.example("scan.ply --cameras cameras.json -o textured.glb", "a mesh without texture coordinates gets some");
  table.elsewhere("align", "cameras are moved by --poses align, which is what is done without it; --poses keep leaves them");
  for (const char* name : {"views", "photographs"})
    table.elsewhere(name, "photographs are named by the file of their cameras, --cameras, and their folder, --images");
  add_model_options(table, "the mesh: OBJ, PLY, glTF or GLB");
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "the textured model, or for one that has texture coordinates a picture"});
  add_compress_option(table);
  add_photograph_options(table);
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .unit = "texels",
             .least = 16,
             .most = 32768,
             .group = "Texture",
             .help = "side of the texture",
             .details = "Without it that of the model's own picture; where there is none, what the photographs "
                        "resolve, from 256 to 8192."});
  table.add({.name = "unwrap",
             .group = "Texture",
             .help = "give the mesh new texture coordinates even if it has some"});
  table.add({.name = "labels",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Photographs",
             .help = "a picture per texture: the number of the photograph that texels are to come from",
             .details = "Counted from 0, the first channel as stored; the viewer's tool paints them. Where it is "
                        "transparent, and where that photograph does not show the texel, one is chosen."});
  table.add({.name = "resume",
             .type = Type::path,
             .metavar = "FOLDER",
             .group = "Photographs",
             .help = "keep what is found of each photograph in this folder, and go on from what is there",
             .details = "For many photographs: the same command goes on where it was stopped. What was found with "
                        "others or other options is found again. Removed once the result is written."});
  table.add({.name = "picture",
             .type = Type::path,
             .group = "Texture",
             .help = "a page that shows which photograph was chosen where, beside the result, how many show it, and how many are left out there"});
  add_up_option(table, "Texture");
  table.add({.name = "unseen",
             .type = Type::choice,
             .default_value = "fill",
             .choices = {"fill", "keep"},
             .metavar = "HOW",
             .group = "Texture",
             .help = "what no photograph shows is filled from what is around, or keeps the model's own texture",
             .details = "Kept, it is another photograph: there is no step around it."});
  add_spread_options(table, usual_photograph_length, "Stitch", "how far steps between photographs are spread");
  add_solver_options(table);
  add_space_option(table);
  add_depth_option(table);
  return {table, texture, {{.what = "made of photographs with cameras", .vertices = "", .pictures = ""}}};
}

}  // namespace mq::app
