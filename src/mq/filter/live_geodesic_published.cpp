// u += C·(M·δ_source − (M + t·S)·u);   φ += C·(−∫ ⟨∇u/|∇u|, ∇φ_i⟩ dA − S·φ),   φ −= φ_source.
//
// The equations of u do not mind its unit, and its gradient is normalised: M·δ is scaled to 1, which keeps
// what is 10⁻³⁰ of it far away within single precision.

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/base/parallel.h"
#include "mq/filter/geodesic_steps.h"
#include "mq/filter/detail/live_geodesic_ways.h"
#include "mq/linear/connected_components.h"

namespace mq {
namespace {

/// Below it a gradient is that of nothing, or its inverse no number of single precision.
constexpr float least_norm = 1e-36F;

class PublishedWay final : public LiveGeodesic::Way {
 public:
  PublishedWay(const LiveGeodesicSpace& on, const LiveGeodesicOptions& options, const Progress& progress)
      : space_(on.space),
        mass_(on.space.mass()),
        spread_(on.levels(
            on.space.regularised_system(1, options.published_alpha * on.space.scale().area),
            progress.step("heat", 0.5))),
        poisson_(on.levels(on.space.regularised_system(0, 1), progress.step("distance", 0.5))),
        component_(connected_components(mass_)) {}

  void move(const std::vector<GeodesicSource>& sources) override {
    require_sources(sources, space_.size());
    sources_ = sources;
    Vector impulse = Vector::Zero(space_.size());
    for (const GeodesicSource& s : sources) impulse[s.unknown] = 1;
    Vector b = mass_ * impulse;
    b /= b.cwiseAbs().maxCoeff();
    spread_.set_right_hand_side(b);
    spread_.set_guess(Vector::Zero(space_.size()));
    poisson_.set_guess(Vector::Zero(space_.size()));
  }

  LiveGeodesicStep step(const Progress& progress) override {
    require(!sources_.empty(), "distances need a source: none was given before the first step");
    progress.check();
    spread_.cycle();
    Signal u(space_.size(), 1);
    parallel_for(u.rows(), [&](std::int64_t i) { u(i, 0) = spread_.x(i); });
    std::vector<float> factor = space_.gradient_norms(u);
    for (float& f : factor) f = f > least_norm ? -1 / f : 0.0F;
    poisson_.set_right_hand_side(space_.weighted_stiffness_times(u, factor).col(0));
    const double change = poisson_.cycle();
    Vector phi(space_.size());
    parallel_for(phi.size(), [&](std::int64_t i) { phi[i] = poisson_.x(i); });
    from_source(phi);
    distance_ = std::move(phi);
    return {LiveGeodesicStep::Part::published, LiveGeodesicStep::Shown::anew, change};
  }

  bool rests() const override { return false; }

 private:
  /// φ is 0 at the source of its component, at several on average; infinite where there is none.
  void from_source(Vector& phi) const {
    std::vector<double> sum(component_.size(), 0), count(component_.size(), 0);
    for (const GeodesicSource& s : sources_) {
      sum[component_[s.unknown]] += phi[s.unknown] - s.distance;
      count[component_[s.unknown]] += 1;
    }
    parallel_for(phi.size(), [&](std::int64_t i) {
      const int c = component_[i];
      phi[i] = count[c] > 0 ? phi[i] - sum[c] / count[c] : infinity;
    });
  }

  const SignalSpace& space_;
  SparseMatrix mass_;
  GuessedCycles spread_, poisson_;
  std::vector<int> component_;
  std::vector<GeodesicSource> sources_;
};

}  // namespace

std::unique_ptr<LiveGeodesic::Way> published_way(const LiveGeodesicSpace& space, const LiveGeodesicOptions& options,
                                                 const Progress& progress) {
  return std::make_unique<PublishedWay>(space, options, progress);
}

}  // namespace mq
