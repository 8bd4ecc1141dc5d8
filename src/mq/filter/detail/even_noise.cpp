#include "mq/filter/detail/even_noise.h"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// a + r v that is nearest to the deviations, in parts of these; a at least an eighth of that where it is darkest.
std::pair<double, double> line_through(const NoiseCurve& curve) {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < curve.brightness.size(); ++k) {
    const double deviation = curve.deviation(Eigen::Index(k), 0);
    const Eigen::Vector2d row = Eigen::Vector2d(1, curve.brightness[k]) / deviation;
    A += row * row.transpose();
    b += row;
  }
  const Eigen::Vector2d line = A.ldlt().solve(b);
  return {std::max(line[0], curve.deviation(0, 0) / 8), line[1]};
}

/// But for a quarter of the places, where classes of brightness may hold dark and bright blocks.
bool is_near(const NoiseCurve& curve, double a, double r) {
  constexpr double most = 1.0 / 3, most_places = 0.25;
  const auto far = std::ranges::count_if(std::views::iota(std::size_t(0), curve.brightness.size()), [&](std::size_t k) {
    return std::abs((a + r * curve.brightness[k]) / curve.deviation(Eigen::Index(k), 0) - 1) > most;
  });
  return double(far) <= most_places * double(curve.brightness.size());
}

}  // namespace

std::vector<NoiseCurve> growing_noise(const ChartWindows& windows, const Signal& psi, const std::vector<double>& noise,
                                      const Progress& progress) {
  std::vector<NoiseCurve> curves(noise.size());
  for (std::size_t c = 0; c < noise.size(); ++c) {
    progress.at(double(c) / double(noise.size()));
    if (noise[c] == 0) continue;
    curves[c] = noise_curve(windows, psi.col(Eigen::Index(c)));
    if (!curves[c].grows()) return {};
  }
  return curves;
}

std::optional<EvenNoise> EvenNoise::of(const std::vector<NoiseCurve>& curves, const Signal& psi) {
  EvenNoise scale;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    scale.a_.push_back(0);
    scale.r_.push_back(0);
    if (curves[c].is_empty()) continue;
    const auto [a, r] = line_through(curves[c]);
    const double least = psi.col(Eigen::Index(c)).minCoeff();
    if (!(r > 0) || least < -0.5 * a / r || !is_near(curves[c], a, r)) return {};
    scale.a_.back() = a;
    scale.r_.back() = r;
  }
  return scale;
}

Signal EvenNoise::there(const Signal& psi) const {
  Signal z = psi;
  parallel_for(psi.rows(), [&](std::int64_t k) {
    for (std::size_t c = 0; c < a_.size(); ++c)
      if (a_[c] > 0) z(k, Eigen::Index(c)) = std::log1p(r_[c] * psi(k, Eigen::Index(c)) / a_[c]) / r_[c];
  });
  return z;
}

Signal EvenNoise::back(const Signal& z, const Signal& before, const std::vector<double>& noise,
                       const Signal& psi) const {
  Signal result = psi;
  parallel_for(psi.rows(), [&](std::int64_t k) {
    for (std::size_t c = 0; c < a_.size(); ++c) {
      const auto at = Eigen::Index(c);
      if (a_[c] == 0 || z(k, at) == before(k, at)) continue;
      const double lost = r_[c] * noise[c] * noise[c] / 2;
      result(k, at) = std::max(0.0, a_[c] / r_[c] * std::expm1(r_[c] * (z(k, at) + lost)));
    }
  });
  return result;
}

}  // namespace mq
