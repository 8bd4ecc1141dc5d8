// Figures for meshes: making a surface of one, curvatures, closest points. Tori as indexed meshes
// and as triangle soups, 0.1 to 10 million triangles.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "mq/base/random.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface.h"
#include "mq/sample/shapes.h"

namespace {

using namespace mq;

Mesh torus_of(std::int64_t triangles) {
  const int m = int(std::sqrt(double(triangles) / 4));
  return torus(2 * m, m, 0.45, TorusMap::arc_length).mesh;
}

Mesh soup_of(const Mesh& mesh) {
  Mesh soup = mesh;
  soup.positions.clear();
  for (Triangle& t : soup.triangles)
    for (int& corner : t) {
      soup.positions.push_back(mesh.positions[corner]);
      corner = soup.vertex_count() - 1;
    }
  return soup;
}

void report(benchmark::State& state, const Mesh& mesh) {
  state.counters["triangles"] = mesh.triangle_count();
  state.counters["triangles/s"] = benchmark::Counter(
      double(mesh.triangle_count()) * double(state.iterations()), benchmark::Counter::kIsRate);
}

void make_surface_indexed(benchmark::State& state) {
  const Mesh mesh = torus_of(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(make_surface(mesh));
  report(state, mesh);
}

void make_surface_soup(benchmark::State& state) {
  const Mesh mesh = soup_of(torus_of(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(make_surface(mesh));
  report(state, mesh);
}

void curvature(benchmark::State& state) {
  const Surface surface = make_surface(torus_of(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(vertex_curvatures(surface));
  report(state, surface.mesh);
}

void closest(benchmark::State& state) {
  const Mesh mesh = torus_of(state.range(0));
  const ClosestPointFinder find(mesh);
  const Random random(1);
  std::vector<Vector3> points;
  for (std::uint64_t i = 0; i < 100000; ++i)
    points.emplace_back(random.uniform(3 * i, -1.5, 1.5), random.uniform(3 * i + 1, -0.5, 0.5),
                        random.uniform(3 * i + 2, -1.5, 1.5));
  for (auto _ : state) benchmark::DoNotOptimize(find(points));
  state.counters["points/s"] = benchmark::Counter(
      double(points.size()) * double(state.iterations()), benchmark::Counter::kIsRate);
}

#define SIZES Unit(benchmark::kMillisecond)->UseRealTime()->Arg(100'000)->Arg(1'000'000)
BENCHMARK(make_surface_indexed)->SIZES->Arg(10'000'000);
BENCHMARK(make_surface_soup)->SIZES->Arg(10'000'000);
BENCHMARK(curvature)->SIZES;
BENCHMARK(closest)->SIZES;

}  // namespace

BENCHMARK_MAIN();
