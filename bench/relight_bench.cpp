// Filters in time on a body that bends and is renewed in part half-way, of which every texel's
// colour is known: what they leave of noise and of light that goes around, and how multigrid in
// space and time converges.
#include <benchmark/benchmark.h>
#include <malloc.h>
#include <sys/resource.h>

#include <cmath>
#include <numbers>

#include "mq/base/random.h"
#include "mq/evolving/lifespan_atlas.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/moving.h"
#include "mq/sample/paint.h"
#include "mq/video/flicker.h"
#include "mq/video/light_removal.h"
#include "mq/video/temporal_poisson.h"
#include "mq/video/texel_owners.h"

namespace mq {
namespace {

constexpr int frames = 46, texels_across = 256;
constexpr double noise = 0.05, light = 0.6;

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1e3;
}

/// The film: positions that the motion itself says, texture coordinates of one atlas.
struct Made {
  EvolvingMesh evolving;
  std::vector<std::vector<Vector3>> rest;  // per segment

  Made() {
    const Mesh mesh = make_moving_frame("bending", 0, {.triangles = 6000}).mesh;
    EvolvingSegment first = segment_of(mesh);
    first.uvs.clear();
    first.corner_uvs.clear();
    EvolvingSegment second = first;
    int next = first.triangle_count();
    for (int t = 0; t < second.triangle_count(); ++t)
      if (triangle_centre(mesh, t).y() > 0.4) second.triangle_ids[t] = next++;
    evolving.segments = {first, second};
    for (int f = 0; f < frames; ++f) {
      EvolvingFrame frame{f, f < frames / 2 ? 0 : 1, {}};
      for (const Vector3& p : mesh.positions)
        frame.positions.push_back(moved_material("bending", p, f, {}));
      evolving.frames.push_back(std::move(frame));
    }
    rest.assign(2, mesh.positions);
    LifespanAtlasOptions options;
    options.unwrap.width = options.unwrap.height = texels_across;
    options.unwrap.trials = 20;
    lay_out(evolving, options);
  }

  static Vector3 triangle_centre(const Mesh& mesh, int t) {
    return (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
  }
};

/// Colours of the texels at rest.
Signal albedo(const Texels& texels) {
  static const ColorField field = colorful(0.35, 1);
  Signal signal(texels.size(), 3);
  for (int t = 0; t < texels.size(); ++t) {
    const auto& p = texels.positions[t];
    signal.row(t) = field(Vector3(p[0], p[1], p[2]), 0).transpose();
  }
  return signal;
}

/// How brightly each texel is lit in a frame.
Vector brightness(const AtlasFrame& frame, int f) {
  const Mesh& mesh = frame.surface().mesh;
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const TexelOwners owners(mesh, texels_across, texels_across, 1, 3);
  const double angle = 2 * std::numbers::pi * f / light_period;
  const Vector3 from = Vector3(std::cos(angle), 0.4, std::sin(angle)).normalized();
  const Texels& texels = frame.space().texels();
  Vector result = Vector::Ones(texels.size());
  for (int t = 0; t < texels.size(); ++t) {
    const TexelOwners::Owner& owner = owners.owner(texels.places[t].x, texels.places[t].y);
    if (owner.triangle < 0) continue;
    const Vector3 b = nearest_in_triangle(owners.corners(owner.triangle),
                                          owners.place(texels.places[t].x, texels.places[t].y));
    Vector3 normal = Vector3::Zero();
    for (int k = 0; k < 3; ++k) normal += b[k] * normals[mesh.triangles[owner.triangle][k]];
    result[t] = 1 - light * 0.5 * (1 - normal.normalized().dot(from));
  }
  return result;
}

enum class Disturbed { by_noise, by_light };

/// Frames as they are wanted, and what they should be.
class Film {
 public:
  explicit Film(Disturbed disturbed) : disturbed_(disturbed) {
    static const Made made;
    made_ = &made;
  }

  TemporalFrame load(int f) {
    const EvolvingFrame& stored = made_->evolving.frames[f];
    const EvolvingSegment& segment = made_->evolving.segments[stored.segment];
    const auto atlas = atlas_of(f);
    const Texels& texels = atlas->space().texels();
    const AtlasFrame at_rest(segment, made_->rest[stored.segment], texels_across, texels_across);
    TemporalFrame frame{std::shared_ptr<const SignalSpace>(atlas, &atlas->space()),
                        std::make_shared<Texels>(texels),
                        albedo(at_rest.space().texels()),
                        {}};
    truth_[f] = frame.psi;
    if (disturbed_ == Disturbed::by_light) {
      frame.psi = brightness(*atlas, f).asDiagonal() * frame.psi;
    } else {
      const Random random(7, std::uint64_t(f));
      const double width = noise * std::sqrt(3.0);
      for (std::int64_t i = 0; i < frame.psi.size(); ++i)
        frame.psi.data()[i] += random.uniform(std::uint64_t(i), -width, width);
    }
    if (before_) frame.links = texel_links(*before_, *atlas);
    before_ = atlas;
    return frame;
  }

  void store(int f, const TemporalFrame& frame, const Signal& phi) {
    const Signal& truth = truth_.at(f);
    std::shared_ptr<const SignalSpace> space = frame.space;
    if (!space) {
      const auto atlas = atlas_of(f);
      space = {atlas, &atlas->space()};
    }
    add(frame, *space, truth, frame.psi, was_);
    add(frame, *space, truth, phi, is_);
    truth_.erase(f);
  }

  void count(const TemporalReport& report, benchmark::State& state) {
    const double flicker_was = was_.meter.finish().deviation,
                 flicker_is = is_.meter.finish().deviation;
    state.counters["flicker_before"] = flicker_was;
    state.counters["flicker"] = flicker_is;
    state.counters["sharpness"] = is_.gradients / is_.true_gradients;
    state.counters["error_before"] = was_.error();
    state.counters["error"] = is_.error();
    state.counters["cycles"] = report.solve.cycles;
    state.counters["factor"] = report.factor;
    state.counters["held"] = report.held;
    state.counters["set_up_s"] = report.solve.setup_seconds;
    state.counters["solve_s"] = report.solve.solve_seconds;
    state.counters["peak_MB"] = peak_megabytes();
  }

 private:
  struct Side {
    FlickerMeter meter;
    double gradients = 0, true_gradients = 0, product = 0, square = 0, truth = 0, values = 0;

    /// Up to one factor for all frames.
    double error() const { return std::sqrt((truth - product * product / square) / values); }
  };

  std::shared_ptr<AtlasFrame> atlas_of(int f) const {
    const EvolvingFrame& stored = made_->evolving.frames[f];
    return std::make_shared<AtlasFrame>(made_->evolving.segments[stored.segment], stored.positions,
                                        texels_across, texels_across);
  }

  static void add(const TemporalFrame& frame, const SignalSpace& space, const Signal& truth,
                  const Signal& signal, Side& side) {
    side.meter.add(frame.links, frame.texels->interior, signal);
    const Signal gradient = space.stiffness_times(truth);
    side.gradients += signal.cwiseProduct(gradient).sum();
    side.true_gradients += truth.cwiseProduct(gradient).sum();
    for (int t = 0; t < signal.rows(); ++t) {
      if (!frame.texels->interior[t]) continue;
      side.product += signal.row(t).dot(truth.row(t));
      side.square += signal.row(t).squaredNorm();
      side.truth += truth.row(t).squaredNorm();
      side.values += 3;
    }
  }

  Disturbed disturbed_;
  const Made* made_ = nullptr;
  std::map<int, Signal> truth_;
  std::shared_ptr<AtlasFrame> before_;
  Side was_, is_;
};

/// Weights of gradients in square model units, 4 · 10⁻⁶ times a number; the body's area is 3.91.
double weight_of(std::int64_t number) { return 4e-6 * double(number); }

/// Smoothing in space with the weight of the first, γ = the second.
void noise_filtered(benchmark::State& state) {
  for (auto _ : state) {
    Film film(Disturbed::by_noise);
    const TemporalReport report = temporal_poisson(
        frames, [&](int f, const Progress&) { return film.load(f); },
        [&](int f, const TemporalFrame& frame, const Signal& phi) { film.store(f, frame, phi); },
        {.weight = weight_of(state.range(0)),
         .beta = 0,
         .gamma = double(state.range(1)),
         .solver = {.tolerance = 1e-5}});
    film.count(report, state);
  }
}

/// Bytes in use, of all that was asked for.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return double(info.uordblks) + double(info.hblkhd);
}

/// Bytes a texel and frame of a window of 28 frames, while its first frame is handed out: of the
/// frames as they were loaded, and of all.
void window_memory(benchmark::State& state) {
  for (auto _ : state) {
    Film film(Disturbed::by_noise);
    const double before = allocated();
    double loaded = 0, all = 0, texels = 0;
    const TemporalReport report = temporal_poisson(
        28,
        [&](int f, const Progress&) {
          loaded = std::max(loaded, allocated() - before);
          TemporalFrame frame = film.load(f);
          texels += frame.psi.rows();
          return frame;
        },
        [&](int f, const TemporalFrame& frame, const Signal& phi) {
          if (f == 0) all = allocated() - before;
          film.store(f, frame, phi);
        },
        {.weight = 8e-6, .beta = 0, .gamma = 4, .window = 28, .solver = {.tolerance = 1e-5}});
    state.counters["loaded_B"] = loaded / (texels * 27 / 28);
    state.counters["all_B"] = all / texels;
    state.counters["peak_MB"] = peak_megabytes();
    state.counters["texels"] = texels;
    state.counters["held"] = report.held;
  }
}

/// Windows of a radius, the weight of the second, the crossover of the third (1: steep).
void light_removed(benchmark::State& state) {
  for (auto _ : state) {
    Film film(Disturbed::by_light);
    const TemporalReport report = remove_lighting(
        frames, [&](int f, const Progress&) { return film.load(f); },
        [&](int f, const TemporalFrame& frame, const Signal& phi) { film.store(f, frame, phi); },
        {.weight = weight_of(state.range(1)),
         .radius = int(state.range(0)),
         .crossover = LightRemovalOptions::Crossover(state.range(2))});
    film.count(report, state);
  }
}

/// By how much a cycle reduces the residual in the end, without acceleration; 1 level: no
/// coarsening in time.
void cycle_factor(benchmark::State& state) {
  Film film(Disturbed::by_noise);
  const double weight = weight_of(state.range(0)), gamma = double(state.range(1));
  std::vector<TemporalFrame> held;
  std::vector<TimePlane> planes;
  Vector before;
  for (int f = 0; f < 28; ++f) {
    held.push_back(film.load(f + 10));
    const TemporalFrame& frame = held.back();
    const Vector m = frame.space->lumped_mass().cwiseMax(1e-12);
    SparseMatrix K = frame.space->regularised_system(0, weight);
    K.diagonal() += m;
    planes.push_back({K, f > 0 ? frame.links : TimeLinks(), gamma * m});
  }
  for (auto _ : state) {
    const TimeMultigrid system(
        planes, texel_planes([&](int f) -> const Texels& { return *held[f].texels; }),
        {.most_levels = int(state.range(2))});
    const int n = int(system.matrix().rows());
    const Random random(3);
    Signal x(n, 1), z;
    for (int i = 0; i < n; ++i) x(i, 0) = random.uniform(i, -1, 1);
    double last = (system.matrix() * x).norm(), factor = 0;
    for (int i = 0; i < 12; ++i) {
      system.cycle(-(system.matrix() * x), z);
      x += z;
      const double now = (system.matrix() * x).norm();
      factor = now / last;
      last = now;
    }
    state.counters["factor"] = factor;
    state.counters["levels"] = system.level_count();
    state.counters["unknowns"] = n;
  }
}

BENCHMARK(noise_filtered)->Args({2, 0})->Args({2, 16})->Unit(benchmark::kSecond)->Iterations(1);
BENCHMARK(window_memory)->Unit(benchmark::kSecond)->Iterations(1);
BENCHMARK(light_removed)
    ->Args({10, 5, 0})
    ->Args({10, 200, 0})
    ->Args({20, 200, 0})
    ->Args({10, 781, 1})
    ->Args({20, 781, 1})
    ->Unit(benchmark::kSecond)
    ->Iterations(1);
BENCHMARK(cycle_factor)
    ->Args({5, 1, 30})
    ->Args({5, 16, 30})
    ->Args({5, 256, 30})
    ->Args({1000, 16, 30})
    ->Args({1000, 16, 1})
    ->Unit(benchmark::kSecond)
    ->Iterations(1);

}  // namespace
}  // namespace mq

BENCHMARK_MAIN();
