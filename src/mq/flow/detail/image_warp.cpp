/// dΦ/dt = X(Φ), Φ(p, 0) = p: thesis 4.4.3. On a mesh the field is constant on triangles and paths
/// are followed exactly; here it is bilinear, so that warped images change smoothly with it and a
/// few steps are as exact as the field is.

#include "mq/flow/detail/image_warp.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

using Shift = std::array<float, 2>;

void require_field(const Image<float>& field) {
  require(field.channels() == 2 && !field.empty(),
          fmt::format("a field has two values per pixel; found {} x {} pixels with {}",
                      field.width(), field.height(), field.channels()));
}

/// X at a place, bilinear; beyond the border as at its nearest place.
Shift field_at(const Image<float>& field, float column, float row) {
  const float x = std::clamp(column, 0.0F, float(field.width() - 1));
  const float y = std::clamp(row, 0.0F, float(field.height() - 1));
  const int i = std::min(int(x), std::max(0, field.width() - 2));
  const int j = std::min(int(y), std::max(0, field.height() - 2));
  const float s = x - float(i), t = y - float(j);
  const int right = i + 1 < field.width() ? 2 : 0;
  const int down = j + 1 < field.height() ? 2 * field.width() : 0;
  const float* p = &field(i, j);
  Shift value;
  for (int c = 0; c < 2; ++c) {
    const float above = p[c] + s * (p[c + right] - p[c]);
    const float below = p[c + down] + s * (p[c + down + right] - p[c + down]);
    value[c] = above + t * (below - above);
  }
  return value;
}

/// The largest change of X from a pixel to the next.
double steepest(const Image<float>& field) {
  std::vector<double> most(std::size_t(field.height()), 0.0);
  parallel_for(
      field.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        const auto change = [&](int x, int to_x, int to_y) {
          const double u = double(field(to_x, to_y, 0)) - field(x, y, 0);
          const double v = double(field(to_x, to_y, 1)) - field(x, y, 1);
          return u * u + v * v;
        };
        for (int x = 0; x < field.width(); ++x) {
          double& largest = most[std::size_t(y)];
          if (x + 1 < field.width()) largest = std::max(largest, change(x, x + 1, y));
          if (y + 1 < field.height()) largest = std::max(largest, change(x, x, y + 1));
        }
      },
      row_block);
  return std::sqrt(*std::ranges::max_element(most));
}

/// The four weights of Keys' kernel at the pixels −1, 0, 1, 2 for a place s past pixel 0.
std::array<float, 4> cubic_weights(float s) {
  const float s2 = s * s, s3 = s2 * s;
  return {-0.5F * s3 + s2 - 0.5F * s, 1.5F * s3 - 2.5F * s2 + 1, -1.5F * s3 + 2 * s2 + 0.5F * s,
          0.5F * s3 - 0.5F * s2};
}

/// The four pixels along one axis and their weights; beyond the border its pixel again.
struct Taps {
  std::array<int, 4> at;
  std::array<float, 4> weight;
};
Taps taps(float place, int size) {
  // Beyond the border everything is as on it, however far.
  const float clamped = std::clamp(place, -2.0F, float(size + 1));
  const int first = int(std::floor(clamped));
  Taps taps;
  taps.weight = cubic_weights(clamped - float(first));
  for (int k = 0; k < 4; ++k) taps.at[k] = std::clamp(first - 1 + k, 0, size - 1);
  return taps;
}

/// `Channels` of the signal's, from `first` on.
template <int Channels, Overshoot overshoot>
void sample_cubic(const Image<float>& signal, int first, const Taps& across, const Taps& down,
                  float* values) {
  std::array<float, Channels> sum{}, low, high;
  low.fill(INFINITY);
  high.fill(-INFINITY);
  for (int j = 0; j < 4; ++j) {
    const float* line = &signal(0, down.at[j], first);
    std::array<float, Channels> part{};
    for (int i = 0; i < 4; ++i) {
      const float* pixel = line + across.at[i] * signal.channels();
      for (int c = 0; c < Channels; ++c) part[c] += across.weight[i] * pixel[c];
      if constexpr (overshoot == Overshoot::cut)
        for (int c = 0; c < Channels; ++c) {
          low[c] = std::min(low[c], pixel[c]);
          high[c] = std::max(high[c], pixel[c]);
        }
    }
    for (int c = 0; c < Channels; ++c) sum[c] += down.weight[j] * part[c];
  }
  for (int c = 0; c < Channels; ++c)
    values[c] = overshoot == Overshoot::cut ? std::clamp(sum[c], low[c], high[c]) : sum[c];
}

template <Overshoot overshoot>
void displace(const Image<float>& signal, const Image<float>& displacement, Image<float>& result) {
  const int channels = signal.channels();
  parallel_for(
      result.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < result.width(); ++x) {
          const Taps across = taps(float(x) + displacement(x, y, 0), signal.width());
          const Taps down = taps(float(y) + displacement(x, y, 1), signal.height());
          float* to = &result(x, y);
          int c = 0;
          for (; c + 3 <= channels; c += 3)
            sample_cubic<3, overshoot>(signal, c, across, down, to + c);
          for (; c < channels; ++c) sample_cubic<1, overshoot>(signal, c, across, down, to + c);
        }
      },
      row_block);
}

}  // namespace

Image<float> displacement(const Image<float>& field, double time, FlowPath path) {
  require_field(field);
  Image<float> result(field.width(), field.height(), 2);
  const bool straight = path == FlowPath::straight;
  const double turns = straight ? 0 : std::abs(time) * steepest(field);
  const int steps = int(std::clamp(std::ceil(turns), 1.0, 4.0));
  const float h = float(time / steps);
  parallel_for(
      field.height(),
      [&](std::int64_t row) {
        for (int x = 0; x < field.width(); ++x) {
          const auto start = field.pixel(x, int(row));
          const auto to = result.pixel(x, int(row));
          if (straight) {
            for (int c = 0; c < 2; ++c) to[c] = h * start[c];
            continue;
          }
          // The way gone, not the place, is summed: it has fewer digits to lose.
          Shift way = {0, 0};
          for (int n = 0; n < steps; ++n) {
            const auto slope = [&](float part, const Shift& along) {
              return field_at(field, float(x) + (way[0] + part * along[0]),
                              float(row) + (way[1] + part * along[1]));
            };
            const Shift k1 = n == 0 ? Shift{start[0], start[1]} : slope(0, way);
            const Shift k2 = slope(h / 2, k1), k3 = slope(h / 2, k2), k4 = slope(h, k3);
            for (int c = 0; c < 2; ++c) way[c] += h / 6 * (k1[c] + 2 * (k2[c] + k3[c]) + k4[c]);
          }
          std::ranges::copy(way, to.begin());
        }
      },
      row_block);
  return result;
}

Image<float> displaced(const Image<float>& signal, const Image<float>& displacement,
                       Overshoot overshoot) {
  require_field(displacement);
  require(!signal.empty(), "there are no pixels to move");
  Image<float> result(displacement.width(), displacement.height(), signal.channels());
  if (overshoot == Overshoot::cut)
    displace<Overshoot::cut>(signal, displacement, result);
  else
    displace<Overshoot::kept>(signal, displacement, result);
  return result;
}

Image<float> advected(const Image<float>& signal, const Image<float>& field, double time,
                      FlowPath path) {
  return displaced(signal, displacement(field, time, path));
}

Image<float> resized_field(const Image<float>& field, int width, int height) {
  require_field(field);
  if (width == field.width() && height == field.height()) return field;
  Image<float> result(width, height, 2);
  const float across = float(field.width()) / float(width);
  const float down = float(field.height()) / float(height);
  parallel_for(
      height,
      [&](std::int64_t row) {
        for (int x = 0; x < width; ++x) {
          const Shift v =
              field_at(field, (float(x) + 0.5F) * across - 0.5F, (float(row) + 0.5F) * down - 0.5F);
          result(x, int(row), 0) = v[0] / across;
          result(x, int(row), 1) = v[1] / down;
        }
      },
      row_block);
  return result;
}

}  // namespace mq
