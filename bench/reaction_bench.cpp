// A step of reaction and diffusion, against one pass over as many bytes in the same run.
//
//     reaction_bench --benchmark_counters_tabular=true

#include <benchmark/benchmark.h>

#include <chrono>
#include <vector>

#include "atlas/atlas_fixtures.h"
#include "mq/base/parallel.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/reaction_diffusion.h"

namespace mq {
namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Reads this many bytes once, on all threads.
double stream(const std::vector<float>& values) {
  const double start = seconds();
  const double sum = parallel_sum(std::ssize(values), 0.0, [&](auto begin, auto end) {
    float parts[16] = {};
    for (auto k = begin; k + 16 <= end; k += 16)
      for (int lane = 0; lane < 16; ++lane) parts[lane] += values[k + lane];
    double total = 0;
    for (const float part : parts) total += part;
    return total;
  });
  benchmark::DoNotOptimize(sum);
  return seconds() - start;
}

void react(benchmark::State& state) {
  fixtures::CutOptions options;
  options.parts = 6;
  options.cells = 24;
  options.scale = 0.65;
  options.angle = fixtures::odd_angle;
  const int side = int(state.range(0));
  const auto model = fixtures::textured(fixtures::cut_square(options), {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const double h = space.scale().texel_spacing;
  const ReactionDiffusion process(space, {0.2 * h * h, 0.1 * h * h});
  Substances substances(std::size_t(2 * space.size()), 0.5F);
  const std::vector<float> bytes(std::size_t(process.bytes_per_step() / 4), 1.0F);
  const Reaction reaction = gray_scott({});
  double stepping = 0, streaming = 0;
  for (auto _ : state) {
    const double start = seconds();
    process.run(reaction, 10, substances);
    stepping += (seconds() - start) / 10;
    streaming += stream(bytes);
  }
  const double runs = double(state.iterations());
  state.counters["texels"] = space.size();
  state.counters["ns/texel"] = 1e9 * stepping / runs / space.size();
  state.counters["of_a_stream"] = stepping / streaming;
}
BENCHMARK(react)->Arg(512)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
