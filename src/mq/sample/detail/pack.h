#pragma once
/// Placing flat charts beside each other in a texture.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

struct SamplePackOptions {
  int texture_size = 1024;  ///< texels a side
  double gutter = 4;        ///< texels between charts, and half of it to the border
};

/// Turns each chart to its smallest upright box, scales all by the same factor, the largest found
/// for which they fit, and moves them into [0, 1]². A gutter that leaves too little room for the
/// charts themselves is halved, until all gutters take less than a quarter of the texture.
/// `mesh.uvs` come in the surface's scale; `charts` says the chart of each triangle, and no chart
/// shares a texture coordinate with another.
void pack(Mesh& mesh, const std::vector<int>& charts, const SamplePackOptions& options = {});

}  // namespace mq
