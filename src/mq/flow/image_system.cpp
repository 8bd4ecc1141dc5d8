/// Planes have a margin of a row and a little more on both sides that stays 0, and w is 0 where a
/// pixel has no neighbour, so that kernels have no borders to look after: what they read there
/// counts nothing.

#include "mq/flow/image_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/kernels/flow_kernels.h"

namespace mq {
namespace {

constexpr std::int64_t system_row_block = 16;

/// The coarsest grid has at most so many pixels.
constexpr int coarsest_pixels = 64;

/// The coarser pixels that a fine one is interpolated from: ¾ of the one it lies in, ¼ of the one
/// on its side, which beyond the border is the same again.
struct Parents {
  int near, far;
};
Parents parents(int i, int coarse_size) {
  const int near = i / 2;
  return {near, std::clamp(i % 2 == 0 ? near - 1 : near + 1, 0, coarse_size - 1)};
}

}  // namespace

/// Two planes with margins.
struct ImageFlowSolver::Vectors {
  Vectors(int width, int height)
      : margin(width + 16), u(std::size_t(width) * height + 2 * margin), v(u.size()) {}
  float* across(std::int64_t k = 0) { return u.data() + margin + k; }
  float* down(std::int64_t k = 0) { return v.data() + margin + k; }
  const float* across(std::int64_t k = 0) const { return u.data() + margin + k; }
  const float* down(std::int64_t k = 0) const { return v.data() + margin + k; }

  std::int64_t margin;
  std::vector<float> u, v;
};

/// A on one grid, and its kernels on rows.
struct ImageFlowSolver::Grid {
  Grid(int w, int h) : width(w), height(h), margin(w + 16), colours(std::size_t(w) + 1) {
    for (std::vector<float>* plane : {&d11, &d12, &d22, &east, &south})
      plane->assign(std::size_t(w) * h + 2 * margin, 0.0F);
    for (std::size_t i = 0; i < colours.size(); ++i) colours[i] = i % 2 == 0 ? 1.0F : 0.0F;
  }
  std::int64_t size() const { return std::int64_t(width) * height; }
  float* at(std::vector<float>& plane, std::int64_t k) { return plane.data() + margin + k; }
  const float* at(const std::vector<float>& plane, std::int64_t k) const {
    return plane.data() + margin + k;
  }

  int width, height;
  std::int64_t margin;
  std::vector<float> d11, d12, d22, east, south;
  std::vector<float> colours;  ///< 1, 0, 1, ...

  FlowRow row(int y, const Vectors& x) const {
    const std::int64_t k = std::int64_t(y) * width;
    return {width,       at(d11, k),   at(d12, k),           at(d22, k),  at(east, k),
            at(south, k), at(south, k - width), x.across(k), x.down(k)};
  }

  /// Relaxes the pixels of one colour in row y.
  void relax_row(int y, int colour, const Vectors& b, Vectors& x, std::vector<float>& space) const {
    float *du = space.data(), *dv = du + width;
    const std::int64_t k = std::int64_t(y) * width;
    flow_kernels().update(row(y, x), b.across(k), b.down(k), du, dv);
    const float* mask = colours.data() + (y + colour) % 2;
    flow_kernels().add_masked(width, mask, du, x.across(k));
    flow_kernels().add_masked(width, mask, dv, x.down(k));
  }

  /// All pixels of one colour, then all of the other, in one walk through memory: the second
  /// follows a row behind the first, and rows at the ends of a block wait for its neighbours.
  /// `relax_row` touches whole rows, so that no two threads may be at adjacent ones: every second
  /// block waits for the others.
  void relax(int first, const Vectors& b, Vectors& x) const {
    const std::int64_t blocks = (height + system_row_block - 1) / system_row_block;
    const auto first_row = [&](std::int64_t block) {
      return int(std::min<std::int64_t>(height, block * system_row_block));
    };
    for (int odd = 0; odd < 2; ++odd)
      parallel_for(
          (blocks + 1 - odd) / 2,
          [&](std::int64_t i) {
            const int begin = first_row(2 * i + odd), end = first_row(2 * i + odd + 1);
            std::vector<float> space(2 * std::size_t(width));
            for (int y = begin; y < end; ++y) {
              relax_row(y, first, b, x, space);
              if (y - 1 > begin) relax_row(y - 1, 1 - first, b, x, space);
            }
          },
          1);
    parallel_for(
        blocks,
        [&](std::int64_t block) {
          std::vector<float> space(2 * std::size_t(width));
          const int begin = first_row(block);
          if (block > 0) relax_row(begin - 1, 1 - first, b, x, space);
          relax_row(begin, 1 - first, b, x, space);
          if (block == blocks - 1 && height - 1 > begin)
            relax_row(height - 1, 1 - first, b, x, space);
        },
        1);
  }

  void residual(const Vectors& b, const Vectors& x, Vectors& r) const {
    parallel_for(
        height,
        [&](std::int64_t y) {
          const std::int64_t k = y * width;
          flow_kernels().residual(row(int(y), x), b.across(k), b.down(k), r.across(k), r.down(k));
        },
        system_row_block);
  }

  /// y = A·x and xᵀAx.
  double multiply(const Vectors& x, Vectors& y) const {
    return parallel_sum(
        height, 0.0,
        [&](std::int64_t begin, std::int64_t end) {
          double sum = 0;
          for (std::int64_t j = begin; j < end; ++j) {
            flow_kernels().product(row(int(j), x), y.across(j * width), y.down(j * width));
            const float *xu = x.across(j * width), *xv = x.down(j * width);
            const float *yu = y.across(j * width), *yv = y.down(j * width);
            for (int i = 0; i < width; ++i) sum += double(xu[i]) * yu[i] + double(xv[i]) * yv[i];
          }
          return sum;
        },
        system_row_block);
  }

  /// The grid of half as many pixels a side.
  Grid coarser() const {
    Grid c((width + 1) / 2, (height + 1) / 2);
    parallel_for(
        c.height,
        [&](std::int64_t J) {
          for (int I = 0; I < c.width; ++I) {
            const std::int64_t K = J * c.width + I;
            for (int y = 2 * int(J); y < std::min(2 * int(J) + 2, height); ++y)
              for (int x = 2 * I; x < std::min(2 * I + 2, width); ++x) {
                const std::int64_t k = std::int64_t(y) * width + x;
                *c.at(c.d11, K) += *at(d11, k);
                *c.at(c.d12, K) += *at(d12, k);
                *c.at(c.d22, K) += *at(d22, k);
                // The last of an odd number stands alone, and so is its side.
                if (x == 2 * I + 1) *c.at(c.east, K) += 0.5F * *at(east, k);
                if (y == 2 * int(J) + 1) *c.at(c.south, K) += 0.5F * *at(south, k);
              }
          }
        },
        system_row_block);
    return c;
  }

  /// b of the coarser grid: the transpose of the interpolation times r.
  void restrict_to(const Grid& coarse, const Vectors& r, Vectors& b) const {
    parallel_for(
        coarse.height,
        [&](std::int64_t J) {
          std::vector<float> lines(2 * std::size_t(width), 0.0F);
          for (int y = std::max(0, 2 * int(J) - 1); y <= std::min(height - 1, 2 * int(J) + 2);
               ++y) {
            const Parents p = parents(y, coarse.height);
            const float weight = (p.near == J ? 0.75F : 0.0F) + (p.far == J ? 0.25F : 0.0F);
            const std::int64_t k = std::int64_t(y) * width;
            for (int i = 0; i < width; ++i) lines[std::size_t(i)] += weight * r.across(k)[i];
            for (int i = 0; i < width; ++i) lines[std::size_t(width + i)] += weight * r.down(k)[i];
          }
          for (int plane = 0; plane < 2; ++plane) {
            const float* line = lines.data() + plane * width;
            float* to = (plane == 0 ? b.across() : b.down()) + J * coarse.width;
            std::fill_n(to, coarse.width, 0.0F);
            for (int i = 0; i < width; ++i) {
              const Parents p = parents(i, coarse.width);
              to[p.near] += 0.75F * line[i];
              to[p.far] += 0.25F * line[i];
            }
          }
        },
        system_row_block);
  }

  /// x += interpolated.
  void add_from(const Grid& coarse, const Vectors& from, Vectors& x) const {
    parallel_for(
        height,
        [&](std::int64_t y) {
          const Parents p = parents(int(y), coarse.height);
          std::vector<float> line(std::size_t(coarse.width));
          for (int plane = 0; plane < 2; ++plane) {
            const float* values = plane == 0 ? from.across() : from.down();
            const float *near = values + std::int64_t(p.near) * coarse.width,
                        *far = values + std::int64_t(p.far) * coarse.width;
            for (int i = 0; i < coarse.width; ++i)
              line[std::size_t(i)] = 0.75F * near[i] + 0.25F * far[i];
            float* to = (plane == 0 ? x.across() : x.down()) + y * width;
            for (int i = 0; i < width; ++i) {
              const Parents q = parents(i, coarse.width);
              to[i] += 0.75F * line[std::size_t(q.near)] + 0.25F * line[std::size_t(q.far)];
            }
          }
        },
        system_row_block);
  }
};

ImageFlowSystem::ImageFlowSystem(int w, int h) : width(w), height(h) {
  require(w > 0 && h > 0, "a system of optical flow needs pixels");
  for (std::vector<float>* plane : {&d11, &d12, &d22, &east, &south})
    plane->assign(std::size_t(w) * h, 0.0F);
}

ImageFlowSolver::ImageFlowSolver(ImageFlowSystem system) {
  Grid finest(system.width, system.height);
  std::ranges::copy(system.d11, finest.at(finest.d11, 0));
  std::ranges::copy(system.d12, finest.at(finest.d12, 0));
  std::ranges::copy(system.d22, finest.at(finest.d22, 0));
  std::ranges::copy(system.east, finest.at(finest.east, 0));
  std::ranges::copy(system.south, finest.at(finest.south, 0));
  system = ImageFlowSystem(1, 1);
  grids_.push_back(std::move(finest));
  while (grids_.back().size() > coarsest_pixels) grids_.push_back(grids_.back().coarser());

  // The coarsest A, column by column, and its inverse.
  const Grid& coarsest = grids_.back();
  const int n = int(coarsest.size());
  Eigen::MatrixXd A(2 * n, 2 * n);
  Vectors x(coarsest.width, coarsest.height), y(coarsest.width, coarsest.height);
  for (int k = 0; k < 2 * n; ++k) {
    float& one = k < n ? *x.across(k) : *x.down(k - n);
    one = 1;
    coarsest.multiply(x, y);
    one = 0;
    for (int i = 0; i < n; ++i) A(i, k) = *y.across(i), A(n + i, k) = *y.down(i);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(A);
  if (factor.info() != Eigen::Success)
    throw SolverError(
        "the system of optical flow is not positive definite: there is nothing to say where it "
        "goes");
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(2 * n, 2 * n));
  for (int i = 0; i < 2 * n; ++i) {
    inverse_.emplace_back(std::size_t(2 * n));
    for (int k = 0; k < 2 * n; ++k)
      inverse_.back()[std::size_t(k)] = 0.5 * (inverse(i, k) + inverse(k, i));
  }
}

ImageFlowSolver::~ImageFlowSolver() = default;
ImageFlowSolver::ImageFlowSolver(ImageFlowSolver&&) noexcept = default;
ImageFlowSolver& ImageFlowSolver::operator=(ImageFlowSolver&&) noexcept = default;

void ImageFlowSolver::solve_coarsest(std::vector<Vectors>& work) const {
  const Vectors& b = work[work.size() - 3];
  Vectors& x = work[work.size() - 2];
  const int n = int(grids_.back().size());
  for (int i = 0; i < 2 * n; ++i) {
    double sum = 0;
    for (int k = 0; k < n; ++k)
      sum += inverse_[std::size_t(i)][std::size_t(k)] * *b.across(k) +
             inverse_[std::size_t(i)][std::size_t(n + k)] * *b.down(k);
    (i < n ? *x.across(i) : *x.down(i - n)) = float(sum);
  }
}

/// Of a level's three vectors b, x and r: x ≈ A⁻¹ b from x = 0.
void ImageFlowSolver::cycle(std::size_t level, std::vector<Vectors>& work) const {
  if (level + 1 == grids_.size()) {
    solve_coarsest(work);
    return;
  }
  const Grid &fine = grids_[level], &coarse = grids_[level + 1];
  Vectors &b = work[3 * level], &x = work[3 * level + 1], &r = work[3 * level + 2];
  Vectors &coarse_b = work[3 * level + 3], &coarse_x = work[3 * level + 4];
  std::ranges::fill(x.u, 0.0F);
  std::ranges::fill(x.v, 0.0F);
  fine.relax(0, b, x);
  fine.residual(b, x, r);
  fine.restrict_to(coarse, r, coarse_b);
  cycle(level + 1, work);
  fine.add_from(coarse, coarse_x, x);
  fine.relax(1, b, x);
}

SolveReport ImageFlowSolver::solve(const FlowPlanes& b, FlowPlanes& Y, double tolerance,
                                   int max_cycles, const Progress& progress) const {
  const Stopwatch watch;
  const Grid& A = grids_.front();
  const std::int64_t n = A.size();
  std::vector<Vectors> work;
  for (const Grid& grid : grids_)
    for (int i = 0; i < 3; ++i) work.emplace_back(grid.width, grid.height);
  Vectors &r = work[0], &z = work[1];  // the cycle solves for r, in place of b
  Vectors p(A.width, A.height), q(A.width, A.height), x(A.width, A.height);
  std::ranges::copy(b.u, r.across());
  std::ranges::copy(b.v, r.down());
  const auto dot = [&](const Vectors& a, const Vectors& c) {
    return parallel_sum(n, 0.0, [&](std::int64_t begin, std::int64_t end) {
      double sum = 0;
      for (std::int64_t k = begin; k < end; ++k)
        sum += double(*a.across(k)) * *c.across(k) + double(*a.down(k)) * *c.down(k);
      return sum;
    });
  };
  /// to = f·to + g·from.
  const auto combine = [&](float f, Vectors& to, float g, const Vectors& from) {
    parallel_blocks(n, 16384, [&](std::int64_t begin, std::int64_t end) {
      flow_kernels().combine(end - begin, f, to.across(begin), g, from.across(begin));
      flow_kernels().combine(end - begin, f, to.down(begin), g, from.down(begin));
    });
  };

  SolveReport report;
  report.method = "multigrid";
  report.residuals = {1};
  const double first = std::sqrt(dot(r, r));
  if (!std::isfinite(first))
    throw SolverError("the right side of a system of optical flow is not finite");
  double rho = 0;
  while (first > 0 && report.residuals.back() > tolerance && report.cycles < max_cycles) {
    cycle(0, work);
    const double next = dot(r, z);
    if (std::isnan(next)) throw SolverError("a value became not a number in optical flow's solver");
    if (!(next > 0)) break;  // rounding is all that is left
    combine(report.cycles == 0 ? 0.0F : float(next / rho), p, 1, z);
    rho = next;
    const double energy = A.multiply(p, q);
    if (!(energy > 0)) break;
    const float step = float(rho / energy);
    combine(1, x, step, p);
    combine(1, r, -step, q);
    ++report.cycles;
    report.residuals.push_back(std::sqrt(dot(r, r)) / first);
    progress.check();
  }
  report.converged = first == 0 || report.residuals.back() <= tolerance;
  Y.u.assign(x.across(), x.across(n));
  Y.v.assign(x.down(), x.down(n));
  report.solve_seconds = watch.seconds();
  return report;
}

FlowPlanes ImageFlowSolver::times(const FlowPlanes& Y) const {
  const Grid& A = grids_.front();
  Vectors x(A.width, A.height), y(A.width, A.height);
  std::ranges::copy(Y.u, x.across());
  std::ranges::copy(Y.v, x.down());
  A.multiply(x, y);
  return {{y.across(), y.across(A.size())}, {y.down(), y.down(A.size())}};
}

}  // namespace mq
