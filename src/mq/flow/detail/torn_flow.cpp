/// Differential steps find motions of about twice the length that signals are smoothed over, and smooth away what is
/// smaller than that. So where things of a few pixels' motion lie on a ground that moves by a hundred, no first scale
/// finds both. Here the ground is searched for, as DIS does by inverse search [kroeger2016dis] and descriptor matching
/// does in [brox2011ldof], among all motions at once; the things come from differential steps that begin at 0 and at a
/// finer scale; and pixels choose.

#include "mq/flow/detail/torn_flow.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/field_fusion.h"
#include "mq/flow/detail/image_levels.h"
#include "mq/flow/detail/motion_search.h"

namespace mq {
namespace {

/// ϵ of differences in standard deviations, where nobody says otherwise: what is hidden in one image must not pull.
constexpr double usual_robustness = 0.2;

/// Of `misfit`, that a pixel has a voice with.
constexpr float most_misfit = 0.5F;

/// How often what is hidden is found from the field and the field from what is hidden, at the first scale.
constexpr int first_rounds = 4;

/// How far borders between motions may move at a scale, pixels of it.
constexpr int border_step = 2;

/// Of α*, before a correction is given up.
constexpr int most_halvings = 2;

FieldClaims claims_along(const Image<float>& X, const ImageScale& at) {
  return claimed(X, 0.5, misfit({at.source, at.target}, X));
}

/// Two signals and a field between them that is corrected; pixels that are hidden in one of them or unlike each other
/// have no voice.
class VoicedField final : public FlowCorrection {
 public:
  VoicedField(const ImageScale& at, const ImageFlowOptions& options, Image<float> field)
      : aligner_(at, options), X_(std::move(field)) {
    const FieldClaims claims = claims_along(X_, at);
    const Image<float> costs = misfit({at.source, at.target}, X_, claims);
    for (const float cost : costs.values()) voiced_.push_back(cost < most_misfit);
    moved_ = move(X_);
  }

  /// As `FlowDomain::correct`.
  double correct(const Progress& progress) {
    correction_ = aligner_.correct(moved_, progress);
    return correction_.scale;
  }

  FlowErrorChange attempt(double factor) override {
    next_X_ = stepped(X_, correction_.Y, factor);
    next_ = move(next_X_);
    const MovedCosts costs = compared(moved_, next_);
    return {costs.before, costs.after};
  }

  void take() override {
    X_ = std::move(next_X_);
    moved_ = std::move(next_);
  }

  void leave() override {}

  Image<float> take_field() { return std::move(X_); }

 private:
  MovedImages move(const Image<float>& X) const {
    MovedImages moved = aligner_.move(X);
    for (std::size_t k = 0; k < voiced_.size(); ++k) moved.inside[k] = moved.inside[k] && voiced_[k];
    return moved;
  }

  ImageAligner aligner_;
  std::vector<char> voiced_;
  Image<float> X_, next_X_;
  MovedImages moved_, next_;
  ImageAligner::Correction correction_;
};

/// X with corrections at one scale, each as far as the error falls.
Image<float> corrected(Image<float> X, ImageScale& at, const ImageFlowOptions& options, const Progress& progress) {
  at.torn = X;
  VoicedField field(at, options, std::move(X));
  for (int step = 0; step < options.steps; ++step) {
    const double scale = field.correct(progress);
    if (!(scale > 0)) break;
    const std::optional<FlowErrorChange> change = take_what_gains(field, scale, most_halvings, progress);
    if (!change || !(change->after < (1 - options.least_gain) * change->before)) break;
  }
  return field.take_field();
}

/// The field by so many pixels aside.
Image<float> beside(const Image<float>& field, int dx, int dy) {
  const int width = field.width(), height = field.height();
  Image<float> result(width, height, 2);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      std::ranges::copy(field.pixel(std::clamp(x + dx, 0, width - 1), std::clamp(y + dy, 0, height - 1)),
                        result.pixel(x, y).begin());
  return result;
}

/// The field with a vector added.
Image<float> shifted(Image<float> field, float u, float v) {
  for (std::size_t i = 0; i < field.values().size(); ++i) field.values()[i] += i % 2 == 0 ? u : v;
  return field;
}

/// The field that one of these constants is, on a grid of this size.
Image<float> constant_field(const std::array<float, 2>& X, int width, int height) {
  Image<float> field(width, height, 2);
  for (std::size_t i = 0; i < field.values().size(); ++i) field.values()[i] = X[i % 2];
  return field;
}

/// What the first scale chooses from; the first is that of what most pixels have in common.
std::vector<Image<float>> first_fields(const SearchedMotions& searched, ImageScale& at, const Image<float>& smooth,
                                       const ImageFlowOptions& options, const Progress& progress) {
  const int width = at.source.width(), height = at.source.height();
  std::vector<Image<float>> fields = {searched.common, searched.free, smooth};
  for (const std::array<float, 2>& X : searched.most)
    fields.push_back(constant_field(X, searched.common.width(), searched.common.height()));
  for (Image<float>& field : fields) field = resized_field(field, width, height);
  fields.push_back(corrected(Image<float>(width, height, 2), at, options, progress));
  return fields;
}

/// The field of the first scale. What is hidden follows from the field and the field from what is hidden; and motions
/// that were searched for in whole steps of `step` pixels are then in quarters, eighths, ... of them.
Image<float> first_field(const std::vector<Image<float>>& candidates, const ImageScale& at, double step) {
  Image<float> X = candidates.front();
  for (int round = 0; round < first_rounds; ++round) {
    std::vector<Image<float>> fields = {X};
    fields.insert(fields.end(), candidates.begin() + (round == 0 ? 1 : 0), candidates.end());
    const float part = float(step / (2 << round));
    for (const float way : {part, -part}) {
      if (round == 0) continue;
      fields.push_back(shifted(X, way, 0));
      fields.push_back(shifted(X, 0, way));
    }
    X = fused(at, fields, claims_along(X, at));
  }
  return X;
}

/// What a later one does: the field at hand, the same with its borders moved, and `smooth`.
std::vector<Image<float>> next_fields(const Image<float>& X, const ImageScale& at, const Image<float>& smooth) {
  const int width = at.source.width(), height = at.source.height(), r = border_step;
  std::vector<Image<float>> fields = {resized_field(X, width, height)};
  for (const auto& [dx, dy] : {std::pair{r, 0}, std::pair{-r, 0}, std::pair{0, r}, std::pair{0, -r}})
    fields.push_back(beside(fields.front(), dx, dy));
  fields.push_back(resized_field(smooth, width, height));
  return fields;
}

std::vector<FlowScale> torn_scales(const SignalPair& signals, const SearchedMotions& searched,
                                   const ImageFlowOptions& options) {
  const SurfaceScale scale{.area = double(signals.source.pixel_count()), .texel_spacing = 1};
  const double smallest = flow_pixels(options.smallest, scale);
  const double first = std::max(smallest, double(signals.source.width()) / searched.common.width());
  std::vector<FlowScale> scales = halved_scales(first, 1.5 * smallest);
  scales.push_back({smallest});
  scales.push_back({smallest, FlowScale::Signals::unsmoothed});
  return scales;
}

}  // namespace

Image<float> straightened(const Image<float>& field, FlowPath path) {
  if (path == FlowPath::straight) return field;
  Image<float> result = displacement(field, 0.5, path);
  const Image<float> back = displacement(field, -0.5, path);
  for (std::size_t i = 0; i < result.values().size(); ++i) result.values()[i] -= back.values()[i];
  return result;
}

Image<float> torn_field(const SignalPair& signals, const Image<float>& smooth, const ImageFlowOptions& given,
                        const Progress& progress) {
  const SearchedMotions searched = searched_motions(signals);
  if (searched.common.empty()) return smooth;
  progress.at(0.1);
  ImageFlowOptions options = given;
  options.path = FlowPath::straight;
  if (options.robust_data == 0) {
    options.robust_data = usual_robustness;
    options.reweightings = 1;
  }
  const std::vector<FlowScale> scales = torn_scales(signals, searched, options);
  Image<float> X;
  for (std::size_t l = 0; l < scales.size(); ++l) {
    ImageScale at = image_scale(signals, scales[l], options);
    if (l == 0) {
      const double step = double(at.source.width()) / searched.common.width();
      X = first_field(first_fields(searched, at, smooth, options, progress), at, step);
    } else {
      const std::vector<Image<float>> fields = next_fields(X, at, smooth);
      X = corrected(fused(at, fields, claims_along(fields.front(), at)), at, options, progress);
    }
    progress.at(0.1 + 0.9 * double(l + 1) / double(scales.size()));
  }
  return X;
}

}  // namespace mq
