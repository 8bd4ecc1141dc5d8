// Unknowns θ = (a, b, k), of a view v first a_v, then b_v of each channel. With ℓ of a patch at its least squares, a step
// of θ solves Σ_p Dᵀ W P D δθ = Σ_p Dᵀ W r − (terms that hold), rows D = (ℓ + f, e_c, a φ) by a_v, b_vc and k, and
// P = 1 − a aᵀ W / (aᵀ W a) the projection that eliminates δℓ (a here: of the views of the patch).

#include "mq/views/tones.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/views/detail/readings.h"

namespace mq {
namespace {

constexpr int channels = 3;
constexpr double hold = 0.3, hold_contrast = 1;

/// What a reading is, and by channel where it lies under the model as it is.
struct Reading {
  int view;
  double weight;
  std::array<double, channels> x;  ///< log c − m
  Eigen::Vector2d basis;
};

class ToneModel {
 public:
  ToneModel(const Observations& observations, int views) : views_(views), readings_(std::size_t(observations.patches())) {
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    double weights = 0;
    for (int p = 0; p < observations.patches(); ++p) {
      for (const Observation& o : observations.of(p)) {
        if (!tells_exposure(o)) continue;
        Reading reading{o.view, double(o.quality) * o.quality, {}, falloff_bases(o.radius)};
        for (std::size_t c = 0; c < channels; ++c) reading.x[c] = std::log(double(o.colour[c]));
        readings_[std::size_t(p)].push_back(reading);
      }
      if (readings_[std::size_t(p)].size() < 2) readings_[std::size_t(p)].clear();
      for (const Reading& r : readings_[std::size_t(p)])
        sum += r.weight * Eigen::Array3d(r.x[0], r.x[1], r.x[2]), weights += r.weight;
    }
    if (weights > 0) mean_ = sum / weights;
    counts_ = Eigen::VectorXd::Zero(views);
    for (std::vector<Reading>& patch : readings_)
      for (Reading& r : patch) {
        counts_[r.view] += 1;
        for (int c = 0; c < channels; ++c) r.x[std::size_t(c)] -= mean_[c];
      }
    theta_ = Eigen::VectorXd::Zero(size());
    for (int v = 0; v < views; ++v) theta_[at_a(v)] = 1;
  }

  void begin_with(const Exposures& found) {
    for (int v = 0; v < views_; ++v)
      for (int c = 0; c < channels; ++c)
        theta_[at_b(v, c)] = -std::log(double(found.gains[std::size_t(v)][std::size_t(c)]));
    theta_[at_k()] = found.falloff.k1, theta_[at_k() + 1] = found.falloff.k2;
  }

  /// A Gauss–Newton step; weights are robust with the scale of the residuals as they are.
  void step() {
    const double scale = robust_scale();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size(), size());
    Eigen::VectorXd b = Eigen::VectorXd::Zero(size());
    for (const std::vector<Reading>& patch : readings_)
      for (int c = 0; c < channels && !patch.empty(); ++c) add(patch, c, scale, A, b);
    for (int i = 0; i < size(); ++i) {
      const bool contrast = i < at_k() && i % (1 + channels) == 0;
      A(i, i) += contrast ? hold_contrast : hold;
      b[i] -= contrast ? hold_contrast * (theta_[i] - 1) : hold * theta_[i];
    }
    const Eigen::MatrixXd both = A.selfadjointView<Eigen::Lower>();
    theta_ += both.ldlt().solve(b);
    settle();
  }

  Exposures found() const {
    Exposures result = no_exposures(views_);
    for (int v = 0; v < views_; ++v) {
      if (counts_[v] == 0) continue;
      const double exponent = 1 / theta_[at_a(v)];
      result.exponents[std::size_t(v)] = float(exponent);
      for (int c = 0; c < channels; ++c)
        result.gains[std::size_t(v)][std::size_t(c)] =
            float(std::exp(mean_[c] - exponent * (mean_[c] + theta_[at_b(v, c)])));
    }
    result.falloff = {theta_[at_k()], theta_[at_k() + 1]};
    return result;
  }

 private:
  int size() const { return (1 + channels) * views_ + 2; }
  int at_a(int view) const { return (1 + channels) * view; }
  int at_b(int view, int channel) const { return (1 + channels) * view + 1 + channel; }
  int at_k() const { return (1 + channels) * views_; }

  double contrast(const Reading& r) const { return theta_[at_a(r.view)]; }
  double falloff(const Reading& r) const { return r.basis.dot(theta_.tail<2>()); }
  /// ℓ as one reading says.
  double evened(const Reading& r, int c) const {
    return (r.x[std::size_t(c)] - theta_[at_b(r.view, c)]) / contrast(r) - falloff(r);
  }

  /// a (ℓ_r − median of the patch) of each reading.
  std::vector<double> deviations(const std::vector<Reading>& patch, int c) const {
    std::vector<double> levels;
    for (const Reading& r : patch) levels.push_back(evened(r, c));
    std::vector<double> result = levels;
    const double level = median_of(levels);
    for (std::size_t k = 0; k < patch.size(); ++k) result[k] = contrast(patch[k]) * (result[k] - level);
    return result;
  }

  double robust_scale() const {
    constexpr double least = 0.05;
    std::vector<double> sizes;
    for (const std::vector<Reading>& patch : readings_)
      for (int c = 0; c < channels && !patch.empty(); ++c)
        for (const double d : deviations(patch, c)) sizes.push_back(std::abs(d));
    return sizes.empty() ? least : std::max(least, 2 * median_of(sizes));
  }

  /// Adds a channel of a patch to the lower triangle of the equations.
  void add(const std::vector<Reading>& patch, int c, double scale, Eigen::MatrixXd& A, Eigen::VectorXd& b) const {
    const std::size_t count = patch.size();
    const std::vector<double> away = deviations(patch, c);
    std::vector<double> w(count);
    double all = 0, level = 0;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      const double a = contrast(patch[k]);
      w[k] = patch[k].weight / (1 + std::pow(away[k] / scale, 2));
      all += w[k] * a * a, level += w[k] * a * a * evened(patch[k], c), middle += w[k] * a * a * patch[k].basis;
    }
    level /= all, middle /= all;
    for (std::size_t k = 0; k < count; ++k) {
      const Reading& r = patch[k];
      const double a = contrast(r), slope = level + falloff(r), residual = a * (evened(r, c) - level);
      const int of_a = at_a(r.view), of_b = at_b(r.view, c);
      const Eigen::Vector2d basis = a * (r.basis - middle);
      A(of_a, of_a) += w[k] * slope * slope, A(of_b, of_a) += w[k] * slope, A(of_b, of_b) += w[k];
      b[of_a] += w[k] * slope * residual, b[of_b] += w[k] * residual;
      A.block<2, 1>(at_k(), of_a) += w[k] * slope * basis;
      A.block<2, 1>(at_k(), of_b) += w[k] * basis;
      A.bottomRightCorner<2, 2>() += w[k] * basis * basis.transpose();
      b.tail<2>() += w[k] * residual * basis;
      for (std::size_t m = 0; m < count; ++m) {
        const Reading& other = patch[m];
        if (other.view > r.view) continue;
        const double shared = w[k] * a * w[m] * contrast(other) / all;
        const double other_slope = level + falloff(other);
        const int other_a = at_a(other.view), other_b = at_b(other.view, c);
        A(of_a, other_a) -= shared * slope * other_slope;
        A(of_b, other_b) -= shared;
        A(of_b, other_a) -= shared * other_slope;
        if (other.view < r.view) A(of_a, other_b) -= shared * slope;
      }
    }
  }

  /// Within limits, and with what data do not tell as it is to be.
  void settle() {
    const double all = counts_.sum();
    if (!(all > 0)) return;
    double mean = 0;
    for (int v = 0; v < views_; ++v) {
      double& a = theta_[at_a(v)];
      a = counts_[v] > 0 ? std::clamp(a, 0.5, 2.0) : 1;
      mean += counts_[v] * a / all;
    }
    for (int v = 0; v < views_; ++v)
      if (counts_[v] > 0) theta_[at_a(v)] /= mean;
    theta_.tail<2>() *= mean;
    for (int c = 0; c < channels; ++c) {
      double middle = 0;
      for (int v = 0; v < views_; ++v) middle += counts_[v] * theta_[at_b(v, c)] / all;
      for (int v = 0; v < views_; ++v)
        theta_[at_b(v, c)] = counts_[v] > 0 ? theta_[at_b(v, c)] - theta_[at_a(v)] * middle : 0;
    }
  }

  int views_;
  std::vector<std::vector<Reading>> readings_;  ///< per patch; none where fewer than two tell anything
  Eigen::Array3d mean_ = Eigen::Array3d::Zero();
  Eigen::VectorXd counts_, theta_;
};

}  // namespace

Exposures tones(const Observations& observations, int views) {
  constexpr int rounds = 10;
  ToneModel model(observations, views);
  model.begin_with(exposures(observations, views));
  for (int round = 0; round < rounds; ++round) model.step();
  return model.found();
}

}  // namespace mq
