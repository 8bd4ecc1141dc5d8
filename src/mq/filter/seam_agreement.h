#pragma once
/// Texels beside charts, chosen so that lookups on both sides of a seam agree.

#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/trace/trace_atlas.h"

namespace mq {

/// A signal φ made of another, ψ, with φ + δ where texels on both sides of a seam are to agree better: δ minimises
///
///     ∫ (d(φ + δ) − κ·d(ψ))² ds + Σ ε δ²,    d the difference of both sides, bilinear in each chart,
///
/// over all seams, ds in texels: by points along them half a texel apart, and conjugate gradients to 10⁻³. `kept` is κ
/// per texel: 1 where nothing has happened, so that the difference there was is there still, down to 0. ε is 10⁻⁴ at
/// texels that are `outside` (1), whose centre no chart covers, so that nobody sees them but by lookups at seams, and
/// `hold / (1 − κ)` at others: where κ is 1 they stay as they are, bit for bit. No value leaves the range of its channel
/// in φ. Costs up to 100 products of a row per point.
Signal agree_at_seams(const TraceAtlas& domain, const Signal& signal, const Signal& before, const Vector& kept,
                      const std::vector<char>& outside, const Progress& progress = {});

}  // namespace mq
