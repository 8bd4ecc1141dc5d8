#include "mq/evolving/detail/free_texels.h"

#include <algorithm>
#include <cmath>

#include "mq/evolving/detail/filled_hole.h"
#include "mq/unwrap/touched_cells.h"

namespace mq {
namespace {

/// Cells of a window that polygons touch.
std::vector<CellRun> touched_in(std::vector<std::vector<Vector2>> polygons, int left, int low, int width,
                                int height) {
  for (auto& polygon : polygons)
    for (Vector2& p : polygon) p -= Vector2(left, low);
  return touched_cells(polygons, width, height);
}

}  // namespace

FreeTexels::Extent::Extent(const std::vector<Vector2>& points) : low(points[0]), high(points[0]) {
  for (const Vector2& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
}

bool FreeTexels::Extent::meets(const Extent& other, double margin) const {
  return (low.array() - margin < other.high.array()).all() && (other.low.array() - margin < high.array()).all();
}

FreeTexels::FreeTexels(const std::vector<std::vector<Vector2>>& taken, const std::vector<char>& own,
                       const std::vector<Vector2>& points, int width, int height, int gutter)
    : inside_(std::vector<Vector2>{Vector2::Constant((gutter + 1) / 2), Vector2(width, height) - Vector2::Constant((gutter + 1) / 2)}),
      window_(points),
      gutter_(gutter) {
  window_.low = window_.low.cwiseMax(inside_.low).cwiseMin(inside_.high);
  window_.high = window_.high.cwiseMin(inside_.high).cwiseMax(inside_.low);
  // Polygons that leave the window touch its outermost columns too: the gutter around these is not asked for.
  const int margin = gutter + 3;
  left_ = int(std::floor(window_.low.x())) - margin;
  low_ = int(std::floor(window_.low.y())) - margin;
  width_ = int(std::ceil(window_.high.x())) + margin - left_;
  height_ = int(std::ceil(window_.high.y())) + margin - low_;
  marked_.assign(std::size_t(width_) * std::size_t(height_), 0);
  std::vector<std::vector<Vector2>> others;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    const Extent extent(taken[i]);
    if (!extent.meets(window_, gutter + 2)) continue;
    near_.push_back(taken[i]);
    extents_.push_back(extent);
    if (!own[i]) others.push_back(taken[i]);
  }
  mark(others);
}

void FreeTexels::mark(const std::vector<std::vector<Vector2>>& polygons) {
  for (const CellRun& run : touched_in(polygons, left_, low_, width_, height_))
    for (int y = std::max(0, run.row - gutter_); y <= std::min(height_ - 1, run.row + gutter_); ++y) {
      const auto row = marked_.begin() + std::ptrdiff_t(y) * width_;
      std::fill(row + std::max(0, run.begin - gutter_), row + std::min(width_, run.end + gutter_), char(1));
    }
}

bool FreeTexels::fits(const std::vector<Vector2>& triangle) const {
  const Extent extent(triangle);
  if ((extent.low.array() < inside_.low.array()).any() || (extent.high.array() > inside_.high.array()).any())
    return false;
  const int left = int(std::floor(extent.low.x())) - 1, low = int(std::floor(extent.low.y())) - 1;
  const int width = int(std::ceil(extent.high.x())) + 1 - left, height = int(std::ceil(extent.high.y())) + 1 - low;
  for (const CellRun& run : touched_in({triangle}, left, low, width, height)) {
    const auto row = marked_.begin() + std::ptrdiff_t(run.row + low - low_) * width_ + (left - left_);
    if (std::any_of(row + run.begin, row + run.end, [](char cell) { return cell != 0; })) return false;
  }
  for (std::size_t i = 0; i < near_.size(); ++i)
    if (extent.meets(extents_[i], 0) && overlap(triangle, near_[i])) return false;
  return true;
}

void FreeTexels::take(const std::vector<Vector2>& triangle) {
  near_.push_back(triangle);
  extents_.emplace_back(triangle);
}

}  // namespace mq
