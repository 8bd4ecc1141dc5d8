#pragma once
/// Flat surfaces with atlases cut in many ways: on them exact answers are known.

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include "fixtures.h"
#include "mq/atlas/atlas.h"
#include "mq/mesh/surface.h"

namespace mq::fixtures {

/// A surface with its atlas, at fixed addresses.
struct Textured {
  Surface surface;
  Atlas atlas;
};

inline std::unique_ptr<Textured> textured(const Mesh& mesh, const std::vector<TextureSize>& sizes,
                                          const AtlasOptions& options = {}) {
  auto result = std::make_unique<Textured>();
  result->surface = make_surface(mesh);
  result->atlas = make_atlas(result->surface, sizes, options);
  return result;
}

/// A square cut along a grid into charts, each an affine copy of its part in a slot of its own.
struct CutOptions {
  int cells = 12;       ///< the square is cells × cells quads
  int parts = 2;        ///< charts along x
  int parts_up = 0;     ///< charts along y; 0: as many as along x
  double jitter = 0.2;  ///< of inner vertices
  double scale = 0.7;   ///< of each chart in its slot of the texture
  std::function<double(int)> angle = [](int) { return 0.0; };             ///< of chart c, radians
  std::function<Vector2(int)> shift = [](int) { return Vector2(0, 0); };  ///< of chart c, in uv
  std::function<int(int)> texture = [](int) { return 0; };                ///< of chart c
  /// What is done to chart c before it is turned.
  std::function<Eigen::Matrix2d(int)> shape = [](int) { return Eigen::Matrix2d::Identity().eval(); };

  int rows() const { return parts_up > 0 ? parts_up : parts; }
  int charts() const { return parts * rows(); }
};

/// The middle of part c on the square, and of its slot in the texture.
inline Vector2 middle_of_part(const CutOptions& options, int part) {
  return {(part % options.parts + 0.5) / options.parts,
          (part / options.parts + 0.5) / options.rows()};
}

/// uv = middle + shift + map · (p − middle) for points p of part c of the square.
inline Eigen::Matrix2d map_of_part(const CutOptions& options, int part) {
  return options.scale * Eigen::Rotation2Dd(options.angle(part)).toRotationMatrix() *
         options.shape(part);
}

/// The point of the square, or of the plane around it, whose place in part c is `uv`.
inline Vector2 on_square(const CutOptions& options, int part, const Vector2& uv) {
  const Vector2 middle = middle_of_part(options, part);
  return middle + map_of_part(options, part).inverse() * (uv - middle - options.shift(part));
}

/// The unit square so cut. Chart c of its atlas is part c.
inline Mesh cut_square(const CutOptions& options = {}) {
  Mesh mesh = flat_square(options.cells, options.jitter);
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  std::map<std::pair<int, int>, int> uv_of;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int quad = t / 2, i = quad % options.cells, j = quad / options.cells;
    const int part = j * options.rows() / options.cells * options.parts +
                     i * options.parts / options.cells;
    const Vector2 middle = middle_of_part(options, part);
    const Eigen::Matrix2d map = map_of_part(options, part);
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles[t][k];
      const auto [it, added] = uv_of.insert({{part, v}, int(mesh.uvs.size())});
      if (added) {
        const Vector2 p = mesh.positions[v].head<2>();
        mesh.uvs.push_back(middle + options.shift(part) + map * (p - middle));
      }
      corners[k] = it->second;
    }
    mesh.corner_uvs.push_back(corners);
    mesh.textures.push_back(options.texture(part));
  }
  return mesh;
}

/// The mesh with every chart lifted off the others: nothing but charts, no seams.
inline Mesh torn(const Mesh& mesh, double lift = 1) {
  Mesh result = mesh;
  result.positions.assign(mesh.uvs.size(), Vector3::Zero());
  result.triangles = mesh.corner_uvs;
  const Atlas atlas = make_atlas(make_surface(mesh), {{64, 64}, {64, 64}});
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      result.positions[mesh.corner_uvs[t][k]] =
          mesh.position(t, k) + Vector3(0, 0, lift * atlas.chart[t]);
  return result;
}

/// The same cut on a torus around the z-axis (radii R > r), opposite sides of the square joined:
/// x runs around the axis, y around the tube.
inline Mesh cut_torus(const CutOptions& options, double R = 1, double r = 0.4) {
  Mesh mesh = cut_square(options);
  const auto angle = [](double x) { return x == 1 ? 0.0 : 2 * std::numbers::pi * x; };
  for (Vector3& p : mesh.positions) {
    const double u = angle(p.x()), v = angle(p.y()), rho = R + r * std::cos(v);
    p = {rho * std::cos(u), rho * std::sin(u), r * std::sin(v)};
  }
  return mesh;
}

/// The unit sphere as a cube blown up, six charts of n × n cells, each turned in its slot of a 3 : 2
/// texture.
inline Mesh cut_sphere(int n, const CutOptions& options) {
  Mesh mesh;
  std::map<std::array<int, 3>, int> vertex_of;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face % 2;
    const Vector2 middle((face % 3 + 0.5) / 3, (face / 3 + 0.5) / 2);
    const Eigen::Matrix2d map = Vector2(1.0 / 3, 1.0 / 2).asDiagonal() * map_of_part(options, face);
    const int first_uv = int(mesh.uvs.size());
    std::vector<int> vertices;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        std::array<int, 3> at{};  // i × j turns towards the outside on both sides
        at[axis] = side * n;
        at[(axis + 1) % 3] = side ? i : j;
        at[(axis + 2) % 3] = side ? j : i;
        const auto [it, added] = vertex_of.insert({at, mesh.vertex_count()});
        if (added) {
          const auto angle = [&](int k) { return std::tan((2.0 * at[k] / n - 1) * std::numbers::pi / 4); };
          mesh.positions.push_back(Vector3(angle(0), angle(1), angle(2)).normalized());
        }
        vertices.push_back(it->second);
        mesh.uvs.push_back(middle + map * (Vector2(i, j) / n - Vector2(0.5, 0.5)));
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
        for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
          mesh.triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
          mesh.corner_uvs.push_back({first_uv + t[0], first_uv + t[1], first_uv + t[2]});
        }
      }
  }
  return mesh;
}

/// Angles that no texel line runs along.
inline double odd_angle(int chart) { return 0.3 + 1.1 * chart; }

/// Stretched 2 to 3 times one way, and sheared.
inline Eigen::Matrix2d sheared(int chart) {
  Eigen::Matrix2d shape;
  shape << 1.2, 0.4 - 0.2 * (chart % 4), 0, 0.5;
  return shape;
}

/// Quarter turns: seams of charts cut along the axes stay along texel lines.
inline double quarter_turn(int chart) { return chart * std::acos(-1.0) / 2; }

}  // namespace mq::fixtures
