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

/// What pulls the field to 0 where nothing says where it goes, against Ḡ.
constexpr double pull = 1e-6;

/// How often ψ is made quadratic about the last Y.
constexpr int reweightings = 3;

/// α* of (4.8) is 1 or more in exact arithmetic, and cut off where linear models end.
constexpr double scale_slack = 1e-3, largest_scale = 4;

constexpr int halvings = 4;

double pixels(const Length& length, const SurfaceScale& scale) {
  require(length.value >= 0,
          fmt::format("a length of {} pixels is negative: 0 or more is wanted", length.value));
  return std::sqrt(weight_from_length(length, scale));
}

/// ψ of width ϵ, 0 for squares, with what it is made quadratic by: ψ(s²) ≈ w·s² + const.
struct Penalty {
  double width = 0;
  double value(double square) const {
    if (width == 0) return square;
    return 2 * width * (std::sqrt(square + width * width) - width);
  }
  double weight(double square) const {
    return width == 0 ? 1 : width / std::sqrt(square + width * width);
  }
};

/// Two signals moved towards each other.
struct Moved {
  Image<float> source, target;
  std::vector<char> inside;  ///< whether both places are in the image
  std::vector<float> cost;   ///< Σ_c ψ_D per pixel
};

struct Costs {
  double before = 0, after = 0;
  Costs operator+(const Costs& other) const { return {before + other.before, after + other.after}; }
};

/// The costs of two fields over the pixels that both keep in the images: none gets better by what
/// it moves out of sight.
Costs compared(const Moved& before, const Moved& after) {
  return parallel_sum(std::int64_t(before.cost.size()), Costs{},
                      [&](std::int64_t begin, std::int64_t end) {
                        Costs sum;
                        for (std::size_t k = std::size_t(begin); k < std::size_t(end); ++k)
                          if (before.inside[k] && after.inside[k])
                            sum = sum + Costs{before.cost[k], after.cost[k]};
                        return sum;
                      });
}

/// The mean of ψ_D over pixels and channels, where what is out of sight counts as in `blend`.
double error_of(const Moved& moved, const Moved& blend) {
  const double sum =
      parallel_sum(std::int64_t(moved.cost.size()), 0.0, [&](std::int64_t begin, std::int64_t end) {
        double part = 0;
        for (std::size_t k = std::size_t(begin); k < std::size_t(end); ++k)
          part += moved.inside[k] ? moved.cost[k] : blend.cost[k];
        return part;
      });
  return sum / double(moved.source.values().size());
}

/// What one scale is made of.
struct Scale {
  Image<float> source, target;
  double length;  ///< pixels of this grid
  Penalty data;
};

class Aligner {
 public:
  Aligner(const Scale& scale, const ImageFlowOptions& options) : scale_(scale), options_(options) {}

  Moved move(const Image<float>& X) const {
    const Image<float>& like = scale_.source;
    Moved moved;
    moved.inside.assign(std::size_t(like.pixel_count()), 1);
    const bool forward = options_.alignment == Alignment::forward;
    const auto warp = [&](const Image<float>& signal, double time) {
      const Image<float> d = displacement(X, time, forward ? FlowPath::straight : options_.path);
      parallel_for(
          like.height(),
          [&](std::int64_t y) {
            for (int x = 0; x < like.width(); ++x)
              if (!lands_inside(d, x, int(y))) moved.inside[std::size_t(y) * like.width() + x] = 0;
          },
          row_block);
      return displaced(signal, d, Overshoot::kept);
    };
    moved.source = forward ? scale_.source : warp(scale_.source, -0.5);
    moved.target = warp(scale_.target, forward ? 1 : 0.5);
    moved.cost.resize(moved.inside.size());
    parallel_for(
        like.height(),
        [&](std::int64_t y) {
          for (int x = 0; x < like.width(); ++x) {
            const auto a = moved.source.pixel(x, int(y)), b = moved.target.pixel(x, int(y));
            double sum = 0;
            for (std::size_t c = 0; c < a.size(); ++c)
              sum += scale_.data.value((double(b[c]) - a[c]) * (double(b[c]) - a[c]));
            moved.cost[std::size_t(y) * like.width() + x] = float(sum);
          }
        },
        row_block);
    return moved;
  }

  /// A correction and its scale α*; α* = 0 where there is nothing to correct.
  struct Correction {
    FlowPlanes Y;
    double scale = 0;
    int cycles = 0;
  };
  Correction correct(const Moved& moved, const Progress& progress) const {
    Correction correction;
    const std::size_t n = moved.inside.size();
    correction.Y = {std::vector<float>(n), std::vector<float>(n)};
    const bool robust = options_.robust_data > 0 || options_.robust_smoothness > 0;
    for (int round = 0; round < (robust ? reweightings : 1); ++round) {
      Equations equations = linearised(moved, correction.Y);
      if (!(equations.mean_slope > 0)) return {};
      const ImageFlowSystem& A = equations.system;
      const std::vector<float> d11 = A.d11, d12 = A.d12, d22 = A.d22;
      const ImageFlowSolver solver(std::move(equations.system));
      const SolveReport report = solver.solve(equations.b, correction.Y, options_.tolerance,
                                              options_.max_cycles, progress);
      correction.cycles += report.cycles;
      correction.scale = best_scale(d11, d12, d22, equations, correction.Y);
    }
    return correction;
  }

 private:
  struct Equations {
    explicit Equations(int width, int height)
        : system(width, height),
          b{std::vector<float>(system.d11.size()), std::vector<float>(system.d11.size())} {}
    ImageFlowSystem system;
    FlowPlanes b;
    double mean_slope = 0;  ///< Ḡ
    double pull = 0;        ///< in D
  };

  /// ψ_S's weight at each pixel, from the differences to the right and down.
  std::vector<float> smoothness_weights(const FlowPlanes& Y) const {
    const int width = scale_.source.width(), height = scale_.source.height();
    std::vector<float> weights(Y.u.size(), 1.0F);
    if (options_.robust_smoothness == 0) return weights;
    const Penalty psi{options_.robust_smoothness};
    parallel_for(
        height,
        [&](std::int64_t y) {
          for (int x = 0; x < width; ++x) {
            const std::size_t k = std::size_t(y) * width + x;
            const std::size_t right = x + 1 < width ? k + 1 : k,
                              below = y + 1 < height ? k + width : k;
            double square = 0;
            for (const std::vector<float>* plane : {&Y.u, &Y.v})
              for (const std::size_t other : {right, below}) {
                const double d = double((*plane)[other]) - (*plane)[k];
                square += d * d;
              }
            weights[k] = float(psi.weight(square));
          }
        },
        row_block);
    return weights;
  }

  /// A = D + ℓ²Ḡ·L and b = −Σ_c w·δ·∇μ with the weights that Y has.
  Equations linearised(const Moved& moved, const FlowPlanes& Y) const {
    const int width = moved.source.width(), height = moved.source.height();
    const int channels = moved.source.channels();
    Equations equations(width, height);
    ImageFlowSystem& A = equations.system;
    const bool forward = options_.alignment == Alignment::forward;
    const double sum = parallel_sum(
        height, 0.0,
        [&](std::int64_t begin, std::int64_t end) {
          double part = 0;
          for (int y = int(begin); y < int(end); ++y)
            for (int x = 0; x < width; ++x) {
              const std::size_t k = std::size_t(y) * width + x;
              for (int c = 0; c < channels; ++c) {
                const Slope before = slope(moved.source, x, y, c),
                            after = slope(moved.target, x, y, c);
                const Slope g =
                    forward ? after
                            : Slope{0.5F * (before.x + after.x), 0.5F * (before.y + after.y)};
                part += double(g.x) * g.x + double(g.y) * g.y;
                if (!moved.inside[k]) continue;
                const float delta = moved.target(x, y, c) - moved.source(x, y, c);
                const double left = double(delta) + (double(Y.u[k]) * g.x + double(Y.v[k]) * g.y);
                const float w = float(scale_.data.weight(left * left));
                A.d11[k] += w * g.x * g.x;
                A.d12[k] += w * g.x * g.y;
                A.d22[k] += w * g.y * g.y;
                equations.b.u[k] -= w * delta * g.x;
                equations.b.v[k] -= w * delta * g.y;
              }
            }
          return part;
        },
        row_block);
    equations.mean_slope = sum / double(A.d11.size());
    equations.pull = pull * equations.mean_slope;
    const double stiffness = scale_.length * scale_.length * equations.mean_slope;
    const std::vector<float> weights = smoothness_weights(Y);
    parallel_for(
        height,
        [&](std::int64_t y) {
          for (int x = 0; x < width; ++x) {
            const std::size_t k = std::size_t(y) * width + x;
            A.d11[k] += float(equations.pull);
            A.d22[k] += float(equations.pull);
            if (x + 1 < width) A.east[k] = float(stiffness) * 0.5F * (weights[k] + weights[k + 1]);
            if (y + 1 < height)
              A.south[k] = float(stiffness) * 0.5F * (weights[k] + weights[k + std::size_t(width)]);
          }
        },
        row_block);
    return equations;
  }

  /// Equation (4.8): YᵀDY·α* = Yᵀb.
  static double best_scale(const std::vector<float>& d11, const std::vector<float>& d12,
                           const std::vector<float>& d22, const Equations& equations,
                           const FlowPlanes& Y) {
    struct Sums {
      double energy = 0, work = 0;
      Sums operator+(const Sums& other) const { return {energy + other.energy, work + other.work}; }
    };
    const Sums sums =
        parallel_sum(std::int64_t(Y.u.size()), Sums{}, [&](std::int64_t begin, std::int64_t end) {
          Sums part;
          for (std::size_t k = std::size_t(begin); k < std::size_t(end); ++k) {
            const double u = Y.u[k], v = Y.v[k];
            part.energy += (d11[k] - equations.pull) * u * u + 2 * d12[k] * u * v +
                           (d22[k] - equations.pull) * v * v;
            part.work += u * equations.b.u[k] + v * equations.b.v[k];
          }
          return part;
        });
    if (!(sums.energy > 0)) return 0;
    const double scale = sums.work / sums.energy;
    if (!(scale >= 1 - scale_slack))
      throw SolverError(fmt::format(
          "the scale of a correction came out as {}, and is 1 or more where signs are right",
          scale));
    return scale;
  }

  const Scale& scale_;
  const ImageFlowOptions& options_;
};

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
void correct_at(const Aligner& aligner, const ImageFlowOptions& options, Image<float>& X,
                ImageFlowLevel& level, const Progress& progress) {
  const Moved blend = aligner.move(Image<float>(X.width(), X.height(), 2));
  Moved moved = aligner.move(X);
  level.before = error_of(moved, blend);
  const bool any = options.step_length == ImageFlowOptions::StepLength::scaled;
  for (int step = 0; step < options.steps; ++step) {
    progress.at(double(step) / options.steps, fmt::format("error {:.3g}", error_of(moved, blend)));
    const Aligner::Correction correction = aligner.correct(moved, progress);
    level.cycles += correction.cycles;
    if (correction.scale == 0) break;
    if (step == 0) level.scale = correction.scale;
    double factor = any ? correction.scale : std::min(correction.scale, largest_scale);
    double left = 1;  // of the cost, by this step
    for (int half = 0; half <= (any ? 0 : halvings); ++half, factor /= 2) {
      progress.check();
      Image<float> further = stepped(X, correction.Y, factor);
      Moved next = aligner.move(further);
      const Costs costs = compared(moved, next);
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
Scale at_length(const Image<float>& source, const Image<float>& target, const ScaleLength& which,
                const ImageFlowOptions& options, const SurfaceScale& scale) {
  const double spacing = grid_spacing(which, options);
  const auto side = [&](int size) { return std::clamp(int(std::ceil(size / spacing)), 1, size); };
  const int width = side(source.width()), height = side(source.height());
  const double smoothness = pixels(options.smoothness, scale);
  Scale at{at_scale(source, which.deviation, width, height),
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
  const Scale whole{first, second, 1, {options.robust_data}};
  const Aligner judge(whole, options);
  const Moved blend = judge.move(flow.field);
  flow.error.push_back(error_of(blend, blend));

  const std::vector<ScaleLength> lengths = scale_lengths(options, scale);
  double work = 0;
  for (const ScaleLength& which : lengths) work += std::pow(grid_spacing(which, options), -2);
  Image<float> X(1, 1, 2);
  for (const ScaleLength& which : lengths) {
    const Stopwatch watch;
    const Progress step = progress.step(fmt::format("scale of {:.3g} pixels", which.length),
                                        0.95 * std::pow(grid_spacing(which, options), -2) / work);
    const Scale at = at_length(first, second, which, options, scale);
    ImageFlowLevel level;
    level.length = which.length;
    level.deviation = which.deviation;
    level.width = at.source.width();
    level.height = at.source.height();
    X = resized_field(X, level.width, level.height);
    if (mean_square(at.source) > faintest * faintest &&
        mean_square(at.target) > faintest * faintest)
      correct_at(Aligner(at, options), options, X, level, step);
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
  const Scale whole{first, second, 1, {options.robust_data}};
  const Aligner judge(whole, measured);
  const Moved blend = judge.move(Image<float>(source.width(), source.height(), 2));
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
