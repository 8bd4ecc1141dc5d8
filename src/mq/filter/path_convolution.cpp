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
      backward_(AtlasFlow::along(domain, vectors.velocities(-z))) {}

ConvolvedPaths PathConvolution::draw(const Signal& signal, double length, const Progress& progress) const {
  require(length > 0 && std::isfinite(length), fmt::format("paths of length {} cannot be followed", length));
  require(signal.rows() == domain_.space().size(), "one row per texel is needed");
  const int steps = int(std::clamp(std::ceil(length / spacing_), 1.0, 10000.0));
  const double step = length / steps;
  const std::vector<ChartPlace> starts = domain_.starts().places;
  const auto looked_up = [&](const std::vector<ChartPlace>& places, double weight, Signal& sum) {
    parallel_blocks(std::ssize(places), 4096, [&](std::int64_t begin, std::int64_t end) {
      Signal row(1, signal.cols());
      for (std::int64_t i = begin; i < end; ++i) {
        domain_.value(signal, places[std::size_t(i)], row);
        sum.row(i) += weight * row;
      }
    });
  };
  ConvolvedPaths result{Signal::Zero(signal.rows(), signal.cols()), {}};
  double weights = 2;  // 1 + cos 0
  looked_up(starts, weights, result.signal);
  for (const AtlasFlow* flow : {&forward_, &backward_}) {
    std::vector<ChartPlace> places = starts, going = starts;
    std::vector<int> path(starts.size());  // which one goes there
    std::iota(path.begin(), path.end(), 0);
    for (int k = 1; k <= steps; ++k) {
      const TracedTexels traced = flow->trace(going, step);
      result.counts = result.counts + traced.counts;
      std::size_t left = 0;
      for (std::size_t n = 0; n < path.size(); ++n) {
        places[std::size_t(path[n])] = traced.ends[n];
        if (traced.circled[n]) continue;
        path[left] = path[n];
        going[left++] = traced.ends[n];
      }
      path.resize(left);
      going.resize(left);
      const double weight = 1 + std::cos(std::numbers::pi * k / (steps + 1));
      looked_up(places, weight, result.signal);
      weights += weight;
      progress.at(((flow == &forward_ ? 0 : steps) + k) / (2.0 * steps));
    }
  }
  result.signal /= weights;
  return result;
}

}  // namespace mq
