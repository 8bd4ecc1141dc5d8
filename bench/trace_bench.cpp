// Paths on a mesh: triangles crossed per second, with the file's triangles in order and in random
// order.
//
//     trace_bench --benchmark_counters_tabular=true

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "atlas/atlas_fixtures.h"
#include "fixtures.h"
#include "mq/trace/atlas_flow.h"
#include "mq/trace/grid_flow.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

enum Order { in_order = 0, at_random = 1 };

/// The mesh with vertices and triangles in another order, of no system.
Mesh shuffled(const Mesh& mesh) {
  const auto order = [](int count, std::uint64_t seed) {
    std::vector<int> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), 0);
    const Random random(seed);
    std::ranges::sort(numbers, {}, [&](int i) { return random.bits(std::uint64_t(i)); });
    return numbers;
  };
  const std::vector<int> vertices = order(mesh.vertex_count(), 1),
                         triangles = order(mesh.triangle_count(), 2);
  std::vector<int> place(vertices.size());
  Mesh other;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    place[std::size_t(vertices[i])] = int(i);
    other.positions.push_back(mesh.positions[std::size_t(vertices[i])]);
  }
  for (const int t : triangles) {
    const Triangle& c = mesh.triangles[std::size_t(t)];
    other.triangles.push_back(
        {place[std::size_t(c[0])], place[std::size_t(c[1])], place[std::size_t(c[2])]});
  }
  return other;
}

/// A sphere of 2·4^levels + 2 vertices, 1 for each is at level 9.5: a torus of as many as are asked
/// for.
const Surface& surface_of(int thousands, Order order) {
  static std::map<std::pair<int, Order>, Surface> kept;
  auto& surface = kept[{thousands, order}];
  if (surface.mesh.positions.empty()) {
    const int across = int(std::sqrt(1000.0 * thousands / 2.5));
    const Mesh mesh = fixtures::torus(int(2.5 * across), across);
    surface = make_surface(order == in_order ? mesh : shuffled(mesh));
  }
  return surface;
}

/// Waves about a twentieth of the surface long, so that paths cross some twenty triangles and more.
double wave(const Vector3& p) {
  return std::sin(9 * p.x() + 2 * p.z()) * std::cos(8 * p.y()) + 0.3 * std::sin(21 * p.z());
}

Vector waves(const Surface& surface) {
  Vector P(surface.mesh.vertex_count());
  for (int v = 0; v < P.size(); ++v) P[v] = wave(surface.mesh.positions[std::size_t(v)]);
  return P;
}

void follow(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(3)));
  const Surface& surface = surface_of(int(state.range(0)), Order(state.range(1)));
  const TraceMesh mesh(surface);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, waves(surface));
  const Signal signal = Signal::Random(surface.mesh.vertex_count(), 3);
  const double time = 1e-3 * double(state.range(2));
  PathCounts counts;
  for (auto _ : state) counts = flow.advect(signal, time).counts;
  const double crossed = double(counts.triangles + counts.edges);
  state.counters["vertices"] = surface.mesh.vertex_count();
  state.counters["crossed"] = crossed / double(counts.paths);
  state.counters["M/s"] =
      benchmark::Counter(crossed * 1e-6 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(follow)
    ->ArgNames({"thousands", "random", "time", "threads"})
    ->ArgsProduct({{10, 100, 1000}, {in_order, at_random}, {3, 1'000'000'000}, {1}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(follow)
    ->ArgNames({"thousands", "random", "time", "threads"})
    ->ArgsProduct({{1000}, {in_order, at_random}, {1'000'000'000}, {2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// What has to be done once for a surface, and once for a potential.
void prepare(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  const Surface& surface = surface_of(1000, Order(state.range(0)));
  const Vector P = waves(surface);
  const bool once = state.range(1) == 0;
  const TraceMesh mesh(surface);
  for (auto _ : state) {
    if (once)
      benchmark::DoNotOptimize(TraceMesh(surface).triangle_count());
    else
      benchmark::DoNotOptimize(SurfaceFlow::downhill(mesh, P).leave(0, 0));
  }
}
BENCHMARK(prepare)
    ->ArgNames({"random", "potential"})
    ->ArgsProduct({{0, 1}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

/// From every pixel of an image, along waves as above.
void follow_image(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  const int side = int(state.range(0));
  std::vector<double> P;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double u = 20.0 * x / side, v = 20.0 * y / side;
      P.push_back(std::sin(u + 0.2 * v) * std::cos(v) + 0.3 * std::sin(2.3 * v + 0.1 * u));
    }
  const GridFlow flow = GridFlow::downhill(side, side, std::move(P));
  const double time = 1e-4 * double(state.range(1)) * side * side;
  PathCounts counts;
  for (auto _ : state) counts = flow.trace_pixels(time).counts;
  const double crossed = double(counts.triangles + counts.edges);
  state.counters["crossed"] = crossed / double(counts.paths);
  state.counters["M/s"] =
      benchmark::Counter(crossed * 1e-6 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(follow_image)
    ->ArgNames({"side", "time"})
    ->ArgsProduct({{256, 1024}, {3, 1'000'000'000}})
    ->Unit(benchmark::kMillisecond);

/// From every texel of a torus in charts turned by odd angles, along the same waves.
void follow_atlas(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  const int side = int(state.range(0)), parts = int(state.range(1));
  const auto model = fixtures::textured(
      fixtures::cut_torus({.cells = 24, .parts = parts, .scale = 0.65, .angle = fixtures::odd_angle}), {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const TraceAtlas domain(model->surface, model->atlas, space);
  Vector P(space.size());
  for (int i = 0; i < P.size(); ++i) P[i] = wave(space.texels().position(i));
  const AtlasFlow flow = AtlasFlow::downhill(domain, P);
  const std::vector<ChartPlace> starts = domain.starts().places;
  const double time = 1e-3 * double(state.range(2));
  PathCounts counts;
  for (auto _ : state) counts = flow.trace(starts, time).counts;
  const double crossed = double(counts.triangles + counts.edges);
  state.counters["texels"] = double(starts.size());
  state.counters["crossed"] = crossed / double(counts.paths);
  state.counters["M/s"] =
      benchmark::Counter(crossed * 1e-6 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(follow_atlas)
    ->ArgNames({"side", "parts", "time"})
    ->ArgsProduct({{512, 1024}, {1, 4}, {3, 1'000'000'000}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
