#pragma once
/// Lines of constant width over a picture that is drawn in samples; hidden where a surface is in
/// front. Used inside this room.

#include <vector>

#include "mq/draw/samples.h"
#include "mq/image/colour.h"

namespace mq {

/// A line between two projected points. Units are samples; depth as of `Camera::project`.
struct ScreenLine {
  float x0, y0, depth0;
  float x1, y1, depth1;
  int style;
};

/// How lines look: a core and a casing around it, so that they show on any picture.
struct LineStyle {
  Colour colour = {0, 0, 0};
  float opacity = 1;
  float half_width = 1;  ///< of the core, samples
  float casing = 0;      ///< beyond it on both sides, samples
  Colour casing_colour = {0, 0, 0};
  float casing_opacity = 0;
};

/// Where depth at the screen fraction s of a line comes from.
enum class DepthRule { linear, reciprocal };

/// Draws lines (`order`: ids in `lines`) over the band. Styles are drawn in their order, each
/// blended once per sample however many of its lines cover it. A line is hidden where the band's
/// surface is nearer than the line by more than `depth_slack`.
void draw_lines(const std::vector<ScreenLine>& lines, const std::vector<int>& order,
                const std::vector<LineStyle>& styles, DepthRule rule, float depth_slack,
                SampleBand& band);

/// Bands that cover a picture: band b has the sample rows [b · rows, (b + 1) · rows).
struct Bands {
  int rows = 0;
  int count = 0;
};

/// The ids of lines that touch each band, ascending.
std::vector<std::vector<int>> lines_by_band(const std::vector<ScreenLine>& lines,
                                            const std::vector<LineStyle>& styles,
                                            const Bands& bands);

}  // namespace mq
