#include "verbs/shared/shock_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mq/base/error.h"
#include "mq/draw/false_colour.h"
#include "mq/fem/image_space.h"
#include "mq/io/file_names.h"
#include "mq/io/path_status.h"
#include "mq/io/vector_field.h"
#include "mq/model/field_map.h"
#include "mq/model/model_shock.h"
#include "shell/results.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// A few edges must not leave everything else dark.
constexpr double shown_quantile = 0.99;

/// Colours from 0 to the quantile of values.
FalseColour potential_scale(const Vector& potential) {
  std::vector<double> sorted(potential.begin(), potential.end());
  const auto high = sorted.begin() + std::ptrdiff_t(shown_quantile * double(sorted.size() - 1));
  std::ranges::nth_element(sorted, high);
  const double most = *high > 0 ? *high : potential.maxCoeff();
  return {.low = 0, .high = most > 0 ? most : 1};
}

/// Values at the vertices of the surface, at those of the file; 0 at those that no triangle uses.
Vector at_vertices_of_file(const Surface& surface, const Vector& values) {
  Vector result = Vector::Zero(Eigen::Index(surface.vertex_from_source.size()));
  for (Eigen::Index v = 0; v < result.size(); ++v)
    if (const int own = surface.vertex_from_source[std::size_t(v)]; own >= 0) result[v] = values[own];
  return result;
}

/// Directions, and lengths: as they are in formats of numbers, else as parts of the strongest.
Signal map_of(const TexturedModel& scene, const ModelSignal& signal, ModelField field, Depth depth) {
  const double one = strength_of(scene.surface, field.field);
  if (depth != Depth::f32 && one > 0) field.texels /= one;
  Signal map = field_map(scene, signal, field).values;
  if (depth != Depth::f32) map.col(2) = map.col(2).cwiseMin(1.0);
  return map;
}

}  // namespace

void add_shock_output_options(OptionTable& table) {
  table.add({.name = "write-potential",
             .type = Option::Type::path,
             .metavar = "FILE",
             .group = "Output",
             .help = "the potential that paths run down, P = 1/2 |gradient|^2 smoothed: how strong edges are",
             .details = "Of pictures and textures a picture: numbers in .exr and .tif, colours elsewhere, the "
                        "brightest from the strongest 1 % on. At vertices, and of shapes, a .ply with P as their quality, and in "
                        "colours. P is in squared values over squared length: pixels, or model units."});
  table.add({.name = "write-field",
             .type = Option::Type::path,
             .metavar = "FILE",
             .group = "Output",
             .help = "the field along which paths run, minus the gradient of P, as lic --field takes it",
             .details = "A .ply with vx, vy, vz at its faces or a .vf; of pictures and textures also a picture, a map "
                        "of directions in red and green, and in blue of lengths: as they are in .exr and .tif, elsewhere 1 from the strongest tenth on. In units "
                        "of P over length."});
}

ShockOutputs::ShockOutputs(Run& run, const Model& model, At at, const std::vector<fs::path>& results) {
  const OptionValues& options = run.options();
  const auto named = [&](const char* option) { return options.has(option) ? options.text(option) : std::string(); };
  const std::string potential = named("write-potential"), field = named("write-field");
  for (const char* option : {"write-potential", "write-field"})
    require(named(option).empty() || !run.receiver,
            fmt::format("--{}: it is of one signal, and several slots are worked on: take them one by one", option));
  const auto unfit = [&](const char* option, const std::string& name, const char* wanted) {
    return fmt::format("--{}: found '{}', and {}: wanted {}", option, name,
                       at == At::vertices ? "what is worked on are vertices" : "what is worked on are pictures",
                       wanted);
  };
  if (!potential.empty() && at == At::vertices) {
    require(lower_extension(potential) == ".ply", unfit("write-potential", potential, ".ply"));
    values_ = potential;
  } else if (!potential.empty()) {
    require(names_picture(potential), unfit("write-potential", potential, "a picture"));
    potential_.emplace(potential, model, Outputs::Kind::pictures);
  }
  if (!field.empty()) {
    const bool vectors = names_vector_field(field);
    require(vectors || (at == At::texels && names_picture(field)),
            unfit("write-field", field, at == At::vertices ? ".ply or .vf" : ".ply, .vf or a picture"));
    if (vectors)
      vectors_ = field;
    else
      map_.emplace(field, model, Outputs::Kind::pictures);
  }
  std::vector<fs::path> all;
  std::ranges::transform(results, std::back_inserter(all), full_name);
  for (const fs::path& path : paths()) {
    require(std::ranges::find(all, full_name(path)) == all.end(),
            path.string() + ": would be written twice: give --output, --write-potential and --write-field names of "
                            "their own");
    all.push_back(full_name(path));
  }
  if (const auto files = potential_paths(); !files.empty()) run.will_write(files, {}, "--write-potential");
  if (const auto files = field_paths(); !files.empty()) run.will_write(files, {}, "--write-field");
}

std::vector<fs::path> ShockOutputs::potential_paths() const {
  if (potential_) return potential_->paths();
  return values_.empty() ? std::vector<fs::path>{} : std::vector<fs::path>{values_};
}

std::vector<fs::path> ShockOutputs::field_paths() const {
  if (map_) return map_->paths();
  return vectors_ ? std::vector<fs::path>{*vectors_} : std::vector<fs::path>{};
}

std::vector<fs::path> ShockOutputs::paths() const {
  std::vector<fs::path> all = potential_paths();
  std::ranges::copy(field_paths(), std::back_inserter(all));
  return all;
}

void ShockOutputs::write_potential(Run& run, const TexturedModel& scene, const ModelSignal& signal,
                                   const Vector& potential) const {
  const FalseColour scale = potential_scale(potential);
  run.result["potential"] = {{"largest", potential.maxCoeff()}, {"brightest_from", scale.high}};
  if (potential_) {
    Model pictures = scene.model;
    const bool numbers = holds_numbers(potential_->paths().front());
    signal.replace(numbers ? Signal(potential) : false_colours(potential, scale), numbers ? Depth::f32 : Depth::u8,
                   pictures);
    for (const std::string& note : potential_->write(std::move(pictures), {})) run.terminal().remark(note);
    return;
  }
  const Vector values = at_vertices_of_file(scene.surface, potential);
  std::vector<Colour> colours;
  for (const double value : values) colours.push_back(false_colour(value, scale));
  write_vertex_values(values_, scene.model.mesh, std::span(values.data(), std::size_t(values.size())), colours);
}

void ShockOutputs::write(Run& run, const TexturedModel& scene, const ModelSignal& signal,
                         const Vector& potential) const {
  if (potential_ || !values_.empty()) write_potential(run, scene, signal, potential);
  if (!vectors_ && !map_) return;
  ModelField field = downhill_field(scene, signal, potential);
  if (vectors_) return write_vector_field(*vectors_, scene.model.mesh, field.field);
  Model pictures = scene.model;
  const Depth depth = holds_numbers(map_->paths().front()) ? Depth::f32 : Depth::u16;
  signal.replace(map_of(scene, signal, std::move(field), depth), depth, pictures);
  for (const std::string& note : map_->write(std::move(pictures), {})) run.terminal().remark(note);
}

void ShockOutputs::write(Run& run, const Model& picture, const std::vector<double>& potential) const {
  Model fine = picture;
  const int width = picture.textures.front().pixels.width(), height = picture.textures.front().pixels.height();
  fine.mesh = image_rectangle(width, height, ImageTriangles::per_pixel);
  const TexturedModel scene = textured_again(std::move(fine), {}, run.terminal());
  const TextureSignal signal(scene, {.pictures = TextureSignalOptions::Pictures::replaced}, run.terminal());
  const std::vector<Texels::Place>& places = signal.space().texels().places;
  Vector values(signal.space().size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Texels::Place& at = places[std::size_t(i)];
    values[i] = potential[std::size_t(at.y) * std::size_t(width) + std::size_t(at.x)];
  }
  write(run, scene, signal, values);
}

void ShockOutputs::report(Run& run) const {
  for (const fs::path& path : paths()) {
    remark_written(run, path);
    run.result["outputs"].push_back(path.string());
  }
}

}  // namespace mq::app
