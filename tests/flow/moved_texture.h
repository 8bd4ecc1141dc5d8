#pragma once
/// Textures, and the same moved along the surface.

#include "fem/cut_squares.h"
#include "flow/moved_signals.h"
#include "mq/flow/texture_flow.h"
#include "mq/trace/atlas_flow.h"

namespace mq::fixtures {

/// Three channels of smooth noise at the texels, moved along.
struct MovedTexture {
  MovedTexture(const Mesh& mesh, const TextureSize& size, double waves, const Motion& back)
      : model(textured(mesh, {size})), space(model->surface, model->atlas) {
    for (Signal* signal : {&source, &target}) {
      signal->resize(space.size(), 3);
      for (int i = 0; i < space.size(); ++i) {
        const Vector3 place = space.texels().position(i);
        signal->row(i) = colour_at(waves * (signal == &source ? place : back(place)));
      }
    }
  }

  /// Mean distance, in texels, of the ends of paths to where their texels truly go.
  double end_point_error(const Vector& field, const Motion& truth) const {
    const TraceAtlas domain(model->surface, model->atlas, space);
    const TexelVectorSpace vectors(model->surface, model->atlas, space);
    const std::vector<ChartPlace> starts = domain.starts().places;
    const auto ends = AtlasFlow::along(domain, vectors.velocities(field)).trace(starts, 1).ends;
    double sum = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
      sum += (domain.position(ends[i]) - truth(domain.position(starts[i]))).norm();
    return sum / double(ends.size()) / space.scale().texel_spacing;
  }

  std::unique_ptr<Textured> model;
  TexelSpace space;
  Signal source, target;
};

inline MeshFlowOptions up_to(double texels) {
  MeshFlowOptions options;
  options.largest = {2 * texels, Length::Unit::texels};
  options.detail = {};
  return options;
}

}  // namespace mq::fixtures
