// With a, b the ways from a node to two neighbours, as in fast_marching.cpp. A neighbour that got nearer
// can only change what is farther away than it.

#include "mq/filter/detail/level_fronts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mq/base/parallel.h"
#include "mq/linear/galerkin.h"

namespace mq {
namespace {

constexpr float unreached = std::numeric_limits<float>::infinity();

/// A level below this size is not made coarser: its walk takes no time.
constexpr int few_nodes = 1000;

/// Walks end when nothing is left to be looked at, or after so many.
constexpr int most_walks = 20;

/// A neighbour, its time from some moment on, and the way to it.
struct Candidate {
  float w;
  std::array<float, 3> way;
};

float inner_product(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// When a plane wave of speed 1 that passes a and b gets here; see fast_marching.cpp. Q is without its 1/det.
float wave_between(const Candidate& a, const Candidate& b) {
  const float aa = inner_product(a.way, a.way), ab = inner_product(a.way, b.way), bb = inner_product(b.way, b.way);
  const float det = aa * bb - ab * ab;
  const float s = bb - 2 * ab + aa, t = (bb - ab) * a.w + (aa - ab) * b.w;
  const float r = bb * a.w * a.w - 2 * ab * a.w * b.w + aa * b.w * b.w - det;
  const float root = t * t - s * r;
  const float x = (t + std::sqrt(std::max(0.0F, root))) / s;
  const bool between = (bb * (x - a.w) >= ab * (x - b.w)) & (aa * (x - b.w) >= ab * (x - a.w));
  return between & (det > 1e-5F * aa * bb) & (root >= 0) ? x : unreached;
}

/// Where the nodes of the next level lie: at the unknown that is theirs.
std::vector<Vector3> coarse_positions(const LevelTransfer& P, std::span<const Vector3> fine) {
  std::vector<Vector3> coarse(std::size_t(P.coarse_rows()), Vector3::Zero());
  std::vector<float> most(coarse.size(), 0), sum(coarse.size(), 0);
  std::vector<Vector3> mean(coarse.size(), Vector3::Zero());
  std::array<WeightedIndex, 4> parents;
  for (int i = 0; i < P.fine_rows(); ++i)
    for (int k = 0, count = P.parents(i, parents); k < count; ++k) {
      const auto j = std::size_t(parents[std::size_t(k)].index);
      const float weight = parents[std::size_t(k)].weight;
      mean[j] += double(weight) * fine[std::size_t(i)];
      sum[j] += weight;
      if (weight > most[j]) most[j] = weight, coarse[j] = fine[std::size_t(i)];
    }
  constexpr float own = 0.99F;
  for (std::size_t j = 0; j < coarse.size(); ++j)
    if (most[j] < own && sum[j] > 0) coarse[j] = mean[j] / double(sum[j]);
  return coarse;
}

}  // namespace

LevelFronts::LevelFronts(const SparseMatrix& S, std::span<const Vector3> positions, const Multigrid& multigrid,
                         int most_nodes, const Progress& progress)
    : multigrid_(multigrid) {
  const std::size_t count = multigrid.levels.size();
  positions_.emplace_back(positions.begin(), positions.end());
  SparseMatrix here = S;
  const auto shown = [&](std::size_t l) { progress.at(double(l) / double(count + 1)); };
  for (std::size_t l = 0;; ++l) {
    shown(l);
    const int rows = int(here.rows());
    if (levels_.empty() && (rows <= most_nodes || l == count)) first_ = l;
    if (rows <= most_nodes || l == count) add_level(here, positions_.back());
    if (levels_.empty() && l > 0) between_.emplace_back(rows, 1);
    if (l == count || (rows <= few_nodes && !levels_.empty())) break;
    const LevelTransfer& P = *multigrid.levels[l]->transfer;
    positions_.push_back(coarse_positions(P, positions_.back()));
    SparseMatrix coarse = galerkin(here, P);
    here.swap(coarse);
  }
}

void LevelFronts::add_level(const SparseMatrix& S, std::span<const Vector3> positions) {
  Level& level = levels_.emplace_back();
  const auto n = std::size_t(S.rows());
  level.starts.assign(n + 1, 0);
  double sum = 0;
  for (int i = 0; i < int(n); ++i) {
    double nearest = 0;
    for (SparseMatrix::InnerIterator it(S, i); it; ++it) {
      const int j = int(it.col());
      if (j == i || it.value() == 0) continue;
      const Vector3 way = positions[std::size_t(j)] - positions[std::size_t(i)];
      const double length = way.norm();
      if (!(length > 0)) continue;
      nearest = nearest > 0 ? std::min(nearest, length) : length;
      level.neighbours.push_back({j, float(length), {float(way.x()), float(way.y()), float(way.z())}});
    }
    sum += nearest;
    level.starts[std::size_t(i) + 1] = int(level.neighbours.size());
  }
  level.spacing = n > 0 ? sum / double(n) : 0;
  level.fixed.assign(n, 0), level.stale.assign(n, 0);
  level.places.assign(n, 0);
  level.w = LaneVector(std::int64_t(n), 1);
}

/// From the three neighbours that are nearest by the straight way.
float LevelFronts::arrival(const Level& level, int i) {
  const float* w = level.w.data();
  std::array<float, 3> time = {unreached, unreached, unreached};
  std::array<int, 3> at = {0, 0, 0};
  for (int e = level.starts[i]; e < level.starts[i + 1]; ++e) {
    const float found = w[level.neighbours[e].index] + level.neighbours[e].length;
    // Without branches, which could not be foreseen.
    const bool first = found < time[0], second = found < time[1], third = found < time[2];
    time[2] = second ? time[1] : third ? found : time[2];
    at[2] = second ? at[1] : third ? e : at[2];
    time[1] = first ? time[0] : second ? found : time[1];
    at[1] = first ? at[0] : second ? e : at[1];
    time[0] = first ? found : time[0];
    at[0] = first ? e : at[0];
  }
  if (!(time[1] < unreached)) return time[0];
  const float since = w[level.neighbours[at[0]].index];
  const auto candidate = [&](int k) {
    const Neighbour& to = level.neighbours[at[std::size_t(k)]];
    return Candidate{w[to.index] - since, to.way};
  };
  const Candidate a = candidate(0), b = candidate(1);
  float least = wave_between(a, b);
  if (time[2] < unreached) {
    const Candidate c = candidate(2);
    least = std::min({least, wave_between(b, c), wave_between(c, a)});
  }
  return std::min(time[0], least + since);
}

/// A counting sort of what w says; what is not reached comes last.
void LevelFronts::order_by_distance(Level& level) {
  constexpr int bins = 1 << 13;
  const float* w = level.w.data();
  const int n = int(level.places.size());
  float high = 0;
  for (int i = 0; i < n; ++i)
    if (w[i] < unreached) high = std::max(high, w[i]);
  const float scale = high > 0 ? float(bins - 2) / high : 0;
  std::vector<int> next(bins + 1, 0);
  for (int i = 0; i < n; ++i) {
    const int bin = w[i] < unreached ? int(std::max(0.0F, w[i]) * scale) : bins - 1;
    level.places[i] = bin;
    ++next[bin + 1];
  }
  for (int b = 0; b < bins; ++b) next[b + 1] += next[b];
  level.order.resize(std::size_t(n));
  for (int i = 0; i < n; ++i) level.order[next[level.places[i]]++] = i;
}

/// Along couplings from the fixed ones.
void LevelFronts::order_by_steps(Level& level) {
  level.order.clear();
  std::vector<char> met = level.fixed;
  for (int i = 0; i < int(met.size()); ++i)
    if (met[i]) level.order.push_back(i);
  for (std::size_t k = 0; k < level.order.size(); ++k)
    for (int e = level.starts[level.order[k]]; e < level.starts[level.order[k] + 1]; ++e)
      if (const int j = level.neighbours[e].index; !met[j]) met[j] = 1, level.order.push_back(j);
}

/// From the fixed nodes, all others being infinite: once in the level's order, then what is stale.
void LevelFronts::sweep(Level& level) {
  float* const w = level.w.data();
  std::ranges::fill(level.stale, 1);
  std::vector<int> now_stale;
  for (int walk = 0; walk < most_walks && !level.order.empty(); ++walk) {
    now_stale.clear();
    for (const int i : level.order) {
      level.stale[i] = 0;
      if (level.fixed[i]) continue;
      const float now = arrival(level, i);
      if (!(now < w[i])) continue;
      w[i] = now;
      for (int e = level.starts[i]; e < level.starts[i + 1]; ++e) {
        const int j = level.neighbours[e].index;
        if (!(now < w[j]) || level.fixed[j] || level.stale[j]) continue;
        level.stale[j] = 1;
        now_stale.push_back(j);
      }
    }
    std::ranges::sort(now_stale, {}, [&](int i) { return std::pair(w[i], i); });
    level.order.swap(now_stale);
  }
}

/// The groups on a coarser level: those of its nodes that lie at fixed unknowns, or else those next to them.
std::vector<std::vector<LevelFronts::Fixed>> LevelFronts::lifted(const std::vector<std::vector<Fixed>>& groups,
                                                                 std::size_t to) const {
  const LevelTransfer& P = *multigrid_.levels[to - 1]->transfer;
  std::vector<std::vector<Fixed>> result;
  result.reserve(groups.size());
  std::array<WeightedIndex, 4> parents;
  for (const std::vector<Fixed>& group : groups) {
    std::vector<Fixed> at, beside;
    for (const auto& [i, distance] : group)
      for (int k = 0, count = P.parents(i, parents); k < count; ++k) {
        const int j = parents[std::size_t(k)].index;
        const double step = (positions_[to][std::size_t(j)] - positions_[to - 1][std::size_t(i)]).norm();
        (step == 0 ? at : beside).emplace_back(j, distance + step);
      }
    result.push_back(at.empty() ? std::move(beside) : std::move(at));
  }
  return result;
}

void LevelFronts::run(std::span<const std::vector<Fixed>> groups, LaneVector& distance) {
  std::vector<std::vector<std::vector<Fixed>>> fixed;  // per level of the hierarchy
  fixed.emplace_back(groups.begin(), groups.end());
  for (std::size_t l = 1; l < first_ + levels_.size(); ++l) fixed.push_back(lifted(fixed.back(), l));
  for (std::size_t l = levels_.size(); l-- > 0;) {
    Level& level = levels_[l];
    float* const w = level.w.data();
    const int n = int(level.places.size());
    std::ranges::fill(level.fixed, 0);
    for (const auto& group : fixed[first_ + l])
      for (const auto& [i, d] : group) level.fixed[i] = 1;
    if (l + 1 < levels_.size()) {
      level.w.clear();
      multigrid_.levels[first_ + l]->transfer->prolongate_add(1, levels_[l + 1].w.data(), w);
      order_by_distance(level);
    } else {
      order_by_steps(level);
    }
    std::fill(w, w + n, unreached);
    for (const auto& group : fixed[first_ + l])
      for (const auto& [i, d] : group) w[i] = std::min(w[i], float(d));
    sweep(level);
    for (int i = 0; i < n; ++i)
      if (!(w[i] < unreached)) w[i] = 0;
  }
  const float* from = levels_.front().w.data();
  for (std::size_t l = first_; l-- > 0;) {
    LaneVector& to = l == 0 ? distance : between_[l - 1];
    to.clear();
    multigrid_.levels[l]->transfer->prolongate_add(1, from, to.data());
    from = to.data();
  }
  if (first_ == 0) std::copy(from, from + distance.size(), distance.data());
}

}  // namespace mq
