#include "subdomain.h"

#include <algorithm>
#include <span>

namespace mq::shared {

Subdomain::Subdomain(const TexelPart& part, const Numbering& numbering, const SparseMatrix& A, double weight) {
  if (part.empty()) return;
  const int self = part.owner()[std::size_t(part.own().front())];
  SparseMatrix sum = A;
  std::fill_n(sum.valuePtr(), sum.nonZeros(), 0.0);
  // What an element does not depend on, though it couples it, is left out: nothing would be on its diagonal.
  std::vector<char> used(std::size_t(sum.rows()), 0);
  part.space().for_each_summand(1, weight, [&](std::span<const int> unknowns, std::span<const double> values) {
    if (unknowns.empty() || part.owner()[std::size_t(*std::ranges::min_element(unknowns))] != self) return;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      used[std::size_t(unknowns[i])] |= values[i * (unknowns.size() + 1)] > 0;
      for (std::size_t j = 0; j < unknowns.size(); ++j)
        sum.coeffRef(unknowns[i], unknowns[j]) += values[i * unknowns.size() + j];
    }
  });
  std::vector<int> row(used.size(), -1);
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) row[i] = int(numbers.size()), numbers.push_back(numbering.numbers()[i]);
  // Zeros stay: PETSc's BDDC hands MUMPS, which refuses it, what couples a texel by itself to others: nothing.
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < sum.rows(); ++i)
    for (SparseMatrix::InnerIterator entry(sum, i); used[std::size_t(i)] && entry; ++entry) {
      const int column = row[std::size_t(entry.col())];
      if (column >= 0) entries.emplace_back(row[std::size_t(i)], column, entry.value());
    }
  matrix.resize(std::ssize(numbers), std::ssize(numbers));
  matrix.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace mq::shared
