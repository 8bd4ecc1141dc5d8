#pragma once
/// What a model shows anywhere on it, in all its channels.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "mq/io/materials.h"
#include "mq/mesh/surface_point.h"
#include "mq/model/baked_signal.h"
#include "mq/model/textured_model.h"
#include "mq/model/value_space.h"

namespace mq {

/// Textures, bilinear, or where there are none colours at vertices. Grey beside colours is spread
/// over three channels; where one has alpha and another not, it is 1. A triangle whose material has no
/// picture shows what the slot has without one: 1, or a flat normal, times its factor where factors are
/// applied; 0 where that is 0. Model and mesh must stay.
class SourceColours {
 public:
  /// Decodes the pictures into `values`. `mesh` is the model's, some of its triangles flipped. Throws
  /// `InvalidInput` as `bake` does.
  SourceColours(const Model& model, const Mesh& mesh, const ValueSpace& values,
                const BakeOptions& options);

  int channels() const { return channels_; }

  /// Whether they are light, as pictures hold it.
  bool is_light() const { return is_light_; }
  Depth depth() const { return depth_; }

  /// Mean distance of texels, or of vertices, on the model.
  double spacing() const { return spacing_; }

  /// The values at a point of the mesh; false where it shows nothing.
  bool at(const SurfacePoint& point, std::span<double> values) const;

 private:
  void read_textures(const ValueSpace& values);
  void read_vertices(const BakeOptions& options);
  void read_materials(BakeOptions::Factors factors);
  void look_up(int texture, const SurfacePoint& point, std::span<double> values) const;
  void fill(const std::array<double, 4>& colour, std::span<double> values) const;
  SlotFactor tint_at(const SurfacePoint& point) const;
  double to_light(double value) const;
  double to_space(double light) const;
  void multiply(const SlotFactor& by, std::span<double> values) const;

  const Model& model_;
  const Mesh& mesh_;
  std::vector<Image<float>> pictures_;  ///< empty where colours are at vertices
  int channels_ = 0;
  TransferFunction transfer_ = TransferFunction::srgb;
  ColourSpace space_ = ColourSpace::stored;
  VertexSignal colours_;  ///< at vertices, as displayed
  bool tints_ = false;    ///< whether colours at vertices multiply the textures
  ModelMaterials materials_;
  std::vector<SlotFactor> factors_;  ///< per material; empty where they stay apart
  std::vector<std::optional<std::array<double, 4>>> bare_;  ///< per material what it shows without a picture
  bool is_light_ = false;
  Depth depth_ = Depth::u8;
  double spacing_ = 0;
};

}  // namespace mq
