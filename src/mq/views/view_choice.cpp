#include "mq/views/view_choice.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/views/detail/neighbours.h"
#include "mq/views/detail/places.h"
#include "mq/views/detail/readings.h"
#include "mq/views/smooth_labels.h"

namespace mq {

namespace {

constexpr double print_floor = 0.02;  ///< differences between dark places are noise
constexpr double print_steps = 32;    ///< of a byte, in 1

}  // namespace

void Print::put(int place, double brightness, double mean) {
  const auto logarithm = [](double light) { return std::log(std::max(light, 0.0) + print_floor); };
  const double steps = std::round(print_steps * (logarithm(brightness) - logarithm(mean)));
  values[std::size_t(place)] = std::int8_t(std::clamp(steps, -127.0, 127.0));
}

std::optional<float> Print::at(int place) const {
  const std::int8_t value = values[std::size_t(place)];
  if (value == none) return std::nullopt;
  return float(value / print_steps);
}

Observations Observations::gather(int patches, std::span<const std::vector<OfPatch>> views) {
  Observations result;
  result.offsets.assign(std::size_t(patches) + 1, 0);
  for (const std::vector<OfPatch>& view : views)
    for (const OfPatch& one : view) ++result.offsets[one.patch + 1];
  for (int p = 0; p < patches; ++p) result.offsets[p + 1] += result.offsets[p];
  result.all.resize(result.offsets.back());
  std::vector<std::int64_t> next(result.offsets.begin(), result.offsets.end() - 1);
  for (const std::vector<OfPatch>& view : views)
    for (const OfPatch& one : view) result.all[next[one.patch]++] = one.observation;
  return result;
}

std::int64_t Observations::number_of(int patch, int view) const {
  const auto views = of(patch);
  const auto at = std::ranges::lower_bound(views, view, {}, &Observation::view);
  return at != views.end() && at->view == view ? offsets[patch] + (at - views.begin()) : -1;
}

bool Observations::all_rejected(int patch) const {
  const auto views = of(patch);
  return !views.empty() && std::ranges::all_of(views, &Observation::rejected);
}

// ---------------------------------------------------------------------------------------- exposures

namespace {

/// What observations on one patch say.
struct Readings {
  std::vector<double> x;  ///< logarithms
  std::vector<double> w;
  std::vector<int> view;
  std::vector<Eigen::Vector2d> basis;

  /// Those that `logarithm` has a value for.
  template <class Logarithm>
  Readings(std::span<const Observation> observations, const Logarithm& logarithm) {
    for (const Observation& o : observations) {
      if (!tells_exposure(o)) continue;
      x.push_back(logarithm(o));
      w.push_back(double(o.quality) * o.quality);
      view.push_back(o.view);
      basis.push_back(falloff_bases(o.radius));
    }
  }
};

/// g of all views, and k where it is asked for (else 0), by the normal equations from which the L_p are eliminated:
/// with weights w, rows d = (e_v, basis) and W = Σw of a patch, Σ_p Σ w (d − d̄)(d − d̄)ᵀ θ = Σ_p Σ w (d − d̄)(x − x̄).
template <class Logarithm>
Eigen::VectorXd fitted_exposures(const Observations& observations, int views, bool with_falloff,
                                 const Logarithm& logarithm) {
  constexpr int rounds = 10;
  constexpr double scale = 0.05, ridge = 0.3;
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(views + 2), counts = Eigen::VectorXd::Zero(views);
  for (int round = 0; round < rounds; ++round) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(views + 2, views + 2);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(views + 2);
    counts.setZero();
    for (int p = 0; p < observations.patches(); ++p) {
      Readings of(observations.of(p), logarithm);
      const std::size_t count = of.x.size();
      if (count < 2) continue;
      // Residuals from the median of what θ says now.
      std::vector<double> residuals(count);
      for (std::size_t k = 0; k < count; ++k)
        residuals[k] = of.x[k] - theta[of.view[k]] - of.basis[k].dot(theta.tail<2>());
      std::vector<double> levels = residuals;
      const double level = median_of(levels);
      double sum = 0, mean = 0;
      Eigen::Vector2d middle = Eigen::Vector2d::Zero();
      for (std::size_t k = 0; k < count; ++k) {
        if (round > 0) of.w[k] /= 1 + std::pow((residuals[k] - level) / scale, 2);
        sum += of.w[k], mean += of.w[k] * of.x[k], middle += of.w[k] * of.basis[k];
      }
      mean /= sum, middle /= sum;
      for (std::size_t k = 0; k < count; ++k) {
        const int v = of.view[k];
        const Eigen::Vector2d basis = with_falloff ? Eigen::Vector2d(of.basis[k] - middle) : Eigen::Vector2d(0, 0);
        counts[v] += 1;
        A(v, v) += of.w[k];
        b[v] += of.w[k] * (of.x[k] - mean);
        A.block<1, 2>(v, views) += of.w[k] * basis.transpose();
        A.bottomRightCorner<2, 2>() += of.w[k] * basis * basis.transpose();
        b.tail<2>() += of.w[k] * (of.x[k] - mean) * basis;
        for (std::size_t m = 0; m < count; ++m) A(v, of.view[m]) -= of.w[k] * of.w[m] / sum;
      }
    }
    A.block(views, 0, 2, views) = A.block(0, views, views, 2).transpose().eval();
    A.diagonal().array() += ridge;
    theta = A.ldlt().solve(b);
    if (counts.sum() > 0) theta.head(views).array() -= counts.dot(theta.head(views)) / counts.sum();
    for (int v = 0; v < views; ++v)
      if (counts[v] == 0) theta[v] = 0;
  }
  return theta;
}

}  // namespace

double Falloff::correction(double radius) const { return std::exp(-falloff_bases(radius).dot(Eigen::Vector2d(k1, k2))); }

LightColour Exposures::evened(int view, double radius, const LightColour& light) const {
  LightColour result = light;
  for (std::size_t c = 0; c < 3; ++c) {
    if (exponents[std::size_t(view)] != 1) result[c] = std::pow(std::max(result[c], 0.0F), exponents[std::size_t(view)]);
    result[c] *= gains[std::size_t(view)][c] * float(falloff.correction(radius));
  }
  return result;
}

Exposures exposures(const Observations& observations, int views) {
  Exposures result = no_exposures(views);
  const Eigen::VectorXd all = fitted_exposures(observations, views, true, [](const Observation& o) {
    return (std::log(double(o.colour[0])) + std::log(double(o.colour[1])) + std::log(double(o.colour[2]))) / 3;
  });
  result.falloff = {all[views], all[views + 1]};
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::VectorXd g = fitted_exposures(observations, views, false, [&](const Observation& o) {
      return std::log(double(o.colour[c]) * result.falloff.correction(o.radius));
    });
    for (int v = 0; v < views; ++v) result.gains[std::size_t(v)][c] = float(std::exp(-g[v]));
  }
  return result;
}

Exposures no_exposures(int views) {
  return {std::vector<LightColour>(std::size_t(views), LightColour{1, 1, 1}),
          std::vector<float>(std::size_t(views), 1.0F),
          {}};
}

void even_out(const Exposures& exposures, Observations& observations) {
  for (Observation& o : observations.all) o.colour = exposures.evened(o.view, o.radius, o.colour);
}

// --------------------------------------------------------------------------------------------- choice

namespace {

/// What a quarter of those that are not rejected surpass; 0 of nothing.
double usual_detail(std::span<const Observation> views) {
  std::vector<float> details;
  for (const Observation& o : views)
    if (!o.rejected) details.push_back(o.detail);
  if (details.empty()) return 0;
  const auto quarter = details.begin() + (3 * std::ssize(details) - 1) / 4;
  std::nth_element(details.begin(), quarter, details.end());
  return *quarter;
}

}  // namespace

void pool_details(const Patches& patches, Observations& observations, int rounds) {
  require(patches.count() == observations.patches(), "observations of these patches are needed");
  struct Sum {
    float own = 0, usual = 0;  ///< squares
  };
  std::vector<Sum> sums(observations.all.size());
  std::vector<float> usual(std::size_t(patches.count()), 0.0F);
  parallel_for(
      patches.count(),
      [&](std::int64_t p) {
        const float m = usual[std::size_t(p)] = float(usual_detail(observations.of(int(p))));
        for (std::int64_t k = observations.offsets[p]; k < observations.offsets[p + 1]; ++k) {
          const Observation& o = observations.all[std::size_t(k)];
          if (!o.rejected) sums[std::size_t(k)] = {o.detail * o.detail, m * m};
        }
      },
      256);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Sum> next = sums;
    const auto add = [](const Sum& from, float side, Sum& to) {
      to.own += side * from.own, to.usual += side * from.usual;
    };
    for_each_pair(patches, observations, [&](std::size_t k, std::size_t beside, float side) {
      add(sums[beside], side, next[k]), add(sums[k], side, next[beside]);
    });
    sums = std::move(next);
  }
  for (int p = 0; p < patches.count(); ++p)
    for (std::int64_t k = observations.offsets[p]; k < observations.offsets[p + 1]; ++k)
      if (const Sum& sum = sums[std::size_t(k)]; sum.usual > 0)
        observations.all[std::size_t(k)].detail = usual[std::size_t(p)] * std::sqrt(sum.own / sum.usual);
}

std::vector<float> sharpness(std::span<const Observation> views) {
  const double usual = usual_detail(views);
  std::vector<float> sharp;
  for (const Observation& o : views)
    sharp.push_back(usual > 0 ? float(std::clamp(o.detail / usual, 0.05, 1.0)) : 1);
  return sharp;
}

std::vector<float> relative_qualities(std::span<const Observation> views) {
  std::vector<float> qualities = sharpness(views);
  float best = 0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    qualities[k] *= views[k].quality;
    if (!views[k].rejected) best = std::max(best, qualities[k]);
  }
  for (float& quality : qualities) quality = best > 0 ? std::min(quality / best, 1.0F) : 1;
  return qualities;
}

std::vector<float> print_deviations(std::span<const Observation> views) {
  constexpr float most_contrast = 2;
  const std::vector<float> qualities = relative_qualities(views);
  std::array<float, Print::places> mean{};
  for (int place = 0; place < Print::places; ++place) {
    float weight = 0;
    for (std::size_t k = 0; k < views.size(); ++k)
      if (const auto value = views[k].print.at(place); value && !views[k].rejected)
        mean[std::size_t(place)] += qualities[k] * *value, weight += qualities[k];
    if (weight > 0) mean[std::size_t(place)] /= weight;
  }
  std::vector<float> deviations;
  for (const Observation& o : views) {
    float own = 0, both = 0, of_mean = 0, count = 0;
    for (int place = 0; place < Print::places; ++place)
      if (const auto value = o.print.at(place)) {
        const float m = mean[std::size_t(place)];
        own += *value * *value, both += *value * m, of_mean += m * m, ++count;
      }
    const float contrast = of_mean > 0 ? std::clamp(both / of_mean, 0.0F, most_contrast) : 0;
    const float left = own - 2 * contrast * both + contrast * contrast * of_mean;
    deviations.push_back(count > 0 ? std::sqrt(std::max(left, 0.0F) / count) : 0);
  }
  return deviations;
}

namespace {

/// Makes all views of a patch but one dearer, whose costs are the last, where that one is there and not rejected.
void keep_to(int view, std::span<const Observation> views, float cost, std::vector<float>& costs) {
  const auto kept = std::ranges::find(views, view, &Observation::view);
  if (kept == views.end() || kept->rejected) return;
  for (std::size_t k = 0; k < views.size(); ++k)
    if (views[k].view != view) costs[costs.size() - views.size() + k] += cost;
}

}  // namespace

std::vector<int> choose_views(const Patches& patches, const Observations& observations,
                              const ChooseOptions& options, const Progress& progress) {
  require(patches.count() == observations.patches(), "observations of these patches are needed");
  require(options.before.empty() || std::ssize(options.before) == patches.count(),
          fmt::format("a view of the frame before is wanted for each of {} patches, found {}", patches.count(),
                      options.before.size()));
  constexpr float most_of_print = 40;  // what is torn is torn
  LabelGraph graph;
  graph.offsets = observations.offsets;
  for (const Observation& o : observations.all) graph.labels.push_back(o.view);
  for (int p = 0; p < patches.count(); ++p) {
    const auto views = observations.of(p);
    const std::vector<float> qualities = relative_qualities(views);
    for (std::size_t k = 0; k < views.size(); ++k)
      graph.costs.push_back(1 - qualities[k] + (views[k].rejected ? float(options.rejected) : 0));
    if (!options.before.empty()) keep_to(options.before[std::size_t(p)], views, float(options.steady), graph.costs);
    for (const float deviation : print_deviations(views)) graph.borders.push_back(std::min(float(options.print) * deviation * deviation, most_of_print));
  }
  for (const Patches::Link& link : patches.links)
    graph.edges.push_back({link.a, link.b, float(options.smoothness) * link.weight});
  std::vector<int> chosen = smooth_labels(graph, 30, progress);
  for (int p = 0; p < patches.count(); ++p)
    if (observations.all_rejected(p)) chosen[std::size_t(p)] = -1;
  return chosen;
}

std::vector<std::optional<LightColour>> agreed_colours(const Observations& observations) {
  std::vector<std::optional<LightColour>> colours(std::size_t(observations.patches()));
  for (int p = 0; p < observations.patches(); ++p) {
    std::array<double, 3> sum{};
    double weight = 0;
    for (const Observation& o : observations.of(p)) {
      if (o.rejected) continue;
      weight += o.quality;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += double(o.quality) * o.colour[c];
    }
    if (!(weight > 0)) continue;
    LightColour& colour = colours[std::size_t(p)].emplace();
    for (std::size_t c = 0; c < 3; ++c) colour[c] = float(sum[c] / weight);
  }
  return colours;
}

std::vector<LightColour> agreed_in_place_of_own(const Observations& observations) {
  const std::vector<std::optional<LightColour>> agreed = agreed_colours(observations);
  std::vector<LightColour> colours(observations.all.size());
  parallel_for(
      observations.patches(),
      [&](std::int64_t p) {
        const std::span<const Observation> views = observations.of(int(p));
        for (std::size_t k = 0; k < views.size(); ++k) {
          std::vector<const Observation*> others;
          for (std::size_t i = 0; i < views.size(); ++i)
            if (i != k && !views[i].rejected) others.push_back(&views[i]);
          const std::optional<LightColour>& all = agreed[std::size_t(p)];
          colours[std::size_t(observations.offsets[std::size_t(p)]) + k] =
              all && !shows_other_places(views[k], others) ? *all : views[k].colour;
        }
      },
      256);
  return colours;
}

}  // namespace mq
