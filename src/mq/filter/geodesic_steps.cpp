#include "mq/filter/geodesic_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/filter/fast_marching.h"
#include "mq/filter/heat_sweeps.h"
#include "mq/linear/dense.h"

namespace mq {
namespace {

/// |∇w| is near 1. Where it is less than this there is no direction but rounding: inside sources,
/// and in the half texel by which a texture ends beyond its last texels.
constexpr float least_gradient = 0.05F;

/// How far heat that does not leave bends what is along a boundary, in √t: e⁻³ is left of it.
constexpr double boundary_lengths = 3;

/// Sources with those around their points, each unknown once at the least of its distances.
class SourceDiscs {
 public:
  SourceDiscs(const SparseMatrix& A, std::span<const Vector3> positions, double spacing, double radius)
      : A_(A), positions_(positions), spacing_(spacing), radius_(radius) {}

  std::vector<GeodesicSource> grown(const std::vector<GeodesicSource>& sources) {
    for (const GeodesicSource& s : sources) {
      add(s.unknown, s.distance);
      if (s.from) grow(s);
    }
    std::vector<GeodesicSource> all;
    for (const auto& [unknown, distance] : distance_) all.push_back({unknown, distance});
    return all;
  }

  double reach(int unknown) const { return radius_ * std::max(spacing_, spacing_around(unknown)); }

 private:
  void add(int unknown, double distance) {
    const auto [at, is_new] = distance_.try_emplace(unknown, distance);
    if (!is_new) at->second = std::min(at->second, distance);
  }

  /// The unknowns that couplings lead to inside the disc, by ways that are not much longer than the
  /// straight one; nothing where they do not lie near a plane.
  void grow(const GeodesicSource& source) {
    const Vector3 centre = *source.from;
    const double radius = reach(source.unknown);
    const auto straight = [&](int i) { return (positions_[std::size_t(i)] - centre).norm(); };
    std::map<int, double> along = {{source.unknown, straight(source.unknown)}};
    std::set<std::pair<double, int>> queue = {{along.begin()->second, source.unknown}};
    while (!queue.empty()) {
      const auto [way, i] = *queue.begin();
      queue.erase(queue.begin());
      if (way > along[i]) continue;
      for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
        const int j = int(it.col());
        if (j == i || it.value() == 0 || straight(j) > radius) continue;
        const double longer = way + (positions_[std::size_t(j)] - positions_[std::size_t(i)]).norm();
        const auto [at, is_new] = along.try_emplace(j, longer);
        if (!is_new && longer >= at->second) continue;
        at->second = longer;
        queue.emplace(longer, j);
      }
    }
    if (!is_flat(along, centre, radius)) return;
    for (const auto& [i, way] : along)
      if (way <= most_detour * straight(i) + spacing_) add(i, straight(i));
  }

  double spacing_around(int i) const {
    double sum = 0;
    int count = 0;
    for (SparseMatrix::InnerIterator it(A_, i); it; ++it) {
      if (it.col() == i || it.value() == 0) continue;
      sum += (positions_[std::size_t(it.col())] - positions_[std::size_t(i)]).norm();
      ++count;
    }
    return count > 0 ? sum / count / ((1 + std::numbers::sqrt2) / 2) : 0;
  }

  bool is_flat(const std::map<int, double>& disc, const Vector3& centre, double radius) const {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const auto& [i, way] : disc) {
      const Vector3 d = positions_[std::size_t(i)] - centre;
      moments += d * d.transpose();
    }
    const Vector3 normal = symmetric_pairs(moments).vectors.col(0);
    return std::ranges::all_of(disc, [&](const auto& entry) {
      return std::abs(normal.dot(positions_[std::size_t(entry.first)] - centre)) <= flatness * radius;
    });
  }

  static constexpr double most_detour = 1.25;  ///< along couplings of a square grid it is 1.08
  static constexpr double flatness = 0.1;

  const SparseMatrix& A_;
  std::span<const Vector3> positions_;
  double spacing_, radius_;
  std::map<int, double> distance_;
};

/// A rising function v of w with |∇v| near 1, where |∇w| is not: near points it is more. Through
/// the means of w and of first distances in steps of w; it turns no gradient.
class EvenSlope {
 public:
  EvenSlope(const Signal& w, const Vector& first, const std::vector<char>& left_out, double step,
            const SharedUnknowns& shared) {
    std::map<std::int64_t, Mean> means;
    for (Eigen::Index i = 0; i < w.rows(); ++i) {
      if (left_out[std::size_t(i)] || !std::isfinite(first[i]) || !shared.is_own(i)) continue;
      Mean& mean = means[std::int64_t(std::floor(w(i, 0) / step))];
      mean.w += w(i, 0), mean.first += first[i], mean.count += 1;
    }
    if (!shared.is_alone()) means = sums_of_all(means, shared);
    for (const auto& [k, mean] : means) {
      const double v = mean.first / mean.count;
      if (nodes_.empty() || v > nodes_.back().second) nodes_.emplace_back(mean.w / mean.count, v);
    }
  }

  double operator()(double w) const {
    if (nodes_.empty()) return w;
    if (w <= nodes_.front().first) return nodes_.front().second + (w - nodes_.front().first);
    if (w >= nodes_.back().first) return nodes_.back().second + (w - nodes_.back().first);
    const auto above = std::ranges::upper_bound(nodes_, w, {}, &std::pair<double, double>::first);
    const auto& [w0, v0] = *(above - 1);
    const auto& [w1, v1] = *above;
    return v0 + (v1 - v0) * (w - w0) / (w1 - w0);
  }

 private:
  struct Mean {
    double w = 0, first = 0, count = 0;
  };

  /// Steps that any process has, from the lowest to the highest.
  static std::map<std::int64_t, Mean> sums_of_all(const std::map<std::int64_t, Mean>& own,
                                                  const SharedUnknowns& shared) {
    double ends[] = {-infinity, -infinity};
    if (!own.empty()) ends[0] = -double(own.begin()->first), ends[1] = double(own.rbegin()->first);
    shared.largest(ends);
    if (!std::isfinite(ends[0])) return {};
    const auto first = std::int64_t(-ends[0]);
    std::vector<double> sums(3 * std::size_t(std::int64_t(ends[1]) - first + 1), 0);
    for (const auto& [k, mean] : own) {
      double* const at = sums.data() + 3 * (k - first);
      at[0] = mean.w, at[1] = mean.first, at[2] = mean.count;
    }
    shared.sum(sums);
    std::map<std::int64_t, Mean> all;
    for (std::size_t k = 0; 3 * k < sums.size(); ++k)
      if (sums[3 * k + 2] > 0) all[first + std::int64_t(k)] = {sums[3 * k], sums[3 * k + 1], sums[3 * k + 2]};
    return all;
  }

  std::vector<std::pair<double, double>> nodes_;
};

/// Which unknowns are so few couplings away from these.
std::vector<char> within_rings(const SparseMatrix& A, std::vector<int> ring, int rings, const SharedUnknowns& shared) {
  std::vector<char> near(std::size_t(A.rows()), 0);
  for (const int i : ring)
    if (shared.is_own(i)) near[std::size_t(i)] = 1;
  const std::vector<int> halo = shared.halo();
  for (int k = 0; k < rings; ++k) {
    if (!shared.is_alone()) {
      const std::vector<char> before = near;
      shared.fill_halo(near);
      for (const int i : halo)
        if (near[std::size_t(i)] && !before[std::size_t(i)]) ring.push_back(i);
    }
    if (!(shared.largest(double(ring.size())) > 0)) break;
    std::vector<int> farther;
    for (const int i : ring)
      for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
        if (it.value() == 0 || near[std::size_t(it.col())] || !shared.is_own(it.col())) continue;
        near[std::size_t(it.col())] = 1;
        farther.push_back(int(it.col()));
      }
    ring = std::move(farther);
  }
  return near;
}

}  // namespace

double mean_spacing(const SignalSpace& space) {
  const SurfaceScale scale = space.scale();
  if (scale.texel_spacing > 0) return scale.texel_spacing;
  return std::sqrt(2 / std::sqrt(3.0) * scale.area / space.size());
}

namespace {

/// How much of the area is stretched how much, e in steps of a quarter of an octave from 1.
class Stretches {
 public:
  void add(double stiffness, double mass) {
    const double half = std::max(1.0, 0.375 * stiffness);  // (e + 1/e) / 2
    const double step = std::round(steps_per_octave * std::log2(half + std::sqrt(half * half - 1)));
    area_[std::size_t(std::clamp(step, 0.0, double(area_.size() - 1)))] += mass;
  }

  void sum(const SharedUnknowns& shared) { shared.sum(area_); }

  /// What this part of the area exceeds.
  double exceeded_by(double part) const {
    double all = 0, more = 0;
    for (const double area : area_) all += area;
    std::size_t step = area_.size();
    while (step > 0 && more <= part * all) more += area_[--step];
    return std::exp2(double(step) / steps_per_octave);
  }

 private:
  static constexpr double steps_per_octave = 4;
  std::array<double, 64> area_{};
};

}  // namespace

double heat_spacing(double spacing, const SparseMatrix& S, const Vector& mass, const SharedUnknowns& shared) {
  constexpr double stretched_part = 0.1, ordinary_stretch = 2;
  Stretches stretches;
  for (Eigen::Index i = 0; i < S.rows(); ++i)
    if (shared.is_own(i)) stretches.add(S.coeff(i, i), mass[i]);
  stretches.sum(shared);
  return spacing * std::sqrt(std::max(1.0, stretches.exceeded_by(stretched_part) / ordinary_stretch));
}

double heat_spacing(const SignalSpace& space, const SparseMatrix& S, const Vector& mass) {
  const double spacing = mean_spacing(space);
  return space.scale().texel_spacing > 0 ? heat_spacing(spacing, S, mass) : spacing;
}

void make_heat_matrix(const Vector& mass, double t, SparseMatrix& S) {
  S *= t;
  S.diagonal() += mass;
}

void require_sources(const std::vector<GeodesicSource>& sources, int size) {
  require(!sources.empty(), "distances need at least one source");
  for (const GeodesicSource& s : sources) {
    require(s.unknown >= 0 && s.unknown < size,
            fmt::format("source {} is none of the {} unknowns", s.unknown, size));
    require(s.distance >= 0 && std::isfinite(s.distance),
            fmt::format("the distance at source {} is {}; it must be finite and not negative",
                        s.unknown, s.distance));
  }
}

std::vector<GeodesicSource> grown_sources(const SparseMatrix& A, std::span<const Vector3> positions,
                                          double spacing, const std::vector<GeodesicSource>& sources,
                                          double radius) {
  return SourceDiscs(A, positions, spacing, radius).grown(sources);
}

double disc_radius(const SparseMatrix& A, std::span<const Vector3> positions, double spacing, int unknown,
                   double radius) {
  return SourceDiscs(A, positions, spacing, radius).reach(unknown);
}

std::vector<float> gradient_lengths(const SignalSpace& space, const Signal& w) {
  std::vector<float> lengths = space.gradient_norms(w);
  for (float& length : lengths) length = std::max(length, least_gradient);
  return lengths;
}

void continue_to_boundary(const GeodesicDomain& domain, const std::vector<GeodesicSource>& sources,
                          const Vector& first, Signal& w, const Progress& progress, const SharedUnknowns& shared) {
  std::vector<char> near =
      within_rings(domain.heat, {domain.boundary.begin(), domain.boundary.end()},
                   int(std::ceil(boundary_lengths * domain.length / domain.spacing)), shared);
  for (const GeodesicSource& s : sources) near[std::size_t(s.unknown)] = 0;
  const EvenSlope even(w, first, near, 2 * domain.length, shared);
  std::vector<std::pair<int, double>> inside;
  for (Eigen::Index i = 0; i < w.rows(); ++i) {
    if (!std::isfinite(first[i]) || !shared.is_own(i)) continue;
    w(i, 0) = even(w(i, 0));
    if (!near[std::size_t(i)]) inside.emplace_back(int(i), w(i, 0));
  }
  const Vector front = fast_marching_distances(domain.heat, domain.positions, inside, shared, progress);
  for (Eigen::Index i = 0; i < w.rows(); ++i)
    if (shared.is_own(i) && near[std::size_t(i)] && std::isfinite(front[i])) w(i, 0) = front[i];
}

HeatDistances heat_distances(const GeodesicDomain& domain, const std::vector<GeodesicSource>& sources,
                             const GeodesicOptions& options, const Progress& progress, const SharedUnknowns& shared) {
  std::vector<std::pair<int, double>> fixed, begin;
  for (const GeodesicSource& s : sources) {
    fixed.emplace_back(s.unknown, -s.distance / domain.length);
    begin.emplace_back(s.unknown, s.distance);
  }
  const Vector guess = fast_marching_distances(domain.heat, domain.positions, begin, shared,
                                               progress.step("front", 0.6)) /
                       -domain.length;
  HeatSweeps heat = sweep_heat(domain.heat, fixed, {options.tolerance, options.max_sweeps}, guess, shared,
                               progress.step("spread heat", 0.3));
  HeatDistances found{.w = Signal(heat.log_u.size(), 1), .sweeps = heat.sweeps, .change = heat.change};
  Signal& w = found.w;
  for (Eigen::Index i = 0; i < w.rows(); ++i)
    w(i, 0) = std::isfinite(heat.log_u[i]) ? -domain.length * heat.log_u[i] : 0;
  heat.log_u = Vector();
  if (shared.largest(double(domain.boundary.size())) > 0)
    continue_to_boundary(domain, sources, -domain.length * guess, w, progress.step("boundary", 0.1), shared);
  if (shared.is_alone()) return found;
  Vector values = w.col(0);
  shared.fill_halo(values);
  w.col(0) = values;
  return found;
}

Signal unit_gradient_moments(const SignalSpace& space, const Signal& w) {
  std::vector<float> factor = gradient_lengths(space, w);
  for (float& f : factor) f = 1 / f;
  return space.weighted_stiffness_times(w, factor);
}

Signal missed_at_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component, int components,
                         const Vector& distance) {
  Signal missed = Signal::Zero(components, 2);
  for (const GeodesicSource& s : sources) {
    missed(component[s.unknown], 0) += distance[s.unknown] - s.distance;
    missed(component[s.unknown], 1) += 1;
  }
  return missed;
}

int meet_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component, const Signal& missed,
                 Vector& distance) {
  int unreached = 0;
  for (Eigen::Index i = 0; i < distance.size(); ++i) {
    const int c = component[i];
    if (missed(c, 1) > 0) {
      distance[i] = std::max(0.0, distance[i] - missed(c, 0) / missed(c, 1));
    } else {
      distance[i] = infinity;
      ++unreached;
    }
  }
  for (const GeodesicSource& s : sources) distance[s.unknown] = s.distance;
  return unreached;
}

int meet_sources(const std::vector<GeodesicSource>& sources, std::span<const int> component,
                 Vector& distance) {
  const int components = component.empty() ? 0 : 1 + *std::ranges::max_element(component);
  return meet_sources(sources, component, missed_at_sources(sources, component, components, distance), distance);
}

}  // namespace mq
