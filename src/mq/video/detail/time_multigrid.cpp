// Semi-coarsening in time with relaxation of planes. The other way round, lines in time relaxed and
// space coarsened, has the same rates but needs every level of every frame to have the same
// unknowns, which frames whose charts come and go do not have.
//
// A plane's block of A is K_f + diag(d) + WᵀdW, W the weights of the next frame's links to this
// one. Where links are no identities (charts that were laid out anew) WᵀdW has entries off the
// diagonal; the plane solver gets the diagonal matrix of its rows' sums of magnitudes instead,
// which is larger: relaxation stays convergent, and the matrix keeps the pattern of K.
//
// Eigen's sparse matrices are copied where others are moved: they are swapped here, or made in place.

#include "mq/video/detail/time_multigrid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

/// Σ d (e_t − Σ w e_s)(e_t − Σ w e_s)ᵀ over all frames.
SparseMatrix link_matrix(const std::vector<TimePlane>& planes, const std::vector<int>& offsets) {
  Entries entries;
  for (std::size_t f = 1; f < planes.size(); ++f) {
    const TimeLinks& links = planes[f].links;
    for (int t = 0; t < links.rows(); ++t) {
      if (!links.linked(t) || !(planes[f].strength[t] > 0)) continue;
      std::vector<TimeLinks::Entry> row = {{offsets[f] + t, 1.0}};
      for (int e = links.starts[t]; e < links.starts[t + 1]; ++e)
        row.push_back({offsets[f - 1] + links.entries[e].column, -links.entries[e].weight});
      for (const TimeLinks::Entry& a : row)
        for (const TimeLinks::Entry& b : row)
          entries.emplace_back(a.column, b.column, planes[f].strength[t] * a.weight * b.weight);
    }
  }
  return sparse_matrix(offsets.back(), offsets.back(), entries);
}

/// Interpolation to all frames from every second one.
SparseMatrix interpolation(const std::vector<TimeLinks>& links, const std::vector<int>& offsets,
                           const std::vector<int>& coarse_offsets) {
  Entries entries;
  const int frames = int(offsets.size()) - 1;
  for (int f = 0; f < frames; ++f) {
    const int count = offsets[f + 1] - offsets[f];
    if (f % 2 == 0) {
      for (int t = 0; t < count; ++t)
        entries.emplace_back(offsets[f] + t, coarse_offsets[f / 2] + t, 1.0);
      continue;
    }
    std::vector<int> after(count, -1);
    if (f + 1 < frames)
      for (int u = 0; u < links[f + 1].rows(); ++u)
        if (const int t = links[f + 1].nearest(u); t >= 0 && after[t] < 0) after[t] = u;
    for (int t = 0; t < count; ++t) {
      const int before = links[f].nearest(t);
      const double weight = before >= 0 && after[t] >= 0 ? 0.5 : 1.0;
      if (before >= 0) entries.emplace_back(offsets[f] + t, coarse_offsets[f / 2] + before, weight);
      if (after[t] >= 0)
        entries.emplace_back(offsets[f] + t, coarse_offsets[f / 2 + 1] + after[t], weight);
    }
  }
  return sparse_matrix(offsets.back(), coarse_offsets.back(), entries);
}

/// Links over two frames: of the nearest unknown of the nearest one.
TimeLinks composed(const TimeLinks& later, const TimeLinks& earlier) {
  TimeLinks links;
  for (int t = 0; t < later.rows(); ++t) {
    const int between = later.nearest(t);
    const int before = between >= 0 ? earlier.nearest(between) : -1;
    if (before >= 0) links.entries.push_back({before, 1.0});
    links.starts.push_back(int(links.entries.size()));
  }
  return links;
}

/// Every second frame's links to the one before it among these.
std::vector<TimeLinks> coarse_links(const std::vector<TimeLinks>& links) {
  std::vector<TimeLinks> result(1);
  for (std::size_t f = 2; f < links.size(); f += 2)
    result.push_back(composed(links[f], links[f - 1]));
  return result;
}

/// blockdiag(K_f) + T, row by row.
SparseMatrix with_links(const std::vector<SparseMatrix>& blocks, const SparseMatrix& T,
                        const std::vector<int>& offsets) {
  const auto merged = [&](const auto& visit) {  // visit(row, column, value), columns increasing
    for (std::size_t f = 0; f < blocks.size(); ++f)
      for (int row = 0; row < blocks[f].rows(); ++row) {
        SparseMatrix::InnerIterator own(blocks[f], row), link(T, offsets[f] + row);
        while (own || link) {
          const int i = own ? int(own.col()) + offsets[f] : std::numeric_limits<int>::max();
          const int j = link ? int(link.col()) : std::numeric_limits<int>::max();
          const double value = (i <= j ? own.value() : 0) + (j <= i ? link.value() : 0);
          visit(offsets[f] + row, std::min(i, j), value);
          if (i <= j) ++own;
          if (j <= i) ++link;
        }
      }
  };
  std::int64_t entries = 0;
  merged([&](int, int, double) { ++entries; });
  SparseMatrix result(offsets.back(), offsets.back());
  result.reserve(entries);
  int open = -1;
  merged([&](int row, int column, double value) {
    while (open < row) result.startVec(++open);
    result.insertBack(row, column) = value;
  });
  while (open + 1 < offsets.back()) result.startVec(++open);
  result.finalize();
  return result;
}

/// K with what the links add to a frame's own block; see the top.
SparseMatrix plane_matrix(const SparseMatrix& K, const SparseMatrix& links, int offset) {
  SparseMatrix B = K;
  for (int row = 0; row < B.rows(); ++row) {
    double sum = 0;
    for (SparseMatrix::InnerIterator entry(links, offset + row); entry; ++entry)
      if (entry.col() >= offset && entry.col() < offset + B.rows()) sum += std::abs(entry.value());
    if (sum > 0) B.coeffRef(row, row) += sum;
  }
  B.makeCompressed();
  return B;
}

/// How much stronger frames hang together than values do.
double coupling(const std::vector<SparseMatrix>& K, const SparseMatrix& links) {
  double held = 0;
  for (const SparseMatrix& plane : K) held += (plane * Vector::Ones(plane.cols())).sum();
  return links.diagonal().sum() / held;
}

std::vector<int> offsets_of(const std::vector<SparseMatrix>& K) {
  std::vector<int> offsets = {0};
  for (const SparseMatrix& plane : K) {
    const std::int64_t end = std::int64_t(offsets.back()) + plane.rows();
    require(end < std::int64_t(1) << 31,
            "the frames held at once have more than 2 billion texels: hold fewer");
    offsets.push_back(int(end));
  }
  return offsets;
}

/// y = A·x in some rows, subtracted from b.
void residual_rows(const SparseMatrix& A, const Signal& b, const Signal& x, int begin, int end,
                   Signal& r) {
  r.resize(end - begin, b.cols());
  for (int row = begin; row < end; ++row) {
    r.row(row - begin) = b.row(row);
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
      r.row(row - begin) -= entry.value() * x.row(entry.col());
  }
}

}  // namespace

PlaneSolver texel_planes(std::function<const Texels&(int frame)> texels) {
  return [texels](int frame, const SparseMatrix& B) -> Preconditioner {
    Hierarchy levels = texel_hierarchy(B, texels(frame));
    levels.keep_cycle_only();
    const auto hierarchy = std::make_shared<const Hierarchy>(std::move(levels));
    return [hierarchy](const Signal& R, Signal& Z) {
      Z.resize(R.rows(), R.cols());
      const Scaling& scaling = hierarchy->scaling();
      for (int first = 0; first < R.cols(); first += 4) {
        const int channels = std::min(4, int(R.cols()) - first), lanes = lanes_for(channels);
        LaneVector b(R.rows(), lanes), x(R.rows(), lanes);
        parallel_for(R.rows(), [&](std::int64_t k) {
          for (int c = 0; c < channels; ++c)
            b.data()[k * lanes + c] = float(scaling.common * scaling.row(k) * R(k, first + c));
        });
        Multigrid::Workspace workspace(hierarchy->multigrid(), lanes);
        hierarchy->multigrid().cycle(b.data(), x.data(), workspace);
        parallel_for(R.rows(), [&](std::int64_t k) {
          for (int c = 0; c < channels; ++c)
            Z(k, first + c) = scaling.row(k) * x.data()[k * lanes + c];
        });
      }
    };
  };
}

PlaneSolver factored_planes() {
  return [](int, const SparseMatrix& B) -> Preconditioner {
    const auto factor = std::make_shared<const DirectSolver>(B);
    return [factor](const Signal& R, Signal& Z) { Z = factor->solve(R); };
  };
}

TimeMultigrid::TimeMultigrid(std::vector<TimePlane> planes, const PlaneSolver& solver,
                             const TimeMultigridOptions& options, const Progress& progress)
    : options_(options) {
  std::vector<SparseMatrix> K;
  std::vector<TimeLinks> links;
  std::vector<int> frames;
  for (std::size_t f = 0; f < planes.size(); ++f) {
    const TimePlane& plane = planes[f];
    require(plane.K.rows() == plane.K.cols() &&
                (f == 0 ||
                 (plane.links.rows() == plane.K.rows() && plane.strength.size() == plane.K.rows())),
            fmt::format("frame {} has {} unknowns, links of {} and {} strengths", f, plane.K.rows(),
                        plane.links.rows(), plane.strength.size()));
    frames.push_back(int(f));
  }
  K.resize(planes.size());
  for (std::size_t f = 0; f < planes.size(); ++f) K[f].swap(planes[f].K);
  std::vector<int> offsets = offsets_of(K);
  SparseMatrix T = link_matrix(planes, offsets);
  for (TimePlane& plane : planes) links.push_back(std::move(plane.links));
  Vector count = Vector::Ones(offsets.back());  // frames that an unknown stands for
  double left = 1;
  while (true) {
    const bool coarsest = frames.size() == 1 || int(levels_.size()) + 1 >= options.most_levels ||
                          coupling(K, T) < 0.5;
    Level& level = levels_.emplace_back();
    level.offsets = offsets;
    level.planes.resize(frames.size());
    const double share = coarsest ? left : left / 2;
    left -= share;
    std::atomic<int> done = 0;
    parallel_for(
        std::ssize(frames),
        [&](std::int64_t f) {
          progress.check();
          level.planes[f] = solver(frames[f], plane_matrix(K[f], T, offsets[f]));
          progress.at(1 - left - share + share * ++done / double(frames.size()));
        },
        1);
    with_links(K, T, offsets).swap(level.A);
    if (coarsest) break;
    std::vector<SparseMatrix> coarse_K((frames.size() + 1) / 2);
    std::vector<int> coarse_frames;
    for (std::size_t f = 0; f < frames.size(); f += 2) {
      coarse_K[f / 2].swap(K[f]);
      coarse_frames.push_back(frames[f]);
    }
    K.clear();
    const std::vector<int> coarse_offsets = offsets_of(coarse_K);
    interpolation(links, offsets, coarse_offsets).swap(level.P);
    level.R = level.P.transpose();
    const Vector coarse_count = level.R * count;
    for (std::size_t f = 0; f < coarse_K.size(); ++f) {
      const auto rows = coarse_K[f].rows();
      coarse_K[f] *= coarse_count.segment(coarse_offsets[f], rows).mean() /
                     count.segment(offsets[2 * f], rows).mean();
    }
    count = coarse_count;
    SparseMatrix(level.R * SparseMatrix(T * level.P)).swap(T);
    links = coarse_links(links);
    K = std::move(coarse_K);
    frames = std::move(coarse_frames);
    offsets = coarse_offsets;
  }
}

void TimeMultigrid::relax(const Level& level, int parity, const Signal& b, Signal& x) const {
  const int count = (level.frames() - parity + 1) / 2;
  parallel_for(
      count,
      [&](std::int64_t i) {
        const int f = int(2 * i) + parity, begin = level.offsets[f], end = level.offsets[f + 1];
        Signal r, z;
        residual_rows(level.A, b, x, begin, end, r);
        level.planes[f](r, z);
        x.middleRows(begin, end - begin) += z;
      },
      1);
}

void TimeMultigrid::descend(std::size_t l, const Signal& b, Signal& x) const {
  const Level& level = levels_[l];
  if (l + 1 == levels_.size()) {
    for (int i = 0; i < options_.sweeps; ++i) relax(level, 0, b, x), relax(level, 1, b, x);
    for (int i = 0; i < options_.sweeps; ++i) relax(level, 1, b, x), relax(level, 0, b, x);
    return;
  }
  relax(level, 0, b, x);
  relax(level, 1, b, x);
  Signal& r = level.residual;
  r.resize(b.rows(), b.cols());
  parallel_for(b.rows(), [&](std::int64_t row) {
    r.row(row) = b.row(row);
    for (SparseMatrix::InnerIterator entry(level.A, row); entry; ++entry)
      r.row(row) -= entry.value() * x.row(entry.col());
  });
  const auto multiply_into = [](const SparseMatrix& A, const Signal& v, Signal& y) {
    y.resize(A.rows(), v.cols());
    parallel_for(A.rows(), [&](std::int64_t row) {
      y.row(row).setZero();
      for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
        y.row(row) += entry.value() * v.row(entry.col());
    });
  };
  multiply_into(level.R, r, level.below);
  level.correction.setZero(level.below.rows(), level.below.cols());
  descend(l + 1, level.below, level.correction);
  multiply_into(level.P, level.correction, level.change);
  x += level.change;
  relax(level, 1, b, x);
  relax(level, 0, b, x);
}

void TimeMultigrid::cycle(const Signal& R, Signal& Z) const {
  Z = Signal::Zero(R.rows(), R.cols());
  descend(0, R, Z);
}

SolveReport TimeMultigrid::solve(const Signal& B, Signal& X, const Progress& progress) const {
  SolveReport report = conjugate_gradients(
      matrix(), B, X, [&](const Signal& R, Signal& Z) { cycle(R, Z); },
      {.tolerance = options_.tolerance, .max_cycles = options_.max_cycles}, progress);
  report.method = fmt::format("multigrid in space and time, {} levels in time", level_count());
  return report;
}

}  // namespace mq
