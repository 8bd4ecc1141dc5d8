// How long edges of different widths take, in one picture, by paths and by the explicit scheme.
//
//     shock_edges_bench             the table, as Markdown
//
// Four bands of 40 rows of 160 pixels, rounded to 8 bits, with an edge from 0.1 to 0.9 each:
// 0.5 + 0.4 tanh(d/s), d from the edge in pixels, s as the columns say. What is given is the
// largest difference between pixels two apart as a share of the edge, 100 being one that is a pixel wide;
// smoothing is over 0.3 % of the side of the picture.

#include <fmt/format.h>
#include "mq/baseline/osher_rudin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/stopwatch.h"
#include "mq/filter/image_shock.h"

namespace mq {
namespace {

constexpr int side = 160, band = 40;
constexpr std::array<double, 4> widths = {1.5, 3, 6, 12};

Image<float> edges() {
  Image<float> image(side, side, 1);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double value = 0.5 + 0.4 * std::tanh((x - 80.3) / widths[std::size_t(y / band)]);
      image(x, y) = float(std::round(255 * value) / 255);
    }
  return image;
}

/// Of each band the steepest place of its middle row, per cent of 0.8.
std::string jumps(const Image<float>& image) {
  std::string row;
  for (int b = 0; b < 4; ++b) {
    float most = 0;
    for (int x = 2; x < side; ++x)
      most = std::max(most,
                      std::abs(image(x, band * b + band / 2) - image(x - 2, band * b + band / 2)));
    row += fmt::format(" {:.0f} |", 100 * most / 0.8);
  }
  return row;
}

void run() {
  const Image<float> image = edges();
  fmt::print(
      "| | time | s = 1.5 | 3 | 6 | 12 | steps | seconds |\n|---|---|---|---|---|---|---|---|\n");
  fmt::print("| before | |{} | |\n", jumps(image));
  const double weight = std::pow(0.003 * side, 2);
  for (const double tau : {1.0, 2.0, 12.0, 40.0, 400.0, 1e4, 1e6}) {
    const Stopwatch watch;
    const ShockedImage sharp =
        shock(image, {.weights = {weight, weight}, .time = {ShockTime::Unit::relative, tau}});
    fmt::print("| transport | {:g} |{} | {:.2f} |\n", tau, jumps(sharp.image), watch.seconds());
  }
  for (const double tau : {1.0, 12.0, 40.0, 1e6}) {
    const Stopwatch watch;
    const EvolvedImage sharp =
        osher_rudin(image, {.time = osher_rudin_time(image, {ShockTime::Unit::relative, tau}),
                            .least_change = 0.5 / 255});
    fmt::print("| osher-rudin | {:g} |{} {} | {:.1f} |\n", tau, jumps(sharp.image), sharp.steps,
               watch.seconds());
  }
}

}  // namespace
}  // namespace mq

int main() { mq::run(); }
