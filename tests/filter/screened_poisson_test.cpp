#include "mq/filter/screened_poisson.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fem/flat_torus.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/conjugate_gradients.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

using test::flat_torus;
using test::FlatTorus;
using test::random_signal;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double infinite = ScreenedPoisson::infinite_weight;

Surface sphere_beside_torus() {
  Mesh sphere = fixtures::sphere(3);
  for (Vector3& p : sphere.positions) p += Vector3(5, 0, 0);
  return make_surface(fixtures::beside(fixtures::torus(20, 12), sphere));
}

TEST(ScreenedPoisson, SolvesTheNormalEquations) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 3);
  for (const double beta : {0.0, 0.5, 3.0}) {
    const Signal phi = ScreenedPoisson(space, 0.02).solve(psi, beta).signal;
    const Signal error =
        space.system(1, 0.02) * phi - space.mass() * psi - 0.02 * beta * (space.stiffness() * psi);
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 1e-15) << "beta " << beta;
  }
}

TEST(ScreenedPoisson, ReturnsConstantsBitForBit) {
  const VertexSpace space(sphere_beside_torus());
  const Signal psi = Signal::Constant(space.size(), 2, 0.1);
  for (const double weight : {0.0, 1e-4, 1.0, infinite})
    EXPECT_TRUE(ScreenedPoisson(space, weight).solve(psi, 0).signal == psi) << "weight " << weight;
}

TEST(ScreenedPoisson, ReturnsTheInputBitForBitForBetaOne) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 3);
  const std::vector<double> ones(space.size(), 1.0);
  for (const double weight : {1e-4, 1.0, infinite}) {
    const ScreenedPoisson equation(space, weight);
    EXPECT_TRUE(equation.solve(psi, 1).signal == psi);
    EXPECT_TRUE(equation.solve(psi, ones).signal == psi);
  }
}

TEST(ScreenedPoisson, KeepsTheMeanOfEachComponent) {
  const Surface surface = sphere_beside_torus();
  const VertexSpace space(surface);
  const Signal psi = random_signal(space.size(), 3);
  const Vector mass = space.mass() * Vector::Ones(space.size());
  const int torus_size = 240;
  for (const double weight : {1e-4, 1.0, infinite}) {
    const Signal change = ScreenedPoisson(space, weight).solve(psi, 3).signal - psi;
    EXPECT_GT(change.cwiseAbs().maxCoeff(), 1e-3);
    for (const auto rows :
         {Eigen::seq(0, torus_size - 1), Eigen::seq(torus_size, space.size() - 1)})
      EXPECT_LE((mass(rows).transpose() * change(rows, Eigen::all)).cwiseAbs().maxCoeff(), 1e-12)
          << "weight " << weight;
  }
}

/// Wave of the flat torus with 64 vertices a period, eigenvalue 1.
TEST(ScreenedPoisson, ScalesEigenmodesByItsGain) {
  const FlatTorus torus = flat_torus(64);
  const VertexSpace space(torus.surface, torus.shapes);
  const Signal psi = torus.sample([](double x, double) { return std::cos(x); });
  const double area = space.scale().area;
  const double lambda = 1, discrete = (psi.transpose() * space.stiffness_times(psi))(0) /
                                      (psi.transpose() * (space.mass() * psi))(0);
  EXPECT_NEAR(discrete, lambda, 0.005);
  for (const double alpha : {1e-3, 1e-1, 10.0})
    for (const double beta : {0.0, 0.5, 3.0}) {
      const double w = alpha * area;
      const Signal phi = ScreenedPoisson(space, w).solve(psi, beta).signal;
      const auto gain = [&](double l) { return (1 + beta * w * l) / (1 + w * l); };
      EXPECT_LE((phi - gain(lambda) * psi).cwiseAbs().maxCoeff(),
                0.005 * std::max(gain(lambda), 0.1));
      EXPECT_LE((phi - gain(discrete) * psi).cwiseAbs().maxCoeff(), 1e-11);
    }
}

TEST(ScreenedPoisson, RepeatedInSmallStepsFollowsTheHeatEquation) {
  const FlatTorus torus = flat_torus(24, 0.2);
  const VertexSpace space(torus.surface, torus.shapes);
  const double time = 0.3;
  const auto diffuse = [&](int steps) {
    Signal phi =
        torus.sample([](double x, double y) { return std::exp(std::cos(x) + std::sin(2 * y)); });
    const ScreenedPoisson equation(space, time / steps);
    for (int i = 0; i < steps; ++i) phi = equation.solve(phi, 0).signal;
    return phi;
  };
  const Signal exact = (8 * diffuse(256) - 6 * diffuse(128) + diffuse(64)) / 3;  // extrapolated
  const double coarse = (diffuse(8) - exact).norm(), fine = (diffuse(16) - exact).norm();
  EXPECT_NEAR(std::log2(coarse / fine), 1, 0.1);
}

TEST(ScreenedPoisson, WithInfiniteWeightScalesDeviationsFromTheMean) {
  const VertexSpace space(sphere_beside_torus());
  const Signal psi = random_signal(space.size(), 2);
  const ScreenedPoisson equation(space, infinite);
  const Signal means = equation.solve(psi, 0).signal;
  EXPECT_LE(space.stiffness_times(means).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_GT((means.row(0) - means.row(space.size() - 1)).norm(), 1e-3);
  const Signal doubled = equation.solve(psi, 2).signal;
  EXPECT_LE((doubled - (2 * psi - means)).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(ScreenedPoisson, KeepsItsAccuracyWithInfiniteWeightOnFineMeshes) {
  const FlatTorus torus = flat_torus(640);
  const VertexSpace space(torus.surface, torus.shapes);
  const Signal psi = random_signal(space.size(), 1);
  const Filtered found = ScreenedPoisson(space, infinite, direct_solver()).solve(psi, 2);
  EXPECT_EQ(found.report.method.find("raised"), std::string::npos) << found.report.method;
  const double mean = psi.mean();  // all vertices have the same area
  EXPECT_LE((found.signal.array() - (2 * psi.array() - mean)).abs().maxCoeff(), 1e-7);
}

TEST(ScreenedPoisson, IsTheLimitOfLargeWeights) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 2);
  const Signal limit = ScreenedPoisson(space, infinite).solve(psi, 3).signal;
  for (const double weight : {1e7, 1e9, 1e11, 1e15, 1e300}) {
    const Signal large = ScreenedPoisson(space, weight).solve(psi, 3).signal;
    EXPECT_LE((limit - large).cwiseAbs().maxCoeff(), 1e-5) << weight;
  }
}

TEST(ScreenedPoisson, FindsTheSignalWhoseGradientItIsGiven) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal target = random_signal(space.size(), 2);
  const Signal moments = space.gradient_moments(space.gradient(target));
  const Signal found = ScreenedPoisson(space, infinite).solve_towards(target, moments).signal;
  EXPECT_LE((found - target).cwiseAbs().maxCoeff(), 1e-9);
  Signal start = target;
  start.array() += 1;
  start.topRows(10).array() += 1;
  const Signal rebuilt = ScreenedPoisson(space, infinite).solve_towards(start, moments).signal;
  const Signal change = rebuilt - target;
  EXPECT_LE((change.rowwise() - change.row(0)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(ScreenedPoisson, TakesAModulationPerVertex) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 2);
  const ScreenedPoisson equation(space, 0.02);
  const std::vector<double> threes(space.size(), 3.0);
  EXPECT_LE((equation.solve(psi, threes).signal - equation.solve(psi, 3).signal).norm(), 1e-12);

  std::vector<double> half(space.size(), 1.0);
  for (int i = 0; i < space.size() / 2; ++i) half[i] = 3;
  const Signal modulated = space.stiffness_times(psi, half);
  const Signal expected =
      DirectSolver(space.system(1, 0.02)).solve(space.mass() * psi + 0.02 * modulated);
  EXPECT_LE((equation.solve(psi, half).signal - expected).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(ScreenedPoisson, LeavesVerticesThatNoAreaReachesAlone) {
  Mesh mesh = fixtures::flat_square(6);
  const int lone = mesh.vertex_count();
  mesh.positions.insert(mesh.positions.end(), {{3, 0, 0}, {4, 0, 0}, {5, 0, 0}});
  mesh.triangles.push_back({lone, lone + 1, lone + 2});
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Surface surface = make_surface(mesh);
  const VertexSpace space(surface);
  ASSERT_EQ(space.size(), lone + 3);
  const Signal psi = random_signal(space.size(), 2);
  for (const double weight : {0.1, infinite}) {
    const Filtered filtered = ScreenedPoisson(space, weight).solve(psi, 0);
    EXPECT_TRUE(filtered.signal.bottomRows(3) == psi.bottomRows(3));
    EXPECT_THAT(filtered.report.method, Not(HasSubstr("raised")));
  }
}

TEST(ScreenedPoisson, KeepsWhatItCanWhenTheWeightChanges) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 2);
  ScreenedPoisson equation(space, 0.02);
  for (const double weight : {0.5, infinite, 1e-3}) {
    equation.set_weight(weight);
    EXPECT_TRUE(equation.solve(psi, 2).signal ==
                ScreenedPoisson(space, weight).solve(psi, 2).signal);
  }
}

TEST(ScreenedPoisson, AgreesForEverySolver) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 3);
  const Signal direct = ScreenedPoisson(space, 0.1).solve(psi, 3).signal;
  const auto iterative = conjugate_gradient_solver({.tolerance = 1e-12});
  const Filtered filtered = ScreenedPoisson(space, 0.1, iterative).solve(psi, 3);
  EXPECT_TRUE(filtered.report.converged);
  EXPECT_LE((filtered.signal - direct).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ScreenedPoisson, GivesEqualBitsForAnyNumberOfThreads) {
  const VertexSpace space(make_surface(fixtures::torus(150, 80)));
  const Signal psi = random_signal(space.size(), 3);
  const auto solve = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return ScreenedPoisson(VertexSpace(make_surface(fixtures::torus(150, 80))), 0.1)
        .solve(psi, 3)
        .signal;
  };
  const Signal one = solve(1);
  EXPECT_TRUE(one == solve(2));
  EXPECT_TRUE(one == solve(7));
}

TEST(ScreenedPoisson, RefusesWeightsAndValuesThatMeanNothing) {
  const VertexSpace space(make_surface(fixtures::torus(10, 8)));
  EXPECT_THROW(ScreenedPoisson(space, -1), InvalidInput);
  EXPECT_THROW(ScreenedPoisson(space, std::nan("")), InvalidInput);
  const ScreenedPoisson equation(space, 1);
  EXPECT_THROW(equation.solve(random_signal(79, 1), 0), InvalidInput);
  Signal psi = random_signal(80, 3);
  EXPECT_THROW(equation.solve(psi, infinite), InvalidInput);
  EXPECT_THROW(equation.solve(psi, std::vector<double>(3, 1.0)), InvalidInput);
  psi(41, 2) = std::nan("");
  EXPECT_THAT([&] { equation.solve(psi, 0); },
              ThrowsMessage<InvalidInput>(HasSubstr("nan at unknown 41, channel 2")));
}

/// Two unknowns whose M + w·S is (1, c; c, 1).
class TwoUnknowns final : public SignalSpace {
 public:
  explicit TwoUnknowns(double coupling) : coupling_(coupling) {}
  int size() const override { return 2; }
  SparseMatrix system(double, double, const Progress&) const override {
    SparseMatrix A = test::diagonal({1, 1});
    A.coeffRef(0, 1) = A.coeffRef(1, 0) = coupling_;
    A.makeCompressed();
    return A;
  }
  Signal stiffness_times(const Signal& psi, std::span<const double>) const override {
    return psi.rowwise() - psi.colwise().mean();
  }
  Signal edge_divergence(const std::vector<std::array<int, 2>>&, const Signal& z) const override {
    return 0 * z;
  }
  SurfaceScale scale() const override { return {}; }
  int element_count() const override { return 0; }
  std::vector<float> gradient_norms(const Signal&) const override { return {}; }
  Signal weighted_stiffness_times(const Signal& psi, std::span<const float>) const override {
    return 0 * psi;
  }
  SparseMatrix weighted_system(double a, double b, std::span<const float>,
                               const Progress& progress) const override {
    return system(a, b, progress);
  }
  std::vector<Vector3> positions() const override { return {{0, 0, 0}, {1, 0, 0}}; }
  std::vector<int> boundary() const override { return {}; }
  std::vector<BasisWeight> basis_at(int, const Vector3&) const override { return {}; }
  double largest_shown(const Vector& values) const override { return values.maxCoeff(); }
  void for_each_mixed_element(std::span<const int>,
                              const std::function<void(const Element&)>&) const override {}
  SolverFactory multigrid(const StoppingRule&) const override { return direct_solver(); }

 private:
  double coupling_;
};

TEST(ScreenedPoisson, RaisesTheDiagonalWhereRoundingMadeTheMatrixSingular) {
  for (const Factorisation kind : factorisations()) {
    const TwoUnknowns space(1 + 1e-11);
    const Filtered filtered =
        ScreenedPoisson(space, 1, direct_solver(kind)).solve(random_signal(2, 1), 0);
    EXPECT_THAT(filtered.report.method, HasSubstr("diagonal raised by 1e-10 of itself"));
  }
}

TEST(ScreenedPoisson, RefusesAMatrixThatIsTrulyIndefinite) {
  EXPECT_THROW(ScreenedPoisson(TwoUnknowns(1.001), 1), NotPositiveDefinite);
}

TEST(Smooth, IsIndependentOfTheUnitOfLength) {
  Mesh mesh = fixtures::torus(30, 20);
  const VertexSpace metres(make_surface(mesh));
  for (Vector3& p : mesh.positions) p *= 1000;
  const VertexSpace millimetres(make_surface(mesh));
  const Signal psi = random_signal(metres.size(), 2);
  const Length length{.value = 5, .unit = Length::Unit::percent};
  const Signal a = smooth(metres, psi, length).signal, b = smooth(millimetres, psi, length).signal;
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(Smooth, IsTheFilterWithBetaZero) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = random_signal(space.size(), 2);
  const Length length{.value = 0.2, .unit = Length::Unit::model};
  EXPECT_TRUE(smooth(space, psi, length).signal ==
              ScreenedPoisson(space, 0.2 * 0.2).solve(psi, 0).signal);
  EXPECT_TRUE(sharpen(space, psi, length, 4).signal ==
              ScreenedPoisson(space, 0.2 * 0.2).solve(psi, 4).signal);
}

}  // namespace
}  // namespace mq
