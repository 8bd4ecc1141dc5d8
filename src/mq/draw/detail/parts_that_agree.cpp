#include "mq/draw/detail/parts_that_agree.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mq {
namespace {

struct Sums {
  double count = 0, weight = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;

  void add(const Sums& other) {
    count += other.count, weight += other.weight;
    x += other.x, y += other.y, xx += other.xx, yy += other.yy, xy += other.xy;
  }
  void add(const Compared& one) {
    const double w = one.weight;
    add({1, w, w * one.shown, w * one.agreed, w * one.shown * one.shown, w * one.agreed * one.agreed,
         w * one.shown * one.agreed});
  }

  double correlation(double noise) const {
    const double mx = x / weight, my = y / weight, floor = noise * noise;
    const double across = std::max(0.0, xx / weight - mx * mx), down = std::max(0.0, yy / weight - my * my);
    return std::max(0.0, (xy / weight - mx * my + floor) / std::sqrt((across + floor) * (down + floor)));
  }
};

}  // namespace

std::vector<float> parts_that_agree(std::span<const Compared> compared, int columns, int rows, double noise) {
  constexpr double fewest = 8, nothing = 0.5, all = 0.8;
  std::vector<Sums> cells(std::size_t(columns) * std::size_t(rows)), around(cells.size());
  for (const Compared& one : compared) cells[std::size_t(one.cell)].add(one);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      for (int j = std::max(row - 1, 0); j <= std::min(row + 1, rows - 1); ++j)
        for (int i = std::max(column - 1, 0); i <= std::min(column + 1, columns - 1); ++i)
          around[std::size_t(row * columns + column)].add(cells[std::size_t(j * columns + i)]);
  std::vector<float> result(cells.size(), 1.0F);
  std::vector<std::pair<double, double>> known;  // correlations, and how many places have them
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (cells[k].count > 0 && around[k].count >= fewest && around[k].weight > 0)
      known.emplace_back(around[k].correlation(noise), cells[k].count);
  std::ranges::sort(known);
  double sum = 0, below = 0, usual = 0;
  for (const auto& [correlation, count] : known) sum += count;
  for (const auto& [correlation, count] : known)
    if ((below += count) >= 0.5 * sum) {
      usual = correlation;
      break;
    }
  if (!(usual > 0)) return result;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (around[k].count >= fewest && around[k].weight > 0)
      result[k] = float(std::clamp((around[k].correlation(noise) / usual - nothing) / (all - nothing), 0.0, 1.0));
  return result;
}

}  // namespace mq
