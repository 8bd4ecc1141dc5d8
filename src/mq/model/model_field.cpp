#include "mq/model/model_field.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/vector_field.h"
#include "mq/mesh/geometry.h"

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
  return {std::move(fields[std::size_t(number - 1)]), int(fields.size())};
}

/// ∇ψ, 0 in triangles where ψ varies by no more than what it is rounded to.
TangentField gradient(const Surface& surface, const Vector& psi) {
  constexpr double rounding = 1e-6;
  TangentField field = gradient_field(surface, psi);
  const double least = rounding * psi.cwiseAbs().maxCoeff();
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Triangle& v = surface.mesh.triangles[t];
    const auto [low, high] = std::minmax({psi[v[0]], psi[v[1]], psi[v[2]]});
    if (!(high - low > least)) field[t].setZero();
  }
  return field;
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

ModelField unscaled(const TexturedModel& model, const ModelSignal& signal,
                    const FieldRequest& request, const Progress& progress) {
  using Kind = FieldRequest::Kind;
  switch (request.kind) {
    case Kind::max_curvature:
      return {curvature_field(model.surface, Principal::max, 2, progress), {}};
    case Kind::min_curvature:
      return {curvature_field(model.surface, Principal::min, 2, progress), {}};
    case Kind::harmonic: return harmonic(model, request.number, progress);
    case Kind::gradient: return {gradient(model.surface, signal.brightness()), {}};
    case Kind::file: return {from_file(model, request.file), {}};
  }
  return {};
}

}  // namespace

void check_field(const TexturedModel& model, const FieldRequest& request) {
  if (request.kind == FieldRequest::Kind::file) read_vector_field(request.file, model.model.mesh);
}

ModelField model_field(const TexturedModel& model, const ModelSignal& signal,
                       const FieldRequest& request, const Progress& progress) {
  const Surface& surface = model.surface;
  ModelField found = unscaled(model, signal, request, progress);
  TangentField& field = found.field;
  if (request.turn == FieldRequest::Turn::quarter)
    for (int t = 0; t < surface.triangle_count(); ++t)
      field[t] = triangle_normal(surface.mesh, t).cross(field[t]);
  require(std::ranges::any_of(field, [](const Vector3& v) { return !v.isZero(0); }),
          "the field is 0 everywhere: choose another");
  field = request.strength == FieldRequest::Strength::unit
              ? normalised(surface, std::move(field))
              : scaled_to_one(surface, std::move(field));
  return found;
}

}  // namespace mq
