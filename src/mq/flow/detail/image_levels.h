#pragma once
/// Two images aligned level by level, each at the resolution it needs.

#include <optional>
#include <string>
#include <vector>

#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/image_aligner.h"

namespace mq {

/// In pixels of an image of this scale. Throws `InvalidInput` where it is negative.
double flow_pixels(const Length& length, const SurfaceScale& scale);

/// The scales of `ImageFlowOptions`. Throws `InvalidInput` where the smallest is 0.
std::vector<FlowScale> image_flow_scales(const ImageFlowOptions& options,
                                         const SurfaceScale& scale);

/// How far apart the pixels are that a scale is worked on.
double grid_spacing(const FlowScale& scale, const ImageFlowOptions& options);

/// The signals at one scale, with their derivatives where these count.
ImageScale image_scale(const SignalPair& signals, const FlowScale& scale, const ImageFlowOptions& options);

/// X + factor·Y.
Image<float> stepped(const Image<float>& X, const FlowPlanes& Y, double factor);

/// The images as `coarse_to_fine` sees them. See `ImageFlow::error` for what errors are. Signals
/// (`flow_signals`) and options must stay.
class ImageLevels final : public FlowDomain {
 public:
  ImageLevels(const SignalPair& signals, const ImageFlowOptions& options);

  std::string name(const FlowScale& scale) const override;
  double work(const FlowScale& scale) const override;
  double blend_error() const override { return error_of(blend_, blend_); }
  FlowLevel& enter(const FlowScale& scale) override;
  void look_up() override;
  double level_error() const override;
  int most_steps() const override { return options_.steps; }
  double correct(const Progress& progress, double share) override;
  FlowErrorChange attempt(double factor) override;
  void take() override;
  void leave() override {}
  double measure() override;
  void keep() override { best_ = std::move(whole_field_); }
  void forget() override { best_ = Image<float>(best_.width(), best_.height(), 2); }

  /// The error of a field on the whole.
  double error_along(const Image<float>& field) const;

  Image<float> take_field() { return std::move(best_); }
  std::vector<ImageFlowLevel> take_levels() { return std::move(levels_); }

 private:
  const SignalPair& signals_;
  const ImageFlowOptions& options_;
  const SurfaceScale scale_;
  ImageScale whole_;
  ImageAligner judge_;
  MovedImages blend_;
  Image<float> best_;  ///< X of least error

  Image<float> X_{1, 1, 2};
  Image<float> whole_field_;  ///< the same at the size of the images, once it is measured
  std::vector<ImageFlowLevel> levels_;
  ImageScale at_;  ///< the level's signals
  std::optional<ImageAligner> aligner_;
  MovedImages level_blend_, moved_;
  bool shows_ = false;  ///< there is more than rounding in them
  ImageAligner::Correction correction_;
  Image<float> next_X_;  ///< while it is tried
  MovedImages next_;
};

}  // namespace mq
