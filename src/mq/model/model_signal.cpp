// What both kinds of signal share, and colours at vertices; textures are in texture_signal.cpp.

#include "mq/model/model_signal.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/fem/field_metric.h"
#include "mq/image/colour.h"
#include "mq/mesh/components.h"
#include "mq/model/detail/same_row.h"

namespace mq {

SurfaceScale ModelSignal::scale() const {
  SurfaceScale scale = space().scale();
  if (!(scale.texel_spacing > 0)) scale.texel_spacing = std::sqrt(scale.area / space().size());
  return scale;
}

std::vector<int> ModelSignal::unknowns_at(const Texels::Place&) const { return {}; }

Signal VertexColourSignal::values_of(const VertexSignal& colors) const {
  const Surface& surface = model_.surface;
  Signal sum = Signal::Zero(space_.size(), colors.channels);
  Vector copies = Vector::Zero(space_.size());
  for (int v = 0; v < model_.model.mesh.vertex_count(); ++v) {
    const int unknown = surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0) continue;
    copies[unknown] += 1;
    for (int c = 0; c < colors.channels; ++c) {
      const float value = colors.values[std::size_t(v) * colors.channels + c];
      require(
          std::isfinite(value),
          fmt::format("{}: channel {} of the colour of vertex {} (counted from 0) is {}; it must "
                      "be finite",
                      model_.model.path.string(), c, v, value));
      sum(unknown, c) += value;
    }
  }
  // A vertex split into fans has its source's colour in each; only one of them was counted.
  for (int u = 0; u < space_.size(); ++u) {
    if (copies[u] > 0) {
      sum.row(u) /= copies[u];
      continue;
    }
    const int source = surface.source_from_vertex[std::size_t(u)];
    for (int c = 0; c < colors.channels; ++c)
      sum(u, c) = colors.values[std::size_t(source) * colors.channels + c];
  }
  return sum;
}

void VertexColourSignal::put(const Signal& before, const Signal& after, Model& model) const {
  VertexSignal& colors = model.colors;
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    const int unknown = model_.surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0 || same_row(before, after, unknown)) continue;
    for (int c = 0; c < colors.channels; ++c)
      colors.values[std::size_t(v) * colors.channels + c] = float(after(unknown, c));
  }
}

std::vector<int> components_of(const ModelSignal& signal, const Surface& surface) {
  const std::vector<int> of_triangle = triangle_components(surface);
  const TexelSpace* const texels = signal.texel_space();
  std::vector<int> of_chart(texels ? signal.texel_atlas()->charts.size() : 0), of_vertex(surface.mesh.positions.size(), -1);
  for (std::size_t t = 0; t < of_triangle.size(); ++t) {
    if (const int chart = texels ? signal.texel_atlas()->chart[t] : -1; chart >= 0)
      of_chart[std::size_t(chart)] = of_triangle[t];
    for (const int v : surface.mesh.triangles[t]) of_vertex[std::size_t(v)] = of_triangle[t];
  }
  if (!texels) return of_vertex;
  std::vector<int> components;
  for (const int chart : texels->texels().chart) components.push_back(of_chart[std::size_t(chart)]);
  return components;
}

void VertexColourSignal::replace(const Signal& values, Depth depth, Model& model) const {
  VertexSignal& colors = model.colors;
  colors.channels = int(values.cols());
  colors.depth = depth;
  colors.values.assign(std::size_t(model.mesh.vertex_count()) * colors.channels, 0.0F);
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    const int unknown = model_.surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0) continue;
    for (int c = 0; c < colors.channels; ++c)
      colors.values[std::size_t(v) * colors.channels + c] = float(values(unknown, c));
  }
}

std::unique_ptr<SignalSpace> VertexColourSignal::space_across(std::span<const Vector3> field,
                                                         double kappa, const Progress&) const {
  return std::make_unique<VertexSpace>(model_.surface, shapes_across(model_.surface, field, kappa));
}

Vector VertexColourSignal::brightness() const {
  const VertexSignal& colors = model_.model.colors;
  require(colors.channels > 0, "there are neither textures nor colours at vertices");
  Vector values = Vector::Zero(space_.size());
  for (int v = 0; v < space_.size(); ++v)
    for (int c = 0; c < colour_channels(colors.channels); ++c)
      values[v] +=
          colors.values[std::size_t(model_.surface.source_from_vertex[v]) * colors.channels + c];
  return values;
}

}  // namespace mq
