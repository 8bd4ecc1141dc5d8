#include "mq/filter/noise_curve.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "mq/filter/detail/noise_blocks.h"

namespace mq {

namespace {

constexpr std::size_t most_classes = 16, least_of_class = 256, least_flat_of_class = 16;

/// A class is flat where low frequencies, each, hold up to so much as high ones. Of noise alone the flattest
/// twentieth holds 0.55.
constexpr double most_low = 1.2;

/// Noise that was smoothed holds about as much in the first two diagonals as in the next two, where texture holds ever
/// less; it is the same nearly everywhere: without the first, a quarter of the blocks hold up to so much more than a
/// twentieth of them; and it holds more than high frequencies do.
constexpr double most_first = 2.0, most_uneven = 4.0, least_smoothed = 2.25;
constexpr int last_first = 2, last_second = 4;  ///< diagonals

/// A quarter of all blocks is flat then; less would be what JPEG has flattened.
constexpr double flattest_smoothed = 0.25;

/// No channel has less noise than this, of what the noisiest has.
constexpr double least_deviation = 1e-4;

/// The least brightness of each class but the first; classes hold as many blocks each.
std::vector<double> class_bounds(std::span<const NoiseBlock> blocks) {
  std::vector<double> brightness, bounds;
  for (const NoiseBlock& block : blocks) brightness.push_back(block.brightness);
  std::ranges::sort(brightness);
  const std::size_t count = std::min(most_classes, blocks.size() / least_of_class);
  for (std::size_t k = 1; k < count; ++k)
    if (const double bound = brightness[k * blocks.size() / count];
        bound > (bounds.empty() ? brightness.front() : bounds.back()))
      bounds.push_back(bound);
  return bounds;
}

/// Noise of one channel in each class. Noise that grows with brightness makes the flattest of a class the darkest, so
/// that their brightness counts.
struct ClassNoise {
  std::vector<double> brightness, variance;
  std::vector<char> is_noise;  ///< else texture, and noise has the variance at most
};

ClassNoise noise_of(const std::vector<double>& bounds, std::span<const NoiseBlock> blocks) {
  std::vector<std::vector<NoiseBlock>> parts(bounds.size() + 1);
  for (const NoiseBlock& block : blocks) {
    const auto part = std::ranges::upper_bound(bounds, block.brightness) - bounds.begin();
    parts[std::size_t(part)].push_back(block);
  }
  ClassNoise result;
  for (const std::vector<NoiseBlock>& part : parts) {
    const bool enough = part.size() >= least_flat_of_class;
    const Flattest found = enough ? flattest_part(part, flattest, least_flat_of_class) : Flattest{};
    result.brightness.push_back(found.brightness);
    result.variance.push_back(enough ? found.high : std::numeric_limits<double>::infinity());
    result.is_noise.push_back(enough && found.low <= most_low * found.high);
  }
  return result;
}

/// Linear between values of x, which rise; beyond them those of the ends.
double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::size_t(std::ranges::upper_bound(x, at) - x.begin());
  if (above == 0) return y.front();
  if (above == x.size()) return y.back();
  const double share = (at - x[above - 1]) / (x[above] - x[above - 1]);
  return (1 - share) * y[above - 1] + share * y[above];
}

/// Texture takes what classes beside it say, and neighbours get their geometric mean; all are the same where all is
/// texture.
std::vector<double> smooth_variance(const std::vector<double>& brightness, const ClassNoise& noise, double of_all) {
  std::vector<double> x, y;
  for (std::size_t k = 0; k < noise.variance.size(); ++k)
    if (noise.is_noise[k]) x.push_back(brightness[k]), y.push_back(noise.variance[k]);
  if (x.empty()) return std::vector<double>(noise.variance.size(), of_all);
  std::vector<double> full = noise.variance;
  for (std::size_t k = 0; k < full.size(); ++k)
    if (!noise.is_noise[k]) full[k] = std::min(full[k], interpolated(x, y, brightness[k]));
  std::vector<double> result = full;
  for (std::size_t k = 1; k + 1 < full.size(); ++k) result[k] = (full[k - 1] + 2 * full[k] + full[k + 1]) / 4;
  return result;
}

bool is_smoothed(std::span<const NoiseBlock> blocks) {
  if (blocks.size() < least_of_class) return false;
  std::vector<double> energies;
  for (const NoiseBlock& block : blocks) {
    double first = 0;
    for (int i = 0; i <= last_first; ++i)
      for (int j = 0; i + j <= last_first; ++j)
        if (i + j > 0) first += double(block.square[std::size_t(i * block_side + j)]);
    energies.push_back(block.low - first);
  }
  const auto quantile = [&](double share) {
    const auto at = energies.begin() + std::ptrdiff_t(share * double(energies.size()));
    std::ranges::nth_element(energies, at);
    return *at;
  };
  const Flattest flat = flattest_part(blocks, flattest);
  const double first = mean_of(flat.square, 1, last_first), second = mean_of(flat.square, last_first + 1, last_second);
  return first < most_first * second && quantile(0.25) < most_uneven * quantile(flattest) &&
         second > least_smoothed * flat.high;
}

/// Of noise of deviation 1 at high frequencies.
BlockValues spectrum_of(const Flattest& flat) {
  const double share = share_of_least(flat.square);
  BlockValues spectrum;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j) {
      const auto k = std::size_t(i * block_side + j);
      spectrum[k] = flat.square[k] / flat.high / (i + j < first_high ? share : 1);
    }
  spectrum[0] = mean_of(spectrum, 1, last_first);
  return spectrum;
}

/// One class of noise that was smoothed, or none.
NoiseCurve smoothed_noise(const std::vector<NoiseBlocks>& blocks) {
  if (!is_smoothed(blocks.front().changing)) return {};
  NoiseCurve curve{{0}, Signal::Zero(1, Eigen::Index(blocks.size())), {}};
  for (std::size_t c = 0; c < blocks.size(); ++c) {
    BlockValues white;
    white.fill(1);
    curve.spectrum.push_back(white);
    if (noise_level(blocks[c]) == 0) continue;
    const Flattest flat = flattest_part(blocks[c].changing, flattest_smoothed);
    curve.spectrum.back() = spectrum_of(flat);
    curve.deviation(0, Eigen::Index(c)) = std::sqrt(flat.high);
  }
  curve.deviation = curve.deviation.cwiseMax(least_deviation * curve.deviation.maxCoeff());
  return curve;
}

}  // namespace

NoiseCurve::Place NoiseCurve::place_of(double value) const {
  const auto count = int(brightness.size());
  if (count < 2 || value <= brightness.front()) return {};
  const auto above = int(std::ranges::upper_bound(brightness, value) - brightness.begin());
  const int to = std::min(above, count - 1);
  const double from = brightness[std::size_t(to - 1)];
  return {to, (value - from) / (brightness[std::size_t(to)] - from)};
}

double NoiseCurve::at(const Place& place, int channel) const {
  if (place.to == 0) return deviation(0, channel);
  const double from = deviation(place.to - 1, channel), to = deviation(place.to, channel);
  if (place.share > 1 && to <= from) return to;
  return from + place.share * (to - from);
}

NoiseCurve noise_curve(const ChartWindows& windows, const Signal& psi, const Progress& progress) {
  const std::vector<NoiseBlocks> blocks = noise_blocks(windows, psi, progress);
  const std::vector<NoiseBlock>& bright = blocks.front().changing;
  const std::vector<double> bounds = class_bounds(bright);
  const ClassNoise of_brightness = noise_of(bounds, bright);
  if (std::ranges::none_of(of_brightness.is_noise, std::identity{})) return smoothed_noise(blocks);
  const auto classes = Eigen::Index(of_brightness.brightness.size());
  NoiseCurve curve{of_brightness.brightness, Signal(classes, psi.cols()), {}};
  for (int c = 0; c < psi.cols(); ++c) {
    const NoiseBlocks& of_channel = blocks[std::size_t(c)];
    const double of_all = noise_level(of_channel);
    const ClassNoise noise = c == 0 ? of_brightness : noise_of(bounds, of_channel.changing);
    const std::vector<double> variance = smooth_variance(curve.brightness, noise, of_all * of_all);
    curve.deviation.col(c) = Eigen::Map<const Vector>(variance.data(), classes).cwiseSqrt();
  }
  curve.deviation = curve.deviation.cwiseMax(least_deviation * curve.deviation.maxCoeff());
  return curve;
}

bool NoiseCurve::grows() const {
  constexpr double far_from_0 = 1.5, least_range = 2, least_power = 0.45;
  if (!spectrum.empty()) return false;
  std::size_t first = 0;
  while (first < brightness.size() && brightness[first] < far_from_0 * deviation(Eigen::Index(first), 0)) ++first;
  for (std::size_t k = first + 1; k < brightness.size(); ++k) {
    const double brighter = brightness[k] / brightness[first],
                 noisier = deviation(Eigen::Index(k), 0) / deviation(Eigen::Index(first), 0);
    if (brighter >= least_range && std::log(noisier) > least_power * std::log(brighter)) return true;
  }
  return false;
}

double NoiseCurve::smoothed() const {
  return spectrum.empty() ? 1 : std::sqrt(mean_of(spectrum.front(), last_first + 1, last_second));
}

Eigen::MatrixXd NoiseCurve::covariance(int channel, int side) const {
  const int size = side * side;
  if (spectrum.empty()) return Eigen::MatrixXd::Identity(size, size);
  // Of two values of a block, one at (a, b) and one at (c, d): Σᵢⱼ S(i, j) T(i, a) T(j, b) T(i, c) T(j, d).
  const BlockValues& S = spectrum[std::size_t(channel)];
  const BlockValues& T = block_cosines();
  const auto of_block = [&](int a, int b, int c, int d) {
    double sum = 0;
    for (int i = 0; i < block_side; ++i)
      for (int j = 0; j < block_side; ++j)
        sum += S[std::size_t(i * block_side + j)] * T[std::size_t(i * block_side + a)] *
               T[std::size_t(j * block_side + b)] * T[std::size_t(i * block_side + c)] *
               T[std::size_t(j * block_side + d)];
    return sum;
  };
  const int places = block_side - side + 1;
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  for (int y = 0; y < places; ++y)
    for (int x = 0; x < places; ++x)
      for (int m = 0; m < size; ++m)
        for (int n = 0; n < size; ++n)
          C(m, n) += of_block(y + m / side, x + m % side, y + n / side, x + n % side) / (places * places);
  return C;
}

}  // namespace mq
