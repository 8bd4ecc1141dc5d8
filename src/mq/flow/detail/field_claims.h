#pragma once
/// Which pixels of two images are shown at which place between them, and so which are hidden.

#include <vector>

#include "mq/flow/detail/image_warp.h"

namespace mq {

/// Of each pixel of both images the vector X of the place between them that it is shown at; NaN where none is known.
struct FieldClaims {
  Image<float> source, target;
};

/// Pixels p of a straight field at time t come from p − tX(p) and go to p + (1 − t)X(p), whose four neighbours they
/// claim where their `misfit` is no more than `surest`; of several the least one has it, of equal ones the first.
FieldClaims claimed(const Image<float>& field, double time, const Image<float>& misfit);

/// Whether the place p + `way` belongs to what moves otherwise than X.
bool is_of_others(const Image<float>& claims, int x, int y, const float* way, const float* X);

/// Where pixels of a field lie in the source and in the target, from their own place.
struct FieldWays {
  Image<float> back, forth;
};
FieldWays ways_along(const Image<float>& field, double time, FlowPath path);

/// Whether a pixel's place in an image is outside, or of others; `claims` may be empty.
bool is_hidden(const Image<float>& field, const Image<float>& way, const Image<float>& claims, int x, int y);

/// In how many of the two images it is.
inline int times_hidden(const Image<float>& field, const FieldWays& ways, const FieldClaims& claims, int x, int y) {
  return int(is_hidden(field, ways.back, claims.source, x, y)) + int(is_hidden(field, ways.forth, claims.target, x, y));
}

/// Of all pixels halfway along a straight field, whether they are seen in both images.
std::vector<char> seen_in_both(const Image<float>& field, const FieldClaims& claims);

}  // namespace mq
