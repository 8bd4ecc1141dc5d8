#include "mq/flow/detail/image_aligner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"

namespace mq {
namespace {

using Alignment = FlowAlignment;

/// What pulls the field to 0 where nothing says where it goes, against Ḡ.
constexpr double pull = 1e-6;

/// α* of (4.8) is 1 or more in exact arithmetic, and cut off where linear models end.
constexpr double scale_slack = 1e-3;

/// A jump of the field, pixels, that halves the smoothness of corrections across it.
constexpr float half_torn = 1;

/// What is left of the smoothness between two pixels.
float joined(const Image<float>& torn, std::size_t p, std::size_t q) {
  if (torn.empty()) return 1;
  const float u = torn.values()[2 * p] - torn.values()[2 * q], v = torn.values()[2 * p + 1] - torn.values()[2 * q + 1];
  return 1 / (1 + (u * u + v * v) / (half_torn * half_torn));
}

}  // namespace

MovedCosts compared(const MovedImages& before, const MovedImages& after) {
  return parallel_sum(std::int64_t(before.cost.size()), MovedCosts{},
                      [&](std::int64_t begin, std::int64_t end) {
                        MovedCosts sum;
                        for (std::size_t k = std::size_t(begin); k < std::size_t(end); ++k)
                          if (before.inside[k] && after.inside[k])
                            sum = sum + MovedCosts{before.cost[k], after.cost[k]};
                        return sum;
                      });
}

double error_of(const MovedImages& moved, const MovedImages& blend) {
  const double sum =
      parallel_sum(std::int64_t(moved.cost.size()), 0.0, [&](std::int64_t begin, std::int64_t end) {
        double part = 0;
        for (std::size_t k = std::size_t(begin); k < std::size_t(end); ++k)
          part += moved.inside[k] ? moved.cost[k] : blend.cost[k];
        return part;
      });
  return sum / double(moved.source.values().size());
}

MovedImages ImageAligner::move(const Image<float>& X) const {
  const Image<float>& like = scale_.source;
  MovedImages moved;
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

struct ImageAligner::Equations {
  explicit Equations(int width, int height)
      : system(width, height),
        b{std::vector<float>(system.d11.size()), std::vector<float>(system.d11.size())} {}
  ImageFlowSystem system;
  FlowPlanes b;
  double mean_slope = 0;  ///< Ḡ
  double pull = 0;        ///< in D
};

/// ψ_S's weight at each pixel, from the differences to the right and down.
std::vector<float> ImageAligner::smoothness_weights(const FlowPlanes& Y) const {
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
ImageAligner::Equations ImageAligner::linearised(const MovedImages& moved,
                                                 const FlowPlanes& Y) const {
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
                  forward ? after : Slope{0.5F * (before.x + after.x), 0.5F * (before.y + after.y)};
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
          const auto between = [&](std::size_t other) {
            return float(stiffness) * 0.5F * (weights[k] + weights[other]) * joined(scale_.torn, k, other);
          };
          if (x + 1 < width) A.east[k] = between(k + 1);
          if (y + 1 < height) A.south[k] = between(k + std::size_t(width));
        }
      },
      row_block);
  return equations;
}

/// Equation (4.8): YᵀDY·α* = Yᵀb.
double ImageAligner::best_scale(const std::vector<float>& d11, const std::vector<float>& d12,
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
        "the scale of a correction came out as {}, and is 1 or more where signs are right", scale));
  return scale;
}

ImageAligner::Correction ImageAligner::correct(const MovedImages& moved,
                                               const Progress& progress) const {
  Correction correction;
  const std::size_t n = moved.inside.size();
  correction.Y = {std::vector<float>(n), std::vector<float>(n)};
  const bool robust = options_.robust_data > 0 || options_.robust_smoothness > 0;
  for (int round = 0; round < (robust ? std::max(1, options_.reweightings) : 1); ++round) {
    Equations equations = linearised(moved, correction.Y);
    if (!(equations.mean_slope > 0)) return {};
    const ImageFlowSystem& A = equations.system;
    const std::vector<float> d11 = A.d11, d12 = A.d12, d22 = A.d22;
    const ImageFlowSolver solver(std::move(equations.system));
    const SolveReport report =
        solver.solve(equations.b, correction.Y, options_.tolerance, options_.max_cycles, progress);
    correction.cycles += report.cycles;
    correction.scale = best_scale(d11, d12, d22, equations, correction.Y);
  }
  return correction;
}

}  // namespace mq
