#pragma once
/// What several sources of the room sum and compare by.

#include <algorithm>
#include <vector>

#include "mq/mesh/geometry.h"

namespace mq {

/// Of values, the larger of both where two are in the middle; 0 where there are none.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Per vertex a third of the area of its triangles, lumped, of sum 1.
inline std::vector<double> area_shares(const Mesh& mesh) {
  std::vector<double> shares(mesh.positions.size(), 0);
  double total = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const double area = triangle_area(mesh, t);
    total += area;
    for (const int v : mesh.triangles[t]) shares[v] += area / 3;
  }
  for (double& share : shares) share /= total;
  return shares;
}

}  // namespace mq
