#pragma once
/// In which axes the vectors of a normal map are, and how those in tangent space come to the model's.

#include <span>
#include <string>

#include "mq/atlas/coverage.h"
#include "mq/mesh/tangent_frames.h"
#include "mq/model/textured_model.h"
#include "mq/model/value_space.h"

namespace mq {

/// What the texels inside charts say of a normal map.
struct NormalMapShares {
  double upright = 0;  ///< within 60° of z: nearly all in a map in tangent space
  double below = 0;    ///< with z < 0, none in a map in tangent space
  double far_off = 0;  ///< of lengths below 3/4 or above 5/4
  bool without_z = false;  ///< blue is black everywhere
};

/// Of the pictures of a model that has an atlas; `coverage` is that of the atlas.
NormalMapShares normal_map_shares(const TexturedModel& model, std::span<const Coverage> coverage);

/// The axes that are asked for; for `as_found` tangent space in normal slots of glTF, which knows no
/// other, and elsewhere where at least 9 of 10 normals are upright; else object.
NormalAxes found_axes(const TexturedModel& model, NormalAxes asked, const NormalMapShares& shares);

/// Whether charts lie on top of each other, beyond what rounding by who made them does, so that one
/// texel would be another normal in each.
bool charts_overlap(std::span<const Coverage> coverage);

/// The frames of a model's triangles, and where they are from.
class ShadingFrames {
 public:
  /// Those of the model's file, or that it had, completed (`file_frames`, `tangent_frames`). Throws
  /// what these throw. With `tangent_down` the map's y is turned.
  ShadingFrames(const TexturedModel& model, NormalAxes axes);

  TangentFrame at(const SurfacePoint& point) const;

  /// "normals of the file, tangents as MikkTSpace has them"
  const std::string& source() const { return source_; }

 private:
  CornerFrames frames_;
  double up_ = 1;
  std::string source_;
};

}  // namespace mq
