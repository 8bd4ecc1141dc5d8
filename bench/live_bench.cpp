/// A brush that changes the modulation of a texture while one looks on (`LiveModulation`), touch by touch:
/// how long a touch takes, and how far what is shown right after it is from the solution.
///
///     live_bench [MODEL [TEXELS [RADIUS...]]]
///
/// MODEL is a sample; a brush of RADIUS times √area (0.01, 0.03 and 0.2 unless said) wanders over the
/// surface and sharpens by 3. Errors are of the texels' values, 0 … 1, in steps of 8 bits.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "mq/base/stopwatch.h"
#include "mq/filter/live_modulation.h"
#include "sample_space.h"

namespace mq {
namespace {

constexpr double alpha = 1e-4, strength = 3;
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

void run(const SampleSpace& model, const std::string& name, double radius) {
  const TexelSpace& space = *model.space;
  const Texels& texels = space.texels();
  const std::vector<Image<float>> pictures = {paint(model.sample)};
  const Signal psi = space.gather(pictures);
  const double unit = std::sqrt(space.scale().area), weight = alpha * unit * unit;
  LiveModulation live(space, weight, psi), solution(space, weight, psi);

  std::vector<double> update, solve, all, processor;
  Errors under_brush, elsewhere;
  double brushed = 0, followed = 0, largest = 0;
  int cycles = 0;
  std::vector<char> is_under(std::size_t(texels.size()), 0);
  for (const int place : path(texels, 0.3 * radius * unit)) {
    std::vector<int> under;
    std::vector<double> beta;
    for (int k = 0; k < texels.size(); ++k) {
      const double d = distance(texels.positions[k], texels.positions[place]) / (radius * unit);
      is_under[k] = d < 1;
      if (d >= 1) continue;
      under.push_back(k);
      beta.push_back(std::max(live.beta()[k], 1 + (strength - 1) * std::pow(1 - d * d, 2)));
    }
    const double processor_before = processor_seconds();
    const Stopwatch watch;
    live.modulate(under, beta);
    update.push_back(watch.seconds());
    cycles += live.follow().cycles;
    all.push_back(watch.seconds());
    solve.push_back(all.back() - update.back());
    processor.push_back(processor_seconds() - processor_before);
    brushed += double(under.size()) / frames;
    followed += double(live.followed().size()) / frames;

    solution.modulate(under, beta);
    if (all.size() % frames_per_solution != 0) continue;
    solution.settle({.tolerance = 1e-7});
    for (int k = 0; k < texels.size(); ++k) {
      const double error = (live.signal().row(k) - solution.signal().row(k)).cwiseAbs().maxCoeff();
      const double change = (solution.signal().row(k) - psi.row(k)).cwiseAbs().maxCoeff();
      largest = std::max(largest, change);
      if (is_under[k])
        under_brush.add(error);
      else if (std::max(change, error) > 0.5 / 255)
        elsewhere.add(error);
    }
  }
  fmt::print("{}: {} texels, a brush of {} √area: {:.0f} texels under it, solved for {:.0f}\n", name, space.size(),
             radius, brushed, followed);
  fmt::print("  update: {}\n  solve:  {}; {:.1f} cycles\n  both:   {}\n  processor time of both: {}\n", summary(update),
             summary(solve), double(cycles) / frames, summary(all), summary(processor));
  fmt::print("  shown right after a touch, in steps of 8 bits of a change of up to {:.0f}:\n"
             "    under the brush: {}\n    elsewhere, where anything changed: {}\n",
             255 * largest, under_brush.summary(), elsewhere.summary());
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
