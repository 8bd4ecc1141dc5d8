// Texel coordinates are mapped to samples by one scale and an offset. Triangles are filled in bands
// of sample rows: a sample belongs to a triangle when its centre lies in it. Lines are those of
// lines.h, with nothing to hide them.

#include "mq/draw/uv_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/detail/lines.h"
#include "mq/draw/detail/textures.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

using Fill = UvLayoutOptions::Fill;
using Lines = RenderOptions::Lines;

constexpr int band_rows = 32;                      ///< pixels
constexpr Colour paper = {0.93f, 0.935f, 0.945f};  ///< beyond the texture
constexpr Colour overlap_colour = {0.9f, 0.05f, 0.05f};
constexpr Colour grid_colour = {0.1f, 0.1f, 0.12f};
constexpr double grid_from = 8;  ///< pixels per texel

/// Which part of the plane of texels is shown, and how large.
struct Window {
  double left = 0, top = 0;   ///< texel coordinates of the picture's upper left corner
  double scale = 1;           ///< samples per texel
  int width = 0, height = 0;  ///< pixels

  float x(double column) const { return float((column - left) * scale); }
  float y(double row) const { return float((row - top) * scale); }
  double column(int sample) const { return left + (sample + 0.5) / scale; }
  double row(int sample) const { return top + (sample + 0.5) / scale; }
};

/// The texture and all its charts, or the part asked for.
Window window_on(const Surface& surface, const Atlas& atlas, const UvLayoutOptions& options) {
  const TextureSize& size = atlas.textures[options.texture];
  double left = -0.5, top = -0.5, right = size.width - 0.5, bottom = size.height - 0.5;
  if (options.zoom <= 1) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      if (atlas.chart[t] >= 0 && surface.mesh.texture(t) == options.texture)
        for (const TexelPoint& p : atlas.corners[t]) {
          left = std::min(left, p.column()), right = std::max(right, p.column());
          top = std::min(top, p.row()), bottom = std::max(bottom, p.row());
        }
  } else {
    const TexelPoint center = texel_point(options.center, size.width, size.height);
    const double half_x = size.width / options.zoom / 2, half_y = size.height / options.zoom / 2;
    left = center.column() - half_x, right = center.column() + half_x;
    top = center.row() - half_y, bottom = center.row() + half_y;
  }
  Window window;
  const double pixels = options.side / std::max(right - left, bottom - top);
  window.width = std::max(1, int(std::lround((right - left) * pixels)));
  window.height = std::max(1, int(std::lround((bottom - top) * pixels)));
  window.left = left, window.top = top;
  window.scale = pixels * options.samples;
  return window;
}

enum Style { wire, border, end, seam, style_count };

/// Lines are thinner where charts are so many that they would hide them: at most a sixteenth of the
/// side of a square of the mean chart's area, at least half a pixel.
float half_width(const Atlas& atlas, const Window& window, const UvLayoutOptions& options) {
  double area = 0;
  int count = 0;
  for (const Chart& chart : atlas.charts)
    if (chart.texture == options.texture) area += chart.texel_area, ++count;
  const double side = count > 0 ? std::sqrt(area / count) * window.scale / options.samples : 1e9;
  const double width = std::clamp(side / 16, std::min(0.5, options.line_width), options.line_width);
  return float(width * options.samples / 2);
}

std::vector<LineStyle> line_styles(float half) {
  std::vector<LineStyle> styles(style_count);
  styles[wire] = {{0.05f, 0.05f, 0.07f}, 0.35f, half / 3, 0, {}, 0};
  styles[border] = {{0.45f, 0.47f, 0.5f}, 1, half / 2, 0, {}, 0};
  styles[end] = {{0.25f, 0.65f, 1.f}, 1, half, 0.5f * half, {0.02f, 0.03f, 0.05f}, 0.6f};
  styles[seam] = {{1.f, 0.45f, 0.05f}, 1, half, 0.5f * half, {0.05f, 0.03f, 0.02f}, 0.6f};
  return styles;
}

std::vector<ScreenLine> lines_of(const Surface& surface, const Atlas& atlas, const Window& window,
                                 const UvLayoutOptions& options) {
  std::vector<ScreenLine> lines;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3;
    if (atlas.chart[t] < 0 || surface.mesh.texture(t) != options.texture) continue;
    const bool inside = atlas.edges[h] == EdgeKind::inside;
    if ((inside ? options.wires : options.seams) != Lines::show) continue;
    if (inside && h > surface.twins[h]) continue;
    const TexelPoint &a = atlas.corners[t][h % 3], &b = atlas.corners[t][(h % 3 + 1) % 3];
    lines.push_back({window.x(a.column()), window.y(a.row()), 0, window.x(b.column()),
                     window.y(b.row()), 0,
                     inside                             ? wire
                     : atlas.edges[h] == EdgeKind::seam ? seam
                                                        : end});
  }
  const TextureSize& size = atlas.textures[options.texture];
  const float x0 = window.x(-0.5), x1 = window.x(size.width - 0.5);
  const float y0 = window.y(-0.5), y1 = window.y(size.height - 0.5);
  for (const auto& [ax, ay, bx, by] : {std::array{x0, y0, x1, y0}, std::array{x1, y0, x1, y1},
                                       std::array{x1, y1, x0, y1}, std::array{x0, y1, x0, y0}})
    lines.push_back({ax, ay, 0, bx, by, 0, border});
  return lines;
}

/// Triangles per band of sample rows.
std::vector<std::vector<int>> triangles_by_band(const Surface& surface, const Atlas& atlas,
                                                const Window& window, const Bands& bands,
                                                int texture) {
  std::vector<std::vector<int>> ids(bands.count);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (atlas.chart[t] < 0 || surface.mesh.texture(t) != texture) continue;
    double low = 1e300, high = -1e300;
    for (const TexelPoint& p : atlas.corners[t]) {
      low = std::min(low, double(window.y(p.row())));
      high = std::max(high, double(window.y(p.row())));
    }
    const auto band = [&](double y) { return std::floor(y / bands.rows); };
    const int first = int(std::max(0.0, band(low))),
              last = int(std::min(bands.count - 1.0, band(high)));
    for (int b = first; b <= last; ++b) ids[b].push_back(t);
  }
  return ids;
}

/// Which chart each sample lies in: -1 none, -2 more than one layer.
struct ChartMap {
  const SampleBand& band;
  std::vector<int> charts;
  static constexpr int several = -2;

  explicit ChartMap(const SampleBand& samples)
      : band(samples), charts(samples.colours.size(), -1) {}

  void fill(const Window& window, const std::array<TexelPoint, 3>& corners, int chart) {
    std::array<double, 3> x, y;
    for (int k = 0; k < 3; ++k) {
      x[k] = (corners[k].column() - window.left) * window.scale - 0.5;
      y[k] = (corners[k].row() - window.top) * window.scale - 0.5;
    }
    const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (area == 0) return;
    const auto clipped = [](double v, int low, int high) {
      return int(std::clamp(v, double(low), double(high)));
    };
    const auto [x_low, x_high] = std::ranges::minmax(x);
    const auto [y_low, y_high] = std::ranges::minmax(y);
    if (x_high < 0 || x_low > band.width - 1) return;
    const int x0 = clipped(std::ceil(x_low), 0, band.width - 1);
    const int x1 = clipped(std::floor(x_high), 0, band.width - 1);
    const int y0 = clipped(std::ceil(y_low), band.first_row, band.first_row + band.rows - 1);
    const int y1 = clipped(std::floor(y_high), band.first_row, band.first_row + band.rows - 1);
    for (int row = y0; row <= y1; ++row)
      for (int column = x0; column <= x1; ++column) {
        double least = 1;
        for (int k = 0; k < 3; ++k) {
          const int i = (k + 1) % 3, j = (k + 2) % 3;
          least = std::min(
              least, ((x[i] - column) * (y[j] - row) - (x[j] - column) * (y[i] - row)) / area);
        }
        if (least >= 0) put(band.at(column, row), chart, least);
      }
  }

  /// A sample on the edge between two triangles is no overlap.
  void put(std::size_t at, int chart, double least_weight) {
    constexpr double strictly = 1e-6;
    if (charts[at] == -1)
      charts[at] = chart;
    else if (least_weight > strictly && inner_[at])
      charts[at] = several;
    inner_[at] = inner_[at] || least_weight > strictly;
  }

 private:
  std::vector<char> inner_ = std::vector<char>(charts.size());
};

/// The texture as it is looked up: averaged where it is shown small.
struct Source {
  Image<float> image;
  double scale_x = 1, scale_y = 1;  ///< of texel coordinates
  Wrap wrap = Wrap::clamp;

  Colour at(double column, double row) const {
    const double x = (column + 0.5) * scale_x, y = (row + 0.5) * scale_y;  // nearest pixel
    const auto pixel = image.pixel(wrapped(std::int64_t(std::floor(x)), image.width(), wrap),
                                   wrapped(std::int64_t(std::floor(y)), image.height(), wrap));
    return {pixel[0], pixel[1], pixel[2]};
  }
};

Source source_of(const Image<float>& picture, const Window& window, Wrap wrap) {
  Source source;
  source.wrap = wrap;
  if (window.scale >= 1) {
    source.image = as_rgb(picture);
    return source;
  }
  const int width = std::max(1, int(std::lround(picture.width() * window.scale)));
  const int height = std::max(1, int(std::lround(picture.height() * window.scale)));
  source.scale_x = double(width) / picture.width();
  source.scale_y = double(height) / picture.height();
  source.image = as_rgb(area_scaled(picture, width, height));
  return source;
}

Colour mixed(const Colour& a, const Colour& b, float t) {
  Colour colour;
  for (int k = 0; k < 3; ++k) colour[k] = a[k] + t * (b[k] - a[k]);
  return colour;
}

struct Job {
  const Surface& surface;
  const Atlas& atlas;
  const UvLayoutOptions& options;
  const Window& window;
  const Source* source;  ///< null: no picture

  Colour colour(int chart, double column, double row, int x, int y) const {
    const TextureSize& size = atlas.textures[options.texture];
    const bool within =
        column >= -0.5 && column < size.width - 0.5 && row >= -0.5 && row < size.height - 0.5;
    const bool seen = source != nullptr && (within || source->wrap == Wrap::repeat);
    Colour base = seen ? source->at(column, row) : within ? Colour{1, 1, 1} : paper;
    if (chart == -1) return seen ? mixed(base, paper, within ? 0.72f : 0.88f) : base;
    if (chart == ChartMap::several) {
      const int stripe = 3 * options.samples;
      return (x + y) / stripe % 2 == 0 ? mixed(base, overlap_colour, 0.75f) : base;
    }
    if (source == nullptr) return chart_colour(chart);
    return options.fill == Fill::tinted_texture ? mixed(base, chart_colour(chart), 0.28f) : base;
  }

  bool on_grid(double column, double row) const {
    const double pixels = window.scale / options.samples;
    if (pixels < grid_from) return false;
    const auto off = [&](double v) { return std::abs(v + 0.5 - std::round(v + 0.5)) * pixels; };
    return std::min(off(column), off(row)) < 0.5;
  }

  void paint(const std::vector<int>& triangles, SampleBand& band) const {
    ChartMap map(band);
    for (const int t : triangles) map.fill(window, atlas.corners[t], atlas.chart[t]);
    for (int y = band.first_row; y < band.first_row + band.rows; ++y)
      for (int x = 0; x < band.width; ++x) {
        const double column = window.column(x), row = window.row(y);
        Colour result = colour(map.charts[band.at(x, y)], column, row, x, y);
        if (on_grid(column, row)) result = mixed(result, grid_colour, 0.18f);
        band.colours[band.at(x, y)] = {result[0], result[1], result[2], 1};
      }
  }
};

void check(const Atlas& atlas, const Image<float>* picture, const UvLayoutOptions& options) {
  if (options.texture < 0 || options.texture >= int(atlas.textures.size()))
    throw InvalidInput(fmt::format("there is no texture {}: the atlas has {}", options.texture,
                                   atlas.textures.size()));
  Atlas only;
  only.textures = {atlas.textures[options.texture]};
  if (picture != nullptr || options.fill != Fill::charts) check_textures(only, {picture});
  require(options.side >= 1 && options.side <= 16384, "a layout has from 1 to 16384 pixels a side");
  require(options.samples >= 1 && options.samples <= 16,
          "samples per pixel and direction are from 1 to 16");
  require(options.zoom > 0 && options.zoom <= 1e6 && options.center.cwiseAbs().maxCoeff() <= 100,
          "the zoom is above 0 and at most 1e6, its centre within 100 tiles");
  require(options.line_width > 0 && options.line_width <= 100,
          "the width of lines is above 0 and at most 100 pixels");
}

}  // namespace

Image<float> draw_uv_layout(const Surface& surface, const Atlas& atlas, const Image<float>* picture,
                            const UvLayoutOptions& options, const Progress& progress) {
  check(atlas, picture, options);
  const Window window = window_on(surface, atlas, options);
  const int samples = options.samples;
  const Bands bands{band_rows * samples, (window.height + band_rows - 1) / band_rows};
  const std::vector<LineStyle> styles = line_styles(half_width(atlas, window, options));
  const std::vector<ScreenLine> lines = lines_of(surface, atlas, window, options);
  const auto line_ids = lines_by_band(lines, styles, bands);
  const auto triangle_ids = triangles_by_band(surface, atlas, window, bands, options.texture);
  const bool with_picture = options.fill != Fill::charts;
  const Source source =
      with_picture ? source_of(*picture, window, atlas.textures[options.texture].wrap) : Source();
  const Job job{surface, atlas, options, window, with_picture ? &source : nullptr};

  Image<float> layout(window.width, window.height, 3);
  std::atomic<int> done{0};
  parallel_for(
      bands.count,
      [&](std::int64_t b) {
        const int begin = int(b) * band_rows, end = std::min(begin + band_rows, window.height);
        SampleBand band(window.width * samples, begin * samples, (end - begin) * samples);
        job.paint(triangle_ids[b], band);
        draw_lines(lines, line_ids[b], styles, DepthRule::linear, 0, band);
        resolve(band, samples, {}, begin, end, layout);
        progress.at(double(++done) / bands.count);
      },
      1);
  return layout;
}

}  // namespace mq
