#pragma once
/// Values of a normal map in tangent space as those of one surface.

#include <memory>
#include <vector>

#include "mq/model/detail/texel_places.h"
#include "mq/model/normal_axes.h"

namespace mq {

/// Whether a stored vector is (0, 0, 1) to half a step of its code per channel.
bool is_flat(const Vector3& mapped, double half_step);

/// That of a picture of 8 or 16 bits, for vectors, with a hair for the rounding of floats; else 0.
double half_vector_step(Depth depth);

/// What a normal n of the map adds to the surface's own: d = n − N in the model's axes, N being the
/// unit shading normal where the texel lies. 0 where the map is flat; the same on both sides of a seam,
/// however the charts lie.
class TangentTexels {
 public:
  TangentTexels(std::shared_ptr<const ShadingFrames> frames, std::vector<TexelPlace> places);

  /// Of a stored vector of any length: one that is flat adds exactly 0. Of texels that lie nowhere
  /// 0.
  Vector3 deviation(int unknown, const Vector3& mapped, double half_step) const;

  /// The unit vector of the map that is normalise(N + d) in the model's axes. Where N + d vanishes it is N.
  Vector3 mapped(int unknown, const Vector3& deviation) const;

  /// N; 0 where the texel lies nowhere.
  Vector3 shading_normal(int unknown) const;

  const ShadingFrames& frames() const { return *frames_; }

 private:
  TangentFrame frame(int unknown) const {
    return frames_->at(places_[std::size_t(unknown)].point());
  }
  bool is_placed(int unknown) const { return places_[std::size_t(unknown)].triangle >= 0; }

  std::shared_ptr<const ShadingFrames> frames_;
  std::vector<TexelPlace> places_;
};

}  // namespace mq
