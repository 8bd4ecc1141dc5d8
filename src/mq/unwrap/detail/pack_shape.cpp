#include "mq/unwrap/detail/pack_shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace mq {
namespace {

Vector2 turned(const Vector2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

/// Bits of cells, a byte each; small.
struct Cells {
  int width, height;
  std::vector<char> bits;
  Cells(int w, int h) : width(w), height(h), bits(std::size_t(w) * h) {}
  char& at(int x, int y) { return bits[std::size_t(y) * width + x]; }
};

std::vector<CellRun> runs_of(const Cells& cells) {
  std::vector<CellRun> runs;
  for (int y = 0; y < cells.height; ++y) {
    const char* row = cells.bits.data() + std::size_t(y) * cells.width;
    for (int x = 0; x < cells.width;) {
      if (!row[x]) {
        ++x;
        continue;
      }
      const int begin = x;
      while (x < cells.width && row[x]) ++x;
      runs.push_back({y, begin, x});
    }
  }
  return runs;
}

/// All cells whose closed square, made wider by `pad`, an edge meets.
void touch(const Vector2& a, const Vector2& b, double pad, Cells& cells) {
  const Vector2 &low = a.y() <= b.y() ? a : b, &high = a.y() <= b.y() ? b : a;
  const int first = std::max(0, int(std::floor(low.y() - pad)));
  const int last = std::min(cells.height - 1, int(std::floor(high.y() + pad)));
  const double slope = high.y() > low.y() ? (high.x() - low.x()) / (high.y() - low.y()) : 0;
  for (int y = first; y <= last; ++y) {
    double from = y - pad <= low.y() ? low.x() : low.x() + slope * (y - pad - low.y());
    double to = y + 1 + pad >= high.y() ? high.x() : low.x() + slope * (y + 1 + pad - low.y());
    if (from > to) std::swap(from, to);
    // A rounding error beyond the texel's side is still the texel's side.
    constexpr double slack = 1e-9;
    const int begin = std::clamp(int(std::floor(from - pad - slack)), 0, cells.width - 1);
    const int end = std::clamp(int(std::floor(to + pad + slack)), 0, cells.width - 1);
    for (int x = begin; x <= end; ++x) cells.at(x, y) = 1;
  }
}

/// Cells whose centre is inside.
void fill(const std::vector<std::vector<Vector2>>& loops, Cells& cells) {
  std::vector<std::vector<double>> crossings(cells.height);
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector2 &p = loop[i], &q = loop[(i + 1) % loop.size()];
      const Vector2 &low = p.y() <= q.y() ? p : q, &high = p.y() <= q.y() ? q : p;
      const int first = std::max(0, int(std::ceil(low.y() - 0.5)));
      for (int y = first; y < cells.height && y + 0.5 < high.y(); ++y)
        crossings[y].push_back(low.x() +
                               (high.x() - low.x()) * (y + 0.5 - low.y()) / (high.y() - low.y()));
    }
  for (int y = 0; y < cells.height; ++y) {
    std::ranges::sort(crossings[y]);
    for (std::size_t i = 0; i + 1 < crossings[y].size(); i += 2) {
      const int begin = std::max(0, int(std::ceil(crossings[y][i] - 0.5)));
      for (int x = begin; x < cells.width && x + 0.5 < crossings[y][i + 1]; ++x) cells.at(x, y) = 1;
    }
  }
}

Cells widened(const Cells& cells, int by) {
  Cells rows(cells.width, cells.height), all(cells.width, cells.height);
  for (const CellRun& run : runs_of(cells))
    for (int x = std::max(0, run.begin - by); x < std::min(cells.width, run.end + by); ++x)
      rows.at(x, run.row) = 1;
  for (const CellRun& run : runs_of(rows))
    for (int y = std::max(0, run.row - by); y <= std::min(cells.height - 1, run.row + by); ++y)
      for (int x = run.begin; x < run.end; ++x) all.at(x, y) = 1;
  return all;
}

}  // namespace

PackShape make_shape(const PackChart& chart, double angle, double scale, double pad, int gutter) {
  std::vector<std::vector<Vector2>> loops = chart.loops;
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (auto& loop : loops)
    for (Vector2& p : loop) {
      p = scale * turned(p, angle);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  PackShape shape;
  shape.angle = angle;
  // A hair inside the first cell, so that a side on a line of cells touches one row, not two.
  const Vector2 inset = Vector2::Constant(gutter + pad + 1e-6);
  shape.origin = low - inset;
  for (auto& loop : loops)
    for (Vector2& p : loop) p -= shape.origin;
  Cells cells(int(std::floor(high.x() - shape.origin.x() + pad)) + 1 + gutter,
              int(std::floor(high.y() - shape.origin.y() + pad)) + 1 + gutter);
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i)
      touch(loop[i], loop[(i + 1) % loop.size()], pad, cells);
  fill(loops, cells);
  shape.width = cells.width;
  shape.height = cells.height;
  shape.touched = runs_of(cells);
  double count = 0;
  for (const CellRun& run : shape.touched) {
    const double length = run.end - run.begin;
    shape.middle += length * Vector2((run.begin + run.end) / 2.0, run.row + 0.5);
    count += length;
  }
  if (count > 0) shape.middle /= count;
  shape.wide = gutter > 0 ? runs_of(widened(cells, gutter)) : shape.touched;
  const auto longest = std::ranges::max_element(
      shape.wide, {}, [](const CellRun& run) { return run.end - run.begin; });
  shape.longest = std::size_t(longest - shape.wide.begin());
  return shape;
}

std::vector<CellRun> touched_cells(const std::vector<std::vector<Vector2>>& polygons, int width,
                                   int height) {
  Cells cells(width, height);
  for (const auto& polygon : polygons)
    for (std::size_t i = 0; i < polygon.size(); ++i)
      touch(polygon[i], polygon[(i + 1) % polygon.size()], 0, cells);
  fill(polygons, cells);
  return runs_of(cells);
}

double smallest_box_angle(const PackChart& chart) {
  const double right = std::numbers::pi / 2;
  constexpr int steps = 45;
  double best = std::numeric_limits<double>::infinity(), angle = 0;
  for (int k = 0; k < steps; ++k) {
    Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& loop : chart.loops)
      for (const Vector2& p : loop) {
        const Vector2 q = turned(p, right * k / steps);
        low = low.cwiseMin(q);
        high = high.cwiseMax(q);
      }
    const Vector2 size = high - low;
    if (size.prod() >= best * (1 - 1e-9)) continue;
    best = size.prod();
    angle = right * k / steps + (size.x() < size.y() ? right : 0);
  }
  return angle;
}

// ---- Cells over time ----

namespace {

/// Sets bits [begin, end) of a row of words.
void set_bits(std::uint64_t* bits, int begin, int end) {
  if (begin >= end) return;
  const int first = begin / 64, last = (end - 1) / 64;
  const std::uint64_t head = ~std::uint64_t(0) << (begin % 64),
                      tail = ~std::uint64_t(0) >> (63 - (end - 1) % 64);
  if (first == last) {
    bits[first] |= head & tail;
    return;
  }
  bits[first] |= head;
  for (int w = first + 1; w < last; ++w) bits[w] = ~std::uint64_t(0);
  bits[last] |= tail;
}

/// Where the run of equal bits that holds bit x ends, at most 64 · words; `ones`: of which it is.
int run_end(const std::uint64_t* bits, int words, int x, bool ones) {
  int w = x / 64;
  std::uint64_t other = (ones ? ~bits[w] : bits[w]) & ~std::uint64_t(0) << (x % 64);
  while (other == 0 && ++w < words) other = ones ? ~bits[w] : bits[w];
  return other == 0 ? 64 * words : 64 * w + std::countr_zero(other);
}

}  // namespace

PackVolume::PackVolume(int width, int height, int frames)
    : width_(width), height_(height), frames_(frames), words_((width + 63) / 64) {
  const std::size_t size = std::size_t(height) * words_;
  int leaves = 1;
  while (leaves < frames) leaves *= 2;
  frames_ = leaves;
  covers_.resize(2 * std::size_t(leaves));
  anys_.resize(2 * std::size_t(leaves));
  view_.assign(size, 0);
  ahead_.resize(std::size_t(width) * height);
  longest_.resize(height);
  for (int y = 0; y < height; ++y) count_runs(y);
}

void PackVolume::take(const std::vector<CellRun>& cells, int x, int y, int first, int last) {
  const auto put = [&](std::vector<Word>& board) {
    if (board.empty()) board.assign(std::size_t(height_) * words_, 0);
    for (const CellRun& run : cells) {
      const int begin = std::max(0, run.begin + x), end = std::min(width_, run.end + x);
      if (run.row + y < 0 || run.row + y >= height_) continue;
      set_bits(row(board, run.row + y), begin, end);
    }
  };
  // The nodes that make up [first, last], and all that contain one of them: those lie on the ways
  // from both ends to the root.
  for (int low = first + frames_, high = last + frames_ + 1; low < high; low /= 2, high /= 2) {
    if (low % 2 == 1) put(covers_[low]), put(anys_[low]), ++low;
    if (high % 2 == 1) --high, put(covers_[high]), put(anys_[high]);
  }
  for (int low = (first + frames_) / 2, high = (last + frames_) / 2; low >= 1;
       low /= 2, high /= 2) {
    put(anys_[low]);
    if (high != low) put(anys_[high]);
  }
}

void PackVolume::look(int first, int last) { look(first, last, 0, height_); }

void PackVolume::look(int first, int last, int from, int to) {
  std::vector<const std::vector<Word>*> boards;
  for (int low = first + frames_, high = last + frames_ + 1; low < high; low /= 2, high /= 2) {
    if (low % 2 == 1) boards.push_back(&anys_[low++]);
    if (high % 2 == 1) boards.push_back(&anys_[--high]);
  }
  for (int low = (first + frames_) / 2, high = (last + frames_) / 2; low >= 1;
       low /= 2, high /= 2) {
    boards.push_back(&covers_[low]);
    if (high != low) boards.push_back(&covers_[high]);
  }
  std::vector<Word> bits(words_);
  for (int y = std::max(0, from); y < std::min(height_, to); ++y) {
    std::ranges::fill(bits, 0);
    for (const std::vector<Word>* board : boards)
      if (!board->empty())
        for (int w = 0; w < words_; ++w) bits[w] |= (*board)[std::size_t(y) * words_ + w];
    Word* seen = row(view_, y);
    if (std::equal(bits.begin(), bits.end(), seen)) continue;
    std::ranges::copy(bits, seen);
    count_runs(y);
  }
}

void PackVolume::count_runs(int y) {
  const Word* bits = view_.data() + std::size_t(y) * words_;
  std::int16_t* ahead = ahead_.data() + std::size_t(y) * width_;
  longest_[y] = 0;
  for (int x = 0; x < width_;) {
    const bool taken = bits[x / 64] >> (x % 64) & 1;
    const int end = std::min(width_, run_end(bits, words_, x, taken));
    for (int c = x; c < end; ++c) ahead[c] = std::int16_t(taken ? c - end : end - c);
    if (!taken) longest_[y] = std::max(longest_[y], end - x);
    x = end;
  }
}

int PackVolume::find(const PackShape& shape, int x, int y) const {
  const std::size_t count = shape.wide.size();
  const CellRun& longest = shape.wide[shape.longest];
  if (longest_[y + longest.row] < longest.end - longest.begin) return -1;
  std::size_t hot = shape.longest;  // then the run that was in the way last
  while (x + shape.width <= width_) {
    std::size_t i = 0;
    for (; i < count; ++i) {
      const CellRun& run = shape.wide[hot];
      const std::int16_t* ahead = ahead_.data() + std::size_t(y + run.row) * width_;
      const int from = x + run.begin, free = std::max<int>(0, ahead[from]);
      if (free < run.end - run.begin) {
        x += free - ahead[from + free];
        break;
      }
      hot = hot + 1 == count ? 0 : hot + 1;
    }
    if (i == count) return x;
  }
  return -1;
}

}  // namespace mq
