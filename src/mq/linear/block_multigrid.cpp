/// P of a block row is w·(c −s; s c), its transpose turns back. Coarse rows of PᵀAP are gathered
/// one by one: the children of a row, their neighbours, the parents of those.

#include "mq/linear/block_multigrid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"

namespace mq {

namespace {

constexpr int piece_rows = 512;  // relaxed one after another by one thread
constexpr int most_dense_rows = 1000;

template <class Real>
using Block = typename BlockMatrix<Real>::Block;

/// (c s; −s c)·B·(c′ −s′; s′ c′).
Block<double> turned_block(const BlockTransfer::Entry& left, const Block<double>& B,
                           const BlockTransfer::Entry& right) {
  const double c = left.cosine, s = left.sine;
  const Block<double> T{c * B[0] + s * B[2], c * B[1] + s * B[3], c * B[2] - s * B[0],
                        c * B[3] - s * B[1]};
  const double d = right.cosine, t = right.sine;
  return {T[0] * d + T[1] * t, T[1] * d - T[0] * t, T[2] * d + T[3] * t, T[3] * d - T[2] * t};
}

struct Scratch {
  std::vector<int> place, columns;
  std::vector<Block<double>> values;
  std::vector<int> order;
};

struct Rows {
  std::vector<int> counts, columns;
  std::vector<Block<double>> blocks;
};

void gather_row(const BlockMatrix<double>& A, const BlockTransfer& P, int row, Scratch& s) {
  s.columns.clear();
  s.values.clear();
  for (int c = P.child_starts[row]; c < P.child_starts[row + 1]; ++c) {
    const BlockTransfer::Entry& child = P.children[c];
    for (int e = A.starts[child.column]; e < A.starts[child.column + 1]; ++e)
      for (int p = P.starts[A.columns[e]]; p < P.starts[A.columns[e] + 1]; ++p) {
        const BlockTransfer::Entry& parent = P.entries[p];
        const Block<double> value = turned_block(child, A.blocks[e], parent);
        int& place = s.place[parent.column];
        if (place < 0) {
          place = int(s.columns.size());
          s.columns.push_back(parent.column);
          s.values.push_back({0, 0, 0, 0});
        }
        for (int k = 0; k < 4; ++k) s.values[place][k] += value[k];
      }
  }
  for (const int column : s.columns) s.place[column] = -1;
}

/// PᵀAP; a coarse row without children, or on which A vanishes, becomes the identity.
BlockMatrix<double> galerkin(const BlockMatrix<double>& A, const BlockTransfer& P,
                             const Progress& progress) {
  constexpr int block_rows = 2048;
  std::vector<Rows> parts((P.columns + block_rows - 1) / block_rows);
  tbb::enumerable_thread_specific<Scratch> scratch;
  parallel_blocks(P.columns, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    Scratch& s = scratch.local();
    s.place.resize(P.columns, -1);
    Rows& part = parts[begin / block_rows];
    for (std::int64_t row = begin; row < end; ++row) {
      gather_row(A, P, int(row), s);
      bool vanishes = true;
      for (const Block<double>& B : s.values)
        for (const double v : B) vanishes = vanishes && v == 0;
      if (vanishes) {
        s.columns.assign(1, int(row));
        s.values.assign(1, {1, 0, 0, 1});
      }
      s.order.resize(s.columns.size());
      std::iota(s.order.begin(), s.order.end(), 0);
      std::sort(s.order.begin(), s.order.end(),
                [&](int a, int b) { return s.columns[a] < s.columns[b]; });
      for (const int i : s.order) {
        part.columns.push_back(s.columns[i]);
        part.blocks.push_back(s.values[i]);
      }
      part.counts.push_back(int(s.columns.size()));
    }
  });
  BlockMatrix<double> C;
  C.starts.assign(1, 0);
  for (const Rows& part : parts)
    for (const int count : part.counts) C.starts.push_back(C.starts.back() + count);
  C.columns.resize(C.starts.back());
  C.blocks.resize(C.starts.back());
  parallel_for(
      std::ssize(parts),
      [&](std::int64_t p) {
        const int at = C.starts[p * block_rows];
        std::copy(parts[p].columns.begin(), parts[p].columns.end(), C.columns.begin() + at);
        std::copy(parts[p].blocks.begin(), parts[p].blocks.end(), C.blocks.begin() + at);
      },
      1);
  return C;
}

/// The diagonal block of a row.
template <class Real>
const Block<Real>& diagonal(const BlockMatrix<Real>& A, int row) {
  const auto* begin = A.columns.data() + A.starts[row];
  const auto* end = A.columns.data() + A.starts[row + 1];
  return A.blocks[std::lower_bound(begin, end, row) - A.columns.data()];
}

/// r = b − A·x in single precision.
void residual(const BlockMatrix<float>& A, const float* b, const float* x, float* r) {
  parallel_for(A.rows(), [&](std::int64_t i) {
    float u = b[2 * i], v = b[2 * i + 1];
    for (int e = A.starts[i]; e < A.starts[i + 1]; ++e) {
      const Block<float>& B = A.blocks[e];
      const float p = x[2 * A.columns[e]], q = x[2 * A.columns[e] + 1];
      u -= B[0] * p + B[1] * q;
      v -= B[2] * p + B[3] * q;
    }
    r[2 * i] = u;
    r[2 * i + 1] = v;
  });
}

/// y = A·x, and ⟨x, y⟩.
double multiply(const BlockMatrix<double>& A, const Vector& x, Vector& y) {
  return parallel_sum(A.rows(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t i = begin; i < end; ++i) {
      double u = 0, v = 0;
      for (int e = A.starts[i]; e < A.starts[i + 1]; ++e) {
        const Block<double>& B = A.blocks[e];
        const double p = x[2 * A.columns[e]], q = x[2 * A.columns[e] + 1];
        u += B[0] * p + B[1] * q;
        v += B[2] * p + B[3] * q;
      }
      y[2 * i] = u;
      y[2 * i + 1] = v;
      sum += u * x[2 * i] + v * x[2 * i + 1];
    }
    return sum;
  });
}

double dot(const Vector& x, const Vector& y) {
  return parallel_sum(x.size(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    return x.segment(begin, end - begin).dot(y.segment(begin, end - begin));
  });
}

/// x += a·y.
void add(Vector& x, double a, const Vector& y) {
  parallel_blocks(x.size(), 16384, [&](std::int64_t begin, std::int64_t end) {
    x.segment(begin, end - begin) += a * y.segment(begin, end - begin);
  });
}

}  // namespace

SparseMatrix scalar_matrix(const BlockMatrix<double>& A) {
  Entries entries;
  for (int i = 0; i < A.rows(); ++i)
    for (int e = A.starts[i]; e < A.starts[i + 1]; ++e)
      for (int k = 0; k < 4; ++k)
        entries.emplace_back(2 * i + k / 2, 2 * A.columns[e] + k % 2, A.blocks[e][k]);
  return sparse_matrix(2 * A.rows(), 2 * A.rows(), entries);
}

void BlockTransfer::finish() {
  child_starts.assign(columns + 1, 0);
  for (const Entry& e : entries) ++child_starts[e.column + 1];
  for (int c = 0; c < columns; ++c) child_starts[c + 1] += child_starts[c];
  std::vector<int> at(child_starts.begin(), child_starts.end() - 1);
  children.resize(entries.size());
  for (int i = 0; i < rows(); ++i)
    for (int e = starts[i]; e < starts[i + 1]; ++e)
      children[at[entries[e].column]++] = {i, entries[e].cosine, entries[e].sine};
}

Vector BlockTransfer::prolongated(const Vector& x) const {
  Vector y(2 * rows());
  parallel_for(rows(), [&](std::int64_t i) {
    double u = 0, v = 0;
    for (int e = starts[i]; e < starts[i + 1]; ++e) {
      const double c = entries[e].cosine, s = entries[e].sine;
      const double p = x[2 * entries[e].column], q = x[2 * entries[e].column + 1];
      u += c * p - s * q;
      v += s * p + c * q;
    }
    y[2 * i] = u;
    y[2 * i + 1] = v;
  });
  return y;
}

BlockMultigrid::BlockMultigrid(std::vector<std::shared_ptr<const BlockTransfer>> transfers,
                               const BlockMultigridOptions& options)
    : transfers_(std::move(transfers)), options_(options), levels_(transfers_.size()) {}

/// Pieces of consecutive rows; those of one colour share no neighbour. Kept while the pattern is.
void BlockMultigrid::order_pieces(Level& level) {
  const BlockMatrix<float>& A = level.matrix;
  const int count = (A.rows() + piece_rows - 1) / piece_rows;
  std::vector<int> colour(count, -1), taken;
  int colours = 0;
  for (int p = 0; p < count; ++p) {
    taken.assign(colours + 1, 0);
    const int end = std::min(A.rows(), (p + 1) * piece_rows);
    for (int e = A.starts[p * piece_rows]; e < A.starts[end]; ++e)
      if (const int c = colour[A.columns[e] / piece_rows]; c >= 0) taken[c] = 1;
    colour[p] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    colours = std::max(colours, colour[p] + 1);
  }
  level.pieces.clear();
  level.colours.assign(1, 0);
  for (int c = 0; c < colours; ++c) {
    for (int p = 0; p < count; ++p)
      if (colour[p] == c) level.pieces.push_back(p);
    level.colours.push_back(int(level.pieces.size()));
  }
}

void BlockMultigrid::set_matrix(BlockMatrix<double> A, const Progress& progress) {
  require(transfers_.empty() || transfers_.front()->rows() == A.rows(),
          fmt::format("a matrix of {} block rows was given for levels of {}", A.rows(),
                      transfers_.empty() ? A.rows() : transfers_.front()->rows()));
  finest_ = std::move(A);
  double trace = 0;
  for (int i = 0; i < finest_.rows(); ++i) {
    const Block<double>& D = diagonal(finest_, i);
    if (!(D[0] > 0 && D[3] > 0 && D[0] * D[3] > D[1] * D[2]))
      throw NotPositiveDefinite(fmt::format(
          "the block of unknowns {} and {} is not positive definite", 2 * i, 2 * i + 1));
    trace += D[0] + D[3];
  }
  scale_ = 2.0 * finest_.rows() / trace;
  BlockMatrix<double> coarse;
  const BlockMatrix<double>* current = &finest_;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    const BlockMatrix<double>& M = *current;
    level.matrix.starts = M.starts;
    level.matrix.columns = M.columns;
    level.matrix.blocks.resize(M.blocks.size());
    level.inverses.resize(M.rows());
    parallel_for(std::ssize(M.blocks), [&](std::int64_t e) {
      for (int k = 0; k < 4; ++k) level.matrix.blocks[e][k] = float(scale_ * M.blocks[e][k]);
    });
    parallel_for(M.rows(), [&](std::int64_t i) {
      const Block<double>& D = diagonal(M, int(i));
      const double f = 1 / (scale_ * (D[0] * D[3] - D[1] * D[2]));
      level.inverses[i] = {float(f * D[3]), float(-f * D[1]), float(-f * D[2]), float(f * D[0])};
    });
    order_pieces(level);
    coarse = galerkin(M, *transfers_[l], progress);
    current = &coarse;
    progress.at(double(l + 1) / double(levels_.size()));
  }
  const SparseMatrix last = scale_ * scalar_matrix(*current);
  sparse_.reset();
  if (last.rows() > most_dense_rows) {
    sparse_.emplace(last, Factorisation::automatic, progress);
    return;
  }
  if (!coarsest_.compute(Eigen::MatrixXd(last)))
    throw NotPositiveDefinite("the coarsest level of a block matrix is not positive definite");
}

/// One sweep, rows ascending (direction 1) or all of that reversed (−1).
void BlockMultigrid::relax(const Level& level, const Vectors& v, std::vector<float>& x,
                           int direction) const {
  const BlockMatrix<float>& A = level.matrix;
  const auto update = [&](int i) {
    float u = v.b[2 * i], w = v.b[2 * i + 1];
    for (int e = A.starts[i]; e < A.starts[i + 1]; ++e) {
      const Block<float>& B = A.blocks[e];
      const float p = x[2 * A.columns[e]], q = x[2 * A.columns[e] + 1];
      u -= B[0] * p + B[1] * q;
      w -= B[2] * p + B[3] * q;
    }
    const std::array<float, 4>& D = level.inverses[i];
    x[2 * i] += D[0] * u + D[1] * w;
    x[2 * i + 1] += D[2] * u + D[3] * w;
  };
  const int count = int(level.colours.size()) - 1;
  for (int k = 0; k < count; ++k) {
    const int c = direction > 0 ? k : count - 1 - k;
    parallel_for(
        level.colours[c + 1] - level.colours[c],
        [&](std::int64_t p) {
          const int first = level.pieces[level.colours[c] + p] * piece_rows;
          const int last = std::min(A.rows(), first + piece_rows);
          if (direction > 0)
            for (int i = first; i < last; ++i) update(i);
          else
            for (int i = last - 1; i >= first; --i) update(i);
        },
        1);
  }
}

void BlockMultigrid::cycle(std::size_t l, std::vector<Vectors>& vectors) const {
  Vectors& v = vectors[l];
  if (l == levels_.size()) {
    const Eigen::Map<const Eigen::VectorXf> b(v.b.data(), std::ssize(v.b));
    const Vector wide = b.cast<double>();
    const Vector x = sparse_ ? Vector(sparse_->solve(wide).col(0)) : Vector(coarsest_.solve(wide));
    Eigen::Map<Eigen::VectorXf>(v.x.data(), std::ssize(v.x)) = x.cast<float>();
    return;
  }
  const Level& level = levels_[l];
  const BlockTransfer& P = *transfers_[l];
  std::fill(v.x.begin(), v.x.end(), 0.0f);
  for (int s = 0; s < options_.sweeps; ++s) relax(level, v, v.x, 1);
  residual(level.matrix, v.b.data(), v.x.data(), v.r.data());
  Vectors& coarse = vectors[l + 1];
  parallel_for(P.columns, [&](std::int64_t j) {
    float p = 0, q = 0;
    for (int e = P.child_starts[j]; e < P.child_starts[j + 1]; ++e) {
      const BlockTransfer::Entry& child = P.children[e];
      const float u = v.r[2 * child.column], w = v.r[2 * child.column + 1];
      p += child.cosine * u + child.sine * w;
      q += child.cosine * w - child.sine * u;
    }
    coarse.b[2 * j] = p;
    coarse.b[2 * j + 1] = q;
  });
  cycle(l + 1, vectors);
  parallel_for(P.rows(), [&](std::int64_t i) {
    for (int e = P.starts[i]; e < P.starts[i + 1]; ++e) {
      const BlockTransfer::Entry& parent = P.entries[e];
      const float p = coarse.x[2 * parent.column], q = coarse.x[2 * parent.column + 1];
      v.x[2 * i] += parent.cosine * p - parent.sine * q;
      v.x[2 * i + 1] += parent.sine * p + parent.cosine * q;
    }
  });
  for (int s = 0; s < options_.sweeps; ++s) relax(level, v, v.x, -1);
}

SolveReport BlockMultigrid::solve(const Vector& b, Vector& x, const Progress& progress) const {
  const Stopwatch watch;
  const std::int64_t size = 2 * std::int64_t(finest_.rows());
  require(
      b.size() == size && x.size() == size,
      fmt::format("{} values and {} unknowns were given for {} rows", b.size(), x.size(), size));
  std::vector<Vectors> vectors(levels_.size() + 1);
  for (std::size_t l = 0; l <= levels_.size(); ++l) {
    const std::size_t rows = l == 0 ? size : 2 * std::size_t(transfers_[l - 1]->columns);
    for (std::vector<float>* v : {&vectors[l].b, &vectors[l].x, &vectors[l].r}) v->assign(rows, 0);
  }
  SolveReport report;
  report.method = "multigrid";
  Vector q(size), r(size), z(size), p = Vector::Zero(size), old = Vector::Zero(size);
  multiply(finest_, x, q);
  r = b - q;
  const double wanted = options_.tolerance * std::sqrt(dot(b, b));
  double norm = std::sqrt(dot(r, r)), form = 1;
  const double start = norm;
  if (!std::isfinite(norm) || !std::isfinite(wanted))
    throw SolverError("a right-hand side or first guess holds a value that is not finite");
  if (start > wanted) report.residuals.push_back(1);
  double last = 0;
  while (norm > wanted && report.cycles < options_.max_cycles) {
    // Single precision sees r of about 1, whatever its unit.
    parallel_for(
        size, [&](std::int64_t i) { vectors[0].b[i] = float(r[i] / norm); }, 16384);
    cycle(0, vectors);
    parallel_for(
        size, [&](std::int64_t i) { z[i] = scale_ * norm * double(vectors[0].x[i]); }, 16384);
    const double descent = dot(z, r);
    // Polak and Ribière: the cycle is symmetric but for rounding.
    const double beta = report.cycles == 0 ? 0 : (descent - dot(z, old)) / last;
    parallel_for(
        size, [&](std::int64_t i) { p[i] = z[i] + beta * p[i]; }, 16384);
    form = multiply(finest_, p, q);
    if (!(form > 0)) break;
    const double step = dot(p, r) / form;
    old = r;
    last = descent;
    add(x, step, p);
    add(r, -step, q);
    norm = std::sqrt(dot(r, r));
    if (!std::isfinite(norm)) throw SolverError("multigrid met a value that is not finite");
    ++report.cycles;
    report.residuals.push_back(norm / start);
    progress.at(std::min(1.0, std::log(norm / start) / std::log(options_.tolerance)));
  }
  report.converged = norm <= wanted;
  report.solve_seconds = watch.seconds();
  return report;
}

}  // namespace mq
