// Lines are blended by how much of a pixel they cover: 1 up to half their width from the middle,
// falling to 0 over a pixel.

#include "mq/draw/line_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/draw/false_colour.h"
#include "mq/draw/detail/text.h"

namespace mq {
namespace {

constexpr double line_width = 2.2, grid_width = 1;  // pixels
constexpr double dot_radius = 3;
constexpr int most_dots = 60;         // places, above which lines have none
constexpr double headroom = 0.06;     // of the range, above the largest value
constexpr double least_range = 1e-3;  // of the largest value, so that few digits tell ticks apart
constexpr Colour ink = {0.12f, 0.12f, 0.14f}, grid = {0.86f, 0.86f, 0.88f}, paper = {1, 1, 1},
                 goal = {0.35f, 0.35f, 0.38f}, mark = {0.97f, 0.84f, 0.68f};

struct Point {
  double x, y;
};

void blend(Image<float>& image, int x, int y, const Colour& colour, double share) {
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height() || !(share > 0)) return;
  for (int c = 0; c < 3; ++c) {
    float& value = image(x, y, c);
    value += float(std::min(share, 1.0)) * (colour[std::size_t(c)] - value);
  }
}

void draw_stroke(Image<float>& image, Point a, Point b, double width, const Colour& colour) {
  const double reach = width / 2 + 1,
               length2 = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
  for (int y = int(std::floor(std::min(a.y, b.y) - reach));
       y <= int(std::ceil(std::max(a.y, b.y) + reach)); ++y)
    for (int x = int(std::floor(std::min(a.x, b.x) - reach));
         x <= int(std::ceil(std::max(a.x, b.x) + reach)); ++x) {
      const double along = ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y));
      const double t = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0;
      const double distance = std::hypot(a.x + t * (b.x - a.x) - x, a.y + t * (b.y - a.y) - y);
      blend(image, x, y, colour, width / 2 + 0.5 - distance);
    }
}

void fill(Image<float>& image, int left, int top, int right, int bottom, const Colour& colour) {
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) blend(image, x, y, colour, 1);
}

bool shown(const PlotPanel& panel, double value) {
  return std::isfinite(value) && (panel.scale == PlotPanel::Scale::linear || value > 0);
}

/// What an axis reaches over, in the values themselves or in their logarithms.
struct Range {
  double low, high;
  double share(double value) const { return (value - low) / (high - low); }
};

double on_axis(const PlotPanel& panel, double value) {
  return panel.scale == PlotPanel::Scale::linear ? value : std::log10(value);
}

Range range_of(const PlotPanel& panel) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto take = [&](double value) {
    if (!shown(panel, value)) return;
    low = std::min(low, on_axis(panel, value));
    high = std::max(high, on_axis(panel, value));
  };
  for (const PlotLine& line : panel.lines)
    for (const double value : line.values) take(value);
  if (panel.wanted) take(*panel.wanted);
  if (panel.scale == PlotPanel::Scale::linear) {
    low = std::min(low, panel.base);
    if (!(high > low)) high = low + (low == 0 ? 1 : least_range * std::abs(low));
    high = std::max(high, low + least_range * std::max(std::abs(low), std::abs(high)));
    return {low, high + headroom * (high - low)};
  }
  if (!(high >= low)) return {0, 1};
  low = std::floor(low + 1e-9), high = std::ceil(high - 1e-9);
  return {low, high > low ? high : low + 1};
}

std::vector<double> ticks_of(const PlotPanel& panel, const Range& range, int count) {
  if (panel.scale == PlotPanel::Scale::linear) return round_ticks(range.low, range.high, count);
  std::vector<double> ticks;
  const double step = std::max(1.0, std::ceil((range.high - range.low) / count));
  for (double at = range.low; at <= range.high; at += step) ticks.push_back(at);
  return ticks;
}

bool is_whole(double x) { return std::abs(x - std::round(x)) < 1e-9; }

/// Between whole places, such as frames, there is nothing.
std::vector<double> ticks_across(const std::vector<double>& places, int count) {
  std::vector<double> ticks = round_ticks(places.front(), places.back(), count);
  if (std::ranges::all_of(places, is_whole))
    std::erase_if(ticks, [](double tick) { return !is_whole(tick); });
  return ticks;
}

/// Each with as many decimals as tell them apart.
std::vector<std::string> tick_texts(const PlotPanel& panel, const std::vector<double>& ticks) {
  std::vector<std::string> texts;
  const bool linear = panel.scale == PlotPanel::Scale::linear;
  for (int digits = 6; digits <= 15; ++digits) {
    texts.clear();
    for (const double tick : ticks)
      texts.push_back(fmt::format("{:.{}g}", linear ? tick : std::pow(10, tick), digits));
    if (std::ranges::adjacent_find(texts) == texts.end()) break;
  }
  return texts;
}

void check(const std::vector<double>& places, const std::vector<PlotPanel>& panels,
           const LinePlotOptions& options) {
  require(!places.empty() && !panels.empty(), "a chart needs at least one place and one panel");
  require(std::ranges::all_of(places, [](double x) { return std::isfinite(x); }) &&
              std::ranges::adjacent_find(places, std::greater_equal<>()) == places.end(),
          "the places of a chart must ascend");
  for (const PlotPanel& panel : panels)
    for (const PlotLine& line : panel.lines)
      require(line.values.size() == places.size(),
              fmt::format("the line \"{}\" has {} values for {} places", line.name,
                          line.values.size(), places.size()));
  require(options.text_scale >= 1 && options.width >= 200 * options.text_scale &&
              options.panel_height >= 30 * options.text_scale,
          fmt::format("a chart of {} x {} pixels a panel is too small for its words", options.width,
                      options.panel_height));
}

Colour colour_of(const PlotPanel& panel, int line) {
  const int own = panel.lines[std::size_t(line)].colour;
  return chart_line_colour(own < 0 ? line : own);
}

/// Where things are on the page.
class Page {
 public:
  Page(const std::vector<double>& places, const std::vector<PlotPanel>& panels,
       const LinePlotOptions& options)
      : places_(places), options_(options), scale_(options.text_scale), line_(text_height(scale_)) {
    int widest = 0;
    for (const PlotPanel& panel : panels)
      for (const std::string& text :
           tick_texts(panel, ticks_of(panel, range_of(panel), tick_count())))
        widest = std::max(widest, text_width(text, scale_));
    left_ = widest + 8 * scale_;
    right_ = options.width - 12 * scale_;
    head_ = line_ + 6 * scale_;
    const int foot = 2 * line_ + 10 * scale_;
    image_ = Image<float>(
        options.width, int(panels.size()) * (head_ + options.panel_height + 8 * scale_) + foot, 3);
    fill(image_, 0, 0, image_.width(), image_.height(), options.background);
  }

  void draw(int number, const PlotPanel& panel, bool last) {
    top_ = number * (head_ + options_.panel_height + 8 * scale_) + head_;
    range_ = range_of(panel);
    fill(image_, left_, top_, right_, bottom(), paper);
    for (const double at : options_.marks)
      if (at >= places_.front() && at <= places_.back())
        draw_stroke(image_, {across(at), double(top_)}, {across(at), bottom() - 1.0}, 2, mark);
    draw_axes(panel, last);
    if (panel.wanted && shown(panel, *panel.wanted)) draw_wanted(up(on_axis(panel, *panel.wanted)));
    for (int i = 0; i < int(panel.lines.size()); ++i)
      draw_line(panel, panel.lines[std::size_t(i)], colour_of(panel, i));
    draw_head(panel);
  }

  Image<float> finish() {
    const int y = image_.height() - line_ - 4 * scale_;
    TextStyle style{.colour = ink, .scale = scale_, .anchor = TextStyle::Anchor::centre};
    draw_text(image_, (left_ + right_) / 2, y, options_.across, style);
    if (!options_.marks.empty() && !options_.marked.empty()) {
      const int width = text_width(options_.marked, scale_);
      style.anchor = TextStyle::Anchor::right;
      draw_text(image_, right_, y, options_.marked, style);
      fill(image_, right_ - width - 8 * scale_, y, right_ - width - 6 * scale_, y + line_, mark);
    }
    return std::move(image_);
  }

 private:
  int tick_count() const { return std::max(2, options_.panel_height / (3 * line_)); }
  int bottom() const { return top_ + options_.panel_height; }

  double across(double place) const {
    const double first = places_.front(), last = places_.back();
    const double share = last > first ? (place - first) / (last - first) : 0.5;
    return left_ + 6 * scale_ + share * (right_ - left_ - 12 * scale_);
  }
  /// The row of a value on the axis.
  double up(double value) const {
    return bottom() - 1 - range_.share(value) * (options_.panel_height - 1);
  }

  void draw_axes(const PlotPanel& panel, bool last) {
    const std::vector<double> ticks = ticks_of(panel, range_, tick_count());
    const std::vector<std::string> texts = tick_texts(panel, ticks);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const double y = up(ticks[i]);
      draw_stroke(image_, {double(left_), y}, {right_ - 1.0, y}, grid_width, grid);
      draw_text(image_, left_ - 3 * scale_, int(std::lround(y)) - line_ / 2, texts[i],
                {.colour = ink, .scale = scale_, .anchor = TextStyle::Anchor::right});
    }
    for (const double x : {double(left_), right_ - 1.0})
      draw_stroke(image_, {x, double(top_)}, {x, bottom() - 1.0}, grid_width, goal);
    draw_stroke(image_, {double(left_), bottom() - 1.0}, {right_ - 1.0, bottom() - 1.0}, grid_width,
                goal);
    for (const double tick : ticks_across(places_, std::max(2, (right_ - left_) / (60 * scale_)))) {
      const double x = across(tick);
      draw_stroke(image_, {x, bottom() - 1.0}, {x, bottom() + 2.0 * scale_}, grid_width, goal);
      if (last)
        draw_text(image_, int(std::lround(x)), bottom() + 4 * scale_, fmt::format("{:g}", tick),
                  {.colour = ink, .scale = scale_, .anchor = TextStyle::Anchor::centre});
    }
  }

  void draw_wanted(double y) {
    for (double x = left_; x < right_; x += 10)
      draw_stroke(image_, {x, y}, {std::min(x + 5, right_ - 1.0), y}, 1.4, goal);
  }

  void draw_line(const PlotPanel& panel, const PlotLine& line, const Colour& colour) {
    const std::size_t count = places_.size();
    const auto point = [&](std::size_t i) {
      return Point{across(places_[i]), up(on_axis(panel, line.values[i]))};
    };
    const auto there = [&](std::size_t i) { return i < count && shown(panel, line.values[i]); };
    for (std::size_t i = 0; i < count; ++i) {
      if (!there(i)) continue;
      const bool alone = (i == 0 || !there(i - 1)) && !there(i + 1);
      if (there(i + 1)) draw_stroke(image_, point(i), point(i + 1), line_width, colour);
      if (alone || count <= most_dots)
        draw_stroke(image_, point(i), point(i), 2 * dot_radius, colour);
    }
  }

  void draw_head(const PlotPanel& panel) {
    const int y = top_ - line_ - 2 * scale_;
    draw_text(image_, left_, y, panel.title, {.colour = ink, .scale = scale_});
    int x = right_;
    for (int i = int(panel.lines.size()) - 1; i >= 0; --i) {
      const std::string& name = panel.lines[std::size_t(i)].name;
      x -= text_width(name, scale_);
      draw_text(image_, x, y, name, {.colour = ink, .scale = scale_});
      x -= 4 * scale_;
      draw_stroke(image_, {x - 12.0 * scale_, y + 0.4 * line_}, {double(x), y + 0.4 * line_},
                  line_width + 1, colour_of(panel, i));
      x -= 22 * scale_;
    }
  }

  const std::vector<double>& places_;
  const LinePlotOptions& options_;
  int scale_, line_;
  int left_ = 0, right_ = 0, head_ = 0, top_ = 0;
  Range range_{0, 1};
  Image<float> image_;
};

}  // namespace

Colour chart_line_colour(int line) {
  // Okabe and Ito's blue, vermilion, green and purple, each lighter than the one before.
  constexpr Colour colours[] = {
      {0.00f, 0.36f, 0.60f}, {0.84f, 0.37f, 0.00f}, {0.00f, 0.62f, 0.45f}, {0.80f, 0.60f, 0.75f}};
  return colours[line % 4];
}

Image<float> line_plot(const std::vector<double>& places, const std::vector<PlotPanel>& panels,
                       const LinePlotOptions& options) {
  check(places, panels, options);
  Page page(places, panels, options);
  for (int i = 0; i < int(panels.size()); ++i)
    page.draw(i, panels[std::size_t(i)], i + 1 == int(panels.size()));
  return page.finish();
}

}  // namespace mq
