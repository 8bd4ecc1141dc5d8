/// The parts of a multigrid cycle beside a copy of memory, on one flat chart of n × n texels with
/// three channels. `bytes_per_second` counts what a part must touch at least; beside the triad's it
/// says how far the part is from the speed of memory.
///
///     multigrid_bench --benchmark_filter=/1800          3.2 million texels
///     MARQUETRY_THREADS=1 multigrid_bench               on one thread

#include <cstdlib>
#include <map>
#include <memory>
#include <optional>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "mq/base/parallel.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {
namespace {

/// M + w·S of bilinear functions on a flat square of n × n texels, w texels squared.
struct Flat {
  Texels texels;
  SparseMatrix A;
};

Flat make_flat(int n, double w) {
  Flat flat;
  flat.A.resize(n * n, n * n);
  flat.A.reserve(Eigen::VectorXi::Constant(n * n, 9));
  const auto mass = [&](int i, int j) {  // of hat functions on n points of a line
    return i != j ? 1.0 / 6 : i == 0 || i == n - 1 ? 1.0 / 3 : 2.0 / 3;
  };
  const auto stiffness = [&](int i, int j) {
    return i != j ? -1.0 : i == 0 || i == n - 1 ? 1.0 : 2.0;
  };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      flat.texels.places.push_back({0, x, y});
      flat.texels.positions.push_back({float(x), float(y), 0});
      for (int v = std::max(0, y - 1); v <= std::min(n - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(n - 1, x + 1); ++u)
          flat.A.insert(y * n + x, v * n + u) =
              mass(x, u) * mass(y, v) +
              w * (stiffness(x, u) * mass(y, v) + mass(x, u) * stiffness(y, v));
    }
  flat.A.makeCompressed();
  flat.texels.chart.assign(n * n, 0);
  flat.texels.interior.assign(n * n, 1);
  return flat;
}

struct Case {
  Flat flat;
  std::optional<Hierarchy> hierarchy;
  LaneVector b, x, r, coarse;
};

/// Built once per size, the last one kept.
Case& flat_case(int n) {
  static std::map<int, std::unique_ptr<Case>> cases;
  if (!cases.contains(n)) {
    cases.clear();
    auto c = std::make_unique<Case>();
    c->flat = make_flat(n, 100);
    c->hierarchy = texel_hierarchy(c->flat.A, c->flat.texels);
    for (LaneVector* v : {&c->b, &c->x, &c->r}) *v = LaneVector(n * n, 4);
    c->coarse = LaneVector(c->hierarchy->multigrid().levels[0]->transfer->coarse_rows(), 4);
    for (std::int64_t i = 0; i < c->b.size(); ++i) c->b.data()[i] = float(i % 17) - 8;
    cases[n] = std::move(c);
  }
  return *cases[n];
}

void report(benchmark::State& state, double bytes_per_texel) {
  const double texels = double(state.range(0)) * double(state.range(0));
  state.counters["ns_per_texel"] = benchmark::Counter(
      texels * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.SetBytesProcessed(std::int64_t(texels * bytes_per_texel * double(state.iterations())));
}

void Triad(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  float *b = c.b.data(), *x = c.x.data(), *r = c.r.data();
  for (auto _ : state)
    parallel_blocks(c.b.size(), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) r[i] = b[i] + 0.5f * x[i];
    });
  report(state, 48);
}

void Relax(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  const StencilMatrix& A = c.hierarchy->high();
  for (auto _ : state)
    A.relax_stencils(4, c.b.data(), c.x.data(), int(state.range(1)), Order::forward);
  report(state, 20 + 16 + 32);
}

void Residual(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  for (auto _ : state) c.hierarchy->high().residual(4, c.b.data(), c.x.data(), c.r.data());
  report(state, 20 + 16 + 16 + 16);
}

void Multiply(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(c.hierarchy->high().multiply(4, c.x.data(), c.b.data(), c.r.data()));
  report(state, 24 + 16 + 16 + 16);
}

void Restrict(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  const LevelTransfer& P = *c.hierarchy->multigrid().levels[0]->transfer;
  for (auto _ : state) P.restrict_to(4, c.r.data(), c.coarse.data());
  report(state, 16 + 4 + 4);
}

void Prolongate(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  const LevelTransfer& P = *c.hierarchy->multigrid().levels[0]->transfer;
  for (auto _ : state) P.prolongate_add(4, c.coarse.data(), c.x.data());
  report(state, 32 + 8 + 4);
}

void Cycle(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  Multigrid::Workspace workspace(c.hierarchy->multigrid(), 4);
  for (auto _ : state) c.hierarchy->multigrid().cycle(c.b.data(), c.x.data(), workspace);
  report(state, 157);
}

void Solve(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  const Hierarchy& h = *c.hierarchy;
  Signal B(c.flat.A.rows(), 3), X = B;
  for (Eigen::Index i = 0; i < B.size(); ++i) B.data()[i] = double(i * 7919 % 1013) / 1013;
  for (auto _ : state) {
    X.setZero();
    const SolveReport solved = mixed_conjugate_gradients(
        h.high(), h.low(), h.scaling(), h.multigrid(), h.components(), B, X, {.tolerance = 1e-6});
    state.counters["cycles"] = solved.cycles;
  }
  report(state, 0);
}

void SetUp(benchmark::State& state) {
  Case& c = flat_case(int(state.range(0)));
  for (auto _ : state) {
    const Hierarchy hierarchy = texel_hierarchy(c.flat.A, c.flat.texels);
    state.counters["bytes_per_texel"] = double(hierarchy.bytes()) / double(c.flat.texels.size());
  }
  report(state, 0);
}

void sizes(benchmark::internal::Benchmark* b) {
  for (const int n : {850, 1800}) b->Arg(n);
  b->Unit(benchmark::kMillisecond)->UseRealTime();
}
void sizes_and_sweeps(benchmark::internal::Benchmark* b) {
  for (const int n : {850, 1800})
    for (const int sweeps : {1, 2, 3}) b->Args({n, sweeps});
  b->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(Triad)->Apply(sizes);
BENCHMARK(Relax)->Apply(sizes_and_sweeps);
BENCHMARK(Residual)->Apply(sizes);
BENCHMARK(Multiply)->Apply(sizes);
BENCHMARK(Restrict)->Apply(sizes);
BENCHMARK(Prolongate)->Apply(sizes);
BENCHMARK(Cycle)->Apply(sizes);
BENCHMARK(Solve)->Apply(sizes);
BENCHMARK(SetUp)->Apply(sizes);

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  const char* threads = std::getenv("MARQUETRY_THREADS");
  std::unique_ptr<tbb::global_control> control;
  if (threads)
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    std::max(1, std::atoi(threads)));
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
