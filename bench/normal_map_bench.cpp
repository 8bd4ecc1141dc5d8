// How far a normal map that is filtered in tangent space is from its bake in object space filtered: the
// largest component of what is between the normals, in steps of 8 bits, over the texels inside charts.
//
//     normal_map_bench [MODEL MAP]
//
// Without a model: `sample bust` with a map of bumps, a tenth of a unit long.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/normal_maps.h"
#include "mq/atlas/coverage.h"
#include "mq/filter/screened_poisson.h"
#include "mq/model/normal_axes.h"

namespace {

using namespace mq;

/// "root mean square | median | 99th percentile | share above a step"
std::string steps_between(const Signal& a, const Signal& b, const std::vector<int>& rows) {
  std::vector<double> steps;
  double squares = 0;
  for (const int row : rows) {
    steps.push_back(255 * (a.row(row) - b.row(row)).cwiseAbs().maxCoeff() / 2);
    squares += steps.back() * steps.back();
  }
  std::ranges::sort(steps);
  const double count = double(steps.size());
  const auto above = std::ranges::count_if(steps, [](double s) { return s > 1; });
  return fmt::format("{:.2g} | {:.2g} | {:.2g} | {:.1f} %", std::sqrt(squares / count),
                     steps[steps.size() / 2], steps[steps.size() * 99 / 100],
                     100 * double(above) / count);
}

Signal unit(Signal normals) {
  normals.rowwise().normalize();
  return normals;
}

void compare(const TexturedModel& model) {
  Messages messages;
  TextureSignalOptions options = test::normals_in(NormalAxes::tangent);
  options.shared = TextureSignalOptions::SharedTexels::as_normals_need;
  const TextureSignal signal(model, options, messages);
  const std::vector<Coverage> coverage = texel_coverage(model.surface, *signal.texel_atlas());
  std::vector<int> inside;
  for (int i = 0; i < signal.space().size(); ++i) {
    const Texels::Place& at = signal.space().texels().places[std::size_t(i)];
    if (coverage[std::size_t(at.texture)].triangle(at.x, at.y) >= 0) inside.push_back(i);
  }
  const Signal d = signal.values().leftCols(3), N = signal.shading_normals();
  const Signal n = unit(N + d);
  fmt::print("{} texels, {}\n", inside.size(), signal.shading_frames()->source());
  fmt::print("| length | between | rms | median | 99 % | above 1 |\n|---|---|---|---|---|---|\n");
  for (const double texels : {1.0, 2.0, 3.0}) {
    const ScreenedPoisson equation(
        signal.space(),
        weight_from_length({texels, Length::Unit::texels}, signal.space().scale()));
    const auto smooth = [&](const Signal& values) { return equation.solve(values, 0).signal; };
    const Signal ours = unit(N + smooth(d)), of_n = smooth(n), of_N = smooth(N);
    const auto row = [&](const char* what, const Signal& a, const Signal& b) {
      fmt::print("| {} | {} | {} |\n", texels, what, steps_between(a, b, inside));
    };
    row("ours, F(n)", ours, unit(of_n));
    row("ours, F(n) − F(N) + N", ours, unit(of_n - of_N + N));
    row("F(N), N", unit(of_N), N);
    row("ours, n", ours, n);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) {
    Messages messages;
    compare(load_textured_model(argv[1], {.textures = {argv[2]}}, messages));
    return 0;
  }
  TexturedModel bust = test::flat_bust(1024, Depth::f32, 0);
  test::paint_bumps(bust, 0.1);
  compare(bust);
}
