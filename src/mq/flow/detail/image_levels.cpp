#include "mq/flow/detail/image_levels.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"

namespace mq {
namespace {

/// A grid's pixels lie a third of the scale's length apart.
constexpr double pixels_per_length = 3;

/// A scale whose signals have a smaller part of the deviation shows nothing but rounding.
constexpr double faintest = 1e-3;

/// Of the Gaussian that smooths signals, pixels.
double deviation(const FlowScale& scale) { return scale.smoothed() ? scale.length : 0; }

}  // namespace

Image<float> stepped(const Image<float>& X, const FlowPlanes& Y, double factor) {
  Image<float> result = X;
  const float f = float(factor);
  for (std::size_t k = 0; k < Y.u.size(); ++k) {
    result.values()[2 * k] += f * Y.u[k];
    result.values()[2 * k + 1] += f * Y.v[k];
  }
  return result;
}

double flow_pixels(const Length& length, const SurfaceScale& scale) {
  require(length.value >= 0,
          fmt::format("a length of {} pixels is negative: 0 or more is wanted", length.value));
  return std::sqrt(weight_from_length(length, scale));
}

std::vector<FlowScale> image_flow_scales(const ImageFlowOptions& options,
                                         const SurfaceScale& scale) {
  const double largest = flow_pixels(options.largest, scale),
               smallest = flow_pixels(options.smallest, scale);
  require(smallest > 0, "the smallest length of optical flow is 0: 2 pixels are what images show");
  std::vector<FlowScale> scales;
  if (options.scales != ImageFlowOptions::Scales::single) {
    scales = halved_scales(largest, smallest * 1.001);
    scales.push_back({smallest});
  }
  if (options.step_length == FlowStepLength::falling_error)
    scales.push_back({smallest, FlowScale::Signals::unsmoothed});
  return scales;
}

double grid_spacing(const FlowScale& scale, const ImageFlowOptions& options) {
  const bool coarse = options.scales == ImageFlowOptions::Scales::hierarchical;
  return coarse ? std::max(1.0, deviation(scale) / pixels_per_length) : 1;
}

ImageScale image_scale(const SignalPair& signals, const FlowScale& which, const ImageFlowOptions& options) {
  const auto& [source, target] = signals;
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  const double spacing = grid_spacing(which, options);
  const auto side = [&](int size) { return std::clamp(int(std::ceil(size / spacing)), 1, size); };
  const int width = side(source.width()), height = side(source.height());
  const double smoothness = flow_pixels(options.smoothness, scale);
  ImageScale at{at_scale(source, deviation(which), width, height),
                at_scale(target, deviation(which), width, height),
                (smoothness > 0 ? smoothness : which.length) *
                    std::sqrt(double(width) * height / double(source.pixel_count())),
                {}};
  const double square = 0.5 * (mean_square(at.source) + mean_square(at.target));
  at.data.width = options.robust_data * std::sqrt(square);
  if (options.gradient_weight > 0) {
    const Image<float> a = with_slopes(at.source, 1), b = with_slopes(at.target, 1);
    const double all = 0.5 * (mean_square(a) + mean_square(b));
    const double slopes = (3 * all - square) / 2;  // of three channels two are slopes
    const double factor = slopes > 0 ? std::sqrt(options.gradient_weight * square / slopes) : 0;
    at.source = with_slopes(at.source, factor);
    at.target = with_slopes(at.target, factor);
  }
  return at;
}

ImageLevels::ImageLevels(const SignalPair& signals, const ImageFlowOptions& options)
    : signals_(signals),
      options_(options),
      scale_{.area = double(signals.source.pixel_count()), .texel_spacing = 1},
      whole_{signals.source, signals.target, 1, {options.robust_data}},
      judge_(whole_, options),
      best_(signals.source.width(), signals.source.height(), 2) {
  blend_ = judge_.move(best_);
}

std::string ImageLevels::name(const FlowScale& scale) const {
  return fmt::format("scale of {:.3g} pixels", scale.length);
}

double ImageLevels::work(const FlowScale& scale) const { return std::pow(grid_spacing(scale, options_), -2); }

FlowLevel& ImageLevels::enter(const FlowScale& scale) {
  at_ = image_scale(signals_, scale, options_);
  aligner_.emplace(at_, options_);
  ImageFlowLevel& level = levels_.emplace_back();
  level.deviation = deviation(scale);
  level.width = at_.source.width();
  level.height = at_.source.height();
  X_ = resized_field(X_, level.width, level.height);
  shows_ = mean_square(at_.source) > faintest * faintest &&
           mean_square(at_.target) > faintest * faintest;
  return level;
}

void ImageLevels::look_up() {
  if (!shows_) return;
  level_blend_ = aligner_->move(Image<float>(X_.width(), X_.height(), 2));
  moved_ = aligner_->move(X_);
  levels_.back().before = level_error();
}

double ImageLevels::level_error() const { return shows_ ? error_of(moved_, level_blend_) : 0; }

double ImageLevels::correct(const Progress& progress, double) {
  correction_ = aligner_->correct(moved_, progress);
  ImageFlowLevel& level = levels_.back();
  level.cycles += correction_.cycles;
  if (level.scale == 0) level.scale = correction_.scale;
  return correction_.scale;
}

FlowErrorChange ImageLevels::attempt(double factor) {
  next_X_ = stepped(X_, correction_.Y, factor);
  next_ = aligner_->move(next_X_);
  const MovedCosts costs = compared(moved_, next_);
  return {costs.before, costs.after};
}

void ImageLevels::take() {
  X_ = std::move(next_X_);
  moved_ = std::move(next_);
}

double ImageLevels::error_along(const Image<float>& field) const {
  return error_of(judge_.move(field), blend_);
}

double ImageLevels::measure() {
  levels_.back().after = level_error();
  whole_field_ = resized_field(X_, best_.width(), best_.height());
  return error_along(whole_field_);
}

}  // namespace mq
