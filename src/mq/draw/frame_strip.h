#pragma once
/// A frame of a sequence and what follows it, side by side, for strips of pictures over time.

#include <array>
#include <span>

#include "mq/base/progress.h"
#include "mq/draw/render.h"

namespace mq {

struct StripFrame {
  const Mesh& captured;
  std::span<const float> captured_colours = {};  ///< three per vertex; empty: none, drawn as clay
  const Mesh& followed;
  std::span<const float> followed_colours;  ///< three per vertex
};

struct StripOptions {
  View view = {};  ///< from where; its target is the middle of the captured frame
  double extent = 1;  ///< model units across a picture
  double most = 1;    ///< distance of the lightest colour, model units
  int side = 160;     ///< pixels
};

/// The captured frame; what follows it, in its colours; and the same in false colours of how far
/// each vertex is from the captured frame, dark 0, light `most` and more.
std::array<Image<float>, 3> draw_strip_frame(const StripFrame& frame, const StripOptions& options,
                                             const Progress& progress = {});

/// Per vertex a colour of where it is in the box around the mesh, so that neighbours have similar
/// ones and what is far apart has not: three values each.
std::vector<float> colours_of_places(const Mesh& mesh);

}  // namespace mq
