#pragma once
/// Closed surfaces of any genus, and the operators of the Whitney basis on a surface.

#include <map>

#include "mq/fem/exterior.h"
#include "mq/fem/vector_basis.h"
#include "mq/mesh/surface.h"

namespace mq::test {

/// The boundary of a slab of cubes, (2·genus + 1) × 3 × 1 in size, with `genus` holes through it;
/// each cube face is n × n cells of two triangles.
inline Mesh handlebody(int genus, int n) {
  const auto solid = [&](int x, int y, int z) {
    const auto in = [](int i, int size) { return i >= 0 && i < size; };
    return in(x, (2 * genus + 1) * n) && in(y, 3 * n) && in(z, n) &&
           !((x / n) % 2 == 1 && y / n == 1);
  };
  Mesh mesh;
  std::map<std::array<int, 3>, int> ids;
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [it, fresh] = ids.try_emplace(p, mesh.vertex_count());
    if (fresh) mesh.positions.push_back(Vector3(p[0], p[1], p[2]) / n);
    return it->second;
  };
  for (int x = 0; x < (2 * genus + 1) * n; ++x)
    for (int y = 0; y < 3 * n; ++y)
      for (int z = 0; z < n; ++z)
        for (int axis = 0; axis < 3 && solid(x, y, z); ++axis)
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> across{x, y, z}, corner{x, y, z};
            across[axis] += side == 1 ? 1 : -1;
            if (solid(across[0], across[1], across[2])) continue;
            corner[axis] += side;
            const int u = (axis + 1 + (side == 0)) % 3, v = (axis + 1 + (side == 1)) % 3;
            std::array<int, 3> a = corner, b = corner, c = corner, d = corner;
            b[u] += 1, c[u] += 1, c[v] += 1, d[v] += 1;
            mesh.triangles.push_back({vertex(a), vertex(b), vertex(c)});
            mesh.triangles.push_back({vertex(a), vertex(c), vertex(d)});
          }
  return mesh;
}

/// Everything on 1-forms that a spectrum needs.
struct WhitneyOperators {
  Edges edges;
  HodgeStars stars;
  SparseMatrix laplacian, mass;
};

inline WhitneyOperators whitney_operators(const Surface& surface,
                                          const std::vector<FlatTriangle>& shapes) {
  WhitneyOperators w;
  w.edges = make_edges(surface, shapes);
  w.stars = hodge_stars(w.edges, surface.mesh.triangles, shapes, surface.mesh.vertex_count());
  w.laplacian = hodge_laplacian(w.edges, w.stars, diagonal_matrix(w.stars.one));
  w.mass = whitney_mass(w.edges, shapes);
  return w;
}

}  // namespace mq::test
