/// With corner 0 at the right angle and sides of length 1 the weights of corners 1 and 2 are
/// coordinates along these sides, and their rates the parts of X: P₀ − P₁ and P₀ − P₂ for X = −∇P.
/// The triangle across a short side is the mirror image in it: it has the same corner 0, and
/// corners 1 and 2 change places.

#include "mq/trace/grid_flow.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/trace/detail/walk.h"

namespace mq {
namespace {

using walk::after;
using walk::before;

/// Paths of one piece of work.
constexpr std::int64_t texel_block = 1024;

constexpr std::int64_t most_pixels = std::int64_t(1) << 27;

}  // namespace

GridFlow::GridFlow(int width, int height) : width_(width), height_(height) {
  require(width >= 2 && height >= 2 && std::int64_t(width) * height <= most_pixels,
          fmt::format("paths are followed on images of 2 x 2 to {} pixels, and this has {} x {}",
                      most_pixels, width, height));
  while ((1 << row_shift_) < width) ++row_shift_;
}

GridFlow GridFlow::downhill(int width, int height, std::vector<double> potential) {
  GridFlow flow(width, height);
  require(std::ssize(potential) == std::int64_t(width) * height &&
              std::ranges::all_of(potential, [](double p) { return std::isfinite(p); }),
          fmt::format("a potential needs a finite value at each of {} x {} pixels", width, height));
  flow.potential_ = std::move(potential);
  return flow;
}

GridFlow GridFlow::along(int width, int height, std::vector<std::array<double, 2>> field) {
  GridFlow flow(width, height);
  require(std::ssize(field) == std::int64_t(width - 1) * (height - 1) &&
              std::ranges::all_of(
                  field, [](const auto& X) { return std::isfinite(X[0]) && std::isfinite(X[1]); }),
          fmt::format("a field needs two finite values in each of {} x {} cells", width - 1,
                      height - 1));
  flow.field_ = std::move(field);
  return flow;
}

GridFlow::Shape GridFlow::shape(int t) const {
  const int s = t & 1, i = column_of(t), j = row_of(t);
  const int odd = (i + j) & 1, right = s ^ odd ^ 1;
  const int horizontal = right ? -1 : 1, vertical = s ? -1 : 1;
  if (odd) return {i + right, j + s, horizontal, 0, 0, vertical};
  return {i + right, j + s, 0, vertical, horizontal, 0};
}

std::array<double, 3> GridFlow::rates(int t) const {
  const Shape at = shape(t);
  double first, second;
  if (field_.empty()) {
    const double P = potential_[pixel(at.column, at.row)];
    first = P - potential_[pixel(at.column + at.column1, at.row + at.row1)];
    second = P - potential_[pixel(at.column + at.column2, at.row + at.row2)];
  } else {
    const auto& X = field_[cell(t)];
    first = X[0] * at.column1 + X[1] * at.row1;
    second = X[0] * at.column2 + X[1] * at.row2;
  }
  return {-(first + second), first, second};
}

int GridFlow::across(int t, int k) const {
  if (k == 0) return 4 * (t ^ 1);
  const Shape at = shape(t);
  const int s = t & 1, i = column_of(t), j = row_of(t);
  // Away from corner k, across the side between corner 0 and the other one.
  const int column = i - (k == 1 ? at.column1 : at.column2), row = j - (k == 1 ? at.row1 : at.row2);
  if (column < 0 || row < 0 || column >= width_ - 1 || row >= height_ - 1) return -1;
  return 4 * triangle(column, row, row == j ? s : 1 - s) + (k == 1 ? 2 : 1);
}

int GridFlow::leave(int t, int k) const {
  const int code = across(t, k);
  return code >= 0 && rates(code >> 2)[code & 3] > 0 ? code : -1;
}

/// Of the weight of corner k + 2 on the edge opposite k, from this side alone.
double GridFlow::slide_rate_from(int t, int k) const {
  const std::array<double, 3> rate = rates(t);
  return k == 0 ? 0.5 * (rate[2] - rate[1]) : k == 1 ? -rate[2] : rate[1];
}

double GridFlow::slide_rate(int t, int k) const {
  const double here = slide_rate_from(t, k);
  const int code = across(t, k);
  if (field_.empty() || code < 0) return here;
  const double pressed = std::max(0.0, -rates(t)[k]),
               against = std::max(0.0, -rates(code >> 2)[code & 3]);
  const double share = pressed + against > 0 ? against / (pressed + against) : 0.5;
  return share * here - (1 - share) * slide_rate_from(code >> 2, code & 3);
}

double GridFlow::speed(int t) const {
  const std::array<double, 3> rate = rates(t);
  return std::hypot(rate[1], rate[2]);
}

/// The fastest way on from the pixel at corner `corner` of triangle t.
std::int64_t GridFlow::exit(int t, int corner) const {
  const Shape place = shape(t);
  const int column = place.column + (corner == 1 ? place.column1 : corner == 2 ? place.column2 : 0);
  const int row = place.row + (corner == 1 ? place.row1 : corner == 2 ? place.row2 : 0);
  std::int64_t best = walk::rest;
  double fastest = 0;
  const auto offer = [&](double speed, int triangle, int k, walk::Way way) {
    if (!walk::faster(speed, fastest)) return;
    fastest = speed;
    best = walk::exit_code(triangle, k, way);
  };
  for (int j = std::max(0, row - 1); j <= std::min(row, height_ - 2); ++j)
    for (int i = std::max(0, column - 1); i <= std::min(column, width_ - 2); ++i)
      for (const int s : {0, 1}) {
        const int u = triangle(i, j, s);
        const Shape at = shape(u);
        const int x = column - at.column, y = row - at.row;
        const int k = x == 0 && y == 0                  ? 0
                      : x == at.column1 && y == at.row1 ? 1
                      : x == at.column2 && y == at.row2 ? 2
                                                        : -1;
        if (k < 0) continue;
        const int next = after(k), previous = before(k);
        const std::array<double, 3> rate = rates(u);
        if (rate[next] >= 0 && rate[previous] >= 0) offer(speed(u), u, k, walk::Way::face);
        const auto length = [](int opposite) { return opposite == 0 ? std::sqrt(2.0) : 1.0; };
        const auto presses = [&](int opposite) {
          return rate[opposite] <= 0 && leave(u, opposite) < 0;
        };
        if (presses(previous))
          offer(slide_rate(u, previous) * length(previous), u, k, walk::Way::edge_to_next);
        if (presses(next))
          offer(-slide_rate(u, next) * length(next), u, k, walk::Way::edge_to_previous);
      }
  return best;
}

void GridFlow::prefetch(int t) const {
  if (field_.empty())
    __builtin_prefetch(&potential_[pixel(column_of(t), row_of(t))]);
  else
    __builtin_prefetch(&field_[cell(t)]);
}

std::array<double, 2> GridFlow::place(const SurfacePoint& point) const {
  const Shape at = shape(point.triangle);
  const double first = point.barycentric[1], second = point.barycentric[2];
  return {at.column + first * at.column1 + second * at.column2,
          at.row + first * at.row1 + second * at.row2};
}

SurfacePoint GridFlow::point(double column, double row) const {
  const double x = std::clamp(column, 0.0, width_ - 1.0), y = std::clamp(row, 0.0, height_ - 1.0);
  const int i = std::min(int(x), width_ - 2), j = std::min(int(y), height_ - 2);
  SurfacePoint best;
  for (const int s : {0, 1}) {
    const int t = triangle(i, j, s);
    const Shape at = shape(t);
    const double dx = x - at.column, dy = y - at.row;
    const double first = dx * at.column1 + dy * at.row1, second = dx * at.column2 + dy * at.row2;
    const Vector3 b(1 - first - second, first, second);
    if (best.triangle < 0 || b.minCoeff() > best.barycentric.minCoeff()) best = {t, b};
  }
  best.barycentric = best.barycentric.cwiseMax(0);
  return best;
}

/// Paths 0 to count − 1 in blocks on all threads.
template <class Start, class Finish>
PathCounts GridFlow::run(std::int64_t count, double time, const Start& start, const Finish& finish,
                         const Progress& progress) const {
  require(time >= 0, fmt::format("a path cannot be followed for a time of {}", time));
  std::atomic<std::int64_t> done = 0;
  return parallel_sum(
      count, PathCounts{},
      [&](std::int64_t begin, std::int64_t end) {
        const PathCounts counts = walk::follow(*this, begin, end, time, start, finish, progress);
        progress.at(double(done += end - begin) / double(count));
        return counts;
      },
      texel_block);
}

Traced GridFlow::trace(std::span<const SurfacePoint> starts, double time,
                       const Progress& progress) const {
  for (const SurfacePoint& p : starts)
    require(p.triangle >= 0 && row_of(p.triangle) < height_ - 1 &&
                column_of(p.triangle) < width_ - 1 && p.barycentric.minCoeff() >= 0 &&
                std::abs(p.barycentric.sum() - 1) < 1e-9,
            "a path of an image begins outside it");
  Traced traced;
  traced.ends.resize(starts.size());
  traced.counts = run(
      std::ssize(starts), time,
      [&](walk::Path& path) {
        walk::put_at(*this, path, starts[path.id].triangle, starts[path.id].barycentric);
      },
      [&](const walk::Path& path) {
        traced.ends[path.id] = {path.triangle, {path.b[0], path.b[1], path.b[2]}};
      },
      progress);
  return traced;
}

Traced GridFlow::trace_pixels(double time, const Progress& progress) const {
  std::vector<SurfacePoint> starts(std::size_t(width_) * height_);
  parallel_for(
      height_,
      [&](std::int64_t row) {
        for (int column = 0; column < width_; ++column) {
          const int t = triangle(std::min(column, width_ - 2), std::min(int(row), height_ - 2), 0);
          for (const int u : {t, t ^ 1}) {
            const Shape at = shape(u);
            for (int k = 0; k < 3; ++k) {
              const int x = at.column + (k == 1 ? at.column1 : k == 2 ? at.column2 : 0);
              const int y = at.row + (k == 1 ? at.row1 : k == 2 ? at.row2 : 0);
              if (x == column && y == row) starts[pixel(column, int(row))] = {u, Vector3::Unit(k)};
            }
          }
        }
      },
      16);
  return trace(starts, time, progress);
}

}  // namespace mq
