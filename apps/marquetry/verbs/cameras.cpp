// marquetry cameras CAMERAS [-o OUT] [--mesh MESH --picture OUT.png]: what a file says of the cameras of
// photographs, the same in another format, and a picture of them around their model.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/draw/camera_lines.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "mq/mesh/geometry.h"
#include "mq/model/model_paints.h"
#include "mq/model/model_picture.h"
#include "mq/model/photographs.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/render_request.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;
using Type = Option::Type;

CameraSet read_set(Run& run) {
  const OptionValues& options = run.options();
  CamerasOptions how{.missing = CamerasOptions::Missing::list, .unreadable = CamerasOptions::Missing::list};
  for (const std::string& folder : options.texts("images")) how.images.emplace_back(folder);
  CameraSet set = read_camera_set(options.text("cameras"), how);
  for (const fs::path& file : set.files) run.will_read(file);
  for (const Photograph& photograph : set.photographs) run.will_read(photograph.picture);
  for (const std::string& note : set.notes) run.terminal().remark(note);
  for (const std::string& doubt : set.doubts) run.terminal().warning(doubt);
  for (const UnusablePhotograph& one : set.unreadable)
    run.terminal().warning(one.why + ": its camera is of unknown size");
  return set;
}

CameraFormat asked_format(const OptionValues& options) {
  static const std::map<std::string, CameraFormat> formats = {
      {"json", CameraFormat::json},
      {"transforms", CameraFormat::transforms},
      {"colmap", CameraFormat::colmap},
      {"colmap-binary", CameraFormat::colmap_binary}};
  const auto found = formats.find(options.text("format"));
  return found == formats.end() ? camera_format_of(options.text("output")) : found->second;
}

Json place_json(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

/// Whose pictures are there, can be read or not, and whose are not.
std::vector<Photograph> all_of(const CameraSet& set) {
  std::vector<Photograph> all = set.photographs;
  for (const UnusablePhotograph& one : set.unreadable) all.push_back(one.photograph);
  all.insert(all.end(), set.missing.begin(), set.missing.end());
  return all;
}

/// Says what was read; `all` are the set's cameras.
void report_set(Run& run, const CameraSet& set, const std::vector<Photograph>& all) {
  std::map<std::string, int> lenses, sizes;
  Mesh places;
  Json missing = Json::array(), unreadable = Json::array();
  for (const Photograph& one : set.missing) missing.push_back(one.picture.string());
  for (const UnusablePhotograph& one : set.unreadable) unreadable.push_back(one.photograph.picture.string());
  for (const auto& [picture, camera] : all) {
    ++lenses[lens_text(camera.lens)];
    ++sizes[camera.width > 0 ? fmt::format("{} × {}", camera.width, camera.height) : "not known"];
    places.positions.push_back(camera.center());
  }
  const int last = places.vertex_count() - 1;
  for (int v = 0; v <= last; ++v) places.triangles.push_back({v, v, v});
  const Box box = bounding_box(places);
  run.result = {{"format", set.format},
                {"views", all.size()},
                {"found", set.photographs.size()},
                {"missing", missing},
                {"unreadable", unreadable},
                {"without_pose", set.without_pose},
                {"lenses", lenses},
                {"sizes", sizes},
                {"extent", {{"low", place_json(box.low)}, {"high", place_json(box.high)}}}};
  const auto row = [](const std::string& name, const std::string& value) {
    return fmt::format("  {:<18}{}\n", name, value);
  };
  const auto counts = [](const std::map<std::string, int>& words) {
    std::vector<std::string> texts;
    for (const auto& [word, count] : words) texts.push_back(fmt::format("{} ({})", word, count));
    return fmt::format("{}", fmt::join(texts, "; "));
  };
  const Vector3 size = box.high - box.low;
  run.print(
      run.options().text("cameras") + "\n" + row("format", set.format) +
      row("views", fmt::format("{}, of which {} without a picture; {} more without a pose", all.size(),
                               set.missing.size(), set.without_pose)) +
      row("lenses", counts(lenses)) + row("pictures", counts(sizes)) +
      row("stand in", fmt::format("{:.6g} × {:.6g} × {:.6g}, from ({:.6g}, {:.6g}, {:.6g})", size.x(), size.y(),
                                  size.z(), box.low.x(), box.low.y(), box.low.z())));
}

void warn_of_missing(Run& run, const CameraSet& set) {
  constexpr std::size_t most_named = 5;
  if (set.missing.empty()) return;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < std::min(most_named, set.missing.size()); ++k)
    names.push_back(set.missing[k].picture.string());
  if (set.missing.size() > most_named) names.emplace_back("...");
  run.terminal().warning(fmt::format("{}: {} not there: {}: give their folder by --images",
                                     run.options().text("cameras"),
                                     set.missing.size() == 1
                                         ? "1 picture is"
                                         : fmt::format("{} pictures are", set.missing.size()),
                                     fmt::join(names, ", ")));
}

/// Those that a format can say: of known size.
void write_set(Run& run, std::vector<Photograph> cameras, CameraFormat format) {
  const fs::path output = run.options().text("output");
  const auto unknown = [](const Photograph& one) { return one.camera.width == 0; };
  const auto left_out = std::erase_if(cameras, unknown);
  require(!cameras.empty(), "--output: no picture is there, and the file does not say their sizes: give "
                            "their folder by --images");
  if (left_out > 0)
    run.terminal().warning(fmt::format("{} left out: the size of their pictures is not known",
                                       counted(std::int64_t(left_out), "camera")));
  write_cameras(output, named_for(output, format, std::move(cameras)), format);
  remark_written(run, output);
}

/// How many triangles are in the pictures of how many views.
void report_seen(Run& run, const TexturedModel& scene, const std::vector<PinholeCamera>& cameras) {
  const std::vector<int> views = views_of_triangles(scene.surface.mesh, cameras);
  const auto share = [&](int least) {
    const auto count = std::ranges::count_if(views, [=](int n) { return n >= least; });
    return double(count) / double(std::max<std::size_t>(1, views.size()));
  };
  run.result["triangles"] = {{"count", views.size()}, {"in_a_view", share(1)}, {"in_three_views", share(3)}};
  run.print(fmt::format("  {:<18}{:.1f} % of {} lie in a view, {:.1f} % in three or more\n", "triangles",
                        100 * share(1), views.size(), 100 * share(3)));
  const bool exchanged = axes_seem_exchanged(scene.surface.mesh, cameras);
  if (share(1) == 0 || exchanged)
    run.terminal().warning(fmt::format("{}: {} view has {} of it in its picture: {}", scene.model.path.string(),
                                       share(1) == 0 ? "no" : "hardly a", share(1) == 0 ? "any" : "most",
                                       exchanged ? exchanged_axes_hint
                                                 : "are mesh and cameras of the same coordinates?"));
}

void draw_set(Run& run, const TexturedModel& scene, const std::vector<PinholeCamera>& cameras) {
  constexpr double share = 0.06;  // of the diagonal of all that is drawn: a frustum's length
  const OptionValues& options = run.options();
  const auto size = *parse_size(options.text("size"));
  ModelPictureOptions wanted;
  wanted.render.view = parse_view(options.text("view"));
  wanted.render.view.up = asked_up(options);
  wanted.render.width = size[0], wanted.render.height = size[1];
  wanted.render.paint = best_paint(scene);
  Box box = bounding_box(scene.surface.mesh);
  for (const PinholeCamera& camera : cameras) {
    box.low = box.low.cwiseMin(camera.center());
    box.high = box.high.cwiseMax(camera.center());
  }
  wanted.render.lines = lines_of_cameras(cameras, share * box.diagonal());
  const std::string picture = options.text("picture");
  const Step step(run, "draw", 0.5);
  const Image<float> drawn = ModelRenderer(scene).draw(wanted, {}, step);
  for (const std::string& note : write_image(picture, drawn)) run.terminal().remark(note);
  remark_written(run, picture);
}

Exit cameras(Run& run) {
  const OptionValues& options = run.options();
  require_picture_name(options, "picture");
  for (const char* name : {"picture", "view", "up", "size"})
    require(options.has("mesh") || !asks_for(options, name),
            fmt::format("--{}: it is for a picture of the cameras around their model, which --mesh names", name));
  require(options.has("picture") || !(asks_for(options, "view") || asks_for(options, "up") || asks_for(options, "size")),
          "--view, --up and --size are of --picture: give it too");
  require(options.has("output") || !asks_for(options, "format"), "--format: it is that of --output: give it too");
  const CameraSet set = read_set(run);
  std::vector<fs::path> files;
  fs::path folder;
  std::optional<CameraFormat> format;
  if (options.has("output")) {
    format = asked_format(options);
    files = camera_files(options.text("output"), *format);
    if (files.size() > 1) folder = options.text("output");
  }
  if (options.has("picture")) files.emplace_back(options.text("picture"));
  run.will_write(files, folder);
  std::optional<TexturedModel> scene;
  if (options.has("mesh")) {
    const Step step(run, "read", 0.4);
    scene = load_textured_model(options.text("mesh"), {.missing = MissingPictures::assume}, run.terminal(), step);
    will_read_model(run, scene->model);
  }
  const std::vector<Photograph> all = all_of(set);
  report_set(run, set, all);
  warn_of_missing(run, set);
  std::vector<PinholeCamera> known;
  for (const Photograph& one : all)
    if (one.camera.width > 0) known.push_back(one.camera);
  if (scene) report_seen(run, *scene, known);
  if (run.dry_run()) return Exit::done;
  if (format) write_set(run, all, *format);
  if (options.has("picture")) draw_set(run, *scene, known);
  return Exit::done;
}

}  // namespace

Verb cameras_verb() {
  OptionTable table("cameras", "Say what cameras of photographs a file holds, convert and draw them.");
  table.example("sparse/ -o cameras.json", "COLMAP's model as one file");
  table.example("scan.xml --images photos/ --mesh scan.ply --picture cameras.png",
                "Metashape's cameras around the mesh");
  table.add({.name = "cameras",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .metavar = "CAMERAS",
             .help = "COLMAP's folder, transforms.json, Bundler's .out, Metashape's .xml, a folder with "
                     "RealityCapture's .xmp, glTF, OpenMVS' .mvs, or JSON"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .metavar = "OUT",
             .help = "the same cameras: .json, transforms.json, or a folder for COLMAP's"});
  table.add({.name = "format",
             .type = Type::choice,
             .default_value = "auto",
             .choices = {"auto", "json", "transforms", "colmap", "colmap-binary"},
             .group = "Cameras",
             .help = "of --output; auto: as its name says"});
  table.add({.name = "images",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Cameras",
             .help = "folders with the photographs, where they are not near the cameras"});
  table.add({.name = "mesh",
             .type = Type::path,
             .group = "Picture",
             .help = "the model they show: what of it lies in views is counted"});
  table.add({.name = "picture",
             .type = Type::path,
             .group = "Picture",
             .help = "draw the model with the cameras, their frusta and directions, as PNG"});
  add_view_option(table, "Picture");
  add_up_option(table, "Picture");
  table.add({.name = "size",
             .type = Type::text,
             .default_value = as_typed(RenderOptions{}.width),
             .accepts = [](const std::string& text) { return parse_size(text).has_value(); },
             .wanted = "pixels, such as 1024 or 1920x1080, 1 to 16384 a side",
             .metavar = "N|WxH",
             .group = "Picture",
             .help = "pixels of the picture"});
  return {table, cameras};
}

}  // namespace mq::app
