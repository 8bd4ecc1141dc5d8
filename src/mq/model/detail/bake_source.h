#pragma once
/// What `bake` looks at: a model's colours, or its normals as what they add to another's.

#include <memory>
#include <optional>
#include <span>

#include "mq/model/baked_signal.h"
#include "mq/model/detail/source_colours.h"
#include "mq/model/normal_axes.h"

namespace mq {

/// Values of a source where a point of the target lies on it. Source, mesh and target must stay.
///
/// Those of normals that are baked in tangent space are d = n − N in the model's axes: n what the
/// source shows (its map in its frames, looked up as renderers do; of a map that is flat to a step
/// of its code, or without a map, its shading normal), N the target's shading normal. Where the
/// source's shading normal points into the target, n is turned over. Channels beyond the third stay
/// as they are stored.
class BakeSource {
 public:
  /// `mesh` is the source's, some of its triangles flipped. Throws what `bake` throws for its
  /// source.
  BakeSource(const TexturedModel& source, const Mesh& mesh, const TexturedModel& target,
             const ModelSignal& signal, const BakeOptions& options);

  int channels() const { return colours_ ? colours_->channels() : 3; }
  bool is_light() const { return colours_ && colours_->is_light(); }
  Depth depth() const { return colours_ ? colours_->depth() : Depth::u8; }

  /// Mean distance of texels, or of vertices, on the model.
  double spacing() const { return colours_ ? colours_->spacing() : spacing_; }

  /// Values where both are; false where the source shows nothing.
  bool at(const SurfacePoint& on_source, const SurfacePoint& on_target,
          std::span<double> values) const;

  /// Of normals in tangent space; else null.
  const std::shared_ptr<const BakedNormals>& normals() const { return normals_; }

 private:
  void find_normals(const TexturedModel& target, const ModelSignal& signal,
                    const BakeOptions& options);
  Vector3 shown_normal(const SurfacePoint& point, std::span<const double> stored,
                       const Vector3& shading) const;

  const TexturedModel& source_;
  const Mesh& mesh_;
  std::optional<SourceColours> colours_;
  double spacing_ = 0;
  std::shared_ptr<const BakedNormals> normals_;
};

/// Values d of such a bake as codes of the target's map.
Signal coded_normals(const BakedNormals& normals, const Signal& values, const TexelSpace& space,
                     const TexturedModel& target);

}  // namespace mq
