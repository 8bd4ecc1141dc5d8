// Charts are let down on those before them, the highest first, each where it ends lowest. Not their
// boxes meet but their lower and upper borders, column by column (Lévy, Petitjean, Ray, Maillot,
// Least squares conformal maps, 2002), which are widened by half the gutter all around. The scale
// is found by bisection.

#include "mq/sample/detail/pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/infinity.h"

namespace mq {
namespace {

constexpr int most_columns = 1024;

struct Outline {
  std::vector<Vector2> points;  // of the boundary, in the chart's own units
  std::vector<std::array<int, 2>> edges;
  Vector2 low = Vector2::Zero(), size = Vector2::Zero();  // of the box, once turned
  double angle = 0;
};

Vector2 turned(const Vector2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

// ---- Outlines, lying in their smallest boxes ----

/// Edges that only one triangle of the chart has.
std::vector<Outline> find_outlines(const Mesh& mesh, const std::vector<int>& charts, int count) {
  std::vector<std::map<std::array<int, 2>, int>> uses(count);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax({mesh.corner_uvs[t][k], mesh.corner_uvs[t][(k + 1) % 3]});
      ++uses[charts[t]][{a, b}];
    }
  std::vector<Outline> outlines(count);
  for (int c = 0; c < count; ++c) {
    std::map<int, int> local;
    for (const auto& [edge, triangles] : uses[c]) {
      if (triangles != 1) continue;
      std::array<int, 2> ends;
      for (int k = 0; k < 2; ++k) {
        const auto [it, fresh] = local.try_emplace(edge[k], int(outlines[c].points.size()));
        if (fresh) outlines[c].points.push_back(mesh.uvs[edge[k]]);
        ends[k] = it->second;
      }
      outlines[c].edges.push_back(ends);
    }
  }
  return outlines;
}

void turn_to(double angle, Outline& outline) {
  outline.angle = angle;
  Vector2 high = Vector2::Constant(-infinity);
  outline.low = Vector2::Constant(infinity);
  for (const Vector2& p : outline.points) {
    outline.low = outline.low.cwiseMin(turned(p, angle));
    high = high.cwiseMax(turned(p, angle));
  }
  outline.size = high - outline.low;
}

/// Of 90 angles the one with the smallest box, which then lies.
void turn_to_smallest_box(Outline& outline) {
  const double right = std::numbers::pi / 2;
  double best = infinity, best_angle = 0;
  for (int k = 0; k < 90; ++k) {
    turn_to(right * k / 90, outline);
    if (outline.size.prod() >= best * (1 - 1e-9)) continue;
    best = outline.size.prod();
    best_angle = outline.angle;
  }
  turn_to(best_angle, outline);
  if (outline.size.x() < outline.size.y()) turn_to(best_angle + right, outline);
}

// ---- Borders and where they come to rest ----

/// Lowest and highest point of the chart in each column, widened by half the gutter.
struct Borders {
  std::vector<double> lower, upper;
};

/// Lengths are in columns.
Borders find_borders(const Outline& outline, double scale, double gutter) {
  const double margin = gutter / 2;
  const int columns = int(std::floor(outline.size.x() * scale + gutter)) + 1;
  Borders borders{std::vector<double>(columns, infinity), std::vector<double>(columns, -infinity)};
  std::vector<Vector2> points;
  for (const Vector2& p : outline.points)
    points.push_back((turned(p, outline.angle) - outline.low) * scale + Vector2::Constant(margin));
  for (const auto& [i, j] : outline.edges) {
    const bool rising = points[i].x() <= points[j].x();
    const Vector2 &a = points[rising ? i : j], &b = points[rising ? j : i];
    const int first = std::max(0, int(std::floor(a.x() - margin)));
    const int last = std::min(columns - 1, int(std::floor(b.x() + margin)));
    for (int k = first; k <= last; ++k) {
      const auto height = [&](double x) {
        const double t = (x - a.x()) / std::max(b.x() - a.x(), 1e-300);
        return a.y() + std::clamp(t, 0.0, 1.0) * (b.y() - a.y());
      };
      const auto [low, high] = std::minmax({height(k - margin), height(k + 1 + margin)});
      borders.lower[k] = std::min(borders.lower[k], low - margin);
      borders.upper[k] = std::max(borders.upper[k], high + margin);
    }
  }
  return borders;
}

/// What is placed so far, seen from above.
class Horizon {
 public:
  explicit Horizon(int columns) : heights_(columns, 0.0) {}

  /// Lets a chart down where it ends lowest, leftmost among such places; false if it does not fit.
  bool place(const Borders& chart, Vector2& corner) {
    const int columns = int(heights_.size()), width = int(chart.lower.size());
    double best = infinity;
    int at = -1;
    for (int x = 0; x + width <= columns; ++x) {
      double y = 0;
      for (int k = 0; k < width && y < best; ++k) y = std::max(y, heights_[x + k] - chart.lower[k]);
      if (y < best) best = y, at = x;
    }
    if (at < 0 || best + *std::max_element(chart.upper.begin(), chart.upper.end()) > columns)
      return false;
    for (int k = 0; k < width; ++k) heights_[at + k] = best + chart.upper[k];
    corner = {at, best};
    return true;
  }

 private:
  std::vector<double> heights_;
};

/// Corners of all charts, in columns; empty if they do not fit.
std::vector<Vector2> place_all(const std::vector<Outline>& outlines, const std::vector<int>& order,
                               double scale, int columns, double gutter) {
  Horizon horizon(columns);
  std::vector<Vector2> corners(outlines.size());
  for (const int c : order)
    if (!horizon.place(find_borders(outlines[c], scale, gutter), corners[c])) return {};
  return corners;
}

}  // namespace

void pack(Mesh& mesh, const std::vector<int>& charts, const SamplePackOptions& options) {
  require(options.texture_size >= 1, "a texture needs at least one texel");
  const int count = charts.empty() ? 0 : *std::max_element(charts.begin(), charts.end()) + 1;
  if (count == 0) return;
  std::vector<Outline> outlines = find_outlines(mesh, charts, count);
  std::vector<int> order;
  double box_area = 0;
  for (int c = 0; c < count; ++c) {
    turn_to_smallest_box(outlines[c]);
    box_area += outlines[c].size.prod();
    order.push_back(c);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return outlines[a].size.y() > outlines[b].size.y(); });

  const int columns = std::min(options.texture_size, most_columns);
  double gutter = std::min(options.gutter * columns / options.texture_size, columns / 4.0);
  while (double(count) * gutter * gutter > double(columns) * columns / 4) gutter /= 2;
  double low = 0, high = 2 * columns / std::sqrt(box_area);
  std::vector<Vector2> corners;
  for (int k = 0; k < 20 || corners.empty(); ++k) {
    const double middle = (low + high) / 2;
    if (auto found = place_all(outlines, order, middle, columns, gutter); !found.empty()) {
      low = middle;
      corners = std::move(found);
    } else {
      high = middle;
    }
  }
  std::vector<char> moved(mesh.uvs.size());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int i : mesh.corner_uvs[t]) {
      if (moved[i]) continue;
      moved[i] = 1;
      const Outline& outline = outlines[charts[t]];
      mesh.uvs[i] = ((turned(mesh.uvs[i], outline.angle) - outline.low) * low + corners[charts[t]] +
                     Vector2::Constant(gutter / 2)) /
                    columns;
    }
}

}  // namespace mq
