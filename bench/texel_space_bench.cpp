// Assembly of the texel space, against the factorisation of its matrix and against a copy of the
// bytes that it writes, in one run. Surfaces are flat squares cut into charts turned by odd angles.
//
//     texel_space_bench --benchmark_counters_tabular=true

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cstring>
#include <vector>

#include "atlas/atlas_fixtures.h"
#include "mq/fem/texel_cells.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::unique_ptr<fixtures::Textured> square(int parts, int size) {
  fixtures::CutOptions options;
  options.parts = parts;
  options.cells = 60;
  options.scale = parts == 1 ? 0.9 : 0.68;
  options.angle = parts == 1 ? [](int) { return 0.0; } : fixtures::odd_angle;
  return fixtures::textured(fixtures::cut_square(options), {{size, size}});
}

/// Arguments: charts along a side, texture size, threads.
void assemble(benchmark::State& state) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(2)));
  const auto model = square(int(state.range(0)), int(state.range(1)));
  int texels = 0;
  std::int64_t held = 0, nonzeros = 0;
  double space_seconds = 0, system_seconds = 0;
  for (auto _ : state) {
    const double start = seconds();
    const TexelSpace space(model->surface, model->atlas);
    const double middle = seconds();
    const SparseMatrix M = space.mass(), S = space.stiffness();
    system_seconds += seconds() - middle;
    space_seconds += middle - start;
    benchmark::DoNotOptimize(M.valuePtr());
    benchmark::DoNotOptimize(S.valuePtr());
    texels = space.size();
    held = space.bytes();
    nonzeros = S.nonZeros();
  }
  const double runs = double(state.iterations());
  state.counters["texels"] = texels;
  state.counters["integrate_ns/texel"] = 1e9 * space_seconds / runs / texels;
  state.counters["M_and_S_ns/texel"] = 1e9 * system_seconds / runs / texels;
  // Held by the space, and by two matrices of 12 bytes an entry beside it.
  state.counters["space_B/texel"] = double(held) / texels;
  state.counters["peak_B/texel"] = double(held + 24 * nonzeros) / texels;
}
BENCHMARK(assemble)
    ->ArgNames({"side", "size", "threads"})
    ->Args({1, 1024, 1})
    ->Args({3, 1024, 1})
    ->Args({6, 1024, 1})
    ->Args({20, 1024, 1})
    ->Args({3, 512, 1})
    ->Args({3, 2048, 1})
    ->Args({3, 4096, 1})
    ->Args({3, 2048, 2})
    ->Unit(benchmark::kMillisecond);

/// How many times as long factoring M + w·S takes as assembling it, on the same model.
void factor_over_assembly(benchmark::State& state) {
  const auto model = square(int(state.range(0)), int(state.range(1)));
  for (auto _ : state) {
    const double start = seconds();
    const TexelSpace space(model->surface, model->atlas);
    const SparseMatrix A = space.system(1, 1e-3);
    const double assembled = seconds();
    const DirectSolver solver(A);
    const double factored = seconds();
    state.counters["ratio"] = (factored - assembled) / (assembled - start);
    state.counters["assembly_s"] = assembled - start;
    state.counters["factor_s"] = factored - assembled;
  }
}
BENCHMARK(factor_over_assembly)
    ->ArgNames({"side", "size"})
    ->Args({3, 1024})
    ->Args({20, 1024})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

/// One matrix gathered from the cells, over a copy of as many bytes.
void system_over_copy(benchmark::State& state) {
  const auto model = square(3, 2048);
  const TexelSpace space(model->surface, model->atlas);
  const SparseMatrix A = space.system(1, 1e-3);
  std::vector<char> from(12 * std::size_t(A.nonZeros()), 1), to(from.size());
  double system = 0, copy = 0;
  for (auto _ : state) {
    const double start = seconds();
    benchmark::DoNotOptimize(space.system(1, 1e-3).valuePtr());
    const double middle = seconds();
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::DoNotOptimize(to.data());
    system += middle - start;
    copy += seconds() - middle;
  }
  state.counters["ratio"] = system / copy;
}
BENCHMARK(system_over_copy)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
