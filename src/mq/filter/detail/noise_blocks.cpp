#include "mq/filter/detail/noise_blocks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr int block_step = 4;
constexpr std::size_t enough_blocks = 64;
constexpr double most_constant = 0.25, most_cut_off = 1.0 / 3;

NoiseBlock transformed(const BlockValues& values) {
  using Matrix8 = Eigen::Matrix<double, block_side, block_side, Eigen::RowMajor>;
  const Eigen::Map<const Matrix8> T(block_cosines().data()), b(values.data());
  const Matrix8 B = (T * b * T.transpose()).cwiseAbs2();
  NoiseBlock block;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j) {
      block.square[std::size_t(i * block_side + j)] = float(B(i, j));
      if (i + j > 0 && i + j < first_high) block.low += B(i, j);
    }
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

void add_blocks(const ChartWindow& window, const Signal& psi, const Signal& range, std::vector<NoiseBlocks>& blocks) {
  std::array<int, block_size> unknowns;
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      if ((window.column + x) % block_step != 0 || (window.row + y) % block_step != 0 ||
          window.own[std::size_t(y * window.width + x)] != 1 || !block_at(window, x, y, unknowns))
        continue;
      double brightness = 0;
      for (const int u : unknowns) brightness += psi(u, 0) / block_size;
      for (int c = 0; c < psi.cols(); ++c) {
        BlockValues values;
        for (int i = 0; i < block_size; ++i) values[std::size_t(i)] = psi(unknowns[std::size_t(i)], c);
        const auto [least, most] = std::ranges::minmax(values);
        const auto ends = std::ranges::count_if(values, [&](double v) { return v == range(0, c) || v == range(1, c); });
        NoiseBlocks& of_channel = blocks[std::size_t(c)];
        if (least == most)
          ++of_channel.constant;
        else if (double(ends) > most_cut_off * block_size)
          ++of_channel.cut_off;
        else {
          of_channel.changing.push_back(transformed(values));
          of_channel.changing.back().brightness = brightness;
        }
      }
    }
}

std::vector<NoiseBlocks> blocks_of(const ChartWindows& windows, const Signal& psi, ChartWindows::Beyond beyond,
                              const Progress& progress) {
  Signal range(2, psi.cols());
  range << psi.colwise().minCoeff(), psi.colwise().maxCoeff();
  std::vector<NoiseBlocks> all(std::size_t(psi.cols()));
  constexpr int at_once = 256;
  for (int first = 0; first < windows.count(); first += at_once) {
    progress.at(double(first) / windows.count());
    const int count = std::min(at_once, windows.count() - first);
    std::vector<std::vector<NoiseBlocks>> found(std::size_t(count), std::vector<NoiseBlocks>(all.size()));
    parallel_for(
        count,
        [&](std::int64_t k) {
          add_blocks(windows.window(first + int(k), block_side - 1, beyond), psi, range, found[std::size_t(k)]);
        },
        1);
    for (const std::vector<NoiseBlocks>& of_window : found)
      for (std::size_t c = 0; c < all.size(); ++c) {
        all[c].changing.insert(all[c].changing.end(), of_window[c].changing.begin(), of_window[c].changing.end());
        all[c].constant += of_window[c].constant;
        all[c].cut_off += of_window[c].cut_off;
      }
  }
  return all;
}

}  // namespace

const BlockValues& block_cosines() {
  static const BlockValues table = [] {
    BlockValues T;
    for (int k = 0; k < block_side; ++k)
      for (int i = 0; i < block_side; ++i)
        T[std::size_t(k * block_side + i)] = std::sqrt((k == 0 ? 1.0 : 2.0) / block_side) *
                                             std::cos(std::numbers::pi * (i + 0.5) * k / block_side);
    return T;
  }();
  return table;
}

std::vector<NoiseBlocks> noise_blocks(const ChartWindows& windows, const Signal& psi, const Progress& progress) {
  std::vector<NoiseBlocks> blocks =
      blocks_of(windows, psi, ChartWindows::Beyond::nothing, progress.step("in charts", 0.9));
  const auto few = [](const NoiseBlocks& b) { return b.changing.size() + b.constant + b.cut_off < enough_blocks; };
  if (std::ranges::any_of(blocks, few))
    blocks = blocks_of(windows, psi, ChartWindows::Beyond::seams, progress.step("over seams", 0.1));
  return blocks;
}

/// The mean of those squares whose i + j is from `first` to `last`.
double mean_of(const BlockValues& square, int first, int last) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j)
      if (i + j >= first && i + j <= last) sum += square[std::size_t(i * block_side + j)], ++count;
  return sum / count;
}

Flattest flattest_of(std::span<const NoiseBlock> blocks, std::size_t count) {
  std::vector<int> order(blocks.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::nth_element(order, order.begin() + std::ptrdiff_t(count - 1), {}, [&](int k) {
    return std::pair(blocks[std::size_t(k)].low, k);
  });
  Flattest found;
  for (std::size_t n = 0; n < count; ++n) {
    const NoiseBlock& block = blocks[std::size_t(order[n])];
    found.brightness += block.brightness / double(count);
    for (std::size_t i = 0; i < found.square.size(); ++i) found.square[i] += double(block.square[i]) / double(count);
  }
  found.low = mean_of(found.square, 1, first_high - 1);
  std::vector<double> high;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j)
      if (i + j >= first_high) high.push_back(found.square[std::size_t(i * block_side + j)]);
  std::ranges::nth_element(high, high.begin() + std::ptrdiff_t(high.size() / 2));
  found.high = high[high.size() / 2];
  return found;
}

Flattest flattest_part(std::span<const NoiseBlock> blocks, double part, std::size_t least) {
  return flattest_of(blocks, std::max(least, std::size_t(part * double(blocks.size()))));
}

double share_of_least(const BlockValues& variance) {
  double sum = 0, squares = 0;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j)
      if (const double v = variance[std::size_t(i * block_side + j)]; i + j > 0 && i + j < first_high)
        sum += v, squares += v * v;
  const double narrow = 2 * squares / (9 * sum * sum);
  constexpr double middle_of_flattest = -1.15;  ///< an eighth of a normal variable is less
  return std::pow(1 - narrow + middle_of_flattest * std::sqrt(narrow), 3);
}

double noise_level(const NoiseBlocks& blocks) {
  const std::size_t count = blocks.changing.size() + blocks.constant + blocks.cut_off;
  if (blocks.changing.size() < least_blocks || double(blocks.constant) >= most_constant * double(count)) return 0;
  return std::sqrt(flattest_part(blocks.changing, flattest).high);
}

}  // namespace mq
