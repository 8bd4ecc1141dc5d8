// What lies beyond a chart: from the nearest texel whose centre the chart covers, straight on (`AtlasWalk`).

#include "mq/filter/chart_windows.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mq/atlas/coverage.h"
#include "mq/base/parallel.h"

namespace mq {

ChartWindows::ChartWindows(const Surface& surface, const Atlas& atlas, const TexelSpace& space)
    : surface_(surface),
      atlas_(atlas),
      texels_(space.texels()),
      grid_(atlas.textures),
      walk_(surface, atlas),
      unknown_(std::size_t(grid_.texel_count()), -1),
      chart_(texels_.chart),
      triangle_(std::size_t(texels_.size()), -1) {
  for (int k = 0; k < texels_.size(); ++k) {
    const Texels::Place& at = texels_.places[std::size_t(k)];
    unknown_[std::size_t(grid_.texel(at.texture, at.x, at.y))] = k;
  }
  // One that seams alone couple in goes with a neighbour.
  for (int k = 0; k < texels_.size(); ++k) {
    const Texels::Place& at = texels_.places[std::size_t(k)];
    for (int n = 0; n < 9 && chart_[std::size_t(k)] < 0; ++n) {
      const int j = unknown_[std::size_t(grid_.texel(at.texture, at.x + n % 3 - 1, at.y + n / 3 - 1))];
      if (j >= 0) chart_[std::size_t(k)] = texels_.chart[std::size_t(j)];
    }
  }
  const std::vector<Coverage> coverage = texel_coverage(surface, atlas);
  parallel_for(texels_.size(), [&](std::int64_t k) {
    const Texels::Place& at = texels_.places[std::size_t(k)];
    const int t = coverage[std::size_t(at.texture)].triangle(at.x, at.y);
    if (t >= 0 && atlas.chart[std::size_t(t)] == chart_[std::size_t(k)]) triangle_[std::size_t(k)] = t;
  });
  const auto window_of = [&](int k) {
    const Texels::Place& at = texels_.places[std::size_t(k)];
    return std::tuple(at.texture, at.y / side, at.x / side, chart_[std::size_t(k)]);
  };
  order_.resize(std::size_t(texels_.size()));
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::stable_sort(order_, {}, window_of);
  for (std::size_t i = 0; i < order_.size(); ++i)
    if (i == 0 || window_of(order_[i]) != window_of(order_[i - 1])) first_.push_back(int(i));
  first_.push_back(int(order_.size()));
}

bool ChartWindows::is_of(int chart, int texture, int column, int row, int& unknown) const {
  const TextureSize& size = grid_.texture(texture);
  if (column < 0 || row < 0 || column >= size.width || row >= size.height) return false;
  unknown = unknown_[std::size_t(grid_.texel(texture, column, row))];
  return unknown >= 0 && chart_[std::size_t(unknown)] == chart;
}

/// Where an unknown's texel lies in its triangle, whole tiles taken off as for the chart.
AtlasPlace ChartWindows::place_of(int unknown) const {
  const Texels::Place& at = texels_.places[std::size_t(unknown)];
  const int triangle = triangle_[std::size_t(unknown)];
  const TextureSize& size = grid_.texture(at.texture);
  Vector2 middle = Vector2::Zero();
  for (const TexelPoint& p : atlas_.corners[std::size_t(triangle)]) middle += Vector2(p.column(), p.row()) / 3;
  const Vector2 place(at.x, at.y), tile(size.width, size.height);
  return {triangle, place + ((middle - place).cwiseQuotient(tile)).array().round().matrix().cwiseProduct(tile)};
}

int ChartWindows::across_seams(int seed, const Vector2& way) const {
  const std::optional<AtlasPlace> end = walk_(place_of(seed), way);
  if (!end) return -1;
  return unknown_[std::size_t(grid_.texel(surface_.mesh.texture(end->triangle), int(std::lround(end->texel.x())),
                                          int(std::lround(end->texel.y()))))];
}

/// Fills what the chart leaves empty. The nearest texel is handed on from neighbour to neighbour, down and up
/// (Danielsson 1980).
void ChartWindows::look_beyond(ChartWindow& window) const {
  const int width = window.width, height = window.height;
  std::vector<int> seed(window.unknowns.size(), -1);
  for (std::size_t i = 0; i < seed.size(); ++i)
    if (window.own[i] && triangle_[std::size_t(window.unknowns[i])] >= 0) seed[i] = int(i);
  const auto distance = [&](int from, int to) {
    const int dx = from % width - to % width, dy = from / width - to / width;
    return dx * dx + dy * dy;
  };
  const auto hand_on = [&](int x, int y, int dx, int dy) {
    if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) return;
    const int i = y * width + x, other = seed[std::size_t((y + dy) * width + x + dx)];
    int& mine = seed[std::size_t(i)];
    if (other >= 0 && (mine < 0 || distance(other, i) < distance(mine, i))) mine = other;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      for (const auto& [dx, dy] : {std::pair(-1, 0), {-1, -1}, {0, -1}, {1, -1}}) hand_on(x, y, dx, dy);
    for (int x = width - 1; x >= 0; --x) hand_on(x, y, 1, 0);
  }
  for (int y = height - 1; y >= 0; --y) {
    for (int x = width - 1; x >= 0; --x)
      for (const auto& [dx, dy] : {std::pair(1, 0), {1, 1}, {0, 1}, {-1, 1}}) hand_on(x, y, dx, dy);
    for (int x = 0; x < width; ++x) hand_on(x, y, -1, 0);
  }
  for (std::size_t i = 0; i < seed.size(); ++i) {
    if (window.own[i] || seed[i] < 0) continue;
    const int from = seed[i];
    const Vector2 way(int(i) % width - from % width, int(i) / width - from / width);
    window.unknowns[i] = across_seams(window.unknowns[std::size_t(from)], way);
  }
}

ChartWindow ChartWindows::window(int k, int border, Beyond beyond) const {
  const auto unknowns = std::span(order_).subspan(std::size_t(first_[std::size_t(k)]),
                                                  std::size_t(first_[std::size_t(k) + 1] - first_[std::size_t(k)]));
  const Texels::Place& first = texels_.places[std::size_t(unknowns.front())];
  const int chart = chart_[std::size_t(unknowns.front())];
  int left = first.x, right = first.x, top = first.y, bottom = first.y;
  for (const int u : unknowns) {
    const Texels::Place& at = texels_.places[std::size_t(u)];
    left = std::min(left, at.x), right = std::max(right, at.x);
    top = std::min(top, at.y), bottom = std::max(bottom, at.y);
  }
  ChartWindow window;
  window.column = left - border, window.row = top - border;
  window.width = right - left + 1 + 2 * border, window.height = bottom - top + 1 + 2 * border;
  const std::size_t size = std::size_t(window.width) * std::size_t(window.height);
  window.unknowns.assign(size, -1);
  window.own.assign(size, 0);
  bool whole = true;
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(window.width) + std::size_t(x);
      const int column = window.column + x, row = window.row + y;
      int unknown = -1;
      if (is_of(chart, first.texture, column, row, unknown)) {
        window.unknowns[i] = unknown;
        window.own[i] = column / side == first.x / side && row / side == first.y / side ? 1 : 2;
      } else {
        whole = false;
      }
    }
  if (!whole && beyond == Beyond::seams) look_beyond(window);
  return window;
}

}  // namespace mq
