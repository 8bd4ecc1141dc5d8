// With a, b the ways from an unknown to two neighbours and Q = (aᵀa, aᵀb; aᵀb, bᵀb)⁻¹, a plane wave
// of speed 1 that passes them at w = (w_a, w_b) passes the unknown at the larger x with
//
//     (w − x·1)ᵀ Q (w − x·1) = 1,
//
// and came from between them where Q (x·1 − w) > 0. That x is the least of w + way over the points between the two, so
// it rises with w_a and w_b; where the wave did not come from between, the straight way from one of them is the least.
// The least of all pairs rises with every neighbour, too: from infinity, in whatever order unknowns are looked at, distances
// end the same. Where aᵀb ≥ 0, a wave from between the two passes both of them before the unknown, x ≥ w_a and x ≥ w_b: of
// such pairs what is nearer never waits for what is farther, and a queue in the order of distance has every unknown once. At
// obtuse angles it may: an unknown that gets nearer after its turn has another one at once, before what is behind it has
// its first. Pairs far beyond a right angle count where no other neighbour lies between.

#include "mq/filter/fast_marching.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"

namespace mq {

namespace {

/// An unknown that gets nearer by less than this of the way to a neighbour has no other turn.
constexpr double enough = 1e-9;

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

/// When the front arrives at an unknown, straight from a neighbour or from between it and another one.
class Arrival {
 public:
  Arrival(const SparseMatrix& A, std::span<const Vector3> places) : A_(A), places_(places) {}

  /// The arrival at i, where that is before `least`, by ways that neighbour `from` has to do with, and of the others those
  /// for which counts(j) is true.
  template <class Counts>
  double operator()(const Vector& w, int i, int from, double least, const Counts& counts) {
    const Near own = near(w, i, from);
    step_ = own.length;
    least = std::min(least, own.w + own.length);
    for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
      const int j = int(it.col());
      if (j == i || j == from || std::min(w[j], own.w) >= least) continue;
      const bool is_behind = std::max(w[j], own.w) >= least;
      if (is_behind && (places_[j] - places_[i]).dot(own.way) >= 0) continue;
      if (it.value() == 0 || w[j] == infinity || !counts(j)) continue;
      const Near other = near(w, i, j);
      least = std::min(least, j > from ? between(i, other, own, least) : between(i, own, other, least));
    }
    return least;
  }

  /// How far it was from the last neighbour that was asked for.
  double step() const { return step_; }

 private:
  Near near(const Vector& w, int i, int j) const {
    const Vector3 way = places_[j] - places_[i];
    return {w[j], way, way.norm()};
  }

  /// When from between two, where that is before `least`.
  double between(int i, const Near& a, const Near& b, double least) const {
    const double x = plane_wave(a, b, least);
    const bool is_wide = x < least && a.way.dot(b.way) < wide_cosine * a.length * b.length;
    return is_wide && parted(i, a, b) ? infinity : x;
  }

  /// Whether another neighbour of i lies between two, seen from it.
  bool parted(int i, const Near& a, const Near& b) const {
    const double aa = a.length * a.length, ab = a.way.dot(b.way), bb = b.length * b.length;
    for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
      const int j = int(it.col());
      if (j == i || it.value() == 0) continue;
      const Vector3 way = places_[j] - places_[i];
      const double ac = a.way.dot(way), bc = b.way.dot(way);
      if (ac * bb - bc * ab > 0 && bc * aa - ac * ab > 0) return true;
    }
    return false;
  }

  const SparseMatrix& A_;
  std::span<const Vector3> places_;
  double step_ = 0;
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
    is_fixed_.assign(std::size_t(A.rows()), 0), is_waiting_ = is_fixed_;
    for (const auto& [i, distance] : fixed) {
      w_[i] = distance;
      is_fixed_[i] = 1;
    }
    for (const auto& [i, distance] : fixed) wait(i);
  }

  /// Gives those that wait their turns, the nearest first, until none does.
  void march() {
    while (!waiting_.empty()) {
      const int i = waiting_.top().second;
      waiting_.pop();
      if (!std::exchange(is_waiting_[i], 0)) continue;
      if (++turns_ % 65536 == 0) progress_.at(double(turns_) / double(turns_ + A_.rows()));
      for (SparseMatrix::InnerIterator it(A_, i); it; ++it)
        if (const int j = int(it.col()); j != i && it.value() != 0 && !is_fixed_[j] && shared_.is_own(j)) come(i, j);
    }
  }

  /// Takes what others found. Says whether anything got nearer by it in any process.
  bool hear() {
    if (shared_.is_alone()) return false;
    Vector now = w_;
    shared_.fill_halo(now);
    double count = 0;
    for (const int i : halo_) {
      if (!(now[i] < w_[i])) continue;
      w_[i] = now[i];
      wait(i);
      ++count;
    }
    return shared_.largest(count) > 0;
  }

  Vector take() { return std::move(w_); }

 private:
  void wait(int i) {
    is_waiting_[i] = 1;
    waiting_.emplace(w_[i], i);
  }

  /// Pairs of i with one that waits are looked at when that one has its turn.
  void come(int i, int j) {
    const double now = arrival_(w_, j, i, w_[j], [&](int other) { return !is_waiting_[other]; });
    if (!(now < w_[j])) return;
    const bool is_more = w_[j] - now > enough * arrival_.step();
    w_[j] = now;
    if (is_more) wait(j);
  }

  using Turn = std::pair<double, int>;

  const SparseMatrix& A_;
  Arrival arrival_;
  const SharedUnknowns& shared_;
  const Progress& progress_;
  std::vector<int> halo_;
  Vector w_;
  std::vector<char> is_fixed_, is_waiting_;
  std::priority_queue<Turn, std::vector<Turn>, std::greater<>> waiting_;  ///< with some that had their turn already
  std::int64_t turns_ = 0;
};

}  // namespace

Vector fast_marching_distances(const SparseMatrix& A, std::span<const Vector3> places,
                               const std::vector<std::pair<int, double>>& fixed,
                               const Progress& progress) {
  return fast_marching_distances(A, places, fixed, SharedUnknowns::alone(), progress);
}

Vector fast_marching_distances(const SparseMatrix& A, std::span<const Vector3> places,
                               const std::vector<std::pair<int, double>>& fixed, const SharedUnknowns& shared,
                               const Progress& progress) {
  Front front(A, places, fixed, shared, progress);
  do front.march();
  while (front.hear());
  return front.take();
}

}  // namespace mq
