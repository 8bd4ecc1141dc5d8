#include "mq/filter/noise_level.h"

#include <algorithm>
#include <cmath>

#include "mq/filter/detail/noise_blocks.h"

namespace mq {

namespace {

/// Weaker than this, of how far values usually lie from their median, is what the transform of a smooth signal leaves.
constexpr double least_level = 1e-4;

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The median of distances from the median, which a few bright lights do not change.
double usual_distance(const Signal& psi, Eigen::Index channel) {
  std::vector<double> values(std::size_t(psi.rows()));
  for (Eigen::Index i = 0; i < psi.rows(); ++i) values[std::size_t(i)] = psi(i, channel);
  const double middle = median(values);
  for (double& v : values) v = std::abs(v - middle);
  return median(std::move(values));
}

}  // namespace

std::vector<double> noise_levels(const ChartWindows& windows, const Signal& psi, const Progress& progress) {
  const std::vector<NoiseBlocks> blocks = noise_blocks(windows, psi, progress);
  std::vector<double> levels;
  for (int c = 0; c < psi.cols(); ++c) {
    const double found = noise_level(blocks[std::size_t(c)]);
    levels.push_back(found > 0 && found > least_level * usual_distance(psi, c) ? found : 0);
  }
  return levels;
}

}  // namespace mq
