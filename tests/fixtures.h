#pragma once
/// Small meshes and pictures that several rooms test with, made in code. One line says what each is
/// for.

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "mq/base/defect.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/image/image.h"
#include "mq/mesh/mesh.h"

namespace mq::fixtures {

/// One right triangle in the xy-plane, legs of length 1, its UVs its own x and y.
inline Mesh one_triangle() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

/// The unit square in the xy-plane as n × n cells of two triangles; UVs are x and y: one isometric
/// chart. Inner vertices move by up to `jitter` of a cell (below 0.25 nothing flips).
inline Mesh flat_square(int n, double jitter = 0, std::uint64_t seed = 1) {
  Mesh mesh;
  const Random random(seed);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && i < n && j > 0 && j < n;
      const auto count = 2 * std::uint64_t(j * (n + 1) + i);
      const double x = (i + (inner ? random.uniform(count, -jitter, jitter) : 0)) / n;
      const double y = (j + (inner ? random.uniform(count + 1, -jitter, jitter) : 0)) / n;
      mesh.positions.emplace_back(x, y, 0);
      mesh.uvs.emplace_back(x, y);
    }
  const auto id = [&](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

/// The unit square as two triangles in charts of their own (both isometric at scale 0.4, the second
/// turned by 90 degrees): the smallest seam.
inline Mesh two_chart_quad() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uvs = {{0.05, 0.05}, {0.45, 0.05}, {0.45, 0.45}, {0.95, 0.55}, {0.55, 0.95}, {0.55, 0.55}};
  mesh.corner_uvs = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

/// The same, with the vertices of the diagonal written twice, as exporters do at seams.
inline Mesh split_two_chart_quad() {
  Mesh mesh = two_chart_quad();
  mesh.positions.push_back(mesh.positions[0]);
  mesh.positions.push_back(mesh.positions[2]);
  mesh.triangles[1] = {4, 5, 3};
  return mesh;
}

/// A square of two triangles and one chart whose UV corners are texel centres of a size² texture,
/// and whose edges run along texel rows and columns and through texel centres.
inline Mesh uv_on_texel_line(int size) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const double a = (size / 4 + 0.5) / size, b = (3 * size / 4 + 0.5) / size;
  mesh.uvs = {{a, a}, {b, a}, {b, b}, {a, b}};
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

/// Two triangles that share a single vertex.
inline Mesh nonmanifold_vertex() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  return mesh;
}

/// Three triangles on one edge.
inline Mesh nonmanifold_edge() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  return mesh;
}

/// A strip of 2n triangles with a half twist: it cannot be oriented.
inline Mesh moebius_strip(int n) {
  Mesh mesh;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    for (const double s : {-0.3, 0.3}) {
      const double r = 1 + s * std::cos(a / 2);
      mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), s * std::sin(a / 2));
    }
  }
  for (int i = 0; i < n; ++i) {
    const int a = 2 * i, b = 2 * i + 1;
    const int c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? b + 2 : 0;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({b, c, d});
  }
  return mesh;
}

/// The closed surface of a regular tetrahedron.
inline Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  return mesh;
}

/// Of all spheres its subdivisions have the most regular triangles.
inline Mesh icosahedron() {
  const double g = std::numbers::phi;
  Mesh mesh;
  mesh.positions = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
  return mesh;
}

/// The unit sphere: a tetrahedron, 4·4^levels triangles in the end, or another mesh halved `levels` times, vertices
/// projected.
inline Mesh sphere(int levels, Mesh mesh = tetrahedron()) {
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), mesh.vertex_count());
      if (fresh) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) / 2);
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vector3& p : mesh.positions) p.normalize();
  return mesh;
}

/// A torus around the z-axis (radii R > r) of n × m cells; u runs around the axis.
inline Mesh torus(int n, int m, double R = 1, double r = 0.4) {
  Mesh mesh;
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
      const double rho = R + r * std::cos(v);
      mesh.positions.emplace_back(rho * std::cos(u), rho * std::sin(u), r * std::sin(v));
    }
  const auto id = [&](int i, int j) { return (j % m) * n + i % n; };
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return mesh;
}

/// `b` after `a`, nothing joined; for meshes without UVs.
inline Mesh beside(Mesh a, const Mesh& b) {
  const int first = a.vertex_count();
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& [i, j, k] : b.triangles)
    a.triangles.push_back({first + i, first + j, first + k});
  return a;
}

/// The mesh with every triangle's vertices written for it alone, as an unindexed file has them.
inline Mesh triangle_soup(const Mesh& mesh) {
  Mesh soup = mesh;
  soup.positions.clear();
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      soup.triangles[t][k] = soup.vertex_count();
      soup.positions.push_back(mesh.position(t, k));
    }
  return soup;
}

/// A picture of values in [0, 1).
inline Image<float> noise(int width, int height, int channels) {
  Image<float> image(width, height, channels);
  const Random random(3);
  for (std::uint64_t i = 0; float& v : image.values()) v = float(random.uniform(i++));
  return image;
}

/// What an action says that throws such an error; empty where it does not.
template <class Thrown = InvalidInput>
std::string error_of(const auto& action) {
  try {
    action();
  } catch (const Thrown& error) {
    return error.what();
  }
  return "";
}

/// The defect of that kind, or one with count 0.
inline Defect defect(const Defects& defects, const std::string& kind) {
  for (const Defect& d : defects)
    if (d.kind == kind) return d;
  return {};
}

}  // namespace mq::fixtures
