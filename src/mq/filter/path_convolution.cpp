#include "mq/filter/path_convolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/filter/seam_agreement.h"

namespace mq {

namespace {

/// X/|X|, 0 where X is.
Vector directions(const Vector& z) {
  Vector result = Vector::Zero(z.size());
  for (Eigen::Index i = 0; i < z.size(); i += 2)
    if (const double length = z.segment<2>(i).norm(); length > 0) result.segment<2>(i) = z.segment<2>(i) / length;
  return result;
}

std::vector<std::array<double, 2>> opposite(std::vector<std::array<double, 2>> field) {
  for (auto& [x, y] : field) x = -x, y = -y;
  return field;
}

}  // namespace

PathConvolution::PathConvolution(const TexelVectorSpace& vectors, const TraceAtlas& domain, const Vector& z)
    : PathConvolution(vectors, domain, z, vectors.velocities(directions(z))) {}

PathConvolution::PathConvolution(const TexelVectorSpace& vectors, const TraceAtlas& domain, const Vector& z,
                                 const std::vector<std::array<double, 2>>& along)
    : domain_(domain),
      spacing_(vectors.space().scale().texel_spacing),
      forward_(AtlasFlow::along(domain, along)),
      backward_(AtlasFlow::along(domain, opposite(along))),
      starts_(domain.starts()),
      clear_(std::size_t(vectors.size())) {
  for (std::size_t i = 0; i < clear_.size(); ++i)
    clear_[i] = float(std::min(1.0, z.segment<2>(2 * std::int64_t(i)).norm()));
}

ConvolvedPaths PathConvolution::draw(const Signal& signal, double length, const Progress& progress) const {
  require(length > 0 && std::isfinite(length), fmt::format("paths of length {} cannot be followed", length));
  require(signal.rows() == domain_.space().size(), "one row per texel is needed");
  constexpr double most = 0.9;  // of the work
  const int steps = int(std::clamp(std::ceil(length / spacing_), 1.0, 10000.0));
  const double step = length / steps;
  const Eigen::RowVectorXd mean = signal.colwise().mean();
  ConvolvedPaths result{Signal::Zero(signal.rows(), signal.cols()), {}};
  Vector kept = Vector::Zero(signal.rows());
  const auto add = [&](const std::vector<int>& paths, const std::vector<ChartPlace>& places, double weight) {
    parallel_blocks(std::ssize(places), 4096, [&](std::int64_t begin, std::int64_t end) {
      Signal row(1, signal.cols());
      for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
        domain_.value(signal, places[n], row);
        result.signal.row(paths[n]) += weight * (row - mean);
        kept[paths[n]] += weight;
      }
    });
  };
  std::vector<int> all(starts_.places.size());
  std::iota(all.begin(), all.end(), 0);
  const Progress following = progress.step("follow paths", most);
  double weights = 2;  // 1 + cos 0
  add(all, starts_.places, weights);
  for (const AtlasFlow* flow : {&forward_, &backward_}) {
    std::vector<ChartPlace> places = starts_.places;
    std::vector<int> paths = all;  // which one is there
    for (int k = 1; k <= steps; ++k) {
      const TracedTexels traced = flow->trace(places, step);
      result.counts = result.counts + traced.counts;
      std::size_t left = 0;
      for (std::size_t n = 0; n < paths.size(); ++n) {
        if (traced.circled[n] || traced.ends[n] == places[n]) continue;
        paths[left] = paths[n];
        places[left++] = traced.ends[n];
      }
      paths.resize(left);
      places.resize(left);
      const double weight = 1 + std::cos(std::numbers::pi * k / (steps + 1));
      add(paths, places, weight);
      weights += weight;
      following.at(((flow == &forward_ ? 0 : steps) + k) / (2.0 * steps));
    }
  }
  for (Eigen::Index i = 0; i < kept.size(); ++i)
    result.signal.row(i) = mean + clear_[std::size_t(i)] / std::max(kept[i], weights / 2) * result.signal.row(i);
  // Texels outside charts alone give way, until no difference is left.
  const Signal none = Signal::Zero(signal.rows(), signal.cols());
  result.signal = agree_at_seams(domain_, result.signal, none, Vector::Ones(signal.rows()), starts_.outside,
                                 progress.step("agree at seams", 1 - most));
  progress.at(1);
  return result;
}

}  // namespace mq
