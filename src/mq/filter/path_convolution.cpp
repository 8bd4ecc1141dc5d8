#include "mq/filter/path_convolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {

PathConvolution::PathConvolution(const TexelVectorSpace& vectors, const TraceAtlas& domain, const Vector& z)
    : domain_(domain),
      spacing_(vectors.space().scale().texel_spacing),
      forward_(AtlasFlow::along(domain, vectors.velocities(z))),
      backward_(AtlasFlow::along(domain, vectors.velocities(-z))),
      moves_(std::size_t(vectors.size())) {
  for (int i = 0; i < vectors.size(); ++i) moves_[std::size_t(i)] = z.segment<2>(2 * std::int64_t(i)).squaredNorm() > 0;
}

ConvolvedPaths PathConvolution::draw(const Signal& signal, double length, const Progress& progress) const {
  require(length > 0 && std::isfinite(length), fmt::format("paths of length {} cannot be followed", length));
  require(signal.rows() == domain_.space().size(), "one row per texel is needed");
  const int steps = int(std::clamp(std::ceil(length / spacing_), 1.0, 10000.0));
  const double step = length / steps;
  const std::vector<ChartPlace> starts = domain_.starts().places;
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
  std::vector<int> all(starts.size());
  std::iota(all.begin(), all.end(), 0);
  double weights = 2;  // 1 + cos 0
  add(all, starts, weights);
  for (const AtlasFlow* flow : {&forward_, &backward_}) {
    std::vector<ChartPlace> places = starts;
    std::vector<int> paths = all;  // which one is there
    for (int k = 1; k <= steps; ++k) {
      const TracedTexels traced = flow->trace(places, step);
      result.counts = result.counts + traced.counts;
      std::size_t left = 0;
      for (std::size_t n = 0; n < paths.size(); ++n) {
        const bool rests = traced.ends[n] == places[n] && moves_[std::size_t(paths[n])];
        if (traced.circled[n] || rests) continue;
        paths[left] = paths[n];
        places[left++] = traced.ends[n];
      }
      paths.resize(left);
      places.resize(left);
      const double weight = 1 + std::cos(std::numbers::pi * k / (steps + 1));
      add(paths, places, weight);
      weights += weight;
      progress.at(((flow == &forward_ ? 0 : steps) + k) / (2.0 * steps));
    }
  }
  for (Eigen::Index i = 0; i < kept.size(); ++i)
    result.signal.row(i) = mean + result.signal.row(i) / std::max(kept[i], weights / 2);
  return result;
}

}  // namespace mq
