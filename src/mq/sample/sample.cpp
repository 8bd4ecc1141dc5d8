// A sample is a shape with charts, packed for a texture size. Shapes by formula bring their charts;
// the others are solids whose surface is cut and flattened.

#include "mq/sample/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/sample/flatten.h"
#include "mq/sample/noise.h"
#include "mq/sample/owl.h"
#include "mq/sample/pack.h"
#include "mq/sample/segment.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

struct Recipe {
  SampleInfo info;
  int triangles;  // by default
  double gutter;  // texels
  std::function<Shape(int triangles, std::uint64_t seed, const Progress&)> shape;
  std::function<ColorField(std::uint64_t seed)> colors;
};

// ---- Solids ----

Mesh owl(int triangles, const Progress& progress) {
  return mesh_of_solid(owl_solid, {.low = {-0.75, -1, -0.7}, .high = {0.75, 1.08, 0.7},
                                   .triangles = triangles}, progress);
}

/// A round button with four holes.
Mesh button(int triangles, const Progress& progress) {
  const auto solid = [](const Vector3& p) {
    const double r = std::hypot(p.x(), p.y());
    const double outer = std::hypot(std::max(0.0, r - 0.78), p.z()) - 0.16;
    const double rim = std::hypot(r - 0.80, p.z()) - 0.19;
    const double hole = std::hypot(std::abs(p.x()) - 0.27, std::abs(p.y()) - 0.27) - 0.15;
    return -smooth_union(-smooth_union(outer, rim, 0.1), hole, 0.12);
  };
  return mesh_of_solid(solid, {.low = {-1.1, -1.1, -0.35}, .high = {1.1, 1.1, 0.35},
                               .triangles = triangles, .euler_characteristic = -6}, progress);
}

Shape flattened(Mesh mesh, const std::vector<char>& seams, const Surface& surface,
                const Progress& progress) {
  FlatCharts flat = flatten(surface, seams, {}, progress);
  mesh.uvs = std::move(flat.uvs);
  mesh.corner_uvs = std::move(flat.corner_uvs);
  return {std::move(mesh), std::move(flat.charts)};
}

Shape in_charts(Mesh mesh, const SegmentOptions& options, const Progress& progress) {
  const Surface surface = make_surface(mesh);
  const auto seams = seams_between(surface, segment(surface, options));
  return flattened(std::move(mesh), seams, surface, progress);
}

/// One chart, cut open from the middle of its bottom to `tips` places as far as can be.
Shape cut_open(Mesh mesh, int tips, const Progress& progress) {
  const Surface surface = make_surface(mesh);
  int root = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const auto height = [&](int i) {
      const Vector3& p = surface.mesh.positions[i];
      return p.y() + 0.1 * std::hypot(p.x(), p.z());
    };
    if (height(v) < height(root)) root = v;
  }
  return flattened(std::move(mesh), seams_along_tree(surface, root, tips), surface, progress);
}

Shape owl_in(int charts, double unevenness, int triangles, std::uint64_t seed,
             const Progress& progress) {
  const auto meshing = progress.step("mesh", 0.3);
  Mesh mesh = owl(triangles, meshing);
  const auto flattening = progress.step("flatten", 0.7);
  if (charts == 1) return cut_open(std::move(mesh), 2, flattening);
  return in_charts(std::move(mesh), {.charts = charts, .rounds = unevenness > 0 ? 0 : 20,
                                     .unevenness = unevenness, .seed = seed}, flattening);
}

// ---- The cap, whose maps are measured against each other ----

constexpr double cap_angle = 1.9;  // radians: a little more than a hemisphere

Shape cap(int triangles) {
  return spherical_cap(std::max(2, int(std::lround(std::sqrt(triangles / 6.0)))), cap_angle);
}

/// The disc onto itself by z → (z + a) / (1 + a z), which keeps angles: scales differ by
/// ((1 + a) / (1 - a))² between its ends.
Shape moebius_cap(int triangles) {
  Shape shape = cap(triangles);
  const double a = 0.5;
  for (Vector2& uv : shape.mesh.uvs) {
    const Vector2 numerator(uv.x() + a, uv.y()), denominator(1 + a * uv.x(), a * uv.y());
    uv = Vector2(numerator.dot(denominator),
                 numerator.y() * denominator.x() - numerator.x() * denominator.y()) /
         denominator.squaredNorm();
  }
  return shape;
}

Shape stretched_cap(int triangles, double ratio) {
  Shape shape = cap(triangles);
  for (Vector2& uv : shape.mesh.uvs) uv.x() /= ratio;
  return shape;
}

// ---- The list ----

int square_root(double x, int least) { return std::max(least, int(std::lround(std::sqrt(x)))); }

const std::vector<Recipe>& recipes() {
  using S = std::uint64_t;
  using P = const Progress&;
  const auto plain = [](double scale) { return [=](S seed) { return colorful(scale, seed); }; };
  static const std::vector<Recipe> list{
      {{"bust", "an owl's bust in 28 charts, painted like a photograph"}, 24000, 6,
       [](int n, S s, P p) { return owl_in(28, 0, n, s, p); }, owl_colors},
      {{"bust_1", "the same as one chart, cut open along a tree"}, 24000, 6,
       [](int n, S s, P p) { return owl_in(1, 0, n, s, p); }, owl_colors},
      {{"bust_4", "the same in 4 charts"}, 24000, 6,
       [](int n, S s, P p) { return owl_in(4, 0, n, s, p); }, owl_colors},
      {{"bust_3000", "the same in 3,000 charts of very different size, as photogrammetry cuts"},
       60000, 2, [](int n, S s, P p) { return owl_in(3000, 0.7, n, s, p); }, owl_colors},
      {{"genus4", "a button with four holes, in 24 charts"}, 16000, 6,
       [](int n, S s, P p) { return in_charts(button(n, p.step("mesh", 0.3)),
                                              {.charts = 24, .rounds = 20, .seed = s},
                                              p.step("flatten", 0.7)); }, plain(0.7)},
      {{"sphere", "the unit sphere in six charts"}, 12 * 32 * 32, 6,
       [](int n, S, P) { return cube_sphere(square_root(n / 12.0, 1)); }, plain(0.8)},
      {{"torus", "a torus as one chart, with two seams"}, 96 * 48 * 2, 6,
       [](int n, S, P) {
         const int m = square_root(n / 4.0, 3);
         return torus(2 * m, m, 0.45, TorusMap::arc_length);
       }, plain(0.8)},
      {{"torus_conformal", "the same torus, its chart conformal"}, 96 * 48 * 2, 6,
       [](int n, S, P) {
         const int m = square_root(n / 4.0, 3);
         return torus(2 * m, m, 0.45, TorusMap::conformal);
       }, plain(0.8)},
      {{"flat_torus", "a polyhedral torus without any curvature, as one isometric chart"},
       36 * 20 * 20, 6,
       [](int n, S, P) { return flat_torus(9, square_root(n / 36.0, 1), 2, 2.2); }, plain(0.9)},
      {{"cylinder", "an open cylinder with one seam, isometric"}, 96 * 32 * 2, 6,
       [](int n, S, P) {
         const int m = square_root(n / 6.0, 1);
         return cylinder(3 * m, m, 2);
       }, plain(0.8)},
      {{"cube", "a cube unfolded to a cross, isometric"}, 12 * 16 * 16, 6,
       [](int n, S, P) { return cube_cross(square_root(n / 12.0, 1)); }, plain(1.0)},
      {{"cap", "a cap of a sphere as one conformal chart"}, 6 * 60 * 60, 6,
       [](int n, S, P) { return cap(n); }, plain(0.7)},
      {{"cap_moebius", "the same, its chart moved by a Moebius transform: conformal, lengths 9:1"},
       6 * 60 * 60, 6, [](int n, S, P) { return moebius_cap(n); }, plain(0.7)},
      {{"cap_stretched_4", "the same, its chart compressed 4:1"}, 6 * 60 * 60, 6,
       [](int n, S, P) { return stretched_cap(n, 4); }, plain(0.7)},
      {{"cap_stretched_16", "the same, its chart compressed 16:1"}, 6 * 60 * 60, 6,
       [](int n, S, P) { return stretched_cap(n, 16); }, plain(0.7)},
      {{"cap_28", "the same in 28 charts"}, 6 * 60 * 60, 6,
       [](int n, S s, P p) {
         return in_charts(cap(n).mesh, {.charts = 28, .rounds = 20, .seed = s}, p);
       }, plain(0.7)},
  };
  return list;
}

/// Number of insertions, deletions and changes from one word to another.
int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = int(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = int(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row[b.size()];
}

const Recipe& find_recipe(const std::string& name) {
  const Recipe* nearest = nullptr;
  for (const Recipe& recipe : recipes()) {
    if (recipe.info.name == name) return recipe;
    if (!nearest || edit_distance(name, recipe.info.name) < edit_distance(name, nearest->info.name))
      nearest = &recipe;
  }
  throw InvalidInput(
      fmt::format("there is no sample '{}': did you mean '{}'?", name, nearest->info.name));
}

}  // namespace

const std::vector<SampleInfo>& sample_names() {
  static const std::vector<SampleInfo> names = [] {
    std::vector<SampleInfo> list;
    for (const Recipe& recipe : recipes()) list.push_back(recipe.info);
    return list;
  }();
  return names;
}

Sample make_sample(const std::string& name, const SampleOptions& options,
                   const Progress& progress) {
  const Recipe& recipe = find_recipe(name);
  if (options.texture_size < 1 || options.texture_size > 1 << 15)
    throw InvalidInput(fmt::format("a sample cannot have {0} x {0} texels: 1 to 32768 a side can "
                                   "be made", options.texture_size));
  if (options.triangles < 0 || options.triangles > 20'000'000)
    throw InvalidInput(fmt::format("a sample cannot have {} triangles: up to 20 million can be "
                                   "made, 0 for its own number", options.triangles));
  const int triangles = options.triangles > 0 ? options.triangles : recipe.triangles;
  Shape shape = recipe.shape(triangles, options.seed, progress.step("shape", 0.95));
  pack(shape.mesh, shape.charts,
       {.texture_size = options.texture_size, .gutter = recipe.gutter});
  progress.at(1);
  return {name, std::move(shape.mesh), {options.texture_size, options.texture_size, Wrap::clamp},
          recipe.colors(options.seed)};
}

Image<float> paint(const Sample& sample, Alignment alignment, std::uint64_t seed,
                   const Progress& progress) {
  const Surface surface = make_surface(sample.mesh);
  const Atlas atlas = make_atlas(surface, {sample.texture});
  if (alignment == Alignment::aligned)
    return paint(surface, atlas, sample.colors, {}, 0, progress);
  const MisalignOptions options{.shift = 2 * atlas.texel_spacing(), .seed = seed};
  return paint(surface, atlas, misaligned(sample.colors, options), {}, 0, progress);
}

}  // namespace mq
