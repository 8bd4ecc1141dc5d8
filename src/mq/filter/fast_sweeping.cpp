// With a, b the ways from an unknown to two neighbours and Q = (aᵀa, aᵀb; aᵀb, bᵀb)⁻¹, a plane wave
// of speed 1 that passes them at w = (w_a, w_b) passes the unknown at the larger x with
//
//     (w − x·1)ᵀ Q (w − x·1) = 1,
//
// and came from between them where Q (x·1 − w) ≥ 0.

#include "mq/filter/fast_sweeping.h"

#include <array>
#include <cmath>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"

namespace mq {

namespace {


/// Sweeps end when distances change by less than this of the mean step between neighbours, on
/// average.
constexpr double enough = 1e-3;
constexpr int most_sweeps = 20;

struct Near {
  double time = infinity;  ///< by the straight way
  double w = 0;
  Vector3 way = Vector3::Zero();
};

double plane_wave(const Near& a, const Near& b) {
  const double aa = a.way.squaredNorm(), ab = a.way.dot(b.way), bb = b.way.squaredNorm();
  const double det = aa * bb - ab * ab;
  if (!(det > 1e-6 * aa * bb)) return infinity;
  const double q11 = bb / det, q12 = -ab / det, q22 = aa / det;
  const double s = q11 + 2 * q12 + q22;
  const double t = (q11 + q12) * a.w + (q12 + q22) * b.w;
  const double r = q11 * a.w * a.w + 2 * q12 * a.w * b.w + q22 * b.w * b.w - 1;
  const double root = t * t - s * r;
  if (!(root >= 0 && s > 0)) return infinity;
  const double x = (t + std::sqrt(root)) / s;
  const double from_a = q11 * (x - a.w) + q12 * (x - b.w),
               from_b = q12 * (x - a.w) + q22 * (x - b.w);
  return from_a >= 0 && from_b >= 0 ? x : infinity;
}

/// From the three neighbours that are nearest by the straight way.
double arrival(const SparseMatrix& A, std::span<const Vector3> places, const Vector& w, int i) {
  std::array<Near, 3> best;
  for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
    const int j = int(it.col());
    if (j == i || it.value() == 0 || !(w[j] < infinity)) continue;
    Near near{0, w[j], places[j] - places[i]};
    near.time = near.w + near.way.norm();
    for (Near& other : best)
      if (near.time < other.time) std::swap(near, other);
  }
  double least = best[0].time;
  for (int k = 0; k < 3; ++k)
    if (best[(k + 1) % 3].time < infinity && best[k].time < infinity)
      least = std::min(least, plane_wave(best[k], best[(k + 1) % 3]));
  return least;
}

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

Vector fast_sweeping_distances(const SparseMatrix& A, std::span<const Vector3> places,
                               const std::vector<std::pair<int, double>>& fixed,
                               const Progress& progress) {
  Vector w = Vector::Constant(A.rows(), infinity);
  std::vector<char> is_fixed(std::size_t(A.rows()), 0);
  for (const auto& [i, distance] : fixed) {
    w[i] = distance;
    is_fixed[i] = 1;
  }
  std::vector<int> met = by_steps(A, fixed);
  double step = 0;
  int visits = 0;
  const auto check_now_and_then = [&] {
    if (++visits % 65536 == 0) progress.check();
  };
  for (const int i : met) {
    check_now_and_then();
    if (is_fixed[i]) continue;
    w[i] = arrival(A, places, w, i);
    step = std::max(step, w[i]);
  }
  step /= std::sqrt(double(met.size()));  // from one neighbour to the next, or so
  std::erase_if(met, [&](int i) { return is_fixed[i]; });
  std::sort(met.begin(), met.end());
  FallingOrder order;
  Vector falling(A.rows());
  // Where nothing around an unknown has changed since it was looked at, nothing would come of it.
  std::vector<char> stale(std::size_t(A.rows()), 1);
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    for (const int i : met) falling[i] = -w[i];
    order.sort(met, falling);
    double change = 0;
    for (const int i : order.order()) {
      check_now_and_then();
      if (!stale[i]) continue;
      stale[i] = 0;
      const double now = arrival(A, places, w, i);
      if (!(now < w[i])) continue;
      change += w[i] - now;
      w[i] = now;
      for (SparseMatrix::InnerIterator it(A, i); it; ++it)
        if (it.col() != i) stale[it.col()] = 1;
    }
    progress.at((sweep + 1.0) / most_sweeps);
    if (change <= enough * step * double(met.size())) break;
  }
  return w;
}

}  // namespace mq
