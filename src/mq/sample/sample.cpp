// A sample is a shape with charts, packed for a texture size. Shapes by formula bring their charts;
// the others are solids whose surface is cut and flattened.

#include "mq/sample/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <utility>

#include "mq/base/error.h"
#include "mq/sample/detail/flatten.h"
#include "mq/sample/owl.h"
#include "mq/sample/detail/pack.h"
#include "mq/sample/detail/segment.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

struct Request {
  int triangles;
  std::uint64_t seed;
  const Progress& progress;
};

using MakeShape = std::function<Shape(const Request&)>;
using MakeColors = std::function<ColorField(std::uint64_t seed)>;

struct Recipe {
  SampleInfo info;
  int triangles;  // by default
  MakeShape shape;
  MakeColors colors;
  double gutter = 6;  // texels
};

// ---- Solids, cut and flattened ----

Mesh owl(int triangles, const Progress& progress) {
  const ImplicitOptions options{
      .low = {-0.75, -1, -0.7}, .high = {0.75, 1.08, 0.7}, .triangles = triangles};
  return mesh_of_solid(owl_solid, options, progress);
}

/// A round button with four holes.
Mesh button(int triangles, const Progress& progress) {
  const auto solid = [](const Vector3& p) {
    const double r = std::hypot(p.x(), p.y());
    const double disc = std::hypot(std::max(0.0, r - 0.78), p.z()) - 0.16;
    const double rim = std::hypot(r - 0.80, p.z()) - 0.19;
    const double hole = std::hypot(std::abs(p.x()) - 0.27, std::abs(p.y()) - 0.27) - 0.15;
    return -smooth_union(-smooth_union(disc, rim, 0.1), hole, 0.12);
  };
  const ImplicitOptions options{.low = {-1.1, -1.1, -0.35},
                                .high = {1.1, 1.1, 0.35},
                                .triangles = triangles,
                                .euler_characteristic = -6};
  return mesh_of_solid(solid, options, progress);
}

Shape flattened(Mesh mesh, const Surface& surface, const std::vector<char>& seams,
                const Progress& progress) {
  FlatCharts flat = flatten(surface, seams, {}, progress);
  mesh.uvs = std::move(flat.uvs);
  mesh.corner_uvs = std::move(flat.corner_uvs);
  return {std::move(mesh), std::move(flat.charts)};
}

Shape in_charts(Mesh mesh, const SegmentOptions& options, const Progress& progress) {
  const Surface surface = make_surface(mesh);
  const std::vector<char> seams = seams_between(surface, segment(surface, options));
  return flattened(std::move(mesh), surface, seams, progress);
}

/// One chart, cut open from the middle of the bottom to the two places farthest from it.
Shape cut_open(Mesh mesh, const Progress& progress) {
  const Surface surface = make_surface(mesh);
  int root = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const auto height = [&](int i) {
      const Vector3& p = surface.mesh.positions[i];
      return p.y() + 0.1 * std::hypot(p.x(), p.z());
    };
    if (height(v) < height(root)) root = v;
  }
  return flattened(std::move(mesh), surface, seams_along_tree(surface, root, 2), progress);
}

MakeShape owl_in(int charts, double unevenness = 0) {
  return [=](const Request& request) {
    Mesh mesh = owl(request.triangles, request.progress.step("mesh", 0.3));
    const Progress flattening = request.progress.step("flatten", 0.7);
    if (charts == 1) return cut_open(std::move(mesh), flattening);
    const SegmentOptions options{.charts = charts,
                                 .rounds = unevenness > 0 ? 0 : 20,
                                 .unevenness = unevenness,
                                 .seed = request.seed};
    return in_charts(std::move(mesh), options, flattening);
  };
}

Shape button_in_24(const Request& request) {
  Mesh mesh = button(request.triangles, request.progress.step("mesh", 0.3));
  return in_charts(std::move(mesh), {.charts = 24, .rounds = 20, .seed = request.seed},
                   request.progress.step("flatten", 0.7));
}

// ---- Shapes by formula ----

/// How often n fits, at least `least` times, when the triangles are `each` n².
int fit(const Request& request, double each, int least) {
  return std::max(least, int(std::lround(std::sqrt(request.triangles / each))));
}

MakeShape torus_by(TorusMap map) {
  return [=](const Request& request) {
    const int n = fit(request, 4, 3);
    return torus(2 * n, n, 0.45, map);
  };
}

Shape polyhedral_torus(const Request& request) {
  return flat_torus(9, fit(request, 36, 1), 2, 2.2);
}

Shape open_cylinder(const Request& request) {
  const int n = fit(request, 6, 1);
  return cylinder(3 * n, n, 2);
}

Shape sphere(const Request& request) { return cube_sphere(fit(request, 12, 1)); }

Shape cube(const Request& request) { return cube_cross(fit(request, 12, 1)); }

// ---- The cap, whose maps are measured against each other ----

Shape cap(const Request& request) {
  const double angle = 1.9;  // radians: a little more than a hemisphere
  return spherical_cap(fit(request, 6, 2), angle);
}

/// The disc onto itself by z -> (z + a) / (1 + a z), which keeps angles: lengths differ by
/// ((1 + a) / (1 - a))² between its ends.
Shape moebius_cap(const Request& request) {
  Shape shape = cap(request);
  const double a = 0.5;
  for (Vector2& uv : shape.mesh.uvs) {
    const std::complex<double> z(uv.x(), uv.y()), w = (z + a) / (1.0 + a * z);
    uv = {w.real(), w.imag()};
  }
  return shape;
}

MakeShape cap_stretched(double ratio) {
  return [=](const Request& request) {
    Shape shape = cap(request);
    for (Vector2& uv : shape.mesh.uvs) uv.x() /= ratio;
    return shape;
  };
}

Shape cap_in_28(const Request& request) {
  Mesh mesh = cap(request).mesh;
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  return in_charts(std::move(mesh), {.charts = 28, .rounds = 20, .seed = request.seed},
                   request.progress);
}

// ---- The list ----

MakeColors plain(double scale) {
  return [=](std::uint64_t seed) { return colorful(scale, seed); };
}

// clang-format off
const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> list{
      {{"bust", "an owl's bust in 28 charts, painted like a photograph"},
       24000, owl_in(28), owl_colors},
      {{"bust_1", "the same as one chart, cut open along a tree"},
       24000, owl_in(1), owl_colors},
      {{"bust_4", "the same in 4 charts"},
       24000, owl_in(4), owl_colors},
      {{"bust_3000", "the same in 3,000 charts of all sizes, as photogrammetry cuts"},
       60000, owl_in(3000, 0.7), owl_colors, 2},
      {{"genus4", "a button with four holes, in 24 charts"},
       16000, button_in_24, plain(0.7)},
      {{"sphere", "the unit sphere in six charts"},
       12000, sphere, plain(0.8)},
      {{"torus", "a torus as one chart, with two seams"},
       10000, torus_by(TorusMap::arc_length), plain(0.8)},
      {{"torus_conformal", "the same torus, its chart conformal"},
       10000, torus_by(TorusMap::conformal), plain(0.8)},
      {{"flat_torus", "a polyhedral torus without any curvature, as one isometric chart"},
       14000, polyhedral_torus, plain(0.9)},
      {{"cylinder", "an open cylinder with one seam, isometric"},
       6000, open_cylinder, plain(0.8)},
      {{"cube", "a cube unfolded to a cross, isometric"},
       3000, cube, plain(1.0)},
      {{"cap", "a cap of a sphere as one conformal chart"},
       20000, cap, plain(0.7)},
      {{"cap_moebius", "the same, its chart moved by a Moebius transform: conformal, lengths 9:1"},
       20000, moebius_cap, plain(0.7)},
      {{"cap_stretched_4", "the same, its chart compressed 4:1"},
       20000, cap_stretched(4), plain(0.7)},
      {{"cap_stretched_16", "the same, its chart compressed 16:1"},
       20000, cap_stretched(16), plain(0.7)},
      {{"cap_28", "the same in 28 charts"},
       20000, cap_in_28, plain(0.7)},
  };
  return list;
}
// clang-format on

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
    throw InvalidInput(
        fmt::format("a sample cannot have {0} x {0} texels: 1 to 32768 a side can "
                    "be made",
                    options.texture_size));
  if (options.triangles < 0 || options.triangles > 20'000'000)
    throw InvalidInput(
        fmt::format("a sample cannot have {} triangles: up to 20 million can be "
                    "made, 0 for its own number",
                    options.triangles));
  const int triangles = options.triangles > 0 ? options.triangles : recipe.triangles;
  Shape shape = recipe.shape({triangles, options.seed, progress.step("shape", 0.9)});
  pack(shape.mesh, shape.charts, {.texture_size = options.texture_size, .gutter = recipe.gutter});
  progress.at(1);
  return {name,
          std::move(shape.mesh),
          {options.texture_size, options.texture_size, Wrap::clamp},
          recipe.colors(options.seed)};
}

Image<float> paint(const Sample& sample, Alignment alignment, std::uint64_t seed,
                   const Progress& progress) {
  const Surface surface = make_surface(sample.mesh);
  const Atlas atlas = make_atlas(surface, {sample.texture});
  if (alignment == Alignment::aligned) return paint(surface, atlas, sample.colors, {}, 0, progress);
  const MisalignOptions options{.shift = 2 * atlas.texel_spacing(), .seed = seed};
  return paint(surface, atlas, misaligned(sample.colors, options), {}, 0, progress);
}

}  // namespace mq
