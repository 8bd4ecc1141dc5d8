/// Thesis 3.2.3. Computed in double; ε is found anew for every step, as |L| changes with the
/// signal. What we do differently: extrema of images bound the pixels beside them.

#include "mq/filter/osher_rudin.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Changes below this, per unit of the largest value, are rounding.
constexpr double at_rest = 1e-14;

double minmod(double x, double y) {
  if (!(x * y > 0)) return 0;
  return std::abs(x) < std::abs(y) ? x : y;
}

void require_time(double time, int most_steps) {
  require(time >= 0 && most_steps >= 1,
          fmt::format("a signal cannot be evolved for a time of {} in {} steps", time, most_steps));
}

/// Of values in rows: how far each pixel may go without passing an extremum beside it.
struct Bounds {
  std::vector<double> low, high;
};

/// The pixels of one value around `first`, joined through their sides; whether values around them
/// are lower and whether there are higher ones.
struct Terrace {
  std::vector<int> pixels;
  bool falls = false, rises = false;
};

class Terraces {
 public:
  Terraces(int width, int height, const std::vector<double>& values)
      : width_(width), height_(height), values_(values), seen_(values.size(), 0) {}

  bool seen(int pixel) const { return seen_[std::size_t(pixel)]; }

  /// Calls visit(pixel) for the up to four neighbours.
  template <class Visit>
  void around(int pixel, const Visit& visit) const {
    const int x = pixel % width_, y = pixel / width_;
    if (x > 0) visit(pixel - 1);
    if (x + 1 < width_) visit(pixel + 1);
    if (y > 0) visit(pixel - width_);
    if (y + 1 < height_) visit(pixel + width_);
  }

  void find(int first, Terrace& terrace) {
    terrace.pixels.assign(1, first);
    terrace.falls = terrace.rises = false;
    seen_[std::size_t(first)] = 1;
    const double level = values_[std::size_t(first)];
    for (std::size_t n = 0; n < terrace.pixels.size(); ++n)
      around(terrace.pixels[n], [&](int other) {
        const double value = values_[std::size_t(other)];
        if (value < level) terrace.falls = true;
        if (value > level) terrace.rises = true;
        if (value != level || seen_[std::size_t(other)]) return;
        seen_[std::size_t(other)] = 1;
        terrace.pixels.push_back(other);
      });
  }

 private:
  int width_, height_;
  const std::vector<double>& values_;
  std::vector<char> seen_;
};

Bounds bounds_by_extrema(int width, int height, const std::vector<double>& values) {
  Bounds bounds{std::vector<double>(values.size(), -INFINITY),
                std::vector<double>(values.size(), INFINITY)};
  Terraces terraces(width, height, values);
  Terrace terrace;
  for (int first = 0; first < int(values.size()); ++first) {
    if (terraces.seen(first)) continue;
    terraces.find(first, terrace);
    if (terrace.falls == terrace.rises) continue;
    const double level = values[std::size_t(first)];
    for (const int pixel : terrace.pixels)
      terraces.around(pixel, [&](int other) {
        double& low = bounds.low[std::size_t(other)];
        double& high = bounds.high[std::size_t(other)];
        if (terrace.falls)
          high = std::min(high, level);
        else
          low = std::max(low, level);
      });
  }
  return bounds;
}

/// One channel of an image, whose border goes on constant.
class Plane {
 public:
  Plane(const Image<float>& image, int channel)
      : width_(image.width()),
        height_(image.height()),
        values_(std::size_t(width_) * height_),
        next_(values_.size()),
        curvature_(values_.size()) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) values_[index(x, y)] = image(x, y, channel);
  }

  /// To be called before the first step.
  void hold_extrema() { bounds_ = bounds_by_extrema(width_, height_, values_); }

  double value(int x, int y) const { return values_[index(x, y)]; }

  /// Curvatures at all pixels, and the largest.
  double find_curvature(Concavity concavity) {
    std::vector<double> largest(std::size_t(height_), 0.0);
    parallel_for(
        height_,
        [&](std::int64_t y) {
          for (int x = 0; x < width_; ++x) {
            const double L = concavity == Concavity::laplacian ? laplacian(x, int(y))
                                                               : second_along_gradient(x, int(y));
            curvature_[index(x, int(y))] = L;
            largest[y] = std::max(largest[y], std::abs(L));
          }
        },
        8);
    return *std::ranges::max_element(largest);
  }

  /// False where nothing changed but by rounding.
  bool step(double epsilon) {
    std::vector<char> moved(std::size_t(height_), 0);
    parallel_for(
        height_,
        [&](std::int64_t row) {
          const int y = int(row);
          for (int x = 0; x < width_; ++x) {
            const double here = at(x, y);
            const double across = minmod(here - at(x - 1, y), at(x + 1, y) - here);
            const double down = minmod(here - at(x, y - 1), at(x, y + 1) - here);
            const double by =
                epsilon * std::sqrt(across * across + down * down) * curvature_[index(x, y)];
            const std::size_t i = index(x, y);
            next_[i] = std::clamp(here - by, bounds_.low[i], bounds_.high[i]);
            if (std::abs(next_[i] - here) > at_rest * std::abs(here)) moved[row] = 1;
          }
        },
        8);
    values_.swap(next_);
    return std::ranges::count(moved, 1) > 0;
  }

 private:
  std::size_t index(int x, int y) const { return std::size_t(y) * width_ + x; }
  double at(int x, int y) const {
    return values_[index(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1))];
  }
  double laplacian(int x, int y) const {
    return at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1) - 4 * at(x, y);
  }
  double second_along_gradient(int x, int y) const {
    const double fx = 0.5 * (at(x + 1, y) - at(x - 1, y)), fy = 0.5 * (at(x, y + 1) - at(x, y - 1));
    const double square = fx * fx + fy * fy;
    if (!(square > 0)) return 0;
    const double fxx = at(x + 1, y) - 2 * at(x, y) + at(x - 1, y);
    const double fyy = at(x, y + 1) - 2 * at(x, y) + at(x, y - 1);
    const double fxy =
        0.25 * (at(x + 1, y + 1) - at(x - 1, y + 1) - at(x + 1, y - 1) + at(x - 1, y - 1));
    return (fx * fx * fxx + 2 * fx * fy * fxy + fy * fy * fyy) / square;
  }

  int width_, height_;
  std::vector<double> values_, next_, curvature_;
  Bounds bounds_;
};

}  // namespace

Evolved osher_rudin(std::span<const double> signal, double time, int most_steps) {
  require_time(time, most_steps);
  Evolved evolved{{signal.begin(), signal.end()}, 0};
  std::vector<double>& phi = evolved.values;
  const int count = int(phi.size());
  std::vector<double> next(phi.size());
  const auto at = [&](int i) { return phi[std::size_t(std::clamp(i, 0, count - 1))]; };
  while (time > 0 && evolved.steps < most_steps && count > 0) {
    double largest = 0, change = 0, size = 0;
    for (int i = 0; i < count; ++i) {
      const double back = at(i) - at(i - 1), ahead = at(i + 1) - at(i);
      largest = std::max(largest, std::abs(ahead - back));
      size = std::max(size, std::abs(at(i)));
    }
    if (largest == 0) break;
    const double epsilon = std::min(time, 1 / (2 * largest));
    for (int i = 0; i < count; ++i) {
      const double back = at(i) - at(i - 1), ahead = at(i + 1) - at(i);
      const double by = epsilon * std::abs(minmod(back, ahead)) * (ahead - back);
      next[std::size_t(i)] = at(i) - by;
      change = std::max(change, std::abs(by));
    }
    phi.swap(next);
    time -= epsilon;
    ++evolved.steps;
    if (change <= at_rest * size) break;
  }
  return evolved;
}

EvolvedImage osher_rudin(const Image<float>& image, const OsherRudinOptions& options,
                         const Progress& progress) {
  require_time(options.time, options.most_steps);
  EvolvedImage evolved;
  evolved.image = image;
  for (int c = 0; c < image.channels(); ++c) {
    Plane plane(image, c);
    plane.hold_extrema();
    double left = options.time;
    int steps = 0;
    const auto rests = [&] {
      left = 0;
      return true;
    };
    while (left > 0 && steps < options.most_steps) {
      const double largest = plane.find_curvature(options.concavity);
      if (largest == 0 && rests()) break;
      const double epsilon = std::min(left, 1 / (4 * largest));
      left -= epsilon;
      if (!plane.step(epsilon) && rests()) break;
      ++steps;
      const double share = std::max(1 - left / options.time, double(steps) / options.most_steps);
      progress.at((c + share) / image.channels(),
                  fmt::format("step {} of about {:.0f}", steps,
                              std::min(steps + left * 4 * largest, double(options.most_steps))));
    }
    evolved.steps = std::max(evolved.steps, steps);
    evolved.left = std::max(evolved.left, left);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) evolved.image(x, y, c) = float(plane.value(x, y));
  }
  return evolved;
}

StepEstimate osher_rudin_steps(const Image<float>& image, double time, Concavity concavity) {
  StepEstimate steps;
  const double of_range = concavity == Concavity::laplacian ? 4 : 2.5;
  for (int c = 0; c < image.channels(); ++c) {
    double low = INFINITY, high = -INFINITY;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        low = std::min(low, double(image(x, y, c)));
        high = std::max(high, double(image(x, y, c)));
      }
    const double largest = Plane(image, c).find_curvature(concavity);
    steps.now = std::max(steps.now, std::ceil(time * 4 * largest));
    steps.most = std::max(steps.most, std::ceil(time * 4 * of_range * (high - low)));
  }
  return steps;
}

}  // namespace mq
