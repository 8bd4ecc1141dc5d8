#pragma once
/// Blocks of 8 × 8 texels in the frequencies of the cosine transform: what noise is measured in.

#include <array>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/filter/chart_windows.h"
#include "mq/linear/matrix.h"

namespace mq {

inline constexpr int block_side = 8, block_size = block_side * block_side;

/// Frequencies (i, j) of a block are high where i + j is at least this; low before, the mean left out.
inline constexpr int first_high = 9;

/// The flattest so many of all are flat but for noise.
inline constexpr double flattest = 0.05;

/// Fewer blocks say nothing.
inline constexpr std::size_t least_blocks = 8;

/// A value for each place of a block, or for each frequency; row by row.
using BlockValues = std::array<double, block_size>;

struct NoiseBlock {
  double brightness = 0;                   ///< mean of the first channel
  double low = 0;                          ///< squares of low frequencies, summed
  std::array<float, block_size> square{};  ///< of each frequency
};

/// Of one channel.
struct NoiseBlocks {
  std::vector<NoiseBlock> changing;
  std::size_t constant = 0;
  std::size_t cut_off = 0;  ///< a third of the values are the least or the greatest of the channel
};

/// T, orthonormal: B = T·b·Tᵀ holds the frequencies of a block b; all have the variance of b where that is white noise.
const BlockValues& block_cosines();

/// Per channel every fourth block of every fourth row that lies within a chart, and over seams too where charts hold
/// few.
std::vector<NoiseBlocks> noise_blocks(const ChartWindows& windows, const Signal& psi, const Progress& progress);

/// Means of the flattest blocks: those of the least low frequencies.
struct Flattest {
  BlockValues square{};        ///< per frequency
  double brightness = 0;
  double low = 0;         ///< of low frequencies
  double high = 0;        ///< of high ones the median
};

/// Of `count` of them, at least 1.
Flattest flattest_of(std::span<const NoiseBlock> blocks, std::size_t count);

/// Of the flattest part of them.
Flattest flattest_part(std::span<const NoiseBlock> blocks, double part, std::size_t least = least_blocks);

/// The mean over frequencies whose i + j is from `first` to `last`.
double mean_of(const BlockValues& square, int first, int last);

/// What the least quarter of sums over low frequencies holds, of what all hold on average: of squares of noise with these
/// variances. The cube root of a sum is about normal (Wilson and Hilferty).
double share_of_least(const BlockValues& variance);

/// The deviation of noise that is the same everywhere; 0 where there is none.
double noise_level(const NoiseBlocks& blocks);

}  // namespace mq
