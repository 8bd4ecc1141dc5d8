// Factorisations and conjugate gradients on the 9-point system of an n × n image, three channels:
// the kind of matrix a texture of that size gives. Times of the steps are counters, in seconds.
#include <vector>

#include <benchmark/benchmark.h>

#include "mq/linear/conjugate_gradients.h"
#include "mq/linear/direct.h"
#include "mq/linear/eigen.h"

namespace {

using namespace mq;

/// M + w·S of the bilinear functions on an n × n grid of spacing 1 (thesis 5.2.3).
SparseMatrix image_system(int n, double w) {
  Entries entries;
  entries.reserve(16 * std::size_t(n) * n);
  const double mass[3] = {4 / 36.0, 2 / 36.0, 1 / 36.0}, stiffness[3] = {4 / 6.0, -1 / 6.0, -2 / 6.0};
  for (int y = 0; y + 1 < n; ++y)
    for (int x = 0; x + 1 < n; ++x) {
      const int corner[4] = {y * n + x, y * n + x + 1, y * n + x + n, y * n + x + n + 1};
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
          const int apart = (a ^ b) == 0 ? 0 : (a ^ b) == 3 ? 2 : 1;
          entries.emplace_back(corner[a], corner[b], mass[apart] + w * stiffness[apart]);
        }
    }
  return sparse_matrix(n * n, n * n, entries);
}

Signal right_hand_side(int rows) {
  Signal B(rows, 3);
  for (int i = 0; i < rows; ++i) B.row(i) << i % 7 - 3, i % 11 - 5, i % 13 - 6;
  return B;
}

void direct(benchmark::State& state, Factorisation kind) {
  const SparseMatrix A = image_system(int(state.range(0)), 100);
  const Signal B = right_hand_side(int(A.rows()));
  for (auto _ : state) {
    const DirectSolver solver(A, kind);
    state.counters["analyse"] = solver.analyse_seconds();
    state.counters["factor"] = solver.factor_seconds();
    state.counters["factor_nonzeros"] = double(solver.factor_nonzeros());
    benchmark::DoNotOptimize(solver.solve(B).data());
  }
}

void conjugate(benchmark::State& state) {
  const SparseMatrix A = image_system(int(state.range(0)), 100);
  const Signal B = right_hand_side(int(A.rows()));
  const Preconditioner jacobi = jacobi_preconditioner(A);
  for (auto _ : state) {
    Signal X = Signal::Zero(B.rows(), B.cols());
    state.counters["cycles"] =
        conjugate_gradients(A, B, X, jacobi, {.tolerance = 1e-6}).cycles;
  }
}

void eigenpairs(benchmark::State& state) {
  const int n = int(state.range(0));
  const SparseMatrix M = image_system(n, 0), S = image_system(n, 1) - M;
  for (auto _ : state)
    benchmark::DoNotOptimize(smallest_eigenpairs(S, M, {.count = 30}).values.data());
}

}  // namespace

BENCHMARK_CAPTURE(direct, eigen, Factorisation::eigen)
    ->Arg(128)->Arg(256)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(direct, automatic, Factorisation::automatic)
    ->Arg(128)->Arg(256)->Arg(512)->Arg(816)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(conjugate)->Arg(256)->Arg(512)->Arg(816)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(eigenpairs)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_MAIN();
