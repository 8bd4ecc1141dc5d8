// image_noise_bench PICTURE...: what `denoise` leaves of Gaussian noise with its defaults, on the middle 320 x
// 320 pixels of each picture, as peak signal to noise ratio. Beside it fixed edges, of which the best is what
// measuring the noise could gain.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mq/fem/image_space.h"
#include "mq/filter/denoise.h"
#include "mq/io/image_file.h"

namespace {

using namespace mq;

Image<float> middle(const Image<float>& whole) {
  const int width = std::min(320, whole.width()), height = std::min(320, whole.height());
  const int left = (whole.width() - width) / 2, top = (whole.height() - height) / 2;
  Image<float> part(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        part(x, y, c) = whole(left + x, top + y, std::min(c, whole.channels() - 1));
  return part;
}

double decibels(const Signal& signal, const Signal& truth) {
  return -10 * std::log10((signal - truth).squaredNorm() / double(truth.size()));
}

void measure(const char* file) {
  const Image<float> picture = middle(read_texture(file).pixels);
  const ImageSpace space(picture.width(), picture.height());
  const Signal truth = space.gather({&picture, 1});
  fmt::print("{}\n", file);
  for (const double sigma : {0.02, 0.05, 0.1}) {
    std::mt19937 generator(7);
    std::normal_distribution<double> normal(0, sigma);
    Signal noisy = truth;
    for (Eigen::Index i = 0; i < noisy.size(); ++i) noisy.data()[i] += normal(generator);
    const double weight = usual_denoise_weight(space);
    const Denoised found = denoise(space, noisy, {}, {.weight = weight});
    fmt::print("  noise {:.2f}: {:.2f} dB; denoised {:.2f} dB, edge {:.4f}; with edges", sigma,
               decibels(noisy, truth), decibels(found.signal, truth), found.edge);
    for (const double edge : {0.005, 0.01, 0.02, 0.04, 0.1})
      fmt::print(" {:g}: {:.2f}", edge,
                 decibels(denoise(space, noisy, {}, {.weight = weight, .edge = edge}).signal, truth));
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) measure(argv[i]);
  return argc > 1 ? 0 : 2;
}
