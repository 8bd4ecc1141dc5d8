#pragma once
/// About how long photographs take, so that a progress goes as time does.

#include <span>

#include "mq/model/photograph_texture.h"

namespace mq {

/// Seconds of one core, as measured with 4, 8 and 16 photographs of 900 × 900 pixels and a texture of 1024²: only how
/// they compare matters. Aligning grows with the square of the number at first, as more of them show each place, and
/// then with the number.
struct PhotographCosts {
  double places = 0;         ///< to find where texels lie
  double read_to_align = 0;
  double align = 0;
  double look = 0;
  double choose = 0;
  double take = 0;

  double aligned() const { return read_to_align + align; }
  double looked() const { return places + aligned() + look + choose; }
};

/// For a texture of so many texels.
PhotographCosts photograph_costs(std::span<const Photograph> photographs, double texels,
                                 const PhotographTextureOptions& options);

}  // namespace mq
