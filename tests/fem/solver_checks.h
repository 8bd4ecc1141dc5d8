#pragma once
/// What every solver of texel systems must refuse, and when it must stop. `Make` is a function of
/// `Texels` that returns a `SolverFactory`.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "fem/patchwork.h"
#include "mq/base/error.h"
#include "mq/linear/solver.h"

namespace mq::fixtures {

template <class Make>
void expect_refusals(const Make& make_factory) {
  const Patchwork p = make_patchwork({.size = 20});
  const SparseMatrix A = system_of(p, 3);
  const SolverFactory make = make_factory(p.texels);
  const auto solver = make(A, {});
  Signal B = signal_noise(A.rows(), 3), X = B;

  SparseMatrix bad = A;
  bad.coeffRef(40, 40) = std::nan("");
  EXPECT_THROW(make(bad, {}), InvalidInput);
  bad.coeffRef(40, 40) = -1;
  EXPECT_THROW(make(bad, {}), NotPositiveDefinite);
  EXPECT_THROW(make(SparseMatrix(3, 3), {}), InvalidInput);
  EXPECT_THROW(solver->update(SparseMatrix(A.rows(), A.rows()), {}), InvalidInput);
  Signal narrow = X.leftCols(2);
  EXPECT_THROW(solver->solve(B, narrow), InvalidInput);
  B(5, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(solver->solve(B, X), SolverError);
  B(5, 1) = 0;
  X(7, 2) = std::nan("");
  EXPECT_THROW(solver->solve(B, X), SolverError);
}

template <class Make>
void expect_to_stop(const Make& make_factory) {
  const Patchwork p = make_patchwork({.size = 60});
  const SparseMatrix A = system_of(p, 50);
  const auto solver = make_factory(p.texels)(A, {});
  const Signal B = signal_noise(A.rows(), 1);
  Signal X = Signal::Zero(A.rows(), 1);
  const std::atomic<bool> cancel = true;
  const Progress progress([](const ProgressEvent&) {}, &cancel);
  EXPECT_THROW(solver->solve(B, X, progress), Cancelled);
}

}  // namespace mq::fixtures
