#pragma once
/// A vector field on a texture made visible by paths along it: line integral convolution as Cabral and Leedom
/// [cabral1993imaging] have it, over chart seams.

#include <array>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texel_vector_space.h"
#include "mq/trace/atlas_flow.h"

namespace mq {

/// What came of it, and what all steps of all paths did.
struct ConvolvedPaths {
  Signal signal;
  PathCounts counts;
};

/// Means of a signal along the integral curves of a field X with a vector per texel: at each texel, over the mean m of the
/// signal,
///
///     m + min(|X|, 1) Σ_k w_k (ψ(p(k·h)) − m) / Σ_k w_k,    dp/dt = X/|X|,  k = −K, ..., K,  K·h = length,
///     w_k = 1 + cos(πk/(K + 1)),
///
/// with steps h of about a texel. X has no unit: from length 1 on lines are clear, with less of it they fade, and there are
/// none where X vanishes. Fields are seen cell by cell of the texture, so that details are as fine as texels whatever the
/// triangles, and nothing is diffused across the field but by bilinear lookups.
///
/// Where a path ends, at a line that the field runs against from both sides or between charts of hardly a texel, it is
/// divided by what it has of Σ w_k; with less than half of it, it fades to m too, so that no texel stands out as noise. Texels whose
/// centre no chart covers are chosen such that lookups from both sides of seams agree (`agree_at_seams`).
class PathConvolution {
 public:
  /// All must outlive the object. z: two components per texel of the space.
  PathConvolution(const TexelVectorSpace& vectors, const TraceAtlas& domain, const Vector& z);

  /// `length` in model units, above 0. A constant comes back as it is.
  ConvolvedPaths draw(const Signal& signal, double length, const Progress& progress = {}) const;

 private:
  PathConvolution(const TexelVectorSpace& vectors, const TraceAtlas& domain, const Vector& z,
                  const std::vector<std::array<double, 2>>& along);

  const TraceAtlas& domain_;
  double spacing_;
  AtlasFlow forward_, backward_;
  TraceAtlas::Starts starts_;
  std::vector<float> clear_;  ///< min(|X|, 1) per texel
};

}  // namespace mq
