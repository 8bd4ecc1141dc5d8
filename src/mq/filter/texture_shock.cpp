#include "mq/filter/texture_shock.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/seam_agreement.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

/// Where the texel's own value is not the signal's at the start of its path, as outside charts, the
/// difference fades over the first texel of the way.
/// Returns per texel what is left of that: from 1, where its path rests, down to 0.
Vector look_up(const TraceAtlas& domain, const Signal& signal, const std::vector<ChartPlace>& starts,
               const std::vector<ChartPlace>& ends, Signal& result) {
  const double side = domain.space().scale().texel_spacing;
  Vector kept = Vector::Ones(signal.rows());
  parallel_for(signal.rows(), [&](std::int64_t i) {
    const ChartPlace &from = starts[std::size_t(i)], &to = ends[std::size_t(i)];
    if (from == to) return;
    auto row = result.middleRows(i, 1);
    domain.value(signal, to, row);
    const double left = std::max(0.0, 1 - (domain.position(to) - domain.position(from)).norm() / side);
    kept[i] = left;
    if (left == 0) return;
    Signal before(1, signal.cols());
    domain.value(signal, from, before);
    for (Eigen::Index c = 0; c < signal.cols(); ++c) {
      const double own = signal(i, c), found = row(0, c);
      const auto [low, high] = std::minmax(own, found);
      row(0, c) = std::clamp(found + left * (own - before(0, c)), low, high);
    }
  });
  return kept;
}

}  // namespace

struct TextureShock::Data {
  Data(const Surface& surface, const Atlas& atlas, const TexelSpace& space, Signal values,
       const Progress& progress)
      : signal(std::move(values)), domain(surface, atlas, space, progress) {}

  Signal signal;
  TraceAtlas domain;
  double rate = 0, area = 0;
  std::vector<SolveReport> solves;
  std::optional<AtlasFlow> flow;
  TraceAtlas::Starts starts;
};

TextureShock::TextureShock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                           Signal signal, const TextureShockOptions& options, const Progress& progress) {
  require(signal.rows() == space.size(),
          fmt::format("a signal of {} rows was given for {} texels", signal.rows(), space.size()));
  require(signal.allFinite(), "the texture has values that are not finite");
  std::vector<SolveReport> solves;
  // First: the solver needs more memory than all else.
  const Vector P = shock_potential(space, signal, options.weights, options.solver, &solves,
                                   progress.step("potential", 0.68));
  data_ = std::make_unique<Data>(surface, atlas, space, std::move(signal), progress.step("order cells", 0.05));
  data_->solves = std::move(solves);
  data_->rate = potential_rate(space, P);
  data_->area = space.scale().area;
  data_->flow.emplace(AtlasFlow::downhill(data_->domain, P));
  data_->starts = data_->domain.starts();
}

TextureShock::~TextureShock() = default;

ShockedTexture TextureShock::at(const ShockTime& time, const Progress& progress) const {
  ShockedTexture shocked;
  shocked.rate = data_->rate;
  shocked.solves = data_->solves;
  shocked.time = time_from(time, data_->rate, data_->area);
  const Stopwatch watch;
  const TracedTexels traced =
      data_->flow->trace(data_->starts.places, shocked.time, progress.step("follow paths", 0.24));
  shocked.counts = traced.counts;
  shocked.path_seconds = watch.seconds();
  shocked.signal = data_->signal;
  if (shocked.time > 0) {
    const Vector kept = look_up(data_->domain, data_->signal, data_->starts.places, traced.ends, shocked.signal);
    // Of what disagreed before less is left than of values: what moves half a texel may as well agree.
    shocked.signal = agree_at_seams(data_->domain, shocked.signal, data_->signal, kept.cwiseAbs2(), data_->starts.outside);
  }
  progress.at(1);
  return shocked;
}

ShockedTexture texture_shock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                             const Signal& signal, const TextureShockOptions& options,
                             const Progress& progress) {
  return TextureShock(surface, atlas, space, signal, options, progress).at(options.time, progress);
}

}  // namespace mq
