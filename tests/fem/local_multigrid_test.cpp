// Some rows of a multigrid: what the cycle on them solves, and what it costs.

#include "mq/linear/local_multigrid.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

/// Texels of a square in four charts, a weight of a few texels, and the levels of their system.
struct System {
  fixtures::Cut cut;
  TexelSpace space;
  SparseMatrix A;
  Hierarchy hierarchy;

  explicit System(int side = 160, double texels = 3)
      : cut(fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {side, side})),
        space(cut.model->surface, cut.model->atlas),
        A(space.regularised_system(1, std::pow(texels * space.scale().texel_spacing, 2))),
        hierarchy(texel_hierarchy(A, space.texels())) {}

  /// Texels within `radius` texel spacings of the square's middle, where its charts meet.
  RowSet middle(double radius) const {
    RowSet rows(space.size());
    for (int k = 0; k < space.size(); ++k) {
      const auto& p = space.texels().positions[k];
      if (std::hypot(p[0] - 0.5, p[1] - 0.5) < radius * space.scale().texel_spacing) rows.add(k);
    }
    return rows;
  }
};

/// b of one channel in the rows chosen, and the solution as a column of all rows.
Vector solve(const System& s, LocalMultigrid& local, const Vector& b, double error,
             LocalSolve* report = nullptr) {
  const Scaling& scaling = s.hierarchy.scaling();
  for (const int i : local.rows())
    local.right_hand_side()[i] = float(scaling.common * scaling.row(i) * b[i]);
  const LocalSolve solved = local.solve({.error = error, .max_cycles = 30});
  if (report) *report = solved;
  Vector x(b.size());
  for (int i = 0; i < x.size(); ++i) x[i] = scaling.row(i) * double(local.solution()[i]);
  return x;
}

/// The solution of A_NN·x = b_N.
Vector exact(const System& s, const std::vector<int>& rows, const Vector& b) {
  std::vector<int> local(std::size_t(s.A.rows()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) local[rows[i]] = int(i);
  std::vector<Eigen::Triplet<double>> entries;
  Signal B(Eigen::Index(rows.size()), 1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    B(Eigen::Index(i), 0) = b[rows[i]];
    for (SparseMatrix::InnerIterator e(s.A, rows[i]); e; ++e)
      if (local[e.col()] >= 0) entries.emplace_back(int(i), local[e.col()], e.value());
  }
  SparseMatrix A(B.rows(), B.rows());
  A.setFromTriplets(entries.begin(), entries.end());
  const Signal X = DirectSolver(A).solve(B);
  Vector x = Vector::Zero(b.size());
  for (std::size_t i = 0; i < rows.size(); ++i) x[rows[i]] = X(Eigen::Index(i), 0);
  return x;
}

Vector forces(const System& s) {
  return Vector(s.A.diagonal().cwiseProduct(Vector(test::random_signal(s.A.rows(), 1).col(0))));
}

TEST(LocalMultigrid, SolvesTheRowsItWasGivenAndNoOthers) {
  for (const double weight : {0.3, 3.0}) {
    const System s(160, weight);
    LocalMultigrid local(s.hierarchy.multigrid(), 1);
    const Vector b = forces(s);
    for (const double radius : {50.0, 6.0, 30.0, 1.5}) {  // in any order: nothing stays of the last
      local.choose(s.middle(radius));
      ASSERT_FALSE(local.rows().empty());
      ASSERT_LT(std::ssize(local.rows()), s.space.size());
      const Vector x = solve(s, local, b, 1e-4);
      const Vector wanted = exact(s, local.rows(), b);
      EXPECT_LT((x - wanted).cwiseAbs().maxCoeff(), 1e-3 * wanted.cwiseAbs().maxCoeff())
          << weight << ", " << radius;
      const RowSet inside = s.middle(radius);
      for (int k = 0; k < s.space.size(); ++k)
        if (!inside.has(k)) {
          ASSERT_EQ(x[k], 0) << k;
        }
    }
  }
}

/// As after a change in the middle, many lengths of the weight away from the border of N.
TEST(LocalMultigrid, SolvesWideForcesInFewCycles) {
  for (const double weight : {3.0, 10.0, 20.0}) {
    const System s(320, weight);
    LocalMultigrid local(s.hierarchy.multigrid(), 1);
    local.choose(s.middle(10 + 4 * weight));
    ASSERT_LT(std::ssize(local.rows()), s.space.size());
    Vector b = forces(s);
    const RowSet forced = s.middle(10);
    for (int k = 0; k < s.space.size(); ++k)
      if (!forced.has(k)) b[k] = 0;
    const Vector wanted = exact(s, local.rows(), b);
    const double largest = wanted.cwiseAbs().maxCoeff();
    LocalSolve report;
    const Vector x = solve(s, local, b, 1e-3 * largest, &report);
    EXPECT_LT((x - wanted).cwiseAbs().maxCoeff(), 3e-3 * largest) << weight;
    EXPECT_LE(report.cycles, 5) << weight;
  }
}

TEST(LocalMultigrid, OnAllRowsIsTheWholeSolve) {
  const System s(64, 10);
  LocalMultigrid local(s.hierarchy.multigrid(), 1);
  local.choose(s.middle(1e6));
  ASSERT_EQ(std::ssize(local.rows()), s.space.size());
  const Vector b = forces(s);
  const Vector wanted = DirectSolver(s.A).solve(Signal(b)).col(0);
  LocalSolve report;
  EXPECT_LT((solve(s, local, b, 1e-4, &report) - wanted).cwiseAbs().maxCoeff(),
            1e-3 * wanted.cwiseAbs().maxCoeff());
  EXPECT_LT(report.cycles, 15);
}

TEST(LocalMultigrid, ACycleBringsItNearer) {
  const System s;
  LocalMultigrid local(s.hierarchy.multigrid(), 1);
  local.choose(s.middle(25));
  const Vector b = forces(s), wanted = exact(s, local.rows(), b);
  double before = wanted.dot(s.A * wanted);
  for (int cycles = 1; cycles < 5; ++cycles) {
    for (const int i : local.rows())
      local.right_hand_side()[i] =
          float(s.hierarchy.scaling().common * s.hierarchy.scaling().row(i) * b[i]);
    local.solve({.error = 0, .max_cycles = cycles});
    Vector e = -wanted;
    for (const int i : local.rows())
      e[i] += s.hierarchy.scaling().row(i) * double(local.solution()[i]);
    const double now = e.dot(s.A * e);
    EXPECT_LT(now, 0.25 * before) << cycles;  // half the error
    before = now;
  }
}

TEST(LocalMultigrid, EstimatesItsError) {
  const System s;
  LocalMultigrid local(s.hierarchy.multigrid(), 1);
  local.choose(s.middle(25));
  const Vector b = forces(s), wanted = exact(s, local.rows(), b);
  for (const double error : {1e-1, 1e-2, 1e-3}) {
    LocalSolve report;
    const double left = (solve(s, local, b, error, &report) - wanted).cwiseAbs().maxCoeff();
    EXPECT_LE(report.error, error);
    EXPECT_LT(left, 2 * error);
  }
}

TEST(LocalMultigrid, SolvesEachChannelAsIfItWereAlone) {
  const System s;
  const Vector b = forces(s);
  LocalMultigrid alone(s.hierarchy.multigrid(), 1);
  alone.choose(s.middle(25));
  LocalSolve wanted;
  const Vector x = solve(s, alone, b, 1e-3, &wanted);
  const Scaling& scaling = s.hierarchy.scaling();
  for (const int lanes : {4, 8})
    for (const int forced : {0, 2, 3, 6}) {  // the others stay 0, and need no cycle
      if (forced >= lanes) continue;
      LocalMultigrid several(s.hierarchy.multigrid(), lanes);
      several.choose(s.middle(25));
      for (const int i : several.rows())
        several.right_hand_side()[std::size_t(i) * std::size_t(lanes) + std::size_t(forced)] =
            float(scaling.common * scaling.row(i) * b[i]);
      const LocalSolve report = several.solve({.error = 1e-3, .max_cycles = 30});
      EXPECT_EQ(report.cycles, wanted.cycles);
      EXPECT_NEAR(report.error, wanted.error, 0.01 * wanted.error);
      for (const int i : several.rows())
        for (int channel = 0; channel < lanes; ++channel)
          ASSERT_NEAR(scaling.row(i) * double(several.solution()[std::size_t(i * lanes + channel)]),
                      channel == forced ? x[i] : 0, 1e-5 * x.cwiseAbs().maxCoeff())
              << lanes << ", " << forced << ", " << channel;
    }
}

TEST(LocalMultigrid, EndsWhereItWasDoneEnough) {
  const System s;
  LocalMultigrid local(s.hierarchy.multigrid(), 1);
  local.choose(s.middle(25));
  const auto solved = [&](std::int64_t enough) {
    for (const int i : local.rows()) local.right_hand_side()[i] = 1;
    return local.solve({.error = 0, .max_cycles = 5, .enough = enough});
  };
  const std::int64_t of_a_cycle = solved(0).updates;
  EXPECT_EQ(solved(0).cycles, 1);
  EXPECT_EQ(solved(of_a_cycle).cycles, 1);
  EXPECT_EQ(solved(of_a_cycle + 1).cycles, 2);
  EXPECT_EQ(solved(5 * of_a_cycle).cycles, 5);
}

TEST(LocalMultigrid, CostsTheRowsThatItSolves) {
  const auto updates = [](const System& s, double radius) {
    LocalMultigrid local(s.hierarchy.multigrid(), 1);
    local.choose(s.middle(radius));
    for (const int i : local.rows()) local.right_hand_side()[i] = 1;
    return double(local.solve({.error = 0, .max_cycles = 1}).updates);
  };
  const System small(160), large(480);
  EXPECT_GT(large.space.size(), 8 * small.space.size());
  EXPECT_LT(updates(large, 20), 1.1 * updates(small, 20));
  EXPECT_NEAR(updates(large, 80) / updates(large, 20), 16, 4);
}

TEST(LocalMultigrid, IsTheSameForAnyNumberOfThreads) {
  const System s(480);
  const Signal b = test::random_signal(s.space.size(), 8);
  const Scaling& scaling = s.hierarchy.scaling();
  for (const int lanes : {1, 8}) {
    std::vector<std::vector<float>> found;
    for (const int threads : {1, 2, 7}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
      LocalMultigrid local(s.hierarchy.multigrid(), lanes);
      local.choose(s.middle(140));
      ASSERT_GT(std::ssize(local.rows()), 40000);  // fewer are left to one thread
      for (const int i : local.rows())
        for (int lane = 0; lane < lanes; ++lane)
          local.right_hand_side()[std::size_t(i * lanes + lane)] = float(scaling.common * scaling.row(i) * b(i, lane));
      local.solve({.error = 0, .max_cycles = 3});
      found.emplace_back(local.solution(), local.solution() + std::ptrdiff_t(s.space.size()) * lanes);
    }
    EXPECT_EQ(found[0], found[1]);
    EXPECT_EQ(found[0], found[2]);
  }
}

}  // namespace
}  // namespace mq
