// Optical flow on images: what it finds of known motions, and how long it takes.
//
//   image_flow_bench --benchmark_filter=Translation    endpoint errors, pixels
//   image_flow_bench --benchmark_filter=Exposure       the same in other light
//   image_flow_bench --benchmark_filter=Megapixel      a pair of 1024 x 1024 pixels, three channels
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>

#include "flow/waves.h"
#include "mq/flow/image_flow.h"
#include "mq/flow/image_system.h"

namespace mq {
namespace {

using test::drawn;

/// A signal and the same moved by `shift` pixels; the error leaves a margin of as much.
void Translation(benchmark::State& state) {
  const int size = 512;
  const double shift = double(state.range(0)), u = 0.8 * shift, v = 0.6 * shift;
  const test::Waves waves(8, 192);
  const Image<float> source = drawn(size, size, [&](double x, double y) { return waves(x, y); });
  const Image<float> target =
      drawn(size, size, [&](double x, double y) { return waves(x - u, y - v); });
  ImageFlowOptions options;
  options.alignment =
      state.range(1) ? FlowAlignment::forward : FlowAlignment::halfway;
  options.scales =
      state.range(2) ? ImageFlowOptions::Scales::hierarchical : ImageFlowOptions::Scales::single;
  ImageFlow flow;
  for (auto _ : state) flow = image_flow(source, target, options);
  state.counters["endpoint_error"] =
      test::endpoint_error(forward_displacement(flow), int(shift) + 8, [&](double, double) {
        return std::array{u, v};
      });
  state.counters["error"] = flow.error.back() / flow.error.front();
}
BENCHMARK(Translation)
    ->ArgNames({"shift", "forward", "scales"})
    ->ArgsProduct({{1, 5, 10, 20, 40}, {0, 1}, {1, 0}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

/// The second has 0.6 of the contrast and is brighter by 0.2 (or not: `light` 0).
void Exposure(benchmark::State& state) {
  const int size = 512;
  const double u = 6, v = -3;
  const test::Waves waves(8, 192);
  const Image<float> source = drawn(size, size, [&](double x, double y) { return waves(x, y); });
  const bool other = state.range(0) == 1;
  const Image<float> target = drawn(size, size, [&](double x, double y) {
    return (other ? 0.6 : 1) * waves(x - u, y - v) + (other ? 0.2 : 0);
  });
  ImageFlowOptions options;
  options.light = std::array{ImageLight::kept, ImageLight::matched, ImageLight::doubted}[std::size_t(state.range(1))];
  options.gradient_weight = double(state.range(2));
  ImageFlow flow;
  for (auto _ : state) flow = image_flow(source, target, options);
  state.counters["endpoint_error"] =
      test::endpoint_error(forward_displacement(flow), 16, [&](double, double) {
        return std::array{u, v};
      });
}
BENCHMARK(Exposure)
    ->ArgNames({"light", "kept_matched_doubted", "gradients"})
    ->ArgsProduct({{0, 1}, {0, 1, 2}, {0, 5}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

void Megapixel(benchmark::State& state) {
  const test::Waves waves(6, 300, 1, 60);
  Image<float> source(1024, 1024, 3), target = source;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 1024; ++y)
      for (int x = 0; x < 1024; ++x) {
        source(x, y, c) = float(waves(x + 500 * c, y));
        target(x, y, c) = float(waves(x + 500 * c - 7 - 0.01 * y, y + 4));
      }
  for (auto _ : state) benchmark::DoNotOptimize(image_flow(source, target));
}
BENCHMARK(Megapixel)->Unit(benchmark::kSecond)->UseRealTime();

void Solve(benchmark::State& state) {
  const int size = int(state.range(0));
  ImageFlowSystem system(size, size);
  const test::Waves waves(8, 64);
  FlowPlanes b, Y;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const std::size_t k = std::size_t(y) * size + x;
      const double gx = waves(x, y), gy = waves(y + 31, x);
      system.d11[k] = float(gx * gx), system.d12[k] = float(gx * gy),
      system.d22[k] = float(gy * gy);
      if (x + 1 < size) system.east[k] = 4;
      if (y + 1 < size) system.south[k] = 4;
      b.u.push_back(float(gx));
      b.v.push_back(float(gy));
    }
  const ImageFlowSolver solver(system);
  SolveReport report;
  for (auto _ : state) report = solver.solve(b, Y, 1e-2, 40);
  state.counters["cycles"] = report.cycles;
}
BENCHMARK(Solve)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
