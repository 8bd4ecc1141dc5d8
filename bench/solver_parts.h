#pragma once
/// What the parts of a cycle take (thesis, Figure 5.9). The cycles here are those of the solvers, walked through by
/// their own steps with a clock between them; whether they give the same bits is checked.

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "mq/base/error.h"
#include "mq/baseline/reference_cycle.h"
#include "mq/fem/texel_hierarchy.h"
#include "solver_cases.h"
#include "watch.h"

namespace mq::bench {

/// Seconds of one cycle.
struct CycleParts {
  double stencils = 0;   ///< relaxation of texels inside of charts
  double boundary = 0;   ///< seams: a direct solution, or patches
  double transfers = 0;  ///< residuals, restriction and prolongation
  double coarse = 0;     ///< the coarsest level, or all levels of points
  double whole = 0;      ///< the solver's own cycle, without clocks inside

  double sum() const { return stencils + boundary + transfers + coarse; }
};

/// The reference's levels, its own workspace apart, which has no vectors to be seen.
class ReferenceWalk {
 public:
  using Cycle = ReferenceCycle<double>;
  ReferenceWalk(const Cycle& cycle, int sweeps) : cycle_(cycle), workspace_(cycle, 4, 3), sweeps_(sweeps) {
    for (std::size_t l = 0; l <= cycle.levels().size(); ++l) {
      const int rows = l == 0 ? cycle.rows() : cycle.levels()[l - 1].transfer->coarse_rows();
      const std::size_t size = std::size_t(rows) * 4;
      levels_.push_back({std::vector<double>(size), std::vector<double>(size), std::vector<double>(size)});
    }
  }

  template <class Watch>
  void descend(std::size_t l, const double* b, double* x, Watch& watch) {
    if (l == cycle_.levels().size())
      return watch.add(&CycleParts::coarse, [&] { cycle_.solve_coarsest(b, x, workspace_); });
    const Cycle::Level& level = cycle_.levels()[l];
    const auto relax = [&] { level.interior.relax(4, b, x, sweeps_); };
    const auto solve_boundary = [&] { cycle_.solve_boundary(level, b, x, workspace_); };
    watch.add(&CycleParts::stencils, relax);
    watch.add(&CycleParts::boundary, solve_boundary);
    Vectors& below = levels_[l + 1];
    watch.add(&CycleParts::transfers, [&] {
      double* r = levels_[l].r.data();
      level.interior.residual(4, b, x, r);
      level.boundary.residual(4, b, x, r);
      level.interpolation.restrict_to(4, r, below.b.data());
      std::ranges::fill(below.x, 0.0);
    });
    descend(l + 1, below.b.data(), below.x.data(), watch);
    watch.add(&CycleParts::transfers, [&] { level.interpolation.prolongate_add(4, below.x.data(), x); });
    watch.add(&CycleParts::boundary, solve_boundary);
    watch.add(&CycleParts::stencils, relax);
  }

 private:
  struct Vectors {
    std::vector<double> b, x, r;
  };
  const Cycle& cycle_;
  Cycle::Workspace workspace_;
  std::vector<Vectors> levels_;
  int sweeps_;
};

/// Ours: the two levels that have stencils, and below them all levels as one part.
class OurWalk {
 public:
  explicit OurWalk(const Multigrid& multigrid) : multigrid_(multigrid) {
    for (std::size_t l = 0; l <= multigrid.levels.size(); ++l) {
      const bool last = l == multigrid.levels.size();
      const int rows = last ? multigrid.coarsest.rows() : multigrid.levels[l]->layout.rows;
      levels_.push_back({LaneVector(rows, 4), LaneVector(rows, 4), LaneVector(rows, 4)});
    }
  }

  template <class Watch>
  void cycle(const float* b, float* x, Watch& watch) {
    std::memset(x, 0, sizeof(float) * 4 * std::size_t(multigrid_.rows()));
    descend(0, b, x, watch);
  }

 private:
  struct Vectors {
    LaneVector b, x, r;
  };

  /// x of a coarse level is set to 0 by who descends to it first.
  template <class Watch>
  void descend(std::size_t l, const float* b, float* x, Watch& watch) {
    if (l == multigrid_.levels.size())
      return watch.add(&CycleParts::coarse, [&] { multigrid_.coarsest.solve(4, b, x); });
    const MultigridLevel& here = *multigrid_.levels[l];
    const bool points = here.layout.runs.empty();
    const auto part = [&](double CycleParts::*of_grids) { return points ? &CycleParts::coarse : of_grids; };
    const int sweeps = multigrid_.options.sweeps, passes = multigrid_.passes_over_patches(l);
    const auto stencils = [&](Order order) {
      watch.add(part(&CycleParts::stencils), [&] { here.matrix.relax_stencils(4, b, x, sweeps, order); });
    };
    const auto patches = [&](Order order) {
      watch.add(part(&CycleParts::boundary), [&] {
        for (int i = 0; i < passes; ++i) here.patches.relax(here.matrix, 4, b, x, order);
      });
    };
    stencils(Order::forward);
    patches(Order::forward);
    Vectors& below = levels_[l + 1];
    watch.add(part(&CycleParts::transfers), [&] {
      float* r = levels_[l].r.data();
      here.matrix.residual(4, b, x, r);
      rescale(here.rescaled, 4, r, 1);
      here.transfer->restrict_to(4, r, below.b.data());
      std::memset(below.x.data(), 0, sizeof(float) * std::size_t(below.x.size()));
    });
    descend(l + 1, below.b.data(), below.x.data(), watch);
    if (int(l + 1) == multigrid_.options.twice_from && l + 1 < multigrid_.levels.size())
      descend(l + 1, below.b.data(), below.x.data(), watch);
    watch.add(part(&CycleParts::transfers), [&] {
      rescale(here.rescaled, 4, x, -1);
      here.transfer->prolongate_add(4, below.x.data(), x);
      rescale(here.rescaled, 4, x, 1);
    });
    patches(Order::backward);
    stencils(Order::backward);
  }

  const Multigrid& multigrid_;
  std::vector<Vectors> levels_;
};

/// Adds up what parts take.
class PartsWatch {
 public:
  explicit PartsWatch(bool wall) : wall_(wall) {}
  template <class Work>
  void add(double CycleParts::*part, const Work& work) {
    parts_.*part += seconds_of(wall_, work);
  }
  const CycleParts& parts() const { return parts_; }

 private:
  CycleParts parts_;
  bool wall_;
};

/// The cycle that took least of some, and the least that the solver's own took.
template <class Walk, class Cycle>
CycleParts least_parts(bool wall, const Walk& walk, const Cycle& cycle) {
  constexpr int rounds = 7;
  CycleParts least;
  double whole = std::numeric_limits<double>::infinity();
  for (int i = 0; i < rounds; ++i) {
    PartsWatch watch(wall);
    walk(watch);
    if (i == 0 || watch.parts().sum() < least.sum()) least = watch.parts();
    whole = std::min(whole, seconds_of(wall, cycle));
  }
  least.whole = whole;
  return least;
}

inline CycleParts reference_parts(const Case& c, const System& system, bool wall) {
  const ReferenceOptions options;
  const ReferenceCycle<double> cycle(system.A, c.space->texels(), options);
  ReferenceCycle<double>::Workspace workspace(cycle, 4, 3);
  ReferenceWalk walk(cycle, options.sweeps);
  Signal B = Signal::Zero(system.B.rows(), 4), X = B, Y = B;
  B.leftCols(3) = system.B;
  const CycleParts parts = least_parts(
      wall, [&](PartsWatch& watch) { walk.descend(0, B.data(), X.data(), watch); },
      [&] { cycle.cycle(B.data(), Y.data(), workspace); });
  require(X == Y, "the steps of the reference's cycle are not the cycle");
  return parts;
}

inline CycleParts our_parts(const Case& c, const System& system, bool wall) {
  const Hierarchy h = texel_hierarchy(system.A, c.space->texels());
  const int rows = h.rows();
  const double unit = 1 / system.B.cwiseAbs().maxCoeff();
  LaneVector b(rows, 4), x(rows, 4), y(rows, 4);
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < 3; ++k) b.data()[4 * i + k] = float(unit * system.B(i, k));
  Multigrid::Workspace workspace(h.multigrid(), 4);
  OurWalk walk(h.multigrid());
  const CycleParts parts = least_parts(
      wall, [&](PartsWatch& watch) { walk.cycle(b.data(), x.data(), watch); },
      [&] { h.multigrid().cycle(b.data(), y.data(), workspace); });
  require(std::memcmp(x.data(), y.data(), sizeof(float) * std::size_t(x.size())) == 0,
          "the steps of our cycle are not the cycle");
  return parts;
}

}  // namespace mq::bench
