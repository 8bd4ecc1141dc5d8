// marquetry sample NAME -o OUT: a model that the program makes itself, for trying things out.
//
// The picture is a colour field in space, seen where each texel lies on the surface; so the two
// sides of a seam show the same, unless --misaligned asks for the opposite. With --normals it is a
// normal map instead, of bumps that are a function of the place too.
//
// The name of a body in motion makes a sequence instead: frames with colours at their vertices, and
// beside them the same triangles at rest, which say where every point of a frame came from.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/path_status.h"
#include "mq/io/tiles.h"
#include "mq/sample/bumps.h"
#include "mq/sample/moving.h"
#include "mq/sample/sample.h"
#include "mq/sample/wall.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/frame_numbers.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* wall_name = "wall";

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const SampleInfo& info : sample_names()) all.push_back(info.name);
  all.push_back(wall_name);
  for (const SampleInfo& info : moving_names()) all.push_back(info.name);
  return all;
}

std::string descriptions() {
  std::string text;
  for (const SampleInfo& info : sample_names())
    text += fmt::format("{}{}: {}.", text.empty() ? "" : " ", info.name, info.description);
  text += fmt::format(" {}: tiles of texture side by side, with seams between all of them.", wall_name);
  text += " Sequences:";
  for (const SampleInfo& info : moving_names())
    text += fmt::format(" {}: {}.", info.name, info.description);
  return text;
}

/// The mesh files to write: both formats into a folder, or the one that is named.
std::vector<fs::path> mesh_paths(const std::string& output, const std::string& name) {
  if (names_model(output)) return {output};
  require(output.ends_with('/') || is_folder(output),
          fmt::format("--output: found '{}', wanted a folder (with / at its end) or a model (.obj, "
                      ".ply, ...)",
                      output));
  return {fs::path(output) / (name + ".obj"), fs::path(output) / (name + ".ply")};
}

Alignment alignment(const OptionValues& options) {
  return options.flag("misaligned") ? Alignment::misaligned : Alignment::aligned;
}

Model make_model(const Run& run, const Progress& progress) {
  const OptionValues& options = run.options();
  const auto seed = std::uint64_t(options.integer("seed"));
  const Sample sample = make_sample(options.text("name"),
                                    {.texture_size = int(options.integer("size")),
                                     .triangles = int(options.integer("triangles")),
                                     .seed = seed},
                                    progress.step("model", 0.5));
  Texture texture;
  texture.name = mesh_paths(options.text("output"), sample.name).front().stem().string() +
                 (depth_from_name(options.text("depth")) >= Depth::half ? ".exr" : ".png");
  const Progress painting = progress.step("paint", 0.5);
  texture.pixels = options.flag("normals") ? paint_normals(sample, painting)
                                           : paint(sample, alignment(options), seed, painting);
  texture.format.depth = depth_from_name(options.text("depth"));
  Model model;
  model.mesh = sample.mesh;
  model.textures.push_back(std::move(texture));
  return model;
}

// ---- Bodies in motion ----

bool is_moving(const std::string& name) {
  return std::ranges::any_of(moving_names(),
                             [&](const SampleInfo& info) { return info.name == name; });
}

/// A frame and its material, each with a place for the number.
struct MovingFiles {
  std::string frame, material;
};

MovingFiles moving_files(const std::string& output) {
  if (output.ends_with('/') || is_folder(output))
    return {(fs::path(output) / "frame_%04d.ply").string(),
            (fs::path(output) / "material" / "frame_%04d.ply").string()};
  require(has_frame_place(fs::path(output).filename().string()) && names_model(output),
          fmt::format("--output: found '{}', wanted a folder (with / at its end) or a model with a "
                      "place for the frame's number, such as frame_%04d.ply",
                      output));
  return {output,
          (fs::path(output).parent_path() / "material" / fs::path(output).filename()).string()};
}

Model colored_model(MovingFrame&& made) {
  Model model;
  model.mesh = std::move(made.mesh);
  model.colors.channels = 3;
  for (const Vector3& color : made.colors)
    for (const double c : color) model.colors.values.push_back(float(c));
  return model;
}

Exit sample_sequence(Run& run) {
  const OptionValues& options = run.options();
  for (const char* name : {"size", "misaligned", "normals", "depth"})
    require(!asks_for(options, name),
            fmt::format("--{}: a sequence has colours at its vertices and no texture", name));
  const MovingFiles names = moving_files(options.text("output"));
  const std::vector<int> numbers = parse_frames(options.text("frames"));
  std::vector<fs::path> frames, materials;
  for (const int number : numbers) {
    frames.emplace_back(frame_name(names.frame, number));
    materials.emplace_back(frame_name(names.material, number));
  }
  run.will_write(frames, fs::path(names.frame).parent_path());
  run.will_write(materials, fs::path(names.material).parent_path());
  if (run.dry_run()) return Exit::done;
  const int triangles = int(options.integer("triangles"));
  const MovingOptions how{.period = int(options.integer("period")),
                          .triangles = triangles > 0 ? triangles : MovingOptions().triangles,
                          .seed = std::uint64_t(options.integer("seed")),
                          .light = options.number("light"),
                          .noise = options.number("noise"),
                          .flicker = options.number("flicker"),
                          .capture = {.off = options.number("off"),
                                      .holes = int(options.integer("holes")),
                                      .handles = int(options.integer("handles"))}};
  const Step step(run, "frames", 1);
  Json counts = Json::array();
  for (std::size_t f = 0; f < numbers.size(); ++f) {
    const Progress part =
        step.progress().step(fmt::format("frame {}", numbers[f]), 1 / double(numbers.size()));
    MovingFrame made = make_moving_frame(options.text("name"), numbers[f], how, part);
    counts.push_back(made.mesh.triangle_count());
    Model rest;
    rest.mesh.positions = made.material;
    rest.mesh.triangles = made.mesh.triangles;
    write_model(frames[f], colored_model(std::move(made)));
    write_model(materials[f], rest);
  }
  run.result = {{"frames", numbers.size()}, {"triangles", counts}};
  frames.insert(frames.end(), materials.begin(), materials.end());
  say_written(run, frames);
  return Exit::done;
}

// ---- A wall of tiles ----

/// Its mesh and what names its tiles.
struct WallFiles {
  fs::path mesh;
  TileName tile;
};

WallFiles wall_files(const OptionValues& options) {
  const std::string output = options.text("output");
  require(output.ends_with('/') || is_folder(output) || output.ends_with(".obj"),
          fmt::format("--output: found '{}', wanted a folder (with / at its end) or an .obj: its texture comes in "
                      "tiles",
                      output));
  const fs::path mesh =
      output.ends_with(".obj") ? fs::path(output) : fs::path(output) / (std::string(wall_name) + ".obj");
  const bool is_float = depth_from_name(options.text("depth")) >= Depth::half;
  return {mesh, {.before = mesh.stem().string() + ".", .after = is_float ? ".exr" : ".png", .place = {}}};
}

Model make_wall_model(const OptionValues& options, const WallFiles& files, const Progress& progress) {
  const int triangles = int(options.integer("triangles")), side = int(options.integer("tiles"));
  WallOptions how{.tiles = side,
                  .texture_size = int(options.integer("size")),
                  .seed = std::uint64_t(options.integer("seed"))};
  if (triangles > 0) how.squares = std::max(1, int(std::lround(std::sqrt(triangles / 2.0) / side)));
  Wall wall = make_wall(how);
  const Surface surface = make_surface(wall.mesh);
  const Atlas atlas = make_atlas(surface, wall.textures);
  const ColorField colors = alignment(options) == Alignment::misaligned
                                ? misaligned(wall.colors, {.shift = 2.0 / how.texture_size, .seed = how.seed})
                                : wall.colors;
  Model model;
  for (std::size_t i = 0; i < wall.tiles.size(); ++i) {
    Texture texture;
    texture.name = files.tile.file({wall.tiles[i][0], wall.tiles[i][1]});
    const Progress painting = progress.step(texture.name, 1 / double(wall.tiles.size()));
    texture.pixels = options.flag("normals") ? paint_normals(surface, atlas, {}, PaintOptions{}.margin, int(i), painting)
                                             : paint(surface, atlas, colors, {}, int(i), painting);
    texture.format.depth = depth_from_name(options.text("depth"));
    model.textures.push_back(std::move(texture));
    model.tiles.push_back({0, wall.tiles[i][0], wall.tiles[i][1]});
  }
  model.mesh = std::move(wall.mesh);
  return model;
}

Exit sample_wall(Run& run) {
  const WallFiles names = wall_files(run.options());
  const int side = int(run.options().integer("tiles"));
  std::vector<fs::path> files{names.mesh, fs::path(names.mesh).replace_extension(".mtl")};
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < side; ++u) files.push_back(names.mesh.parent_path() / names.tile.file({u, v}));
  run.will_write(files, names.mesh.parent_path());
  if (run.dry_run()) return Exit::done;
  Model model;
  {
    const Step step(run, "make", 0.8);
    model = make_wall_model(run.options(), names, step);
  }
  const Step step(run, "write", 0.2);
  write_model(names.mesh, model, step);
  run.result = {{"vertices", model.mesh.vertex_count()}, {"triangles", model.mesh.triangle_count()}};
  say_written(run, files);
  return Exit::done;
}

Exit sample(Run& run) {
  const OptionValues& options = run.options();
  const bool is_wall = options.text("name") == wall_name;
  require(is_wall || !asks_for(options, "tiles"),
          fmt::format("--tiles: '{}' has one texture; '{}' comes in tiles", options.text("name"), wall_name));
  require(!options.flag("normals") || !options.flag("misaligned"),
          "--misaligned: photographs differ in colours, and --normals asks for a normal map");
  if (is_moving(options.text("name"))) return sample_sequence(run);
  for (const char* name : {"frames", "period", "light", "noise", "flicker", "off", "holes", "handles"})
    require(!asks_for(options, name),
            fmt::format("--{}: '{}' does not move", name, options.text("name")));
  if (is_wall) return sample_wall(run);
  const std::vector<fs::path> meshes = mesh_paths(options.text("output"), options.text("name"));
  const fs::path folder =
      names_model(options.text("output")) ? fs::path() : fs::path(options.text("output"));
  const bool is_float = depth_from_name(options.text("depth")) >= Depth::half;
  std::vector<fs::path> files = meshes;
  files.push_back(fs::path(meshes.front()).replace_extension(is_float ? ".exr" : ".png"));
  for (const fs::path& mesh : meshes)
    std::ranges::copy(files_beside_made(mesh, 1), std::back_inserter(files));
  run.will_write(files, folder);
  if (run.dry_run()) return Exit::done;

  Model model;
  {
    const Step step(run, "make", 0.8);
    model = make_model(run, step);
  }
  const Step step(run, "write", 0.2);
  for (const fs::path& path : meshes)
    write_model(path, model, step.progress().step(path.filename().string(), 0.5));
  run.result = {{"vertices", model.mesh.vertex_count()},
                {"triangles", model.mesh.triangle_count()}};
  say_written(run, files);
  return Exit::done;
}

void add_sequence_options(OptionTable& table) {
  using Type = Option::Type;
  Option frames = frames_option();
  frames.default_value = "0-99";
  frames.group = "Sequences made";
  frames.help = "which frames of a sequence";
  table.add(frames);
  table.add({.name = "period",
             .type = Type::integer,
             .default_value = as_typed(MovingOptions{}.period),
             .unit = "frames",
             .least = 1,
             .most = 1000000,
             .group = "Sequences made",
             .help = "how long a motion takes; then it begins again"});
  table.add({.name = "light",
             .type = Type::number,
             .default_value = as_typed(MovingOptions{}.light),
             .least = 0,
             .most = 1,
             .group = "Sequences made",
             .help = "how dark a place gets that faces away from a light, which goes around in 16 "
                     "frames"});
  table.add({.name = "noise",
             .type = Type::number,
             .default_value = as_typed(MovingOptions{}.noise),
             .least = 0,
             .most = 1,
             .group = "Sequences made",
             .help = "standard deviation of noise on colours, another in every frame"});
  table.add({.name = "flicker",
             .type = Type::number,
             .default_value = as_typed(MovingOptions{}.flicker),
             .least = 0,
             .most = 1,
             .group = "Sequences made",
             .help = "standard deviation of the logarithm of exposure, another in every frame",
             .details = "A third of its variance is that of the whole, a third that of eight cameras around it, each "
                        "with its own in every channel, a third differs from place to place."});
  table.add({.name = "off",
             .type = Type::number,
             .default_value = as_typed(CheapCapture{}.off),
             .unit = "mean edges",
             .least = 0,
             .most = 1,
             .group = "Sequences as a cheap capture sees them",
             .help = "standard deviation of how far vertices are off, others in every frame",
             .details = "Along the normals, alike within four edges as in depth maps; a quarter of "
                        "that in any direction, each vertex by itself."});
  table.add({.name = "holes",
             .type = Type::integer,
             .default_value = as_typed(CheapCapture{}.holes),
             .least = 0,
             .most = 1000,
             .group = "Sequences as a cheap capture sees them",
             .help = "in each frame, about five edges wide. Each is there for two frames."});
  table.add({.name = "handles",
             .type = Type::integer,
             .default_value = as_typed(CheapCapture{}.handles),
             .least = 0,
             .most = 1000,
             .group = "Sequences as a cheap capture sees them",
             .help = "in each frame at most, six edges wide. Each is there for two frames."});
}

}  // namespace

Verb sample_verb() {
  using Type = Option::Type;
  OptionTable table("sample",
                    "Make a textured model, or a body in motion, to try things out with.");
  table.example("bust -o bust/", "a textured model to try things with");
  table.example("merging -o merging/", "a sequence");
  table.add({.name = "name",
             .place = Option::Place::positional,
             .type = Type::choice,
             .required = true,
             .choices = names(),
             .help = "which model",
             .details = descriptions()});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a folder for OBJ, PLY and picture, or one model file",
             .details = "Of a sequence a folder, or frame_%04d.ply: a file for each frame. What "
                        "lies in the folder material beside them has the same triangles, with "
                        "every vertex where its material is at rest."});
  table.add({.name = "size",
             .type = Type::integer,
             .default_value = as_typed(SampleOptions{}.texture_size),
             .unit = "texels",
             .least = 1,
             .most = 32768,
             .help = "side of the texture"});
  table.add({.name = "tiles",
             .type = Type::integer,
             .default_value = as_typed(WallOptions{}.tiles),
             .least = 1,
             .most = 10,
             .help = "a side of the wall, each of --size texels and a picture (<UDIM>)"});
  table.add({.name = "triangles",
             .type = Type::integer,
             .default_value = as_typed(SampleOptions{}.triangles),
             .least = 0,
             .most = 20000000,
             .help = "about as many are made, 0: the model's own number",
             .details = "Bodies that move have at least 500."});
  table.add({.name = "misaligned",
             .help = "paint each chart as a photograph of its own, so that seams show"});
  table.add({.name = "normals",
             .help = "a normal map in place of colours: bumps, in the model's axes",
             .details = "For --normals and --normal-space object of verbs that process normal maps."});
  table.add({.name = "depth",
             .type = Type::choice,
             .default_value = "8",
             .choices = {"8", "16", "half", "float"},
             .help = "bits per value; half and float write OpenEXR"});
  add_sequence_options(table);
  return {table, sample};
}

}  // namespace mq::app
