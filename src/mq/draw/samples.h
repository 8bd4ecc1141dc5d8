#pragma once
/// Pictures are drawn in bands of rows, several samples to a pixel, and then averaged.
/// Used inside this room.

#include <array>
#include <vector>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

/// What is behind the model.
struct Backdrop {
  enum class Kind {
    gradient,    ///< light grey, a little darker towards the corners
    colour,      ///< `colour`
    transparent  ///< nothing: the picture has an alpha channel
  } kind = Kind::gradient;
  Colour colour = {1, 1, 1};

  int channels() const { return kind == Kind::transparent ? 4 : 3; }
  /// Its colour at a pixel of a picture of width × height.
  Colour at(int x, int y, int width, int height) const;
};

/// Some rows of samples: colours with their opacity multiplied in, and the depth of what they show.
struct SampleBand {
  int width = 0, first_row = 0, rows = 0;
  std::vector<std::array<float, 4>> colours;
  std::vector<float> depths;  ///< infinite where there is nothing; empty: nothing hides lines

  SampleBand(int sample_width, int first, int count)
      : width(sample_width),
        first_row(first),
        rows(count),
        colours(std::size_t(sample_width) * count, std::array<float, 4>{0, 0, 0, 0}) {}
  std::size_t at(int x, int row) const { return std::size_t(row - first_row) * width + x; }
};

/// Averages samples² samples to each pixel of the picture's rows [begin, end), all in the band, and
/// puts them in front of the backdrop. A transparent picture's colours are not multiplied by alpha.
void resolve(const SampleBand& band, int samples, const Backdrop& backdrop, int begin, int end,
             Image<float>& picture);

}  // namespace mq
