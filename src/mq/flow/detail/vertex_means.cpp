#include "mq/flow/detail/vertex_means.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/fem/flat_triangle.h"

namespace mq {

Signal means_at_vertices(const RefinedTexture& refined, const Signal& signal) {
  const Surface& surface = refined.fine().surface;
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  const double texel = surface.area / double(std::max<Eigen::Index>(1, signal.rows()));
  const Eigen::Index channels = signal.cols();
  // Per corner the sum of weighted values, then of weights.
  Signal parts = Signal::Zero(3 * std::int64_t(surface.triangle_count()), channels + 1);
  parallel_for(surface.triangle_count(), [&](std::int64_t t) {
    const double area = shapes[std::size_t(t)].area();
    const int n = std::clamp(int(std::ceil(std::sqrt(area / texel))), 1, 64);
    const double weight = area > 0 ? area / (n * n) : 1e-12 * texel;
    Signal value(1, channels);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // the n² triangles alike, row by row
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double u = (i + third) / n, v = (j / 2 + third) / n;
        const Vector3 at(1 - u - v, u, v);
        refined.value(signal, {int(t), at}, value.row(0));
        for (int k = 0; k < 3; ++k) {
          parts.row(3 * t + k).head(channels) += weight * at[k] * value.row(0);
          parts(3 * t + k, channels) += weight * at[k];
        }
      }
  });
  const Mesh& mesh = surface.mesh;
  Signal sums = Signal::Zero(mesh.vertex_count(), channels + 1);
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) sums.row(mesh.triangles[t][k]) += parts.row(3 * t + k);
  Signal means = sums.leftCols(channels);
  for (Eigen::Index v = 0; v < means.rows(); ++v)
    if (sums(v, channels) > 0) means.row(v) /= sums(v, channels);
  return means;
}

}  // namespace mq
