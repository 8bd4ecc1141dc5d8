// A_FF δ = −A_F· ψ,  φ_F = ψ_F + δ,  with A the stiffness with soft seams and F the free texels;
// where the change is to be smooth, only the seams' part of A stands on the right.

#include "mq/filter/seam_values.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/atlas/seams.h"
#include "mq/atlas/texel_grid.h"
#include "mq/base/error.h"
#include "mq/fem/elements.h"
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
std::vector<int> solvable_rows(const SparseMatrix& A, const std::vector<char>& free) {
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

/// −A ψ, or of it what seams contribute, for all unknowns.
Signal imbalance(const TexelSpace& space, const SparseMatrix& A, const Signal& psi,
                 const std::vector<int>& rows, Smooth what) {
  Signal result = Signal::Zero(psi.rows(), psi.cols());
  if (what == Smooth::values) {
    for (const int i : rows)
      for (SparseMatrix::InnerIterator it(A, i); it; ++it)
        result.row(i) -= it.value() * (psi.row(it.col()) - psi.row(i));
    return result;
  }
  std::vector<int> labels(std::size_t(psi.rows()), -1);
  for (const int i : rows) labels[i] = i;
  space.for_each_mixed_element(labels, [&](const Element& element) {
    if (!element.own.empty()) return;
    const std::size_t count = element.unknowns.size();
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t m = 0; m < count; ++m)
        result.row(element.unknowns[k]) -=
            element.stiffness[k * count + m] *
            (psi.row(element.unknowns[m]) - psi.row(element.unknowns[k]));
  });
  return result;
}

}  // namespace

Filtered smooth_at_seams(const TexelSpace& space, const Signal& psi, const std::vector<char>& free,
                         Smooth what, const SolverFactory& factory, const Progress& progress) {
  require(psi.rows() == space.size() && std::ssize(free) == space.size(),
          fmt::format("a signal of {} rows and {} marks were given for {} texels", psi.rows(),
                      free.size(), space.size()));
  const SparseMatrix A = space.solvable(0, 1, progress.step("assemble", 0.3));
  const std::vector<int> rows = solvable_rows(A, free);
  if (rows.empty()) return {psi, nothing_to_solve()};
  std::vector<int> number(free.size(), -1);
  for (std::size_t k = 0; k < rows.size(); ++k) number[rows[k]] = int(k);
  const Signal all = imbalance(space, A, psi, rows, what);
  Signal right(Eigen::Index(rows.size()), psi.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) right.row(Eigen::Index(k)) = all.row(rows[k]);
  const auto solver = factory(submatrix(A, rows, number), progress.step("prepare", 0.5));
  Signal delta = Signal::Zero(right.rows(), right.cols());
  Filtered result{psi, solver->solve(right, delta, progress.step("solve", 0.2))};
  for (std::size_t k = 0; k < rows.size(); ++k) result.signal.row(rows[k]) += delta.row(Eigen::Index(k));
  return result;
}

}  // namespace mq
