// c = Σ_e Σ_ℓ w_ℓ S_e (v^{e,ℓ} − ψ),  e the elements where regions meet, ℓ the regions of its
// corners.
//
// The thesis takes differences z_ij along edges to the weak divergence of Σ z_ij (φ_i ∇φ_j − φ_j ∇φ_i)
// (`SignalSpace::edge_divergence`), with z = 0 across borders: `Borders::level`. That needs integrals over every
// cell; ours needs the stiffness of the cells at borders only, whose positive semidefiniteness bounds
// what comes out. Sums of S_ij z_ij over the rows of S would be cheaper still, but are no field's
// divergence: beside a texel that counts a thousandth of its neighbour they drive it a thousand
// steps away.

#include "mq/filter/stitch.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/filter/weak_unknowns.h"
#include "mq/linear/coupled_pairs.h"

namespace mq {
namespace {

/// A space, its stiffness and where its unknowns lie.
struct Ground {
  const SignalSpace& space;
  const SparseMatrix& stiffness;
  std::span<const Vector3> positions;
};

/// How a region goes on around one of its unknowns.
struct Slope {
  Eigen::Matrix<double, 3, Eigen::Dynamic> gradient;
  Eigen::RowVectorXd most;  ///< per channel the largest step to a neighbour

  /// g·d, and no more than a few steps: where neighbouring charts have texels of very unlike size a
  /// slope of noise would reach far beyond all values.
  Eigen::RowVectorXd along(const Vector3& d) const {
    constexpr double steps = 3;
    return (d.transpose() * gradient).cwiseMax(-steps * most).cwiseMin(steps * most);
  }
};

void require_sizes(const Ground& ground, const Signal& psi, std::span<const int> labels) {
  require(
      ground.stiffness.rows() == psi.rows() && std::ssize(labels) == psi.rows() &&
          std::ssize(ground.positions) == psi.rows(),
      fmt::format("stitching: a signal of {} rows, {} labels, {} positions and a stiffness of {} "
                  "rows do not fit",
                  psi.rows(), labels.size(), ground.positions.size(), ground.stiffness.rows()));
}

/// g minimising Σ_j |ψ_j − ψ_i − g·(x_j − x_i)|² + ε Σ_j |x_j − x_i|² |g|² over neighbours of the
/// same label: what no neighbour shows, the direction of the normal among it, becomes 0.
Slope slope(const Ground& ground, const Signal& psi, std::span<const int> labels, int i) {
  constexpr double epsilon = 1e-6;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Slope result{Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, psi.cols()),
               Eigen::RowVectorXd::Zero(psi.cols())};
  for (SparseMatrix::InnerIterator it(ground.stiffness, i); it; ++it) {
    const int j = int(it.col());
    if (j == i || labels[j] != labels[i]) continue;
    const Vector3 d = ground.positions[j] - ground.positions[i];
    const Eigen::RowVectorXd step = psi.row(j) - psi.row(i);
    normal += d * d.transpose();
    result.gradient += d * step;
    result.most = result.most.cwiseMax(step.cwiseAbs());
  }
  const double size = normal.trace();
  if (!(size > 0)) return {0 * result.gradient, result.most};
  normal.diagonal().array() += epsilon * size;
  result.gradient = normal.llt().solve(result.gradient);
  return result;
}

/// The regions of an element's corners, and how many each has; none where something is unseen or it
/// has no corners.
std::map<int, int> regions_of(const Element& element, std::span<const int> labels) {
  std::map<int, int> counts;
  for (const int i : element.unknowns)
    if (labels[i] == unseen) return {};
  for (const int i : element.own) ++counts[labels[i]];
  return counts;
}

/// Slopes of the corners of mixed elements, by unknown.
std::map<int, Slope> border_slopes(const Ground& ground, const Signal& psi,
                                   std::span<const int> labels) {
  std::vector<char> wanted(labels.size(), 0);
  ground.space.for_each_mixed_element(labels, [&](const Element& element) {
    for (const int i : element.own) wanted[i] = labels[i] != unseen;
  });
  std::vector<int> rows;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i]) rows.push_back(int(i));
  std::vector<Slope> slopes(rows.size());
  parallel_for(
      std::ssize(rows), [&](std::int64_t k) { slopes[k] = slope(ground, psi, labels, rows[k]); },
      64);
  std::map<int, Slope> result;
  for (std::size_t k = 0; k < rows.size(); ++k)
    result.emplace_hint(result.end(), rows[k], std::move(slopes[k]));
  return result;
}

/// The change for regions that go on with the values `beyond(label, j, v)` where it returns true,
/// and elsewhere along their slopes, slope_of(i).
template <class SlopeOf, class Beyond>
Signal change(const Ground& ground, const Signal& psi, std::span<const int> labels, const SlopeOf& slope_of,
              const Beyond& beyond) {
  Signal result = Signal::Zero(psi.rows(), psi.cols());
  Signal d;
  Eigen::RowVectorXd v(psi.cols());
  ground.space.for_each_mixed_element(labels, [&](const Element& element) {
    const auto count = std::ssize(element.unknowns);
    const std::map<int, int> regions = regions_of(element, labels);
    if (regions.empty()) return;
    double corners = 0;
    for (const auto& [label, n] : regions) corners += n;
    d.setZero(count, psi.cols());
    for (const auto& [label, n] : regions)
      for (std::ptrdiff_t k = 0; k < count; ++k) {
        const int j = element.unknowns[k];
        if (labels[j] == label) continue;
        if (!beyond(label, j, v)) {
          v.setZero();
          for (const int i : element.own)
            if (labels[i] == label)
              v += psi.row(i) + slope_of(i).along(ground.positions[j] - ground.positions[i]);
          v /= n;
        }
        d.row(k) += n / corners * (v - psi.row(j));
      }
    for (std::ptrdiff_t k = 0; k < count; ++k)
      for (std::ptrdiff_t m = 0; m < count; ++m)
        result.row(element.unknowns[k]) += element.stiffness[k * count + m] * d.row(m);
  });
  return result;
}

template <class Beyond>
Signal change(const Ground& ground, const Signal& psi, std::span<const int> labels, const Beyond& beyond) {
  require_sizes(ground, psi, labels);
  const std::map<int, Slope> slopes = border_slopes(ground, psi, labels);
  return change(ground, psi, labels, [&](int i) -> const Slope& { return slopes.at(i); }, beyond);
}

Signal change_of_regions(const Ground& ground, const Signal& psi, std::span<const int> labels) {
  return change(ground, psi, labels, [](int, int, auto&) { return false; });
}

Signal change_to_level(const Ground& ground, const Signal& psi, std::span<const int> labels, Borders borders) {
  require_sizes(ground, psi, labels);
  std::vector<std::array<int, 2>> pairs;
  for_each_coupled_pair(ground.stiffness, [&](int i, int j) {
    const bool seen = labels[i] != unseen && labels[j] != unseen;
    if (seen ? labels[i] != labels[j] : borders == Borders::published) pairs.push_back({i, j});
  });
  Signal z(Eigen::Index(pairs.size()), psi.cols());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    z.row(Eigen::Index(k)) = psi.row(pairs[k][0]) - psi.row(pairs[k][1]);
  return ground.space.edge_divergence(pairs, z);
}

void require_partials(std::span<const Partial> partials, const Composite& composite) {
  for (std::size_t k = 0; k < partials.size(); ++k) {
    const Partial& partial = partials[k];
    require(partial.values.rows() == composite.values.rows() &&
                partial.values.cols() == composite.values.cols() &&
                std::ssize(partial.confidence) == composite.values.rows(),
            fmt::format(
                "photograph {} has values of {} × {} and {} confidences: wanted {} × {}, as the "
                "composite has, and one confidence for each row",
                k, partial.values.rows(), partial.values.cols(), partial.confidence.size(),
                composite.values.rows(), composite.values.cols()));
  }
  for (const int label : composite.labels)
    require(label == unseen || (label >= 0 && label < std::ssize(partials)),
            fmt::format(
                "found the label {}, wanted the number of a photograph, 0 to {}, or {} where none "
                "is seen",
                label, partials.size() - 1, unseen));
}

/// `levels` are in the composite's values already, and not in the partials'.
Signal change_of_partials(const Ground& ground, std::span<const Partial> partials,
                          const Composite& composite, const RegionLevels& levels = {}) {
  require_partials(partials, composite);
  return change(ground, composite.values, composite.labels,
                [&](int label, int j, Eigen::RowVectorXd& v) {
                  const bool shown = partials[label].confidence[j] > 0;
                  if (!shown) return false;
                  v = partials[label].values.row(j);
                  levels.raise(label, v);
                  return true;
                });
}

}  // namespace

Signal stitch_regions(const SignalSpace& space, const Signal& psi, std::span<const int> labels) {
  return change_of_regions({space, space.stiffness(), space.positions()}, psi, labels);
}

Signal region_slopes(const SignalSpace& space, const SparseMatrix& stiffness, const Signal& psi,
                     std::span<const int> labels) {
  const std::vector<Vector3> positions = space.positions();
  const Ground ground{space, stiffness, positions};
  require_sizes(ground, psi, labels);
  const Eigen::Index channels = psi.cols();
  Signal rows = Signal::Zero(psi.rows(), 4 * channels);
  for (const auto& [i, slope] : border_slopes(ground, psi, labels)) {
    for (Eigen::Index c = 0; c < channels; ++c) rows.row(i).segment(3 * c, 3) = slope.gradient.col(c).transpose();
    rows.row(i).tail(channels) = slope.most;
  }
  return rows;
}

Signal stitch_regions(const SignalSpace& space, const Signal& psi, std::span<const int> labels, const Signal& slopes) {
  const Eigen::Index channels = psi.cols();
  require(slopes.rows() == psi.rows() && slopes.cols() == 4 * channels && std::ssize(labels) == psi.rows() &&
              space.size() == psi.rows(),
          fmt::format("stitching: slopes of {} × {}, a signal of {} × {}, {} labels and {} unknowns do not fit", slopes.rows(),
                      slopes.cols(), psi.rows(), channels, labels.size(), space.size()));
  const std::vector<Vector3> positions = space.positions();
  const SparseMatrix none;
  const auto slope_of = [&](int i) {
    Slope slope{Eigen::Matrix<double, 3, Eigen::Dynamic>(3, channels), slopes.row(i).tail(channels)};
    for (Eigen::Index c = 0; c < channels; ++c) slope.gradient.col(c) = slopes.row(i).segment(3 * c, 3).transpose();
    return slope;
  };
  return change({space, none, positions}, psi, labels, slope_of, [](int, int, auto&) { return false; });
}

Signal level_borders(const SignalSpace& space, const SparseMatrix& stiffness, const Signal& psi,
                     std::span<const int> labels) {
  return change_to_level({space, stiffness, space.positions()}, psi, labels, Borders::level);
}

Signal stitch_partials(const SignalSpace& space, std::span<const Partial> partials,
                       const Composite& composite) {
  return change_of_partials({space, space.stiffness(), space.positions()}, partials, composite);
}

namespace {

/// A fill may not depend on what is held next to it being held exactly, so a weight of one
/// unknown's area is enough: what is seen yields by about its difference to the next texel, in the
/// solve for the fill only.
double fill_weight(const SignalSpace& space) { return space.scale().area / space.size(); }

/// The elements where what is seen and what is not meet.
class SeenBorder {
 public:
  SeenBorder(const SignalSpace& space, std::span<const int> labels) {
    std::vector<int> sides(labels.begin(), labels.end());
    for (int& side : sides) side = side == unseen;
    space.for_each_mixed_element(sides, [&](const Element& element) {
      parts_.push_back({{element.unknowns.begin(), element.unknowns.end()},
                        {element.stiffness.begin(), element.stiffness.end()}});
    });
  }

  /// result −= Σ S_e φ
  void subtract(const Signal& phi, Signal& result) const {
    for (const auto& [unknowns, stiffness] : parts_)
      for (std::size_t k = 0; k < unknowns.size(); ++k)
        for (std::size_t m = 0; m < unknowns.size(); ++m)
          if (m != k)
            result.row(unknowns[k]) -=
                stiffness[k * unknowns.size() + m] * (phi.row(unknowns[m]) - phi.row(unknowns[k]));
  }

 private:
  struct Part {
    std::vector<int> unknowns;
    std::vector<double> stiffness;
  };
  std::vector<Part> parts_;
};

/// K·φ / w: the screened equation on the elements that are seen altogether.
Signal seen_only(const SparseMatrix& S, const SeenBorder& border, const Vector& mass, double weight,
                 std::span<const int> labels, const Signal& phi) {
  Signal result = Signal::Zero(phi.rows(), phi.cols());
  parallel_for(phi.rows(), [&](std::int64_t i) {
    if (labels[i] == unseen) return;
    result.row(i) = mass[i] / weight * phi.row(i);
    for (SparseMatrix::InnerIterator it(S, i); it; ++it)
      if (it.col() != i) result.row(i) += it.value() * (phi.row(it.col()) - phi.row(i));
  });
  border.subtract(phi, result);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == unseen) result.row(Eigen::Index(i)).setZero();
  return result;
}

/// δ of those that are weak, bounded.
void bound_weak(const SparseMatrix& S, std::span<const int> labels, Signal& delta) {
  std::vector<int> rows(labels.size());
  std::iota(rows.begin(), rows.end(), 0);
  const WeakUnknowns weak(S, S.diagonal(), labels, rows);
  const Signal asked = delta;
  weak.bound(asked, delta);
}

/// Σ_i a_ic b_ic per channel, in fixed blocks.
Eigen::RowVectorXd products(const Signal& a, const Signal& b) {
  return parallel_sum(
      a.rows(), Eigen::RowVectorXd(Eigen::RowVectorXd::Zero(a.cols())),
      [&](std::int64_t begin, std::int64_t end) {
        const auto count = end - begin;
        return Eigen::RowVectorXd(
            a.middleRows(begin, count).cwiseProduct(b.middleRows(begin, count)).colwise().sum());
      });
}

}  // namespace

Stitcher::Stitcher(const SignalSpace& space, double weight, std::vector<int> labels,
                   const SolverFactory& factory, const Progress& progress, Systems systems)
    : space_(space),
      weight_(weight),
      factory_(factory),
      stiffness_(space.stiffness()),
      positions_(space.positions()),
      labels_(std::move(labels)) {
  require(std::ssize(labels_) == space.size(),
          fmt::format("stitching: {} labels, wanted one for each of {} unknowns", labels_.size(),
                      space.size()));
  const bool all = std::ranges::count(labels_, unseen) == 0;
  if (!all) mass_ = space.lumped_mass();
  if (systems == Systems::one_each) return;
  if (!all) filler_ = prepared(fill_weight(space), progress.step("fill", 0.5));
  equation_ = prepared(weight, progress.step("stitch", all ? 1 : 0.5));
}

Stitcher::System Stitcher::prepared(double weight, const Progress& progress) const {
  if (sees_all()) return std::make_shared<ScreenedPoisson>(space_, weight, factory_, progress);
  std::vector<double> seen(labels_.size());
  std::ranges::transform(labels_, seen.begin(), [](int label) { return label == unseen ? 0.0 : 1.0; });
  return std::make_shared<ScreenedPoisson>(space_, weight, std::move(seen), factory_, progress);
}

Stitcher::System Stitcher::equation(const Progress& progress) const {
  return equation_ ? equation_ : prepared(weight_, progress);
}

void Stitcher::regroup(std::vector<int> labels) {
  require(labels.size() == labels_.size(),
          fmt::format("stitching: {} labels, wanted one for each of {} unknowns", labels.size(),
                      labels_.size()));
  require(std::ranges::equal(
              labels, labels_, {}, [](int label) { return label == unseen; },
              [](int label) { return label == unseen; }),
          "other regions must leave unseen what was");
  labels_ = std::move(labels);
}

Signal Stitcher::fill(const Signal& psi, const Progress& progress) const {
  require(psi.rows() == space_.size(),
          fmt::format("stitching: a signal of {} rows, wanted one for each of {} unknowns",
                      psi.rows(), space_.size()));
  if (sees_all()) return psi;
  const System filler = filler_ ? filler_ : prepared(fill_weight(space_), progress.step("prepare", 0.5));
  const Signal smooth = filler->solve(psi, 0, progress.step("solve", 0.5)).signal;
  Signal result = psi;
  for (std::size_t i = 0; i < labels_.size(); ++i)
    if (labels_[i] == unseen) result.row(Eigen::Index(i)) = smooth.row(Eigen::Index(i));
  return result;
}

Signal Stitcher::change(const Signal& psi) const {
  return change_of_regions({space_, stiffness_, positions_}, psi, labels_);
}

Signal Stitcher::change(std::span<const Partial> partials, const Composite& composite) const {
  require(composite.labels == labels_, "the composite must have the labels of the stitcher");
  return change_of_partials({space_, stiffness_, positions_}, partials, composite);
}

Signal Stitcher::change(const Signal& psi, const BeyondBorders& beyond) const {
  return mq::change({space_, stiffness_, positions_}, psi, labels_,
                    [&](int label, int j, Eigen::RowVectorXd& v) { return beyond.find(label, j, v); });
}

/// Conjugate gradients on K·δ = w·change, preconditioned by the prepared equation of the whole
/// surface, whose δ is harmonic where nothing is seen; a surface with a hole and one without are
/// so alike (A⁻¹K has eigenvalues around ½ to 1) that a few rounds do.
Filtered Stitcher::solve(const Signal& psi, const Signal& change, const Progress& progress) const {
  const Signal zero = Signal::Zero(psi.rows(), psi.cols());
  const auto changed = [&](const Signal& delta) -> Signal {
    Signal bounded = delta;
    bound_weak(stiffness_, labels_, bounded);
    return psi + bounded;
  };
  const System equation = this->equation(progress);
  if (sees_all() || weight_ == 0) {
    Filtered result = equation->solve_change(zero, change, progress);
    result.signal = changed(result.signal);
    return result;
  }
  constexpr int most_rounds = 8;
  constexpr double enough = 1e-4;
  const SeenBorder border(space_, labels_);
  Filtered result = equation->solve_change(zero, change, progress.step("round 1", 0.3));
  Signal x = zero, r = change, p = result.signal;
  Eigen::RowVectorXd rz = products(r, p);
  const double aim = enough * enough * r.squaredNorm();
  for (int round = 2; round <= most_rounds && r.squaredNorm() > aim; ++round) {
    const Signal q = seen_only(stiffness_, border, mass_, weight_, labels_, p);
    const Eigen::RowVectorXd pq = products(p, q);
    const auto ratio = [](double a, double b) { return a > 0 && b > 0 ? a / b : 0; };
    const Eigen::RowVectorXd step = rz.binaryExpr(pq, ratio);
    x += p * step.asDiagonal();
    r -= q * step.asDiagonal();
    const Signal z =
        equation->solve_change(zero, r, progress.step("round " + std::to_string(round), 0.1))
            .signal;
    const Eigen::RowVectorXd next = products(r, z);
    p = z + p * next.binaryExpr(rz, ratio).asDiagonal();
    rz = next;
  }
  result.signal = changed(x);
  return result;
}

RegionLevels Stitcher::levels(const Signal& psi, LightLaw law) const {
  return {stiffness_, space_.lumped_mass(), psi, labels_, law};
}

/// argmin E(φ; μ, w, ψ, Σ z_d X_d).
Filtered Stitcher::stitch_as_published(const Signal& psi, const Progress& progress) const {
  const Signal asked = change_to_level({space_, stiffness_, positions_}, psi, labels_, borders_);
  const ScreenedPoisson whole(space_, weight_, factory_, progress.step("prepare", 0.5));
  Filtered result = whole.solve_change(Signal::Zero(psi.rows(), psi.cols()), asked, progress.step("stitch", 0.5));
  bound_weak(stiffness_, labels_, result.signal);
  result.signal += psi;
  return result;
}

Filtered Stitcher::stitch(const Signal& psi, std::span<const Partial> partials, const RegionLevels& levels,
                          const Progress& progress) const {
  const Signal raised = levels.gains().rows() > 0 ? levels.raised(psi, labels_) : psi;
  if (borders_ == Borders::published) return stitch_as_published(raised, progress);
  require(borders_ != Borders::level || sees_all(),
          fmt::format("{} level asks nothing of what no photograph shows, which would leave the rest undetermined there: take "
                      "published, which holds it to the colours it has, or continued",
                      option_name("borders")));
  const Signal filled = fill(raised, progress.step("fill", 0.3));
  const Signal asked =
      borders_ == Borders::level ? change_to_level({space_, stiffness_, positions_}, filled, labels_, borders_)
      : partials.empty() ? change(filled)
                       : change_of_partials({space_, stiffness_, positions_}, partials, {filled, labels_}, levels);
  return solve(filled, asked, progress.step("stitch", 0.7));
}

/// With δ = φ − (ψ + d) the equation asks (M + w·S)·δ = w·(c − S·d). Where nothing is seen ψ, d and δ are
/// harmonic, so that it has no say but by the little that its gradients are asked to stay.
Filtered Stitcher::stitch(const Signal& psi, const BeyondBorders& beyond, const Signal& offset,
                          const Progress& progress) const {
  require(offset.rows() == psi.rows() && offset.cols() == psi.cols(),
          fmt::format("stitching: offsets of {} × {} for a signal of {} × {}", offset.rows(), offset.cols(),
                      psi.rows(), psi.cols()));
  const Eigen::Index channels = psi.cols();
  Signal both(psi.rows(), 2 * channels);
  both << psi, offset;
  both = fill(both, progress.step("fill", 0.4));
  const Signal filled = both.leftCols(channels), d = both.rightCols(channels);
  both.resize(0, 0);
  Signal asked = change(filled, beyond);
  parallel_for(asked.rows(), [&](std::int64_t i) {
    for (SparseMatrix::InnerIterator it(stiffness_, i); it; ++it)
      if (it.col() != i) asked.row(i) -= it.value() * (d.row(it.col()) - d.row(i));
  });
  Filtered result = equation(progress.step("prepare", 0.3))
                        ->solve_change(Signal::Zero(psi.rows(), channels), asked, progress.step("stitch", 0.3));
  bound_weak(stiffness_, labels_, result.signal);
  result.signal += filled + d;
  return result;
}

}  // namespace mq
