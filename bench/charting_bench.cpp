// Charts in space and time of long sequences, and the whole atlas: a waving sheet, discs of which
// are replaced after every third frame.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "evolving/evolving_models.h"
#include "mq/evolving/lifespan_atlas.h"
#include "mq/evolving/lifespan_charts.h"
#include "mq/evolving/neighbour_graph.h"

namespace mq {
namespace {

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1e3;
}

/// Squares a side, frames.
void charts(benchmark::State& state) {
  const EvolvingMesh evolving = patched_sheet(int(state.range(0)), int(state.range(1)) / 3, 5);
  for (auto _ : state) {
    const NeighbourGraph graph = neighbour_graph(evolving);
    const LifespanCharts found = find_lifespan_charts(graph);
    state.counters["triangles"] = 2 * double(state.range(0) * state.range(0));
    state.counters["frames"] = double(evolving.frames.size());
    state.counters["chains"] = double(graph.chains.size());
    state.counters["first"] = found.first_charts;
    state.counters["charts"] = double(found.charts.size());
    state.counters["edits"] = double(found.edits);
  }
  state.counters["peak_MB"] = peak_megabytes();
}

/// The same, laid flat and packed into 2048 × 2048 texels.
void atlas(benchmark::State& state) {
  EvolvingMesh evolving = patched_sheet(int(state.range(0)), int(state.range(1)) / 3, 5);
  LifespanAtlasOptions options;
  options.unwrap.width = options.unwrap.height = 2048;
  for (auto _ : state) {
    const LifespanAtlas found = lay_out(evolving, options);
    state.counters["charts"] = double(found.charts.size());
    state.counters["charts_per_frame"] = found.charts_per_frame;
    state.counters["lifespan"] = found.lifespan;
    state.counters["occupancy"] = found.occupancy;
    for (const UnwrapFigures::Seconds& part : found.seconds)
      state.counters["s_" + part.step] = part.seconds;
  }
  state.counters["peak_MB"] = peak_megabytes();
}

BENCHMARK(charts)->Args({45, 90})->Args({141, 300})->Unit(benchmark::kSecond)->Iterations(1);
BENCHMARK(atlas)->Args({45, 90})->Args({141, 300})->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
