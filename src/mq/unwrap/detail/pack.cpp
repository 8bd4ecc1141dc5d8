// In two resolutions. In the coarse one, where charts are wider by half the gutter, orders are
// tried: one that fits all charts at a larger scale than the best so far becomes the best, and the
// next are like it. In the fine one charts keep the directions and neighbours found, and the scale
// is raised as far as they fit when each slides to the lower left, as far as it is free, from its
// place.

#include "mq/unwrap/detail/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/random.h"
#include "mq/unwrap/detail/pack_shape.h"

namespace mq {
namespace {

constexpr int directions = 16;
constexpr int most_cells = 2048;     // a side, of the fine resolution
constexpr int coarse_cells = 256;    // a side of the coarse one, at least ...
constexpr int cells_per_chart = 40;  // ... and so many a side of a chart, if all had the same
constexpr double precision = 0.001;  // of scales

/// How charts are placed one after the other.
struct Plan {
  std::vector<double> weights;  // the largest first
  enum class Loss { height, square, low, corner } loss = Loss::height;
};

/// Where a chart's wide shape lies, and its direction.
struct Place {
  int direction, x, y;
};
using Places = std::optional<std::vector<Place>>;

/// A texture in cells.
struct Grid {
  int width, height;
  int gutter, margin;  // in cells
  double pad;          // what charts are wider, in cells
};

class Packer {
 public:
  /// `taken`: cells that no chart may have, in any frame.
  Packer(const std::vector<PackChart>& charts, const std::vector<double>& angles, const Grid& grid,
         std::vector<CellRun> taken = {})
      : charts_(charts),
        angles_(angles),
        grid_(grid),
        taken_(std::move(taken)),
        shapes_(charts.size()),
        scales_(charts.size()) {
    for (const PackChart& chart : charts) frames_ = std::max(frames_, chart.last + 1);
  }

  /// Places of all charts by a plan at this scale (cells per unit), or nothing where they do not
  /// fit.
  Places place_all(const Plan& plan, double scale, const Progress& progress) {
    std::vector<int> order = everything();
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](int c) { return plan.weights[c]; });
    parallel_for(
        std::ssize(order), [&](std::int64_t c) { make_all_shapes(int(c), scale); }, 4);
    PackVolume volume = empty();
    std::vector<Place> places(charts_.size());
    for (const int c : order) {
      progress.check();
      volume.look(charts_[c].first, charts_[c].last);
      const auto place = best_place(volume, c, plan.loss);
      if (!place) return {};
      put(volume, c, places[c] = *place);
    }
    return places;
  }

  /// Places of those charts that fit at this scale, the largest first.
  std::vector<std::optional<Place>> place_what_fits(double scale, const Progress& progress) {
    std::vector<int> order = everything();
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](int c) { return charts_[c].area; });
    PackVolume volume = empty();
    std::vector<std::optional<Place>> places(charts_.size());
    for (const int c : order) {
      progress.check();
      make_all_shapes(c, scale);
      volume.look(charts_[c].first, charts_[c].last);
      places[c] = best_place(volume, c, Plan::Loss::height);
      if (places[c]) put(volume, c, *places[c]);
    }
    return places;
  }

  /// Places of all charts at this scale near to `wanted`, lower left corners of their boxes in
  /// cells.
  Places place_near(const std::vector<int>& direction, const std::vector<Vector2>& wanted,
                    double scale, int reach, const Progress& progress) {
    parallel_for(
        std::ssize(charts_), [&](std::int64_t c) { make_shape_of(int(c), direction[c], scale); },
        1);
    std::vector<int> order = everything();
    std::ranges::stable_sort(order, {}, [&](int c) { return wanted[c].sum(); });
    PackVolume volume = empty();
    std::vector<Place> places(charts_.size());
    std::vector<int> homeless;
    for (const int c : order) {
      progress.check();
      const auto place = near_place(volume, c, direction[c], wanted[c], reach);
      if (place)
        put(volume, c, places[c] = *place);
      else
        homeless.push_back(c);
    }
    std::ranges::stable_sort(homeless, std::ranges::greater{},
                             [&](int c) { return charts_[c].area; });
    for (const int c : homeless) {
      make_all_shapes(c, scale);
      volume.look(charts_[c].first, charts_[c].last);
      const auto place = best_place(volume, c, Plan::Loss::height);
      if (!place) return {};
      put(volume, c, places[c] = *place);
    }
    return places;
  }

  /// The lower left corner of a placed chart's box, in cells.
  Vector2 corner(const Place& place) const {
    return Vector2(place.x, place.y) + Vector2::Constant(grid_.gutter - slack() + grid_.pad);
  }

  Placement placement(int chart, const Place& place, double scale) {
    make_shape_of(chart, place.direction, scale);
    const PackShape& shape = shapes_[chart][place.direction];
    return {shape.angle, Vector2(place.x - slack(), place.y - slack()) - shape.origin};
  }

 private:
  using Shapes = std::array<PackShape, directions>;
  using Rank = std::array<int, 3>;
  static constexpr int none = std::numeric_limits<int>::max();

  /// Wide shapes may leave the texture by what the gutter is more than the margin.
  int slack() const { return grid_.gutter - grid_.margin; }

  PackVolume empty() const {
    PackVolume volume(grid_.width + 2 * slack(), grid_.height + 2 * slack(), frames_);
    if (!taken_.empty()) volume.take(taken_, slack(), slack(), 0, frames_ - 1);
    return volume;
  }

  std::vector<int> everything() const {
    std::vector<int> all(charts_.size());
    for (std::size_t c = 0; c < all.size(); ++c) all[c] = int(c);
    return all;
  }

  void make_shape_of(int chart, int direction, double scale) {
    if (scales_[chart][direction] == scale) return;
    scales_[chart][direction] = scale;
    shapes_[chart][direction] =
        make_shape(charts_[chart], angles_[chart] + direction * 2 * std::numbers::pi / directions,
                   scale, grid_.pad, grid_.gutter);
  }

  void make_all_shapes(int chart, double scale) {
    for (int d = 0; d < directions; ++d) make_shape_of(chart, d, scale);
  }

  void put(PackVolume& volume, int chart, const Place& place) const {
    volume.take(shapes_[chart][place.direction].touched, place.x, place.y, charts_[chart].first,
                charts_[chart].last);
  }

  /// The place of least loss; among equals the lowest, then the leftmost, then the first direction.
  std::optional<Place> best_place(const PackVolume& volume, int chart, Plan::Loss loss) const {
    std::array<std::pair<Rank, Place>, directions> found;
    parallel_for(
        directions,
        [&](std::int64_t d) {
          const PackShape& shape = shapes_[chart][d];
          Rank& best = found[d].first;
          best = {none, 0, 0};
          for (int y = 0; y + shape.height <= volume.height(); ++y) {
            if (rank(shape, 0, y, loss) >= best) break;
            const int x = volume.find(shape, 0, y);
            if (x < 0) continue;
            const Rank here = rank(shape, x, y, loss);
            if (here < best) best = here, found[d].second = {int(d), x, y};
          }
        },
        4);
    int best = 0;
    for (int d = 1; d < directions; ++d)
      if (found[d].first < found[best].first) best = d;
    if (found[best].first[0] == none) return {};
    return found[best].second;
  }

  /// Less is better; not less for a place above or to the right.
  static Rank rank(const PackShape& shape, int x, int y, Plan::Loss loss) {
    const int top = y + shape.height, side = x + shape.width;
    const int up = int(4 * (y + shape.middle.y())), right = int(4 * (x + shape.middle.x()));
    switch (loss) {
      case Plan::Loss::height: return {top, side, y};
      case Plan::Loss::square: return {std::max(top, side), top + side, y};
      case Plan::Loss::low: return {up, right, y};
      case Plan::Loss::corner: return {up + right, std::max(up, right), y};
    }
    return {none, 0, 0};
  }

  /// The lowest leftmost free place whose corner is at most `reach` cells from `wanted`.
  std::optional<Place> near_place(PackVolume& volume, int chart, int direction,
                                  const Vector2& wanted, int reach) const {
    const PackShape& shape = shapes_[chart][direction];
    const Vector2 at = wanted - corner({direction, 0, 0});
    const int column = int(std::lround(at.x())), row = int(std::lround(at.y()));
    int best = none;
    Place place{direction, 0, 0};
    const int first = std::max(0, row - reach),
              last = std::min(row + reach, volume.height() - shape.height);
    volume.look(charts_[chart].first, charts_[chart].last, first, last + shape.height);
    for (int y = first; y <= last; ++y) {
      const int x = volume.find(shape, std::max(0, column - reach), y);
      if (x < 0 || x > column + reach || x + y >= best) continue;
      best = x + y;
      place.x = x;
      place.y = y;
    }
    if (best == none) return {};
    return place;
  }

  const std::vector<PackChart>& charts_;
  const std::vector<double>& angles_;
  Grid grid_;
  std::vector<CellRun> taken_;
  int frames_ = 1;
  std::vector<Shapes> shapes_;
  std::vector<std::array<double, directions>> scales_;  // at which shapes were made
};

/// Like another plan, but a few charts come earlier or later.
Plan changed(const Plan& plan, const Random& random, std::uint64_t trial) {
  Plan next = plan;
  const auto draw = [&](std::uint64_t i) {
    return random.uniform(trial * (2 * plan.weights.size() + 2) + i);
  };
  for (std::size_t c = 0; c < plan.weights.size(); ++c)
    if (draw(2 * c) < 0.3) next.weights[c] *= std::exp2(3 * draw(2 * c + 1) - 1.5);
  if (draw(2 * plan.weights.size()) < 0.25)
    next.loss = Plan::Loss(int(4 * draw(2 * plan.weights.size() + 1)));
  return next;
}

/// The largest scale that fits, between one that does (or is 0) and one that may not, and its
/// places.
template <class PlaceAt>
std::pair<double, Places> largest_scale(double low, double high, const PlaceAt& place_at, const Progress& progress = {}) {
  Places best;
  const double least = 1e-4 * high;  // where nothing fits at all
  const double halvings = std::log2((high - low) / (precision * high));
  for (int halved = 0; high - low > precision * high && high > least; ++halved) {
    progress.at(halved / (halvings + 1));
    const double middle = (low + high) / 2;
    if (Places places = place_at(middle))
      best = std::move(places), low = middle;
    else
      high = middle;
  }
  return {low, std::move(best)};
}

/// Area of the fullest frame, area times frames of all, charts in a frame on average.
struct Contents {
  double fullest = 0, total = 0, charts = 0;
  int frames = 1;
};

Contents contents_of(const std::vector<PackChart>& charts) {
  Contents contents;
  for (const PackChart& chart : charts) contents.frames = std::max(contents.frames, chart.last + 1);
  std::vector<double> change(contents.frames + 1);
  for (const PackChart& chart : charts) {
    change[chart.first] += chart.area;
    change[chart.last + 1] -= chart.area;
    contents.total += chart.area * (chart.last - chart.first + 1);
    contents.charts += double(chart.last - chart.first + 1) / contents.frames;
  }
  double now = 0;
  for (const double c : change) contents.fullest = std::max(contents.fullest, now += c);
  return contents;
}

/// The best of some plans: cells per unit, places.
std::pair<double, Places> try_plans(Packer& packer, const std::vector<PackChart>& charts,
                                    const PackOptions& options, double charts_per_frame,
                                    double perfect, const Progress& progress) {
  const double many = std::sqrt(double(charts.size()) * charts_per_frame) / 20;
  const int trials = std::min(options.trials, std::max(2, int(options.trials / many)));
  Plan best;
  for (const PackChart& chart : charts) best.weights.push_back(chart.area);
  double scale = 0;
  Places places;
  const Random random(options.seed);
  for (int trial = 0; trial < trials; ++trial) {
    progress.at(double(trial) / trials);
    const Plan plan = trial == 0  ? best
                      : trial < 4 ? Plan{best.weights, Plan::Loss(trial)}
                                  : changed(best, random, trial);
    const auto place_at = [&](double s) { return packer.place_all(plan, s, progress); };
    double low = 0;
    if (scale > 0) {
      // One that does as well is taken too: the best may be near to it.
      Places found = place_at(scale);
      if (!found) continue;
      best = plan;
      places = std::move(found);
      low = scale * (1 + 2 * precision);
      if (!(found = place_at(low))) continue;
      places = std::move(found);
      scale = low;
    }
    auto [larger, more] = largest_scale(low, scale > 0 ? scale * 1.06 : perfect, place_at);
    if (more) places = std::move(more);
    scale = larger;
    best = plan;
  }
  return {scale, std::move(places)};
}

/// The texture at full resolution, and how many texels wide its cells are.
std::pair<Grid, int> fine_grid(const PackOptions& options) {
  require(options.width >= 1 && options.height >= 1 && options.gutter >= 0,
          "a texture needs at least one texel, and a gutter no less than none");
  const int cell = (std::max(options.width, options.height) + most_cells - 1) / most_cells;
  const auto cells = [&](int texels) { return (texels + cell - 1) / cell; };
  return {{options.width / cell, options.height / cell, cells(options.gutter),
           cells((options.gutter + 1) / 2), 0},
          cell};
}

std::vector<double> smallest_box_angles(const std::vector<PackChart>& charts) {
  std::vector<double> angles;
  for (const PackChart& chart : charts) angles.push_back(smallest_box_angle(chart));
  return angles;
}

}  // namespace

Packing pack(const std::vector<PackChart>& charts, const PackOptions& options,
             const Progress& progress) {
  const auto [fine, cell] = fine_grid(options);
  for (const PackChart& chart : charts)
    require(chart.first >= 0 && chart.last >= chart.first,
            "a chart lives from a frame to a later one");
  const Contents contents = contents_of(charts);
  require(contents.fullest > 0, "there is no chart with area to place");
  const std::vector<double> angles = smallest_box_angles(charts);
  const double perfect = std::sqrt(double(fine.width) * fine.height / contents.fullest);

  const double enough =
      std::max<double>(coarse_cells, cells_per_chart * std::sqrt(contents.charts));
  int step = 1;
  while (std::min(fine.width, fine.height) / (2 * step) >= enough) step *= 2;
  const Grid coarse{fine.width / step, fine.height / step, 0, 0, (fine.gutter + 1) / (2.0 * step)};
  Packer quick(charts, angles, step == 1 ? fine : coarse), exact(charts, angles, fine);
  const Plan any{std::vector<double>(charts.size(), 1.0)};
  require(
      exact.place_all(any, 1e-3 * perfect, progress).has_value(),
      fmt::format("{} charts with gutters of {} do not fit into {} × {} texels: wanted a larger "
                  "texture or a smaller gutter",
                  charts.size(), options.gutter, options.width, options.height));
  auto [scale, places] = try_plans(quick, charts, options, contents.charts, perfect / step,
                                   progress.step("try orders", 0.57));

  const Progress sliding = progress.step("slide", 0.43);
  Packer& last = step == 1 ? quick : exact;
  if (step > 1 && places) {
    std::vector<int> direction;
    std::vector<Vector2> corners;
    for (int c = 0; c < int(charts.size()); ++c) {
      direction.push_back((*places)[c].direction);
      corners.push_back(step * quick.corner((*places)[c]));
    }
    const double before = scale * step;
    const auto place_at = [&](double s) {
      std::vector<Vector2> wanted = corners;
      for (Vector2& p : wanted) p *= s / before;
      // Who slides far may take the place of another.
      for (int reach = 8 * step; reach > 1; reach /= 2)
        if (Places found = exact.place_near(direction, wanted, s, reach, sliding)) return found;
      return Places();
    };
    std::tie(scale, places) =
        largest_scale(before * 0.9, std::min(perfect, before * 1.15), place_at, sliding);
  }
  if (!places)
    std::tie(scale, places) = largest_scale(
        1e-3 * perfect, perfect, [&](double s) { return last.place_all(any, s, sliding); }, sliding);
  if (!places) places = last.place_all(any, scale, sliding);
  Packing packing;
  packing.scale = scale * cell;
  for (int c = 0; c < int(charts.size()); ++c) {
    Placement place = last.placement(c, (*places)[c], scale);
    place.shift *= cell;
    packing.places.push_back(place);
  }
  const double texels = double(options.width) * options.height,
               square = packing.scale * packing.scale;
  packing.occupancy = contents.total * square / (texels * contents.frames);
  packing.bound = texels / (contents.fullest * square);
  progress.at(1);
  return packing;
}

std::vector<std::optional<Placement>> pack_beside(const std::vector<PackChart>& charts,
                                                  double scale,
                                                  const std::vector<std::vector<Vector2>>& taken,
                                                  const PackOptions& options,
                                                  const Progress& progress) {
  const auto [grid, cell] = fine_grid(options);
  std::vector<std::vector<Vector2>> polygons = taken;
  for (auto& polygon : polygons)
    for (Vector2& p : polygon) p /= cell;
  const std::vector<double> angles = smallest_box_angles(charts);
  Packer packer(charts, angles, grid, touched_cells(polygons, grid.width, grid.height));
  const std::vector<std::optional<Place>> places = packer.place_what_fits(scale / cell, progress);
  std::vector<std::optional<Placement>> result(charts.size());
  for (int c = 0; c < int(charts.size()); ++c)
    if (places[c]) {
      result[c] = packer.placement(c, *places[c], scale / cell);
      result[c]->shift *= cell;
    }
  return result;
}

std::vector<char> touched_texels(const PackChart& chart, const Placement& place, double scale,
                                 int width, int height) {
  const PackShape shape = make_shape(chart, place.angle, scale, 0, 0);
  const Vector2 corner = shape.origin + place.shift;
  const int x = int(std::floor(corner.x() + 0.5)), y = int(std::floor(corner.y() + 0.5));
  std::vector<char> texels(std::size_t(width) * height);
  for (const CellRun& run : shape.touched)
    for (int c = run.begin + x; c < run.end + x; ++c)
      if (c >= 0 && c < width && run.row + y >= 0 && run.row + y < height)
        texels[std::size_t(height - 1 - run.row - y) * width + c] = 1;
  return texels;
}

}  // namespace mq
