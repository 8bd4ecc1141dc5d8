// Shapes of 0.9 million vertices: filtered, and fitted to normals.
#include <benchmark/benchmark.h>

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

void prepare_fit(benchmark::State& state) {
  owl();
  for (auto _ : state) benchmark::DoNotOptimize(NormalFit(owl()));
}
BENCHMARK(prepare_fit)->Unit(benchmark::kMillisecond)->UseRealTime();

void fit(benchmark::State& state) {
  const NormalFit equation(owl());
  const auto normals = triangle_means(owl().mesh, vertex_normals(owl().mesh));
  for (auto _ : state) benchmark::DoNotOptimize(equation.fit(normals));
}
BENCHMARK(fit)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
