#include "mq/io/vertex_colours.h"

#include <algorithm>
#include <array>

#include "mq/image/resample.h"

namespace mq {
namespace {

constexpr int channels = 3;

/// Of a pixel's values the colour; what follows grey or colour is alpha.
Eigen::RowVector3d colour_of(std::span<const float> values) {
  Eigen::RowVector3d colour;
  for (int c = 0; c < channels; ++c) colour[c] = values[values.size() < 3 ? 0 : std::size_t(c)];
  return colour;
}

}  // namespace

Signal vertex_colours(const Model& model) {
  const Mesh& mesh = model.mesh;
  Signal sums = Signal::Zero(mesh.vertex_count(), channels);
  Vector counts = Vector::Zero(mesh.vertex_count());
  if (const int stored = model.colors.channels; stored > 0) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
      sums.row(v) = colour_of(
          std::span(model.colors.values).subspan(std::size_t(v) * stored, std::size_t(stored)));
    return sums;
  }
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int texture = shown_texture(model, t);
    if (texture < 0) continue;
    const Image<float>& pixels = model.textures[std::size_t(texture)].pixels;
    std::vector<float> values(std::size_t(pixels.channels()));
    for (int k = 0; k < 3; ++k) {
      const Vector2& uv = mesh.uv(t, k);
      sample(pixels, uv.x() * pixels.width() - 0.5, (1 - uv.y()) * pixels.height() - 0.5,
             model.textures[texture].wrap, values);
      sums.row(mesh.triangles[t][k]) += colour_of(values);
      counts[mesh.triangles[t][k]] += 1;
    }
  }
  if (!(counts.maxCoeff() > 0)) return Signal(mesh.vertex_count(), 0);
  const Eigen::RowVector3d mean = sums.colwise().sum() / counts.sum();
  for (int v = 0; v < mesh.vertex_count(); ++v)
    sums.row(v) = counts[v] > 0 ? Eigen::RowVector3d(sums.row(v) / counts[v]) : mean;
  return sums;
}

int shown_texture(const Model& model, int triangle) {
  const int texture = model.mesh.texture(triangle);
  const bool is_there = model.mesh.textured(triangle) && texture >= 0 &&
                        texture < std::ssize(model.textures) &&
                        !model.textures[std::size_t(texture)].pixels.empty();
  return is_there ? texture : -1;
}

bool has_colours(const Model& model) {
  if (model.colors.channels > 0) return true;
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    if (shown_texture(model, t) >= 0) return true;
  return false;
}

ColourAt surface_colours(const Model& model) {
  return [&model](const ClosestPoint& point) {
    const Mesh& mesh = model.mesh;
    const int t = point.triangle;
    Eigen::RowVector3d colour = Eigen::RowVector3d::Constant(0.5);
    if (const int stored = model.colors.channels; stored > 0) {
      colour.setZero();
      for (int k = 0; k < 3; ++k)
        colour += point.barycentric[k] *
                  colour_of(std::span(model.colors.values)
                                .subspan(std::size_t(mesh.triangles[t][k]) * stored,
                                         std::size_t(stored)));
    } else if (const int texture = shown_texture(model, t); texture >= 0) {
      Vector2 uv = Vector2::Zero();
      for (int k = 0; k < 3; ++k) uv += point.barycentric[k] * mesh.uv(t, k);
      const Image<float>& pixels = model.textures[std::size_t(texture)].pixels;
      std::array<float, 16> values{};
      sample(pixels, uv.x() * pixels.width() - 0.5, (1 - uv.y()) * pixels.height() - 0.5,
             model.textures[std::size_t(texture)].wrap,
             std::span(values).first(std::size_t(pixels.channels())));
      colour = colour_of(std::span(values).first(std::size_t(pixels.channels())));
    }
    return std::array{float(colour[0]), float(colour[1]), float(colour[2])};
  };
}

}  // namespace mq
