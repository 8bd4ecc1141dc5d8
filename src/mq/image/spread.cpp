// d²(x, y) = min over columns c of (x − c)² + e²(c, y),  e the distance up or down column c: first
// the nearest known pixel of every column, then along each row the lower envelope of parabolas.

#include "mq/image/spread.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Row of the nearest known pixel in the same column, -1: none.
Image<int> nearest_in_columns(const Image<char>& known) {
  const int width = known.width(), height = known.height();
  Image<int> rows(width, height, 1, -1);
  parallel_for(
      width,
      [&](std::int64_t x) {
        int above = -1;
        for (int y = 0; y < height; ++y) {
          if (known(int(x), y) > 0) above = y;
          rows(int(x), y) = above;
        }
        int below = -1;
        for (int y = height - 1; y >= 0; --y) {
          if (known(int(x), y) > 0) below = y;
          int& row = rows(int(x), y);
          if (below >= 0 && (row < 0 || below - y < y - row)) row = below;
        }
      },
      16);
  return rows;
}

/// The envelope of one row: columns whose parabola is lowest somewhere, left to right.
class Envelope {
 public:
  void add(int column, double square) {
    double start = -std::numeric_limits<double>::infinity();
    while (!columns_.empty()) {
      const int c = columns_.back();
      start = ((square + double(column) * column) - (squares_.back() + double(c) * c)) /
              (2.0 * (column - c));
      if (start > starts_.back()) break;
      columns_.pop_back(), starts_.pop_back(), squares_.pop_back();
      start = -std::numeric_limits<double>::infinity();
    }
    columns_.push_back(column), starts_.push_back(start), squares_.push_back(square);
  }

  /// The column that is nearest at x; x must not decrease from call to call.
  int nearest(int x, std::size_t& at) const {
    while (at + 1 < columns_.size() && starts_[at + 1] < x) ++at;
    return columns_[at];
  }
  bool empty() const { return columns_.empty(); }

 private:
  std::vector<int> columns_;
  std::vector<double> starts_, squares_;
};

}  // namespace

Image<int> nearest_known(const Image<char>& known) {
  const int width = known.width(), height = known.height();
  const Image<int> rows = nearest_in_columns(known);
  Image<int> result(width, height, 1, -1);
  parallel_blocks(height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (int y = int(begin); y < int(end); ++y) {
      Envelope envelope;
      for (int x = 0; x < width; ++x)
        if (rows(x, y) >= 0) envelope.add(x, double(rows(x, y) - y) * (rows(x, y) - y));
      if (envelope.empty()) continue;
      std::size_t at = 0;
      for (int x = 0; x < width; ++x) {
        const int column = envelope.nearest(x, at);
        result(x, y) = rows(column, y) * width + column;
      }
    }
  });
  return result;
}

namespace {

/// Both as `nearest_known` finds them.
void spread_from(const Image<int>& nearest_source, const Image<int>& nearest_known_one,
                 double distance, Image<float>& picture) {
  const int width = picture.width();
  parallel_for(
      picture.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < width; ++x) {
          const int known = nearest_known_one(x, y);
          if (known < 0 || known == y * width + x) continue;
          if (std::hypot(known % width - x, known / width - y) > distance) continue;
          const int from = nearest_source(x, y) >= 0 ? nearest_source(x, y) : known;
          std::ranges::copy(picture.pixel(from % width, from / width), picture.pixel(x, y).begin());
        }
      },
      16);
}

}  // namespace

void spread(const Image<char>& known, double distance, Image<float>& picture) {
  const Image<int> nearest = nearest_known(known);
  spread_from(nearest, nearest, distance, picture);
}

void spread(const Image<char>& source, const Image<char>& known, double distance,
            Image<float>& picture) {
  spread_from(nearest_known(source), nearest_known(known), distance, picture);
}

}  // namespace mq
