#pragma once
/// What the panes show and how.

#include <optional>
#include <string>
#include <vector>

#include "mq/draw/false_colour.h"

namespace mq::view {

struct Look {
  enum class Paint {
    texture,  ///< as it looks
    clay,     ///< the shape alone
    charts,   ///< a colour for each chart
    stretch,  ///< ratio of the singular values of each triangle's map to its texture
    density,  ///< log2 of the surface's area per texel, over its mean
    numbers,  ///< one channel of the textures in false colours
    vertex_colours,
    normals,          ///< the texture is a map of normals in the model's axes
    tangent_normals,  ///< ... in axes along the texture
    lifespans,        ///< of a sequence's triangles
  } paint = Paint::texture;
  bool lit = true;
  bool seams = false, wires = false, chart_tint = false;
  double exposure = 0;  ///< of textures that hold light: stops
  int channel = 0;      ///< of numbers
  FalseColour scale = {};
  bool automatic_scale = true;  ///< from the smallest to the largest value
  double wipe = -1;  ///< before on the left of this fraction of the pane; < 0: after alone
};

inline const std::vector<std::string> paint_names = {
    "texture", "clay",           "charts",  "stretch",         "density",
    "numbers", "vertex-colours", "normals", "tangent-normals", "lifespans"};

inline bool shows_numbers(const Look& look) {
  using enum Look::Paint;
  return look.paint == numbers || look.paint == stretch || look.paint == density;
}

}  // namespace mq::view
