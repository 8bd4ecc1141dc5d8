// A sample belongs to a line when its distance to the line's segment is below the half width. What
// hides a line is asked where the line itself runs, not beside it: on a surface seen at a grazing
// angle the depth beside the line is another one.

#include "mq/draw/detail/lines.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace {

float reach(const LineStyle& style) { return style.half_width + style.casing; }

/// The farthest depth around a place, in the 3 × 3 samples that the band has of it.
float depth_around(const SampleBand& band, float x, float y) {
  const int column = std::clamp(int(std::floor(x)), 0, band.width - 1);
  const int row = std::clamp(int(std::floor(y)), band.first_row, band.first_row + band.rows - 1);
  float farthest = 0;
  for (int j = std::max(row - 1, band.first_row);
       j <= std::min(row + 1, band.first_row + band.rows - 1); ++j)
    for (int i = std::max(column - 1, 0); i <= std::min(column + 1, band.width - 1); ++i)
      farthest = std::max(farthest, band.depths[band.at(i, j)]);
  return farthest;
}

struct Marker {
  SampleBand& band;
  DepthRule rule;
  float depth_slack;
  std::vector<char>& mask;  ///< 0 nothing, 1 casing, 2 core

  bool hidden(const ScreenLine& line, float s) const {
    if (band.depths.empty()) return false;
    const float x = line.x0 + s * (line.x1 - line.x0), y = line.y0 + s * (line.y1 - line.y0);
    const float depth = rule == DepthRule::linear ? line.depth0 + s * (line.depth1 - line.depth0)
                                                  : 1 / ((1 - s) / line.depth0 + s / line.depth1);
    return depth > depth_around(band, x, y) + depth_slack;
  }

  void mark(const ScreenLine& line, const LineStyle& style) const {
    const float r = reach(style);
    const float dx = line.x1 - line.x0, dy = line.y1 - line.y0, square = dx * dx + dy * dy;
    const auto clipped = [](float v, int low, int high) {
      return int(std::clamp(std::floor(v), float(low), float(high)));
    };
    const int last_row = band.first_row + band.rows - 1;
    const int y0 = clipped(std::min(line.y0, line.y1) - r, band.first_row, last_row);
    const int y1 = clipped(std::max(line.y0, line.y1) + r, band.first_row, last_row);
    for (int y = y0; y <= y1; ++y) {
      // The part of this row within reach of the line, from where the line crosses the row's strip.
      float low = std::min(line.x0, line.x1), high = std::max(line.x0, line.x1);
      if (std::abs(dy) > 1e-3f) {
        const float a = std::clamp((float(y) - r - line.y0) / dy, 0.f, 1.f);
        const float b = std::clamp((float(y) + 1 + r - line.y0) / dy, 0.f, 1.f);
        low = line.x0 + std::min(a * dx, b * dx), high = line.x0 + std::max(a * dx, b * dx);
      }
      const int x0 = clipped(low - r, 0, band.width - 1), x1 = clipped(high + r, 0, band.width - 1);
      for (int x = x0; x <= x1; ++x) mark_sample(line, style, {dx, dy, square}, x, y);
    }
  }

  struct Segment {
    float dx, dy, square;
  };

  void mark_sample(const ScreenLine& line, const LineStyle& style, const Segment& segment, int x,
                   int y) const {
    char& kind = mask[band.at(x, y)];
    if (kind == 2) return;
    const float px = float(x) + 0.5f - line.x0, py = float(y) + 0.5f - line.y0;
    const float s = segment.square > 0
                        ? std::clamp((px * segment.dx + py * segment.dy) / segment.square, 0.f, 1.f)
                        : 0;
    const float distance = std::hypot(px - s * segment.dx, py - s * segment.dy);
    if (distance > reach(style)) return;
    const char wanted = distance <= style.half_width ? 2 : 1;
    if (wanted > kind && !hidden(line, s)) kind = wanted;
  }
};

void blend(const Colour& colour, float opacity, std::array<float, 4>& under) {
  for (int k = 0; k < 3; ++k) under[k] = opacity * colour[k] + (1 - opacity) * under[k];
  under[3] = opacity + (1 - opacity) * under[3];
}

}  // namespace

void draw_lines(const std::vector<ScreenLine>& lines, const std::vector<int>& order,
                const std::vector<LineStyle>& styles, DepthRule rule, float depth_slack,
                SampleBand& band) {
  if (order.empty()) return;
  std::vector<char> mask;
  for (std::size_t k = 0; k < styles.size(); ++k) {
    mask.assign(band.colours.size(), 0);
    const Marker marker{band, rule, depth_slack, mask};
    for (const int id : order)
      if (lines[id].style == int(k)) marker.mark(lines[id], styles[k]);
    for (std::size_t i = 0; i < mask.size(); ++i)
      if (mask[i] == 2)
        blend(styles[k].colour, styles[k].opacity, band.colours[i]);
      else if (mask[i] == 1)
        blend(styles[k].casing_colour, styles[k].casing_opacity, band.colours[i]);
  }
}

std::vector<std::vector<int>> lines_by_band(const std::vector<ScreenLine>& lines,
                                            const std::vector<LineStyle>& styles,
                                            const Bands& bands) {
  std::vector<std::vector<int>> ids(bands.count);
  const auto band_of = [&](float y) {
    return int(std::clamp(std::floor(y / float(bands.rows)), 0.f, float(bands.count - 1)));
  };
  const float bottom = float(bands.rows) * float(bands.count);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const ScreenLine& line = lines[i];
    const float r = reach(styles[line.style]);
    const float top = std::min(line.y0, line.y1) - r, low = std::max(line.y0, line.y1) + r;
    if (!(low >= 0 && top <= bottom)) continue;
    for (int b = band_of(top); b <= band_of(low); ++b) ids[b].push_back(int(i));
  }
  return ids;
}

}  // namespace mq
