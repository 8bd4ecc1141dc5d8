// With a, b the ways from an unknown to two neighbours and Q = (aᵀa, aᵀb; aᵀb, bᵀb)⁻¹, a plane wave
// of speed 1 that passes them at w = (w_a, w_b) passes the unknown at the larger x with
//
//     (w − x·1)ᵀ Q (w − x·1) = 1,
//
// and came from between them where Q (x·1 − w) > 0. That x is the least of w + way over the points between the two, so
// it rises with w_a and w_b; where the wave did not come from between, the straight way from one of them is the least.
// The least of all pairs rises with every neighbour, too: sweeps from infinity, in whatever order, end at the same
// distances. Where aᵀb ≥ 0, a wave from between the two passes both of them before the unknown, x ≥ w_a and x ≥ w_b: of such
// pairs what is nearer never waits for what is farther, and one sweep in the order of distance is nearly all. At obtuse
// angles it may, and sweeps go on and on: pairs far beyond a right angle count where no other neighbour lies between.

#include "mq/filter/fast_sweeping.h"

#include <algorithm>
#include <cmath>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"

namespace mq {

namespace {

/// Sweeps end when distances change by less than this of the mean step between neighbours, on
/// average.
constexpr double enough = 1e-9;
constexpr int most_sweeps = 60;

/// Neighbours that are farther apart than this, by the cosine of their angle, have others between them, or the domain ends.
constexpr double least_cosine = -0.5;

/// From here on, 101.5°, pairs between which another one lies are left out. A front that is curved wants those below.
constexpr double wide_cosine = -0.2;

struct Near {
  double w;
  Vector3 way;
  double length;
};

/// Infinite where the wave came from elsewhere: w + way, which is convex between the two, falls from each of them
/// towards the other where it came from between. Or where it is not less than `least`.
double plane_wave(const Near& a, const Near& b, double least) {
  const double ab = a.way.dot(b.way);
  if (ab >= 0 && std::max(a.w, b.w) >= least) return infinity;
  const double aa = a.length * a.length, bb = b.length * b.length, later = b.w - a.w;
  if (!(later * a.length < aa - ab && -later * b.length < bb - ab)) return infinity;
  const double det = aa * bb - ab * ab;
  if (!(det > 1e-6 * aa * bb && ab >= least_cosine * a.length * b.length)) return infinity;
  // Q without its 1/det, times from a's on.
  const double s = bb - 2 * ab + aa, t = (aa - ab) * later;
  const double root = t * t - s * (aa * later * later - det);
  return root >= 0 && s > 0 ? a.w + (t + std::sqrt(root)) / s : infinity;
}

/// Whether another neighbour lies between two, seen from the unknown.
bool parted(const Near& a, const Near& b, std::span<const Near> others) {
  const double aa = a.length * a.length, ab = a.way.dot(b.way), bb = b.length * b.length;
  return std::ranges::any_of(others, [&](const Near& c) {
    const double ac = a.way.dot(c.way), bc = b.way.dot(c.way);
    return ac * bb - bc * ab > 0 && bc * aa - ac * ab > 0;
  });
}

/// When the front arrives at an unknown, from one neighbour or from between two.
class Arrival {
 public:
  Arrival(const SparseMatrix& A, std::span<const Vector3> places) : A_(A), places_(places) {}

  double operator()(const Vector& w, int i) {
    double least = infinity;
    near_.clear();
    for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
      const int j = int(it.col());
      if (j == i || it.value() == 0) continue;
      const Vector3 way = places_[j] - places_[i];
      near_.push_back({w[j], way, way.norm()});
      least = std::min(least, w[j] + near_.back().length);
    }
    for (std::size_t a = 0; a < near_.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (std::min(near_[a].w, near_[b].w) < least) least = std::min(least, between(near_[a], near_[b], least));
    return least;
  }

 private:
  /// When from between two, where that is before `least`.
  double between(const Near& a, const Near& b, double least) const {
    const double x = plane_wave(a, b, least);
    const bool is_wide = x < least && a.way.dot(b.way) < wide_cosine * a.length * b.length;
    return is_wide && parted(a, b, near_) ? infinity : x;
  }

  const SparseMatrix& A_;
  std::span<const Vector3> places_;
  std::vector<Near> near_;
};

}  // namespace

std::vector<int> by_steps(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed) {
  std::vector<int> order;
  std::vector<char> met(std::size_t(A.rows()), 0);
  const auto meet = [&](int i) {
    if (!met[std::size_t(i)]) met[std::size_t(i)] = 1, order.push_back(i);
  };
  for (const auto& [i, value] : fixed) meet(i);
  for (std::size_t k = 0; k < order.size(); ++k)
    for (SparseMatrix::InnerIterator it(A, order[k]); it; ++it)
      if (it.value() != 0) meet(int(it.col()));
  return order;
}

namespace {

class Front {
 public:
  Front(const SparseMatrix& A, std::span<const Vector3> places, const std::vector<std::pair<int, double>>& fixed,
        const SharedUnknowns& shared, const Progress& progress)
      : A_(A), arrival_(A, places), shared_(shared), progress_(progress), halo_(shared.halo()) {
    w_ = Vector::Constant(A.rows(), infinity);
    const auto n = std::size_t(A.rows());
    is_fixed_.assign(n, 0), is_met_.assign(n, 0), stale_.assign(n, 1);
    std::vector<int> begin;
    for (const auto& [i, distance] : fixed) {
      w_[i] = distance;
      is_fixed_[i] = 1;
      if (is_met_[i]) continue;
      is_met_[i] = 1;
      begin.push_back(i);
    }
    count_ = double(begin.size());
    falling_.resize(A.rows());
    reach(std::move(begin));
  }

  /// Takes what others found. Says whether the front got on anywhere, other than by sweeps.
  bool hear() {
    if (shared_.is_alone()) return false;
    const double before = count_;
    reach(heard());
    return shared_.largest(count_ - before) > 0;
  }

  /// Once over all that is reached, in the order of distance. Returns whether that is enough.
  bool sweep() {
    for (const int i : met_) falling_[i] = -w_[i];
    order_.sort(met_, falling_);
    double change = 0;
    for (const int i : order_.order()) {
      check_now_and_then();
      if (!stale_[i]) continue;
      stale_[i] = 0;
      const double now = arrival_(w_, i);
      if (!(now < w_[i])) continue;
      change += w_[i] - now;
      w_[i] = now;
      touch_around(i);
    }
    double sums[] = {change, double(met_.size()), count_};
    shared_.sum(sums);
    const double step = shared_.largest(farthest_) / std::sqrt(sums[2]);  // from one neighbour to the next, or so
    return sums[0] <= enough * step * sums[1];
  }

  Vector take() {
    shared_.fill_halo(w_);
    return std::move(w_);
  }

 private:
  /// Those of the halo that got nearer.
  std::vector<int> heard() {
    Vector now = w_;
    shared_.fill_halo(now);
    std::vector<int> nearer;
    for (const int i : halo_) {
      if (!(now[i] < w_[i])) continue;
      w_[i] = now[i];
      touch_around(i);
      nearer.push_back(i);
    }
    return nearer;
  }

  /// Step by step along couplings to all own that are not reached yet.
  void reach(std::vector<int> ring) {
    while (!ring.empty()) ring = next_ring(ring);
    std::sort(met_.begin(), met_.end());
  }

  std::vector<int> next_ring(const std::vector<int>& ring) {
    std::vector<int> next;
    for (const int i : ring)
      for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
        const int j = int(it.col());
        if (it.value() == 0 || is_met_[j] || !shared_.is_own(j)) continue;
        is_met_[j] = 1;
        next.push_back(j);
      }
    for (const int i : next) {
      check_now_and_then();
      w_[i] = arrival_(w_, i);
      farthest_ = std::max(farthest_, w_[i]);
      met_.push_back(i);
      count_ += 1;
    }
    return next;
  }

  void touch_around(int i) {
    for (SparseMatrix::InnerIterator it(A_, i); it; ++it)
      if (it.col() != i) stale_[it.col()] = 1;
  }

  void check_now_and_then() {
    if (++visits_ % 65536 == 0) progress_.check();
  }

  const SparseMatrix& A_;
  Arrival arrival_;
  const SharedUnknowns& shared_;
  const Progress& progress_;
  std::vector<int> halo_, met_;  ///< own unknowns that are reached and not fixed, ascending
  Vector w_, falling_;
  std::vector<char> is_fixed_, is_met_;
  /// Where nothing around an unknown has changed since it was looked at, nothing would come of it.
  std::vector<char> stale_;
  FallingOrder order_;
  double count_ = 0, farthest_ = 0;  ///< own that are reached, fixed or not; the largest first distance of theirs
  int visits_ = 0;
};

}  // namespace

Vector fast_sweeping_distances(const SparseMatrix& A, std::span<const Vector3> places,
                               const std::vector<std::pair<int, double>>& fixed,
                               const Progress& progress) {
  return fast_sweeping_distances(A, places, fixed, SharedUnknowns::alone(), progress);
}

Vector fast_sweeping_distances(const SparseMatrix& A, std::span<const Vector3> places,
                               const std::vector<std::pair<int, double>>& fixed, const SharedUnknowns& shared,
                               const Progress& progress) {
  Front front(A, places, fixed, shared, progress);
  for (int sweep = 0; sweep < most_sweeps;) {
    const bool got_on = front.hear();
    const bool is_enough = front.sweep();
    if (got_on) continue;  // those do not count
    ++sweep;
    progress.at(1 - 1.0 / (1 + sweep));
    if (is_enough) break;
  }
  return front.take();
}

}  // namespace mq
