// Of charts with S = Σ A ½(σ₁⁻² + σ₂⁻²) and U = Σ A σ₁σ₂ at scale 1, those of scale s together have
// the squared L² stretch Σ S/s² · Σ U s² / (Σ A)², which is least where s⁴ is proportional to S / U
// (Cauchy and Schwarz): the whole then has the stretch Σ √(S U) / Σ A, the mean of its charts'.

#include "mq/sequence/unwrap.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/mesh/geometry.h"
#include "mq/sequence/chart_surface.h"
#include "mq/sequence/pack.h"
#include "mq/sequence/parametrize.h"

namespace mq {
namespace {

/// How much further than the bound a chart's stretch may be for what the coarsened surface does not
/// show.
constexpr double detail = 1.5;

/// L² stretch beyond which a patch is halved: what is less may be relief that halving would not
/// end.
constexpr double most_patch_stretch = 1.5;

/// Enough to know where a chart overlaps itself.
constexpr int most_crossings = 200;

struct FlatChart {
  Sheet sheet;
  Points x;  // empty: none was found
  double stretch = std::numeric_limits<double>::infinity();
  std::vector<std::array<HalfEdge, 2>> crossings;  // of its boundary
};

/// The surface at unit area, on a grid, so that the unit of length leaves no trace.
Surface normalised(const Surface& surface) {
  const Box box = bounding_box(surface.mesh);
  const double size = (box.high - box.low).maxCoeff();
  require(size > 0 && surface.area > 0, "the surface has no area, so there is nothing to unwrap");
  Surface result = surface;
  double area = 0;
  for (Vector3& p : result.mesh.positions)
    for (int k = 0; k < 3; ++k)
      p[k] = std::nearbyint((p[k] - box.low[k]) / size * 0x1p32) * 0x1p-32;
  for (const double a : triangle_areas(result.mesh)) area += a;
  require(area > 0, "the surface has no area, so there is nothing to unwrap");
  for (Vector3& p : result.mesh.positions) p /= std::sqrt(area);
  result.area = 1;
  return result;
}

// ---- Laying charts flat ----

FlatChart lay_flat(const Surface& surface, const Patchwork& patchwork, int chart,
                   const Progress& progress) {
  FlatChart flat;
  flat.sheet = make_sheet(surface, patchwork.triangles(chart), patchwork.glued());
  flat.x = parametrize(flat.sheet, {}, progress);
  if (!flat.x.empty()) {
    flat.stretch = l2_stretch(flat.sheet, flat.x);
    flat.crossings = crossings(flat.sheet, flat.x, most_crossings);
  }
  return flat;
}

/// What tells a chart from all others: its triangles and where they are not glued.
std::vector<int> signature(const Patchwork& patchwork, int chart) {
  std::vector<int> key = patchwork.triangles(chart);
  std::ranges::sort(key);
  const std::size_t count = key.size();
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k)
      if (!patchwork.glued()[3 * key[i] + k]) key.push_back(3 * key[i] + k);
  return key;
}

/// The gluing that is to blame for most of a chart's crossings; for other failures its last.
int culprit(const Patchwork& patchwork, int chart, const FlatChart& flat) {
  std::map<int, int> blame;
  for (const auto& [a, b] : flat.crossings) ++blame[patchwork.joint(chart, a / 3, b / 3)];
  int worst = chart;
  for (const auto& [joint, count] : blame)
    if (patchwork.parts(joint)[0] >= 0 && (worst == chart || count > blame[worst])) worst = joint;
  return worst;
}

/// Halves a patch; steps count from one more patch on.
void halve(const Surface& surface, ChartHistory& history, int patch) {
  const int count = history.patches.count;
  halve_patch(surface, history.patches, patch);
  for (ChartHistory::Step& step : history.steps)
    for (int& chart : step.charts)
      if (chart >= count) ++chart;
}

/// Every chart in the plane; gluings after which one cannot be are refused, and patches that cannot
/// be are halved.
std::vector<FlatChart> lay_all_flat(const Surface& surface, ChartHistory history, double stretch,
                                    Patchwork& patchwork, const Progress& progress) {
  const double bound = 1 + detail * (stretch - 1);
  std::vector<char> refused(history.steps.size());
  std::map<std::vector<int>, FlatChart> known;
  for (int round = 1;; ++round) {
    std::vector<int> step_of, charts, fresh;
    patchwork = replay(surface, history, refused, step_of);
    std::vector<std::vector<int>> keys;
    for (int c = 0; c < patchwork.chart_count(); ++c) {
      if (!patchwork.is_whole(c) || patchwork.triangles(c).empty()) continue;
      charts.push_back(c);
      keys.push_back(signature(patchwork, c));
      if (!known.contains(keys.back())) fresh.push_back(int(charts.size()) - 1);
    }
    // The large ones first, so that none is left over for one thread at the end.
    std::ranges::stable_sort(fresh, std::ranges::greater{},
                             [&](int i) { return patchwork.triangles(charts[i]).size(); });
    std::vector<FlatChart> flats(fresh.size());
    parallel_for(
        std::ssize(fresh),
        [&](std::int64_t i) {
          flats[i] = lay_flat(surface, patchwork, charts[fresh[i]], progress);
        },
        1);
    bool again = false;
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      const int chart = charts[fresh[i]];
      const FlatChart& flat = flats[i];
      const bool lies_flat = !flat.x.empty() && is_injective(flat.sheet, flat.x);
      if (patchwork.parts(chart)[0] >= 0 && !(lies_flat && flat.stretch <= bound)) {
        refused[step_of[culprit(patchwork, chart, flat)]] = 1;
        again = true;
        continue;
      }
      if (patchwork.parts(chart)[0] < 0 && !(lies_flat && flat.stretch <= most_patch_stretch)) {
        require(patchwork.triangles(chart).size() > 1, "a triangle cannot be laid flat");
        halve(surface, history, chart);
        again = true;
        continue;
      }
      known[keys[fresh[i]]] = std::move(flats[i]);
    }
    progress.at(1 - 1.0 / (1 + round));
    if (again) continue;
    std::vector<FlatChart> done;
    for (const std::vector<int>& key : keys) done.push_back(std::move(known[key]));
    return done;
  }
}

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

double signed_area(const Triangle& t, const Points& x) {
  return cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]) / 2;
}

/// To the scale at which the whole has the least stretch.
void scale_for_stretch(FlatChart& flat) {
  double area = 0;
  for (const Triangle& t : flat.sheet.triangles) area += signed_area(t, flat.x);
  const double stretch = std::pow(l2_stretch(flat.sheet, flat.x) * flat.sheet.area, 2) / area;
  const double scale = std::pow(stretch / area, 0.25);
  for (Vector2& p : flat.x) p *= scale;
}

PackChart outline_of(const FlatChart& flat) {
  PackChart chart;
  for (const auto& loop : flat.sheet.loops) {
    chart.loops.emplace_back();
    for (const int v : loop) chart.loops.back().push_back(flat.x[v]);
  }
  for (const Triangle& t : flat.sheet.triangles) chart.area += signed_area(t, flat.x);
  return chart;
}

// ---- Figures ----

void measure(const Surface& surface, const Unwrapped& unwrapped, const UnwrapOptions& options,
             UnwrapFigures& figures) {
  const Mesh& mesh = surface.mesh;
  double uv_area = 0, area = 0;
  struct Singular {
    double area, first, second;
  };
  std::vector<Singular> all;
  const Vector2 size(options.width, options.height);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Vector3 a = mesh.position(t, 1) - mesh.position(t, 0);
    const Vector3 b = mesh.position(t, 2) - mesh.position(t, 0);
    const double twice = a.cross(b).norm();
    if (surface.degenerate[t] || !(twice > 0)) continue;
    const auto uv = [&](int k) {
      return Vector2(unwrapped.uvs[unwrapped.corner_uvs[t][k]].cwiseProduct(size));
    };
    Eigen::Matrix2d to, from;
    to << uv(1) - uv(0), uv(2) - uv(0);
    const double length = a.norm();
    from << length, a.dot(b) / length, 0, twice / length;
    const Eigen::Matrix2d J = to * from.inverse();
    const double e = (J(0, 0) + J(1, 1)) / 2, f = (J(0, 0) - J(1, 1)) / 2;
    const double g = (J(1, 0) + J(0, 1)) / 2, h = (J(1, 0) - J(0, 1)) / 2;
    const double q = std::hypot(e, h), r = std::hypot(f, g);
    figures.flipped += to.determinant() <= 0;
    uv_area += std::abs(to.determinant()) / 2;
    area += twice / 2;
    all.push_back({twice / 2, q + r, std::abs(q - r)});
  }
  const double scale = std::sqrt(area / uv_area);
  double stretch = 0;
  for (const Singular& s : all) {
    const double first = s.first * scale, second = std::max(s.second * scale, 1e-12);
    stretch += s.area * 0.5 * (1 / (first * first) + 1 / (second * second));
    figures.triangles.push_back({s.area, first / second,
                                 0.5 * std::pow(std::log(first * second), 2),
                                 0.5 * std::pow(std::log(first / second), 2)});
  }
  figures.l2_stretch = std::sqrt(stretch / area);
  figures.occupancy = uv_area / size.prod();
}

double seam_length(const Surface& surface, const Patchwork& patchwork) {
  double length = 0;
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (surface.twins[h] > h && !patchwork.glued()[h])
      length +=
          (surface.mesh.position(h / 3, (h + 1) % 3) - surface.mesh.position(h / 3, h % 3)).norm();
  return length;
}

// ---- The atlas ----

/// Triangles with two equal vertices, at a corner that a chart has.
void place_collapsed(const Mesh& mesh, Unwrapped& unwrapped) {
  std::vector<int> at_vertex(mesh.positions.size(), -1), chart_at(mesh.positions.size(), -1);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3 && unwrapped.chart[t] >= 0; ++k) {
      at_vertex[mesh.triangles[t][k]] = unwrapped.corner_uvs[t][k];
      chart_at[mesh.triangles[t][k]] = unwrapped.chart[t];
    }
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (unwrapped.chart[t] >= 0) continue;
    int uv = 0;
    for (const int v : mesh.triangles[t])
      if (at_vertex[v] >= 0) uv = at_vertex[v], unwrapped.chart[t] = chart_at[v];
    unwrapped.corner_uvs[t] = {uv, uv, uv};
    unwrapped.chart[t] = std::max(unwrapped.chart[t], 0);
  }
}

}  // namespace

Unwrapped unwrap(const Surface& given, const UnwrapOptions& options, const Progress& progress) {
  require(options.stretch > 1,
          fmt::format("the bound on stretch: found {}, wanted more than 1", options.stretch));
  const Surface surface = normalised(given);
  Unwrapped unwrapped;
  Stopwatch watch;
  double before = 0;
  const auto lap = [&](const char* step) {
    const double now = watch.seconds();
    unwrapped.figures.seconds.push_back({step, now - before});
    before = now;
  };
  const ChartHistory history =
      find_charts(surface, {.stretch = options.stretch}, progress.step("charts", 0.4));
  lap("charts");
  Patchwork patchwork(surface, history.patches.patch, history.patches.count);
  std::vector<FlatChart> flats =
      lay_all_flat(surface, history, options.stretch, patchwork, progress.step("flatten", 0.4));
  lap("flatten");
  std::vector<PackChart> outlines;
  for (FlatChart& flat : flats) {
    scale_for_stretch(flat);
    outlines.push_back(outline_of(flat));
  }
  const Packing packing = pack(outlines,
                               {.width = options.width,
                                .height = options.height,
                                .gutter = options.gutter,
                                .trials = options.trials},
                               progress.step("pack", 0.2));
  lap("pack");
  unwrapped.corner_uvs.resize(surface.mesh.triangles.size());
  unwrapped.chart.assign(surface.mesh.triangles.size(), -1);
  for (std::size_t c = 0; c < flats.size(); ++c) {
    const int base = int(unwrapped.uvs.size());
    const Placement& place = packing.places[c];
    const double cosine = std::cos(place.angle), sine = std::sin(place.angle);
    for (const Vector2& p : flats[c].x) {
      const Vector2 turned(cosine * p.x() - sine * p.y(), sine * p.x() + cosine * p.y());
      const Vector2 texel = packing.scale * turned + place.shift;
      unwrapped.uvs.push_back({texel.x() / options.width, texel.y() / options.height});
    }
    const Sheet& sheet = flats[c].sheet;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
      unwrapped.chart[sheet.sources[i]] = int(c);
      for (int k = 0; k < 3; ++k)
        unwrapped.corner_uvs[sheet.sources[i]][k] = base + sheet.triangles[i][k];
    }
    unwrapped.figures.overlapping += !is_injective(sheet, flats[c].x);
  }
  place_collapsed(surface.mesh, unwrapped);
  unwrapped.figures.charts = int(flats.size());
  unwrapped.figures.seam_length = seam_length(surface, patchwork);
  measure(given, unwrapped, options, unwrapped.figures);
  return unwrapped;
}

}  // namespace mq
