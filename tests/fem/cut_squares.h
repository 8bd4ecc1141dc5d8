#pragma once
/// Flat squares cut in every way that a texel space must bear, and functions on them.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/atlas_fixtures.h"
#include "mq/base/random.h"
#include "mq/fem/texel_space.h"

namespace mq::fixtures {

struct Cut {
  std::string name;
  CutOptions options;
  TextureSize size;
  bool apart = true;  ///< no texel is read by two charts
  std::unique_ptr<Textured> model;
};

inline CutOptions turned(std::function<double(int)> angle, int parts = 2) {
  CutOptions options;
  options.parts = parts;
  options.cells = 6 * parts;
  options.angle = std::move(angle);
  options.scale = 0.6;
  options.shift = [](int chart) { return Vector2(0.0017 * (chart % 3), -0.0013 * (chart % 4)); };
  return options;
}

/// Charts stretched and sheared, each in its own direction.
inline CutOptions slanted(int parts = 2) {
  CutOptions options = turned(odd_angle, parts);
  options.shape = sheared;
  options.scale = 0.5;
  return options;
}

inline Cut cut(std::string name, CutOptions options, TextureSize size, bool apart = true) {
  auto model = textured(cut_square(options), {size});
  return {std::move(name), std::move(options), size, apart, std::move(model)};
}

/// Where the texels lie.
inline std::vector<Vector3> places_of(const TexelSpace& space) {
  std::vector<Vector3> places;
  for (int k = 0; k < space.size(); ++k) places.push_back(space.texels().position(k));
  return places;
}

/// Seams along texel lines, across them, vertices on texel centres, unlike texel spacings on both
/// sides of a seam, tiny charts, charts inside one cell, charts that share texels.
inline std::vector<Cut> cut_squares() {
  std::vector<Cut> all;
  CutOptions one;
  one.parts = 1;
  all.push_back(cut("one chart", one, {48, 48}));
  one.scale = 0.5;
  one.angle = odd_angle;
  one.shape = sheared;
  all.push_back(cut("one slanted chart", one, {30, 50}));
  all.push_back(cut("turned by odd angles", turned(odd_angle), {48, 48}));
  all.push_back(cut("quarter turns", turned(quarter_turn), {48, 48}));
  all.push_back(cut("slanted", slanted(), {96, 160}));
  all.push_back(cut("slanted, few texels", slanted(), {30, 50}));
  CutOptions on_lines = turned(quarter_turn);
  on_lines.jitter = 0;
  on_lines.scale = 0.75;  // 36 of 48 texels for 12 cells: corners on texel centres
  on_lines.shift = [](int) { return Vector2(0.5 / 48, 0.5 / 48); };
  all.push_back(cut("on texel lines", on_lines, {48, 48}));
  on_lines.shift = [](int chart) {
    return Vector2((0.5 + 1e-8 * chart) / 48, (0.5 - 1e-7 * chart) / 48);
  };
  all.push_back(cut("a hair beside texel lines", on_lines, {48, 48}));
  CutOptions islands = turned(odd_angle);
  islands.scale = 0.15;  // 0.6 texels wide, around the middles of cells
  islands.shift = [](int) { return Vector2(0, 0); };
  all.push_back(cut("charts inside one cell", islands, {8, 8}));
  all.push_back(cut("36 charts", turned(odd_angle, 6), {128, 128}));
  CutOptions crowded = turned(odd_angle, 6);
  crowded.scale = 0.5;
  all.push_back(cut("charts of few texels", crowded, {24, 24}, false));
  all.push_back(cut("charts below a texel", crowded, {5, 5}, false));
  return all;
}

inline bool shares_texels(const TexelSpace& space) {
  for (const Defect& d : space.defects())
    if (d.kind == "shared_texels" || d.kind == "overlapping_triangles") return true;
  return false;
}

/// Where on the square each texel lies in its chart's map.
inline std::vector<Vector2> texels_on_square(const CutOptions& options, const TextureSize& size,
                                             const Texels& texels) {
  std::vector<Vector2> points;
  for (int i = 0; i < texels.size(); ++i) {
    const Texels::Place& at = texels.places[i];
    const Vector2 uv((at.x + 0.5) / size.width, 1 - (at.y + 0.5) / size.height);
    points.push_back(on_square(options, texels.chart[i], uv));
  }
  return points;
}

/// A function of the square at the texels.
inline Signal sample(const Cut& cut, const TexelSpace& space,
                     const std::function<double(const Vector2&)>& f) {
  const std::vector<Vector2> points = texels_on_square(cut.options, cut.size, space.texels());
  Signal values(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) values(i, 0) = f(points[i]);
  return values;
}

/// The value of a signal at a point of a triangle.
inline double value_at(const TexelSpace& space, const Signal& signal, int triangle,
                       const Vector3& barycentric) {
  double value = 0;
  for (const BasisWeight& w : space.basis_at(triangle, barycentric))
    value += w.weight * signal(w.unknown, 0);
  return value;
}

/// The k-th random point of a triangle; every fourth lies on its first edge.
inline Vector3 random_point(const Random& random, std::uint64_t k) {
  double u = random.uniform(2 * k), v = random.uniform(2 * k + 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  if (k % 4 == 0) v = 0;
  return {1 - u - v, u, v};
}

inline Vector3 on_surface(const Mesh& mesh, int triangle, const Vector3& l) {
  return l[0] * mesh.position(triangle, 0) + l[1] * mesh.position(triangle, 1) +
         l[2] * mesh.position(triangle, 2);
}

/// The point of parameter s on a half-edge.
inline Vector3 on_half_edge(HalfEdge h, double s) {
  Vector3 l = Vector3::Zero();
  l[h % 3] = 1 - s;
  l[next(h) % 3] = s;
  return l;
}

/// The first half-edge of every seam.
inline std::vector<HalfEdge> seams_of(const Textured& model) {
  std::vector<HalfEdge> seams;
  for (HalfEdge h = 0; h < HalfEdge(model.atlas.edges.size()); ++h)
    if (model.atlas.edges[h] == EdgeKind::seam && model.surface.twins[h] > h) seams.push_back(h);
  return seams;
}

}  // namespace mq::fixtures
