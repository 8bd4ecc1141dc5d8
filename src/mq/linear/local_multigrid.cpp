/// Level by level, with R the restriction and P = Rᵀ:
///
///     relax A·x = b in N;  b' = R·(b − A·x) in N';  x' from b';  x += P·x' in N;  relax,
///
/// where vectors are those of the whole levels and 0 outside N, so that rows, runs of stencils and
/// patches keep their numbers and kernels are those of the whole matrix.

#include "mq/linear/local_multigrid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>

#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr double dominated_below = 0.5;  // of `StencilMatrix::dominance`
constexpr int sweeps = 1;        // before and after a coarser level: twice cost more than they gain
constexpr int last_sweeps = 12;  // on the last level where relaxation does not solve
// Below so many rows a cycle on one thread is done before others would have been called to each of
// its steps and waited for, the more so where something else runs on their cores.
constexpr std::int64_t rows_for_threads = 40000;
// Coarser levels of a cycle that threads are called to begin where each of them has hardly more than that to do.
constexpr std::int64_t rows_of_level_for_threads = 10000;

constexpr std::int64_t segments_at_once = 32;  // of texels side by side

/// Runs by their first row.
std::vector<int> order_by_row(const StencilTiles& tiles) {
  std::vector<int> order(tiles.runs.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int r) { return tiles.runs[r].first; });
  return order;
}

/// What lies of each run in some rows, in the same order.
StencilTiles clipped(const StencilTiles& tiles, const std::vector<int>& by_row,
                     const std::vector<RowSet::Segment>& segments) {
  struct Piece {
    int run, tile;
    StencilRun part;
  };
  std::vector<Piece> pieces;
  const auto end_of = [&](int r) { return tiles.runs[r].first + tiles.runs[r].count; };
  for (const RowSet::Segment& s : segments) {
    auto at = std::ranges::upper_bound(by_row, s.first, {}, end_of);
    for (; at != by_row.end() && tiles.runs[*at].first < s.first + s.count; ++at) {
      const StencilRun& run = tiles.runs[*at];
      const int first = std::max(run.first, s.first);
      const int skipped = first - run.first;
      pieces.push_back({*at,
                        0,
                        {first, std::min(end_of(*at), s.first + s.count) - first, run.up + skipped,
                         run.down + skipped}});
    }
  }
  std::ranges::stable_sort(pieces, {}, &Piece::run);
  for (Piece& piece : pieces)
    piece.tile = int(std::ranges::upper_bound(tiles.tiles, piece.run) - tiles.tiles.begin()) - 1;

  StencilTiles result;
  std::size_t i = 0;
  for (std::size_t c = 0; c + 1 < tiles.colours.size(); ++c) {
    result.colours.push_back(int(result.tiles.size()));
    for (; i < pieces.size() && pieces[i].tile < tiles.colours[c + 1]; ++i) {
      if (result.runs.empty() || pieces[i].tile != pieces[i - 1].tile)
        result.tiles.push_back(int(i));
      result.runs.push_back(pieces[i].part);
    }
  }
  result.colours.push_back(int(result.tiles.size()));
  result.tiles.push_back(int(pieces.size()));
  return result;
}

/// Positions in `sorted` of those of its values that lie in the segments, increasing.
std::vector<int> positions_in(const std::vector<int>& sorted,
                              const std::vector<RowSet::Segment>& segments) {
  std::vector<int> positions;
  auto at = sorted.begin();
  for (const RowSet::Segment& s : segments) {
    at = std::lower_bound(at, sorted.end(), s.first);
    for (; at != sorted.end() && *at < s.first + s.count; ++at)
      positions.push_back(int(at - sorted.begin()));
  }
  return positions;
}

/// Rows of the next level that some are interpolated from, increasing.
std::vector<int> parents_of(const LevelTransfer& transfer, const std::vector<int>& rows) {
  constexpr std::int64_t at_once = 16384;
  std::vector<std::vector<int>> blocks(std::size_t(std::ssize(rows) + at_once - 1) / at_once);
  parallel_blocks(std::ssize(rows), at_once, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int>& found = blocks[std::size_t(begin / at_once)];
    std::array<WeightedIndex, 4> parents;
    std::array<int, 4> before = {-1, -1, -1, -1};  // of the row beside it, mostly the same
    for (std::int64_t at = begin; at < end; ++at) {
      const int count = transfer.parents(rows[std::size_t(at)], parents);
      for (int i = 0; i < count; ++i)
        if (std::ranges::find(before, parents[std::size_t(i)].index) == before.end())
          found.push_back(parents[std::size_t(i)].index);
      for (int i = 0; i < 4; ++i) before[std::size_t(i)] = i < count ? parents[std::size_t(i)].index : -1;
    }
  });
  RowSet seen(transfer.coarse_rows());
  for (const std::vector<int>& block : blocks)
    for (const int row : block) seen.add(row);
  return seen.rows();
}

}  // namespace

LocalMultigrid::LocalMultigrid(const Multigrid& multigrid, int lanes)
    : multigrid_(multigrid), lanes_(lanes), before_(multigrid.rows(), lanes) {
  for (std::size_t l = 0; l <= multigrid.levels.size(); ++l) {
    Level& here = levels_.emplace_back();
    const bool coarsest = l == multigrid.levels.size();
    const int rows = coarsest ? multigrid.coarsest.rows() : multigrid.levels[l]->layout.rows;
    here.set = RowSet(rows);
    here.b = LaneVector(rows, lanes);
    here.x = LaneVector(rows, lanes);
    if (coarsest) continue;
    here.r = LaneVector(rows, lanes);
    const MultigridLevel& whole = *multigrid.levels[l];
    here.runs_by_row = order_by_row(whole.layout);
    here.anisotropic_by_row = order_by_row(whole.matrix.anisotropic());
    here.dominated = whole.matrix.dominance() <= dominated_below;
  }
}

/// body(floats of the level's vectors before, and in, a piece of consecutive rows).
template <class Body>
void LocalMultigrid::for_segments(const Level& level, const Body& body) const {
  parallel_for(
      std::ssize(level.segments),
      [&](std::int64_t i) {
        const RowSet::Segment& s = level.segments[std::size_t(i)];
        body(std::int64_t(s.first) * lanes_, std::size_t(s.count) * std::size_t(lanes_));
      },
      segments_at_once);
}

void LocalMultigrid::clear(LaneVector& v, const Level& level) const {
  for_segments(level, [&](std::int64_t first, std::size_t count) { std::memset(v.data() + first, 0, sizeof(float) * count); });
}

/// Does something to the rows, by as many threads as it is worth.
template <class Body>
void LocalMultigrid::run(std::int64_t rows, const Body& body) {
  if (rows < rows_for_threads)
    one_thread_.execute(body);
  else
    body();
}

void LocalMultigrid::choose(const RowSet& rows) {
  run(rows.count(), [&] { choose_rows(rows); });
}

void LocalMultigrid::choose_rows(const RowSet& rows) {
  // Of the others nothing is read outside the rows that are chosen then.
  clear(levels_.front().b, levels_.front());
  for (Level& level : levels_) {
    clear(level.x, level);
    level.set.clear();
    level.rows.clear();
    level.segments.clear();
  }
  levels_.front().set = rows;
  levels_.front().rows = rows.rows();
  levels_.front().segments = segments_of(levels_.front().rows);
  last_ = 0;
  for (std::size_t l = 0; l + 1 < levels_.size(); ++l) {
    last_ = l;
    take_rows(l);
    if (levels_[l].dominated) return;
    coarsen(l);
    if (levels_[l + 1].rows.empty()) return;
  }
  // The coarsest matrix has factors for all of its rows.
  if (std::ssize(levels_.back().rows) == multigrid_.coarsest.rows()) last_ = levels_.size() - 1;
}

/// What of the matrix and the patches is in the rows of a level.
void LocalMultigrid::take_rows(std::size_t l) {
  Level& here = levels_[l];
  const MultigridLevel& whole = *multigrid_.levels[l];
  const std::vector<RowSet::Segment>& segments = here.segments;
  here.part.stencils = clipped(whole.layout, here.runs_by_row, segments);
  here.part.anisotropic = clipped(whole.matrix.anisotropic(), here.anisotropic_by_row, segments);
  here.part.irregular = positions_in(whole.layout.irregular, segments);
  std::vector<int> listed = here.part.irregular;
  for (const int p : positions_in(whole.layout.clustered, segments))
    listed.push_back(int(whole.layout.irregular.size()) + p);
  here.patches = whole.patches.within(here.set, listed, whole.layout);
  here.rescaled.clear();
  for (const WeightedIndex& row : whole.rescaled)
    if (here.set.has(row.index)) here.rescaled.push_back(row);
}

/// The rows of the next level all of whose children are in this one.
void LocalMultigrid::coarsen(std::size_t l) {
  const Level& here = levels_[l];
  Level& below = levels_[l + 1];
  const LevelTransfer& transfer = *multigrid_.levels[l]->transfer;
  const std::vector<int> candidates = parents_of(transfer, here.rows);
  std::vector<char> taken(candidates.size(), 0);
  parallel_blocks(std::ssize(candidates), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<WeightedIndex> children;
    for (std::int64_t i = begin; i < end; ++i) {
      children.clear();
      transfer.children(candidates[std::size_t(i)], children);
      taken[std::size_t(i)] =
          std::ranges::all_of(children, [&](const WeightedIndex& c) { return here.set.has(c.index); });
    }
  });
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (taken[i]) below.set.add(candidates[i]);
  below.rows = below.set.rows();
  below.segments = segments_of(below.rows);
}

/// An irregular row whose patches reach beyond N, by Gauss and Seidel.
void LocalMultigrid::relax_alone(std::size_t l, int position) {
  const MultigridLevel& whole = *multigrid_.levels[l];
  const StencilMatrix::Row row = whole.matrix.listed_row(position);
  const std::int64_t at = std::int64_t(whole.layout.irregular[position]) * lanes_;
  float* x = levels_[l].x.data();
  if (!(row.diagonal > 0)) return;
  for (int lane = 0; lane < lanes_; ++lane) {
    float sum = levels_[l].b.data()[at + lane];
    for (int i = 0; i < row.count; ++i)
      sum -= row.values[i] * x[std::int64_t(row.columns[i]) * lanes_ + lane];
    x[at + lane] = sum / row.diagonal;
  }
}

void LocalMultigrid::relax(std::size_t l, int sweeps, Order order) {
  Level& here = levels_[l];
  const MultigridLevel& whole = *multigrid_.levels[l];
  const auto stencils = [&] {
    whole.matrix.relax_stencils(here.part, lanes_, here.b.data(), here.x.data(), sweeps, order);
  };
  if (order == Order::forward) stencils();
  const std::vector<int>& alone = here.patches.alone;
  for (int i = 0; i < sweeps; ++i) {
    if (order == Order::backward)
      for (auto p = alone.rbegin(); p != alone.rend(); ++p) relax_alone(l, *p);
    whole.patches.relax(here.patches.order, whole.matrix, lanes_, here.b.data(), here.x.data(),
                        order);
    if (order == Order::forward)
      for (const int p : alone) relax_alone(l, p);
  }
  if (order == Order::backward) stencils();
  updates_ += sweeps * std::ssize(here.rows);
}

void LocalMultigrid::cycle(std::size_t l) {
  Level& here = levels_[l];
  if (l + 1 == levels_.size()) {
    multigrid_.coarsest.solve(lanes_, here.b.data(), here.x.data());
    return;
  }
  const MultigridLevel& whole = *multigrid_.levels[l];
  if (l == last_) {
    const int enough = here.dominated ? 2 * sweeps : last_sweeps;
    relax(l, enough, Order::forward);
    relax(l, enough, Order::backward);
    return;
  }
  relax(l, sweeps, Order::forward);
  Level& below = levels_[l + 1];
  whole.matrix.residual(here.part, lanes_, here.b.data(), here.x.data(), here.r.data());
  rescale(here.rescaled, lanes_, here.r.data(), 1);
  whole.transfer->restrict_to(below.rows, lanes_, here.r.data(), below.b.data());
  const auto cycles_below = [&] {
    clear(below.x, below);
    cycle(l + 1);
    if (l + 1 == std::size_t(multigrid_.options.twice_from) && l + 1 < last_) cycle(l + 1);
  };
  if (std::ssize(below.rows) < rows_of_level_for_threads)
    one_thread_.execute(cycles_below);
  else
    cycles_below();
  rescale(here.rescaled, lanes_, here.x.data(), -1);
  whole.transfer->prolongate_add(here.rows, lanes_, below.x.data(), here.x.data());
  rescale(here.rescaled, lanes_, here.x.data(), 1);
  relax(l, sweeps, Order::backward);
}

/// The largest change of x by the last cycle.
double LocalMultigrid::change_by(Cycle cycle) {
  constexpr std::size_t wide = 8;
  struct Largest {
    std::array<float, wide> values{};
    Largest operator+(const Largest& other) const {
      Largest result;
      for (std::size_t i = 0; i < wide; ++i) result.values[i] = std::max(values[i], other.values[i]);
      return result;
    }
  };
  const Level& here = levels_.front();
  const auto take = [](std::span<const float> now, const float* before, auto& largest) {
    const auto change = [&](std::size_t i) { return std::abs(before ? now[i] - before[i] : now[i]); };
    std::size_t i = 0;
    for (; i + wide <= now.size(); i += wide)
      for (std::size_t k = 0; k < wide; ++k) largest[k] = std::max(largest[k], change(i + k));
    for (; i < now.size(); ++i) largest[0] = std::max(largest[0], change(i));
  };
  const auto of_block = [&](std::int64_t begin, std::int64_t end) {
    Largest largest;
    for (std::int64_t i = begin; i < end; ++i) {
      const RowSet::Segment& s = here.segments[std::size_t(i)];
      const std::int64_t first = std::int64_t(s.first) * lanes_;
      const std::span<const float> now(here.x.data() + first, std::size_t(s.count) * std::size_t(lanes_));
      take(now, cycle == Cycle::first ? nullptr : before_.data() + first, largest.values);
    }
    return largest;
  };
  return std::ranges::max(parallel_sum(std::ssize(here.segments), Largest{}, of_block, 256).values);
}

void LocalMultigrid::keep_solution() {
  for_segments(levels_.front(), [&](std::int64_t first, std::size_t count) {
    std::memcpy(before_.data() + first, levels_.front().x.data() + first, sizeof(float) * count);
  });
}

LocalSolve LocalMultigrid::solve(const LocalSolveOptions& options) {
  LocalSolve report;
  run(std::ssize(rows()), [&] { report = solve_rows(options); });
  return report;
}

LocalSolve LocalMultigrid::solve_rows(const LocalSolveOptions& options) {
  LocalSolve report;
  updates_ = 0;
  clear(levels_.front().x, levels_.front());
  double last_change = 0;
  while (report.cycles < options.max_cycles) {
    if (report.cycles > 0) keep_solution();
    cycle(0);
    const double change = change_by(report.cycles == 0 ? Cycle::first : Cycle::later);
    ++report.cycles;
    if (last_change > 0) {
      const double ratio = std::clamp(change / last_change, 0.01, 0.9);
      rate_ = std::max(ratio, ratio_);
      ratio_ = ratio;
    }
    last_change = change;
    report.error = change * rate_ / (1 - rate_);
    if (report.error <= options.error || updates_ >= options.enough) break;
  }
  report.updates = updates_;
  return report;
}

}  // namespace mq
