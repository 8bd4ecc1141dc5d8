#include "mq/flow/detail/motion_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/flow/detail/scan_lines.h"

namespace mq {
namespace {

/// Pixels p a side of a square image, and the longest motion, of a side.
constexpr double search_side = 60;
constexpr double longest_part = 0.3;

/// Shorter images are not searched, pixels.
constexpr int least_side = 16;

/// Differences count up to this, in standard deviations of the signals, as 1; places that are hidden as `hidden`.
constexpr float most_difference = 1.0F / 3;
constexpr float hidden = 0.5F;

/// Of pixels that say whose motion those of the images have.
constexpr float surely = 0.3F;

/// Of a neighbour whose motion is the next one or any other.
constexpr float next_motion = 0.2F;
constexpr float other_motion = 0.6F;

/// Of each e times rarer a motion is than the one that most have.
constexpr float rarity = 0.07F;

/// Of all pixels, that a common motion has; and so many are said.
constexpr double least_common = 0.03;
constexpr std::size_t most_peaks = 3;

/// Of labels that are none.
constexpr float never = 1e6F;

/// Motions (x, y) with |x| ≤ across, |y| ≤ down as labels, with a margin of labels that are none.
struct Motions {
  int across, down;
  int stride() const { return 2 * across + 3; }
  int count() const { return stride() * (2 * down + 3); }
  int label(int x, int y) const { return (y + down + 1) * stride() + x + across + 1; }
  int x_of(int label) const { return label % stride() - across - 1; }
  int y_of(int label) const { return label / stride() - down - 1; }
};

/// Whose motion each pixel of both images has, as a label; -1: nobody's.
struct Owners {
  Image<int> source, target;
};

/// Whether a pixel has another motion than this one or the next to it.
bool has_other(const Image<int>& owners, int i, int j, const Motions& motions, int dx, int dy) {
  if (owners.empty()) return false;
  const int label = owners(i, j);
  return label >= 0 && (std::abs(motions.x_of(label) - dx) > 1 || std::abs(motions.y_of(label) - dy) > 1);
}

/// Of one motion at all pixels: what `costs` has in its place for it.
void add_motion(const SignalPair& pair, const Motions& motions, const Owners& owners, int dx, int dy,
                LabelCosts& costs) {
  const int width = costs.width, height = costs.height, channels = pair.source.channels();
  std::vector<float> whole(std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      for (int part = 0; part < 4; ++part) {
        const int i = 2 * x + part % 2, j = 2 * y + part / 2;
        const bool inside = std::min(i - std::abs(dx), j - std::abs(dy)) >= 0 && i + std::abs(dx) < 2 * width &&
                            j + std::abs(dy) < 2 * height;
        const int times = inside ? int(has_other(owners.source, i - dx, j - dy, motions, dx, dy)) +
                                       int(has_other(owners.target, i + dx, j + dy, motions, dx, dy))
                                 : 1;
        if (times > 0) {
          sum += float(times) * hidden;
          continue;
        }
        const float *a = &pair.source(i - dx, j - dy), *b = &pair.target(i + dx, j + dy);
        float difference = 0;
        for (int c = 0; c < channels; ++c) difference += std::abs(a[c] - b[c]);
        sum += std::min(1.0F, difference / (most_difference * float(channels)));
      }
      whole[std::size_t(y) * std::size_t(width) + std::size_t(x)] = sum / 4;
    }
  // The mean over 3 × 3 pixels.
  const auto at = [&](int x, int y) {
    const int i = std::clamp(x, 0, width - 1), j = std::clamp(y, 0, height - 1);
    return whole[std::size_t(j) * std::size_t(width) + std::size_t(i)];
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) sum += at(x + i, y + j);
      costs.at(std::int64_t(y) * width + x)[motions.label(dx, dy)] = sum / 9;
    }
}

LabelCosts costs_of(const SignalPair& pair, const Motions& motions, const Owners& owners) {
  LabelCosts costs(pair.source.width() / 2, pair.source.height() / 2, motions.count());
  std::ranges::fill(costs.values, never);
  parallel_for(
      motions.count(),
      [&](std::int64_t label) {
        const int x = motions.x_of(int(label)), y = motions.y_of(int(label));
        if (std::abs(x) <= motions.across && std::abs(y) <= motions.down)
          add_motion(pair, motions, owners, x, y, costs);
      },
      8);
  return costs;
}

LabelCosts summed(const LabelCosts& costs, const Motions& motions) {
  const int stride = motions.stride(), count = motions.count();
  return summed_along_lines(costs, [=](std::int64_t, const float* last, std::int64_t, float* next) {
    float least = last[0];
    for (int k = 0; k < count; ++k) least = std::min(least, last[k]);
    for (int k = 0; k < stride; ++k) next[k] = next[count - 1 - k] = never;
    for (int k = stride; k < count - stride; ++k) {
      const float beside = std::min(std::min(last[k - 1], last[k + 1]), std::min(last[k - stride], last[k + stride]));
      next[k] = std::min(std::min(last[k], beside + next_motion), least + other_motion);
    }
  });
}

/// The label of least cost; of equal ones that of the shortest motion, and of equally long ones none: -1.
int best_label(const float* costs, const Motions& motions) {
  int best = -1, shortest = 0;
  float least = never / 2;
  bool tied = false;
  for (int k = 0; k < motions.count(); ++k) {
    if (costs[k] > least) continue;
    const int x = motions.x_of(k), y = motions.y_of(k), length = x * x + y * y;
    if (costs[k] < least || length < shortest)
      best = k, shortest = length, tied = false;
    else if (length == shortest)
      tied = true;
    least = costs[k];
  }
  return tied ? -1 : best;
}

std::vector<int> best_labels(const LabelCosts& sums, const Motions& motions) {
  std::vector<int> best(std::size_t(sums.width) * std::size_t(sums.height));
  parallel_for(
      std::int64_t(best.size()), [&](std::int64_t p) { best[std::size_t(p)] = best_label(sums.at(p), motions); }, 64);
  return best;
}

Image<float> field_of(const std::vector<int>& labels, const Motions& motions, int width, int height) {
  Image<float> field(width, height, 2);
  for (std::size_t p = 0; p < labels.size(); ++p)
    if (labels[p] >= 0) {
      field.values()[2 * p] = float(motions.x_of(labels[p]));
      field.values()[2 * p + 1] = float(motions.y_of(labels[p]));
    }
  return field;
}

/// How many pixels have each motion, twice, and those next to it.
std::vector<int> counts_of(const std::vector<int>& labels, const Motions& motions) {
  std::vector<int> counts(std::size_t(motions.count()));
  for (const int label : labels) {
    if (label < 0) continue;
    counts[std::size_t(label)] += 2;
    for (const int step : {1, motions.stride()})
      for (const int beside : {label - step, label + step}) ++counts[std::size_t(beside)];
  }
  return counts;
}

/// What each motion costs for being rare.
std::vector<float> rarities(const std::vector<int>& labels, const Motions& motions) {
  const std::vector<int> counts = counts_of(labels, motions);
  const int most = *std::ranges::max_element(counts);
  std::vector<float> costs;
  for (const int count : counts) costs.push_back(rarity * float(std::log((most + 1.0) / (count + 1.0))));
  return costs;
}

/// The motions that most have and none next to them has more often; of equally many none.
std::vector<std::array<float, 2>> most_common(const std::vector<int>& labels, const Motions& motions) {
  const std::vector<int> counts = counts_of(labels, motions);
  std::vector<int> peaks;
  for (int k = motions.stride() + 1; k < motions.count() - motions.stride() - 1; ++k) {
    const int count = counts[std::size_t(k)];
    bool highest = double(count) > 2 * least_common * double(labels.size());
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if (i != 0 || j != 0) highest = highest && count > counts[std::size_t(k + j * motions.stride() + i)];
    if (highest) peaks.push_back(k);
  }
  std::ranges::stable_sort(peaks, std::greater(), [&](int k) { return counts[std::size_t(k)]; });
  std::vector<std::array<float, 2>> result;
  for (std::size_t i = 0; i < peaks.size() && i < most_peaks; ++i)
    result.push_back({float(motions.x_of(peaks[i])), float(motions.y_of(peaks[i]))});
  return result;
}

/// Of places that are shown at several pixels those of least cost.
Owners owners_of(const std::vector<int>& labels, const Motions& motions, const LabelCosts& costs) {
  const int width = 2 * costs.width, height = 2 * costs.height;
  Owners owners{Image<int>(width, height, 1, -1), Image<int>(width, height, 1, -1)};
  Image<float> source(width, height, 1, surely), target = source;
  const auto claim = [&](Image<int>& owner, Image<float>& least, int i, int j, int label, float cost) {
    if (i < 0 || j < 0 || i >= width || j >= height || !(cost < least(i, j))) return;
    least(i, j) = cost;
    owner(i, j) = label;
  };
  for (std::int64_t p = 0; p < std::ssize(labels); ++p) {
    const int label = labels[std::size_t(p)];
    if (label < 0) continue;
    const int dx = motions.x_of(label), dy = motions.y_of(label);
    for (int part = 0; part < 4; ++part) {
      const int i = 2 * int(p % costs.width) + part % 2, j = 2 * int(p / costs.width) + part / 2;
      claim(owners.source, source, i - dx, j - dy, label, costs.at(p)[label]);
      claim(owners.target, target, i + dx, j + dy, label, costs.at(p)[label]);
    }
  }
  return owners;
}

}  // namespace

SearchedMotions searched_motions(const SignalPair& signals) {
  const int whole_width = signals.source.width(), whole_height = signals.source.height();
  if (std::min(whole_width, whole_height) < least_side) return {};
  const double spacing =
      std::max(2.0, std::sqrt(double(signals.source.pixel_count())) / search_side);
  const int width = int(std::ceil(whole_width / spacing)), height = int(std::ceil(whole_height / spacing));
  const auto small = [&](const Image<float>& signal) {
    return at_scale(signal, spacing / 2, 2 * width, 2 * height);
  };
  const SignalPair pair{small(signals.source), small(signals.target)};
  const Motions motions{int(longest_part * width), int(longest_part * height)};
  LabelCosts plain = costs_of(pair, motions, {});
  const std::vector<int> free = best_labels(summed(plain, motions), motions);
  std::vector<int> common = free;
  LabelCosts costs = plain;
  for (int round = 0; round < 3; ++round) {
    const std::vector<float> rare = rarities(common, motions);
    for (std::int64_t p = 0; p < std::ssize(free); ++p)
      for (int k = 0; k < costs.count; ++k) costs.at(p)[k] += rare[std::size_t(k)];
    common = best_labels(summed(costs, motions), motions);
    if (round < 2) costs = costs_of(pair, motions, owners_of(common, motions, plain));
  }
  return {field_of(free, motions, width, height), field_of(common, motions, width, height),
          most_common(common, motions)};
}

}  // namespace mq
