#include "mq/flow/image_system.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/instruction_set.h"
#include "mq/base/random.h"

namespace mq::test {
namespace {

/// Gradients of one direction per pixel, none in a half of the image, and smoothness of strength
/// `stiffness`.
ImageFlowSystem patchy(int width, int height, double stiffness) {
  ImageFlowSystem system(width, height);
  const Random random(5);
  std::uint64_t drawn = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t k = std::size_t(y) * width + x;
      const double strength = 3 * x < 2 * width ? 2 * random.uniform(drawn++) : 0;
      const double angle = 6.3 * random.uniform(drawn++), c = std::cos(angle), s = std::sin(angle);
      system.d11[k] = float(strength * c * c + 1e-6);
      system.d12[k] = float(strength * c * s);
      system.d22[k] = float(strength * s * s + 1e-6);
      if (x + 1 < width) system.east[k] = float(stiffness);
      if (y + 1 < height) system.south[k] = float(stiffness);
    }
  return system;
}

FlowPlanes noise(std::size_t count) {
  const Random random(7);
  std::uint64_t drawn = 0;
  FlowPlanes b;
  for (std::size_t k = 0; k < count; ++k) {
    b.u.push_back(float(random.uniform(drawn++) - 0.5));
    b.v.push_back(float(random.uniform(drawn++) - 0.5));
  }
  return b;
}

double product(const FlowPlanes& a, const FlowPlanes& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.u.size(); ++k)
    sum += double(a.u[k]) * b.u[k] + double(a.v[k]) * b.v[k];
  return sum;
}

TEST(ImageFlowSolver, SolvesWithinAFewCyclesHoweverSmoothTheFieldShallBe) {
  for (const auto& [width, height] : {std::pair{200, 150}, std::pair{129, 65}, std::pair{1, 300}})
    for (const double stiffness : {1e-3, 1.0, 4.0, 400.0, 4e4}) {
      const ImageFlowSystem system = patchy(width, height, stiffness);
      const FlowPlanes b = noise(system.d11.size());
      const ImageFlowSolver solver(system);
      FlowPlanes Y;
      const SolveReport report = solver.solve(b, Y, 1e-4, 40);
      EXPECT_TRUE(report.converged) << width << ' ' << stiffness;
      EXPECT_LE(report.cycles, 12) << width << ' ' << stiffness;
      FlowPlanes left = solver.times(Y);
      for (std::size_t k = 0; k < b.u.size(); ++k) {
        left.u[k] -= b.u[k];
        left.v[k] -= b.v[k];
      }
      EXPECT_LT(product(left, left), 1e-6 * product(b, b)) << width << ' ' << stiffness;
    }
}

TEST(ImageFlowSolver, HasIteratesThatTakeOffAsMuchAsTheyCost) {
  const ImageFlowSystem system = patchy(100, 80, 4);
  const FlowPlanes b = noise(system.d11.size());
  const ImageFlowSolver solver(system);
  for (const int cycles : {1, 2, 5}) {
    FlowPlanes Y;
    solver.solve(b, Y, 0, cycles);
    EXPECT_NEAR(product(Y, solver.times(Y)) / product(Y, b), 1, 1e-4);
  }
}

TEST(ImageFlowSolver, IsSymmetric) {
  const ImageFlowSystem system = patchy(37, 50, 2);
  const ImageFlowSolver solver(system);
  const FlowPlanes a = noise(system.d11.size());
  FlowPlanes b = a;
  std::ranges::reverse(b.u);
  std::ranges::rotate(b.v, b.v.begin() + 77);
  EXPECT_NEAR(product(solver.times(a), b) / product(a, solver.times(b)), 1, 1e-5);
}

TEST(ImageFlowSolver, GivesTheSameBitsForAnyNumberOfThreadsAndTheOppositeForTheOpposite) {
  const ImageFlowSystem system = patchy(150, 211, 4);
  FlowPlanes b = noise(system.d11.size());
  std::vector<FlowPlanes> results;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const ImageFlowSolver solver(system);
    results.emplace_back();
    solver.solve(b, results.back(), 1e-5, 40);
  }
  EXPECT_EQ(results[1].u, results[0].u);
  EXPECT_EQ(results[2].v, results[0].v);
  for (float& value : b.u) value = -value;
  for (float& value : b.v) value = -value;
  FlowPlanes Y;
  ImageFlowSolver(system).solve(b, Y, 1e-5, 40);
  for (float& value : Y.u) value = -value;
  EXPECT_EQ(Y.u, results[0].u);
}

TEST(ImageFlowSolver, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(ImageFlowSolver(ImageFlowSystem(5, 5)), SolverError);
  const ImageFlowSolver solver(patchy(20, 20, 1));
  FlowPlanes b = noise(400), Y;
  b.u[7] = NAN;
  EXPECT_THROW(solver.solve(b, Y, 1e-3, 10), SolverError);
}

TEST(ImageFlowSolver, GivesEqualBitsInAllFormsWithFusedOperations) {
  const std::vector<InstructionSet> sets = instruction_sets();
  if (sets.back() != InstructionSet::x86_64_v4) GTEST_SKIP() << "this machine has no AVX-512";
  const ImageFlowSystem system = patchy(203, 151, 4);
  const FlowPlanes b = noise(system.d11.size());
  const auto solved = [&](InstructionSet set) {
    use_instruction_set(set);
    FlowPlanes Y;
    ImageFlowSolver(system).solve(b, Y, 1e-9, 3);
    return Y;
  };
  const FlowPlanes v3 = solved(InstructionSet::x86_64_v3), v4 = solved(InstructionSet::x86_64_v4);
  EXPECT_EQ(v3.u, v4.u);
  EXPECT_EQ(v3.v, v4.v);
}

}  // namespace
}  // namespace mq::test
