#pragma once
/// Two signals to align, two pictures or two of one model, and what lies between them.

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mq/flow/image_flow.h"
#include "mq/flow/cut_texture_flow.h"
#include "mq/flow/texture_flow.h"
#include "mq/model/model_signal.h"

namespace mq {

/// What makes alignment idle.
struct Likeness {
  bool first_constant = false, second_constant = false;
  bool equal = false;
};

/// Two pictures of one size. Colours are worked on multiplied by alpha, so that what is transparent
/// has none.
///
///     const PicturePair pair("a.png", "b.png", {}, messages);
///     const ImageFlow flow = pair.align();
///     write_texture("halfway.png", pair.stored(pair.between(flow, 0.5)));
class PicturePair {
 public:
  /// Reads both and works on the values of this space. Remarks on what the reader coped with. Throws
  /// `IoError`, and `InvalidInput` naming the files where sizes or channels differ.
  PicturePair(const std::filesystem::path& first, const std::filesystem::path& second,
              const ValueSpace& values, Messages& messages, const Progress& progress = {});

  const Image<float>& first() const { return first_; }
  const Image<float>& second() const { return second_; }
  Likeness likeness() const;

  /// A field in a file, .flo, .png or .exr. Throws `IoError` where it has not the pictures' size or
  /// says nothing of any pixel.
  Image<float> read_field(const std::filesystem::path& path) const;

  /// Their flow (`image_flow`), or that of a field that is known (`known_flow`).
  ImageFlow align(const ImageFlowOptions& options = {}, const Progress& progress = {}) const;
  ImageFlow follow(const Image<float>& field, const ImageFlowOptions& options = {},
                   const Progress& progress = {}) const;

  /// `interpolated`, in the values that are worked on.
  Image<float> between(const ImageFlow& flow, double t) const {
    return interpolated(flow, first_, second_, t);
  }

  /// A picture in these values as the first file holds its own.
  Texture stored(const Image<float>& picture) const;

  /// The first as a flat model, and that model with such a picture in place of it.
  const Model& model() const { return model_; }
  Model with(const Image<float>& picture) const;

 private:
  ValueSpace values_;
  Model model_;
  Image<float> first_, second_;
};

class ModelPair;

/// Of triangles cut for flow, in texels, where nobody says otherwise.
inline constexpr double usual_longest_edge = 2;

struct ModelFlowOptions : MeshFlowOptions {
  /// Of textures: the flow is found on triangles cut until no edge is longer, in texels (`CutTextureFlow`); without it
  /// in the texels themselves (`TextureFlow`), which only the vertices' basis, solved by multigrid, has.
  std::optional<double> longest_edge;
};

/// The flow of a `ModelPair`, which must outlive it.
class ModelPairFlow {
 public:
  const MeshFlow& flow() const { return textures_ ? textures_->flow() : cut_ ? cut_->flow() : flow_; }

  /// Of the mesh that it was found on, or texels.
  int vertices() const;

  /// Both signals as they meet at time t between 0 and 1.
  WarpedPair warp_pair(double t, const Progress& progress = {}) const;

  /// (1 − t)·source + t·target of them; the signals themselves, bit for bit, at 0 and 1.
  Signal between(double t, const Progress& progress = {}) const;

  /// On the triangles of the surface, in space.
  TangentField field() const;

 private:
  friend class ModelPair;
  explicit ModelPairFlow(const ModelPair& pair) : pair_(&pair) {}

  const ModelPair* pair_;
  std::unique_ptr<TextureFlow> textures_;  ///< one of these ...
  std::unique_ptr<CutTextureFlow> cut_;
  MeshFlow flow_;                    ///< ... or at vertices this
  std::unique_ptr<TraceMesh> mesh_;  ///< and what it is followed on
};

/// Two textures, or two colourings, of one model, which must outlive it.
class ModelPair {
 public:
  /// The model's own textures, and as many others in their order, each of the size and channels of
  /// that in whose place it is. Throws `InvalidInput` naming the one that does not fit, and what
  /// `TextureSignal` throws.
  ModelPair(const TexturedModel& model, std::vector<Texture> second, const ValueSpace& values,
            Messages& messages, const Progress& progress = {});

  /// The colours at its vertices and those of another model with the same vertices in the same
  /// order. Warns where that has other triangles. Throws `InvalidInput` where there are none or they
  /// do not fit.
  ModelPair(const TexturedModel& model, const Model& second, Messages& messages);
  ModelPair(const ModelPair&) = delete;

  const TexturedModel& model() const { return model_; }
  const ModelSignal& target() const { return *target_; }
  bool at_vertices() const { return target_->vertex_space() != nullptr; }
  const Signal& first() const { return first_; }
  const Signal& second() const { return second_; }
  Likeness likeness() const;

  /// This longest edge, or as much more as cuts triangles to no more than about `quick_vertices`,
  /// which flow takes about a minute for; a megatexel, whole, at the usual two texels makes a little
  /// less. Textures only.
  double quick_edge(double longest_edge) const;
  static constexpr double quick_vertices = 0.75e6;

  /// Lengths in texels are for textures only.
  ModelPairFlow align(const ModelFlowOptions& options = {}, const Progress& progress = {}) const;

  /// The model with values at time t. What no triangle shows (texels outside all charts, colours of
  /// vertices without faces) is mixed (1 − t) : t as it lies; at t = 1 all is the second's.
  Model with(const Signal& values, double t) const;

 private:
  void put_shown(const Signal& values, Model& into) const;

  const TexturedModel& model_;
  std::unique_ptr<ModelSignal> target_;
  Signal first_, second_;
  std::vector<Image<float>> second_pictures_;  ///< of textures, as stored
  VertexSignal second_colors_;                 ///< of vertices
};

}  // namespace mq
