// The hat-function space of a torus of n × n vertices: set-up, assembly, products and a filter, with
// the assembly also as a ratio to factoring the same matrix.
#include <chrono>
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>

#include "mq/fem/exterior.h"
#include "mq/fem/vector_basis.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct.h"

namespace {

using namespace mq;

Mesh torus(int n) {
  Mesh mesh;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / n;
      const double rho = 1 + 0.4 * std::cos(v);
      mesh.positions.emplace_back(rho * std::cos(u), rho * std::sin(u), 0.4 * std::sin(v));
    }
  const auto id = [&](int i, int j) { return (j % n) * n + i % n; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return mesh;
}

Signal wave(int rows) {
  Signal psi(rows, 3);
  for (int i = 0; i < rows; ++i) psi.row(i) << std::sin(0.01 * i), std::cos(0.3 * i), i % 5;
  return psi;
}

void prepare(benchmark::State& state) {
  const Surface surface = make_surface(torus(int(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(VertexSpace(surface).size());
  state.SetItemsProcessed(state.iterations() * surface.mesh.vertex_count());
}

void assemble(benchmark::State& state) {
  const VertexSpace space(make_surface(torus(int(state.range(0)))));
  for (auto _ : state) benchmark::DoNotOptimize(space.system(1, 1e-3).nonZeros());
  state.SetItemsProcessed(state.iterations() * space.size());
}

/// Counter `ratio`: assembly over analysis and factorisation.
void assemble_over_factor(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const VertexSpace space(make_surface(torus(int(state.range(0)))));
  for (auto _ : state) {
    const auto start = Clock::now();
    const SparseMatrix A = space.system(1, 1e-3);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const DirectSolver solver(A);
    state.counters["assemble"] = seconds;
    state.counters["analyse"] = solver.analyse_seconds();
    state.counters["factor"] = solver.factor_seconds();
    state.counters["ratio"] = seconds / (solver.analyse_seconds() + solver.factor_seconds());
  }
}

void stiffness_product(benchmark::State& state) {
  const VertexSpace space(make_surface(torus(int(state.range(0)))));
  const Signal psi = wave(space.size());
  for (auto _ : state) benchmark::DoNotOptimize(space.stiffness_times(psi).data());
  state.SetItemsProcessed(state.iterations() * space.size());
}

void filter_again(benchmark::State& state) {
  const VertexSpace space(make_surface(torus(int(state.range(0)))));
  const ScreenedPoisson equation(space, 1e-3);
  const Signal psi = wave(space.size());
  for (auto _ : state) benchmark::DoNotOptimize(equation.solve(psi, 3).signal.data());
  state.SetItemsProcessed(state.iterations() * space.size());
}

void whitney(benchmark::State& state) {
  const Surface surface = make_surface(torus(int(state.range(0))));
  const auto shapes = flat_triangles(surface);
  for (auto _ : state) {
    const Edges edges = make_edges(surface, shapes);
    const HodgeStars stars =
        hodge_stars(edges, surface.mesh.triangles, shapes, surface.mesh.vertex_count());
    benchmark::DoNotOptimize(whitney_mass(edges, shapes).nonZeros());
    benchmark::DoNotOptimize(hodge_laplacian(edges, stars, diagonal_matrix(stars.one)).nonZeros());
  }
  state.SetItemsProcessed(state.iterations() * surface.mesh.vertex_count());
}

}  // namespace

BENCHMARK(prepare)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(assemble)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(assemble_over_factor)->Arg(300)->Arg(600)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(stiffness_product)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(filter_again)->Arg(300)->Arg(600)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(whitney)->Arg(300)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_MAIN();
