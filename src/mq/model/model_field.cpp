#include "mq/model/model_field.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/fem/smoothest_field.h"
#include "mq/filter/screened_poisson.h"
#include "mq/io/field_strokes.h"
#include "mq/io/image_file.h"
#include "mq/io/vector_field.h"
#include "mq/mesh/geometry.h"
#include "mq/model/field_map.h"
#include "mq/model/stroke_wishes.h"

namespace mq {
namespace {

ModelField harmonic(const TexturedModel& model, int number, const Progress& progress) {
  std::vector<TangentField> fields = harmonic_fields(model.surface, progress);
  require(!fields.empty(),
          "a harmonic field: a surface without handles has none, and neither has one with a single "
          "boundary");
  require(number >= 1 && number <= std::ssize(fields),
          fmt::format("harmonic field {}: there are {}", number,
                      counted(std::ssize(fields), "harmonic field")));
  return {std::move(fields[std::size_t(number - 1)]), {}, int(fields.size())};
}

constexpr double rounding = 1e-6;

/// ∇ψ, 0 in triangles where ψ varies by no more than what it is rounded to.
TangentField gradient(const Surface& surface, const Vector& psi) {
  TangentField field = gradient_field(surface, psi);
  const double least = rounding * psi.cwiseAbs().maxCoeff();
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Triangle& v = surface.mesh.triangles[t];
    const auto [low, high] = std::minmax({psi[v[0]], psi[v[1]], psi[v[2]]});
    if (!(high - low > least)) field[t].setZero();
  }
  return field;
}

/// Per texel, where there are some: of brightness that is smoothed over `usual_gradient_smoothing`, 0 where it changes by less
/// from one texel to the next than a quarter of a step of 8 bits.
ModelField gradient_of_colours(const TexturedModel& model, const ModelSignal& signal, const Progress& progress) {
  if (!signal.texel_space()) return {gradient(model.surface, signal.brightness()), {}, {}};
  const TexelVectorSpace vectors(model.surface, *signal.texel_atlas(), *signal.texel_space());
  const TexelSpace& space = *signal.texel_space();
  const double texel = signal.scale().texel_spacing;
  const Signal psi = signal.brightness();
  Vector z = vectors.gradient(
      smooth(space, psi, usual_gradient_smoothing, space.solver({.tolerance = 1e-6}), progress).signal);
  const double least = 0.25 / 255 * psi.cwiseAbs().maxCoeff() / texel;
  for (Eigen::Index i = 0; i < z.size(); i += 2)
    if (!(z.segment<2>(i).norm() > least)) z.segment<2>(i).setZero();
  TangentField field = vectors.on_triangles(z);
  return {std::move(field), std::move(z), {}};
}

TangentField from_file(const TexturedModel& model, const std::filesystem::path& file) {
  VectorField field = read_vector_field(file, model.model.mesh);
  const Surface& surface = model.surface;
  if (field.at == VectorField::At::triangles) {
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 n = triangle_normal(surface.mesh, t);
      field.vectors[t] =
          n.isZero() ? Vector3::Zero() : Vector3(field.vectors[t] - n.dot(field.vectors[t]) * n);
    }
    return std::move(field.vectors);
  }
  std::vector<Vector3> vertices;
  for (const int source : surface.source_from_vertex)
    vertices.push_back(field.vectors[std::size_t(source)]);
  return field_from_vertices(surface, vertices);
}

ModelField along_strokes(const TexturedModel& model, const ModelSignal& signal, const std::filesystem::path& file,
                         const Progress& progress) {
  const std::vector<FieldStroke> strokes = read_field_strokes(file);
  const std::vector<WishedVector> wishes =
      stroke_wishes(model, signal.texel_atlas(), strokes, signal.scale().texel_spacing / 2);
  const auto require_some = [&](const TangentField& field) {
    double longest = 0, strongest = 0;
    for (const Vector3& vector : field) longest = std::max(longest, vector.norm());
    for (const FieldStroke& stroke : strokes) strongest = std::max(strongest, stroke.strength);
    require(longest > rounding * strongest,
            file.string() + ": its strokes cancel each other, so that the smoothest field along them is 0 everywhere: "
                            "leave out those that run against others in the same place");
  };
  if (!signal.texel_space()) {
    TangentField field = smoothest_field(model.surface, wishes, {}, progress);
    require_some(field);
    return {std::move(field), {}, {}};
  }
  const TexelVectorSpace vectors(model.surface, *signal.texel_atlas(), *signal.texel_space());
  SmoothestTexels found = smoothest_field(vectors, wishes, {}, progress);
  require(found.report.converged, "the smoothest field along the strokes was not found: multigrid stopped at a "
                                  "residual above its tolerance; at vertices a factorisation finds one");
  TangentField field = vectors.on_triangles(found.field);
  require_some(field);
  return {std::move(field), std::move(found.field), {}};
}

/// Each vector by `one`, or by its length where that is more; what has hardly any stays.
void scale_texels(Vector& texels, double one) {
  for (Eigen::Index i = 0; i < texels.size(); i += 2)
    if (const double length = std::max(one, texels.segment<2>(i).norm()); length > 1e-12) texels.segment<2>(i) /= length;
}

ModelField unscaled(const TexturedModel& model, const ModelSignal& signal,
                    const FieldRequest& request, const Progress& progress) {
  using Kind = FieldRequest::Kind;
  switch (request.kind) {
    case Kind::max_curvature:
      return {curvature_field(model.surface, Principal::max, 2, progress), {}, {}};
    case Kind::min_curvature:
      return {curvature_field(model.surface, Principal::min, 2, progress), {}, {}};
    case Kind::harmonic: return harmonic(model, request.number, progress);
    case Kind::gradient: return gradient_of_colours(model, signal, progress);
    case Kind::file: return {from_file(model, request.file), {}, {}};
    case Kind::map: return field_of_map(model, signal, request.file);
    case Kind::strokes: return along_strokes(model, signal, request.file, progress);
  }
  return {};
}

}  // namespace

void check_field(const TexturedModel& model, const FieldRequest& request) {
  if (request.kind == FieldRequest::Kind::file) read_vector_field(request.file, model.model.mesh);
  if (request.kind == FieldRequest::Kind::strokes) read_field_strokes(request.file);
  if (request.kind == FieldRequest::Kind::map)
    for (const std::filesystem::path& file : map_files(model, request.file)) picture_info(file);
}

ModelField model_field(const TexturedModel& model, const ModelSignal& signal,
                       const FieldRequest& request, const Progress& progress) {
  using Strength = FieldRequest::Strength;
  const Surface& surface = model.surface;
  ModelField found = unscaled(model, signal, request, progress);
  TangentField& field = found.field;
  if (request.turn == FieldRequest::Turn::quarter) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      field[t] = triangle_normal(surface.mesh, t).cross(field[t]);
    for (Eigen::Index i = 0; i < found.texels.size(); i += 2)
      found.texels.segment<2>(i) = turned(Vector2(found.texels.segment<2>(i)));
  }
  require(std::ranges::any_of(field, [](const Vector3& v) { return !v.isZero(0); }),
          "the field is 0 everywhere: choose another");
  switch (request.strength) {
    case Strength::kept: break;
    case Strength::unit:
      field = normalised(surface, std::move(field));
      scale_texels(found.texels, 0);
      break;
    case Strength::scaled:
      scale_texels(found.texels, strength_of(surface, field));
      field = scaled_to_one(surface, std::move(field));
  }
  return found;
}

}  // namespace mq
