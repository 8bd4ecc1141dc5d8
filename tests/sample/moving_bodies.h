#pragma once
/// Bodies in motion, as tests of tracking take them.

#include <string>
#include <vector>

#include "mq/linear/matrix.h"
#include "mq/sample/moving.h"

namespace mq {

/// Its frames from `first` to `last`.
inline std::vector<MovingFrame> moving_sequence(const std::string& name, int first, int last,
                                                const MovingOptions& options) {
  std::vector<MovingFrame> frames;
  for (int f = first; f <= last; ++f) frames.push_back(make_moving_frame(name, f, options));
  return frames;
}

/// A row per vertex.
inline Signal colours_of(const MovingFrame& frame) {
  Signal colours(frame.mesh.vertex_count(), 3);
  for (int v = 0; v < frame.mesh.vertex_count(); ++v) colours.row(v) = frame.colors[v].transpose();
  return colours;
}

/// The triangles of a frame where their material is at rest.
inline Mesh material_of(const MovingFrame& frame) {
  Mesh mesh = frame.mesh;
  mesh.positions = frame.material;
  return mesh;
}

}  // namespace mq
