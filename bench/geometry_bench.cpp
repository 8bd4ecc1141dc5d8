// Shapes of 0.9 million vertices: filtered, and fitted to normals.
#include <benchmark/benchmark.h>

#include "mq/fem/vertex_multigrid.h"
#include "mq/filter/geometry_filter.h"
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
  for (auto _ : state) benchmark::DoNotOptimize(vertex_normals(owl().mesh));
}
BENCHMARK(vertex_normals_of_owl)->Unit(benchmark::kMillisecond)->UseRealTime();

SolverFactory solver(bool multigrid) {
  return multigrid ? vertex_multigrid_solver(owl().mesh.positions, {.tolerance = 1e-8})
                   : direct_solver();
}

void prepare_fit(benchmark::State& state) {
  owl();
  for (auto _ : state)
    benchmark::DoNotOptimize(NormalFit(owl(), NormalFit::default_alpha, solver(state.range(0) != 0)));
}
BENCHMARK(prepare_fit)->Arg(0)->Arg(1)->ArgName("multigrid")->Unit(benchmark::kMillisecond)->UseRealTime();

void fit(benchmark::State& state) {
  const NormalFit equation(owl(), NormalFit::default_alpha, solver(state.range(0) != 0));
  const auto normals = triangle_means(owl().mesh, vertex_normals(owl().mesh));
  for (auto _ : state) {
    const Reshaped result = equation.fit(normals);
    state.counters["cycles"] = result.report.cycles;
    state.counters["residual"] = result.report.residuals.back();
    double largest = 0;
    for (const Vector3& p : result.positions) largest = std::max(largest, p.x());
    state.counters["x"] = largest;
  }
}
BENCHMARK(fit)->Arg(0)->Arg(1)->ArgName("multigrid")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
