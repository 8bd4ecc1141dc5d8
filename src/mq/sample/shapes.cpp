#include "mq/sample/shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace mq {
namespace {

using std::numbers::pi;

/// Where the faces of a cube lie: grid point (i, j) of n × n is origin + i·right + j·up on the
/// lattice [0, n]³, and (column, row) is the face's place in the cross.
struct Face {
  std::array<int, 3> origin, right, up;  // in units of n, of 1, of 1
  int column, row;
};

// The side faces follow each other around the y-axis, top and bottom hang on the front (+z).
constexpr std::array<Face, 6> cube_faces{{
    {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0, 1},   // left   (-x)
    {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1, 1},   // front  (+z)
    {{1, 0, 1}, {0, 0, -1}, {0, 1, 0}, 2, 1},  // right  (+x)
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, 3, 1},  // back   (-z)
    {{0, 1, 1}, {1, 0, 0}, {0, 0, -1}, 1, 2},  // top    (+y)
    {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 1, 0},   // bottom (-y)
}};

/// The surface of the lattice cube; lattice[v] is the lattice point of vertex v, uvs[v] belongs to
/// face and grid point, in cells.
struct CubeGrid {
  std::vector<Triangle> triangles, corner_uvs;
  std::vector<std::array<int, 3>> lattice;
  std::vector<std::array<int, 2>> grid;  // of a uv, inside its face
  std::vector<int> face;                 // per triangle
};

CubeGrid cube_grid(int n) {
  CubeGrid cube;
  std::map<std::array<int, 3>, int> vertices;
  for (int f = 0; f < 6; ++f) {
    const Face& face = cube_faces[f];
    const int first_uv = int(cube.grid.size());
    std::vector<int> ids;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        std::array<int, 3> point;
        for (int k = 0; k < 3; ++k)
          point[k] = n * face.origin[k] + i * face.right[k] + j * face.up[k];
        const auto [it, fresh] = vertices.try_emplace(point, int(cube.lattice.size()));
        if (fresh) cube.lattice.push_back(point);
        ids.push_back(it->second);
        cube.grid.push_back({i, j});
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
        for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
          cube.triangles.push_back({ids[t[0]], ids[t[1]], ids[t[2]]});
          cube.corner_uvs.push_back({first_uv + t[0], first_uv + t[1], first_uv + t[2]});
          cube.face.push_back(f);
        }
      }
  }
  return cube;
}

/// Triangles of an n × m grid of cells over points (n + 1) × (m + 1), the points row by row.
std::vector<Triangle> grid_triangles(int n, int m) {
  std::vector<Triangle> triangles;
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      triangles.push_back({a, b, c});
      triangles.push_back({a, c, d});
    }
  return triangles;
}

/// Cuts every triangle into m² like it; points on an edge are made once.
template <class Point>
void refine(const std::vector<Point>& points, const std::vector<Triangle>& triangles, int m,
            std::vector<Point>& finer, std::vector<Triangle>& finer_triangles) {
  finer = points;
  std::map<std::array<int, 3>, int> on_edges;  // by (lower end, upper end, steps from the lower)
  for (const Triangle& t : triangles) {
    const auto edge_point = [&](int a, int b, int step) {
      if (a > b) std::swap(a, b), step = m - step;
      if (step == 0) return a;
      if (step == m) return b;
      const auto [it, fresh] = on_edges.try_emplace({a, b, step}, int(finer.size()));
      if (fresh) finer.push_back(points[a] + double(step) / m * (points[b] - points[a]));
      return it->second;
    };
    std::vector<std::vector<int>> rows(m + 1);  // rows[j][i] is i steps to t[1] and j to t[2]
    for (int j = 0; j <= m; ++j)
      for (int i = 0; i + j <= m; ++i) {
        int id = int(finer.size());
        if (j == 0)
          id = edge_point(t[0], t[1], i);
        else if (i == 0)
          id = edge_point(t[0], t[2], j);
        else if (i + j == m)
          id = edge_point(t[1], t[2], j);
        else
          finer.push_back(points[t[0]] + double(i) / m * (points[t[1]] - points[t[0]]) +
                          double(j) / m * (points[t[2]] - points[t[0]]));
        rows[j].push_back(id);
      }
    for (int j = 0; j < m; ++j)
      for (int i = 0; i + j < m; ++i) {
        finer_triangles.push_back({rows[j][i], rows[j][i + 1], rows[j + 1][i]});
        if (i + j + 1 < m)
          finer_triangles.push_back({rows[j][i + 1], rows[j + 1][i + 1], rows[j + 1][i]});
      }
  }
}

/// One chart of everything.
Shape one_chart(Mesh mesh) {
  std::vector<int> charts(mesh.triangles.size(), 0);
  return {std::move(mesh), std::move(charts)};
}

}  // namespace

Shape cube_cross(int n) {
  const CubeGrid cube = cube_grid(n);
  Mesh mesh;
  mesh.triangles = cube.triangles;
  for (const auto& p : cube.lattice)
    mesh.positions.push_back(Vector3(p[0], p[1], p[2]) * 2 / n - Vector3::Ones());
  std::map<std::array<int, 2>, int> pool;  // faces that touch in the cross share coordinates
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    const Face& face = cube_faces[cube.face[t]];
    mesh.corner_uvs.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const auto& [i, j] = cube.grid[cube.corner_uvs[t][k]];
      const std::array<int, 2> place{n * face.column + i, n * face.row + j};
      const auto [it, fresh] = pool.try_emplace(place, int(mesh.uvs.size()));
      if (fresh) mesh.uvs.push_back(Vector2(place[0], place[1]) * 2 / n);
      mesh.corner_uvs.back()[k] = it->second;
    }
  }
  return one_chart(std::move(mesh));
}

Shape cube_sphere(int n) {
  const CubeGrid cube = cube_grid(n);
  const auto angle = [&](double grid) { return (2 * grid / n - 1) * pi / 4; };
  Shape shape;
  shape.mesh.triangles = cube.triangles;
  shape.mesh.corner_uvs = cube.corner_uvs;
  shape.charts = cube.face;
  for (const auto& p : cube.lattice) {
    Vector3 direction;
    for (int k = 0; k < 3; ++k) direction[k] = std::tan(angle(p[k]));
    shape.mesh.positions.push_back(direction.normalized());
  }
  for (const auto& g : cube.grid) shape.mesh.uvs.emplace_back(angle(g[0]), angle(g[1]));
  return shape;
}

Shape torus(int n, int m, double r, TorusMap map) {
  Mesh mesh;
  const auto chart_height = [&](double v) {
    if (map == TorusMap::arc_length) return r * v;
    // ∫ r / (1 + r cos v) dv, continued over the pole of the tangent at v = π
    const double root = std::sqrt(1 - r * r), half = (v - pi) / 2;
    return v <= 0 ? 0.0 : 2 * r / root * (pi / 2 + std::atan(std::tan(half) * (1 + r) / root));
  };
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) {
      const double u = 2 * pi * i / n, v = 2 * pi * j / m;
      mesh.uvs.emplace_back(u, chart_height(v));
      if (i == n || j == m) continue;
      const double rho = 1 + r * std::cos(v);
      mesh.positions.emplace_back(rho * std::sin(u), r * std::sin(v), rho * std::cos(u));
    }
  mesh.corner_uvs = grid_triangles(n, m);
  for (const Triangle& t : mesh.corner_uvs) {
    mesh.triangles.emplace_back();
    for (int k = 0; k < 3; ++k)
      mesh.triangles.back()[k] = t[k] / (n + 1) % m * n + t[k] % (n + 1) % n;
  }
  return one_chart(std::move(mesh));
}

Shape flat_torus(int n, int m, int twist, double height) {
  Mesh coarse;
  for (const double row : {0.0, 0.5})  // bottom vertices A_i, top vertices B_i half an edge on
    for (int i = 0; i < n; ++i) {
      const double a = 2 * pi * (i + row) / n;
      coarse.positions.emplace_back(std::sin(a), (2 * row - 0.5) * height, std::cos(a));
    }
  const auto A = [&](int i) { return (i % n + n) % n; };
  const auto B = [&](int i) { return n + (i % n + n) % n; };
  const auto& p = coarse.positions;
  const double edge = (p[A(1)] - p[A(0)]).norm();
  // Where c lies in the plane when a is at 0 and b at (edge, 0).
  const auto tip = [&](int a, int b, int c) {
    const double x = (p[c] - p[a]).dot(p[b] - p[a]) / edge;
    return Vector2(x, std::sqrt((p[c] - p[a]).squaredNorm() - x * x));
  };
  // The plane has three rows of vertices: A, over it B, over it A again, n + 1 in each.
  const Vector2 outer = tip(A(0), A(1), B(0)), inner = tip(B(0), B(1), A(1 + twist));
  for (const Vector2& row : {Vector2(0, 0), outer, Vector2(outer + inner)})
    for (int i = 0; i <= n; ++i) coarse.uvs.emplace_back(row + Vector2(edge * i, 0));
  const auto uv = [&](int row, int i) { return row * (n + 1) + i; };
  for (int i = 0; i < n; ++i) {
    const int j = i + 1 + twist;
    coarse.triangles.insert(coarse.triangles.end(), {{A(i), A(i + 1), B(i)},
                                                     {A(i + 1), B(i + 1), B(i)},
                                                     {B(i), B(i + 1), A(j)},
                                                     {B(i + 1), A(j + 1), A(j)}});
    for (const int row : {0, 1}) {
      coarse.corner_uvs.push_back({uv(row, i), uv(row, i + 1), uv(row + 1, i)});
      coarse.corner_uvs.push_back({uv(row, i + 1), uv(row + 1, i + 1), uv(row + 1, i)});
    }
  }
  Mesh mesh;
  refine(coarse.positions, coarse.triangles, m, mesh.positions, mesh.triangles);
  refine(coarse.uvs, coarse.corner_uvs, m, mesh.uvs, mesh.corner_uvs);
  return one_chart(std::move(mesh));
}

Shape cylinder(int n, int m, double height) {
  Mesh mesh;
  const double side = 2 * std::sin(pi / n);
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) {
      const double a = 2 * pi * i / n, y = height * (double(j) / m - 0.5);
      mesh.uvs.emplace_back(side * i, y);
      if (i < n) mesh.positions.emplace_back(std::sin(a), y, std::cos(a));
    }
  mesh.corner_uvs = grid_triangles(n, m);
  for (const Triangle& t : mesh.corner_uvs) {
    mesh.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) mesh.triangles.back()[k] = t[k] / (n + 1) * n + t[k] % (n + 1) % n;
  }
  return one_chart(std::move(mesh));
}

Shape spherical_cap(int n, double angle) {
  Mesh mesh;
  const auto ring_start = [](int ring) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1); };
  for (int ring = 0; ring <= n; ++ring)
    for (int i = 0; i < std::max(1, 6 * ring); ++i) {
      const double polar = angle * ring / n, around = 2 * pi * i / std::max(1, 6 * ring);
      const double s = std::sin(around), c = std::cos(around);
      mesh.positions.emplace_back(std::sin(polar) * c, std::cos(polar), -std::sin(polar) * s);
      mesh.uvs.emplace_back(std::tan(polar / 2) / std::tan(angle / 2) * Vector2(c, s));
    }
  for (int ring = 1; ring <= n; ++ring) {
    const int inner = std::max(1, 6 * (ring - 1)), outer = 6 * ring;
    const auto in = [&](int i) { return ring_start(ring - 1) + i % inner; };
    const auto out = [&](int i) { return ring_start(ring) + i % outer; };
    for (int sector = 0; sector < 6; ++sector)
      for (int i = 0; i < ring; ++i) {
        const int a = sector * (ring - 1) + i, b = sector * ring + i;
        mesh.triangles.push_back({in(a), out(b), out(b + 1)});
        if (i + 1 < ring) mesh.triangles.push_back({in(a), out(b + 1), in(a + 1)});
      }
  }
  mesh.corner_uvs = mesh.triangles;
  return one_chart(std::move(mesh));
}

}  // namespace mq
