#include "mq/io/vertex_colours.h"

#include <algorithm>
#include <array>

#include "mq/image/colour.h"
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

/// `to` of the values that are no alpha.
VertexSignal mapped(VertexSignal colors, double (*to)(double)) {
  const int own = colour_channels(colors.channels);
  for (std::size_t i = 0; i < colors.values.size(); ++i)
    if (int(i % std::size_t(colors.channels)) < own) colors.values[i] = float(to(double(colors.values[i])));
  return colors;
}

}  // namespace

std::array<float, 3> displayed_colour(const VertexSignal& colors, int vertex) {
  const auto stored = std::size_t(colors.channels);
  const Eigen::RowVector3d colour =
      colour_of(std::span(colors.values).subspan(std::size_t(vertex) * stored, stored));
  std::array<float, 3> shown;
  for (int c = 0; c < channels; ++c)
    shown[std::size_t(c)] = colors.is_light ? float(srgb_from_linear(colour[c])) : float(colour[c]);
  return shown;
}

VertexSignal as_light(VertexSignal colors) {
  if (colors.is_light || colors.channels == 0) return colors;
  colors = mapped(std::move(colors), linear_from_srgb);
  if (colors.depth == Depth::u8) colors.depth = Depth::u16;
  colors.is_light = true;
  return colors;
}

VertexSignal as_displayed(VertexSignal colors) {
  if (!colors.is_light || colors.channels == 0) return colors;
  colors = mapped(std::move(colors), srgb_from_linear);
  colors.is_light = false;
  return colors;
}

Signal vertex_colours(const Model& model) {
  const Mesh& mesh = model.mesh;
  Signal sums = Signal::Zero(mesh.vertex_count(), channels);
  Vector counts = Vector::Zero(mesh.vertex_count());
  if (model.colors.channels > 0) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
      for (int c = 0; c < channels; ++c) sums(v, c) = displayed_colour(model.colors, v)[std::size_t(c)];
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
    if (model.colors.channels > 0) {
      colour.setZero();
      for (int k = 0; k < 3; ++k) {
        const std::array<float, 3> at_corner = displayed_colour(model.colors, mesh.triangles[t][k]);
        for (int c = 0; c < channels; ++c) colour[c] += point.barycentric[k] * double(at_corner[std::size_t(c)]);
      }
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
