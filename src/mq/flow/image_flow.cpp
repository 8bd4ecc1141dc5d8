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
#include "mq/base/stopwatch.h"
#include "mq/flow/forward_warp.h"
#include "mq/flow/detail/image_aligner.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/image_system.h"

namespace mq {
namespace {

using Alignment = ImageFlowOptions::Alignment;

/// Rows of one piece of work.
constexpr std::int64_t row_block = 8;

/// A grid's pixels lie a third of the scale's length apart.
constexpr double pixels_per_length = 3;

/// A scale whose signals have a smaller part of the deviation shows nothing but rounding.
constexpr double faintest = 1e-3;

/// α* of (4.8) is cut off where linear models end.
constexpr double largest_scale = 4;

constexpr int halvings = 4;

double pixels(const Length& length, const SurfaceScale& scale) {
  require(length.value >= 0,
          fmt::format("a length of {} pixels is negative: 0 or more is wanted", length.value));
  return std::sqrt(weight_from_length(length, scale));
}

Image<float> stepped(const Image<float>& X, const FlowPlanes& Y, double factor) {
  Image<float> result = X;
  const float f = float(factor);
  for (std::size_t k = 0; k < Y.u.size(); ++k) {
    result.values()[2 * k] += f * Y.u[k];
    result.values()[2 * k + 1] += f * Y.v[k];
  }
  return result;
}

/// IterativeFlowCorrection at one scale.
void correct_at(const ImageAligner& aligner, const ImageFlowOptions& options, Image<float>& X,
                ImageFlowLevel& level, const Progress& progress) {
  const MovedImages blend = aligner.move(Image<float>(X.width(), X.height(), 2));
  MovedImages moved = aligner.move(X);
  level.before = error_of(moved, blend);
  const bool any = options.step_length == ImageFlowOptions::StepLength::scaled;
  for (int step = 0; step < options.steps; ++step) {
    progress.at(double(step) / options.steps, fmt::format("error {:.3g}", error_of(moved, blend)));
    const ImageAligner::Correction correction = aligner.correct(moved, progress);
    level.cycles += correction.cycles;
    if (correction.scale == 0) break;
    if (step == 0) level.scale = correction.scale;
    double factor = any ? correction.scale : std::min(correction.scale, largest_scale);
    double left = 1;  // of the cost, by this step
    for (int half = 0; half <= (any ? 0 : halvings); ++half, factor /= 2) {
      progress.check();
      Image<float> further = stepped(X, correction.Y, factor);
      MovedImages next = aligner.move(further);
      const MovedCosts costs = compared(moved, next);
      if (!any && !(costs.after < costs.before)) continue;
      left = costs.after / costs.before;
      X = std::move(further);
      moved = std::move(next);
      ++level.steps;
      break;
    }
    if (!any && !(std::sqrt(left) < 1 - options.least_progress)) break;
  }
  level.after = error_of(moved, blend);
}

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

/// ℓ, and the standard deviation that signals are smoothed by.
struct ScaleLength {
  double length, deviation;
};

std::vector<ScaleLength> scale_lengths(const ImageFlowOptions& options, const SurfaceScale& scale) {
  const double largest = pixels(options.largest, scale), smallest = pixels(options.smallest, scale);
  require(smallest > 0, "the smallest length of optical flow is 0: 2 pixels are what images show");
  std::vector<ScaleLength> lengths;
  if (options.scales != ImageFlowOptions::Scales::single) {
    for (double length = largest; length > smallest * 1.001 && lengths.size() < 40; length /= 2)
      lengths.push_back({length, length});
    lengths.push_back({smallest, smallest});
  }
  if (options.step_length == ImageFlowOptions::StepLength::falling_error)
    lengths.push_back({smallest, 0});
  return lengths;
}

/// How far apart the pixels are that a scale is worked on.
double grid_spacing(const ScaleLength& which, const ImageFlowOptions& options) {
  const bool coarse = options.scales == ImageFlowOptions::Scales::hierarchical;
  return coarse ? std::max(1.0, which.deviation / pixels_per_length) : 1;
}

/// The signals at one scale, with their derivatives where these count.
ImageScale at_length(const Image<float>& source, const Image<float>& target, const ScaleLength& which,
                const ImageFlowOptions& options, const SurfaceScale& scale) {
  const double spacing = grid_spacing(which, options);
  const auto side = [&](int size) { return std::clamp(int(std::ceil(size / spacing)), 1, size); };
  const int width = side(source.width()), height = side(source.height());
  const double smoothness = pixels(options.smoothness, scale);
  ImageScale at{at_scale(source, which.deviation, width, height),
           at_scale(target, which.deviation, width, height),
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
  options.step_length = StepLength::scaled;
  options.steps = 1;
  options.tolerance = 1e-6;
  options.max_cycles = 100;
  return options;
}

ImageFlow image_flow(const Image<float>& source, const Image<float>& target,
                     const ImageFlowOptions& options, const Progress& progress) {
  require_images(source, target);
  const int width = source.width(), height = source.height();
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  const double detail = pixels(options.detail, scale);
  const auto [first, second] = flow_signals(source, target, detail, options.light);
  progress.step("prepare", 0.05).at(1);

  ImageFlow flow;
  flow.alignment = options.alignment;
  flow.path = options.alignment == Alignment::forward ? FlowPath::straight : options.path;
  flow.field = Image<float>(width, height, 2);
  const ImageScale whole{first, second, 1, {options.robust_data}};
  const ImageAligner judge(whole, options);
  const MovedImages blend = judge.move(flow.field);
  flow.error.push_back(error_of(blend, blend));

  const std::vector<ScaleLength> lengths = scale_lengths(options, scale);
  double work = 0;
  for (const ScaleLength& which : lengths) work += std::pow(grid_spacing(which, options), -2);
  Image<float> X(1, 1, 2);
  for (const ScaleLength& which : lengths) {
    const Stopwatch watch;
    const Progress step = progress.step(fmt::format("scale of {:.3g} pixels", which.length),
                                        0.95 * std::pow(grid_spacing(which, options), -2) / work);
    const ImageScale at = at_length(first, second, which, options, scale);
    ImageFlowLevel level;
    level.length = which.length;
    level.deviation = which.deviation;
    level.width = at.source.width();
    level.height = at.source.height();
    X = resized_field(X, level.width, level.height);
    if (mean_square(at.source) > faintest * faintest &&
        mean_square(at.target) > faintest * faintest)
      correct_at(ImageAligner(at, options), options, X, level, step);
    Image<float> field = resized_field(X, width, height);
    const double error = error_of(judge.move(field), blend);
    const bool keeps =
        options.step_length == ImageFlowOptions::StepLength::scaled || error < flow.error.back();
    if (keeps) flow.field = std::move(field);
    flow.error.push_back(keeps ? error : flow.error.back());
    level.seconds = watch.seconds();
    flow.levels.push_back(level);
    step.at(1);
  }
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
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  const auto [first, second] =
      flow_signals(source, target, pixels(options.detail, scale), options.light);
  progress.at(0.3);
  ImageFlow flow;
  flow.alignment = Alignment::forward;
  flow.path = FlowPath::straight;
  flow.field = completed(displacement);
  ImageFlowOptions measured = options;
  measured.alignment = flow.alignment;
  const ImageScale whole{first, second, 1, {options.robust_data}};
  const ImageAligner judge(whole, measured);
  const MovedImages blend = judge.move(Image<float>(source.width(), source.height(), 2));
  progress.at(0.6);
  flow.error = {error_of(blend, blend), error_of(judge.move(flow.field), blend)};
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
