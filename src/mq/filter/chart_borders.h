#pragma once
/// Texels outside charts, chosen so that what is inside goes on: those that lookups at the borders
/// of charts read, and all others.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/atlas/coverage.h"
#include "mq/filter/seam_values.h"
#include "mq/image/image.h"

namespace mq {

/// 1 for the unknowns whose texel's centre no triangle covers; `coverage` is that of the space's
/// atlas (`texel_coverage`).
std::vector<char> border_texels(const TexelSpace& space, std::span<const Coverage> coverage);

/// `smooth_at_seams` of the values at `border` (1), with nothing there beyond the range that each
/// channel of ψ has: a border may extrapolate, a picture should not. Space, factory, report and
/// what is thrown as there.
Filtered continue_at_borders(const TexelSpace& space, const Signal& psi,
                             const std::vector<char>& border,
                             const SolverFactory& factory = economical_solver(),
                             const Progress& progress = {});

/// Gives the texels of one picture that are no unknowns of the space, as far as `distance` texels
/// from one that is (infinite: all), the values of the nearest one that a triangle covers: borders
/// go on across a seam, and nowhere else. Returns how many are no unknowns, near or far.
std::int64_t spread_past_borders(const TexelSpace& space, int texture, const Coverage& coverage,
                                 double distance, Image<float>& picture);

/// The same where the texels of the picture that are unknowns are those that a triangle covers, and `borders` of it.
std::int64_t spread_past_borders(std::span<const Texels::Place> borders, const Coverage& coverage, double distance,
                                 Image<float>& picture);

/// The same without end, but only around `some` of the unknowns (1): the others keep what is around them, up to
/// half-way.
void spread_past_borders_of(const std::vector<char>& some, const TexelSpace& space, int texture,
                            const Coverage& coverage, Image<float>& picture);

}  // namespace mq
