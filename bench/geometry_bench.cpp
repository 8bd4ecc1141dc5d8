// Shapes of 0.9 million vertices: filtered, and fitted to normals.
#include <benchmark/benchmark.h>

#include "mq/fem/vertex_multigrid.h"
#include "mq/filter/geometry_filter.h"
#include "mq/filter/geometry_shock.h"
#include "mq/linear/direct_solver.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/implicit.h"
#include "mq/sample/owl.h"

namespace {

using namespace mq;

const Surface& owl() {
  static const Surface surface = [] {
    const ImplicitOptions options{
        .low = {-0.75, -1, -0.7}, .high = {0.75, 1.08, 0.7}, .triangles = 1'800'000};
    const Mesh mesh = mesh_of_solid(owl_solid, options);
    return make_surface(mesh);
  }();
  return surface;
}

void vertex_normals_of_owl(benchmark::State& state) {
  owl();
  for (auto _ : state) benchmark::DoNotOptimize(vertex_normals(owl().mesh));
}
BENCHMARK(vertex_normals_of_owl)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()
    ->UseRealTime();

SolverFactory solver(bool multigrid) {
  return multigrid ? vertex_multigrid_solver(owl().mesh.positions, {.tolerance = 1e-8})
                   : direct_solver();
}

/// All of `shock --geometry` but files, and its steps in seconds.
void sharpen(benchmark::State& state) {
  const bool multigrid = state.range(0) != 0;
  const GeometryShockOptions options{.time = {ShockTime::Unit::relative, double(state.range(1))}};
  owl();
  for (auto _ : state) {
    const SharpenedShape shape = sharpen_shape(owl(), options, solver(multigrid));
    state.counters["smooth"] = shape.seconds.smooth;
    state.counters["potential"] = shape.seconds.potential;
    state.counters["paths"] = shape.seconds.paths;
    state.counters["prepare_fit"] = shape.seconds.prepare_fit;
    state.counters["fit"] = shape.seconds.fit;
    state.counters["solver"] = shape.seconds.solver;
    state.counters["crossed"] = double(shape.counts.triangles);
    int cycles = 0;
    for (const SolveReport& report : shape.solves) cycles += report.cycles;
    state.counters["cycles"] = cycles;
  }
  state.counters["vertices"] = owl().mesh.vertex_count();
}
BENCHMARK(sharpen)
    ->ArgNames({"multigrid", "tau"})
    ->Args({1, 1})
    ->Args({1, 1'000'000})
    ->Args({0, 1})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// Positions alone, by the same equation.
void smooth(benchmark::State& state) {
  owl();
  const GeometryFilterOptions options{.weight = 1e-4 * owl().area, .beta = 0};
  for (auto _ : state)
    benchmark::DoNotOptimize(filter_positions(owl(), options, solver(state.range(0) != 0)));
}
BENCHMARK(smooth)
    ->ArgName("multigrid")
    ->Arg(1)
    ->Arg(0)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
