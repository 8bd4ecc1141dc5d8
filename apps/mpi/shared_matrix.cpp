#include "shared_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq::shared {

SharedMatrix::SharedMatrix(const SparseMatrix& A, const Processes& processes, const TexelPart& part,
                           const Numbering& numbering)
    : rows_(numbering.own_count()) {
  require(numbering.total() < std::numeric_limits<PetscInt>::max(),
          fmt::format("the model has {} texels, more than this build of PETSc counts: build with one that has 64-bit "
                      "indices (libpetsc64-real-dev)",
                      numbering.total()));
  const auto first = numbering.first(), end = first + rows_;
  const std::vector<std::int64_t>& numbers = numbering.numbers();
  std::vector<PetscInt> own(std::size_t(rows_), 0), others(std::size_t(rows_), 0);
  for (std::int64_t n = 0; n < rows_; ++n)
    for (SparseMatrix::InnerIterator entry(A, part.own()[std::size_t(n)]); entry; ++entry) {
      const std::int64_t column = numbers[std::size_t(entry.col())];
      ++(column >= first && column < end ? own : others)[std::size_t(n)];
    }
  const auto rows = PetscInt(rows_), total = PetscInt(numbering.total());
  check(MatCreateAIJ(PETSC_COMM_WORLD, rows, rows, total, total, 0, own.data(), 0, others.data(), matrix_.place()));
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  std::vector<PetscInt> columns;
  for (std::int64_t n = 0; n < rows_; ++n) {
    columns.clear();
    const int i = part.own()[std::size_t(n)];
    for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry)
      columns.push_back(PetscInt(numbers[std::size_t(entry.col())]));
    require(std::ranges::all_of(columns, [](PetscInt column) { return column >= 0; }),
            fmt::format("internal error: texel {} couples to one that no process has", n));
    const auto row = PetscInt(first + n);
    check(MatSetValues(matrix_, 1, &row, PetscInt(columns.size()), columns.data(), A.valuePtr() + A.outerIndexPtr()[i],
                       INSERT_VALUES));
  }
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix_, MAT_SPD, PETSC_TRUE));
  check(MatCreateVecs(matrix_, x_.place(), y_.place()));
  find_blocks(processes, numbering);
}

void SharedMatrix::find_blocks(const Processes& processes, const Numbering& numbering) {
  std::vector<std::int64_t> wanted;
  if (processes.count() == 1) {
    own_block_ = matrix_;
  } else {
    const PetscInt* columns = nullptr;
    check(MatMPIAIJGetSeqAIJ(matrix_, &own_block_, &other_block_, &columns));
    PetscInt count = 0;
    check(MatGetSize(other_block_, nullptr, &count));
    wanted.assign(columns, columns + count);
  }
  halo_.emplace(processes, numbering, wanted);
}

namespace {

/// AX += A·X, or AX = A·X, of PETSc's matrix of one process.
enum class Product { set, add };
void multiply_block(Mat A, const Signal& X, Product how, Signal& AX) {
  PetscInt rows = 0;
  const PetscInt *starts = nullptr, *columns = nullptr;
  PetscBool done = PETSC_FALSE;
  const PetscScalar* values = nullptr;
  check(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &rows, &starts, &columns, &done));
  check(MatSeqAIJGetArrayRead(A, &values));
  if (how == Product::set) AX.setZero(rows, X.cols());
  const auto walk = [&]<int channels>() {
    using Row = Eigen::Array<double, channels, 1>;
    const Eigen::Index width = X.cols();
    parallel_for(rows, [&](std::int64_t i) {
      Eigen::Map<Row> to(AX.data() + i * width, width);
      Row sum = to;
      for (PetscInt k = starts[i]; k < starts[i + 1]; ++k)
        sum += values[k] * Eigen::Map<const Row>(X.data() + columns[k] * width, width);
      to = sum;
    });
  };
  switch (X.cols()) {
    case 1: walk.template operator()<1>(); break;
    case 3: walk.template operator()<3>(); break;
    case 4: walk.template operator()<4>(); break;
    default: walk.template operator()<Eigen::Dynamic>();
  }
  check(MatSeqAIJRestoreArrayRead(A, &values));
  check(MatRestoreRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &rows, &starts, &columns, &done));
}

}  // namespace

void SharedMatrix::multiply(const Signal& X, Signal& AX) const {
  const Signal of_others = halo_->fetched(X);
  multiply_block(own_block_, X, Product::set, AX);
  if (other_block_) multiply_block(other_block_, of_others, Product::add, AX);
}

SharedSystem shared_system(const SharedMatrix& matrix, const Processes& processes) {
  return {.multiply = [&](const Signal& of, Signal& product) { matrix.multiply(of, product); },
          .sum = [&](std::span<double> values) { processes.sum(values); },
          .largest = [&](std::span<double> values) { processes.largest(values); }};
}

}  // namespace mq::shared
