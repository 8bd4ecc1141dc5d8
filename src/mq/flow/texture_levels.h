#pragma once
/// An atlas at sizes from fine to coarse, and how signals and fields go between them.

#include <memory>
#include <vector>

#include "mq/fem/texel_vector_space.h"
#include "mq/linear/block_multigrid.h"
#include "mq/trace/trace_atlas.h"

namespace mq {

/// A texture with what flow asks of it. Fields have a complex number z per texel in its plane.
class FlowTexture {
 public:
  /// All must outlive the object.
  FlowTexture(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Progress& progress = {});

  int size() const { return space_->size(); }
  double area() const { return space_->scale().area; }
  double spacing() const { return space_->scale().texel_spacing; }
  const Atlas& atlas() const { return *atlas_; }
  /// Of a picture at this size, beside which charts may lie that share texels with others (`FlowTextures`).
  Vector2 own_size(int picture) const {
    return {double(sizes_[std::size_t(picture)].width), double(sizes_[std::size_t(picture)].height)};
  }
  const TexelSpace& space() const { return *space_; }
  const TexelVectorSpace& vectors() const { return vectors_; }
  const TraceAtlas& domain() const { return domain_; }
  const TraceAtlas::Starts& starts() const { return starts_; }
  const Vector& lumped_mass() const { return mass_; }
  /// Conductivities of smoothness: 1, but less for elements that are stretched more than 16 : 1, such as slivers.
  const std::vector<float>& limits() const { return limits_; }

  /// P of the multigrid cycles that solve for fields; made when first asked for.
  const std::vector<std::shared_ptr<const BlockTransfer>>& transfers() const;

  /// A signal with what lookups find in place of the values of texels that lie outside their chart, which may be
  /// anything, such as the ground of an atlas.
  Signal shown(const Signal& signal) const;

 private:
  friend class FlowTextures;
  std::unique_ptr<const Atlas> own_atlas_;       ///< of a coarser texture
  std::unique_ptr<const TexelSpace> own_space_;  ///< and its space
  std::vector<TextureSize> sizes_;
  const Atlas* atlas_;
  const TexelSpace* space_;
  TexelVectorSpace vectors_;
  TraceAtlas domain_;
  TraceAtlas::Starts starts_;
  Vector mass_;
  std::vector<float> limits_;
  mutable std::vector<std::shared_ptr<const BlockTransfer>> transfers_;
};

/// Textures of one atlas, each with half as many texels in a row as the one before. Charts that would share texels at a
/// size, as the gaps between them are less than a texel there, are moved apart in it (`separate_overlaps`), unless they lie
/// upon each other at the finest.
class FlowTextures {
 public:
  /// As long as most texels lie inside a chart, away from seams, and there are more than about `coarsest`. All must
  /// outlive the object.
  FlowTextures(const Surface& surface, const Atlas& atlas, const TexelSpace& space, int coarsest,
               const Progress& progress = {});

  int count() const { return int(textures_.size()); }
  const FlowTexture& operator[](int m) const { return *textures_[std::size_t(m)]; }

  /// Coefficients on texture m for those on texture m + 1: X there at the centres of texels, where paths begin.
  Vector prolongated(int m, const Vector& z) const { return transfers_[std::size_t(m)]->prolongated(z); }

  /// P of that, from texture m + 1 to texture m.
  const BlockTransfer& transfer(int m) const { return *transfers_[std::size_t(m)]; }

  /// Mean values of a signal on texture m around the texels of texture m + 1.
  Signal restricted(int m, const Signal& signal) const;
  /// A signal on texture m + 1 at the texels of texture m.
  Signal prolongated_signal(int m, const Signal& signal) const;

 private:
  std::vector<std::unique_ptr<FlowTexture>> textures_;
  std::vector<std::shared_ptr<const BlockTransfer>> transfers_;
};

}  // namespace mq
