#include "mq/unwrap/detail/chart_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

#include "mq/base/infinity.h"
#include "mq/base/parallel.h"
#include "mq/mesh/coarsen.h"
#include "mq/unwrap/detail/chart_patches.h"
#include "mq/unwrap/detail/parametrize.h"

namespace mq {
namespace {

constexpr int relaxations = 6;  // of a union, from its parts

/// Small systems, many at a time.
constexpr Factorisation small = Factorisation::eigen;

/// A chart laid flat.
struct Flat {
  Sheet sheet;
  Points x;
  double energy = infinity;
  double stretch = infinity;
};

Flat measured(Sheet sheet, Points x) {
  Flat flat;
  flat.energy = isometric_energy(sheet, x);
  flat.stretch = l2_stretch(sheet, x);
  flat.sheet = std::move(sheet);
  flat.x = std::move(x);
  return flat;
}

/// Of the box around points.
double diagonal(const Points& x) {
  Vector2 low = Vector2::Constant(infinity), high = -low;
  for (const Vector2& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

Flat lay_patch(const Surface& surface, const std::vector<int>& triangles,
               const std::vector<char>& merged) {
  Sheet sheet = make_sheet(surface, triangles, merged);
  Points x = parametrize(sheet, {.iterations = 4, .factorisation = small});
  if (x.empty()) return {std::move(sheet), {}, infinity, infinity};
  return measured(std::move(sheet), std::move(x));
}

/// A union that is on offer.
struct Offer {
  ChartSeam seam;
  Flat flat;
  double cost = infinity;
};

/// The rigid motion that takes `from` to `to` as well as can be: x → R x + shift.
struct Motion {
  double c = 1, s = 0;
  Vector2 shift = Vector2::Zero();
  Vector2 operator()(const Vector2& p) const {
    return {c * p.x() - s * p.y() + shift.x(), s * p.x() + c * p.y() + shift.y()};
  }
};

Motion fit(const Points& from, const Points& to) {
  Vector2 a = Vector2::Zero(), b = Vector2::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) a += from[i], b += to[i];
  a /= double(from.size());
  b /= double(from.size());
  double c = 0, s = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vector2 p = from[i] - a, q = to[i] - b;
    c += p.dot(q);
    s += p.x() * q.y() - p.y() * q.x();
  }
  const double norm = std::hypot(c, s);
  Motion motion;
  if (norm > 0) motion.c = c / norm, motion.s = s / norm;
  motion.shift = b - (motion(a) - motion.shift);
  return motion;
}

class Gluing {
 public:
  Gluing(const Surface& surface, const SurfacePatches& patches, const ChartSurfaceOptions& options)
      : surface_(surface),
        options_(options),
        merging_(surface, patches.patch, patches.count),
        flats_(patches.count) {}

  void run(const Progress& progress) {
    parallel_for(
        std::ssize(flats_),
        [&](std::int64_t c) {
          flats_[c] = lay_patch(surface_, merging_.triangles(int(c)), merging_.merged());
        },
        1);
    const int patches = int(flats_.size());
    std::vector<ChartSeam> seams;
    for (int c = 0; c < patches; ++c)
      for (ChartSeam& seam : merging_.seams(c))
        if (seam.charts[1] >= c) seams.push_back(std::move(seam));
    offer(std::move(seams));
    for (;;) {
      progress.at(std::min(1.0, double(int(flats_.size()) - patches) / patches));
      const int best = take_best();
      if (best < 0) break;
      Offer taken = std::move(offers_[best]);
      const int fresh = merging_.merge(taken.seam);
      flats_.push_back(std::move(taken.flat));
      merges_.push_back(taken.seam);
      for (const int part : taken.seam.charts) flats_[part] = {};
      offer(merging_.seams(fresh));
    }
  }

  const std::vector<ChartSeam>& merges() const { return merges_; }

 private:
  void offer(std::vector<ChartSeam> seams) {
    const std::size_t begin = offers_.size();
    for (ChartSeam& seam : seams) {
      offers_.emplace_back();
      offers_.back().seam = std::move(seam);
    }
    parallel_for(
        std::ssize(seams), [&](std::int64_t i) { evaluate(offers_[begin + std::size_t(i)]); }, 1);
    for (std::size_t i = begin; i < offers_.size(); ++i)
      if (offers_[i].cost < infinity) queue_.emplace(offers_[i].cost, int(i));
  }

  bool stands(const Offer& offer) const {
    return merging_.is_whole(offer.seam.charts[0]) && merging_.is_whole(offer.seam.charts[1]);
  }

  /// The next offer that still stands and does not overlap itself.
  int take_best() {
    while (!queue_.empty()) {
      const int i = queue_.top().second;
      queue_.pop();
      if (stands(offers_[i]) && is_injective(offers_[i].flat.sheet, offers_[i].flat.x)) return i;
      offers_[i].flat = {};
    }
    return -1;
  }

  void evaluate(Offer& offer) const {
    const auto [first, second] = offer.seam.charts;
    const Flat& a = flats_[first];
    const Flat& b = flats_[second];
    if (!(a.energy < infinity && b.energy < infinity) || merging_.closes(offer.seam)) return;
    if (first != second && a.sheet.area + b.sheet.area > options_.largest * surface_.area) return;
    std::vector<int> triangles = a.sheet.sources;
    if (first != second)
      triangles.insert(triangles.end(), b.sheet.sources.begin(), b.sheet.sources.end());
    std::vector<char> merged = merging_.merged();
    for (const HalfEdge h : merging_.joined(offer.seam)) merged[h] = 1;
    Sheet sheet = make_sheet(surface_, triangles, merged);
    Points x = first == second ? start(a, sheet) : start(offer.seam, a, b, sheet);
    x = as_rigid_as_possible(sheet, std::move(x), relaxations, small);
    Flat flat = measured(std::move(sheet), std::move(x));
    if (!(flat.stretch <= options_.stretch)) return;
    if (first != second && diagonal(flat.x) > options_.longest * std::sqrt(surface_.area)) return;
    const double before = first == second ? a.energy : a.energy + b.energy;
    const double cost = flat.energy - before - options_.seam_cost * offer.seam.length;
    if (first == second && cost >= 0) return;  // a cut that is worth its length
    offer.cost = cost;
    offer.flat = std::move(flat);
  }

  /// The means where two sides of a cut meet.
  static Points start(const Flat& a, const Sheet& sheet) {
    Points x(sheet.vertex_count, Vector2::Zero());
    std::vector<int> uses(sheet.vertex_count);
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        x[sheet.triangles[i][k]] += a.x[a.sheet.triangles[i][k]];
        ++uses[sheet.triangles[i][k]];
      }
    for (std::size_t v = 0; v < x.size(); ++v) x[v] /= uses[v];
    return x;
  }

  /// Both parts, the second turned to fit along the seam, and the means where they meet.
  Points start(const ChartSeam& seam, const Flat& a, const Flat& b, const Sheet& sheet) const {
    std::map<int, std::size_t> place_in_a, place_in_b;
    for (const HalfEdge h : seam.edges) {
      place_in_a[h / 3] = place_in_b[surface_.twins[h] / 3] = 0;
    }
    for (std::size_t i = 0; i < a.sheet.sources.size(); ++i)
      if (const auto at = place_in_a.find(a.sheet.sources[i]); at != place_in_a.end())
        at->second = i;
    for (std::size_t i = 0; i < b.sheet.sources.size(); ++i)
      if (const auto at = place_in_b.find(b.sheet.sources[i]); at != place_in_b.end())
        at->second = i;
    Points from, to;
    for (const HalfEdge h : seam.edges) {
      const HalfEdge twin = surface_.twins[h];
      const Triangle& ta = a.sheet.triangles[place_in_a[h / 3]];
      const Triangle& tb = b.sheet.triangles[place_in_b[twin / 3]];
      from.push_back(b.x[tb[(twin + 1) % 3]]);
      to.push_back(a.x[ta[h % 3]]);
      from.push_back(b.x[tb[twin % 3]]);
      to.push_back(a.x[ta[(h + 1) % 3]]);
    }
    const Motion motion = fit(from, to);
    Points x(sheet.vertex_count, Vector2::Zero());
    std::vector<int> uses(sheet.vertex_count);
    const std::size_t first = a.sheet.triangles.size();
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const int v = sheet.triangles[i][k];
        x[v] +=
            i < first ? a.x[a.sheet.triangles[i][k]] : motion(b.x[b.sheet.triangles[i - first][k]]);
        ++uses[v];
      }
    for (std::size_t v = 0; v < x.size(); ++v) x[v] /= uses[v];
    return x;
  }

  const Surface& surface_;
  ChartSurfaceOptions options_;
  ChartMerging merging_;
  std::vector<Flat> flats_;
  std::vector<Offer> offers_;
  std::vector<ChartSeam> merges_;  // in their order
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

// ---- From the coarsened surface back ----

/// Labels of the finer surface's triangles whose corners, and whose neighbours' corners, all lie on
/// one patch of the coarser; -1 elsewhere.
std::vector<int> cores(const Surface& surface, const CoarsenedSurface& coarse,
                       const std::vector<int>& patch) {
  std::vector<int> vertex_label(surface.mesh.positions.size(), -1);
  for (std::size_t v = 0; v < vertex_label.size(); ++v)
    if (coarse.places[v].triangle >= 0) vertex_label[v] = patch[coarse.places[v].triangle];
  std::vector<int> label(surface.triangle_count(), -1);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const auto [a, b, c] = surface.mesh.triangles[t];
    if (vertex_label[a] == vertex_label[b] && vertex_label[b] == vertex_label[c])
      label[t] = vertex_label[a];
  }
  std::vector<int> core = label;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      if (const HalfEdge twin = surface.twins[3 * t + k]; twin >= 0 && label[twin / 3] != label[t])
        core[t] = -1;
  // A patch without a core keeps what it has.
  std::vector<char> has_core(surface.triangle_count() + 1);
  for (const int l : core)
    if (l >= 0) has_core[l] = 1;
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (label[t] >= 0 && !has_core[label[t]]) core[t] = label[t];
  return core;
}

Vector3 middle(const Surface& surface, const ChartSeam& seam) {
  Vector3 sum = Vector3::Zero();
  double total = 0;
  for (const HalfEdge h : seam.edges) {
    const Vector3& p = surface.mesh.position(h / 3, h % 3);
    const Vector3& q = surface.mesh.position(h / 3, (h + 1) % 3);
    const double length = (q - p).norm();
    sum += length * (p + q) / 2;
    total += length;
  }
  return total > 0 ? Vector3(sum / total) : sum;
}

/// Patches of the finer surface where those of the coarser are, first in their order.
SurfacePatches finer_patches(const Surface& surface, const CoarsenedSurface& coarse,
                             const SurfacePatches& patches) {
  SurfacePatches found = make_discs(surface, cores(surface, coarse, patches.patch));
  std::vector<int> fresh(found.count, -1);  // patches by their number there, the rest behind them
  std::vector<char> taken(patches.count);
  int count = patches.count;
  for (int p = 0; p < found.count; ++p) {
    const int source = found.sources[p];
    const bool main = source >= 0 && source < patches.count && !taken[source];
    if (main) taken[source] = 1;
    fresh[p] = main ? source : count++;
  }
  for (int& p : found.patch)
    if (p >= 0) p = fresh[p];
  found.count = count;
  found.sources.clear();
  return found;
}

}  // namespace

ChartHistory find_charts(const Surface& surface, const ChartSurfaceOptions& options,
                         const Progress& progress) {
  const double spacing = std::sqrt(4 * surface.area / (std::sqrt(3.0) * options.triangles));
  CoarsenedSurface coarse;
  if (spacing > 0) coarse = coarsen(surface, spacing, progress.step("coarsen", 0.2));
  const bool is_coarser = spacing > 0 && coarse.surface.triangle_count() < surface.triangle_count();
  const Surface& working = is_coarser ? coarse.surface : surface;
  ChartHistory history;
  history.patches = make_patches(working, options.patches, progress.step("patches", 0.1));
  Gluing merge_chart(working, history.patches, options);
  merge_chart.run(progress.step("glue", 0.6));
  const int patches = history.patches.count;
  if (is_coarser) history.patches = finer_patches(surface, coarse, history.patches);
  const int shift = history.patches.count - patches;
  for (const ChartSeam& seam : merge_chart.merges()) {
    ChartHistory::Step step{seam.charts, middle(working, seam)};
    for (int& chart : step.charts)
      if (chart >= patches) chart += shift;
    history.steps.push_back(step);
  }
  return history;
}

ChartMerging replay(const Surface& surface, const ChartHistory& history,
                    const std::vector<char>& refused, std::vector<int>& step_of) {
  ChartMerging merging(surface, history.patches.patch, history.patches.count);
  step_of.assign(history.patches.count, -1);
  std::vector<int> chart(history.patches.count);
  for (int p = 0; p < history.patches.count; ++p) chart[p] = merging.triangles(p).empty() ? -1 : p;
  for (std::size_t i = 0; i < history.steps.size(); ++i) {
    const ChartHistory::Step& step = history.steps[i];
    const int a = chart[step.charts[0]], b = chart[step.charts[1]];
    const auto size = [&](int c) { return c < 0 ? 0 : merging.triangles(c).size(); };
    chart.push_back(size(b) > size(a) ? b : a);
    if (a < 0 || b < 0 || (!refused.empty() && refused[i])) continue;
    if ((a == b) != (step.charts[0] == step.charts[1])) continue;
    double nearest = infinity;
    ChartSeam best;
    for (ChartSeam& seam : merging.seams(a)) {
      if (seam.charts[1] != b || merging.closes(seam)) continue;
      const double distance = (middle(surface, seam) - step.middle).norm();
      if (distance < nearest) nearest = distance, best = std::move(seam);
    }
    if (nearest == infinity) continue;
    chart.back() = merging.merge(best);
    step_of.push_back(int(i));
  }
  return merging;
}

}  // namespace mq
