// A vertex in every cell of a grid whose corners are not all on one side, a quadrilateral around
// every grid edge whose ends are on different sides.

#include "mq/sample/implicit.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/random.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

constexpr std::uint64_t max_attempts = 60;

struct Grid {
  Vector3 low;
  double step;
  int nx, ny, nz;  // points
  std::vector<double> values;

  std::int64_t index(int i, int j, int k) const { return (std::int64_t(k) * ny + j) * nx + i; }
  Vector3 point(int i, int j, int k) const { return low + step * Vector3(i, j, k); }
};

Grid sample_grid(const Solid& solid, const Vector3& low, const Vector3& high, double step) {
  Grid grid{low, step, 0, 0, 0, {}};
  const Vector3 count = ((high - low) / step).array().ceil() + 1;
  grid.nx = int(count.x()), grid.ny = int(count.y()), grid.nz = int(count.z());
  grid.values.resize(std::size_t(grid.nx) * grid.ny * grid.nz);
  parallel_for(
      grid.nz,
      [&](std::int64_t k) {
        for (int j = 0; j < grid.ny; ++j)
          for (int i = 0; i < grid.nx; ++i)
            grid.values[grid.index(i, j, int(k))] = solid(grid.point(i, j, int(k)));
      },
      1);
  return grid;
}

/// The mean of the crossings of the cell's edges; false where there is none.
bool cell_vertex(const Grid& grid, int i, int j, int k, Vector3& vertex) {
  Vector3 sum = Vector3::Zero();
  int crossings = 0;
  const auto corner = [](int c) { return std::array<int, 3>{c & 1, c >> 1 & 1, c >> 2}; };
  const auto value = [&](int c) {
    const auto o = corner(c);
    return grid.values[grid.index(i + o[0], j + o[1], k + o[2])];
  };
  for (int a = 0; a < 8; ++a)
    for (const int bit : {1, 2, 4}) {
      if (a & bit) continue;
      const int b = a | bit;
      const double fa = value(a), fb = value(b);
      if ((fa < 0) == (fb < 0)) continue;
      const auto oa = corner(a), ob = corner(b);
      const double t = fa / (fa - fb);
      sum += (1 - t) * grid.point(i + oa[0], j + oa[1], k + oa[2]) +
             t * grid.point(i + ob[0], j + ob[1], k + ob[2]);
      ++crossings;
    }
  if (crossings == 0) return false;
  vertex = sum / crossings;
  return true;
}

Mesh surface_net(const Grid& grid) {
  Mesh mesh;
  std::vector<int> vertices(grid.values.size(), -1);  // per cell, by its lowest corner
  for (int k = 0; k + 1 < grid.nz; ++k)
    for (int j = 0; j + 1 < grid.ny; ++j)
      for (int i = 0; i + 1 < grid.nx; ++i) {
        Vector3 vertex;
        if (!cell_vertex(grid, i, j, k, vertex)) continue;
        vertices[grid.index(i, j, k)] = mesh.vertex_count();
        mesh.positions.push_back(vertex);
      }
  const auto quad = [&](int a, int b, int c, int d, bool outward) {
    if (!outward) std::swap(b, d);
    const auto length = [&](int p, int q) {
      return (mesh.positions[p] - mesh.positions[q]).norm();
    };
    if (length(a, c) <= length(b, d)) {
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    } else {
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({b, c, d});
    }
  };
  for (int k = 1; k + 1 < grid.nz; ++k)
    for (int j = 1; j + 1 < grid.ny; ++j)
      for (int i = 1; i + 1 < grid.nx; ++i) {
        const bool inside = grid.values[grid.index(i, j, k)] < 0;
        const auto differs = [&](int x, int y, int z) {
          return inside != (grid.values[grid.index(x, y, z)] < 0);
        };
        const auto cell = [&](int x, int y, int z) { return vertices[grid.index(x, y, z)]; };
        if (differs(i + 1, j, k))
          quad(cell(i, j - 1, k - 1), cell(i, j, k - 1), cell(i, j, k), cell(i, j - 1, k), inside);
        if (differs(i, j + 1, k))
          quad(cell(i - 1, j, k - 1), cell(i - 1, j, k), cell(i, j, k), cell(i, j, k - 1), inside);
        if (differs(i, j, k + 1))
          quad(cell(i - 1, j - 1, k), cell(i, j - 1, k), cell(i, j, k), cell(i - 1, j, k), inside);
      }
  return mesh;
}

/// One Newton step along the gradient by central differences.
Vector3 to_surface(const Solid& solid, const Vector3& p, double step) {
  Vector3 gradient;
  for (int k = 0; k < 3; ++k) {
    Vector3 d = Vector3::Zero();
    d[k] = 1e-3 * step;
    gradient[k] = (solid(p + d) - solid(p - d)) / (2e-3 * step);
  }
  const Vector3 move = -solid(p) / std::max(gradient.squaredNorm(), 0.01) * gradient;
  return p + std::min(1.0, 0.5 * step / std::max(move.norm(), 1e-300)) * move;
}

void relax(const Solid& solid, double step, Mesh& mesh) {
  std::vector<Vector3> sums(mesh.positions.size(), Vector3::Zero());
  std::vector<int> counts(mesh.positions.size());
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      sums[t[k]] += mesh.positions[t[(k + 1) % 3]] + mesh.positions[t[(k + 2) % 3]];
      counts[t[k]] += 2;
    }
  parallel_for(mesh.vertex_count(), [&](std::int64_t v) {
    const Vector3 p = 0.5 * (mesh.positions[v] + sums[v] / counts[v]);
    mesh.positions[v] = to_surface(solid, to_surface(solid, p, step), step);
  });
}

}  // namespace

Mesh mesh_of_solid(const Solid& solid, const ImplicitOptions& options, const Progress& progress) {
  const Vector3 extent = options.high - options.low;
  const double coarse = extent.maxCoeff() / 40;
  const int found =
      surface_net(sample_grid(solid, options.low, options.high, coarse)).triangle_count();
  const double step = coarse * std::sqrt(double(found) / options.triangles);
  // A cell that two sheets cross gets one vertex for both. Another place of the grid avoids it.
  const Random random(0);
  for (std::uint64_t attempt = 0; attempt < max_attempts; ++attempt) {
    const Vector3 shift(random.uniform(3 * attempt), random.uniform(3 * attempt + 1),
                        random.uniform(3 * attempt + 2));
    const Vector3 low = options.low - step * (Vector3::Ones() + shift);
    Mesh mesh = surface_net(sample_grid(solid, low, options.high + step * Vector3::Ones(), step));
    progress.at(0.5);
    const Surface surface = make_surface(mesh);
    if (!surface.defects.empty() || surface.euler_characteristic != options.euler_characteristic)
      continue;
    for (int round = 0; round < options.relaxations; ++round) {
      relax(solid, step, mesh);
      progress.at(0.5 + 0.5 * (round + 1) / options.relaxations);
    }
    return mesh;
  }
  throw InvalidInput(
      fmt::format("{} triangles are too few for this solid: ask for more", options.triangles));
}

double smooth_union(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k / 4;
}

}  // namespace mq
