#include "mq/filter/region_levels.h"

#include <Eigen/SparseCholesky>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// A difference and how much it counts.
struct Step {
  double value, weight;
};

/// Of at least one.
double weighted_median(std::vector<Step>& steps) {
  std::ranges::sort(steps, {}, &Step::value);
  const double all = std::transform_reduce(steps.begin(), steps.end(), 0.0, std::plus<>(), std::mem_fn(&Step::weight));
  double sum = 0;
  for (const Step& step : steps)
    if ((sum += step.weight) >= all / 2) return step.value;
  return steps.back().value;
}

/// Per two regions that meet, the pairs that are theirs.
using Borders = std::map<std::array<int, 2>, std::vector<Eigen::Index>>;

Borders borders_of(const RegionPairs& pairs) {
  Borders borders;
  for (std::size_t k = 0; k < pairs.regions.size(); ++k) borders[pairs.regions[k]].push_back(Eigen::Index(k));
  return borders;
}

double log_light(double value, LightLaw law) {
  if (law == LightLaw::log) return value;
  return log_from_linear(law == LightLaw::linear ? value : linear_from_srgb(value));
}

/// How much a value says of light, from 0 to 1.
double credence(double value, LightLaw law) {
  constexpr double dark = 0.02, white = 0.99;
  if (law == LightLaw::display && value >= white) return 0;
  const double light = std::abs(law == LightLaw::log       ? linear_from_log(value)
                                : law == LightLaw::display ? linear_from_srgb(value)
                                                           : value);
  return light / (light + dark);
}

/// What a border says of one channel; no pairs: nothing.
struct Said {
  double median = 0, spread = 0, pairs = 0;
};

Said said(const RegionPairs& pairs, const std::vector<Eigen::Index>& border, Eigen::Index channel, LightLaw law) {
  std::vector<Step> steps;
  double count = 0;
  for (const Eigen::Index k : border) {
    const double from = pairs.from(k, channel), to = pairs.to(k, channel);
    const double credible = std::min(credence(from, law), credence(to, law));
    if (!(credible > 0)) continue;
    steps.push_back({log_light(to, law) - log_light(from, law), credible * pairs.weights[std::size_t(k)]});
    count += credible;
  }
  if (steps.empty()) return {};
  const double median = weighted_median(steps);
  for (Step& step : steps) step.value = std::abs(step.value - median);
  return {median, 1.4826 * weighted_median(steps), count};
}

/// The median of their spreads, by pairs: of a border of three pairs its own says little.
double usual_spread(const std::vector<Said>& all) {
  std::vector<Step> spreads;
  for (const Said& one : all) spreads.push_back({one.spread, one.pairs});
  return weighted_median(spreads);
}

/// The minimiser for one channel.
Vector gains_of(const RegionPairs& of, const Borders& borders, Eigen::Index channel, int count, LightLaw law) {
  std::vector<Said> all;
  for (const auto& [sides, border] : borders) all.push_back(said(of, border, channel, law));
  double squares = 0, pairs = 0;
  for (const Said& one : all) squares += one.pairs * one.median * one.median, pairs += one.pairs;
  const double prior = pairs > 0 ? 4 * squares / pairs : 0, usual = usual_spread(all);
  if (!(prior > 0)) return Vector::Zero(count);  // no step anywhere
  std::vector<Eigen::Triplet<double>> entries;
  for (int a = 0; a < count; ++a) entries.emplace_back(a, a, 1 / prior);
  Vector right = Vector::Zero(count);
  auto one = all.begin();
  for (const auto& [sides, border] : borders) {
    const auto [a, b] = sides;
    const Said& step = *one++;
    if (!(step.pairs > 0)) continue;
    const double spread = std::max(step.spread, usual);
    // Nothing is known better than to a hundredth of what it may be.
    const double weight = 1 / std::max(spread * spread * border_stretch / step.pairs, 1e-4 * prior);
    entries.insert(entries.end(), {{a, a, weight}, {b, b, weight}, {a, b, -weight}, {b, a, -weight}});
    right[a] += weight * step.median;
    right[b] -= weight * step.median;
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
}

/// Numbers of the parts of a graph that hang together.
std::vector<int> parts_of(int count, const Borders& borders) {
  std::vector<int> part(std::size_t(count), 0);
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](int a) {
    while (part[std::size_t(a)] != a) a = part[std::size_t(a)] = part[std::size_t(part[std::size_t(a)])];
    return a;
  };
  for (const auto& [sides, border] : borders) part[std::size_t(root(sides[1]))] = root(sides[0]);
  for (int a = 0; a < count; ++a) part[std::size_t(a)] = root(a);
  return part;
}

/// Makes the mean of each part 0.
void centre(const std::vector<int>& part, std::span<const double> areas, Signal& levels) {
  Signal sums = Signal::Zero(levels.rows(), levels.cols());
  std::vector<double> area(areas.size(), 0);
  for (std::size_t a = 0; a < areas.size(); ++a) {
    sums.row(part[a]) += areas[a] * levels.row(Eigen::Index(a));
    area[std::size_t(part[a])] += areas[a];
  }
  for (std::size_t a = 0; a < areas.size(); ++a)
    if (const double all = area[std::size_t(part[a])]; all > 0) levels.row(Eigen::Index(a)) -= sums.row(part[a]) / all;
}

}  // namespace

RegionPairs region_pairs(const SparseMatrix& stiffness, const Signal& psi, std::span<const int> labels,
                         std::span<const int> rows) {
  require(stiffness.rows() == psi.rows() && std::ssize(labels) == psi.rows(),
          fmt::format("exposure of regions: a stiffness of {} rows, a signal of {} rows and {} labels do not fit",
                      stiffness.rows(), psi.rows(), labels.size()));
  RegionPairs pairs;
  std::vector<std::array<int, 2>> unknowns;
  for (const int i : rows)
    for (SparseMatrix::InnerIterator it(stiffness, i); it; ++it) {
      const int j = int(it.col()), a = labels[std::size_t(i)], b = labels[std::size_t(j)];
      if (a >= b || a == unseen || b == unseen || !(it.value() < 0)) continue;
      pairs.regions.push_back({a, b});
      pairs.weights.push_back(-it.value());
      unknowns.push_back({i, j});
    }
  pairs.from.resize(std::ssize(unknowns), psi.cols());
  pairs.to.resize(std::ssize(unknowns), psi.cols());
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    pairs.from.row(Eigen::Index(k)) = psi.row(unknowns[k][0]);
    pairs.to.row(Eigen::Index(k)) = psi.row(unknowns[k][1]);
  }
  return pairs;
}

namespace {

std::vector<int> all_rows(Eigen::Index count) {
  std::vector<int> rows(std::size_t(count), 0);
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

/// The area of each region.
std::vector<double> region_areas(const Vector& mass, std::span<const int> labels) {
  require(mass.size() == std::ssize(labels),
          fmt::format("exposure of regions: {} masses and {} labels do not fit", mass.size(), labels.size()));
  const int count = labels.empty() ? 0 : std::max(0, 1 + *std::ranges::max_element(labels));
  std::vector<double> areas(std::size_t(count), 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] != unseen) areas[std::size_t(labels[i])] += mass[Eigen::Index(i)];
  return areas;
}

}  // namespace

RegionLevels::RegionLevels(const SparseMatrix& stiffness, const Vector& mass, const Signal& psi,
                           std::span<const int> labels, LightLaw law)
    : RegionLevels(region_pairs(stiffness, psi, labels, all_rows(psi.rows())), region_areas(mass, labels), law) {}

RegionLevels::RegionLevels(const RegionPairs& pairs, std::span<const double> areas, LightLaw law) : law_(law) {
  const int count = int(areas.size());
  gains_ = Signal::Zero(count, colour_channels(int(pairs.from.cols())));
  const Borders borders = borders_of(pairs);
  if (borders.empty()) return;
  for (Eigen::Index c = 0; c < gains_.cols(); ++c) gains_.col(c) = gains_of(pairs, borders, c, count, law);
  centre(parts_of(count, borders), areas, gains_);
}

void RegionLevels::raise(int label, Eigen::Ref<Eigen::RowVectorXd> values) const {
  if (label == unseen || gains_.rows() == 0) return;
  for (Eigen::Index c = 0; c < gains_.cols(); ++c) {
    const double gain = gains_(label, c);
    if (gain == 0) continue;
    double& value = values[c];
    if (law_ == LightLaw::log)
      value += gain;
    else if (law_ == LightLaw::linear)
      value *= std::exp(gain);
    else
      value = srgb_from_linear(std::exp(gain) * linear_from_srgb(value));
  }
}

Signal RegionLevels::raised(const Signal& psi, std::span<const int> labels) const {
  Signal result = psi;
  parallel_for(result.rows(), [&](std::int64_t i) {
    Eigen::RowVectorXd row = result.row(i);
    raise(labels[std::size_t(i)], row);
    result.row(i) = row;
  });
  return result;
}

}  // namespace mq
