/// A brush that changes the modulation of a texture while one looks on (`LiveModulation`), frame by frame:
/// how long a frame takes, and how far it is from the solution.
///
///     live_bench [MODEL [TEXELS [RADIUS]]]
///
/// MODEL is a sample; the brush, of RADIUS times √area, wanders over the surface and sharpens by 3.
/// Errors are of the texels' values, 0 … 1, in steps of 8 bits.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "mq/base/stopwatch.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/filter/live_modulation.h"
#include "mq/filter/screened_poisson.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

constexpr double alpha = 1e-4, strength = 3;
constexpr int frames = 40;

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

void run(const std::string& name, double wanted_texels, double radius) {
  Surface surface;
  Atlas atlas;
  std::unique_ptr<TexelSpace> space;
  Sample sample;
  double size = 1024;
  for (int round = 0; round < 2; ++round) {
    sample = make_sample(name, {.texture_size = int(size)});
    surface = make_surface(sample.mesh);
    atlas = make_atlas(surface, {sample.texture});
    space = std::make_unique<TexelSpace>(surface, atlas);
    size *= std::sqrt(wanted_texels / space->size());
  }
  const Texels& texels = space->texels();
  const std::vector<Image<float>> pictures = {paint(sample)};
  const Signal psi = space->gather(pictures);
  const double unit = std::sqrt(space->scale().area), weight = alpha * unit * unit;
  LiveModulation live(*space, weight, psi);

  std::vector<double> seconds;
  double brushed = 0;
  int cycles = 0;
  const std::vector<int> places = path(texels, 0.3 * radius * unit);
  for (const int place : places) {
    std::vector<int> under;
    std::vector<double> beta;
    for (int k = 0; k < texels.size(); ++k) {
      const double d = distance(texels.positions[k], texels.positions[place]) / (radius * unit);
      if (d >= 1) continue;
      under.push_back(k);
      beta.push_back(std::max(live.beta()[k], 1 + (strength - 1) * std::pow(1 - d * d, 2)));
    }
    const Stopwatch watch;
    live.modulate(under, beta);
    cycles += live.follow().cycles;
    seconds.push_back(watch.seconds());
    brushed += double(under.size()) / frames;
  }
  const Signal moving = live.signal();
  live.follow();
  live.follow();
  const Filtered exact = ScreenedPoisson(*space, weight, multigrid_solver(texels)).solve(psi, live.beta());
  const Signal change = exact.signal - psi;
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  const auto in_steps = [](const Signal& difference) {
    return fmt::format("{:.3f} rms, {:.2f} at most",
                       255 * std::sqrt(difference.squaredNorm() / double(difference.size())),
                       255 * difference.cwiseAbs().maxCoeff());
  };
  fmt::print("{}: {} texels, {:.0f} under the brush\n", name, space->size(), brushed);
  fmt::print("  frames: median {:.1f} ms, 9 of 10 within {:.1f} ms, worst {:.1f} ms; {:.1f} cycles each\n",
             1e3 * sorted[frames / 2], 1e3 * sorted[frames * 9 / 10], 1e3 * sorted.back(),
             double(cycles) / frames);
  fmt::print("  in steps of 8 bits: change {}; error moving {}, two frames later {}\n", in_steps(change),
             in_steps(moving - exact.signal), in_steps(live.signal() - exact.signal));
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  mq::run(argc > 1 ? argv[1] : "bust", argc > 2 ? std::atof(argv[2]) : 740'000,
          argc > 3 ? std::atof(argv[3]) : 0.03);
}
