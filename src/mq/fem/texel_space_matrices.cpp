// Matrices are gathered row by row from the integrals of the (at most four) cells around a texel
// and from the seam blocks it takes part in, so that rows are independent: any number of threads,
// one result. A row whose texel no seam touches is a 3 × 3 stencil and takes a path of its own.

#include "mq/fem/texel_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/grid_levels.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

namespace {

/// The terms of one row after another, those of one column added up: found by a small hash table.
/// For one thread.
class RowTerms {
 public:
  void start() {
    terms_.clear();
    if (++row_ == 0) clear(slots_.size());
  }

  void add(int column, double value) {
    const std::uint64_t key = key_of(column);
    Slot& slot = slots_[slot_of(key)];
    if (slot.key == key) {
      terms_[slot.term].value += value;
      return;
    }
    slot = {key, int(terms_.size())};
    terms_.push_back({column, value});
    if (2 * terms_.size() > slots_.size()) grow();
  }

  int count() const { return int(terms_.size()); }

  /// Their columns increasing. The row takes no further terms.
  const std::vector<RowTerm>& sorted() {
    std::sort(terms_.begin(), terms_.end(),
              [](const RowTerm& p, const RowTerm& q) { return p.column < q.column; });
    return terms_;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;  ///< which row and column; of another row, that it is empty
    int term = 0;
  };

  std::uint64_t key_of(int column) const { return std::uint64_t(row_) << 32 | std::uint32_t(column); }
  /// The slot that has the key, or the empty one that is to have it.
  std::size_t slot_of(std::uint64_t key) const {
    constexpr std::uint32_t golden_ratio = 2654435769U;  // times 2^32
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = (std::uint32_t(key) * golden_ratio >> 12) & mask;
    while (slots_[at].key != key && slots_[at].key >> 32 == row_) at = (at + 1) & mask;
    return at;
  }
  void clear(std::size_t size) {
    slots_.assign(size, {});
    row_ = 1;
  }
  void grow() {
    clear(2 * slots_.size());
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      const std::uint64_t key = key_of(terms_[k].column);
      slots_[slot_of(key)] = {key, int(k)};
    }
  }

  std::uint32_t row_ = 0;  ///< a number of the row at hand
  std::vector<Slot> slots_ = std::vector<Slot>(128);  ///< a power of two
  std::vector<RowTerm> terms_;
};

RowTerms& row_terms() {
  thread_local RowTerms terms;
  return terms;
}

}  // namespace

int TexelSpace::Data::row_size(int i) const {
  const Texels::Place& at = texels.places[i];
  if (is_grid_row(i)) {
    const int width = grid.texture(at.texture).width + 1;
    const int* cell = cells.kind.data() + grid.cell(at.texture, at.x - 1, at.y - 1);
    const bool c00 = cell[0] >= 0, c10 = cell[1] >= 0, c01 = cell[width] >= 0,
               c11 = cell[width + 1] >= 0;
    return 1 + c00 + c10 + c01 + c11 + (c00 || c10) + (c01 || c11) + (c00 || c01) + (c10 || c11);
  }
  RowTerms& terms = row_terms();
  terms.start();
  for_each_cell(at, [&](const Incidence& in) {
    if (!active(in.cell)) return;
    for (const int corner : in.corners) terms.add(unknown[corner], 0);
  });
  for (const Part& part : blocks_of(i)) {
    const SeamBlocks::Block& block = cells.seams.blocks[part.block];
    for (int k = 0; k < block.count; ++k) terms.add(cells.seams.texels[block.first + k], 0);
  }
  return terms.count();
}

namespace {

/// Adds row `corner` of a cell's a·M + b·S to those of the 3 × 3 texels around that corner.
template <int corner>
inline void add_cell(const CellIntegrals& cell, double a, double b, double* sums) {
  double diagonal = 0;
  const auto add = [&]<int d>(std::integral_constant<int, d>) {
    double& sum = sums[place_around(corner, d)];
    sum += a * cell.mass[mass_at[corner][d]];
    if constexpr (d != corner) {
      const double s = b * cell.stiffness[stiffness_at[corner][d]];
      sum += s;
      diagonal -= s;
    }
  };
  add(std::integral_constant<int, 0>()), add(std::integral_constant<int, 1>());
  add(std::integral_constant<int, 2>()), add(std::integral_constant<int, 3>());
  sums[4] += diagonal;
}

}  // namespace

TexelSpace::Data::GridRow TexelSpace::Data::grid_row(const Texels::Place& at, double a, double b,
                                                      std::span<const float> conductivity) const {
  const int width = grid.texture(at.texture).width;
  const int first = grid.first_cell(at.texture) + at.y * (width + 1) + at.x;
  GridRow row;
  const auto add = [&]<int corner>(std::integral_constant<int, corner>) {
    const int id = first + 1 - (corner & 1) + (1 - (corner >> 1)) * (width + 1);
    if (!active(id)) return;
    for (int d = 0; d < 4; ++d) row.coupled[place_around(corner, d)] = true;
    add_cell<corner>(integrals(id), a, conductivity.empty() ? b : b * conductivity[id], row.values.data());
  };
  add(std::integral_constant<int, 3>()), add(std::integral_constant<int, 2>());
  add(std::integral_constant<int, 1>()), add(std::integral_constant<int, 0>());
  return row;
}

const std::vector<RowTerm>& TexelSpace::Data::terms_of_row(int i, double a, double b,
                                                           std::span<const float> conductivity) const {
  RowTerms& terms = row_terms();
  terms.start();
  const auto add = [&](int j, double m, double s) { terms.add(j, a * m + b * s); };
  if (const Texels::Place& at = texels.places[i]; inner(at)) {
    const GridRow row = grid_row(at, a, b, conductivity);
    const int* const around = unknowns_around(at);
    const int width = grid.texture(at.texture).width;
    for (int n = 0; n < 9; ++n)
      if (row.coupled[n]) terms.add(around[n / 3 * width + n % 3], row.values[n]);
    for_each_block_coupling(i, conductivity, add);
  } else {
    for_each_coupling(i, conductivity, add);
  }
  return terms.sorted();
}

void TexelSpace::Data::fill_grid_row(int i, double a, double b, std::span<const float> conductivity,
                                     int* columns, double* values) const {
  const Texels::Place& at = texels.places[i];
  const GridRow row = grid_row(at, a, b, conductivity);
  const int* const around = unknowns_around(at);
  const int width = grid.texture(at.texture).width;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x)
      if (row.coupled[3 * y + x]) {
        *columns++ = around[y * width + x];
        *values++ = row.values[3 * y + x];
      }
}

namespace {

/// sizes[i] becomes where row i begins; there is one place more, for the end of the last row.
void add_up(std::span<int> sizes) {
  std::int64_t sum = 0;
  for (int& size : sizes) {
    const std::int64_t here = sum;
    sum += size;
    size = int(std::min<std::int64_t>(here, INT32_MAX));
  }
  require(sum < INT32_MAX,
          fmt::format("the {} texels that the charts use make a system of more than 2^31 entries "
                      "(texels couple to 8 others): use smaller textures",
                      sizes.size() - 1));
}

}  // namespace

std::vector<int> TexelSpace::Data::row_starts() const {
  std::vector<int> starts(std::size_t(texels.size()) + 1, 0);
  parallel_for(texels.size(), [&](std::int64_t i) { starts[std::size_t(i)] = row_size(int(i)); }, 4096);
  add_up(starts);
  return starts;
}

SparseMatrix TexelSpace::Data::assemble(double a, double b, std::span<const float> conductivity,
                                        const Progress& progress) const {
  require_integrals();
  // How long a row at a seam is, its terms tell: these are found before the others, and kept.
  constexpr std::int64_t block_rows = 4096;
  const std::int64_t n = texels.size();
  SparseMatrix matrix(n, n);
  int* const starts = matrix.outerIndexPtr();
  std::vector<std::vector<RowTerm>> at_seams(std::size_t((n + block_rows - 1) / block_rows));
  parallel_blocks(n, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    std::vector<RowTerm>& found = at_seams[std::size_t(begin / block_rows)];
    for (std::int64_t i = begin; i < end; ++i) {
      if (is_grid_row(int(i))) {
        starts[i] = row_size(int(i));
        continue;
      }
      const std::vector<RowTerm>& terms = terms_of_row(int(i), a, b, conductivity);
      found.insert(found.end(), terms.begin(), terms.end());
      starts[i] = int(terms.size());
    }
  });
  add_up({starts, std::size_t(n) + 1});
  matrix.resizeNonZeros(starts[n]);
  parallel_blocks(n, block_rows, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    std::vector<RowTerm> found = std::move(at_seams[std::size_t(begin / block_rows)]);
    auto next = found.begin();
    for (std::int64_t i = begin; i < end; ++i) {
      int* columns = matrix.innerIndexPtr() + starts[i];
      double* values = matrix.valuePtr() + starts[i];
      if (is_grid_row(int(i)))
        fill_grid_row(int(i), a, b, conductivity, columns, values);
      else
        for (const auto stop = next + (starts[i + 1] - starts[i]); next != stop; ++next)
          *columns++ = next->column, *values++ = next->value;
    }
  });
  return matrix;
}

std::array<int, 2> TexelSpace::Data::stencil_middles(int i) const {
  if (!is_grid_row(i) || row_size(i) != 9) return {-1, -1};
  const Texels::Place& at = texels.places[i];
  const int* const around = unknowns_around(at);
  return {around[1], around[2 * grid.texture(at.texture).width + 1]};
}

std::unique_ptr<SparseMatrix> TexelSpace::Data::irregular_rows(double a, double b, const StencilLayout& layout,
                                                               const Progress& progress) const {
  constexpr std::int64_t block = 1024;
  const std::int64_t n = texels.size(), count = std::ssize(layout.irregular);
  auto matrix = std::make_unique<SparseMatrix>(n, n);
  int* const starts = matrix->outerIndexPtr();
  std::vector<std::vector<RowTerm>> found(std::size_t((count + block - 1) / block));
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    std::vector<RowTerm>& here = found[std::size_t(begin / block)];
    for (std::int64_t p = begin; p < end; ++p) {
      const std::vector<RowTerm>& terms = terms_of_row(layout.irregular[std::size_t(p)], a, b, {});
      here.insert(here.end(), terms.begin(), terms.end());
      starts[layout.irregular[std::size_t(p)]] = int(terms.size());
    }
  });
  add_up({starts, std::size_t(n) + 1});
  matrix->resizeNonZeros(starts[n]);
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t) {
    int at = starts[layout.irregular[std::size_t(begin)]];  // rows between are empty
    for (const RowTerm& term : std::exchange(found[std::size_t(begin / block)], {})) {
      matrix->innerIndexPtr()[at] = term.column;
      matrix->valuePtr()[at++] = term.value;
    }
  });
  return matrix;
}

/// Of each pair of stencils the values of the first; of a stencil and another row those of the stencil.
void TexelSpace::Data::fill_stencils(double a, double b, const StencilLayout& layout, StencilRows& A) const {
  std::vector<char> irregular(std::size_t(layout.rows), 0);
  for (const int k : layout.irregular) irregular[std::size_t(k)] = 1;
  parallel_for(std::ssize(layout.runs), [&](std::int64_t r) {
    const StencilRun& run = layout.runs[std::size_t(r)];
    for (int i = 0; i < run.count; ++i) {
      const int k = run.first + i, up = run.up + i;
      const std::array<double, 9> row = grid_row(texels.places[std::size_t(k)], a, b, {}).values;
      A.at(k, Coupling::centre) = row[4];
      A.at(k, Coupling::right) = row[5];
      A.at(k, Coupling::lower_left) = row[6];
      A.at(k, Coupling::lower) = row[7];
      A.at(k, Coupling::lower_right) = row[8];
      if (irregular[std::size_t(k - 1)]) A.at(k - 1, Coupling::right) = row[3];
      if (irregular[std::size_t(up - 1)]) A.at(up - 1, Coupling::lower_right) = row[0];
      if (irregular[std::size_t(up)]) A.at(up, Coupling::lower) = row[1];
      if (irregular[std::size_t(up + 1)]) A.at(up + 1, Coupling::lower_left) = row[2];
    }
  }, 64);
}

namespace {

/// A_ij, none where A has no such entry.
double* entry_of(SparseMatrix& A, int i, int j) {
  const int* const columns = A.innerIndexPtr();
  const int* const end = columns + A.outerIndexPtr()[i + 1];
  const int* const at = std::lower_bound(columns + A.outerIndexPtr()[i], end, j);
  return at != end && *at == j ? A.valuePtr() + (at - columns) : nullptr;
}

}  // namespace

void TexelSpace::Data::hold_weak(double a, double b, SparseMatrix& A) const {
  for_each_held(a, b, [&](int i, int j, double weight) {
    double* const coupling = entry_of(A, i, j);
    if (!coupling) return;
    *coupling -= weight;
    *entry_of(A, j, i) -= weight;
    *entry_of(A, i, i) += weight;
    *entry_of(A, j, j) += weight;
  });
}

void TexelSpace::Data::hold_weak(double a, double b, const StencilLayout& layout, SparseMatrix& irregular,
                                 StencilRows& A) const {
  if (weak.empty()) return;
  std::vector<char> stencil(std::size_t(layout.rows), 1);
  for (const int k : layout.irregular) stencil[std::size_t(k)] = 0;
  const auto add_to_diagonal = [&](int i, double weight) {
    (stencil[std::size_t(i)] ? A.at(i, Coupling::centre) : *entry_of(irregular, i, i)) += weight;
  };
  for_each_held(a, b, [&](int i, int j, double weight) {
    const bool beside_stencils = stencil[std::size_t(i)] || stencil[std::size_t(j)];
    if (!beside_stencils && !entry_of(irregular, i, j)) return;
    for (const auto& [row, column] : {std::pair(i, j), {j, i}}) {
      if (!stencil[std::size_t(row)]) *entry_of(irregular, row, column) -= weight;
      add_to_diagonal(row, weight);
    }
    if (!beside_stencils) return;
    // Beside a stencil nothing wraps around.
    const Texels::Place &p = texels.places[std::size_t(i)], &q = texels.places[std::size_t(j)];
    const bool first = p.y < q.y || (p.y == q.y && p.x < q.x);
    const int dx = first ? q.x - p.x : p.x - q.x;
    const Coupling coupling = p.y == q.y ? Coupling::right
                              : dx < 0   ? Coupling::lower_left
                              : dx == 0  ? Coupling::lower
                                         : Coupling::lower_right;
    A.at(first ? i : j, coupling) -= weight;
  });
}

SparseMatrix TexelSpace::system(double a, double b, const Progress& progress) const {
  return data_->assemble(a, b, {}, progress);
}

SparseMatrix TexelSpace::regularised_system(double a, double b, const Progress& progress) const {
  SparseMatrix A = system(a, b, progress);
  data_->hold_weak(a, b, A);
  return A;
}

std::optional<StencilSystem> TexelSpace::stencil_system(double a, double b, const Progress& progress) const {
  const Data& d = *data_;
  d.require_integrals();
  StencilLayout layout = make_layout(d.texels, [&](int k) { return d.stencil_middles(k); });
  std::unique_ptr<SparseMatrix> irregular = d.irregular_rows(a, b, layout, progress);
  SparseMatrix& others = *irregular;
  StencilRows rows(std::move(irregular), layout);
  d.fill_stencils(a, b, layout, rows);
  d.hold_weak(a, b, layout, others, rows);
  return StencilSystem{std::move(layout), std::move(rows)};
}

SparseMatrix TexelSpace::weighted_system(double a, double b, std::span<const float> conductivity,
                                         const Progress& progress) const {
  require(std::ssize(conductivity) == element_count(), "one conductivity per element is needed");
  SparseMatrix A = data_->assemble(a, b, conductivity, progress);
  data_->hold_weak(a, b, A);
  return A;
}

}  // namespace mq
