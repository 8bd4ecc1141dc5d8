// What the verbs of an atlas spend their time in: the change that stitching asks for, charts that
// overlap laid apart, the front of distances and the sweeps of heat, noise and contrast of lines, a
// whole denoising, values at seams; a plain filter to compare with. Each beside one pass of S over
// the same texels in the same run.
//
//     atlas_bench --benchmark_counters_tabular=true

#include <benchmark/benchmark.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "mq/atlas/separate_overlaps.h"
#include "mq/base/stopwatch.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/filter/denoise.h"
#include "mq/filter/fast_marching.h"
#include "mq/filter/geodesic.h"
#include "mq/filter/heat_sweeps.h"
#include "mq/filter/line_integral.h"
#include "mq/filter/screened_poisson.h"
#include "mq/filter/seam_values.h"
#include "mq/filter/stitch.h"

namespace mq {
namespace {

/// 36 charts turned by odd angles on a square, and a signal on them.
struct Ground {
  explicit Ground(int side, double scale = 0.6)
      : cut(fixtures::cut("", scaled(fixtures::turned(fixtures::odd_angle, 6), scale),
                          {side, side})),
        space(cut.model->surface, cut.model->atlas),
        places(fixtures::places_of(space)),
        stiffness(space.stiffness()),
        psi(solid_noise(places, 0.01).replicate(1, 3)) {}

  static fixtures::CutOptions scaled(fixtures::CutOptions options, double scale) {
    options.scale = scale;
    return options;
  }

  fixtures::Cut cut;
  TexelSpace space;
  std::vector<Vector3> places;
  SparseMatrix stiffness;
  Signal psi;

  double weight(double texels) const {
    const double length = texels * space.scale().texel_spacing;
    return length * length;
  }
};

/// Runs it as often as the benchmark likes, each time beside S·ψ.
void compare(benchmark::State& state, const Ground& ground, const auto& kernel) {
  double at_work = 0, passing = 0;
  for (auto _ : state) {
    const Stopwatch work;
    kernel();
    at_work += work.seconds();
    const Stopwatch pass;
    benchmark::DoNotOptimize(ground.space.stiffness_times(ground.psi));
    passing += pass.seconds();
  }
  const double texels = double(state.iterations()) * ground.space.size();
  state.counters["texels"] = ground.space.size();
  state.counters["ns/texel"] = 1e9 * at_work / texels;
  state.counters["passes_of_S"] = at_work / passing;
}

void stitch_change(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  compare(state, ground, [&] {
    benchmark::DoNotOptimize(stitch_regions(ground.space, ground.psi, ground.space.texels().chart));
  });
}

/// Charts so large in their slots that all overlap others.
void lay_charts_apart(benchmark::State& state) {
  const Ground ground(int(state.range(0)), 1);
  const fixtures::Textured& model = *ground.cut.model;
  compare(state, ground,
          [&] { benchmark::DoNotOptimize(separate_overlaps(model.surface, model.atlas)); });
}

void geodesic_front(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  compare(state, ground, [&] {
    benchmark::DoNotOptimize(fast_marching_distances(ground.stiffness, ground.places, {{0, 0.0}}));
  });
}

void geodesic_sweeps(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  SparseMatrix heat = ground.space.regularised_system(0, ground.weight(2));
  heat.diagonal() += ground.space.mass() * Vector::Ones(ground.space.size());
  const Vector guess =
      fast_marching_distances(heat, ground.places, {{0, 0.0}}) / -std::sqrt(ground.weight(2));
  int sweeps = 0;
  compare(state, ground, [&] {
    sweeps = sweep_heat(heat, {{0, 0.0}}, {.tolerance = 1e-3}, guess).sweeps;
  });
  state.counters["sweeps"] = sweeps;
}

void lic_noise(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  compare(state, ground,
          [&] { benchmark::DoNotOptimize(with_contrast(solid_noise(ground.places, 0.01))); });
}

/// With an edge that takes the first slight smoothing and one step; both by multigrid.
void denoise_step(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  const DenoiseOptions options{.weight = ground.weight(4), .edge = 0.1, .steps = 1};
  compare(state, ground, [&] {
    benchmark::DoNotOptimize(
        denoise(ground.space, ground.psi, {}, options, multigrid_solver(ground.space.texels())));
  });
}

/// The screened equation itself, for the same.
void filter_smooth(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  compare(state, ground, [&] {
    const ScreenedPoisson equation(ground.space, ground.weight(4),
                                   multigrid_solver(ground.space.texels()));
    benchmark::DoNotOptimize(equation.solve(ground.psi, 0));
  });
}

/// What `fill` and `seams` do before texels are spread: the smoothest change at seams.
void fill_seams(benchmark::State& state) {
  const Ground ground(int(state.range(0)));
  const fixtures::Textured& model = *ground.cut.model;
  const TexelSpace soft(model.surface, model.atlas, soft_seams(model.atlas));
  const std::vector<char> free = seam_texels(model.surface, model.atlas, soft);
  compare(state, ground, [&] {
    benchmark::DoNotOptimize(smooth_at_seams(soft, ground.psi, free, Smooth::change).signal);
  });
}

#define ATLAS_BENCHMARK(name) BENCHMARK(name)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond)
ATLAS_BENCHMARK(filter_smooth);
ATLAS_BENCHMARK(stitch_change);
ATLAS_BENCHMARK(lay_charts_apart);
ATLAS_BENCHMARK(geodesic_front);
ATLAS_BENCHMARK(geodesic_sweeps);
ATLAS_BENCHMARK(lic_noise);
ATLAS_BENCHMARK(denoise_step);
ATLAS_BENCHMARK(fill_seams);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
