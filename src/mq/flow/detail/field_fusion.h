#pragma once
/// One field of several, pixel by pixel.

#include <vector>

#include "mq/flow/detail/field_claims.h"
#include "mq/flow/detail/image_aligner.h"

namespace mq {

/// Of several straight fields X_k the one that at each pixel brings the signals of this scale nearest to each other,
/// φ₀(p − X_k/2) to φ₁(p + X_k/2), and changes least from pixel to pixel: labels k of least
///
///     Σ_p C(p, k_p) + Σ over neighbours p, q of λ·min(1, |X_k(p) − X_j(q)|/τ)
///
/// by sums along lines (scan_lines.h) in place of the fusion moves of [lempitsky2008fusionflow]. C is the `misfit`, a
/// little more for all but the first field and for long vectors: where several motions fit, as in a pattern or on a
/// plain ground, the shortest is meant. Of equal labels the first.
Image<float> fused(const ImageScale& at, const std::vector<Image<float>>& fields, const FieldClaims& claims);

/// C of a straight field halfway, 0 to 1, in one channel: the mean around p of differences that are cut off. Where an
/// image is left, or shows there what moves otherwise, it is 0.6; where both are, 1.
Image<float> misfit(const SignalPair& signals, const Image<float>& field, const FieldClaims& claims = {});

/// The same along other ways.
Image<float> misfit(const SignalPair& signals, const Image<float>& field, const FieldWays& ways,
                    const FieldClaims& claims);

/// A misfit above this is one where two images are seen.
inline constexpr float unlike_misfit = 0.6F;

}  // namespace mq
