#pragma once
/// What a model shows anywhere on it, in all its channels.

#include <span>
#include <vector>

#include "mq/mesh/surface_point.h"
#include "mq/model/textured_model.h"
#include "mq/model/value_space.h"

namespace mq {

/// Textures, bilinear, or where there are none colours at vertices. Grey beside colours is spread
/// over three channels; where one has alpha and another not, it is 1. Model and mesh must stay.
class SourceColours {
 public:
  /// Decodes the pictures. `mesh` is the model's, some of its triangles flipped. Throws
  /// `InvalidInput` as `bake` does.
  SourceColours(const Model& model, const Mesh& mesh, const ValueSpace& values);

  int channels() const { return channels_; }
  Depth depth() const { return depth_; }

  /// Mean distance of texels, or of vertices, on the model.
  double spacing() const { return spacing_; }

  /// The values at a point of the mesh; false where it shows nothing.
  bool at(const SurfacePoint& point, std::span<double> values) const;

 private:
  void read_textures(const ValueSpace& values);
  void read_vertices();

  const Model& model_;
  const Mesh& mesh_;
  std::vector<Image<float>> pictures_;  ///< empty where colours are at vertices
  int channels_ = 0;
  TransferFunction transfer_ = TransferFunction::srgb;
  Depth depth_ = Depth::u8;
  double spacing_ = 0;
};

}  // namespace mq
