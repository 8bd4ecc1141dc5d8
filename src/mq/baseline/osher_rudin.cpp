/// Thesis 3.2.3. Computed in double; ε is found anew for every step, as |L| changes with the
/// signal. What we do differently: extrema of images bound the pixels beside them, and |L| counts
/// where pixels move. On a slope a the equation is ∂φ/∂t = −a·φₓₓ for what is small: heat running
/// backwards, by which the shortest waves of a grid grow fastest, whatever the step.

#include "mq/baseline/osher_rudin.h"

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

Bounds no_bounds(std::size_t pixels) {
  return {std::vector<double>(pixels, -INFINITY), std::vector<double>(pixels, INFINITY)};
}

/// Calls visit(terraces, terrace, level) for every extremum.
template <class Visit>
void for_each_extremum(int width, int height, const std::vector<double>& values, const Visit& visit) {
  Terraces terraces(width, height, values);
  Terrace terrace;
  for (int first = 0; first < int(values.size()); ++first) {
    if (terraces.seen(first)) continue;
    terraces.find(first, terrace);
    if (terrace.falls != terrace.rises) visit(terraces, terrace, values[std::size_t(first)]);
  }
}

Bounds bounds_by_extrema(int width, int height, const std::vector<double>& values) {
  Bounds bounds = no_bounds(values.size());
  for_each_extremum(width, height, values, [&](const Terraces& terraces, const Terrace& terrace, double level) {
    for (const int pixel : terrace.pixels)
      terraces.around(pixel, [&](int other) {
        double& low = bounds.low[std::size_t(other)];
        double& high = bounds.high[std::size_t(other)];
        if (terrace.falls)
          high = std::min(high, level);
        else
          low = std::max(low, level);
      });
  });
  return bounds;
}

/// One channel of an image, with a frame of one pixel as its border goes on constant.
class Plane {
 public:
  Plane(const Image<float>& image, int channel)
      : width_(image.width()),
        height_(image.height()),
        stride_(width_ + 2),
        values_(std::size_t(stride_) * (height_ + 2)),
        rates_(std::size_t(width_) * height_) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) at(x, y) = image(x, y, channel);
    frame();
  }

  /// To be called before the first step.
  void begin(OsherRudinOptions::Scheme scheme) {
    scheme_ = scheme;
    bounds_ = scheme == OsherRudinOptions::Scheme::bounded ? bounds_by_extrema(width_, height_, values())
                                                           : no_bounds(rates_.size());
  }

  std::vector<double> values() const {
    std::vector<double> values;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) values.push_back(at(x, y));
    return values;
  }

  double value(int x, int y) const { return at(x, y); }

  /// ∂φ/∂t at all pixels, and the largest |L|, where bounded of those that move.
  double find_rates(Concavity concavity) {
    std::vector<double> largest(std::size_t(height_), 0.0);
    parallel_for(
        height_,
        [&](std::int64_t row) {
          const int y = int(row);
          for (int x = 0; x < width_; ++x) {
            const std::size_t i = std::size_t(y) * width_ + x;
            rates_[i] = 0;
            const double here = at(x, y);
            const double across = minmod(here - at(x - 1, y), at(x + 1, y) - here);
            const double down = minmod(here - at(x, y - 1), at(x, y + 1) - here);
            const bool moves = across != 0 || down != 0, counts = scheme_ == OsherRudinOptions::Scheme::as_printed;
            if (!moves && !counts) continue;
            const double L =
                concavity == Concavity::laplacian ? laplacian(x, y) : second_along_gradient(x, y);
            if (counts) largest[row] = std::max(largest[row], std::abs(L));
            if (!moves) continue;
            const double rate = -std::sqrt(across * across + down * down) * L;
            if (rate == 0 || (rate > 0 ? here >= bounds_.high[i] : here <= bounds_.low[i]))
              continue;
            rates_[i] = rate;
            largest[row] = std::max(largest[row], std::abs(L));
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
          for (int x = 0; x < width_; ++x) {
            const std::size_t i = std::size_t(row) * width_ + x;
            if (rates_[i] == 0) continue;
            double& here = at(x, int(row));
            const double next =
                std::clamp(here + epsilon * rates_[i], bounds_.low[i], bounds_.high[i]);
            if (std::abs(next - here) > at_rest * std::abs(here)) moved[row] = 1;
            here = next;
          }
        },
        8);
    frame();
    return std::ranges::count(moved, 1) > 0;
  }

  /// By how much values differ at most from those of the last call, or from 0.
  double change() {
    marked_.resize(values_.size());
    double largest = 0;
    for (std::size_t i = 0; i < values_.size(); ++i)
      largest = std::max(largest, std::abs(values_[i] - marked_[i]));
    marked_ = values_;
    return largest;
  }

 private:
  double& at(int x, int y) { return values_[std::size_t(y + 1) * stride_ + x + 1]; }
  double at(int x, int y) const { return values_[std::size_t(y + 1) * stride_ + x + 1]; }
  void frame() {
    for (int y = 0; y < height_; ++y) at(-1, y) = at(0, y), at(width_, y) = at(width_ - 1, y);
    for (int x = -1; x <= width_; ++x) at(x, -1) = at(x, 0), at(x, height_) = at(x, height_ - 1);
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

  int width_, height_, stride_;
  std::vector<double> values_, rates_, marked_;
  OsherRudinOptions::Scheme scheme_ = OsherRudinOptions::Scheme::bounded;
  Bounds bounds_;
};

/// Steps before the first look at what has changed since.
constexpr int first_look = 16;

/// What became of a channel.
struct Course {
  int steps = 0;
  double left = 0;     ///< of the time
  double largest = 0;  ///< |L| of the last step
};

/// Evolves a plane; told(course) after every step.
template <class Told>
Course evolve(Plane& plane, const OsherRudinOptions& options, const Told& told) {
  plane.begin(options.scheme);
  Course course{.left = options.time};
  double looked = 0;
  while (course.left > 0 && course.steps < options.most_steps) {
    course.largest = plane.find_rates(options.concavity);
    if (course.largest == 0) return {course.steps, 0, 0};
    const double epsilon = std::min(course.left, 1 / (4 * course.largest));
    course.left -= epsilon;
    if (!plane.step(epsilon)) return {course.steps, 0, 0};
    ++course.steps;
    told(course);
    const double gone = options.time - course.left;
    if (course.steps < first_look || gone < 2 * looked) continue;
    const bool resting = plane.change() <= options.least_change;
    if (looked > 0 && resting) return {course.steps, 0, 0};
    looked = gone;
  }
  return course;
}

/// Of a channel the part of `side` pixels each way around where values change most from one to the
/// next.
Image<float> steepest_part(const Image<float>& image, int channel, int side) {
  int at_x = 0, at_y = 0;
  float steepest = -1;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const float here = image(x, y, channel);
      const float across = x + 1 < image.width() ? std::abs(image(x + 1, y, channel) - here) : 0;
      const float down = y + 1 < image.height() ? std::abs(image(x, y + 1, channel) - here) : 0;
      if (across + down > steepest) steepest = across + down, at_x = x, at_y = y;
    }
  const int width = std::min(side, image.width()), height = std::min(side, image.height());
  const int left = std::clamp(at_x - side / 2, 0, image.width() - width);
  const int top = std::clamp(at_y - side / 2, 0, image.height() - height);
  Image<float> part(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) part(x, y) = image(left + x, top + y, channel);
  return part;
}

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
    const Course course = evolve(plane, options, [&](const Course& now) {
      const double share =
          std::max(1 - now.left / options.time, double(now.steps) / options.most_steps);
      progress.at((c + share) / image.channels(),
                  fmt::format("step {} of {:.0f} at most", now.steps,
                              std::min(now.steps + std::ceil(now.left * 4 * now.largest),
                                       double(options.most_steps))));
    });
    evolved.steps = std::max(evolved.steps, course.steps);
    evolved.left = std::max(evolved.left, course.left);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) evolved.image(x, y, c) = float(plane.value(x, y));
  }
  return evolved;
}

PassedExtrema passed_extrema(const Image<float>& before, const Image<float>& after) {
  require(before.width() == after.width() && before.height() == after.height() && before.channels() == after.channels(),
          "extrema are looked for in two images of one size");
  PassedExtrema found;
  for (int c = 0; c < before.channels(); ++c) {
    const std::vector<double> values = Plane(before, c).values(), now = Plane(after, c).values();
    for_each_extremum(before.width(), before.height(), values,
                      [&](const Terraces& terraces, const Terrace& terrace, double level) {
                        double by = 0;
                        for (const int pixel : terrace.pixels)
                          terraces.around(pixel, [&](int other) {
                            if (values[std::size_t(other)] == level) return;
                            const double above = now[std::size_t(other)] - level;
                            by = std::max(by, terrace.falls ? above : -above);
                          });
                        ++found.extrema;
                        found.passed += by > 0;
                        found.furthest = std::max(found.furthest, by);
                      });
  }
  return found;
}

double osher_rudin_time(const Image<float>& image, const ShockTime& time) {
  if (time.unit == ShockTime::Unit::absolute) return time.value;
  // An image with a side of one pixel is as if repeated: what it repeats has the same means.
  const int width = std::max(2, image.width()), height = std::max(2, image.height());
  Image<float> wider(width, height, image.channels());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      std::ranges::copy(
          image.pixel(std::min(x, image.width() - 1), std::min(y, image.height() - 1)),
          wider.pixel(x, y).begin());
  const std::vector<double> potential = shock_potential(wider, {});
  const double rate = potential_rate(width, height, potential);
  double squares = 0, fourths = 0;
  for (const double P : potential) {
    squares += 2 * P;
    fourths += 4 * P * P;
  }
  return rate > 0 ? time.value * std::sqrt(fourths / squares) / rate : 0;
}

double osher_rudin_steps(const Image<float>& image, const OsherRudinOptions& options) {
  constexpr int side = 48, tried = 2000;
  double most = 0;
  for (int c = 0; c < image.channels(); ++c) {
    OsherRudinOptions pilot = options;
    pilot.most_steps = std::min(tried, options.most_steps);
    Plane part(steepest_part(image, c, side), 0);
    const Course course = evolve(part, pilot, [](const Course&) {});
    most = std::max(most, course.steps + std::ceil(course.left * 4 * course.largest));
  }
  return most;
}

}  // namespace mq
