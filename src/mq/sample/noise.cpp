#include "mq/sample/noise.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "mq/base/random.h"

namespace mq {
namespace {

/// Towards the edges of a cube, of which there are twelve; four come twice.
constexpr double gradients[16][3] = {
    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
    {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}, {1, 1, 0}, {0, -1, 1}, {-1, 1, 0}, {0, -1, -1}};

double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

}  // namespace

Noise::Noise(std::uint64_t seed) {
  const Random random(seed);
  std::array<std::uint8_t, 256> values;
  std::iota(values.begin(), values.end(), std::uint8_t(0));
  for (std::size_t i = 255; i > 0; --i) std::swap(values[i], values[random.bits(i) % (i + 1)]);
  for (std::size_t i = 0; i < 512; ++i) shuffled_[i] = values[i % 256];
}

double Noise::operator()(const Vector3& point) const {
  const double fx = std::floor(point.x()), fy = std::floor(point.y()), fz = std::floor(point.z());
  const double x = point.x() - fx, y = point.y() - fy, z = point.z() - fz;
  const auto lattice = [](double f) { return std::size_t(std::int64_t(f) & 255); };
  const std::size_t i = lattice(fx), j = lattice(fy), k = lattice(fz);
  const auto corner = [&](std::size_t a, std::size_t b, std::size_t c) {
    const std::size_t hash = shuffled_[shuffled_[shuffled_[i + a] + j + b] + k + c];
    const double* g = gradients[hash & 15];
    return g[0] * (x - double(a)) + g[1] * (y - double(b)) + g[2] * (z - double(c));
  };
  const double u = fade(x), v = fade(y), w = fade(z);
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const auto along_x = [&](std::size_t b, std::size_t c) {
    return mix(corner(0, b, c), corner(1, b, c), u);
  };
  return mix(mix(along_x(0, 0), along_x(1, 0), v), mix(along_x(0, 1), along_x(1, 1), v), w);
}

double Noise::octaves(const Vector3& point, int count) const {
  Eigen::Matrix3d turn;  // a rotation by the columns of a quaternion without symmetry, times 2
  turn << 0.00, 1.60, 1.20, -1.60, 0.72, -0.96, -1.20, -0.96, 1.28;
  Vector3 p = point;
  double sum = 0, weight = 0.5;
  for (int k = 0; k < count; ++k, weight /= 2) {
    sum += weight * (*this)(p);
    p = turn * p + Vector3(17.3, -9.1, 31.7);
  }
  return 1.6 * sum;
}

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace mq
