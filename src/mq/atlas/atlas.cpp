// Charts and seams by flood fill over twin half-edges. Everything is decided on coordinates rounded
// once (texel_point.h), so two triangles agree on an edge exactly or not at all.

#include "mq/atlas/atlas.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/option_names.h"

namespace mq {
namespace {

constexpr double max_tiles = 100;
constexpr double few_flipped = 1e-3;  // of the area of all charts

double signed_texel_area(const std::array<TexelPoint, 3>& p) {
  return 0.5 * double(orientation(p[0], p[1], p[2])) / double(TexelPoint::one) /
         double(TexelPoint::one);
}

/// Triangles below this, in texels², are as good as collapsed: rounding to 2⁻³⁶ texel is all they
/// are.
constexpr double smallest_triangle = 1e-12;

/// Rounds the corners of every triangle that can take part; chart = 0 marks them, -1 the others.
void place_triangles(const Surface& surface, Atlas& atlas) {
  const Mesh& mesh = surface.mesh;
  std::vector<std::int64_t> untextured, without_uv, not_finite, far_away, collapsed;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int texture = mesh.texture(t);
    if (texture < 0) {
      untextured.push_back(t);
      continue;
    }
    if (texture >= int(atlas.textures.size()))
      throw InvalidInput(fmt::format(
          "triangle {} is painted with texture {}, but there are {}: give one picture per texture",
          t, texture, atlas.textures.size()));
    if (!mesh.textured(t)) {
      without_uv.push_back(t);
      continue;
    }
    const TextureSize& size = atlas.textures[texture];
    bool finite = true, near = true;
    for (int k = 0; k < 3; ++k) {
      const Vector2& uv = mesh.uv(t, k);
      finite = finite && uv.allFinite();
      near = near && uv.cwiseAbs().maxCoeff() <= max_tiles;
    }
    if (!finite || !near) {
      (finite ? far_away : not_finite).push_back(t);
      continue;
    }
    for (int k = 0; k < 3; ++k)
      atlas.corners[t][k] = texel_point(mesh.uv(t, k), size.width, size.height);
    if (surface.degenerate[t]) continue;
    const auto& p = atlas.corners[t];
    if (std::abs(signed_texel_area(p)) < smallest_triangle) {
      collapsed.push_back(t);
      continue;
    }
    atlas.chart[t] = 0;
  }
  using enum Defect::Severity;
  add_defect(atlas.defects, "untextured_triangles", note, "triangle", untextured,
             "no texture is assigned; the surface ends there");
  add_defect(atlas.defects, "triangles_without_uv", warning, "triangle", without_uv,
             "corners without texture coordinates; the surface ends there",
             "with corners that lack texture coordinates: the surface ends there");
  add_defect(atlas.defects, "uv_not_finite", refused, "triangle", not_finite,
             "texture coordinates that are not finite numbers: repair the UVs of these triangles");
  add_defect(atlas.defects, "uv_far_away", refused, "triangle", far_away,
             fmt::format("texture coordinates beyond {} tiles: move these UVs to the unit square",
                         max_tiles));
  add_defect(atlas.defects, "uv_without_area", warning, "triangle", collapsed,
             "triangles with area on the surface and less than 1e-12 texels in the texture, or "
             "none: no texel can show them, "
             "they are left out",
             "with no area in the texture: no texel can show them, left out");
}

/// Same texture, same two points: the edge lies inside a chart.
bool agree(const Surface& surface, const Atlas& atlas, HalfEdge a, HalfEdge b) {
  const auto corner = [&](HalfEdge h) { return atlas.corners[h / 3][h % 3]; };
  return surface.mesh.texture(a / 3) == surface.mesh.texture(b / 3) &&
         corner(a) == corner(next(b)) && corner(next(a)) == corner(b);
}

void classify_edges(const Surface& surface, Atlas& atlas) {
  atlas.edges.assign(3 * atlas.chart.size(), EdgeKind::boundary);
  for (HalfEdge h = 0; h < HalfEdge(atlas.edges.size()); ++h) {
    const HalfEdge twin = surface.twins[h];
    if (atlas.chart[h / 3] < 0 || twin < 0 || atlas.chart[twin / 3] < 0) continue;
    atlas.edges[h] = agree(surface, atlas, h, twin) ? EdgeKind::inside : EdgeKind::seam;
    if (atlas.edges[h] == EdgeKind::seam && h < twin) ++atlas.seam_count;
  }
}

void flood_charts(const Surface& surface, Atlas& atlas) {
  std::vector<int> stack;
  std::vector<char> placed(atlas.chart.size());
  for (std::size_t seed = 0; seed < atlas.chart.size(); ++seed) {
    if (atlas.chart[seed] < 0 || placed[seed]) continue;
    const int id = int(atlas.charts.size());
    atlas.charts.push_back({.texture = surface.mesh.texture(int(seed))});
    placed[seed] = 1;
    stack.push_back(int(seed));
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      atlas.chart[t] = id;
      ++atlas.charts[id].triangles;
      for (int k = 0; k < 3; ++k) {
        if (atlas.edges[3 * t + k] != EdgeKind::inside) continue;
        const int s = surface.twins[3 * t + k] / 3;
        if (placed[s]) continue;
        placed[s] = 1;
        stack.push_back(s);
      }
    }
  }
}

/// Charts in the order of a walk over the surface, see `Chart::turn`: breadth first across seams,
/// from the first chart of each component.
void walk_charts(const Surface& surface, Atlas& atlas) {
  std::vector<std::vector<int>> next_to(atlas.charts.size());
  for (HalfEdge h = 0; h < int(atlas.edges.size()); ++h)
    if (atlas.chart[h / 3] >= 0 && atlas.edges[h] == EdgeKind::seam)
      next_to[atlas.chart[h / 3]].push_back(atlas.chart[surface.twins[h] / 3]);
  std::vector<int> walk;
  std::vector<char> met(atlas.charts.size(), 0);
  for (int seed = 0; seed < int(atlas.charts.size()); ++seed) {
    if (met[seed]) continue;
    met[seed] = 1;
    walk.push_back(seed);
    for (std::size_t i = walk.size() - 1; i < walk.size(); ++i)
      for (const int c : next_to[walk[i]])
        if (!met[c]) {
          met[c] = 1;
          walk.push_back(c);
        }
  }
  for (int i = 0; i < int(walk.size()); ++i) atlas.charts[walk[i]].turn = i;
}

/// Areas, mirrored charts, triangles against their chart. Rows run downward, so a chart seen from
/// the front has negative orientation in texel coordinates.
void orient_charts(const Surface& surface, const AtlasOptions& options, Atlas& atlas) {
  std::vector<double> balance(atlas.charts.size(), 0.0);
  for (int t = 0; t < int(atlas.chart.size()); ++t)
    if (atlas.chart[t] >= 0) {
      Chart& chart = atlas.charts[atlas.chart[t]];
      const double area = signed_texel_area(atlas.corners[t]);
      balance[atlas.chart[t]] += area;
      chart.texel_area += std::abs(area);
      const Mesh& m = surface.mesh;
      chart.surface_area +=
          0.5 *
          (m.position(t, 1) - m.position(t, 0)).cross(m.position(t, 2) - m.position(t, 0)).norm();
    }
  std::vector<std::int64_t> mirrored, flipped;
  for (std::size_t c = 0; c < atlas.charts.size(); ++c) {
    atlas.charts[c].mirrored = balance[c] > 0;
    if (atlas.charts[c].mirrored) mirrored.push_back(std::int64_t(c));
    atlas.surface_area += atlas.charts[c].surface_area;
    atlas.texel_area += atlas.charts[c].texel_area;
  }
  for (int t = 0; t < int(atlas.chart.size()); ++t)
    if (atlas.chart[t] >= 0 &&
        (signed_texel_area(atlas.corners[t]) > 0) != atlas.charts[atlas.chart[t]].mirrored)
      flipped.push_back(t);
  using enum Defect::Severity;
  add_defect(atlas.defects, "mirrored_charts", note, "chart", mirrored,
             "charts whose picture is seen from behind; filtered like any other");
  double folded = 0;
  for (std::int64_t t : flipped) folded += std::abs(signed_texel_area(atlas.corners[t]));
  using Flipped = AtlasOptions::Flipped;
  const bool refuse = options.flipped == Flipped::refuse ||
                      (options.flipped == Flipped::few && folded > few_flipped * atlas.texel_area);
  const std::string extent =
      fmt::format("{:.3g} % of the texels of all charts", 100 * folded / atlas.texel_area);
  add_defect(atlas.defects, "flipped_triangles", refuse ? refused : warning, "triangle", flipped,
             refuse ? "triangles flipped against their chart, so that it folds over itself (" +
                          extent + "): repair the UVs there, or accept the folds with " +
                          option_name("flipped") + " keep"
                    : "triangles flipped against their chart (" + extent +
                          "): both layers of the fold read and write the same texels",
             "flipped against their chart: both layers of the fold share texels");
}

struct Box {
  std::int64_t x0 = std::numeric_limits<std::int64_t>::max(), y0 = x0, x1 = -x0, y1 = -x0;
};

std::vector<Box> chart_boxes(const Atlas& atlas) {
  std::vector<Box> boxes(atlas.charts.size());
  for (int t = 0; t < int(atlas.chart.size()); ++t)
    if (atlas.chart[t] >= 0)
      for (const TexelPoint& p : atlas.corners[t]) {
        Box& box = boxes[atlas.chart[t]];
        box.x0 = std::min(box.x0, p.x), box.x1 = std::max(box.x1, p.x);
        box.y0 = std::min(box.y0, p.y), box.y1 = std::max(box.y1, p.y);
      }
  return boxes;
}

/// Whole tiles come off; what still leaves [0,1] makes its texture repeat, unless it clamps.
void bring_home(Atlas& atlas) {
  const std::vector<Box> boxes = chart_boxes(atlas);
  // The unit square spans [-1/2, size - 1/2] in texels; rounding of the file's floats is forgiven.
  const std::int64_t half = TexelPoint::one / 2, slack = TexelPoint::one / 100;
  const auto tile = [](std::int64_t low, std::int64_t high, int texels) {
    const double middle = (double(low) + double(high)) / 2 / double(TexelPoint::one) + 0.5;
    return int(std::floor(middle / texels));
  };
  const auto leaves = [&](std::int64_t low, std::int64_t high, int texels, int tiles) {
    const std::int64_t shift = std::int64_t(tiles) * texels * TexelPoint::one;
    return low - shift < -half - slack || high - shift > texels * TexelPoint::one - half + slack;
  };
  std::vector<std::int64_t> outside, moved;
  std::vector<char> left(atlas.textures.size());
  for (std::size_t c = 0; c < atlas.charts.size(); ++c) {
    Chart& chart = atlas.charts[c];
    const TextureSize& size = atlas.textures[chart.texture];
    chart.tile_x = tile(boxes[c].x0, boxes[c].x1, size.width);
    chart.tile_y = tile(boxes[c].y0, boxes[c].y1, size.height);
    if (chart.tile_x != 0 || chart.tile_y != 0) moved.push_back(std::int64_t(c));
    if (leaves(boxes[c].x0, boxes[c].x1, size.width, chart.tile_x) ||
        leaves(boxes[c].y0, boxes[c].y1, size.height, chart.tile_y)) {
      outside.push_back(std::int64_t(c));
      left[chart.texture] = 1;
    }
  }
  for (int t = 0; t < int(atlas.chart.size()); ++t)
    if (atlas.chart[t] >= 0) {
      const Chart& chart = atlas.charts[atlas.chart[t]];
      const TextureSize& size = atlas.textures[chart.texture];
      for (TexelPoint& p : atlas.corners[t]) {
        p.x -= std::int64_t(chart.tile_x) * size.width * TexelPoint::one;
        p.y -= std::int64_t(chart.tile_y) * size.height * TexelPoint::one;
      }
    }
  for (std::size_t k = 0; k < atlas.textures.size(); ++k) {
    Wrap& wrap = atlas.textures[k].wrap;
    if (!left[k])
      wrap = Wrap::clamp;
    else if (wrap == Wrap::unspecified)
      wrap = Wrap::repeat;
  }
  using enum Defect::Severity;
  add_defect(atlas.defects, "charts_in_other_tiles", note, "chart", moved,
             "charts that lie in another tile than [0,1]; the texture repeats there");
  add_defect(atlas.defects, "charts_outside", warning, "chart", outside,
             "charts that leave [0,1]: the texture is taken as its wrap mode says, repeated where "
             "the file says nothing",
             "that leave [0,1]: wrapped as the file says, or repeated");
}

void list_stretched(const Surface& surface, Atlas& atlas) {
  std::vector<std::int64_t> stretched;
  for (int t = 0; t < int(atlas.chart.size()); ++t)
    if (atlas.chart[t] >= 0 && texel_metric(surface, atlas, t).stretch > max_stretch)
      stretched.push_back(t);
  add_defect(atlas.defects, "stretched_triangles", Defect::Severity::warning, "triangle", stretched,
             fmt::format("triangles stretched beyond {:.0f} : 1 between texture and surface; "
                         "integrated as if it were that",
                         max_stretch),
             fmt::format("stretched beyond {:.0f} : 1 in the texture: integrated as if it were that", max_stretch));
}

}  // namespace

double Atlas::texel_spacing() const {
  return texel_area > 0 ? std::sqrt(surface_area / texel_area) : 0;
}

TexelMetric texel_metric(const Surface& surface, const Atlas& atlas, int triangle) {
  const Mesh& mesh = surface.mesh;
  const auto& p = atlas.corners[triangle];
  const double one = double(TexelPoint::one);
  Eigen::Matrix2d E;
  E << double(p[1].x - p[0].x) / one, double(p[2].x - p[0].x) / one, double(p[1].y - p[0].y) / one,
      double(p[2].y - p[0].y) / one;
  Eigen::Matrix<double, 3, 2> e;
  e.col(0) = mesh.position(triangle, 1) - mesh.position(triangle, 0);
  e.col(1) = mesh.position(triangle, 2) - mesh.position(triangle, 0);

  // Exact in the integers: the determinant of nearly collinear corners must not cancel.
  const double determinant = double(orientation(p[0], p[1], p[2])) / one / one;
  Eigen::Matrix2d adjugate;
  adjugate << E(1, 1), -E(0, 1), -E(1, 0), E(0, 0);

  TexelMetric metric;
  metric.density = Vector3(e.col(0)).cross(Vector3(e.col(1))).norm() / std::abs(determinant);
  // J = e E^-1 scaled to unit density: the entries stay in range for any unit of length.
  const Eigen::Matrix<double, 3, 2> J = e * adjugate / (determinant * std::sqrt(metric.density));
  Eigen::Matrix2d g = J.transpose() * J;
  const double half_trace = g.trace() / 2;  // |g| = 1: the eigenvalues are s and 1/s, s the stretch
  metric.stretch = half_trace + std::sqrt(std::max(0.0, half_trace * half_trace - 1));
  if (!(metric.stretch <= max_stretch)) {
    const Eigen::Matrix2d deviator = g - half_trace * Eigen::Matrix2d::Identity();
    const double radius = deviator.norm() / std::sqrt(2.0);
    g = (max_stretch + 1 / max_stretch) / 2 * Eigen::Matrix2d::Identity() +
        (radius > 0 ? (max_stretch - 1 / max_stretch) / 2 / radius : 0.0) * deviator;
  }
  metric.a = g(1, 1);
  metric.b = -g(0, 1);
  metric.c = g(0, 0);
  return metric;
}

Atlas make_atlas(const Surface& surface, const std::vector<TextureSize>& textures,
                 const AtlasOptions& options, const Progress& progress) {
  for (std::size_t k = 0; k < textures.size(); ++k)
    if (textures[k].width < 1 || textures[k].height < 1 || textures[k].width > 1 << 15 ||
        textures[k].height > 1 << 15)
      throw InvalidInput(fmt::format("texture {} has {} x {} texels: 1 to 32768 a side can be used",
                                     k, textures[k].width, textures[k].height));
  Atlas atlas;
  atlas.textures = textures;
  atlas.chart.assign(surface.mesh.triangle_count(), -1);
  atlas.corners.resize(surface.mesh.triangle_count());
  place_triangles(surface, atlas);
  progress.at(0.3);
  classify_edges(surface, atlas);
  flood_charts(surface, atlas);
  walk_charts(surface, atlas);
  progress.at(0.6);
  orient_charts(surface, options, atlas);
  bring_home(atlas);
  list_stretched(surface, atlas);
  progress.at(1);
  return atlas;
}

}  // namespace mq
