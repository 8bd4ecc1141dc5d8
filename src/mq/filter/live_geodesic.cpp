#include "mq/filter/live_geodesic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/vertex_hierarchy.h"
#include "mq/filter/detail/live_geodesic_ways.h"

namespace mq {

GuessedCycles::GuessedCycles(Hierarchy hierarchy)
    : hierarchy_(std::move(hierarchy)), workspace_(hierarchy_.multigrid(), 1) {
  for (LaneVector* v : {&b_, &x_, &r_, &z_}) *v = LaneVector(hierarchy_.rows(), 1);
}

void GuessedCycles::set_right_hand_side(const Vector& b) {
  const Scaling& scaling = hierarchy_.scaling();
  parallel_for(b.size(), [&](std::int64_t i) { b_.data()[i] = float(scaling.common * scaling.row(i) * b[i]); });
}

void GuessedCycles::set_guess(const Vector& x) {
  const Scaling& scaling = hierarchy_.scaling();
  parallel_for(x.size(), [&](std::int64_t i) { x_.data()[i] = float(x[i] / scaling.row(i)); });
}

double GuessedCycles::cycle() {
  const Multigrid& multigrid = hierarchy_.multigrid();
  const float* correction = z_.data();
  if (multigrid.levels.empty()) {  // all of A is the coarsest level
    multigrid.cycle(b_.data(), z_.data(), workspace_);
    for (std::int64_t i = 0; i < x_.size(); ++i) std::swap(x_.data()[i], z_.data()[i]), z_.data()[i] -= x_.data()[i];
  } else {
    hierarchy_.high().residual(1, b_.data(), x_.data(), r_.data());
    multigrid.cycle(r_.data(), z_.data(), workspace_);
    parallel_for(x_.size(), [&](std::int64_t i) { x_.data()[i] += correction[i]; });
  }
  struct Most {
    double value = 0;
    Most operator+(const Most& other) const { return {std::max(value, other.value)}; }
  };
  const Scaling& scaling = hierarchy_.scaling();
  return parallel_sum(x_.size(), Most{}, [&](std::int64_t begin, std::int64_t end) {
           Most most;
           for (std::int64_t i = begin; i < end; ++i)
             most.value = std::max(most.value, scaling.row(i) * std::abs(double(correction[i])));
           return most;
         }).value;
}

namespace {

std::unique_ptr<LiveGeodesic::Way> way_for(const LiveGeodesicSpace& space, const LiveGeodesicOptions& options,
                                           const Progress& progress) {
  require(options.geodesic.time > 0 && std::isfinite(options.geodesic.time),
          fmt::format("the time that heat spreads is {}; it must be positive", options.geodesic.time));
  require(options.published_alpha > 0 && std::isfinite(options.published_alpha),
          fmt::format("the time that heat spreads is {} areas; it must be positive", options.published_alpha));
  return options.method == LiveGeodesicOptions::Method::published ? published_way(space, options, progress)
                                                                  : progressive_way(space, options, progress);
}

}  // namespace

LiveGeodesic::LiveGeodesic(const TexelSpace& space, const LiveGeodesicOptions& options, const Progress& progress)
    : way_(way_for({space,
                    [&space](const SparseMatrix& A, const Progress& making) {
                      return texel_hierarchy(A, space.texels(), {}, making);
                    }},
                   options, progress)) {}

LiveGeodesic::LiveGeodesic(const VertexSpace& space, const LiveGeodesicOptions& options, const Progress& progress)
    : way_(way_for({space,
                    [&space](const SparseMatrix& A, const Progress& making) {
                      return vertex_hierarchy(A, space.positions(), {}, making);
                    }},
                   options, progress)) {}

LiveGeodesic::~LiveGeodesic() = default;
LiveGeodesic::LiveGeodesic(LiveGeodesic&&) noexcept = default;

void LiveGeodesic::move(const std::vector<GeodesicSource>& sources) { way_->move(sources); }
LiveGeodesicStep LiveGeodesic::step(const Progress& progress) { return way_->step(progress); }
bool LiveGeodesic::rests() const { return way_->rests(); }
const Vector& LiveGeodesic::distance() const { return way_->distance(); }

}  // namespace mq
