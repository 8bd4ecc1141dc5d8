// A_FF δ = −A_F· ψ,  φ_F = ψ_F + δ,  with A the stiffness with soft seams and F the free texels;
// where the change is to be smooth, only the seams' part of A stands on the right. What goes too
// far beyond its neighbours then is brought back and held, and the others are solved for once more.

#include "mq/filter/seam_values.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/atlas/seams.h"
#include "mq/atlas/texel_grid.h"
#include "mq/base/error.h"
#include "mq/filter/seam_rows.h"
#include "mq/linear/connected_components.h"

namespace mq {

TexelSpaceOptions soft_seams(const Atlas& atlas, double weight) {
  TexelSpaceOptions options;
  options.seams = TexelSpaceOptions::Seams::soft;
  const double spacing = atlas.texel_spacing();
  options.seam_penalty = spacing > 0 ? weight / spacing : 0;
  return options;
}

std::vector<char> seam_texels(const Surface& surface, const Atlas& atlas, const TexelSpace& space) {
  const Seams seams(surface, atlas);
  const TexelGrid grid(atlas.textures);
  std::vector<char> read(std::size_t(grid.texel_count()), 0);
  for (int e = 0; e < seams.count(); ++e) {
    const auto breaks = seams.breaks(e);
    for (const HalfEdge h : seams.half_edges(e))
      for (std::size_t k = 1; k < breaks.size(); ++k) {
        const TexturePlace p = seams.place(h, (breaks[k - 1] + breaks[k]) / 2);
        for (const int texel : grid.corners(p.texture, p.column, p.row)) read[texel] = 1;
      }
  }
  std::vector<char> result(std::size_t(space.size()));
  for (int i = 0; i < space.size(); ++i) {
    const Texels::Place& at = space.texels().places[i];
    result[i] = read[grid.texel(at.texture, at.x, at.y)];
  }
  return result;
}

namespace {

/// The free texels of components in which something is held.
std::vector<int> regularised_rows(const SparseMatrix& A, const std::vector<char>& free) {
  const std::vector<int> component = connected_components(A);
  std::vector<char> held(free.size(), 0);
  for (std::size_t i = 0; i < free.size(); ++i)
    if (!free[i]) held[component[i]] = 1;
  std::vector<int> rows;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i] && held[component[i]]) rows.push_back(int(i));
  return rows;
}

SparseMatrix submatrix(const SparseMatrix& A, const std::vector<int>& rows,
                       const std::vector<int>& number) {
  SparseMatrix result(Eigen::Index(rows.size()), Eigen::Index(rows.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (SparseMatrix::InnerIterator it(A, rows[k]); it; ++it)
      if (number[it.col()] >= 0) entries.emplace_back(int(k), number[it.col()], it.value());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// Where what came out goes beyond what a texel and its neighbours (or theirs, or all) showed, by
/// more than a part of their range, it is brought back; returns which texels those are. Texels that
/// hardly count can otherwise go anywhere for a little agreement.
std::vector<int> bring_back(const SparseMatrix& A, const Signal& psi,
                            const std::vector<char>& counts, const std::vector<int>& rows,
                            Signal& phi) {
  std::vector<int> brought;
  ValueRange everywhere;  // which few need
  for (const int i : rows) {
    ValueRange range;
    range.extend(A, psi, counts, i);
    if (!range.any())
      for (SparseMatrix::InnerIterator it(A, i); it; ++it)
        range.extend(A, psi, counts, int(it.col()));
    if (!range.any()) {
      if (!everywhere.any())
        for (std::size_t j = 0; j < counts.size(); ++j)
          if (counts[j]) everywhere.extend(psi.row(std::int64_t(j)));
      range = everywhere;
    }
    if (range.bring_back(phi, i)) brought.push_back(i);
  }
  return brought;
}

/// Solves for the rows, with what φ − ψ is at all others.
SolveReport solve_rows(const SparseMatrix& A, const Signal& psi, const Signal& right,
                       const std::vector<int>& rows, const SolverFactory& factory, Signal& phi,
                       const Progress& progress) {
  std::vector<int> number(std::size_t(psi.rows()), -1);
  for (std::size_t k = 0; k < rows.size(); ++k) number[rows[k]] = int(k);
  Signal b(std::ssize(rows), psi.cols()), delta(std::ssize(rows), psi.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    b.row(std::int64_t(k)) = right.row(rows[k]);
    delta.row(std::int64_t(k)) = phi.row(rows[k]) - psi.row(rows[k]);
    for (SparseMatrix::InnerIterator it(A, rows[k]); it; ++it)
      if (number[it.col()] < 0)
        b.row(std::int64_t(k)) -= it.value() * (phi.row(it.col()) - psi.row(it.col()));
  }
  const auto solver = factory(submatrix(A, rows, number), progress.step("prepare", 0.7));
  SolveReport report = solver->solve(b, delta, progress.step("solve", 0.3));
  for (std::size_t k = 0; k < rows.size(); ++k)
    phi.row(rows[k]) = psi.row(rows[k]) + delta.row(std::int64_t(k));
  return report;
}

}  // namespace

Filtered smooth_at_seams(const TexelSpace& space, const Signal& psi, const std::vector<char>& free,
                         Smooth what, const SolverFactory& factory, const Progress& progress) {
  require(psi.rows() == space.size() && std::ssize(free) == space.size(),
          fmt::format("a signal of {} rows and {} marks were given for {} texels", psi.rows(),
                      free.size(), space.size()));
  const SparseMatrix A = space.regularised_system(0, 1, progress.step("assemble", 0.3));
  std::vector<int> rows = regularised_rows(A, free);
  if (rows.empty()) return {psi, nothing_to_solve()};
  const Signal right = seam_imbalance(space, A, psi, rows, what);
  Filtered result{psi, {}};
  result.report =
      solve_rows(A, psi, right, rows, factory, result.signal, progress.step("free", 0.35));
  std::vector<char> counts(free.size(), 1);  // whose ψ means something
  if (what == Smooth::values)
    for (std::size_t i = 0; i < free.size(); ++i) counts[i] = !free[i];
  const std::vector<int> held = bring_back(A, psi, counts, rows, result.signal);
  if (held.empty()) return result;
  std::vector<char> still_free = free;
  for (const int i : held) still_free[i] = 0;
  rows = regularised_rows(A, still_free);
  if (rows.empty()) return result;
  const SolveReport again =
      solve_rows(A, psi, right, rows, factory, result.signal, progress.step("bounded", 0.35));
  result.report.converged = result.report.converged && again.converged;
  bring_back(A, psi, counts, rows, result.signal);
  return result;
}

}  // namespace mq
