#pragma once
/// Two signals to align as the options name them, two pictures or two textures or colourings of one
/// model: read, aligned, and what the report says of that. The work is in mq/model/signal_pair.h.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mq/model/signal_pair.h"
#include "options/signal_options.h"

namespace mq::app {

/// Whether the options name two pictures, and no model.
bool is_picture_pair(const OptionValues& options);

/// Two pictures, a tenth of the run to read.
class AskedPictures {
 public:
  explicit AskedPictures(Run& run);
  const PicturePair& pair() const { return pair_; }

  /// Their flow, or that of --flow, with `run.result` of it.
  ImageFlow align(Run& run, const ImageFlowOptions& options, const Progress& progress) const;

  /// The field in the file that this option names; none where it names none.
  std::optional<Image<float>> field_of(Run& run, const std::string& option) const;

 private:
  PicturePair pair_;
  std::optional<Image<float>> given_;  ///< of --flow
};

/// Two signals on one model.
class AskedModels {
 public:
  /// Reads model and signals and makes the signal space: a third of the run, or next to nothing
  /// beside factorisations.
  explicit AskedModels(Run& run);

  /// Of the run, what `align` takes.
  double share_of_align() const { return factors_ ? 0.95 : 0.45; }

  const Model& model() const { return scene_.model; }
  const Surface& surface() const { return scene_.surface; }
  const ModelPair& pair() const { return *pair_; }

  /// Puts `run.result` as well.
  ModelPairFlow align(Run& run, const ModelFlowOptions& options, const Progress& progress) const;

 private:
  void read_textures(Run& run, const std::vector<std::string>& second, const Progress& progress);
  double edge_for(Run& run, double longest_edge) const;

  TexturedModel scene_;
  bool factors_ = false;  ///< not by multigrid
  std::unique_ptr<ModelPair> pair_;
};

}  // namespace mq::app
