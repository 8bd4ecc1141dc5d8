#pragma once
/// A torus without curvature, which no mesh in space has: its triangles are given by shape alone.

#include <cmath>
#include <numbers>
#include <vector>

#include "fixtures.h"
#include "mq/fem/flat_triangle.h"
#include "mq/mesh/surface.h"

namespace mq::test {

/// The square [0, 2π]² with opposite sides joined, n × n cells of two triangles. Its Laplacian has
/// the eigenvalues k² + l². Vertices move by up to `jitter` of a cell.
struct FlatTorus {
  Surface surface;  ///< its positions are those of a torus in space and mean nothing
  std::vector<FlatTriangle> shapes;
  std::vector<Vector2> positions;  ///< in the square, some a little outside by jitter

  /// A signal given as a function on the square, of period 2π in both directions.
  template <class Function>
  Eigen::VectorXd sample(const Function& f) const {
    Eigen::VectorXd values(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) values[i] = f(positions[i].x(), positions[i].y());
    return values;
  }
};

inline FlatTorus flat_torus(int n, double jitter = 0, std::uint64_t seed = 1) {
  FlatTorus torus{make_surface(fixtures::torus(n, n)), {}, {}};
  const double side = 2 * std::numbers::pi;
  const Random random(seed);
  for (int v = 0; v < n * n; ++v)
    torus.positions.push_back(Vector2(v % n + random.uniform(2 * v, -jitter, jitter),
                                      v / n + random.uniform(2 * v + 1, -jitter, jitter)) * side / n);
  const auto step = [&](int from, int to) {
    const Vector2 d = torus.positions[to] - torus.positions[from];
    return Vector3(std::remainder(d.x(), side), std::remainder(d.y(), side), 0);
  };
  for (const Triangle& t : torus.surface.mesh.triangles)
    torus.shapes.push_back(flat_triangle(step(t[0], t[1]), step(t[0], t[2])));
  return torus;
}

}  // namespace mq::test
