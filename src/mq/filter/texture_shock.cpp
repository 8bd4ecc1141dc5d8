#include "mq/filter/texture_shock.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/detail/texel_parts.h"
#include "mq/filter/seam_agreement.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

/// What of a texel is looked up at the end of a path that begins in it, or near it. Where its own value is not the
/// signal's at the start, as outside charts, the difference fades over the first texel of the way. Returns what is left
/// of that: from 1, where the path rests and the value is its own, down to 0.
double look_up(const TraceAtlas& domain, const Signal& signal, std::int64_t texel, const ChartPlace& from,
               const ChartPlace& to, Eigen::Ref<Signal> found) {
  found.row(0) = signal.row(texel);
  if (from == to) return 1;
  domain.value(signal, to, found);
  const double side = domain.space().scale().texel_spacing;
  const double left = std::max(0.0, 1 - (domain.position(to) - domain.position(from)).norm() / side);
  if (left == 0) return 0;
  Signal before(1, signal.cols());
  domain.value(signal, from, before);
  for (Eigen::Index c = 0; c < signal.cols(); ++c)
    found(0, c) = faded(found(0, c), left, signal(texel, c), before(0, c));
  return left;
}

/// The same of all texels, each with a path; per texel what is left.
Vector look_up(const TraceAtlas& domain, const Signal& signal, const std::vector<ChartPlace>& starts,
               const std::vector<ChartPlace>& ends, Signal& result) {
  Vector left(signal.rows());
  parallel_for(signal.rows(), [&](std::int64_t i) {
    left[i] = look_up(domain, signal, i, starts[std::size_t(i)], ends[std::size_t(i)], result.middleRows(i, 1));
  });
  return left;
}

/// Texels in the midst of charts that differ from one around them, where something has changed.
std::vector<int> texels_at_jumps(const TraceAtlas& domain, const Signal& before, const Signal& after,
                                 const TraceAtlas::Starts& starts) {
  const Signal least = least_jumps(before);
  const auto far = [&](const Signal& a, std::int64_t i, const Signal& b, std::int64_t j) {
    for (Eigen::Index c = 0; c < a.cols(); ++c)
      if (std::abs(a(i, c) - b(j, c)) > least(0, c)) return true;
    return false;
  };
  std::vector<char> jumps(std::size_t(before.rows()));
  parallel_for(before.rows(), [&](std::int64_t i) {
    const ChartPlace& at = starts.places[std::size_t(i)];
    if (starts.outside[std::size_t(i)] || at.x != 0 || at.y != 0) return;
    const int step = domain.stride(at.cell);
    bool jump = false, changed = false;
    for (const int row : {at.cell, domain.beyond(at.cell, TraceAtlas::Side::top)})
      for (const int cell : {row, row < 0 ? -1 : domain.beyond(row, TraceAtlas::Side::left)})
        if (cell < 0 || !domain.covered(cell) || domain.bordered(cell)) return;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const int j = domain.unknown(at.cell + y * step + x);
        if (j < 0) return;
        jump |= far(after, i, after, j);
        changed |= far(before, j, after, j);
      }
    jumps[std::size_t(i)] = jump && changed;
  });
  std::vector<int> result;
  for (std::size_t i = 0; i < jumps.size(); ++i)
    if (jumps[i]) result.push_back(int(i));
  return result;
}

/// Right and down from its centre by less than half a texel.
ChartPlace beside(const TraceAtlas& domain, ChartPlace at, double x, double y) {
  if (x < 0) at.cell = domain.beyond(at.cell, TraceAtlas::Side::left);
  if (y < 0) at.cell = domain.beyond(at.cell, TraceAtlas::Side::top);
  at.x = x < 0 ? 1 + x : x;
  at.y = y < 0 ? 1 + y : y;
  return at;
}

/// Where texels differ from those around them the mean of paths from `texel_parts` takes the place of the one path.
void smooth_outlines(const AtlasFlow& flow, const Signal& signal, const TraceAtlas::Starts& starts, double time,
                     Signal& result, const Progress& progress) {
  const TraceAtlas& domain = flow.domain();
  const std::vector<int> texels = texels_at_jumps(domain, signal, result, starts);
  constexpr std::size_t most = 1 << 17;  // at once
  constexpr std::size_t parts = texel_parts.size();
  for (std::size_t first = 0; first < texels.size(); first += most) {
    const std::size_t count = std::min(most, texels.size() - first);
    std::vector<ChartPlace> from(count * parts);
    for (std::size_t n = 0; n < from.size(); ++n) {
      const auto [x, y] = texel_parts[n % parts];
      from[n] = beside(domain, starts.places[std::size_t(texels[first + n / parts])], x, y);
    }
    const std::vector<ChartPlace> to =
        flow.trace(from, time, progress.step("follow paths", double(count) / double(texels.size()))).ends;
    parallel_for(std::int64_t(count), [&](std::int64_t n) {
      const int texel = texels[first + std::size_t(n)];
      Signal found(std::int64_t(parts), signal.cols());
      for (std::size_t k = 0; k < parts; ++k)
        look_up(domain, signal, texel, from[std::size_t(n) * parts + k], to[std::size_t(n) * parts + k],
                found.middleRows(std::int64_t(k), 1));
      // The mean, which rounding must not bring out of the range.
      result.row(texel) = found.colwise().mean().cwiseMax(found.colwise().minCoeff()).cwiseMin(found.colwise().maxCoeff());
    });
  }
}

}  // namespace

struct TextureShock::Data {
  Data(const Surface& surface, const Atlas& atlas, const TexelSpace& space, Signal values,
       const Progress& progress)
      : signal(std::move(values)), domain(surface, atlas, space, progress) {}

  Signal signal;
  Vector potential;
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
  Vector P = shock_potential(space, signal, options.weights, options.solver, &solves,
                                   progress.step("potential", 0.52));
  data_ = std::make_unique<Data>(surface, atlas, space, std::move(signal), progress.step("order cells", 0.04));
  data_->solves = std::move(solves);
  data_->rate = potential_rate(space, P);
  data_->area = space.scale().area;
  data_->flow.emplace(AtlasFlow::downhill(data_->domain, P));
  data_->starts = data_->domain.starts();
  data_->potential = std::move(P);
}

TextureShock::~TextureShock() = default;

const Vector& TextureShock::potential() const { return data_->potential; }

ShockedTexture TextureShock::at(const ShockTime& time, const Progress& progress) const {
  ShockedTexture shocked;
  shocked.rate = data_->rate;
  shocked.solves = data_->solves;
  shocked.time = time_from(time, data_->rate, data_->area);
  const Stopwatch watch;
  const TracedTexels traced =
      data_->flow->trace(data_->starts.places, shocked.time, progress.step("follow paths", 0.12));
  shocked.counts = traced.counts;
  shocked.signal = data_->signal;
  Vector kept;
  if (shocked.time > 0) {
    kept = look_up(data_->domain, data_->signal, data_->starts.places, traced.ends, shocked.signal);
    smooth_outlines(*data_->flow, data_->signal, data_->starts, shocked.time, shocked.signal,
                    progress.step("outlines", 0.16));
  }
  shocked.path_seconds = watch.seconds();
  if (shocked.time > 0) {
    // Of what disagreed before less is left than of values: what moves half a texel may as well agree.
    shocked.signal = agree_at_seams(data_->domain, shocked.signal, data_->signal, kept.cwiseAbs2(), data_->starts.outside,
                                    progress.step("agree at seams", 0.16));
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
