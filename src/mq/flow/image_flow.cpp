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
#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/detail_match.h"
#include "mq/flow/detail/field_fusion.h"
#include "mq/flow/detail/image_levels.h"
#include "mq/flow/detail/image_sight.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/torn_flow.h"

namespace mq {
namespace {

using Alignment = FlowAlignment;

/// Of α*, before a correction is given up.
constexpr int halvings = 4;

/// Of all pixels, that are unlike along a field before a search is worth its time.
constexpr double least_unlike = 0.01;

/// Of the misfit, that the field of a search may leave: where light changed, other motions fit a quarter better.
constexpr double most_of_misfit = 2.0 / 3;

/// Of all pixels, that nothing fits, and of the blend's error, that is left, from where on two images show different things.
/// Turned by 45 degrees things are at 0.09 and 0.12, under strong noise at 0.12 and 0.55, different textures from 0.16 and
/// 0.35 on.
constexpr double unrelated_unfit = 0.15, unrelated_error = 0.3;

/// Of `DetailMatch`, from where on they do so as well: mirrored and different photographs have at most 0.3 alike and a
/// bend of 0.4 and more, things turned by 25 degrees that are still found 0.6 and more.
constexpr double unrelated_alike = 0.35, unrelated_bend = 0.3;

/// And from where on parts may be mangled: a head turned by 14 degrees has 0.83 alike and a bend of 0.23, by 10 degrees
/// 0.93 and 0.16.
constexpr double strained_alike = 0.9, strained_bend = 0.15;

/// Of all pixels, that nothing fits, or of the blend's error, that is left, from where on light may have changed.
constexpr double doubtful_unfit = 0.05, doubtful_error = 0.2;

/// Of the ratio of light along a field, from where on it is another in each: of pictures in one light it is 0.001 to
/// 0.005, where one has a tenth more 0.03 along a field that is wrong for it.
constexpr double least_light = 0.01;

/// What light hardly changes, in % of √area: finer than that.
constexpr double lightless_detail = 2;

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
SignalPair prepared(const Image<float>& source, const Image<float>& target, const Length& detail, ImageLight light) {
  require_images(source, target);
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  return flow_signals(source, target, flow_pixels(detail, scale), light);
}

double share_above(const Image<float>& values, float least) {
  const auto count = std::ranges::count_if(values.values(), [&](float value) { return value > least; });
  return double(count) / double(values.pixel_count());
}

/// The error of a straight field over the pixels that are seen in both images.
double error_where_seen(const SignalPair& signals, const Image<float>& X, const FieldClaims& claims,
                        const ImageFlowOptions& options) {
  ImageFlowOptions straight = options;
  straight.path = FlowPath::straight;
  const ImageScale whole{signals.source, signals.target, 1, {options.robust_data}};
  MovedImages moved = ImageAligner(whole, straight).move(X);
  const std::vector<char> seen = seen_in_both(X, claims);
  const auto count = std::ranges::count(seen, 1);
  for (std::size_t k = 0; k < seen.size(); ++k)
    if (!seen[k]) moved.inside[k] = 0, moved.cost[k] = 0;
  return count > 0 ? error_of(moved, moved) * double(seen.size()) / double(count) : 0;
}

/// Puts the field of the search in place of the one at hand where the images fit better along it.
void take_far(ImageFlow& flow, const SignalPair& signals, const ImageFlowOptions& options, const Progress& progress) {
  const Stopwatch watch;
  const Image<float> smooth = straightened(flow.field, flow.path);
  flow.fit = {.misfit = misfit(signals, smooth), .detail = options.detail, .light = options.light};
  ImageFlow::Fit& fit = *flow.fit;
  if (!(share_above(fit.misfit, unlike_misfit) > least_unlike)) return;
  Image<float> X = torn_field(signals, smooth, options, progress);
  Image<float> costs = misfit(signals, X);
  const FieldClaims claims = claimed(X, 0.5, costs);
  const double before = mean(misfit(signals, smooth, claimed(smooth, 0.5, fit.misfit)));
  const double error = error_where_seen(signals, X, claims, options);
  if (mean(misfit(signals, X, claims)) < most_of_misfit * before && error < flow.error.back()) {
    ImageFlowLevel level;
    level.width = X.width();
    level.height = X.height();
    level.length = flow.levels.back().length;
    level.before = flow.error.back();
    level.after = level.error = error;
    level.seconds = watch.seconds();
    flow.levels.push_back(level);
    flow.error.push_back(error);
    flow.field = std::move(X);
    flow.path = FlowPath::straight;
    fit.misfit = std::move(costs);
    fit.torn = true;
  }
  fit.unfit = mean(image_sight(signals, flow, 0.5).unfit);
}

/// Searches for far motions, and says how the images fit along what is kept.
void search_far(ImageFlow& flow, const SignalPair& signals, const ImageFlowOptions& options, const Progress& progress) {
  take_far(flow, signals, options, progress);
  ImageFlow::Fit& fit = *flow.fit;
  const Image<float> X = straightened(flow.field, flow.path);
  const DetailMatch match =
      detail_match(signals, X, seen_in_both(X, fit.torn ? claimed(X, 0.5, fit.misfit) : FieldClaims()));
  fit.alike = match.alike;
  fit.bend = match.bend;
  fit.unrelated = (fit.unfit > unrelated_unfit && flow.error.back() > unrelated_error * flow.error.front()) ||
                  (match.alike < unrelated_alike && match.bend > unrelated_bend);
  fit.strained = !fit.unrelated && match.alike < strained_alike && match.bend > strained_bend;
}

/// Whether far motions are searched for.
bool searches(const ImageFlowOptions& options) {
  return options.search == FlowSearch::far && options.alignment == Alignment::halfway &&
         options.scales == ImageFlowOptions::Scales::hierarchical;
}

/// Two images aligned from large to small scales, and what was aligned.
struct Aligned {
  SignalPair signals;
  ImageFlow flow;
};

/// With light as the options say: kept or matched.
Aligned coarse_to_fine_aligned(const Image<float>& source, const Image<float>& target, const ImageFlowOptions& options,
                               const Progress& progress) {
  Aligned result{prepared(source, target, options.detail, options.light), {}};
  progress.step("prepare", 0.05).at(1);
  ImageFlow& flow = result.flow;
  flow.alignment = options.alignment;
  flow.path = options.alignment == Alignment::forward ? FlowPath::straight : options.path;
  ImageLevels levels(result.signals, options);
  const SurfaceScale scale{.area = double(source.pixel_count()), .texel_spacing = 1};
  flow.error = coarse_to_fine(levels, image_flow_scales(options, scale), options,
                              {.halvings = halvings, .after_worse = FlowPolicy::AfterWorse::last, .share = 0.95},
                              progress);
  flow.levels = levels.take_levels();
  for (std::size_t l = 0; l < flow.levels.size(); ++l) flow.levels[l].error = flow.error[l + 1];
  flow.field = levels.take_field();
  return result;
}

/// And what is far from that, where it is searched for.
ImageFlow flow_in_light(const Image<float>& source, const Image<float>& target, const ImageFlowOptions& options,
                        const Progress& progress) {
  Aligned found = coarse_to_fine_aligned(source, target, options, progress.step("align", searches(options) ? 0.5 : 1));
  if (searches(options)) search_far(found.flow, found.signals, options, progress.step("search far", 0.5));
  return std::move(found.flow);
}

/// How much more light the target has along the field.
LightRatio light_along(const ImageFlow& flow, const Image<float>& source, const Image<float>& target,
                       LightBreaks breaks = LightBreaks::none) {
  return light_ratio(source, target, straightened(flow.field, flow.path), breaks);
}

/// The flow with the ratio of light made good.
ImageFlow flow_evened(const Image<float>& source, const Image<float>& target, ImageFlowOptions options,
                      const Progress& progress) {
  ImageFlowOptions lightless = options;
  lightless.light = ImageLight::matched;
  lightless.detail = {lightless_detail, Length::Unit::percent};
  options.light = ImageLight::kept;
  LightRatio ratio = light_along(
      coarse_to_fine_aligned(source, target, lightless, progress.step("find light", 0.2)).flow, source, target,
      LightBreaks::found);
  LitImages lit = in_mean_light(ratio, source, target);
  ratio = light_along(
      coarse_to_fine_aligned(lit.source, lit.target, lightless, progress.step("find light", 0.2)).flow, source, target,
      LightBreaks::found);
  lit = in_mean_light(ratio, source, target);
  ImageFlow flow = flow_in_light(lit.source, lit.target, options, progress.step("align", 0.6));
  flow.fit->light = ImageLight::evened;
  flow.fit->ratio = std::move(ratio);
  return flow;
}

/// Ratios of light are told of such.
bool is_positive(const Image<float>& image) {
  return std::ranges::all_of(image.values(), [](float value) { return value >= 0; });
}

/// As kept light shows them; evened or matched where they fit a third better so.
ImageFlow flow_in_doubtful_light(const Image<float>& source, const Image<float>& target, ImageFlowOptions options,
                                 const Progress& progress) {
  options.light = ImageLight::kept;
  Aligned kept = coarse_to_fine_aligned(source, target, options, progress.step("align", 0.45));
  ImageFlow& flow = kept.flow;
  double most = most_of_misfit * mean(misfit(kept.signals, straightened(flow.field, flow.path)));
  const auto fits_better = [&](const ImageFlow& other) { return mean(other.fit->misfit) < most; };
  const bool positive = is_positive(source) && is_positive(target);
  const bool is_lit = positive && light_along(flow, source, target).size > least_light;
  if (is_lit)
    if (ImageFlow evened = flow_evened(source, target, options, progress.step("even light", 0.5)); fits_better(evened))
      return evened;
  search_far(flow, kept.signals, options, progress.step("search far", 0.5));
  if (flow.fit->unfit < doubtful_unfit && flow.error.back() < doubtful_error * flow.error.front()) return flow;
  most = most_of_misfit * mean(flow.fit->misfit);
  if (positive && !is_lit)
    if (ImageFlow evened = flow_evened(source, target, options, progress.step("even light", 0.02)); fits_better(evened))
      return evened;
  options.light = ImageLight::matched;
  if (ImageFlow matched = flow_in_light(source, target, options, progress.step("match light", 0.02)); fits_better(matched))
    return matched;
  return std::move(flow);
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
  options.search = FlowSearch::none;
  options.light = ImageLight::kept;
  options.steps = 1;
  options.tolerance = 1e-6;
  options.max_cycles = 100;
  return options;
}

ImageFlow image_flow(const Image<float>& source, const Image<float>& target,
                     const ImageFlowOptions& options, const Progress& progress) {
  require_images(source, target);
  const bool is_evened = options.light == ImageLight::evened;
  require(!is_evened || (searches(options) && is_positive(source) && is_positive(target)),
          "light is evened of images without negative values, where far motions are searched for");
  if (is_evened) return flow_evened(source, target, options, progress);
  if (options.light == ImageLight::doubted && searches(options))
    return flow_in_doubtful_light(source, target, options, progress);
  ImageFlowOptions lit = options;
  if (options.light == ImageLight::doubted) lit.light = ImageLight::kept;
  return flow_in_light(source, target, lit, progress);
}

ImageFlow known_flow(const Image<float>& source, const Image<float>& target,
                     const Image<float>& displacement, const ImageFlowOptions& options,
                     const Progress& progress) {
  require_images(source, target);
  require(
      displacement.width() == source.width() && displacement.height() == source.height(),
      fmt::format("a flow of {} x {} pixels was given for images of {} x {}", displacement.width(),
                  displacement.height(), source.width(), source.height()));
  const SignalPair signals = prepared(source, target, options.detail, options.light);
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
  if (flow.fit && flow.fit->torn) return forward_warp(flow.field, -0.5, flow.fit->misfit).field;
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

/// (1 − t)·φ₀ + t·φ₁.
static Image<float> blended(const Image<float>& source, const Image<float>& target, double t) {
  Image<float> between = source;
  const auto of = target.values();
  const auto values = between.values();
  parallel_for(std::ssize(values), [&](std::int64_t k) {
    values[std::size_t(k)] += float(t) * (of[std::size_t(k)] - values[std::size_t(k)]);
  });
  return between;
}

/// Both along the ways, in the parts that `sight` says.
static Image<float> mixed(const ImageSight& sight, const Image<float>& source, const Image<float>& target, double t) {
  Image<float> between = displaced(source, sight.ways.back);
  const Image<float> other = displaced(target, sight.ways.forth);
  parallel_for(
      between.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < between.width(); ++x) {
          const float part = sight.target(x, y), unfit = sight.unfit(x, y);
          const std::span<float> value = between.pixel(x, y);
          const std::span<const float> first = source.pixel(x, y), second = target.pixel(x, y);
          for (std::size_t c = 0; c < value.size(); ++c) {
            value[c] += part * (other(x, y, int(c)) - value[c]);
            if (unfit > 0) value[c] += unfit * (first[c] + float(t) * (second[c] - first[c]) - value[c]);
          }
        }
      },
      row_block);
  return between;
}

Image<float> interpolated(const ImageFlow& flow, const Image<float>& source,
                          const Image<float>& target, double t) {
  require_images(source, target);
  require(t >= 0 && t <= 1, fmt::format("a time between 0 and 1 is wanted; found {}", t));
  require(source.width() == flow.field.width() && source.height() == flow.field.height(),
          "the flow is that of images of another size");
  if (t == 0) return source;
  if (t == 1) return target;
  if (flow.fit && flow.fit->unrelated) return blended(source, target, t);
  if (flow.fit && flow.fit->light == ImageLight::evened) {
    const LitImages lit = in_mean_light(flow.fit->ratio, source, target), now = in_light(flow.fit->ratio, source, target, t);
    const ImageSight sight = image_sight(prepared(lit.source, lit.target, flow.fit->detail, ImageLight::kept), flow, t);
    return mixed(sight, now.source, now.target, t);
  }
  if (flow.fit && (flow.fit->torn || flow.fit->unfit > 0))
    return mixed(image_sight(prepared(source, target, flow.fit->detail, flow.fit->light), flow, t), source, target, t);
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
