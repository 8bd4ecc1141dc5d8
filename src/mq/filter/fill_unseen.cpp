// Of S φ = 0 the rows of unknown values u, with known ones k on the right:
//
//     (S_uu + ε D) φ_u = ε D ψ_u − S_uk ψ_k ,    D = diag S_uu ,
//
// where ε = 1e-9 decides what nothing else does: parts of which nothing is known keep ψ, and a hole
// R texels wide is harmonic to about ε R².

#include "mq/filter/fill_unseen.h"

#include <fmt/format.h>

#include <vector>

#include "mq/base/error.h"
#include "mq/linear/direct.h"

namespace mq {

Signal fill_unseen(const SignalSpace& space, std::span<const char> known, const Signal& psi) {
  constexpr double hold = 1e-9;  // ε
  require(psi.rows() == space.size() && std::ssize(known) == space.size(),
          fmt::format("{} values, of which {} are known or not: wanted {}, one for each unknown",
                      psi.rows(), known.size(), space.size()));
  std::vector<int> row(known.size(), -1), unknown;
  for (int t = 0; t < space.size(); ++t)
    if (!known[t]) row[t] = int(unknown.size()), unknown.push_back(t);
  if (unknown.empty()) return psi;

  const SparseMatrix S = space.regularised_system(0, 1);
  std::vector<Eigen::Triplet<double>> entries;
  Signal b = Signal::Zero(std::ssize(unknown), psi.cols());
  for (const int t : unknown) {
    for (SparseMatrix::InnerIterator it(S, t); it; ++it)
      if (row[it.col()] >= 0)
        entries.emplace_back(row[t], row[it.col()], it.value());
      else
        b.row(row[t]) -= it.value() * psi.row(it.col());
    const double diagonal = S.coeff(t, t);  // 0: it meets nothing
    const double held = diagonal > 0 ? hold * diagonal : 1;
    entries.emplace_back(row[t], row[t], held);
    b.row(row[t]) += held * psi.row(t);
  }
  SparseMatrix A(std::ssize(unknown), std::ssize(unknown));
  A.setFromTriplets(entries.begin(), entries.end());
  const Signal found = DirectSolver(A).solve(b);

  Signal filled = psi;
  const Eigen::RowVectorXd low = psi.colwise().minCoeff(), high = psi.colwise().maxCoeff();
  for (const int t : unknown) filled.row(t) = found.row(row[t]).cwiseMax(low).cwiseMin(high);
  return filled;
}

}  // namespace mq
