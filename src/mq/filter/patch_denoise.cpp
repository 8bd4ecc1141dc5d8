// x = T·ψ/σ, T the cosine transform of the channels: luminance first. Twice patches P of x, in the deviation of their
// noise and white, become  P' = m + (C − I)·C⁻¹·(P − m); and back.

#include "mq/filter/patch_denoise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/filter/chart_windows.h"
#include "mq/filter/detail/even_noise.h"
#include "mq/filter/detail/fireflies.h"
#include "mq/filter/detail/stray_texels.h"
#include "mq/filter/kernels/similar_patches.h"
#include "mq/filter/noise_curve.h"
#include "mq/filter/noise_level.h"
#include "mq/mesh/weld.h"

namespace mq {

namespace {

using Values = TexelValues;

struct Pass {
  int side = 0;      ///< of a patch
  int together = 0;  ///< so many channels at most
};
constexpr Pass first_pass{4, 1}, second_pass{3, 4};
constexpr int window_border = patches_before + first_pass.side - 1;
constexpr int anchor_step = 2;

/// Patches whose values vary by no more than this, of what noise does, are flat.
constexpr double flat_variance = 1.05;

/// Keeps C of patches that repeat one another invertible, of the variance of noise.
constexpr float least_variance = 1e-3F;

/// L of the Cholesky factorisation L·Lᵀ of the covariance of noise of a channel, and its inverse, row by row: L⁻¹ makes
/// noise of patches white.
struct Whitening {
  Whitening(const NoiseCurve& noise, int channel, int side) {
    const Eigen::MatrixXd C = noise.covariance(channel, side);
    const Eigen::MatrixXd L = C.llt().matrixL();
    factor = L.cast<float>();
    inverse = L.inverse().cast<float>();
  }

  using Triangle = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Triangle factor, inverse;
};

/// What patches are measured by: one for each channel of each pass; none where noise is white.
using Whitenings = std::array<std::vector<Whitening>, 2>;

Whitenings whitenings_of(const NoiseCurve& noise, int channels) {
  Whitenings result;
  for (int c = 0; c < channels && !noise.spectrum.empty(); ++c) {
    result[0].emplace_back(noise, c, first_pass.side);
    result[1].emplace_back(noise, c, second_pass.side);
  }
  return result;
}

/// In place, as rows below do not count.
void multiply(const Whitening::Triangle& lower, float* rows) {
  for (Eigen::Index r = lower.rows() - 1; r >= 0; --r) {
    float* const row = rows + r * most_patches;
    for (int n = 0; n < most_patches; ++n) row[n] *= lower(r, r);
    for (Eigen::Index t = 0; t < r; ++t) {
      const float factor = lower(r, t);
      const float* const other = rows + t * most_patches;
      for (int n = 0; n < most_patches; ++n) row[n] += factor * other[n];
    }
  }
}

/// One window, its values in planes and what its patches say.
class WindowFilter {
 public:
  WindowFilter(ChartWindow window, const Values& noisy, const Values* basic, const NoiseCurve& noise,
               const Whitenings& whitenings)
      : window_(std::move(window)),
        pass_(basic ? second_pass : first_pass),
        channels_(int(noisy.cols())),
        noise_(noise),
        whitenings_(whitenings[basic ? 1 : 0]) {
    noisy_ = planes(noisy);
    if (basic) basic_ = planes(*basic);
    find_anchors();
    sum_.assign(noisy_.size(), 0);
    weight_.assign(window_.unknowns.size(), 0);
    for (const int anchor : anchors_) filter(anchor);
  }

  /// Adds to the changes, and how often each, of the unknowns of the chart.
  void add_to(Values& change, std::vector<float>& weight) const {
    for (std::size_t i = 0; i < weight_.size(); ++i) {
      if (!window_.own[i] || weight_[i] == 0) continue;
      const int k = window_.unknowns[i];
      weight[std::size_t(k)] += weight_[i];
      for (int c = 0; c < channels_; ++c) change(k, c) += sum_[std::size_t(c) * weight_.size() + i];
    }
  }

 private:
  std::vector<float> planes(const Values& values) const {
    const std::size_t size = window_.unknowns.size();
    std::vector<float> result(size * std::size_t(channels_), 0);
    for (std::size_t i = 0; i < size; ++i)
      if (const int k = window_.unknowns[i]; k >= 0)
        for (int c = 0; c < channels_; ++c) result[std::size_t(c) * size + i] = values(k, c);
    return result;
  }

  bool is_whole(int x, int y) const {
    for (int j = 0; j < pass_.side; ++j)
      for (int i = 0; i < pass_.side; ++i)
        if (window_.unknowns[std::size_t((y + j) * window_.width + x + i)] < 0) return false;
    return true;
  }

  /// Every second patch of every second row, and where the chart ends what else it takes to hold every texel.
  void find_anchors() {
    const int width = window_.width, height = window_.height, last = pass_.side - 1;
    whole_.assign(window_.unknowns.size(), 0);
    for (int y = 0; y + last < height; ++y)
      for (int x = 0; x + last < width; ++x) whole_[std::size_t(y * width + x)] = is_whole(x, y);
    std::vector<char> held(window_.unknowns.size(), 0);
    const auto take = [&](int x, int y) {
      anchors_.push_back(y * width + x);
      for (int j = 0; j <= last; ++j)
        for (int i = 0; i <= last; ++i) held[std::size_t((y + j) * width + x + i)] = 1;
    };
    for (int y = window_border; y < height - window_border; ++y)
      for (int x = window_border; x < width - window_border; ++x) {
        const std::size_t i = std::size_t(y * width + x);
        if ((window_.column + x) % anchor_step == 0 && (window_.row + y) % anchor_step == 0 && whole_[i] &&
            window_.own[i] == 1)
          take(x, y);
      }
    for (int y = window_border; y < height - window_border; ++y)
      for (int x = window_border; x < width - window_border; ++x)
        for (int n = 0; n < pass_.side * pass_.side; ++n) {
          const std::size_t i = std::size_t(y * width + x);
          if (window_.own[i] != 1 || held[i]) break;
          const int left = x - n % pass_.side, top = y - n / pass_.side;
          if (whole_[std::size_t(top * width + left)]) take(left, top);
        }
  }

  /// The patches most like one, itself the first.
  int find_similar(int anchor, std::array<int, most_patches>& similar) const {
    std::array<float, patch_search_side * patch_search_side> sums;
    const auto size = std::int64_t(window_.unknowns.size());
    const PatchPlanes planes{basic_.empty() ? noisy_.data() : basic_.data(), size, window_.width,
                             basic_.empty() ? 1 : channels_};
    similar_patch_kernels().distances(planes, pass_.side, anchor, sums.data());
    std::array<std::pair<float, int>, patch_search_side * patch_search_side> candidates;
    int count = 0;
    for (int n = 0; n < int(sums.size()); ++n) {
      const int at = anchor + (n / patch_search_side - patches_before) * window_.width + n % patch_search_side -
                     patches_before;
      if (whole_[std::size_t(at)]) candidates[std::size_t(count++)] = {at == anchor ? -1 : sums[std::size_t(n)], at};
    }
    const int found = std::min(count, most_patches);
    std::ranges::nth_element(candidates.begin(), candidates.begin() + (found - 1), candidates.begin() + count);
    std::ranges::sort(candidates.begin(), candidates.begin() + found);
    for (int n = 0; n < found; ++n) similar[std::size_t(n)] = candidates[std::size_t(n)].second;
    return found;
  }

  /// Values of the patches, a row for each place and channel.
  void gather(const std::vector<float>& planes, std::span<const int> patches, int first_channel, int channels,
              float* rows) const {
    for (int c = first_channel; c < first_channel + channels; ++c)
      for (int j = 0; j < pass_.side; ++j)
        for (int i = 0; i < pass_.side; ++i, rows += most_patches) {
          const float* const plane = &planes[std::size_t(c) * window_.unknowns.size()] + j * window_.width + i;
          for (std::size_t n = 0; n < patches.size(); ++n) rows[n] = plane[patches[n]];
        }
  }

  void add(std::span<const int> patches, int first_channel, int channels, const float* rows) {
    for (int c = first_channel; c < first_channel + channels; ++c)
      for (int j = 0; j < pass_.side; ++j)
        for (int i = 0; i < pass_.side; ++i, rows += most_patches) {
          const std::size_t offset = std::size_t(c) * window_.unknowns.size() + std::size_t(j * window_.width + i);
          for (std::size_t n = 0; n < patches.size(); ++n) {
            const std::size_t at = offset + std::size_t(patches[n]);
            sum_[at] += rows[n] - noisy_[at];
          }
        }
  }

  /// Of the mean brightness of each place of the patches.
  std::array<NoiseCurve::Place, most_patch_values> brightness_of(std::span<const int> patches) const {
    const std::vector<float>& plane = basic_.empty() ? noisy_ : basic_;
    std::array<NoiseCurve::Place, most_patch_values> places;
    for (int r = 0; r < pass_.side * pass_.side; ++r) {
      const int offset = r / pass_.side * window_.width + r % pass_.side;
      float sum = 0;
      for (const int patch : patches) sum += plane[std::size_t(patch + offset)];
      places[std::size_t(r)] = noise_.place_of(double(sum) / double(patches.size()));
    }
    return places;
  }

  /// Of noise, a value for each row that `gather` gives.
  std::array<float, most_patch_values> deviations(const std::array<NoiseCurve::Place, most_patch_values>& brightness,
                                                  int first_channel, int channels) const {
    std::array<float, most_patch_values> result{};
    const int places = pass_.side * pass_.side;
    for (int c = 0; c < channels; ++c)
      for (int r = 0; r < places; ++r)
        result[std::size_t(c * places + r)] = float(noise_.at(brightness[std::size_t(r)], first_channel + c));
    return result;
  }

  /// Whether the patches differ by noise alone; then their values become the mean of them all.
  bool level(std::span<const int> patches, const std::array<NoiseCurve::Place, most_patch_values>& brightness) {
    const int rows = pass_.side * pass_.side;
    std::array<float, most_patch_values * most_patches> values;
    std::vector<double> means;
    double variance = 0;
    const double share = 1.0 / (double(rows) * double(patches.size()));
    for (int c = 0; c < channels_; ++c) {
      gather(noisy_, patches, c, 1, values.data());
      const std::array<float, most_patch_values> deviation = deviations(brightness, c, 1);
      double sum = 0, of_noise = 0, squares = 0;
      for (int r = 0; r < rows; ++r) {
        of_noise += double(deviation[std::size_t(r)]) * double(deviation[std::size_t(r)]) / rows;
        for (std::size_t n = 0; n < patches.size(); ++n) {
          const double v = double(values[std::size_t(r) * most_patches + n]) - double(values[0]);
          sum += v, squares += v * v;
        }
      }
      variance += (share * squares - share * share * sum * sum) / of_noise;
      if (variance > flat_variance * channels_) return false;
      means.push_back(double(values[0]) + share * sum);
    }
    for (int c = 0; c < channels_; ++c) {
      values.fill(float(means[std::size_t(c)]));
      add(patches, c, 1, values.data());
    }
    return true;
  }

  /// Makes noise of deviation 1 of it, without what neighbours have in common.
  void whiten(int first_channel, int channels, const std::array<float, most_patch_values>& deviation,
              float* values) const {
    const int rows = pass_.side * pass_.side;
    for (int r = 0; r < channels * rows; ++r) {
      const float factor = 1 / deviation[std::size_t(r)];
      for (int n = 0; n < most_patches; ++n) values[r * most_patches + n] *= factor;
    }
    for (int k = 0; k < channels && !whitenings_.empty(); ++k)
      multiply(whitenings_[std::size_t(first_channel + k)].inverse, values + k * rows * most_patches);
  }

  /// The same back.
  void colour(int first_channel, int channels, const std::array<float, most_patch_values>& deviation,
              float* values) const {
    const int rows = pass_.side * pass_.side;
    for (int k = 0; k < channels && !whitenings_.empty(); ++k)
      multiply(whitenings_[std::size_t(first_channel + k)].factor, values + k * rows * most_patches);
    for (int r = 0; r < channels * rows; ++r)
      for (int n = 0; n < most_patches; ++n) values[r * most_patches + n] *= deviation[std::size_t(r)];
  }

  void filter(int anchor) {
    std::array<int, most_patches> similar;
    const std::span<const int> patches(similar.data(), std::size_t(find_similar(anchor, similar)));
    for (const int patch : patches)
      for (int j = 0; j < pass_.side; ++j)
        for (int i = 0; i < pass_.side; ++i) weight_[std::size_t(patch + j * window_.width + i)] += 1;
    const std::array<NoiseCurve::Place, most_patch_values> brightness = brightness_of(patches);
    if (basic_.empty() && level(patches, brightness)) return;
    std::array<float, most_patch_values * most_patches> values{}, like{};
    for (int c = 0; c < channels_; c += pass_.together) {
      const int channels = std::min(pass_.together, channels_ - c), rows = channels * pass_.side * pass_.side;
      gather(noisy_, patches, c, channels, values.data());
      const std::array<float, most_patch_values> deviation = deviations(brightness, c, channels);
      whiten(c, channels, deviation, values.data());
      if (!basic_.empty()) {
        gather(basic_, patches, c, channels, like.data());
        whiten(c, channels, deviation, like.data());
      }
      similar_patch_kernels().shrink(rows, int(patches.size()), basic_.empty() ? least_variance : 1,
                                     basic_.empty() ? values.data() : like.data(), values.data());
      colour(c, channels, deviation, values.data());
      add(patches, c, channels, values.data());
    }
  }

  ChartWindow window_;
  Pass pass_;
  int channels_;
  const NoiseCurve& noise_;
  const std::vector<Whitening>& whitenings_;
  std::vector<float> noisy_, basic_;  ///< planes; the latter empty in the first pass
  std::vector<float> sum_;            ///< planes
  std::vector<float> weight_;
  std::vector<char> whole_;  ///< per place whether a patch that begins there lies on the surface
  std::vector<int> anchors_;
};

/// What the patches of all windows say; changes are added up window by window, whatever the threads do.
Values pass_over(const ChartWindows& windows, const Values& noisy, const Values* basic, const NoiseCurve& noise,
                 const Whitenings& whitenings, const Progress& progress) {
  Values change = Values::Zero(noisy.rows(), noisy.cols());
  std::vector<float> weight(std::size_t(noisy.rows()), 0);
  constexpr int at_once = 128;
  for (int first = 0; first < windows.count(); first += at_once) {
    progress.at(double(first) / windows.count());
    const int count = std::min(at_once, windows.count() - first);
    std::vector<std::optional<WindowFilter>> filtered(static_cast<std::size_t>(count));
    parallel_for(
        count,
        [&](std::int64_t k) {
          filtered[std::size_t(k)].emplace(windows.window(first + int(k), window_border), noisy, basic, noise,
                                           whitenings);
        },
        1);
    for (const std::optional<WindowFilter>& window : filtered) window->add_to(change, weight);
  }
  parallel_for(noisy.rows(), [&](std::int64_t k) {
    if (weight[std::size_t(k)] > 0) change.row(k) /= weight[std::size_t(k)];
    change.row(k) += noisy.row(k);
  });
  return change;
}

/// Orthonormal; its first row is the mean, and of three channels the others are what is called opponent colours.
Eigen::MatrixXd cosine_transform(int count) {
  Eigen::MatrixXd T(count, count);
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < count; ++i)
      T(k, i) = std::sqrt((k == 0 ? 1.0 : 2.0) / count) * std::cos(std::numbers::pi * (i + 0.5) * k / count);
  return T;
}

/// Planes in which noise of different channels has little in common, luminance first.
class NoisePlanes {
 public:
  /// Of the channels that have noise.
  NoisePlanes(const Signal& psi, const std::vector<double>& noise) : middle_(psi.colwise().mean()) {
    for (int c = 0; c < int(psi.cols()); ++c)
      if (noise[std::size_t(c)] > 0) channels_.push_back(c);
    T_ = cosine_transform(count());
    level_.resize(count());
    for (int n = 0; n < count(); ++n) level_[n] = noise[std::size_t(channels_[std::size_t(n)])];
  }

  int count() const { return int(channels_.size()); }

  Signal of(const Signal& psi) const {
    Signal planes(psi.rows(), count());
    parallel_for(psi.rows(), [&](std::int64_t k) {
      Eigen::VectorXd x(count());
      for (int n = 0; n < count(); ++n) {
        const int c = channels_[std::size_t(n)];
        x[n] = (psi(k, c) - middle_[c]) / level_[n];
      }
      planes.row(k) = (T_ * x).transpose();
    });
    return planes;
  }

  /// The change of channels that a change of the planes is.
  Signal change(const Values& from, const Values& to) const {
    Signal result(from.rows(), count());
    parallel_for(from.rows(), [&](std::int64_t k) {
      const Eigen::VectorXd x = (to.row(k) - from.row(k)).transpose().cast<double>();
      result.row(k) = (T_.transpose() * x).cwiseProduct(level_).transpose();
    });
    return result;
  }

  void add(const Signal& change, Signal& psi) const {
    for (int n = 0; n < count(); ++n) psi.col(channels_[std::size_t(n)]) += change.col(n);
  }

 private:
  std::vector<int> channels_;
  Eigen::RowVectorXd middle_;
  Eigen::MatrixXd T_;
  Eigen::VectorXd level_;
};

/// Takes the mean of a change, over each component of the surface, out of it.
void keep_means(const Surface& surface, const Atlas& atlas, const TexelSpace& space, Signal& change) {
  DisjointSets charts(atlas.charts.size());
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int here = atlas.chart[std::size_t(h / 3)], twin = surface.twins[std::size_t(h)];
    const int there = twin < 0 ? -1 : atlas.chart[std::size_t(twin / 3)];
    if (here >= 0 && there >= 0) charts.join(here, there);
  }
  const Vector mass = space.lumped_mass();
  Vector area = Vector::Zero(Eigen::Index(atlas.charts.size()));
  Signal sum = Signal::Zero(area.size(), change.cols());
  const std::vector<int>& chart = space.texels().chart;
  for (int k = 0; k < space.size(); ++k) {
    if (chart[std::size_t(k)] < 0) continue;
    const int root = charts.root(chart[std::size_t(k)]);
    area[root] += mass[k];
    sum.row(root) += mass[k] * change.row(k);
  }
  for (int k = 0; k < space.size(); ++k) {
    if (chart[std::size_t(k)] < 0) continue;
    const int root = charts.root(chart[std::size_t(k)]);
    if (area[root] > 0) change.row(k) -= sum.row(root) / area[root];
  }
}

/// Fireflies are looked for where noise is that of light.
enum class Fireflies { taken_off, none };

/// Where noise is of one deviation everywhere, or nearly.
PatchDenoised denoise_even(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                           const ChartWindows& windows, const Signal& psi, const std::vector<double>& levels,
                           double strength, Fireflies fireflies, const Progress& progress) {
  PatchDenoised result{psi, levels};
  const NoisePlanes planes(psi, levels);
  if (planes.count() == 0) return result;
  Values noisy;
  NoiseCurve noise;
  {
    const Signal exact = planes.of(psi);
    noise = noise_curve(windows, exact, progress.step("measure noise by brightness", 0.03));
    noisy = exact.cast<float>();
  }
  result.smoothed = noise.smoothed();
  if (noise.is_empty()) noise = {.brightness = {0}, .deviation = Signal::Ones(1, planes.count()), .spectrum = {}};
  noise.deviation *= std::max(1.0, strength);

  Values steady = noisy;
  if (fireflies == Fireflies::taken_off && noise.spectrum.empty())
    result.fireflies = take_fireflies_off(windows, noise, steady);
  const Whitenings whitenings = whitenings_of(noise, planes.count());
  const Values basic =
      pass_over(windows, steady, nullptr, noise, whitenings, progress.step("patches of channels", 0.47));
  const Values best = pass_over(windows, steady, &basic, noise, whitenings, progress.step("patches of colours", 0.5));
  Signal change = planes.change(steady, best);
  keep_means(surface, atlas, space, change);
  if (result.fireflies > 0) change += planes.change(noisy, steady);
  planes.add(change, result.signal);
  return result;
}

}  // namespace

PatchDenoised denoise_by_patches(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                                 const Signal& given, const PatchDenoiseOptions& options, const Progress& progress) {
  require(options.strength > 0 && std::isfinite(options.strength),
          fmt::format("denoising has a strength of {}; it must be more than 0", options.strength));
  require(given.rows() == space.size() && given.allFinite(),
          fmt::format("a signal of {} rows was given for {} unknowns, or it is not finite", given.rows(),
                      space.size()));
  const ChartWindows windows(surface, atlas, space);
  const WithoutStrays without = without_stray_texels(windows, given);
  const Signal& psi = without.signal ? *without.signal : given;
  const std::vector<double> levels = noise_levels(windows, psi, progress.step("measure noise", 0.03));
  const std::vector<NoiseCurve> curves = growing_noise(windows, psi, levels, progress.step("measure noise", 0.03));
  const auto even = curves.empty() ? std::nullopt : EvenNoise::of(curves, psi);
  const Progress filtering = progress.step("filter", 0.94);
  PatchDenoised result;
  if (even) {
    const Signal z = even->there(psi);
    const std::vector<double> of_z = noise_levels(windows, z, filtering.step("measure noise", 0.03));
    result = denoise_even(surface, atlas, space, windows, z, of_z, options.strength, Fireflies::taken_off,
                          filtering.step("filter", 0.97));
    result.signal = even->back(result.signal, z, of_z, psi);
    result.noise = levels;
  } else {
    result = denoise_even(surface, atlas, space, windows, psi, levels, options.strength,
                          curves.empty() ? Fireflies::none : Fireflies::taken_off, filtering);
  }
  result.strays = without.count;
  if (options.strength < 1) result.signal = psi + options.strength * (result.signal - psi);
  return result;
}

}  // namespace mq
