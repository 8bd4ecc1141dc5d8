/// With δ = φ − ψ, b = w·S_{β−1}·ψ and r = b − A·δ, everywhere: a change of β changes b, and with it r, in
/// a few rows. Following it solves A_NN·z = r_N on a set N of texels near by, those further off held,
/// and does δ_N += z, r −= A_·N·z. N is all texels within `reach` lengths √w of a ball that is half as
/// large again as one around the changed ones, so that a brush can move on a little; distances are
/// straight ones, which are never longer than those on the surface.

#include "mq/filter/live_modulation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/multigrid_solver.h"

namespace mq {

namespace {

using Point = std::array<float, 3>;

double distance(const Point& a, const Point& b) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) squared += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
  return std::sqrt(squared);
}

struct Ball {
  Point centre = {0, 0, 0};
  double radius = 0;

  bool holds(const Ball& other) const {
    return distance(centre, other.centre) + other.radius <= radius;
  }
};

/// Around the corners of the box around some points.
Ball ball_around(std::span<const int> texels, const std::vector<Point>& positions) {
  Point low = positions[texels[0]], high = low;
  for (const int t : texels)
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], positions[t][i]);
      high[i] = std::max(high[i], positions[t][i]);
    }
  Ball ball;
  for (int i = 0; i < 3; ++i) ball.centre[i] = (low[i] + high[i]) / 2;
  ball.radius = distance(low, high) / 2;
  return ball;
}

/// Some texels as if there were no others, in the same order, and a solver for them.
struct Neighbourhood {
  Ball changes;  ///< where changes may lie
  std::vector<int> members;
  std::vector<int> rows;  ///< the members, and what they couple to
  Texels texels;
  std::unique_ptr<LinearSolver> solver;
};

}  // namespace

struct LiveModulation::Data {
  const TexelSpace& space;
  double weight;
  LiveOptions options;
  Signal psi;
  SparseMatrix A;
  std::vector<double> beta, change;  ///< β and β − 1
  Signal b, r, phi;
  std::vector<int> changed;   ///< since the last `follow`
  std::vector<int> local;     ///< per unknown its number in the neighbourhood, or −1
  Neighbourhood near;
  std::unique_ptr<LinearSolver> everywhere;  ///< null before the first `settle`
  SettleOptions everywhere_until;

  Data(const TexelSpace& s, double weight_, Signal psi_, const LiveOptions& options_,
       const Progress& progress)
      : space(s), weight(weight_), options(options_), psi(std::move(psi_)),
        A(s.solvable(1, weight, progress)), beta(s.size(), 1.0), change(s.size(), 0.0),
        b(Signal::Zero(s.size(), psi.cols())), r(b), phi(psi), local(s.size(), -1) {}

  std::vector<int> rows_around(std::span<const int> texels) const;
  void move_neighbourhood(const Ball& changes);
  SparseMatrix local_matrix() const;
  void add_local(const Signal& z);
};

/// These texels and those A couples them to: where the right-hand side depends on their β.
std::vector<int> LiveModulation::Data::rows_around(std::span<const int> texels) const {
  std::vector<int> rows;
  rows.reserve(10 * texels.size());
  for (const int t : texels)
    for (SparseMatrix::InnerIterator entry(A, t); entry; ++entry) rows.push_back(int(entry.col()));
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

/// A_NN. Its rows are ordered as A's are.
SparseMatrix LiveModulation::Data::local_matrix() const {
  const int n = int(near.members.size());
  SparseMatrix matrix(n, n);
  std::vector<int> starts(n + 1, 0);
  const auto for_each_entry = [&](int row, const auto& visit) {
    for (SparseMatrix::InnerIterator entry(A, near.members[row]); entry; ++entry)
      if (local[entry.col()] >= 0) visit(local[entry.col()], entry.value());
  };
  parallel_for(n, [&](std::int64_t i) {
    int count = 0;
    for_each_entry(int(i), [&](int, double) { ++count; });
    starts[i + 1] = count;
  });
  for (int i = 0; i < n; ++i) starts[i + 1] += starts[i];
  matrix.resizeNonZeros(starts.back());
  std::copy(starts.begin(), starts.end(), matrix.outerIndexPtr());
  parallel_for(n, [&](std::int64_t i) {
    int at = starts[i];
    for_each_entry(int(i), [&](int column, double value) {
      matrix.innerIndexPtr()[at] = column;
      matrix.valuePtr()[at++] = value;
    });
  });
  return matrix;
}

void LiveModulation::Data::move_neighbourhood(const Ball& changes) {
  for (const int k : near.members) local[k] = -1;
  near = {};
  const double reach = options.reach * std::sqrt(weight);
  near.changes = {changes.centre, 1.5 * changes.radius};
  const Texels& all = space.texels();
  for (int k = 0; k < all.size(); ++k)
    if (distance(all.positions[k], near.changes.centre) <= near.changes.radius + reach) {
      local[k] = int(near.members.size());
      near.members.push_back(k);
    }
  for (const int k : near.members) {
    near.texels.places.push_back(all.places[k]);
    near.texels.positions.push_back(all.positions[k]);
    near.texels.chart.push_back(all.chart[k]);
    near.texels.interior.push_back(all.interior[k]);
  }
  near.rows = rows_around(near.members);
  near.solver =
      multigrid_solver(near.texels, {.tolerance = options.tolerance, .max_cycles = 20})(local_matrix(),
                                                                                        {});
}

/// φ_N += z, r −= A_·N·z.
void LiveModulation::Data::add_local(const Signal& z) {
  const Eigen::Index channels = z.cols();
  parallel_for(std::ssize(near.rows), [&](std::int64_t at) {
    const int i = near.rows[at];
    double* const r_i = r.data() + i * channels;
    for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
      const int j = local[entry.col()];
      if (j < 0) continue;
      for (Eigen::Index c = 0; c < channels; ++c) r_i[c] -= entry.value() * z.data()[j * channels + c];
    }
    if (local[i] >= 0) phi.row(i) += z.row(local[i]);
  });
}

LiveModulation::LiveModulation(const TexelSpace& space, double weight, Signal psi,
                               const LiveOptions& options, const Progress& progress) {
  require(weight > 0 && std::isfinite(weight),
          fmt::format("the weight of a live modulation is {}; it must be positive and finite", weight));
  require(psi.rows() == space.size() && psi.cols() > 0 && psi.allFinite(),
          fmt::format("a live modulation of {} texels wants a finite signal of as many rows; one of "
                      "{} × {} was given", space.size(), psi.rows(), psi.cols()));
  data_ = std::make_unique<Data>(space, weight, std::move(psi), options, progress);
}

LiveModulation::~LiveModulation() = default;
LiveModulation::LiveModulation(LiveModulation&&) noexcept = default;

void LiveModulation::modulate(std::span<const int> texels, std::span<const double> beta) {
  Data& d = *data_;
  require(texels.size() == beta.size(), "one modulation per texel is needed");
  for (std::size_t i = 0; i < texels.size(); ++i)
    if (texels[i] < 0 || texels[i] >= d.space.size() || !std::isfinite(beta[i]))
      throw InvalidInput(fmt::format("a modulation of {} was given for unknown {} of {}", beta[i],
                                     texels[i], d.space.size()));
  if (texels.empty()) return;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    d.beta[texels[i]] = beta[i];
    d.change[texels[i]] = beta[i] - 1;
  }
  const std::vector<int> rows = d.rows_around(texels);
  const Signal now = d.weight * d.space.stiffness_rows(rows, d.psi, d.change);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    d.r.row(rows[i]) += now.row(i) - d.b.row(rows[i]);
    d.b.row(rows[i]) = now.row(i);
  }
  d.changed.insert(d.changed.end(), texels.begin(), texels.end());
}

SolveReport LiveModulation::follow() {
  Data& d = *data_;
  if (d.changed.empty() && !d.near.solver) return {.method = "none (nothing was changed)", .residuals = {}};
  if (!d.changed.empty()) {
    const Ball changes = ball_around(d.changed, d.space.texels().positions);
    if (!d.near.solver || !d.near.changes.holds(changes)) d.move_neighbourhood(changes);
    d.changed.clear();
  }
  const Eigen::Index n = Eigen::Index(d.near.members.size());
  Signal B(n, d.psi.cols()), z = Signal::Zero(n, d.psi.cols());
  for (Eigen::Index i = 0; i < n; ++i) B.row(i) = d.r.row(d.near.members[i]);
  const SolveReport report = d.near.solver->solve(B, z);
  d.add_local(z);
  return report;
}

SolveReport LiveModulation::settle(const SettleOptions& options, const Progress& progress) {
  Data& d = *data_;
  const Progress prepare = progress.step("prepare", 0.5);
  if (!d.everywhere || d.everywhere_until.tolerance != options.tolerance ||
      d.everywhere_until.max_cycles != options.max_cycles) {
    d.everywhere.reset();
    d.everywhere = multigrid_solver(d.space.texels(), {.tolerance = options.tolerance,
                                                       .max_cycles = options.max_cycles})(d.A, prepare);
    d.everywhere_until = options;
  }
  Signal delta = d.phi - d.psi;
  const SolveReport report = d.everywhere->solve(d.b, delta, progress.step("solve", 0.5));
  d.phi = d.psi + delta;
  parallel_for(d.r.rows(), [&](std::int64_t i) {
    d.r.row(i) = d.b.row(i);
    for (SparseMatrix::InnerIterator entry(d.A, i); entry; ++entry)
      d.r.row(i) -= entry.value() * delta.row(entry.col());
  });
  return report;
}

std::span<const int> LiveModulation::followed() const { return data_->near.members; }

std::span<const double> LiveModulation::beta() const { return data_->beta; }

const Signal& LiveModulation::signal() const { return data_->phi; }

}  // namespace mq
