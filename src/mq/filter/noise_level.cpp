#include "mq/filter/noise_level.h"

#include <cmath>

#include "mq/filter/detail/noise_blocks.h"

namespace mq {

namespace {

/// Weaker than this, of the deviation of all values, is what the transform of a smooth signal leaves.
constexpr double least_level = 1e-4;

}  // namespace

std::vector<double> noise_levels(const ChartWindows& windows, const Signal& psi, const Progress& progress) {
  const std::vector<NoiseBlocks> blocks = noise_blocks(windows, psi, progress);
  std::vector<double> levels;
  for (int c = 0; c < psi.cols(); ++c) {
    const double found = noise_level(blocks[std::size_t(c)]);
    const Vector around = psi.col(c).array() - psi.col(c).mean();
    levels.push_back(found > least_level * std::sqrt(around.squaredNorm() / double(psi.rows())) ? found : 0);
  }
  return levels;
}

}  // namespace mq
