/// ScaleSpace-IterativeFlowCorrection of thesis 4.3.3, on signals preprocessed as in 4.4.2:
///
///     φ̃₀ = (G_ℓ ∗ φ₀)(p − X/2),  φ̃₁ = (G_ℓ ∗ φ₁)(p + X/2)
///     Y = argmin Σ_c ∫ ψ_D(δ + ⟨Y, ∇μ⟩) + ℓ²Ḡ ∫ ψ_S(|∇Y|),   δ = φ̃₁ − φ̃₀
///     X ← X + α*Y
///
/// What is done differently: the weight of smoothness is a length, the scales are worked on at
/// their own resolution, each correction goes only as far as the error falls, and several are made
/// at each scale while that pays. Table 4.1 has a misprint in the row of the forward warping: what
/// moves is φ̃₁.

#include "mq/flow/image_flow.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/flow/forward_warp.h"
#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/image_levels.h"
#include "mq/flow/detail/image_signals.h"

namespace mq {
namespace {

using Alignment = FlowAlignment;

/// Of α*, before a correction is given up.
constexpr int halvings = 4;

void require_images(const Image<float>& source, const Image<float>& target) {
  require(
      !source.empty() && source.width() == target.width() && source.height() == target.height() &&
          source.channels() == target.channels(),
      fmt::format("two images of one size and number of channels are wanted; found {} x {} with "
                  "{} and {} x {} with {}",
                  source.width(), source.height(), source.channels(), target.width(),
                  target.height(), target.channels()));
  for (const Image<float>* image : {&source, &target})
    require(std::ranges::all_of(image->values(), [](float v) { return std::isfinite(v); }),
            "an image to align has a value that is not finite");
}

/// The images, preprocessed.
SignalPair prepared(const Image<float>& source, const Image<float>& target,
                    const ImageFlowOptions& options) {
  require_images(source, target);
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  return flow_signals(source, target, flow_pixels(options.detail, scale), options.light);
}

}  // namespace

ImageFlowOptions ImageFlowOptions::thesis() {
  ImageFlowOptions options;
  options.scales = Scales::full;
  options.path = FlowPath::straight;
  // A Gaussian damps as Smooth with weight α does where its variance is 2α.
  const double largest = 100 * std::sqrt(2 * 3e-3);
  options.largest = {largest, Length::Unit::percent};
  options.smallest = {largest / 64, Length::Unit::percent};
  // ½·10⁴·h³ of unit area, h = 1/√56,000.
  options.smoothness = {100 * std::sqrt(5e3 * std::pow(56e3, -1.5)), Length::Unit::percent};
  options.detail = {1e-4, Length::Unit::alpha};
  options.step_length = FlowStepLength::scaled;
  options.steps = 1;
  options.tolerance = 1e-6;
  options.max_cycles = 100;
  return options;
}

ImageFlow image_flow(const Image<float>& source, const Image<float>& target,
                     const ImageFlowOptions& options, const Progress& progress) {
  const SignalPair signals = prepared(source, target, options);
  progress.step("prepare", 0.05).at(1);
  ImageFlow flow;
  flow.alignment = options.alignment;
  flow.path = options.alignment == Alignment::forward ? FlowPath::straight : options.path;
  ImageLevels levels(signals, options);
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  flow.error = coarse_to_fine(levels, image_flow_scales(options, scale), options,
                              {.halvings = halvings,
                               .after_worse = FlowPolicy::AfterWorse::last,
                               .share = 0.95},
                              progress);
  flow.levels = levels.take_levels();
  for (std::size_t l = 0; l < flow.levels.size(); ++l) flow.levels[l].error = flow.error[l + 1];
  flow.field = levels.take_field();
  return flow;
}

ImageFlow known_flow(const Image<float>& source, const Image<float>& target,
                     const Image<float>& displacement, const ImageFlowOptions& options,
                     const Progress& progress) {
  require_images(source, target);
  require(
      displacement.width() == source.width() && displacement.height() == source.height(),
      fmt::format("a flow of {} x {} pixels was given for images of {} x {}", displacement.width(),
                  displacement.height(), source.width(), source.height()));
  const SignalPair signals = prepared(source, target, options);
  progress.at(0.3);
  ImageFlow flow;
  flow.alignment = Alignment::forward;
  flow.path = FlowPath::straight;
  flow.field = completed(displacement);
  ImageFlowOptions measured = options;
  measured.alignment = flow.alignment;
  const ImageLevels levels(signals, measured);
  progress.at(0.6);
  flow.error = {levels.blend_error(), levels.error_along(flow.field)};
  progress.at(1);
  return flow;
}

AlignedImages aligned(const ImageFlow& flow, const Image<float>& source,
                      const Image<float>& target) {
  if (flow.alignment == Alignment::forward)
    return {source, advected(target, flow.field, 1, FlowPath::straight)};
  return {advected(source, flow.field, -0.5, flow.path),
          advected(target, flow.field, 0.5, flow.path)};
}

Image<float> forward_displacement(const ImageFlow& flow) {
  if (flow.alignment == Alignment::forward) return flow.field;
  if (flow.path == FlowPath::integrated) return displacement(flow.field, 1);
  // X(q) at q = p + X(q)/2, again and again: it settles where |∇X| < 2.
  Image<float> moved = flow.field;
  for (int round = 0; round < 20; ++round) {
    Image<float> half = moved;
    for (float& value : half.values()) value *= 0.5F;
    moved = displaced(flow.field, half);
  }
  return moved;
}

/// How unlike the pixels of the source are to those of the target they go to.
static Image<float> disagreement(const Image<float>& displacement, const Image<float>& source,
                                 const Image<float>& target) {
  const Image<float> arrived = displaced(target, displacement);
  Image<float> costs(source.width(), source.height(), 1);
  parallel_for(
      source.height(),
      [&](std::int64_t y) {
        for (int x = 0; x < source.width(); ++x) {
          const auto a = source.pixel(x, int(y)), b = arrived.pixel(x, int(y));
          double sum = 0;
          for (std::size_t c = 0; c < a.size(); ++c)
            sum += (double(b[c]) - a[c]) * (double(b[c]) - a[c]);
          costs(x, int(y)) = float(sum);
        }
      },
      row_block);
  return costs;
}

Image<float> interpolated(const ImageFlow& flow, const Image<float>& source,
                          const Image<float>& target, double t) {
  require_images(source, target);
  require(t >= 0 && t <= 1, fmt::format("a time between 0 and 1 is wanted; found {}", t));
  require(source.width() == flow.field.width() && source.height() == flow.field.height(),
          "the flow is that of images of another size");
  if (t == 0) return source;
  if (t == 1) return target;
  const bool forward = flow.alignment == Alignment::forward;
  const ForwardWarpedField on_the_way =
      forward ? forward_warp(flow.field, t, disagreement(flow.field, source, target))
              : ForwardWarpedField();
  const Image<float>& X = forward ? on_the_way.field : flow.field;
  const Image<float> back = displacement(X, -t, flow.path);
  const Image<float> forth = displacement(X, 1 - t, flow.path);
  Image<float> between = displaced(source, back);
  const Image<float> other = displaced(target, forth);
  parallel_for(
      between.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < between.width(); ++x) {
          const bool in_source = lands_inside(back, x, y) && (!forward || on_the_way.seen(x, y));
          const bool in_target = lands_inside(forth, x, y);
          const float part = in_source == in_target ? float(t) : in_target ? 1.0F : 0.0F;
          const auto value = between.pixel(x, y);
          for (std::size_t c = 0; c < value.size(); ++c)
            value[c] += part * (other(x, y, int(c)) - value[c]);
        }
      },
      row_block);
  return between;
}

}  // namespace mq
