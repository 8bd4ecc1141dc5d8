// Multigrid for signals at vertices: it solves what a factorisation solves, at a rate that does not
// depend on the mesh's size.

#include "mq/fem/vertex_multigrid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "fixtures.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

struct Problem {
  Surface surface;
  VertexSpace space;
  explicit Problem(const Mesh& mesh) : surface(make_surface(mesh)), space(surface) {}
  const std::vector<Vector3>& places() const { return surface.mesh.positions; }
};

Signal noise(Eigen::Index rows, int channels) {
  const Random random(7);
  Signal values(rows, channels);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    values.data()[i] = random.uniform(std::uint64_t(i), -1, 1);
  return values;
}

double mean_rate(const SolveReport& report) {
  return std::pow(report.residuals.back(), 1.0 / report.cycles);
}

TEST(VertexMultigrid, SolvesWhatAFactorisationSolves) {
  for (const Mesh& mesh : {fixtures::torus(120, 60), fixtures::sphere(5),
                           fixtures::flat_square(60, 0.2)}) {
    const Problem p(mesh);
    for (const double w : {1e-5, 1e-2, 1.0})
      for (const int channels : {1, 3, 5}) {
        const SparseMatrix A = p.space.system(1, w);
        const Signal B = p.space.mass() * noise(A.rows(), channels);
        Signal X = Signal::Zero(A.rows(), channels);
        const SolveReport report =
            vertex_multigrid_solver(p.places(), {.tolerance = 1e-11})(A, {})->solve(B, X);
        EXPECT_TRUE(report.converged) << w;
        const Signal exact = DirectSolver(A).solve(B);
        EXPECT_LT((X - exact).norm(), 1e-8 * exact.norm()) << w;
      }
  }
}

TEST(VertexMultigrid, ConvergesAtARateThatDoesNotDependOnTheSize) {
  for (const int levels : {4, 6, 7}) {
    const Problem p(fixtures::sphere(levels));
    const SparseMatrix A = p.space.system(1, 100);
    const Signal B = p.space.mass() * noise(A.rows(), 3);
    Signal X = Signal::Zero(A.rows(), 3);
    const SolveReport report = vertex_multigrid_solver(p.places())(A, {})->solve(B, X);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(mean_rate(report), 0.3) << levels;
  }
}

TEST(VertexMultigrid, SolvesPureStiffnessOnEachComponent) {
  Mesh far = fixtures::torus(40, 20);
  for (Vector3& p : far.positions) p += Vector3(10, 0, 0);
  const Problem p(fixtures::beside(fixtures::sphere(4), far));
  const SparseMatrix A = p.space.stiffness();
  const Signal wanted = noise(A.rows(), 3), B = A * wanted;
  Signal X = Signal::Zero(A.rows(), 3);
  const SolveReport report =
      vertex_multigrid_solver(p.places(), {.tolerance = 1e-10})(A, {})->solve(B, X);
  EXPECT_TRUE(report.converged);
  EXPECT_LT((A * X - B).norm(), 1e-9 * B.norm());
}

TEST(VertexMultigrid, CopesWithUglyMeshes) {
  Mesh slivers = fixtures::flat_square(30);
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  slivers.triangles.push_back({0, 1, 2});
  slivers.triangles.push_back({6, 6, 7});
  // Vertices that only a triangle without area uses.
  const int n = slivers.vertex_count();
  for (int i = 0; i < 3; ++i) slivers.positions.emplace_back(i, 2, 0);
  slivers.triangles.push_back({n, n + 1, n + 2});
  Mesh thin = fixtures::flat_square(40);
  for (Vector3& q : thin.positions) q.y() *= 1e-3;
  for (const Mesh& mesh : {slivers, thin, fixtures::one_triangle(), fixtures::nonmanifold_edge(),
                           fixtures::moebius_strip(50)}) {
    const Problem p(mesh);
    const SparseMatrix A = p.space.system(1, 0.01);
    const Signal B = A * noise(A.rows(), 3);
    Signal X = Signal::Zero(A.rows(), 3);
    const SolveReport report = vertex_multigrid_solver(p.places())(A, {})->solve(B, X);
    EXPECT_TRUE(report.converged)
        << mesh.vertex_count() << " vertices: " << report.residuals.back() << " after "
        << report.cycles;
    EXPECT_TRUE(X.allFinite());
  }
}

TEST(VertexMultigrid, TakesTheValuesOfAnotherMatrix) {
  const Problem p(fixtures::torus(100, 50));
  const SparseMatrix first = p.space.system(1, 0.01), second = p.space.system(1, 3);
  const Signal B = p.space.mass() * noise(first.rows(), 2);
  const SolverFactory make = vertex_multigrid_solver(p.places());
  const auto updated = make(first, {});
  updated->update(second, {});
  Signal X = Signal::Zero(B.rows(), 2), Y = X;
  updated->solve(B, X);
  make(second, {})->solve(B, Y);
  EXPECT_LT((X - Y).norm(), 1e-5 * Y.norm());
  EXPECT_LT((second * X - B).norm(), 1e-5 * B.norm());
}

TEST(VertexMultigrid, GivesTheSameBitsForAnyNumberOfThreads) {
  const Problem p(fixtures::torus(150, 80));
  const SparseMatrix A = p.space.system(1, 0.1);
  const Signal B = p.space.mass() * noise(A.rows(), 3);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Signal X = Signal::Zero(A.rows(), 3);
    vertex_multigrid_solver(p.places())(A, {})->solve(B, X);
    return X;
  };
  const Signal one = with(1);
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(7));
}

TEST(VertexMultigrid, RefusesWhatDoesNotFitAndStops) {
  const Problem p(fixtures::torus(20, 10));
  const SparseMatrix A = p.space.system(1, 0.1);
  const SolverFactory make = vertex_multigrid_solver(p.places());
  EXPECT_THROW(make(SparseMatrix(3, 3), {}), InvalidInput);
  SparseMatrix bad = A;
  bad.coeffRef(40, 40) = std::nan("");
  EXPECT_THROW(make(bad, {}), InvalidInput);
  bad.coeffRef(40, 40) = -1;
  EXPECT_THROW(make(bad, {}), NotPositiveDefinite);
  const auto solver = make(A, {});
  Signal B = noise(A.rows(), 3), X = B, narrow = X.leftCols(2);
  EXPECT_THROW(solver->solve(B, narrow), InvalidInput);
  EXPECT_THROW(solver->update(SparseMatrix(A.rows(), A.rows()), {}), InvalidInput);
  B(5, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(solver->solve(B, X), SolverError);
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(solver->solve(noise(A.rows(), 3), X, Progress([](const ProgressEvent&) {}, &cancel)),
               Cancelled);
}

}  // namespace
}  // namespace mq
