// marquetry render MESH [TEXTURE...] -o OUT.png: pictures of a model, of its charts and seams, and
// of two versions of its textures side by side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/base/words.h"
#include "mq/draw/pinhole.h"
#include "mq/draw/texture_difference.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "verbs/shared/render_request.h"
#include "verbs/shared/seam_report.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// Model units across the picture that --extent asks for.
double extent_of(const OptionValues& options, const TexturedModel& scene) {
  const Length length = parse_length(options.text("extent"));
  require(length.value > 0, "--extent: found '" + options.text("extent") + "', wanted more than 0");
  const SurfaceScale scale{scene.surface.area, scene.atlas ? scene.atlas->texel_spacing() : 0};
  require(length.unit != Length::Unit::texels || scale.texel_spacing > 0,
          scene.model.path.string() +
              ": no triangle has an area both on the surface and in a texture, so --extent cannot "
              "be in texels; give it in model units, such as 0.1, or as 1%");
  return std::sqrt(weight_from_length(length, scale));
}

/// Where the textures drawn first jump most.
void look_at_seam(Run& run, const TexturedModel& scene, const ModelRenderer& renderer, View& view) {
  const std::string file = scene.model.path.string();
  require(has_pictures(scene), file + ": has no textures whose seams could differ");
  require(scene.atlas->seam_count > 0, file + ": has no seam to look at; give --at three coordinates");
  const SeamDifference seams = texture_seams(scene);
  require(!seams.edges.empty(),
          file + ": has no seam whose two sides could differ; give --at three coordinates");
  const Sight sight = renderer.sight_of_seam(seams, extent_of(run.options(), scene), view);
  if (!sight.clear)
    run.terminal().remark("the place where seams differ most is hidden; seen from straight above");
  if (seams.rms < 0.5 / 255)
    run.terminal().remark(fmt::format("{}: seams differ by {:.2g} of 255, at most {:.2g}: there is little to see", file,
                                      255 * seams.rms, 255 * seams.worst.difference));
  view = sight.view;
  const Vector3& p = *view.target;
  run.result["seam"] = {
      {"rms", seams.rms}, {"largest", seams.worst.difference}, {"at", {p.x(), p.y(), p.z()}}};
}

/// Where the textures drawn first and those drawn beside them differ most.
void look_at_difference(Run& run, const TexturedModel& scene, std::span<const Texture> after,
                        const ModelRenderer& renderer, View& view) {
  const std::string file = scene.model.path.string();
  require(!after.empty(), "--at difference: there is nothing to differ from: name other textures with --compare");
  const TextureDifference found =
      texture_difference(scene.surface, *scene.atlas, pictures_of(scene.model.textures),
                         pictures_of(after.first(scene.model.textures.size())), {.most = 1});
  require(!found.places.empty(), file + ": --at difference: the textures do not differ anywhere on the model");
  const DifferencePlace& place = found.places.front();
  const Sight sight = renderer.sight_of_place(place.point, place.normal, extent_of(run.options(), scene), view);
  if (!sight.clear)
    run.terminal().remark("the place where textures differ most is hidden; seen from straight above");
  view = sight.view;
  const Vector3& p = place.point;
  run.result["difference"] = {
      {"rms", found.rms}, {"largest", place.difference}, {"at", {p.x(), p.y(), p.z()}}};
}

/// Moves the camera to the place --at names.
void look_at_place(Run& run, const TexturedModel& scene, std::span<const Texture> after,
                   const ModelRenderer& renderer, View& view) {
  const OptionValues& options = run.options();
  if (!options.has("at")) return;
  if (options.text("at") == "seam") return look_at_seam(run, scene, renderer, view);
  if (options.text("at") == "difference") return look_at_difference(run, scene, after, renderer, view);
  const auto place = numbers_of(options, "at", 3);
  view.target = Vector3(place[0], place[1], place[2]);
  view.extent = extent_of(options, scene);
}

/// The camera that --through and --photograph name. Throws `InvalidInput` where there is none.
PinholeCamera asked_camera(Run& run) {
  const OptionValues& options = run.options();
  const std::string file = options.text("through");
  CamerasOptions how{.missing = CamerasOptions::Missing::list, .unreadable = CamerasOptions::Missing::list};
  CameraSet set = read_camera_set(file, how);
  for (const std::filesystem::path& read : set.files) run.will_read(read);
  std::vector<Photograph> all = std::move(set.photographs);
  std::ranges::move(set.missing, std::back_inserter(all));
  std::erase_if(all, [](const Photograph& one) { return one.camera.width == 0; });
  require(!all.empty(), file + ": has no camera of which the size of its picture is known");
  const std::string name = options.has("photograph") ? options.text("photograph") : "";
  const auto named = [&](const Photograph& one) {
    return name.empty() || one.picture == name || one.picture.filename() == name || one.picture.stem() == name;
  };
  const auto chosen = std::ranges::find_if(all, named);
  require(chosen != all.end(),
          fmt::format("--photograph: {} has no camera of {}; it has {}, the first of {}", file, name,
                      counted(std::ssize(all), "camera"), all.front().picture.filename().string()));
  if (name.empty() && all.size() > 1)
    run.terminal().remark(fmt::format("{}: has {}; seen as in {}: --photograph names another", file,
                                      counted(std::ssize(all), "camera"), chosen->picture.filename().string()));
  const PinholeCamera& camera = chosen->camera;
  if (camera.lens != Lens{} || camera.skew != 0 || std::abs(camera.fx / camera.fy - 1) > 1e-3)
    run.terminal().remark(fmt::format("{}: drawn without the distortion of its lens",
                                      chosen->picture.filename().string()));
  return camera;
}

/// Draws what a camera of a file sees, in its proportions where --size is one number.
void look_through(Run& run, ModelPictureOptions& wanted) {
  const OptionValues& options = run.options();
  require(options.has("through") || !options.has("photograph"), "--photograph: it is one of --through: give it too");
  if (!options.has("through")) return;
  for (const char* name : {"view", "at", "projection", "overview", "layout"})
    require(!asks_for(options, name), fmt::format("--{}: --through says from where: leave one of them out", name));
  const PinholeCamera camera = asked_camera(run);
  wanted.render.view.through = standing(camera);
  if (options.text("size").find('x') != std::string::npos) return;
  const double scale = double(std::max(wanted.render.width, wanted.render.height)) / std::max(camera.width, camera.height);
  wanted.render.width = std::max(1, int(std::lround(camera.width * scale)));
  wanted.render.height = std::max(1, int(std::lround(camera.height * scale)));
}

/// Of one version an object, of several a list.
Json seams_of_versions(const TexturedModel& scene, const std::vector<Texture>& textures) {
  const auto count = std::ptrdiff_t(scene.model.textures.size());
  if (std::ssize(textures) == count) return seams_json(scene, textures);
  Json all = Json::array();
  for (auto first = textures.begin(); first != textures.end(); first += count)
    all.push_back(seams_json(scene, std::vector<Texture>(first, first + count)));
  return all;
}

Exit render(Run& run) {
  const OptionValues& options = run.options();
  require_picture_name(options, "output");
  const TexturedModel scene = read_textured_model(run, MissingPictures::overlook, 0.1);
  const std::string output = options.text("output");
  std::vector<std::filesystem::path> files = {output};
  if (options.has("cameras")) {
    require(!options.flag("layout") && !options.flag("overview") && !options.has("compare") &&
                options.texts("view").size() == 1,
            "--cameras: a page has no camera: draw one view of one model");
    files.emplace_back(options.text("cameras"));
  }
  ModelPictureOptions wanted = asked_picture(options, scene);
  look_through(run, wanted);
  run.will_write(files);
  check_pictures(options, scene,
                 {"compare", InputPictures::Count::many_sets, InputPictures::Size::of_the_texture});
  if (run.dry_run()) return Exit::done;

  const std::vector<Texture> after = read_compared(options, scene);
  Image<float> picture;
  PinholeCamera camera;
  about(scene.model, [&] {
    const Step step(run, "draw", 0.88);
    if (options.flag("layout")) {
      picture = draw_layout(scene, after, wanted.layout, wanted.sheet, step);
      return;
    }
    const ModelRenderer renderer(scene);
    look_at_place(run, scene, after, renderer, wanted.render.view);
    picture = renderer.draw(wanted, after, step);
    if (options.has("cameras"))
      camera = pinhole_of(Camera(scene.surface.mesh, wanted.render.view, picture.width(),
                                 picture.height()));
  });
  if (!after.empty())
    run.result["seams"] = {{"before", seams_json(scene)}, {"after", seams_of_versions(scene, after)}};
  run.result["width"] = picture.width();
  run.result["height"] = picture.height();
  run.result["output"] = output;
  for (const std::string& note : write_image(output, picture)) run.terminal().remark(note);
  remark_written(run, output);
  if (!options.has("cameras")) return Exit::done;
  write_cameras(options.text("cameras"), {{std::filesystem::path(output).filename(), camera}});
  remark_written(run, options.text("cameras"));
  return Exit::done;
}

}  // namespace

Verb render_verb() {
  OptionTable table("render",
                    "Draw a model, its charts and seams, or two versions of its textures.");
  table.example("scan.obj --overview -o scan.png", "shape, charts, seams and triangles on a sheet");
  table.example("scan.obj --compare sharp.png --at seam -o seam.png", "before and after at the worst seam");
  add_model_options(table);
  table.add({.name = "output",
             .letter = 'o',
             .type = Option::Type::path,
             .required = true,
             .help = "the picture: PNG, JPEG, TIFF, EXR, BMP or TGA"});
  add_render_options(table);
  table.add({.name = "cameras",
             .type = Option::Type::path,
             .group = "Picture",
             .help = "also write the picture's camera, for the verb texture"});
  add_frames_option(table);
  return {table, render};
}

}  // namespace mq::app
