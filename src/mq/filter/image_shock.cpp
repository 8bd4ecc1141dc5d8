/// Thesis 3.3.1 (ComputeFlow, IntegrateFlow, Iterative Sampling, Flow Composition) and 3.3.2
/// (Advect).

#include "mq/filter/image_shock.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/detail/texel_parts.h"
#include "mq/image/gaussian.h"

namespace mq {
namespace {

/// Several channels in double, row by row, as an image has them.
struct Field {
  int width = 0, height = 0, channels = 0;
  std::vector<double> values;
  double& operator()(int x, int y, int c) {
    return values[(std::size_t(y) * width + x) * channels + c];
  }
  double operator()(int x, int y, int c) const {
    return values[(std::size_t(y) * width + x) * channels + c];
  }
  double clamped(int x, int y, int c) const {
    return (*this)(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1), c);
  }
};

Field field_of(const Image<float>& image) {
  return {image.width(),
          image.height(),
          image.channels(),
          {image.values().begin(), image.values().end()}};
}

Field smoothed(const Field& field, double weight) {
  Field result = field;
  smooth(result.values, field.width, field.height, field.channels, weight);
  return result;
}

/// ½ Σ_c of the mean of |∇φ_c|² over a cell: along x the differences a above and b below, whose
/// square has the mean (a² + ab + b²)/3, and the same along y.
double cell_energy(const Field& phi, int x, int y) {
  double sum = 0;
  for (int c = 0; c < phi.channels; ++c) {
    const double p = phi(x, y, c), q = phi(x + 1, y, c), r = phi(x, y + 1, c),
                 s = phi(x + 1, y + 1, c);
    const double above = q - p, below = s - r, left = r - p, right = s - q;
    sum +=
        above * above + above * below + below * below + left * left + left * right + right * right;
  }
  return sum / 6;
}

/// The mean over the cells around each pixel.
Field potential_of(const Field& signal, const ShockWeights& weights) {
  const Field phi = smoothed(signal, weights.signal);
  const int cells_x = phi.width - 1, cells_y = phi.height - 1;
  std::vector<double> energy(std::size_t(cells_x) * cells_y);
  parallel_for(
      cells_y,
      [&](std::int64_t y) {
        for (int x = 0; x < cells_x; ++x)
          energy[std::size_t(y) * cells_x + x] = cell_energy(phi, x, int(y));
      },
      8);
  Field P{phi.width, phi.height, 1, std::vector<double>(std::size_t(phi.width) * phi.height)};
  parallel_for(
      phi.height,
      [&](std::int64_t row) {
        for (int x = 0; x < phi.width; ++x) {
          double sum = 0;
          int count = 0;
          for (int j = std::max(0, int(row) - 1); j <= std::min(int(row), cells_y - 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(x, cells_x - 1); ++i, ++count)
              sum += energy[std::size_t(j) * cells_x + i];
          P(x, int(row), 0) = sum / count;
        }
      },
      8);
  return smoothed(P, weights.potential);
}

/// Of values with one sign, else 0.
double nearest_to_zero(const std::array<double, 4>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return low > 0 ? low : high < 0 ? high : 0;
}

/// −X, X = Σ_c L_c ∇φ_c, constant on cells. Of the Laplacians at a cell's pixels the one nearest to
/// 0 counts, and none where their signs differ: an edge no wider than a cell is at rest.
GridFlow along_laplacian(const Field& phi) {
  const int cells_x = phi.width - 1, cells_y = phi.height - 1;
  std::vector<std::array<double, 2>> X(std::size_t(cells_x) * cells_y);
  const auto laplacian = [&](int x, int y, int c) {
    return phi.clamped(x - 1, y, c) + phi.clamped(x + 1, y, c) + phi.clamped(x, y - 1, c) +
           phi.clamped(x, y + 1, c) - 4 * phi(x, y, c);
  };
  parallel_for(
      cells_y,
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < cells_x; ++x) {
          auto& to = X[std::size_t(y) * cells_x + x];
          for (int c = 0; c < phi.channels; ++c) {
            const double L = nearest_to_zero({laplacian(x, y, c), laplacian(x + 1, y, c),
                                              laplacian(x, y + 1, c), laplacian(x + 1, y + 1, c)});
            const double p = phi(x, y, c), q = phi(x + 1, y, c), r = phi(x, y + 1, c),
                         s = phi(x + 1, y + 1, c);
            to[0] -= L * (q - p + s - r) / 2;
            to[1] -= L * (r - p + s - q) / 2;
          }
        }
      },
      8);
  return GridFlow::along(phi.width, phi.height, std::move(X));
}

/// Bilinear, never outside the values of the four pixels around.
void look_up(const Field& from, const std::array<double, 2>& place, double* values) {
  const auto [column, line] = place;
  const int i = std::clamp(int(std::floor(column)), 0, from.width - 2);
  const int j = std::clamp(int(std::floor(line)), 0, from.height - 2);
  const double u = column - i, v = line - j;
  for (int c = 0; c < from.channels; ++c) {
    const double p = from(i, j, c), q = from(i + 1, j, c), r = from(i, j + 1, c),
                 s = from(i + 1, j + 1, c);
    const double above = u == 0 ? p : u == 1 ? q : p + u * (q - p);
    const double below = u == 0 ? r : u == 1 ? s : r + u * (s - r);
    const double value = v == 0 ? above : v == 1 ? below : above + v * (below - above);
    const auto [low, high] = std::minmax({p, q, r, s});
    values[c] = std::clamp(value, low, high);
  }
}

/// Values of `from` at the ends of paths.
Field looked_up(const Field& from, const GridFlow& flow, const std::vector<SurfacePoint>& ends) {
  Field to = from;
  parallel_for(
      from.height,
      [&](std::int64_t row) {
        for (int x = 0; x < from.width; ++x)
          look_up(from, flow.place(ends[std::size_t(row) * from.width + x]), &to(x, int(row), 0));
      },
      8);
  return to;
}

/// Pixels that differ from one around them, where something has changed.
std::vector<int> pixels_at_jumps(const Field& before, const Field& after) {
  const Eigen::Map<const Signal> values(before.values.data(), std::int64_t(before.width) * before.height,
                                        before.channels);
  const Signal least = least_jumps(values);
  const auto are_apart = [&](double a, double b, int c) { return std::abs(a - b) > least(0, c); };
  std::vector<char> jumps(std::size_t(before.width) * before.height);
  parallel_for(
      before.height,
      [&](std::int64_t row) {
        for (int x = 0; x < before.width; ++x) {
          const int y = int(row);
          bool jump = false, changed = false;
          for (int j = std::max(0, y - 1); j <= std::min(before.height - 1, y + 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(before.width - 1, x + 1); ++i)
              for (int c = 0; c < before.channels; ++c) {
                jump |= are_apart(after(x, y, c), after(i, j, c), c);
                changed |= are_apart(before(i, j, c), after(i, j, c), c);
              }
          jumps[std::size_t(y) * before.width + x] = jump && changed;
        }
      },
      8);
  std::vector<int> result;
  for (std::size_t i = 0; i < jumps.size(); ++i)
    if (jumps[i]) result.push_back(int(i));
  return result;
}

/// Where pixels differ from those around them the mean of paths from `texel_parts` takes the place of the one path.
void smooth_outlines(const GridFlow& flow, const Field& signal, double time, Field& result) {
  const std::vector<int> pixels = pixels_at_jumps(signal, result);
  constexpr std::size_t most = 1 << 17;  // at once
  constexpr std::size_t parts = texel_parts.size();
  const int channels = signal.channels;
  for (std::size_t first = 0; first < pixels.size(); first += most) {
    const std::size_t count = std::min(most, pixels.size() - first);
    std::vector<SurfacePoint> from(count * parts);
    for (std::size_t n = 0; n < from.size(); ++n) {
      const int pixel = pixels[first + n / parts];
      from[n] = flow.point(pixel % signal.width + texel_parts[n % parts][0],
                           pixel / signal.width + texel_parts[n % parts][1]);
    }
    const std::vector<SurfacePoint> to = flow.trace(from, time).ends;
    parallel_for(std::int64_t(count), [&](std::int64_t n) {
      const auto begin = std::size_t(pixels[first + std::size_t(n)]) * channels;
      Signal found(std::int64_t(parts), channels), before(1, channels);
      for (std::size_t k = 0; k < parts; ++k) {
        const auto start = flow.place(from[std::size_t(n) * parts + k]), end = flow.place(to[std::size_t(n) * parts + k]);
        const double left = std::max(0.0, 1 - std::hypot(end[0] - start[0], end[1] - start[1]));
        look_up(signal, end, &found(std::int64_t(k), 0));
        look_up(signal, start, before.data());
        for (int c = 0; c < channels; ++c) {
          double& value = found(std::int64_t(k), c);
          const double own = signal.values[begin + c];
          value = left == 1 ? own : faded(value, left, own, before(0, c));
        }
      }
      // The mean, which rounding must not bring out of the range.
      for (int c = 0; c < channels; ++c)
        result.values[begin + c] = std::clamp(found.col(c).mean(), found.col(c).minCoeff(), found.col(c).maxCoeff());
    });
  }
}

/// The image with a side of one pixel repeated.
Image<float> at_least_two(const Image<float>& image) {
  Image<float> wider(std::max(2, image.width()), std::max(2, image.height()), image.channels());
  for (int y = 0; y < wider.height(); ++y)
    for (int x = 0; x < wider.width(); ++x)
      std::ranges::copy(
          image.pixel(std::min(x, image.width() - 1), std::min(y, image.height() - 1)),
          wider.pixel(x, y).begin());
  return wider;
}

ShockedImage follow(const Image<float>& image, const ImageShockOptions& options,
                    const Progress& progress) {
  const Field first = field_of(image);
  ShockedImage shocked;
  shocked.image = image;
  const bool along = options.concavity == Concavity::along_gradient;
  const Field potential = potential_of(first, options.weights);
  shocked.rate = potential_rate(image.width(), image.height(), potential.values);
  shocked.time = options.time.unit == ShockTime::Unit::absolute ? options.time.value
                 : shocked.rate > 0                             ? options.time.value / shocked.rate
                                                                : 0;
  const int steps = options.method == ImageShockOptions::Method::transport ? 1 : options.steps;
  const bool iterated = options.method == ImageShockOptions::Method::iterated;
  Field signal = first;
  const Field calm =
      along ? Field{} : smoothed(first, options.weights.signal + options.weights.potential);
  Field carried = calm;
  Traced traced;
  for (int k = 0; k < steps; ++k) {
    const Progress step = progress.step(fmt::format("step {} of {}", k + 1, steps), 1.0 / steps);
    const GridFlow flow =
        along ? GridFlow::downhill(
                    image.width(), image.height(),
                    k == 0 ? potential.values : potential_of(signal, options.weights).values)
              : along_laplacian(carried);
    const Stopwatch watch;
    const bool composes = options.method == ImageShockOptions::Method::composed && k > 0;
    traced = composes ? flow.trace(traced.ends, shocked.time / steps, step)
                      : flow.trace_pixels(shocked.time / steps, step);
    shocked.counts = shocked.counts + traced.counts;
    shocked.path_seconds += watch.seconds();
    signal = looked_up(iterated ? signal : first, flow, traced.ends);
    if (steps == 1 && shocked.time > 0) smooth_outlines(flow, first, shocked.time, signal);
    if (!along && k + 1 < steps) carried = looked_up(iterated ? carried : calm, flow, traced.ends);
  }
  std::ranges::copy(signal.values, shocked.image.values().begin());
  return shocked;
}

}  // namespace

std::vector<double> shock_potential(const Image<float>& image, const ShockWeights& weights) {
  if (image.width() >= 2 && image.height() >= 2) return potential_of(field_of(image), weights).values;
  const Field wider = potential_of(field_of(at_least_two(image)), weights);
  std::vector<double> narrow;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) narrow.push_back(wider(x, y, 0));
  return narrow;
}

double potential_rate(int width, int height, std::span<const double> potential) {
  const auto at = [&](int x, int y) {
    return potential[std::size_t(std::clamp(y, 0, height - 1)) * width +
                     std::clamp(x, 0, width - 1)];
  };
  const double sum = parallel_sum(
      height, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double part = 0;
        for (int y = int(begin); y < int(end); ++y)
          for (int x = 0; x < width; ++x) {
            const double L =
                at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1) - 4 * at(x, y);
            part += L * L;
          }
        return part;
      },
      16);
  return std::sqrt(sum / (double(width) * height));
}

ShockedImage shock(const Image<float>& image, const ImageShockOptions& options,
                   const Progress& progress) {
  require(!image.empty(), "the image has no pixels");
  require(options.steps >= 1 && options.time.value >= 0 && options.weights.signal >= 0 &&
              options.weights.potential >= 0,
          fmt::format("an image cannot be sharpened for a time of {} in {} steps",
                      options.time.value, options.steps));
  require(std::ranges::all_of(image.values(), [](float v) { return std::isfinite(v); }),
          "the image has values that are not finite");
  if (image.width() >= 2 && image.height() >= 2) return follow(image, options, progress);
  ShockedImage shocked = follow(at_least_two(image), options, progress);
  Image<float> narrow(image.width(), image.height(), image.channels());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      std::ranges::copy(shocked.image.pixel(x, y), narrow.pixel(x, y).begin());
  shocked.image = std::move(narrow);
  return shocked;
}

}  // namespace mq
