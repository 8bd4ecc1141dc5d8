// marquetry sample NAME -o OUT: a model that the program makes itself, for trying things out.
//
// The picture is a colour field in space, seen where each texel lies on the surface; so the two
// sides of a seam show the same, unless --misaligned asks for the opposite.
#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/sample/sample.h"
#include "outputs.h"
#include "run.h"
#include "scene.h"
#include "verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const SampleInfo& info : sample_names()) all.push_back(info.name);
  return all;
}

std::string descriptions() {
  std::string text;
  for (const SampleInfo& info : sample_names())
    text += fmt::format("{}{}: {}.", text.empty() ? "" : " ", info.name, info.description);
  return text;
}

/// The mesh files to write: both formats into a folder, or the one that is named.
std::vector<fs::path> mesh_paths(const std::string& output, const std::string& name) {
  if (names_model(output)) return {output};
  require(output.ends_with('/') || fs::is_directory(output),
          fmt::format("--output: found '{}', wanted a folder (with / at its end) or a model (.obj, "
                      ".ply, ...)",
                      output));
  return {fs::path(output) / (name + ".obj"), fs::path(output) / (name + ".ply")};
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
  texture.pixels =
      paint(sample, options.flag("misaligned") ? Alignment::misaligned : Alignment::aligned, seed,
            progress.step("paint", 0.5));
  texture.format.depth = depth_from_name(options.text("depth"));
  Model model;
  model.mesh = sample.mesh;
  model.textures.push_back(std::move(texture));
  return model;
}

Exit sample(Run& run) {
  const OptionValues& options = run.options();
  const std::vector<fs::path> meshes = mesh_paths(options.text("output"), options.text("name"));
  const fs::path folder =
      names_model(options.text("output")) ? fs::path() : fs::path(options.text("output"));
  const bool is_float = depth_from_name(options.text("depth")) >= Depth::half;
  std::vector<fs::path> files = meshes;
  files.push_back(fs::path(meshes.front()).replace_extension(is_float ? ".exr" : ".png"));
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

}  // namespace

Verb sample_verb() {
  using Type = Option::Type;
  OptionTable table("sample", "Make a textured model to try things out with.");
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
             .help = "a folder for OBJ, PLY and picture, or one model file"});
  table.add({.name = "size",
             .type = Type::integer,
             .default_value = "1024",
             .unit = "texels",
             .least = 1,
             .most = 32768,
             .help = "side of the texture"});
  table.add({.name = "triangles",
             .type = Type::integer,
             .default_value = "0",
             .least = 0,
             .most = 20000000,
             .help = "about as many are made, 0: the model's own number"});
  table.add({.name = "misaligned",
             .help = "paint each chart as a photograph of its own, so that seams show"});
  table.add({.name = "depth",
             .type = Type::choice,
             .default_value = "8",
             .choices = {"8", "16", "half", "float"},
             .help = "bits per value; half and float write OpenEXR"});
  return {table, sample};
}

}  // namespace mq::app
