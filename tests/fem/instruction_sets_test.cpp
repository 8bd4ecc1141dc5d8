// Kernels exist in a form for each instruction set (base/kernel_forms.h): those with fused operations
// give equal bits, whatever the width of their registers.
#include "mq/base/instruction_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "fem/patchwork.h"
#include "fem/solver_checks.h"
#include "mq/base/error.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/linear/boundary_rows.h"
#include "mq/linear/interior_relaxation.h"
#include "mq/linear/interpolation.h"

namespace mq {
namespace {

using fixtures::make_patchwork;
using fixtures::signal_noise;
using fixtures::Patchwork;
using fixtures::system_of;

/// Leaves the form in use as it was.
class WithEachSet : public testing::Test {
 protected:
  ~WithEachSet() override { use_instruction_set(at_first_); }

  static bool has(InstructionSet set) { return std::ranges::count(instruction_sets(), set) > 0; }

  /// compute() with the kernels of a set.
  template <class Compute>
  static auto with(InstructionSet set, const Compute& compute) {
    use_instruction_set(set);
    return compute();
  }

 private:
  InstructionSet at_first_ = instruction_set();
};

using InstructionSets = WithEachSet;

Signal solved(const Patchwork& p, int channels, int cycles) {
  const SparseMatrix A = system_of(p, 100);
  const Signal B = p.mass * signal_noise(A.rows(), channels);
  Signal X = Signal::Zero(A.rows(), channels);
  multigrid_solver(p.texels, {.tolerance = 1e-9, .max_cycles = cycles})(A, {})->solve(B, X);
  return X;
}

TEST_F(InstructionSets, OfAMachineBeginWithTheOneThatAllHave) {
  ASSERT_FALSE(instruction_sets().empty());
  EXPECT_EQ(instruction_sets().front(), InstructionSet::x86_64);
  EXPECT_EQ(instruction_set(), instruction_sets().back());
  for (const InstructionSet set : instruction_sets())
    EXPECT_EQ(parse_instruction_set(instruction_set_name(set)), set);
  EXPECT_THAT([] { parse_instruction_set("avx9"); },
              testing::ThrowsMessage<InvalidInput>(testing::HasSubstr("x86-64-v3")));
}

TEST_F(InstructionSets, WithFusedOperationsSolveToEqualBits) {
  if (!has(InstructionSet::x86_64_v4)) GTEST_SKIP() << "this machine has no AVX-512";
  // Few cycles: a solver that had converged would hide a difference.
  for (const double stretch : {1.0, 5.0})
    for (const int channels : {1, 2, 3, 4, 5}) {
      const Patchwork p = make_patchwork({.size = 150, .charts = 3, .stretch = stretch});
      const auto solve = [&] { return solved(p, channels, 3); };
      const Signal v3 = with(InstructionSet::x86_64_v3, solve);
      const Signal v4 = with(InstructionSet::x86_64_v4, solve);
      EXPECT_TRUE(v3 == v4) << channels << " channels, stretch " << stretch;
    }
}

TEST_F(InstructionSets, SolveToTheSameWithinTheTolerance) {
  const Patchwork p = make_patchwork({.size = 150, .charts = 3});
  const auto solve = [&] { return solved(p, 3, 60); };
  const Signal plain = with(InstructionSet::x86_64, solve);
  for (const InstructionSet set : instruction_sets()) {
    const Signal X = with(set, solve);
    EXPECT_LT((X - plain).norm(), 1e-7 * plain.norm()) << instruction_set_name(set);
    // Were they equal, the forms would not be what they are called.
    EXPECT_EQ(X == plain, set == InstructionSet::x86_64) << instruction_set_name(set);
  }
}

TEST_F(InstructionSets, GiveTheSameBitsForAnyNumberOfThreads) {
  const Patchwork p = make_patchwork({.size = 200, .charts = 3});
  for (const InstructionSet set : instruction_sets()) {
    use_instruction_set(set);
    Signal first;
    for (const int threads : {1, 2, 7}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      const Signal X = solved(p, 3, 5);
      if (first.size() == 0) first = X;
      EXPECT_TRUE(X == first) << instruction_set_name(set) << ", " << threads << " threads";
    }
  }
}

/// A grid of unknowns without seams, and one block of its interior.
struct Grid {
  int side = 64;
  SparseMatrix A;
  StencilBlocks blocks;

  Grid() {
    Entries entries;
    const auto in = [&](int i) { return i >= 0 && i < side; };
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            if (in(x + dx) && in(y + dy))
              entries.emplace_back(y * side + x, (y + dy) * side + x + dx,
                                   dx == 0 && dy == 0 ? 9.1 + 0.01 * ((7 * x * y) % 13) : -1.03);
    A = sparse_matrix(side * side, side * side, entries);
    blocks.rows.push_back(0);
    for (int y = 1; y + 1 < side; ++y) {
      const int k = y * side + 1;
      blocks.segments.push_back({k, side - 2, k - side, k + side});
      blocks.rows.push_back(int(blocks.segments.size()));
    }
    blocks.blocks = {0, side - 2};
    blocks.lines = {0, 1};
    blocks.even_lines = 1;
  }
};

template <class Real>
std::vector<Real> relaxed(const Grid& grid, int lanes) {
  InteriorRelaxation<Real> interior(grid.blocks);
  interior.set_values(grid.A);
  const Signal B = signal_noise(grid.A.rows(), lanes);
  std::vector<Real> b(B.data(), B.data() + B.size()), x(b.size()), r(b.size());
  interior.relax(lanes, b.data(), x.data(), 3);
  interior.residual(lanes, b.data(), x.data(), r.data());
  std::vector<int> rows;
  for (int k = 0; k < grid.A.rows(); k += 3) rows.push_back(k);
  BoundaryRows<Real> boundary(grid.A, rows);
  boundary.set_values(grid.A);
  boundary.residual(lanes, b.data(), x.data(), r.data());
  x.insert(x.end(), r.begin(), r.end());
  return x;
}

TEST_F(InstructionSets, WithFusedOperationsRelaxToEqualBits) {
  if (!has(InstructionSet::x86_64_v4)) GTEST_SKIP() << "this machine has no AVX-512";
  const Grid grid;
  for (const int lanes : {1, 4}) {
    const auto in_floats = [&] { return relaxed<float>(grid, lanes); };
    const auto in_doubles = [&] { return relaxed<double>(grid, lanes); };
    EXPECT_EQ(with(InstructionSet::x86_64_v3, in_floats), with(InstructionSet::x86_64_v4, in_floats));
    EXPECT_EQ(with(InstructionSet::x86_64_v3, in_doubles),
              with(InstructionSet::x86_64_v4, in_doubles));
    EXPECT_NE(with(InstructionSet::x86_64, in_doubles), with(InstructionSet::x86_64_v3, in_doubles));
  }
}

}  // namespace
}  // namespace mq
