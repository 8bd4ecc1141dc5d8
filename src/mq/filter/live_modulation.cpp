/// With δ = φ − ψ, b = w·S_{β−1}·ψ and r = b − A·δ, everywhere: a change of β changes b, and with
/// it r, in a few rows. Following it solves A_NN·z = r_N on the set N of unknowns near by, those
/// further off held, and does δ_N += z, r −= A_·N·z. N is what lies within `reach` lengths √w of
/// the changed ones; distances are straight ones, which are never longer than those on the surface.
///
/// z is solved for in single precision until nobody sees what is left of it; r is in double, so
/// that nothing of that is lost.

#include "mq/filter/live_modulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/release.h"
#include "mq/fem/point_bins.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/fem/vertex_hierarchy.h"
#include "mq/linear/local_multigrid.h"

namespace mq {

namespace {

constexpr double least_reach = 8;      // unknowns: as many as relaxation sees
constexpr double bins_per_reach = 2;   // along an axis
constexpr double most_to_keep = 1.25;  // times the bins needed: else another N is chosen

}  // namespace

/// What is solved, whatever the unknowns are.
struct LiveModulation::System {
  SparseMatrix A;
  Hierarchy hierarchy;
  std::vector<std::array<float, 3>> places;  ///< of the unknowns, from somewhere
  double spacing;                            ///< between them, in model units
  /// S_β·ψ in some rows.
  std::function<Signal(std::span<const int> rows, const Signal& psi, std::span<const double> beta)>
      stiffness_rows;
};

struct LiveModulation::Data {
  double weight;
  Signal psi;
  System system;
  const SparseMatrix& A = system.A;
  const Hierarchy& hierarchy = system.hierarchy;
  LocalMultigrid local;
  double reach;  ///< in model units
  PointBins bins;
  std::vector<double> beta, change;  ///< β and β − 1
  std::vector<double> texture, change_of_texture;  ///< empty, or the part of it, and of β − 1 what it is
  Signal b, r, phi;
  std::vector<int> changed;    ///< since the last `follow`
  std::vector<int> near_bins;  ///< whose unknowns are N
  std::vector<int> around;     ///< N and the rows it couples to
  RowSet rows;                 ///< empty between calls

  Data(System of_space, double weight_, Signal psi_, const LiveOptions& options)
      : weight(weight_),
        psi(std::move(psi_)),
        system(std::move(of_space)),
        local(hierarchy.multigrid(), lanes_for(int(psi.cols()) * (options.texture.empty() ? 1 : 2))),
        reach(std::max(options.reach * std::sqrt(weight), least_reach * system.spacing)),
        bins(system.places, reach / bins_per_reach),
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
  Signal right_hand_side(std::span<const int> wanted) const;
  std::vector<int> rows_around(std::span<const int> unknowns);
  void choose_near();
  void take_right_hand_side(Eigen::Index first, Eigen::Index channels);
  template <int channels>
  void add_solution(Eigen::Index first);
};

/// These and those A couples them to: where the right-hand side depends on their β.
std::vector<int> LiveModulation::Data::rows_around(std::span<const int> unknowns) {
  for (const int k : unknowns)
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) rows.add(int(entry.col()));
  std::vector<int> result = rows.rows();
  rows.clear();
  return result;
}

/// w·S_{β−1}·ψ in some rows, and the same for texture's part.
Signal LiveModulation::Data::right_hand_side(std::span<const int> wanted) const {
  Signal result(std::ssize(wanted), phi.cols());
  result.leftCols(psi.cols()) = weight * system.stiffness_rows(wanted, psi, change);
  if (parts() == 2) result.rightCols(psi.cols()) = weight * system.stiffness_rows(wanted, psi, change_of_texture);
  return result;
}

/// N is to hold what lies around the changes, and not much more.
void LiveModulation::Data::choose_near() {
  std::vector<int> needed = bins.around(changed, reach);
  if (std::ranges::includes(near_bins, needed) &&
      double(near_bins.size()) <= most_to_keep * double(needed.size()))
    return;
  near_bins = std::move(needed);
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
  });
}

/// φ_N += z, r −= A_·N·z.
template <int channels>
void LiveModulation::Data::add_solution(Eigen::Index first) {
  using Row = Eigen::Array<double, channels, 1>;
  const Scaling& scaling = hierarchy.scaling();
  const int lanes = local.lanes();
  const auto z = [&, x = local.solution()](int i) {
    const auto of_row = Eigen::Array<float, channels, 1>::Map(x + std::int64_t(i) * lanes);
    return Row(of_row.template cast<double>() * scaling.row(i));
  };
  parallel_for(std::ssize(around), [&](std::int64_t at) {
    const int i = around[at];
    Row product = Row::Zero();
    for (int e = A.outerIndexPtr()[i]; e < A.outerIndexPtr()[i + 1]; ++e)
      product += A.valuePtr()[e] * z(A.innerIndexPtr()[e]);
    Row::Map(r.data() + i * r.cols() + first) -= product;
    Row::Map(phi.data() + i * phi.cols() + first) += z(i);
  });
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
                                        [&space](auto rows, const Signal& of, auto beta) {
                                          return space.stiffness_rows(rows, of, beta);
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
             [&space](auto rows, const Signal& of, auto beta) {
               return space.stiffness_rows(rows, of, beta);
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
  if (unknowns.empty()) return;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    d.beta[unknowns[i]] = beta[i];
    d.change[unknowns[i]] = beta[i] - 1;
    if (d.parts() == 2)
      d.change_of_texture[unknowns[i]] = (beta[i] - 1) * (beta[i] > 1 ? d.texture[unknowns[i]] : 1);
  }
  const std::vector<int> rows = d.rows_around(unknowns);
  const Signal now = d.right_hand_side(rows);
  parallel_for(std::ssize(rows), [&](std::int64_t i) {
    for (Eigen::Index c = 0; c < now.cols(); ++c) {
      double& b = d.b(rows[i], c);
      d.r(rows[i], c) += now(i, c) - b;
      b = now(i, c);
    }
  });
  d.changed.insert(d.changed.end(), unknowns.begin(), unknowns.end());
}

Followed LiveModulation::follow(const FollowOptions& options) {
  Data& d = *data_;
  if (d.changed.empty() && d.near_bins.empty()) return {};
  if (!d.changed.empty()) d.choose_near();
  d.changed.clear();
  Followed report;
  for (Eigen::Index first = 0; first < d.phi.cols(); first += 4) {
    const Eigen::Index channels = std::min<Eigen::Index>(4, d.phi.cols() - first);
    d.take_right_hand_side(first, channels);
    const LocalSolve solve =
        d.local.solve({.error = options.error, .max_cycles = options.max_cycles});
    switch (channels) {
      case 1: d.add_solution<1>(first); break;
      case 2: d.add_solution<2>(first); break;
      case 3: d.add_solution<3>(first); break;
      default: d.add_solution<4>(first);
    }
    report.cycles = std::max(report.cycles, solve.cycles);
    report.error = std::max(report.error, solve.error);
    report.updates += solve.updates;
  }
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
  parallel_for(d.r.rows(), [&](std::int64_t i) {
    d.r.row(i) = d.b.row(i);
    for (SparseMatrix::InnerIterator entry(d.A, i); entry; ++entry)
      d.r.row(i) -= entry.value() * delta.row(entry.col());
  });
  return report;
}

std::span<const int> LiveModulation::followed() const { return data_->local.rows(); }

std::span<const double> LiveModulation::beta() const { return data_->beta; }

const Signal& LiveModulation::signal() const { return data_->phi; }

}  // namespace mq
