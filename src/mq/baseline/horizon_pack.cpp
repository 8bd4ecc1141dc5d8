// A horizon of a line y = l: per column x the free cells low(x) ≤ y ≤ high(x) around it. A chart whose columns touch
// bottom(x) ≤ y ≤ top(x) fits where it is moved by (s, t) with
//
//   max_x low(x + s) − bottom(x) ≤ t ≤ min_x high(x + s) − top(x).
//
// The thesis shifts one horizon along the other; that t may be any of these, and is the one nearest to the middle, is
// ours. Vertical lines are horizontal ones of the board and chart mirrored at x = y.

#include "mq/baseline/horizon_pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "mq/base/error.h"
#include "mq/unwrap/touched_cells.h"

namespace mq {
namespace {

constexpr double precision = 0.001;  // of scales
constexpr double hair = 1e-6;        // so that a side on a line of cells touches one row, as in `pack`
constexpr int none = std::numeric_limits<int>::max();

/// Per column of a chart's box the lowest and highest cell, the gutter added.
struct Sides {
  std::vector<int> bottom, top;
};

/// A chart as cells, from the corner of a box that is wider by the gutter all around.
struct Shape {
  std::vector<CellRun> touched;
  Sides columns, rows;
  Vector2 middle = Vector2::Zero();
  double angle = 0;
  Vector2 low = Vector2::Zero();  ///< of the turned, scaled chart at the box' corner
};

/// The gutter added to what is touched, `none` and −1 where nothing is.
Sides widened(const Sides& sides, int gutter) {
  const int count = int(sides.bottom.size());
  Sides wide{std::vector<int>(sides.bottom.size(), none), std::vector<int>(sides.top.size(), -1)};
  for (int x = 0; x < count; ++x) {
    if (sides.top[x] < 0) continue;
    for (int u = std::max(0, x - gutter); u <= std::min(count - 1, x + gutter); ++u) {
      wide.bottom[u] = std::min(wide.bottom[u], sides.bottom[x] - gutter);
      wide.top[u] = std::max(wide.top[u], sides.top[x] + gutter);
    }
  }
  return wide;
}

Vector2 turned(const Vector2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

Shape make_shape(const PackChart& chart, double angle, double scale, int gutter) {
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& loop : chart.loops)
    for (const Vector2& point : loop) {
      const Vector2 p = scale * turned(point, angle);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  Shape shape;
  shape.angle = angle;
  shape.low = low - Vector2::Constant(gutter + hair);
  const int width = int(std::floor(high.x() - shape.low.x())) + 1 + gutter,
            height = int(std::floor(high.y() - shape.low.y())) + 1 + gutter;
  const std::vector<char> cells = touched_texels(chart, {angle, -shape.low}, scale, width, height);
  Sides columns{std::vector<int>(width, none), std::vector<int>(width, -1)},
      rows{std::vector<int>(height, none), std::vector<int>(height, -1)};
  double count = 0;
  for (int y = 0; y < height; ++y) {
    const char* row = cells.data() + std::size_t(height - 1 - y) * width;
    for (int x = 0; x < width;) {
      if (!row[x]) {
        ++x;
        continue;
      }
      const int begin = x;
      for (; x < width && row[x]; ++x) {
        columns.bottom[x] = std::min(columns.bottom[x], y);
        columns.top[x] = y;
      }
      shape.touched.push_back({y, begin, x});
      rows.bottom[y] = std::min(rows.bottom[y], begin);
      rows.top[y] = x - 1;
      shape.middle += (x - begin) * Vector2((begin + x) / 2.0, y + 0.5);
      count += x - begin;
    }
  }
  shape.middle /= std::max(count, 1.0);
  shape.columns = widened(columns, gutter);
  shape.rows = widened(rows, gutter);
  return shape;
}

/// What is free around each cell of a board in its column: cells from it on, itself counted, 0 where it is taken.
class FreeColumns {
 public:
  FreeColumns(const std::vector<char>& taken, int width, int height)
      : width_(width), below_(taken.size()), above_(taken.size()) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (!taken[at(x, y)]) below_[at(x, y)] = 1 + (y > 0 ? below_[at(x, y - 1)] : 0);
    for (int y = height - 1; y >= 0; --y)
      for (int x = 0; x < width; ++x)
        if (!taken[at(x, y)]) above_[at(x, y)] = 1 + (y + 1 < height ? above_[at(x, y + 1)] : 0);
  }
  int low(int x, int line) const { return line - below_[at(x, line)] + 1; }    // above the line: taken
  int high(int x, int line) const { return line + above_[at(x, line)] - 1; }  // below the line: taken

 private:
  std::size_t at(int x, int y) const { return std::size_t(y) * width_ + x; }
  int width_;
  std::vector<int> below_, above_;
};

/// A place, and the square of its middle's distance from where it should be.
struct Found {
  double distance = std::numeric_limits<double>::infinity();
  int along = 0, across = 0, direction = 0;
};

/// Looks along a line for a better place than the one found: `middle` is the chart's, `goal` where that should be,
/// both along and across the line.
void look_along(const std::vector<int>& low, const std::vector<int>& high, const Sides& chart, const Vector2& middle,
                const Vector2& goal, Found& found) {
  const int columns = int(chart.bottom.size()), last = int(low.size()) - columns;
  const auto try_shift = [&](int s) {
    int least = std::numeric_limits<int>::min(), most = none;
    for (int x = 0; x < columns; ++x) {
      if (chart.top[x] < chart.bottom[x]) continue;
      if (high[s + x] < low[s + x]) return;
      least = std::max(least, low[s + x] - chart.bottom[x]);
      most = std::min(most, high[s + x] - chart.top[x]);
      if (least > most) return;
    }
    const int t = std::clamp(int(std::lround(goal.y() - middle.y())), least, most);
    const double distance = (Vector2(s, t) + middle - goal).squaredNorm();
    if (distance < found.distance) found = {distance, s, t, found.direction};
  };
  const auto gap = [&](int s) { return std::pow(s + middle.x() - goal.x(), 2); };
  const int first = std::clamp(int(std::lround(goal.x() - middle.x())), 0, std::max(last, 0));
  for (int s = first; s <= last && gap(s) < found.distance; ++s) try_shift(s);
  for (int s = std::min(first - 1, last); s >= 0 && gap(s) < found.distance; --s) try_shift(s);
}

class HorizonPacker {
 public:
  HorizonPacker(const std::vector<PackChart>& charts, const HorizonPackOptions& options)
      : charts_(charts),
        options_(options),
        slack_(options.gutter - (options.gutter + 1) / 2),
        width_(options.width + 2 * slack_),
        height_(options.height + 2 * slack_) {
    for (const PackChart& chart : charts) {
      order_.push_back(int(order_.size()));
      angles_.push_back(upright_angle(chart));
    }
    std::ranges::stable_sort(order_, std::ranges::greater{}, [&](int c) { return charts[c].area; });
  }

  /// Places of all charts at this scale, or nothing where they do not fit.
  std::optional<std::vector<Placement>> place_all(double scale, const Progress& progress) const {
    std::vector<Placement> places(charts_.size());
    std::vector<std::vector<CellRun>> cells(charts_.size());  // on the board, of those placed
    Vector2 weighted = Vector2::Zero();
    double weight = 0;
    for (const int c : order_) {
      progress.check();
      const std::vector<char> taken = taken_for(charts_[c], cells);
      const Vector2 goal = weight > 0 ? Vector2(weighted / weight) : Vector2(width_ / 2.0, height_ / 2.0);
      std::vector<Shape> shapes;
      for (int d = 0; d < options_.directions; ++d)
        shapes.push_back(make_shape(charts_[c], angles_[c] + d * 2 * std::numbers::pi / options_.directions, scale,
                                    options_.gutter));
      const std::optional<std::array<int, 3>> place = best_place(taken, shapes, goal);
      if (!place) return {};
      const auto [x, y, direction] = *place;
      const Shape& shape = shapes[direction];
      for (const CellRun& run : shape.touched) cells[c].push_back({run.row + y, run.begin + x, run.end + x});
      weighted += charts_[c].area * (shape.middle + Vector2(x, y));
      weight += charts_[c].area;
      places[c] = {shape.angle, Vector2(x - slack_, y - slack_) - shape.low};
    }
    return places;
  }

 private:
  /// At which the longest diameter is upright.
  static double upright_angle(const PackChart& chart) {
    double longest = -1, angle = 0;
    std::vector<Vector2> points;
    for (const auto& loop : chart.loops) points.insert(points.end(), loop.begin(), loop.end());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Vector2 d = points[i] - points[j];
        if (d.squaredNorm() <= longest) continue;
        longest = d.squaredNorm();
        angle = std::numbers::pi / 2 - std::atan2(d.y(), d.x());
      }
    return angle;
  }

  /// The cells that those taken have that live at the same time.
  std::vector<char> taken_for(const PackChart& chart, const std::vector<std::vector<CellRun>>& cells) const {
    std::vector<char> taken(std::size_t(width_) * height_);
    for (std::size_t other = 0; other < cells.size(); ++other) {
      if (charts_[other].first > chart.last || chart.first > charts_[other].last) continue;
      for (const CellRun& run : cells[other])
        std::fill_n(taken.begin() + std::ptrdiff_t(run.row) * width_ + run.begin, run.end - run.begin, 1);
    }
    return taken;
  }

  /// Column, row and direction.
  std::optional<std::array<int, 3>> best_place(const std::vector<char>& taken, const std::vector<Shape>& shapes,
                                               const Vector2& goal) const {
    std::vector<char> mirrored(taken.size());
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) mirrored[std::size_t(x) * height_ + y] = taken[std::size_t(y) * width_ + x];
    Found across_rows, across_columns;
    look(taken, width_, height_, shapes, &Shape::columns, goal, across_rows);
    look(mirrored, height_, width_, shapes, &Shape::rows, Vector2(goal.y(), goal.x()), across_columns);
    if (std::isinf(std::min(across_rows.distance, across_columns.distance))) return {};
    if (across_rows.distance <= across_columns.distance)
      return {{across_rows.along, across_rows.across, across_rows.direction}};
    return {{across_columns.across, across_columns.along, across_columns.direction}};
  }

  /// Along all lines of a board of this size, which may be mirrored, as the goal then is.
  void look(const std::vector<char>& taken, int width, int height, const std::vector<Shape>& shapes,
            Sides Shape::*sides, const Vector2& goal, Found& found) const {
    const FreeColumns columns(taken, width, height);
    const bool is_mirrored = sides == &Shape::rows;
    std::vector<int> low(width), high(width);
    for (int i = 0; i < options_.lines; ++i) {
      const int line = int((i + 0.5) * height / options_.lines);
      for (int x = 0; x < width; ++x) {
        low[x] = columns.low(x, line);
        high[x] = columns.high(x, line);
      }
      for (std::size_t d = 0; d < shapes.size(); ++d) {
        const Vector2& middle = shapes[d].middle;
        Found here = found;
        here.direction = int(d);
        look_along(low, high, shapes[d].*sides, is_mirrored ? Vector2(middle.y(), middle.x()) : middle, goal, here);
        if (here.distance < found.distance) found = here;
      }
    }
  }

  const std::vector<PackChart>& charts_;
  HorizonPackOptions options_;
  int slack_;  // a chart with its gutter may leave the texture by what that is more than the border
  int width_, height_;
  std::vector<int> order_;
  std::vector<double> angles_;
};

/// Area of the fullest frame, area times frames of all, and frames.
struct Contents {
  double fullest = 0, total = 0;
  int frames = 1;
};

Contents contents_of(const std::vector<PackChart>& charts) {
  Contents contents;
  for (const PackChart& chart : charts) {
    require(chart.first >= 0 && chart.last >= chart.first, "a chart lives from a frame to a later one");
    contents.frames = std::max(contents.frames, chart.last + 1);
  }
  std::vector<double> area(contents.frames);
  for (const PackChart& chart : charts)
    for (int f = chart.first; f <= chart.last; ++f) area[f] += chart.area;
  for (const double a : area) {
    contents.fullest = std::max(contents.fullest, a);
    contents.total += a;
  }
  return contents;
}

}  // namespace

Packing horizon_pack(const std::vector<PackChart>& charts, const HorizonPackOptions& options,
                     const Progress& progress) {
  require(options.width >= 1 && options.height >= 1 && options.gutter >= 0,
          "a texture needs at least one texel, and a gutter no less than none");
  require(options.lines >= 1 && options.directions >= 1, "wanted at least one line and one direction");
  const Contents contents = contents_of(charts);
  require(contents.fullest > 0, "there is no chart with area to place");
  const HorizonPacker packer(charts, options);
  const double texels = double(options.width) * options.height, perfect = std::sqrt(texels / contents.fullest);
  double low = 0, high = perfect;
  std::optional<std::vector<Placement>> places;
  for (int halved = 0; high - low > precision * perfect; ++halved) {
    progress.at(halved / 11.0);
    const double middle = (low + high) / 2;
    if (auto found = packer.place_all(middle, progress)) {
      places = std::move(found);
      low = middle;
    } else {
      high = middle;
    }
  }
  require(places.has_value(),
          fmt::format("{} charts with gutters of {} do not fit into {} × {} texels: wanted a larger texture or a "
                      "smaller gutter",
                      charts.size(), options.gutter, options.width, options.height));
  progress.at(1);
  return {std::move(*places), low, contents.total * low * low / (texels * contents.frames),
          texels / (contents.fullest * low * low)};
}

}  // namespace mq
