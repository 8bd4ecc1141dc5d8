#include "mq/flow/light_ratio.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/flow/detail/field_claims.h"
#include "mq/flow/detail/image_signals.h"
#include "mq/flow/detail/image_warp.h"
#include "mq/image/gaussian.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

/// Over which means are taken, in √area, and what is added to them, in the mean of both images.
constexpr double width_of_means = 0.08, least_part = 0.01;

/// Of the largest value of an image, from where on it may be cut off.
constexpr float cut_off = 0.97F;

/// What a pixel says by itself: over such means and such a square, in √area; no more than so far from 0.
constexpr double own_length = 0.006, median_length = 0.03;
constexpr float largest_logarithm = 1.5F;

/// Logarithms that differ by no more are of one light, about.
constexpr float same_light = 0.12F;

/// Of the difference that breaks make to a tenth of all values, from where on there are some.
constexpr float least_broken = 0.1F;

/// √area of the grid that breaks are found on, pixels, and how much larger those of means are.
constexpr double grid_side = 400, coarsening = 4;

float largest(const Image<float>& image) {
  return image.empty() ? 0 : std::ranges::max(image.values());
}

/// What lies along a field, 0 where one of the two does not tell how much light there is.
struct MovedPair {
  FieldWays ways;
  Image<float> first, second;
  Image<float> told;  ///< 1 or 0
  float added = 0;    ///< to means
};

MovedPair moved_pair(const Image<float>& source, const Image<float>& target, const Image<float>& X) {
  MovedPair pair{ways_along(X, 0.5, FlowPath::straight), {}, {}, {},
                 float(least_part * (mean(source) + mean(target)) / 2)};
  const auto& [back, forth] = pair.ways;
  pair.first = displaced(source, back);
  pair.second = displaced(target, forth);
  pair.told = Image<float>(X.width(), X.height(), source.channels());
  const float cut_first = cut_off * largest(source), cut_second = cut_off * largest(target);
  for (int y = 0; y < X.height(); ++y)
    for (int x = 0; x < X.width(); ++x)
      for (int c = 0; c < source.channels(); ++c) {
        float &first = pair.first(x, y, c), &second = pair.second(x, y, c);
        const bool told =
            lands_inside(back, x, y) && lands_inside(forth, x, y) && first < cut_first && second < cut_second;
        pair.told(x, y, c) = told ? 1.0F : 0.0F;
        if (!told) first = second = 0;
      }
  return pair;
}

/// The image smoothed by so much of its √area.
Image<float> means(const Image<float>& image, double length) {
  const double deviation = length * std::sqrt(double(image.pixel_count()));
  return smoothed(image, deviation * deviation / 2);
}

/// log (b + added) − log (a + added).
Image<float> logarithm_of(const Image<float>& a, const Image<float>& b, float added) {
  Image<float> result = a;
  parallel_for(std::ssize(result.values()), [&](std::int64_t i) {
    float& value = result.values()[std::size_t(i)];
    value = std::log(b.values()[std::size_t(i)] + added) - std::log(value + added);
  });
  return result;
}

/// The mean over channels.
Image<float> grey(const Image<float>& image) {
  Image<float> result(image.width(), image.height(), 1);
  for (std::int64_t p = 0; p < image.pixel_count(); ++p) {
    float sum = 0;
    for (int c = 0; c < image.channels(); ++c) sum += image.values()[std::size_t(p * image.channels() + c)];
    result.values()[std::size_t(p)] = sum / float(image.channels());
  }
  return result;
}

/// The median over (2·reach + 1)² pixels, the border repeated.
Image<float> medians(const Image<float>& image, int reach) {
  const int width = image.width(), height = image.height();
  Image<float> result(width, height, 1);
  parallel_for(
      height,
      [&](std::int64_t row) {
        std::vector<float> around;
        for (int x = 0; x < width; ++x) {
          around.clear();
          for (int j = -reach; j <= reach; ++j)
            for (int i = -reach; i <= reach; ++i)
              around.push_back(image(std::clamp(x + i, 0, width - 1), std::clamp(int(row) + j, 0, height - 1)));
          const auto middle = around.begin() + std::ssize(around) / 2;
          std::nth_element(around.begin(), middle, around.end());
          result(x, int(row)) = *middle;
        }
      },
      row_block);
  return result;
}

/// What each pixel of a grid says by itself.
Image<float> own_logarithm(const Image<float>& first, const Image<float>& second, float added) {
  Image<float> own = logarithm_of(means(grey(first), own_length), means(grey(second), own_length), added);
  const int reach = int(std::lround(median_length * std::sqrt(double(own.pixel_count())) / 2));
  own = medians(own, reach);
  for (float& value : own.values()) value = std::clamp(value, -largest_logarithm, largest_logarithm);
  return own;
}

/// The logarithm of means over those pixels whose own is about `level`, on a coarse grid.
Image<float> logarithm_at_level(const MovedPair& grid, const Image<float>& own, float level, int width, int height) {
  const int channels = grid.first.channels();
  Image<float> weighted(own.width(), own.height(), 2 * channels);
  parallel_for(own.pixel_count(), [&](std::int64_t p) {
    const float off = (own.values()[std::size_t(p)] - level) / same_light, weight = std::exp(-off * off / 2);
    for (int c = 0; c < channels; ++c) {
      const auto at = std::size_t(p * channels + c);
      const float more = grid.added * grid.told.values()[at];
      weighted.values()[std::size_t(2 * (p * channels + c))] = weight * (grid.first.values()[at] + more);
      weighted.values()[std::size_t(2 * (p * channels + c) + 1)] = weight * (grid.second.values()[at] + more);
    }
  });
  const double deviation = width_of_means * std::sqrt(double(own.pixel_count()));
  const Image<float> sums = at_scale(weighted, deviation, width, height);
  Image<float> result(width, height, channels);
  const float least = 1e-6F * grid.added;
  for (std::size_t i = 0; i < result.values().size(); ++i)
    result.values()[i] = std::log(sums.values()[2 * i + 1] + least) - std::log(sums.values()[2 * i] + least);
  return result;
}

/// The image at another size, bilinearly.
Image<float> enlarged(const Image<float>& image, int width, int height) {
  if (width == image.width() && height == image.height()) return image;
  Image<float> result(width, height, image.channels());
  const double across = double(image.width()) / width, down = double(image.height()) / height;
  parallel_for(
      height,
      [&](std::int64_t y) {
        for (int x = 0; x < width; ++x)
          sample(image, (x + 0.5) * across - 0.5, (double(y) + 0.5) * down - 0.5, Wrap::clamp, result.pixel(x, int(y)));
      },
      row_block);
  return result;
}

/// With weights by how near the own logarithms are.
Image<float> broken_logarithm(const MovedPair& pair) {
  const int width = pair.first.width(), height = pair.first.height();
  const double spacing = std::max(1.0, std::sqrt(double(width) * height) / grid_side);
  const auto part = [](int side, double of) { return std::max(1, int(std::lround(side / of))); };
  const int across = part(width, spacing), down = part(height, spacing);
  const auto on_grid = [&](const Image<float>& image) { return area_scaled(image, across, down); };
  const MovedPair grid{{}, on_grid(pair.first), on_grid(pair.second), on_grid(pair.told), pair.added};
  const Image<float> own = own_logarithm(grid.first, grid.second, grid.added);
  const auto [least, most] = std::ranges::minmax(own.values());
  const int first = int(std::floor(least / same_light)), last = int(std::floor(most / same_light)) + 1;
  std::vector<Image<float>> levels;
  for (int level = first; level <= last; ++level)
    levels.push_back(enlarged(logarithm_at_level(grid, own, float(level) * same_light, part(across, coarsening),
                                                 part(down, coarsening)),
                              across, down));
  Image<float> result = grid.first;
  const int channels = result.channels();
  parallel_for(own.pixel_count(), [&](std::int64_t p) {
    const float place = own.values()[std::size_t(p)] / same_light - float(first);
    const int below = std::clamp(int(place), 0, last - first - 1);
    for (std::int64_t i = p * channels; i < (p + 1) * channels; ++i) {
      const float from = levels[std::size_t(below)].values()[std::size_t(i)],
                  to = levels[std::size_t(below + 1)].values()[std::size_t(i)];
      result.values()[std::size_t(i)] = from + (place - float(below)) * (to - from);
    }
  });
  return enlarged(result, width, height);
}

/// What a tenth of all differences surpass.
float difference_of(const Image<float>& a, const Image<float>& b) {
  std::vector<float> differences(a.values().size());
  for (std::size_t i = 0; i < differences.size(); ++i) differences[i] = std::abs(a.values()[i] - b.values()[i]);
  const auto at = differences.begin() + std::ssize(differences) * 9 / 10;
  std::nth_element(differences.begin(), at, differences.end());
  return *at;
}

/// The image with each value times what `factor` makes of its logarithm.
template <class Factor>
Image<float> lit(const Image<float>& image, const Image<float>& logarithm, const Factor& factor) {
  Image<float> result = image;
  parallel_for(std::ssize(result.values()), [&](std::int64_t i) {
    result.values()[std::size_t(i)] *= factor(logarithm.values()[std::size_t(i)]);
  });
  return result;
}

}  // namespace

LightRatio light_ratio(const Image<float>& source, const Image<float>& target, const Image<float>& X,
                       LightBreaks breaks) {
  const MovedPair pair = moved_pair(source, target, X);
  LightRatio ratio;
  if (!(pair.added > 0)) {
    ratio.of_source = ratio.of_target = Image<float>(source.width(), source.height(), source.channels());
    return ratio;
  }
  Image<float> logarithm =
      logarithm_of(means(pair.first, width_of_means), means(pair.second, width_of_means), pair.added);
  if (breaks == LightBreaks::found)
    if (Image<float> broken = broken_logarithm(pair); difference_of(broken, logarithm) > least_broken)
      logarithm = std::move(broken);
  double squares = 0;
  for (const float value : logarithm.values()) squares += double(value) * value;
  ratio.size = std::sqrt(squares / double(logarithm.values().size()));
  // A pixel p of the source is halfway at p + X/2.
  ratio.of_source = displaced(logarithm, pair.ways.forth);
  ratio.of_target = displaced(logarithm, pair.ways.back);
  return ratio;
}

LitImages in_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target, double t) {
  return {lit(source, ratio.of_source, [t](float l) { return float(1 + t * std::expm1(double(l))); }),
          lit(target, ratio.of_target, [t](float l) { return float(t + (1 - t) * std::exp(-double(l))); })};
}

LitImages in_mean_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target) {
  LitImages result{lit(source, ratio.of_source, [](float l) { return std::exp(0.5F * l); }),
                   lit(target, ratio.of_target, [](float l) { return std::exp(-0.5F * l); })};
  const auto cut = [](Image<float>& image, float most_of_other, const Image<float>& logarithm, float sign) {
    for (std::size_t i = 0; i < image.values().size(); ++i)
      image.values()[i] = std::min(image.values()[i], most_of_other * std::exp(sign * 0.5F * logarithm.values()[i]));
  };
  cut(result.source, largest(target), ratio.of_source, -1);
  cut(result.target, largest(source), ratio.of_target, 1);
  return result;
}

}  // namespace mq
