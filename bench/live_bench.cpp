/// A brush that changes the modulation of a texture while one looks on (`LiveModulation`), touch by touch:
/// how long a touch takes, and how far what is shown right after it is from the solution.
///
///     live_bench [MODEL [TEXELS [RADIUS...]]]
///
/// MODEL is a sample; a brush of RADIUS times √area (0.01, 0.03 and 0.2 unless said) wanders over the
/// surface and sharpens touch by touch, up to 3, with halos limited as the viewer does it, so that two solutions are followed. Errors
/// are of the texels' values, 0 … 1, in steps of 8 bits. One in five touches is compared.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "mq/base/stopwatch.h"
#include "mq/fem/surface_ball.h"
#include "mq/filter/halo_limit.h"
#include "mq/filter/live_modulation.h"
#include "mq/mesh/closest_point.h"
#include "sample_space.h"

namespace mq {
namespace {

constexpr double alpha = 1e-4, strength = 3, per_touch = 0.5;
constexpr int frames = 30;
constexpr int frames_per_solution = 5;  // one in so many touches is compared with the solution

double distance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return std::sqrt(std::pow(a[0] - b[0], 2) + std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2));
}

/// Per frame where the brush is: along a great arc of the model's box, at the texel nearest.
std::vector<int> path(const Texels& texels, double step) {
  std::vector<int> places = {texels.size() / 3};
  for (int f = 1; f < frames; ++f) {
    std::array<float, 3> wanted = texels.positions[places.back()];
    wanted[f % 7 < 4 ? 0 : 1] += float(step);
    int nearest = 0;
    for (int k = 0; k < texels.size(); ++k)
      if (distance(texels.positions[k], wanted) < distance(texels.positions[nearest], wanted))
        nearest = k;
    places.push_back(nearest);
  }
  return places;
}

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

std::string summary(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return fmt::format("median {:.1f} ms, 9 of 10 within {:.1f} ms, worst {:.1f} ms", 1e3 * seconds[seconds.size() / 2],
                     1e3 * seconds[seconds.size() * 9 / 10], 1e3 * seconds.back());
}

/// Errors of texels, the largest of a texel's channels, in steps of 8 bits.
class Errors {
 public:
  void add(double error) { all_.push_back(float(255 * error)); }
  std::string summary() {
    if (all_.empty()) return "none";
    std::sort(all_.begin(), all_.end());
    return fmt::format("99 of 100 within {:.2f}, {:.2f} at most", all_[all_.size() * 99 / 100], all_.back());
  }

 private:
  std::vector<float> all_;
};

/// Seconds of each touch.
struct Times {
  std::vector<double> find, update, solve, all, processor;
};

/// What is shown of a solution: that for all of the modulation, and that for its part of texture.
struct Shown {
  const Signal& psi;
  const HaloLimit& limit;

  double operator()(const Signal& solved, int texel, int channel) const {
    const double was = psi(texel, channel);
    return limit.sharpened(texel, channel, was, solved(texel, channel) - was,
                           solved(texel, psi.cols() + channel) - was);
  }
};

void run(const SampleSpace& model, const std::string& name, double radius) {
  const TexelSpace& space = *model.space;
  const Texels& texels = space.texels();
  const std::vector<Image<float>> pictures = {paint(model.sample)};
  const Signal psi = space.gather(pictures);
  const double unit = std::sqrt(space.scale().area), weight = alpha * unit * unit;
  const HaloLimit limit(space, psi);
  LiveOptions options;
  options.texture.assign(limit.texture().begin(), limit.texture().end());
  LiveModulation live(space, weight, psi, options), solution(space, weight, psi, options);
  SurfaceBall ball(space);
  const ClosestPointFinder closest(model.surface.mesh);
  const Shown shown{psi, limit};

  Times times;
  Errors under_brush, elsewhere;
  double brushed = 0, followed = 0, largest = 0;
  int cycles = 0, touches = 0;
  std::vector<char> is_under(std::size_t(texels.size()), 0);
  const auto compare = [&](Errors& under, Errors& others) {
    for (int k = 0; k < texels.size(); ++k) {
      double error = 0, change = 0;
      for (int c = 0; c < psi.cols(); ++c) {
        const double wanted = shown(solution.signal(), k, c);
        error = std::max(error, std::abs(shown(live.signal(), k, c) - wanted));
        change = std::max(change, std::abs(wanted - psi(k, c)));
      }
      largest = std::max(largest, change);
      if (is_under[k])
        under.add(error);
      else if (std::max(change, error) > 0.5 / 255)
        others.add(error);
    }
  };
  for (const int place : path(texels, 0.3 * radius * unit)) {
    const double processor_before = processor_seconds();
    const Stopwatch watch;
    const Vector3 middle = texels.position(place);
    const ClosestPoint at = closest(middle);
    const std::vector<int> under = ball.reach(at.triangle, at.barycentric, middle, radius * unit);
    times.find.push_back(watch.seconds());
    std::vector<double> beta;
    for (const int k : under) {
      const double d = distance(texels.positions[k], texels.positions[place]) / (radius * unit);
      beta.push_back(std::min(strength, live.beta()[k] + per_touch * (strength - 1) * std::pow(1 - d * d, 2)));
    }
    const double before_update = watch.seconds();
    live.modulate(under, beta);
    const double before_solve = watch.seconds();
    cycles += live.follow({.enough = FollowOptions::for_a_picture}).cycles;
    times.update.push_back(before_solve - before_update);
    times.solve.push_back(watch.seconds() - before_solve);
    times.all.push_back(watch.seconds() - before_update + times.find.back());
    times.processor.push_back(processor_seconds() - processor_before);
    brushed += double(under.size()) / frames;
    followed += double(live.followed().size()) / frames;

    solution.modulate(under, beta);
    if (++touches % frames_per_solution != 0) continue;
    solution.settle({.tolerance = 1e-7});
    std::fill(is_under.begin(), is_under.end(), 0);
    for (const int k : under) is_under[k] = 1;
    compare(under_brush, elsewhere);
  }
  const Stopwatch watch;
  int rests = 0;
  while (live.follow({.enough = FollowOptions::for_a_picture}).unfinished > 0) ++rests;
  const double resting = watch.seconds();
  Errors under_at_rest, elsewhere_at_rest, settled;
  compare(under_at_rest, elsewhere_at_rest);
  live.settle({.tolerance = 1e-7, .least_cycles = 4});
  compare(settled, settled);
  fmt::print("{}: {} texels, a brush of {} √area: {:.0f} texels under it, solved for {:.0f}\n", name, space.size(),
             radius, brushed, followed);
  fmt::print("  find:   {}\n  update: {}\n  solve:  {}; {:.1f} cycles\n  all:    {}\n  processor time of all: {}\n",
             summary(times.find), summary(times.update), summary(times.solve), double(cycles) / frames,
             summary(times.all), summary(times.processor));
  fmt::print("  shown right after a touch, in steps of 8 bits of a change of up to {:.0f}:\n"
             "    under the brush: {}\n    elsewhere, where anything changed: {}\n",
             255 * largest, under_brush.summary(), elsewhere.summary());
  fmt::print("  at rest, {} times more, {:.1f} ms:\n    where it was last: {}\n    elsewhere: {}\n"
             "  settled: {}\n",
             rests + 1, 1e3 * resting, under_at_rest.summary(), elsewhere_at_rest.summary(), settled.summary());
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "bust";
  const auto model = mq::make_sample_space(name, argc > 2 ? std::atof(argv[2]) : 740'000);
  std::vector<double> radii = {0.01, 0.03, 0.2};
  if (argc > 3) radii.clear();
  for (int i = 3; i < argc; ++i) radii.push_back(std::atof(argv[i]));
  for (const double radius : radii) mq::run(*model, name, radius);
}
