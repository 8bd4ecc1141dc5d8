#pragma once
/// What tests of filtered shapes share.

#include <algorithm>
#include <vector>

#include "fixtures.h"
#include "mq/mesh/surface.h"

namespace mq::fixtures {

/// By how much the vertex that moved furthest did.
inline double largest_distance(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, (a[v] - b[v]).norm());
  return largest;
}

/// A torus of n × n/2 cells with noise of up to `share` of 1/n: nothing symmetric about it.
inline Mesh bumpy_torus(int n = 30, double share = 0.3) {
  Mesh mesh = torus(n, n / 2);
  const Random random(5);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    for (int k = 0; k < 3; ++k)
      mesh.positions[v][k] += random.uniform(3 * v + std::uint64_t(k), -share, share) / n;
  return mesh;
}

}  // namespace mq::fixtures
