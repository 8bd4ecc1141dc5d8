#pragma once
/// Two signals to align: two pictures, or two textures or colourings of one model.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "mq/flow/image_flow.h"
#include "mq/flow/texture_flow.h"
#include "options/signal_options.h"

namespace mq::app {

/// Whether the options name two pictures, and no model.
bool is_picture_pair(const OptionValues& options);

/// What makes alignment idle.
struct Alike {
  bool first_constant = false, second_constant = false;
  bool equal = false;
};

/// Says of a pair, aligned as `run.result` says, why it did not come nearer, or not near.
void warn_of_little(Run& run, const Alike& alike);

/// Two pictures of one size. Colours are worked on multiplied by alpha, so that what is transparent
/// has none.
class PicturePair {
 public:
  /// Reads both, a tenth of the run. Throws `IoError` and `InvalidInput` naming the files.
  explicit PicturePair(Run& run);

  const Image<float>& first() const { return first_; }
  const Image<float>& second() const { return second_; }

  /// Their flow, or that of --flow, with `run.result` of it.
  ImageFlow align(Run& run, const ImageFlowOptions& options, const Progress& progress) const;

  /// The field in the file that this option names, of the pictures' size; none where it names none.
  /// Throws `IoError` naming it.
  std::optional<Image<float>> field_of(Run& run, const std::string& option) const;

  /// A picture in these values as the first file holds its own.
  Texture stored(const Image<float>& picture) const;

  /// The first as a model without a mesh, for `Outputs`.
  const Model& model() const { return model_; }

 private:
  ValueSpace values_;
  Model model_;
  Image<float> first_, second_;
  std::optional<Image<float>> given_;  ///< of --flow
};

/// Two signals on one model. Their flow, once it is found, gives what lies between.
class ModelPair {
 public:
  /// Reads model and signals and makes the signal space: a third of the run, or next to nothing
  /// beside factorisations.
  explicit ModelPair(Run& run);

  /// Of the run, what `align` takes.
  double share_of_align() const { return factors_ ? 0.95 : 0.45; }

  TexturedModel& scene() { return scene_; }
  const ModelSignal& target() const { return *target_; }
  const Signal& first() const { return first_; }
  const Signal& second() const { return second_; }
  bool at_vertices() const { return vertices_; }

  /// Puts `run.result` as well.
  void align(Run& run, const TextureFlowOptions& options, const Progress& progress);
  const MeshFlow& flow() const { return textures_ ? textures_->flow() : flow_; }
  int flow_vertices() const { return textures_ ? textures_->vertices() : target_->space().size(); }
  WarpedPair warp_pair(double t, const Progress& progress) const;

  /// (1 − t)·source + t·target of them; the signals themselves, bit for bit, at 0 and 1.
  Signal between(double t, const Progress& progress) const;

  /// The model with these values. What no triangle shows (texels outside all charts, colours of
  /// vertices without faces) is mixed (1 − t) : t as it lies; at t = 1 all is the second's.
  Model with(const Signal& values, double t) const;

  /// On the triangles of the surface, in space.
  TangentField field() const;

 private:
  /// Both signals: colours at the vertices of two models, of which the first is called `name`, or the
  /// pictures of both textures.
  void take_colours(Run& run, const std::string& name, const std::string& file);
  void take_textures(Run& run, const std::vector<std::filesystem::path>& first,
                     const std::vector<std::filesystem::path>& second, const Progress& progress);
  void refuse_what_is_for_textures(const OptionValues& options) const;
  void find(const TextureFlowOptions& options, const Progress& progress);

  /// The edges to cut to: as given, longer where --longest-edge is not and that would be too many.
  double edge_for(Run& run, double longest_edge) const;

  /// Says what factorisations will take where that is much, and what else could be done.
  void warn_of_cost(Run& run, const FlowForecast& forecast) const;

  TexturedModel scene_;
  bool factors_ = false;  ///< not by multigrid
  bool vertices_ = false;
  std::unique_ptr<ModelSignal> target_;
  Signal first_, second_;
  std::vector<Image<float>> second_pictures_;  ///< of textures, as stored
  VertexSignal second_colors_;                 ///< of vertices
  std::unique_ptr<TextureFlow> textures_;
  MeshFlow flow_;
  std::unique_ptr<TraceMesh> mesh_;
};

}  // namespace mq::app
