#pragma once
/// Numbers over a common axis as lines, one panel above the other.
///
///     line_plot(frames, {{.title = "distance [% of the diagonal]", .lines = {{"mean", mean}}}});

#include <optional>
#include <string>
#include <vector>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

struct PlotLine {
  std::string name;
  std::vector<double> values;  ///< one per place; what is not finite leaves a gap
  /// The number of its colour, so that a line has it whichever others are drawn; −1: its place.
  int colour = -1;
};

struct PlotPanel {
  std::string title;  ///< what is shown, and its unit in brackets
  std::vector<PlotLine> lines;
  enum class Scale {
    linear,      ///< from `base`, or from the least value where that is less, to the largest, and
                 ///< at least over a thousandth of it
    logarithmic  ///< whole powers of ten; values not above 0 leave a gap
  } scale = Scale::linear;
  double base = 0;
  std::optional<double> wanted = {};  ///< drawn as a dashed line
};

struct LinePlotOptions {
  int width = 1200;                ///< pixels
  int panel_height = 240;          ///< of the axes of each panel
  int text_scale = 2;              ///< of all words
  std::string across = "frame";    ///< what the places are, and their unit
  std::vector<double> marks = {};  ///< places marked by an upright line
  std::string marked = {};         ///< what they are; said below the last panel
  Colour background = {0.98f, 0.98f, 0.985f};
};

/// Red, green and blue. All panels share the places, ascending, and every line has a value for
/// each; lines are told apart by colour and by lightness, single points between gaps are dots.
/// Throws `InvalidInput` where there is no place or panel, sizes do not agree, places do not
/// ascend, or the picture is too small for its words.
Image<float> line_plot(const std::vector<double>& places, const std::vector<PlotPanel>& panels,
                       const LinePlotOptions& options = {});

/// The colour of the line with this number in its panel.
Colour chart_line_colour(int line);

}  // namespace mq
