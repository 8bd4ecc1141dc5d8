// B = T·b·Tᵀ,  T the orthonormal cosine transform of 8 values: of white noise of deviation σ all of B are, too.

#include "mq/filter/noise_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr int block_side = 8, block_size = block_side * block_side, block_step = 4, first_high = 9;
constexpr int high_count = 21;  ///< i + j from `first_high` to 14
constexpr std::size_t enough_blocks = 64, least_blocks = 8;
constexpr double flattest = 0.05, most_constant = 0.25, most_cut_off = 1.0 / 3;

/// Weaker than this, of the deviation of all values, is what the transform of a smooth signal leaves.
constexpr double least_level = 1e-4;

struct Block {
  double low = 0;                          ///< energy of low frequencies
  std::array<float, high_count> high{};  ///< squares
};

/// Of one channel.
struct Blocks {
  std::vector<Block> changing;
  std::size_t constant = 0, cut_off = 0;
};

using Square = std::array<double, block_size>;

const Square& cosines() {
  static const Square table = [] {
    Square T;
    for (int k = 0; k < block_side; ++k)
      for (int i = 0; i < block_side; ++i)
        T[std::size_t(k * block_side + i)] = std::sqrt((k == 0 ? 1.0 : 2.0) / block_side) *
                                             std::cos(std::numbers::pi * (i + 0.5) * k / block_side);
    return T;
  }();
  return table;
}

Block transformed(const Square& values) {
  using Matrix8 = Eigen::Matrix<double, block_side, block_side, Eigen::RowMajor>;
  const Eigen::Map<const Matrix8> T(cosines().data()), b(values.data());
  const Matrix8 B = (T * b * T.transpose()).cwiseAbs2();
  Block block;
  int n = 0;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j)
      if (i + j >= first_high)
        block.high[std::size_t(n++)] = float(B(i, j));
      else if (i + j > 0)
        block.low += B(i, j);
  return block;
}

/// The unknowns of a block, none where the surface ends in it.
bool block_at(const ChartWindow& window, int x, int y, std::array<int, block_size>& unknowns) {
  if (x + block_side > window.width || y + block_side > window.height) return false;
  for (int j = 0; j < block_side; ++j)
    for (int i = 0; i < block_side; ++i) {
      const int u = window.unknowns[std::size_t((y + j) * window.width + x + i)];
      if (u < 0) return false;
      unknowns[std::size_t(j * block_side + i)] = u;
    }
  return true;
}

void add_blocks(const ChartWindow& window, const Signal& psi, const Signal& range, std::vector<Blocks>& blocks) {
  std::array<int, block_size> unknowns;
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      if ((window.column + x) % block_step != 0 || (window.row + y) % block_step != 0 ||
          window.own[std::size_t(y * window.width + x)] != 1 || !block_at(window, x, y, unknowns))
        continue;
      for (int c = 0; c < psi.cols(); ++c) {
        Square values;
        for (int i = 0; i < block_size; ++i) values[std::size_t(i)] = psi(unknowns[std::size_t(i)], c);
        const auto [least, most] = std::ranges::minmax(values);
        const auto ends = std::ranges::count_if(values, [&](double v) { return v == range(0, c) || v == range(1, c); });
        Blocks& of_channel = blocks[std::size_t(c)];
        if (least == most)
          ++of_channel.constant;
        else if (double(ends) > most_cut_off * block_size)
          ++of_channel.cut_off;
        else
          of_channel.changing.push_back(transformed(values));
      }
    }
}

std::vector<Blocks> blocks_of(const ChartWindows& windows, const Signal& psi, ChartWindows::Beyond beyond,
                              const Progress& progress) {
  Signal range(2, psi.cols());
  range << psi.colwise().minCoeff(), psi.colwise().maxCoeff();
  std::vector<Blocks> all(std::size_t(psi.cols()));
  constexpr int at_once = 256;
  for (int first = 0; first < windows.count(); first += at_once) {
    progress.at(double(first) / windows.count());
    const int count = std::min(at_once, windows.count() - first);
    std::vector<std::vector<Blocks>> found(std::size_t(count), std::vector<Blocks>(all.size()));
    parallel_for(
        count,
        [&](std::int64_t k) {
          add_blocks(windows.window(first + int(k), block_side - 1, beyond), psi, range, found[std::size_t(k)]);
        },
        1);
    for (const std::vector<Blocks>& of_window : found)
      for (std::size_t c = 0; c < all.size(); ++c) {
        all[c].changing.insert(all[c].changing.end(), of_window[c].changing.begin(), of_window[c].changing.end());
        all[c].constant += of_window[c].constant;
        all[c].cut_off += of_window[c].cut_off;
      }
  }
  return all;
}

double level(Blocks& blocks) {
  const std::size_t count = blocks.changing.size() + blocks.constant + blocks.cut_off;
  if (blocks.changing.size() < least_blocks || double(blocks.constant) >= most_constant * double(count)) return 0;
  const std::size_t flat = std::max(least_blocks, std::size_t(flattest * double(blocks.changing.size())));
  std::vector<int> order(blocks.changing.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::nth_element(order, order.begin() + std::ptrdiff_t(flat - 1), {}, [&](int k) {
    return std::pair(blocks.changing[std::size_t(k)].low, k);
  });
  std::array<double, high_count> mean{};
  for (std::size_t n = 0; n < flat; ++n)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += double(blocks.changing[std::size_t(order[n])].high[i]) / double(flat);
  std::ranges::nth_element(mean, mean.begin() + high_count / 2);
  return std::sqrt(mean[high_count / 2]);
}

}  // namespace

std::vector<double> noise_levels(const ChartWindows& windows, const Signal& psi, const Progress& progress) {
  std::vector<Blocks> blocks = blocks_of(windows, psi, ChartWindows::Beyond::nothing, progress.step("in charts", 0.9));
  const auto few = [](const Blocks& b) { return b.changing.size() + b.constant + b.cut_off < enough_blocks; };
  if (std::ranges::any_of(blocks, few))
    blocks = blocks_of(windows, psi, ChartWindows::Beyond::seams, progress.step("over seams", 0.1));
  std::vector<double> levels;
  for (int c = 0; c < psi.cols(); ++c) {
    const double found = level(blocks[std::size_t(c)]);
    const Vector around = psi.col(c).array() - psi.col(c).mean();
    levels.push_back(found > least_level * std::sqrt(around.squaredNorm() / double(psi.rows())) ? found : 0);
  }
  return levels;
}

}  // namespace mq
