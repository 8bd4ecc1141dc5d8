#include "mq/flow/detail/field_fusion.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/flow/detail/image_warp.h"
#include "mq/flow/detail/scan_lines.h"

namespace mq {
namespace {

/// Differences count up to this, in standard deviations of the signals, as 1.
constexpr float largest_difference = 0.6F;

/// Of each place that is hidden; of both it is 1.
constexpr float hidden_cost = 0.6F;

/// λ and τ, pixels of the scale.
constexpr float change_cost = 0.8F;
constexpr float change_length = 3;

/// Of all fields but the first; and of a motion as long as √area, as where several fit the shortest is meant.
constexpr float other_field = 0.05F;
constexpr float length_cost = 0.2F;

/// The mean over 5 × 5 pixels, as many as there are.
Image<float> around(const Image<float>& values) {
  constexpr int reach = 2;
  const int width = values.width(), height = values.height();
  Image<float> result(width, height, 1);
  parallel_for(
      height,
      [&](std::int64_t row) {
        const int y = int(row), top = std::max(0, y - reach), bottom = std::min(height - 1, y + reach);
        std::vector<float> column(std::size_t(width), 0.0F);
        for (int j = top; j <= bottom; ++j)
          for (int x = 0; x < width; ++x) column[std::size_t(x)] += values(x, j);
        for (int x = 0; x < width; ++x) {
          const int left = std::max(0, x - reach), right = std::min(width - 1, x + reach);
          float sum = 0;
          for (int i = left; i <= right; ++i) sum += column[std::size_t(i)];
          result(x, y) = sum / float((right - left + 1) * (bottom - top + 1));
        }
      },
      row_block);
  return result;
}

}  // namespace

Image<float> misfit(const SignalPair& signals, const Image<float>& field, const FieldClaims& claims) {
  return misfit(signals, field, ways_along(field, 0.5, FlowPath::straight), claims);
}

Image<float> misfit(const SignalPair& signals, const Image<float>& field, const FieldWays& ways,
                    const FieldClaims& claims) {
  const Image<float> source = displaced(signals.source, ways.back), target = displaced(signals.target, ways.forth);
  Image<float> cost(field.width(), field.height(), 1);
  const int channels = source.channels();
  parallel_for(
      field.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < field.width(); ++x) {
          if (const int times = times_hidden(field, ways, claims, x, y); times > 0) {
            cost(x, y) = std::min(1.0F, float(times) * hidden_cost);
            continue;
          }
          float sum = 0;
          for (int c = 0; c < channels; ++c) sum += std::abs(source(x, y, c) - target(x, y, c));
          cost(x, y) = std::min(1.0F, sum / (largest_difference * float(channels)));
        }
      },
      row_block);
  return around(cost);
}

static LabelCosts label_costs(const ImageScale& at, const std::vector<Image<float>>& fields,
                              const FieldClaims& claims) {
  const int width = at.source.width(), height = at.source.height();
  const float side = std::sqrt(float(width) * float(height));
  LabelCosts costs(width, height, int(fields.size()));
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const Image<float> cost = misfit({at.source, at.target}, fields[k], claims);
    for (std::int64_t p = 0; p < cost.pixel_count(); ++p) {
      const float *X = &fields[k].values()[2 * std::size_t(p)], length = std::sqrt(X[0] * X[0] + X[1] * X[1]);
      costs.at(p)[k] = cost.values()[std::size_t(p)] + length_cost * length / side + (k > 0 ? other_field : 0);
    }
  }
  return costs;
}

Image<float> fused(const ImageScale& at, const std::vector<Image<float>>& fields, const FieldClaims& claims) {
  const int width = fields.front().width(), height = fields.front().height(), count = int(fields.size());
  const LabelCosts costs = label_costs(at, fields, claims);
  const LabelCosts sums =
      summed_along_lines(costs, [&](std::int64_t q, const float* last, std::int64_t p, float* next) {
        for (int k = 0; k < count; ++k) {
          const float* here = &fields[std::size_t(k)].values()[2 * std::size_t(p)];
          float least = last[k] + change_cost;
          for (int j = 0; j < count; ++j) {
            const float* there = &fields[std::size_t(j)].values()[2 * std::size_t(q)];
            const float u = here[0] - there[0], v = here[1] - there[1];
            const float change = std::min(1.0F, std::sqrt(u * u + v * v) / change_length);
            least = std::min(least, last[j] + change_cost * change);
          }
          next[k] = least;
        }
      });
  Image<float> result(width, height, 2);
  for (std::int64_t p = 0; p < result.pixel_count(); ++p) {
    const float* sum = sums.at(p);
    const std::size_t best = std::size_t(std::min_element(sum, sum + count) - sum);
    for (std::size_t c = 2 * std::size_t(p); c < 2 * std::size_t(p) + 2; ++c)
      result.values()[c] = fields[best].values()[c];
  }
  return result;
}

}  // namespace mq
