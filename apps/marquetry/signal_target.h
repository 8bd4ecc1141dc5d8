#pragma once
/// The signal that a verb changes: the model's textures, all of them one signal, or its colours at
/// vertices; taken out of the model and put back so that what did not change keeps its bits.
///
/// A verb that computes a field of its own needs only the `Domain`.

#include <memory>
#include <span>
#include <vector>

#include "domain.h"
#include "mq/image/colour.h"
#include "mq/io/model.h"

namespace mq::app {

/// In which values a signal is worked on.
struct ValueSpace {
  enum class Meaning { colours, normals } meaning = Meaning::colours;
  ColourSpace space = ColourSpace::stored;
  /// Whether the two sides of a seam are to agree, as normals in tangent space cannot.
  bool meets_at_seams = true;
};

/// What --space and --normals say, where the verb has them.
ValueSpace value_space(const OptionValues& options);

/// Whether a texture stores display values or light.
TransferFunction transfer(const Texture& texture);

/// A texture's values in that space, and back.
Image<float> decoded(const Texture& texture, const ValueSpace& values);
Image<float> encoded(const Image<float>& picture, const Texture& texture, const ValueSpace& values);

class Target {
 public:
  virtual ~Target() = default;
  virtual const Domain& domain() const = 0;
  virtual Signal values() const = 0;
  /// Puts changed values into the model. Unknowns that equal `before` in every channel stay.
  virtual void put(const Signal& before, const Signal& after, Model& model) const = 0;

  const SignalSpace& space() const { return domain().space(); }
};

/// Textures, all of them one signal. Those with and without alpha are worked on together; where one
/// lacks it, it is 1.
class TextureTarget : public Target {
 public:
  /// The scene must outlive the target. Throws `InvalidInput` where textures disagree in channels,
  /// or where normals are in tangent space and there are seams.
  TextureTarget(Run& run, const Scene& scene, const ValueSpace& values, const Progress& progress)
      : TextureTarget(run, scene, values, {}, progress) {}
  TextureTarget(Run& run, const Scene& scene, const ValueSpace& values,
                const TexelSpaceOptions& space, const Progress& progress);

  const TexelDomain& domain() const override { return domain_; }
  Signal values() const override { return values_of(model_.textures); }
  void put(const Signal& before, const Signal& after, Model& model) const override;

  /// The values of other pictures, one for each texture of the model and of its size, in the same
  /// space and channels. Throws `InvalidInput` naming the one that does not fit.
  Signal values_of(std::span<const Texture> textures) const;

  int channels() const { return channels_; }

 private:
  std::vector<Image<float>> pictures_of(std::span<const Texture> textures) const;
  void refuse_tangent_space(const Scene& scene) const;

  const Model& model_;
  ValueSpace values_;
  int channels_;
  TexelDomain domain_;
};

/// Colours at vertices. Copies of a vertex that exporters wrote for several charts are one unknown,
/// their mean.
class VertexTarget : public Target {
 public:
  explicit VertexTarget(const Scene& scene) : scene_(scene), domain_(scene) {}

  const VertexDomain& domain() const override { return domain_; }
  Signal values() const override { return values_of(scene_.model.colors); }
  void put(const Signal& before, const Signal& after, Model& model) const override;

  /// Values at the vertices of the model's file, as values of the space.
  Signal values_of(const VertexSignal& colors) const;

 private:
  const Scene& scene_;
  VertexDomain domain_;
};

/// What the options ask for (see `at_vertices`). The scene must outlive it.
std::unique_ptr<Target> make_target(Run& run, const Scene& scene, const Progress& progress);

}  // namespace mq::app
