#pragma once
/// The signal of a model: its textures, all of them one signal, or its colours at vertices; taken out
/// of the model and put back so that what did not change keeps its bits.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mq/atlas/separate_overlaps.h"
#include "mq/base/defect.h"
#include "mq/fem/texel_copies.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/model/textured_model.h"
#include "mq/model/value_space.h"

namespace mq {

class KeptWork;
struct UnknownRange;
class ShadingFrames;
class TangentTexels;

/// What both kinds of signal offer. The model must outlive it.
class ModelSignal {
 public:
  virtual ~ModelSignal() = default;
  virtual const SignalSpace& space() const = 0;

  /// The same space where it is one of texels, or of vertices; else null.
  virtual const TexelSpace* texel_space() const { return nullptr; }
  virtual const VertexSpace* vertex_space() const { return nullptr; }

  /// The atlas of `texel_space`; else null.
  virtual const Atlas* texel_atlas() const { return nullptr; }

  /// The texels of the model's pictures that its unknowns are; none at vertices.
  virtual std::vector<Texels::Place> texels() const { return {}; }

  /// Of the surface; what counts as a texel where there are none is the mean spacing of vertices.
  SurfaceScale scale() const;

  /// What was found wrong while the space was made.
  virtual Defects defects() const { return {}; }

  /// The unknowns of a texel of the pictures; none where no chart reads it, and at vertices. Where a
  /// texel has an unknown for each of its charts, those of the charts that cover its centre.
  virtual std::vector<int> unknowns_at(const Texels::Place& texel) const;

  /// The model's values, one row per unknown.
  virtual Signal values() const = 0;

  /// Puts changed values into a model like this one: textures of the same sizes (else throws
  /// `InvalidInput`), as many vertices. Unknowns that equal `before` in every channel keep their bits.
  virtual void put(const Signal& before, const Signal& after, Model& model) const = 0;

  /// Gives the model pictures of these values (one column per channel) in place of its own, black
  /// where no chart is, or colours at its vertices.
  virtual void replace(const Signal& values, Depth depth, Model& model) const = 0;

  /// The space of the same unknowns in which distances across a vector field, one vector per triangle,
  /// are long (`texel_metrics_across`, `shapes_across`).
  virtual std::unique_ptr<SignalSpace> space_across(std::span<const Vector3> field, double kappa,
                                                    const Progress& progress = {}) const = 0;

  /// Of the colour channels together, as stored, per unknown. Throws `InvalidInput` where the model lacks what it
  /// would be taken of.
  virtual Vector brightness() const = 0;
};

/// Per unknown the component of the model's surface (`triangle_components`) that it lies on, −1 for a vertex of no triangle.
std::vector<int> components_of(const ModelSignal& signal, const Surface& surface);

/// What a signal of textures is made for.
struct TextureSignalOptions {
  ValueSpace values = {};
  TexelSpaceOptions space = {};

  /// A texel that several charts read is one unknown, whose value is right for none of them but the
  /// best there is for all; or one for each chart, of which the picture can show one
  /// (`separate_overlaps`). Normals in tangent space need the latter where charts overlap: one stored
  /// vector is another normal in each of them.
  enum class SharedTexels {
    one_unknown,  ///< refused where charts overlap and normals are in tangent space
    one_for_each,
    as_normals_need  ///< one for each where `one_unknown` is refused
  } shared = SharedTexels::one_unknown;

  /// Whether the values of the model's own pictures are of interest: then textures that disagree in
  /// channels are refused before any work.
  enum class Pictures { read, replaced } pictures = Pictures::read;

  std::optional<Depth> depth = {};  ///< that pictures will be written in, where it is not their own
  KeptWork* kept = nullptr;         ///< whose space is taken, if it is the same; null: it is made
};

/// Textures. Those with and without alpha are worked on together; where one lacks it, it is 1.
///
/// The values of a normal map in tangent space (normal_axes.h) are d = n − N in the model's axes: by
/// how much its normal differs from the surface's shading normal. They are 0 where the map is flat, and
/// the same on both sides of a seam, whatever the frames of its charts. Put back, normalise(N + d) is
/// expressed in the texel's frame. A texel that shows another normal than before by no more than half a
/// step of its code, or 10⁻⁶, keeps what is stored.
class TextureSignal final : public ModelSignal {
 public:
  /// Throws `InvalidInput` as said above and for normal maps without z, and what `TexelSpace` throws.
  /// Warns of values without a logarithm, and of a normal map that does not look like one; remarks on
  /// what axes normals are taken to be in where that was found by their values.
  TextureSignal(const TexturedModel& model, const TextureSignalOptions& options,
                Messages& messages, const Progress& progress = {});

  const TexelSpace& space() const override { return *space_; }
  const TexelSpace* texel_space() const override { return &*space_; }
  const Atlas* texel_atlas() const override { return &atlas(); }
  std::vector<Texels::Place> texels() const override;
  Defects defects() const override;
  std::vector<int> unknowns_at(const Texels::Place& texel) const override;
  Signal values() const override { return values_of(model_.model.textures); }
  void put(const Signal& before, const Signal& after, Model& model) const override;
  void replace(const Signal& values, Depth depth, Model& model) const override;
  std::unique_ptr<SignalSpace> space_across(std::span<const Vector3> field, double kappa,
                                            const Progress& progress = {}) const override;
  Vector brightness() const override;

  /// The values of other pictures, one for each texture of the model and of its size, in the same
  /// space and channels. Throws `InvalidInput` naming the one that does not fit.
  Signal values_of(std::span<const Texture> textures) const;

  /// The values of pictures of one channel count, one for each texture, as they are stored.
  Signal gather(std::span<const Image<float>> pictures) const;

  int channels() const { return channels_; }

  /// In which its values are; `NormalAxes` as they were found.
  const ValueSpace& value_space() const { return values_; }

  /// The frames of a normal map in tangent space; of other pictures null.
  const ShadingFrames* shading_frames() const;

  /// N of each unknown of such a map, three columns.
  Signal shading_normals() const;

 private:
  const Atlas& atlas() const { return apart_ ? apart_->atlas : *model_.atlas; }
  Texels::Place home(int unknown) const;
  UnknownRange of_texture(std::size_t texture) const;
  TextureSignalOptions::SharedTexels find_axes(TextureSignalOptions::SharedTexels shared,
                                               Messages& messages);
  void find_frames();
  double code_step(const Texture& texture) const;
  void to_deviations(std::span<const int> block, const Texture& texture, Image<float>& worked,
                     Signal& values) const;
  void put_normals(std::span<const int> block, const Signal& before, const Signal& after,
                   Texture& texture) const;
  void require_alike(std::span<const Texture> textures) const;

  const TexturedModel& model_;
  ValueSpace values_;
  int channels_ = 0;
  std::optional<SeparatedAtlas> apart_;  ///< nothing where each texel is one unknown
  std::shared_ptr<const TexelSpace> space_;
  std::optional<TexelCopies> copies_;
  std::vector<int> first_of_texture_;  ///< unknowns are in the order of textures; and behind the last
  std::shared_ptr<const TangentTexels> tangent_;  ///< null: values are not in tangent space
  std::optional<Depth> depth_;
};

/// Colours at vertices. Copies of a vertex that exporters wrote for several charts are one unknown,
/// their mean.
class VertexColourSignal final : public ModelSignal {
 public:
  explicit VertexColourSignal(const TexturedModel& model) : model_(model), space_(model.surface) {}

  const VertexSpace& space() const override { return space_; }
  const VertexSpace* vertex_space() const override { return &space_; }
  Signal values() const override { return values_of(model_.model.colors); }
  void put(const Signal& before, const Signal& after, Model& model) const override;
  void replace(const Signal& values, Depth depth, Model& model) const override;
  std::unique_ptr<SignalSpace> space_across(std::span<const Vector3> field, double kappa,
                                            const Progress& progress = {}) const override;
  Vector brightness() const override;

  /// Values at the vertices of the model's file, as values of the space.
  Signal values_of(const VertexSignal& colors) const;

 private:
  const TexturedModel& model_;
  VertexSpace space_;
};

}  // namespace mq
