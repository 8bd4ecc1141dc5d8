#include "mq/linear/stencil_rows.h"

#include <cstring>

#include "mq/base/parallel.h"
#include "mq/base/parallel_values.h"

namespace mq {

std::vector<int> runs_of_rows(const StencilLayout& layout) {
  std::vector<int> run_of(std::size_t(layout.rows), -1);
  parallel_for(std::ssize(layout.runs), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[std::size_t(r)];
    std::fill_n(run_of.begin() + run.first, run.count, int(r));
  }, 64);
  return run_of;
}

void StencilRows::make_room(const StencilLayout& layout) {
  has_stencils_ = !layout.runs.empty();
  if (!has_stencils_) return;
  for (auto& values : values_) {
    values.resize(std::size_t(layout.rows) + 2 * margin);
    parallel_fill(values.data(), std::ssize(values), 0.0);
  }
}

/// A row's own values on and after the diagonal, and before it those of neighbours that are no stencils.
StencilRows::StencilRows(const SparseMatrix& A, const StencilLayout& layout)
    : listed_(&A), entries_(A.nonZeros()) {
  make_room(layout);
  std::vector<char> irregular(std::size_t(layout.rows), 0);
  for (const int k : layout.irregular) irregular[std::size_t(k)] = 1;
  parallel_for(std::ssize(layout.runs), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[std::size_t(r)];
    const bool alone = std::memchr(irregular.data() + run.up - 1, 1, std::size_t(run.count) + 2) == nullptr;
    const double* row = A.valuePtr() + A.outerIndexPtr()[run.first];
    for (int i = 0; i < run.count; ++i, row += 9) {
      const int k = run.first + i, up = run.up + i;
      at(k, Coupling::centre) = row[4];
      at(k, Coupling::right) = row[5];
      at(k, Coupling::lower_left) = row[6];
      at(k, Coupling::lower) = row[7];
      at(k, Coupling::lower_right) = row[8];
      if (irregular[std::size_t(k - 1)]) at(k - 1, Coupling::right) = row[3];
      if (alone) continue;
      if (irregular[std::size_t(up - 1)]) at(up - 1, Coupling::lower_right) = row[0];
      if (irregular[std::size_t(up)]) at(up, Coupling::lower) = row[1];
      if (irregular[std::size_t(up + 1)]) at(up + 1, Coupling::lower_left) = row[2];
    }
  }, 64);
}

StencilRows::StencilRows(std::unique_ptr<SparseMatrix> irregular, const StencilLayout& layout)
    : own_(std::move(irregular)), listed_(own_.get()),
      entries_(own_->nonZeros() + 9 * (std::int64_t(layout.rows) - std::ssize(layout.irregular))) {
  make_room(layout);
}

namespace {

/// Where each row begins and the last ends; `size(row)` is asked in parallel.
template <class Size>
void begin_rows(SparseMatrix& A, const Size& size) {
  int* const starts = A.outerIndexPtr();
  parallel_for(A.rows(), [&](std::int64_t k) { starts[k + 1] = size(int(k)); }, 4096);
  starts[0] = 0;
  for (std::int64_t k = 0; k < A.rows(); ++k) starts[k + 1] += starts[k];
  A.resizeNonZeros(starts[A.rows()]);
}

int size_of_row(const SparseMatrix& A, int k) { return A.outerIndexPtr()[k + 1] - A.outerIndexPtr()[k]; }

void copy_row(const SparseMatrix& from, int k, SparseMatrix& to) {
  const int begin = from.outerIndexPtr()[k], count = size_of_row(from, k), at = to.outerIndexPtr()[k];
  std::copy_n(from.innerIndexPtr() + begin, count, to.innerIndexPtr() + at);
  std::copy_n(from.valuePtr() + begin, count, to.valuePtr() + at);
}

/// The stencils that are wanted, and of the other rows what is listed.
template <class IsWanted>
void compress(const StencilRows& A, const StencilLayout& layout, const IsWanted& is_wanted, SparseMatrix& to) {
  const std::vector<int> run_of = runs_of_rows(layout);
  const auto from_run = [&](int k) { return run_of[std::size_t(k)] >= 0 && is_wanted(k); };
  begin_rows(to, [&](int k) { return from_run(k) ? 9 : size_of_row(A.listed(), k); });
  parallel_for(layout.rows, [&](std::int64_t k) {
    if (!from_run(int(k))) return copy_row(A.listed(), int(k), to);
    const StencilRun& run = layout.runs[std::size_t(run_of[std::size_t(k)])];
    const int at = to.outerIndexPtr()[k], i = int(k) - run.first;
    std::ranges::copy(stencil_columns(run, i), to.innerIndexPtr() + at);
    std::ranges::copy(A.stencil(run, i), to.valuePtr() + at);
  }, 4096);
}

}  // namespace

void StencilRows::list_clustered(const StencilLayout& layout) {
  if (!own_ || layout.clustered.empty()) return;
  std::vector<char> clustered(std::size_t(layout.rows), 0);
  for (const int k : layout.clustered) clustered[std::size_t(k)] = 1;
  auto all = std::make_unique<SparseMatrix>(layout.rows, layout.rows);
  compress(*this, layout, [&](int k) { return clustered[std::size_t(k)] != 0; }, *all);
  own_ = std::move(all);
  listed_ = own_.get();
}

SparseMatrix StencilRows::matrix(const StencilLayout& layout) const {
  SparseMatrix A(layout.rows, layout.rows);
  compress(*this, layout, [](int) { return true; }, A);
  return A;
}

}  // namespace mq
