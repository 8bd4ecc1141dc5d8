// One frame of tracking, and one step of the deformation graph, on bodies of several sizes.
#include <benchmark/benchmark.h>

#include "mq/sample/moving.h"
#include "mq/track/deformation_graph.h"
#include "mq/track/tracking.h"

namespace mq {
namespace {

Signal colours_of(const MovingFrame& frame) {
  Signal colours(frame.mesh.vertex_count(), 3);
  for (int v = 0; v < frame.mesh.vertex_count(); ++v) colours.row(v) = frame.colors[v].transpose();
  return colours;
}

void follow(benchmark::State& state, int colour_cycles) {
  const MovingOptions moving{.triangles = int(state.range(0))};
  const MovingFrame first = make_moving_frame("twisting", 0, moving);
  const MovingFrame second = make_moving_frame("twisting", 1, moving);
  TrackOptions options;
  options.colour_cycles = colour_cycles;
  SurfaceTracker tracker(first.mesh, colours_of(first), options);
  const TrackTarget target(second.mesh, colours_of(second));
  for (auto _ : state)
    benchmark::DoNotOptimize(tracker.follow(first.mesh.positions, {}, target).distance.p95);
  state.counters["nodes"] = tracker.node_count();
}

void by_shape(benchmark::State& state) { follow(state, 0); }
void by_colours(benchmark::State& state) { follow(state, 2); }

void graph_step(benchmark::State& state) {
  const Mesh mesh = make_moving_frame("twisting", 0, {.triangles = int(state.range(0))}).mesh;
  const Surface surface = make_surface(mesh);
  DeformationGraph graph(surface, 0.05 * std::sqrt(surface.area));
  std::vector<PointConstraint> pulls(mesh.positions.size());
  for (PointConstraint& pull : pulls)
    pull.add(Eigen::Matrix3d::Identity() / double(pulls.size()), Vector3(0.01, 0, 0));
  const std::vector<NodeMotion> still(std::size_t(graph.node_count()));
  for (auto _ : state) {
    std::vector<NodeMotion> motions = still;
    benchmark::DoNotOptimize(
        graph.gauss_newton_step(mesh.positions, pulls, mesh.positions, still, {1, 0.1}, motions));
  }
  state.counters["nodes"] = graph.node_count();
}

BENCHMARK(by_shape)->Arg(8000)->Arg(50000)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(by_colours)->Arg(8000)->Arg(50000)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(graph_step)->Arg(8000)->Arg(50000)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
