/// With δ = φ − ψ, b = w·S_{β−1}·ψ and r = b − A·δ, everywhere: a change of β changes b, and with
/// it r, in a few rows. Following it solves A_NN·z = r_N on the set N of unknowns near by, those
/// further off held, and does δ_N += z, r −= A_·N·z, all channels of both solutions at once. N is what lies within
/// `reach` lengths √w of the changed ones; distances are straight ones, which are never longer than those on the
/// surface. Where cycles ended before z was near enough, N is remembered, bin by bin, until one of the next times.
///
/// z is solved for in single precision until nobody sees what is left of it; r is in double, so
/// that nothing of that is lost.

#include "mq/filter/live_modulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/release.h"
#include "mq/fem/modulated_stiffness.h"
#include "mq/fem/point_bins.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/fem/vertex_hierarchy.h"
#include "mq/linear/local_multigrid.h"

namespace mq {

namespace {

constexpr double least_reach = 8;      // unknowns: as many as relaxation sees
constexpr double bins_per_reach = 2;   // along an axis
constexpr double most_to_keep = 1.25;  // times the bins needed: else another N is chosen
constexpr Eigen::Index most_lanes = 8;  // channels that are solved for at once
// Rows to a thread: fewer are done before another one has come, and waited for where something else runs on its core.
constexpr std::int64_t rows_at_once = 16384;

/// S_β·ψ in some rows for each of several β, side by side.
using StiffnessRows = std::function<Signal(std::span<const int>, std::span<const std::span<const double>>)>;

/// The rows that some, increasing, couple to. Where stencils lie side by side, so do the triples of their columns, which
/// are one segment.
std::vector<RowSet::Segment> columns_of(const SparseMatrix& A, std::span<const int> wanted) {
  std::vector<RowSet::Segment> found;
  std::array<RowSet::Segment, 3> open{};  // of the rows before
  int last = -2;
  for (const int row : wanted) {
    const int begin = A.outerIndexPtr()[row], count = A.outerIndexPtr()[row + 1] - begin;
    const int* const columns = A.innerIndexPtr() + begin;
    const bool is_stencil = count == 9 && columns[2] - columns[0] == 2 && columns[5] - columns[3] == 2 &&
                            columns[8] - columns[6] == 2;
    const auto goes_on = [&](int i) { return columns[3 * i + 2] == open[std::size_t(i)].first + open[std::size_t(i)].count; };
    if (is_stencil && row == last + 1 && goes_on(0) && goes_on(1) && goes_on(2)) {
      for (RowSet::Segment& segment : open) ++segment.count;
      last = row;
      continue;
    }
    found.insert(found.end(), open.begin(), open.end());
    open = {};
    last = -2;
    if (is_stencil) {
      for (int i = 0; i < 3; ++i) open[std::size_t(i)] = {columns[3 * i], 3};
      last = row;
    } else {
      for (int i = 0; i < count; ++i) found.push_back({columns[i], 1});
    }
  }
  found.insert(found.end(), open.begin(), open.end());
  return found;
}

/// Adds them, found block by block.
void add_columns(const SparseMatrix& A, std::span<const int> wanted, RowSet& to) {
  std::vector<std::vector<RowSet::Segment>> blocks(std::size_t(std::ssize(wanted) + rows_at_once - 1) / rows_at_once);
  parallel_blocks(std::ssize(wanted), rows_at_once, [&](std::int64_t begin, std::int64_t end) {
    blocks[std::size_t(begin / rows_at_once)] = columns_of(A, wanted.subspan(std::size_t(begin), std::size_t(end - begin)));
  });
  for (const auto& block : blocks)
    for (const RowSet::Segment& segment : block) to.add(segment);
}

}  // namespace

/// What is solved, whatever the unknowns are.
struct LiveModulation::System {
  SparseMatrix A;
  Hierarchy hierarchy;
  std::vector<std::array<float, 3>> places;  ///< of the unknowns, from somewhere
  double spacing;                            ///< between them, in model units
  std::function<StiffnessRows(const Signal& psi)> stiffness_of;
};

struct LiveModulation::Data {
  double weight;
  Signal psi;
  System system;
  const SparseMatrix& A = system.A;
  const Hierarchy& hierarchy = system.hierarchy;
  StiffnessRows stiffness_rows;
  LocalMultigrid local;
  double reach;  ///< in model units
  PointBins bins;
  std::vector<std::vector<int>> bins_near;  ///< per bin those within reach; empty: not asked for yet
  std::vector<double> beta, change;  ///< β and β − 1
  std::vector<double> texture, change_of_texture;  ///< empty, or the part of it, and of β − 1 what it is
  Signal b, r, phi;
  std::vector<int> changed;    ///< since the last `follow`
  std::vector<int> near_bins;  ///< whose unknowns are N
  std::vector<int> unfinished;  ///< bins of which something is left to be solved for
  std::vector<int> around;     ///< N and the rows it couples to
  RowSet rows;                 ///< empty between calls

  Data(System of_space, double weight_, Signal psi_, const LiveOptions& options)
      : weight(weight_),
        psi(std::move(psi_)),
        system(std::move(of_space)),
        stiffness_rows(system.stiffness_of(psi)),
        local(hierarchy.multigrid(), lanes_for(int(psi.cols()) * (options.texture.empty() ? 1 : 2))),
        reach(std::max(options.reach * std::sqrt(weight), least_reach * system.spacing)),
        bins(system.places, reach / bins_per_reach),
        bins_near(std::size_t(bins.bin_count())),
        beta(std::size_t(size()), 1.0),
        change(std::size_t(size()), 0.0),
        texture(options.texture),
        change_of_texture(texture.size(), 0.0),
        b(Signal::Zero(size(), psi.cols() * parts())),
        r(b),
        phi(start()),
        rows(size()) {
    release(system.places);
  }

  int size() const { return int(A.rows()); }
  int parts() const { return texture.empty() ? 1 : 2; }
  Signal start() const { return psi.replicate(1, parts()); }
  Signal change_of_gradients(std::span<const int> wanted) const;
  std::vector<int> rows_around(std::span<const int> unknowns);
  std::vector<int> bins_around_changes();
  void choose_near();
  void take_bins(std::vector<int> bins);
  enum class Progressed { in_part, to_the_end };
  void note(Progressed progressed);
  void take_right_hand_side(Eigen::Index first, Eigen::Index channels);
  template <int channels>
  void add_solution(Eigen::Index first);
  void add_solution(Eigen::Index first, Eigen::Index channels);
};

/// These and those A couples them to: where the right-hand side depends on their β.
std::vector<int> LiveModulation::Data::rows_around(std::span<const int> unknowns) {
  add_columns(A, unknowns, rows);
  std::vector<int> result = rows.rows();
  rows.clear();
  return result;
}

/// S_{β−1}·ψ in some rows, and the same for texture's part.
Signal LiveModulation::Data::change_of_gradients(std::span<const int> wanted) const {
  const std::array<std::span<const double>, 2> betas = {change, change_of_texture};
  return stiffness_rows(wanted, std::span(betas).first(std::size_t(parts())));
}

/// The bins within reach of a change. Which are near one is found once.
std::vector<int> LiveModulation::Data::bins_around_changes() {
  RowSet holding(bins.bin_count()), near(bins.bin_count());
  for (const int k : changed) holding.add(bins.bin_of(k));
  for (const int bin : holding.rows()) {
    std::vector<int>& around_it = bins_near[std::size_t(bin)];
    if (around_it.empty()) around_it = bins.around_bin(bin, reach);  // itself at least
    for (const int other : around_it) near.add(other);
  }
  return near.rows();
}

/// N is to hold what lies around the changes, and not much more; where nothing changed, what is unfinished.
void LiveModulation::Data::choose_near() {
  if (changed.empty()) {
    const bool here = std::ranges::any_of(
        unfinished, [&](int bin) { return std::ranges::binary_search(near_bins, bin); });
    if (!unfinished.empty() && !here) take_bins(unfinished);
    return;
  }
  std::vector<int> needed = bins_around_changes();
  if (std::ranges::includes(near_bins, needed) &&
      double(near_bins.size()) <= most_to_keep * double(needed.size()))
    return;
  take_bins(std::move(needed));
}

void LiveModulation::Data::take_bins(std::vector<int> wanted) {
  near_bins = std::move(wanted);
  bins.add(near_bins, rows);
  local.choose(rows);
  rows.clear();
  around = rows_around(local.rows());
}

/// b̂ = D·r of some channels; see `Scaling`.
void LiveModulation::Data::take_right_hand_side(Eigen::Index first, Eigen::Index channels) {
  const std::vector<int>& near = local.rows();
  const Scaling& scaling = hierarchy.scaling();
  parallel_for(std::ssize(near), [&](std::int64_t at) {
    const int i = near[at];
    const double factor = scaling.common * scaling.row(i);
    for (Eigen::Index c = 0; c < local.lanes(); ++c)
      local.right_hand_side()[std::int64_t(i) * local.lanes() + c] =
          c < channels ? float(factor * r(i, first + c)) : 0.0F;
  }, rows_at_once);
}

/// φ_N += z, r −= A_·N·z.
template <int channels>
void LiveModulation::Data::add_solution(Eigen::Index first) {
  using Row = Eigen::Array<double, channels, 1>;
  const float* const unit = hierarchy.scaling().rows.empty() ? nullptr : hierarchy.scaling().rows.data();
  const int lanes = local.lanes();
  const auto z = [&, x = local.solution()](int i) {
    const Row of_row = Eigen::Array<float, channels, 1>::Map(x + std::int64_t(i) * lanes).template cast<double>();
    return unit ? Row(of_row * double(unit[i])) : of_row;
  };
  parallel_for(std::ssize(around), [&](std::int64_t at) {
    const int i = around[at];
    Row product = Row::Zero();
    for (int e = A.outerIndexPtr()[i]; e < A.outerIndexPtr()[i + 1]; ++e)
      product += A.valuePtr()[e] * z(A.innerIndexPtr()[e]);
    Row::Map(r.data() + i * r.cols() + first) -= product;
    Row::Map(phi.data() + i * phi.cols() + first) += z(i);
  }, rows_at_once);
}

void LiveModulation::Data::add_solution(Eigen::Index first, Eigen::Index channels) {
  switch (channels) {
    case 1: return add_solution<1>(first);
    case 2: return add_solution<2>(first);
    case 3: return add_solution<3>(first);
    case 4: return add_solution<4>(first);
    case 5: return add_solution<5>(first);
    case 6: return add_solution<6>(first);
    case 7: return add_solution<7>(first);
    default: return add_solution<most_lanes>(first);
  }
}

/// After cycles on N.
void LiveModulation::Data::note(Progressed progressed) {
  std::vector<int> now;
  if (progressed == Progressed::in_part)
    std::ranges::set_union(unfinished, near_bins, std::back_inserter(now));
  else
    std::ranges::set_difference(unfinished, near_bins, std::back_inserter(now));
  unfinished = std::move(now);
}

namespace {

void check(const SignalSpace& space, double weight, const Signal& psi, const LiveOptions& options) {
  require(
      weight > 0 && std::isfinite(weight),
      fmt::format("the weight of a live modulation is {}; it must be positive and finite", weight));
  require(
      psi.rows() == space.size() && psi.cols() > 0 && psi.allFinite(),
      fmt::format("a live modulation of {} unknowns wants a finite signal of as many rows; one of "
                  "{} × {} was given",
                  space.size(), psi.rows(), psi.cols()));
  require(options.texture.empty() ||
              (std::ssize(options.texture) == space.size() &&
               std::ranges::all_of(options.texture, [](double t) { return t >= 0 && t <= 1; })),
          fmt::format("a live modulation of {} unknowns wants a part of texture from 0 to 1 for each; {} were given",
                      space.size(), options.texture.size()));
}

}  // namespace

LiveModulation::LiveModulation(const TexelSpace& space, double weight, Signal psi,
                               const LiveOptions& options, const Progress& progress) {
  check(space, weight, psi, options);
  SparseMatrix A = space.regularised_system(1, weight, progress.step("assemble", 0.4));
  Hierarchy hierarchy = texel_hierarchy(A, space.texels(), {}, progress.step("levels", 0.6));
  data_ = std::make_unique<Data>(System{std::move(A), std::move(hierarchy),
                                        space.texels().positions, space.scale().texel_spacing,
                                        [&space](const Signal& of) -> StiffnessRows {
                                          return [rows = std::make_shared<ModulatedStiffness>(space, of)](
                                                     auto wanted, auto betas) { return rows->rows(wanted, betas); };
                                        }},
                                 weight, std::move(psi), options);
}

LiveModulation::LiveModulation(const VertexSpace& space, double weight, Signal psi,
                               const LiveOptions& options, const Progress& progress) {
  check(space, weight, psi, options);
  const std::vector<Vector3> positions = space.positions();
  SparseMatrix A = space.system(1, weight, progress.step("assemble", 0.4));
  Hierarchy hierarchy = vertex_hierarchy(A, positions, {}, progress.step("levels", 0.6));
  data_ = std::make_unique<Data>(
      System{std::move(A), std::move(hierarchy), relative_positions(positions),
             std::sqrt(space.scale().area / space.size()),
             [&space](const Signal& of) -> StiffnessRows {
               return [&](std::span<const int> wanted, std::span<const std::span<const double>> betas) {
                 Signal result(std::ssize(wanted), of.cols() * std::ssize(betas));
                 for (std::size_t b = 0; b < betas.size(); ++b)
                   result.middleCols(std::int64_t(b) * of.cols(), of.cols()) =
                       space.stiffness_rows(wanted, of, betas[b]);
                 return result;
               };
             }},
      weight, std::move(psi), options);
}

LiveModulation::~LiveModulation() = default;
LiveModulation::LiveModulation(LiveModulation&&) noexcept = default;

void LiveModulation::modulate(std::span<const int> unknowns, std::span<const double> beta) {
  Data& d = *data_;
  require(unknowns.size() == beta.size(), "one modulation per unknown is needed");
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i] < 0 || unknowns[i] >= d.size() || !std::isfinite(beta[i]))
      throw InvalidInput(fmt::format("a modulation of {} was given for unknown {} of {}", beta[i],
                                     unknowns[i], d.size()));
  const std::size_t known = d.changed.size();
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto k = std::size_t(unknowns[i]);
    if (d.beta[k] == beta[i]) continue;
    d.beta[k] = beta[i];
    d.change[k] = beta[i] - 1;
    if (d.parts() == 2) d.change_of_texture[k] = (beta[i] - 1) * (beta[i] > 1 ? d.texture[k] : 1);
    d.changed.push_back(unknowns[i]);
  }
  if (d.changed.size() == known) return;
  const std::vector<int> rows = d.rows_around(std::span(d.changed).subspan(known));
  const Signal changes = d.change_of_gradients(rows);
  parallel_for(std::ssize(rows), [&](std::int64_t i) {
    const auto now = d.weight * changes.row(i);
    d.r.row(rows[std::size_t(i)]) += now - d.b.row(rows[std::size_t(i)]);
    d.b.row(rows[std::size_t(i)]) = now;
  }, rows_at_once);
}

Followed LiveModulation::follow(const FollowOptions& options) {
  Data& d = *data_;
  if (d.changed.empty() && d.near_bins.empty()) return {};
  d.choose_near();
  d.changed.clear();
  Followed report;
  for (Eigen::Index first = 0; first < d.phi.cols(); first += d.local.lanes()) {
    const Eigen::Index channels = std::min<Eigen::Index>(d.local.lanes(), d.phi.cols() - first);
    d.take_right_hand_side(first, channels);
    const LocalSolve solve =
        d.local.solve({.error = options.error, .max_cycles = options.max_cycles, .enough = options.enough});
    d.add_solution(first, channels);
    report.cycles = std::max(report.cycles, solve.cycles);
    report.error = std::max(report.error, solve.error);
    report.updates += solve.updates;
  }
  d.note(report.error <= options.error ? Data::Progressed::to_the_end : Data::Progressed::in_part);
  for (const int bin : d.unfinished) report.unfinished += std::ssize(d.bins.points_of(bin));
  return report;
}

SolveReport LiveModulation::settle(const SettleOptions& options, const Progress& progress) {
  Data& d = *data_;
  const Hierarchy& h = d.hierarchy;
  Signal delta = d.phi - d.start();
  const SolveReport report = mixed_conjugate_gradients(h.high(), h.low(), h.scaling(),
                                                       h.multigrid(), h.components(), d.b, delta,
                                                       {.tolerance = options.tolerance,
                                                        .max_cycles = options.max_cycles,
                                                        .least_cycles = options.least_cycles},
                                                       progress);
  d.phi = d.start() + delta;
  if (report.converged) d.unfinished.clear();
  parallel_for(d.r.rows(), [&](std::int64_t i) {
    d.r.row(i) = d.b.row(i);
    for (SparseMatrix::InnerIterator entry(d.A, i); entry; ++entry)
      d.r.row(i) -= entry.value() * delta.row(entry.col());
  });
  return report;
}

std::span<const int> LiveModulation::followed() const { return data_->local.rows(); }

std::span<const double> LiveModulation::beta() const { return data_->beta; }

const Signal& LiveModulation::residual() const { return data_->r; }

const Signal& LiveModulation::signal() const { return data_->phi; }

}  // namespace mq
