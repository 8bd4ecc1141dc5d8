// Of charts with S = Σ A ½(σ₁⁻² + σ₂⁻²) and U = Σ A σ₁σ₂ at scale 1, those of scale s together have
// the squared L² stretch Σ S/s² · Σ U s² / (Σ A)², which is least where s⁴ is proportional to S / U
// (Cauchy and Schwarz): the whole then has the stretch Σ √(S U) / Σ A, the mean of its charts'.

#include "mq/unwrap/flat_charts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

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

FlatChart lay_chart_flat(const Surface& surface, const ChartMerging& merging, int chart,
                         const EdgeLengths* lengths, const Progress& progress) {
  FlatChart flat;
  flat.stretch = std::numeric_limits<double>::infinity();
  flat.sheet = make_sheet(surface, merging.triangles(chart), merging.merged(), lengths);
  flat.x = parametrize(flat.sheet, {}, progress);
  if (!flat.x.empty()) {
    flat.stretch = l2_stretch(flat.sheet, flat.x);
    flat.crossings = crossings(flat.sheet, flat.x, most_crossings);
  }
  return flat;
}

/// What tells a chart from all others: its triangles and where they are not glued.
std::vector<int> signature(const ChartMerging& merging, int chart) {
  std::vector<int> key = merging.triangles(chart);
  std::ranges::sort(key);
  const std::size_t count = key.size();
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k)
      if (!merging.merged()[3 * key[i] + k]) key.push_back(3 * key[i] + k);
  return key;
}

/// The gluing that is to blame for most of a chart's crossings; for other failures its last.
int culprit(const ChartMerging& merging, int chart, const FlatChart& flat) {
  std::map<int, int> blame;
  for (const auto& [a, b] : flat.crossings) ++blame[merging.joint(chart, a / 3, b / 3)];
  int worst = chart;
  for (const auto& [joint, count] : blame)
    if (merging.parts(joint)[0] >= 0 && (worst == chart || count > blame[worst])) worst = joint;
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

double signed_area(const Triangle& t, const Points& x) {
  return cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]) / 2;
}

}  // namespace

std::vector<FlatChart> lay_flat(const Surface& surface, ChartHistory history, double stretch,
                                const EdgeLengths* lengths, ChartMerging& merging,
                                const Progress& progress) {
  const double bound = 1 + detail * (stretch - 1);
  std::vector<char> refused(history.steps.size());
  std::map<std::vector<int>, FlatChart> known;
  for (int round = 1;; ++round) {
    std::vector<int> step_of, charts, fresh;
    merging = replay(surface, history, refused, step_of);
    std::vector<std::vector<int>> keys;
    for (int c = 0; c < merging.chart_count(); ++c) {
      if (!merging.is_whole(c) || merging.triangles(c).empty()) continue;
      charts.push_back(c);
      keys.push_back(signature(merging, c));
      if (!known.contains(keys.back())) fresh.push_back(int(charts.size()) - 1);
    }
    // The large ones first, so that none is left over for one thread at the end.
    std::ranges::stable_sort(fresh, std::ranges::greater{},
                             [&](int i) { return merging.triangles(charts[i]).size(); });
    std::vector<FlatChart> flats(fresh.size());
    parallel_for(
        std::ssize(fresh),
        [&](std::int64_t i) {
          flats[i] = lay_chart_flat(surface, merging, charts[fresh[i]], lengths, progress);
        },
        1);
    bool again = false;
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      const int chart = charts[fresh[i]];
      const FlatChart& flat = flats[i];
      const bool lies_flat = !flat.x.empty() && is_injective(flat.sheet, flat.x);
      if (merging.parts(chart)[0] >= 0 && !(lies_flat && flat.stretch <= bound)) {
        refused[step_of[culprit(merging, chart, flat)]] = 1;
        again = true;
        continue;
      }
      if (merging.parts(chart)[0] < 0 && !(lies_flat && flat.stretch <= most_patch_stretch)) {
        require(merging.triangles(chart).size() > 1, "a triangle cannot be laid flat");
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

void append_uvs(const FlatChart& flat, const Placement& place, double scale, int width, int height,
                std::vector<Vector2>& uvs) {
  const double cosine = std::cos(place.angle), sine = std::sin(place.angle);
  for (const Vector2& p : flat.x) {
    const Vector2 turned(cosine * p.x() - sine * p.y(), sine * p.x() + cosine * p.y());
    const Vector2 texel = scale * turned + place.shift;
    uvs.push_back({texel.x() / width, texel.y() / height});
  }
}

}  // namespace mq
