// Matrices are gathered row by row from the integrals of the (at most four) cells around a texel
// and from the seam blocks it takes part in, so that rows are independent: any number of threads,
// one result. A row whose texel no seam touches is a 3 × 3 stencil and takes a path of its own.

#include "mq/fem/texel_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "mq/atlas/overlap_depth.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
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

TexelSpace::TexelSpace(const Surface& surface, const Atlas& atlas, const TexelSpaceOptions& options,
                       const Progress& progress) {
  Defects defects = deep_overlaps(surface, atlas);
  defects.insert(defects.begin(), atlas.defects.begin(), atlas.defects.end());
  if (refused(defects)) {
    std::string message = "the atlas cannot be worked with:";
    for (const Defect& d : defects)
      if (d.severity == Defect::Severity::refused)
        message += fmt::format(
            " {} {}s ({}{}): {};", d.count, d.element,
            fmt::join(d.ids.begin(), d.ids.begin() + std::min<std::size_t>(d.ids.size(), 5), ", "),
            d.count > 5 ? ", ..." : "", d.message);
    message.pop_back();
    throw InvalidInput(message);
  }
  data_ = std::make_unique<Data>(surface, atlas);
  data_->integrate(options, progress);
  data_->number_texels();
  require(!data_->texels.places.empty(),
          "no triangle has texture coordinates and area: there is nothing to work on");
  progress.at(0.75);
  data_->find_parts();
  progress.at(0.85);
  data_->place_texels();
  data_->find_weak();
  data_->list_defects();
  progress.at(1);
}

TexelSpace::~TexelSpace() = default;
TexelSpace::TexelSpace(TexelSpace&&) noexcept = default;

int TexelSpace::size() const { return data_->texels.size(); }
const Texels& TexelSpace::texels() const { return data_->texels; }
const Defects& TexelSpace::defects() const { return data_->defects; }

SurfaceScale TexelSpace::scale() const {
  return {data_->atlas.surface_area, data_->atlas.texel_spacing()};
}

SparseMatrix TexelSpace::Data::assemble(double a, double b, std::span<const float> conductivity,
                                        const Progress& progress) const {
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

SparseMatrix TexelSpace::system(double a, double b, const Progress& progress) const {
  return data_->assemble(a, b, {}, progress);
}

void TexelSpace::Data::hold_weak(double a, double b, SparseMatrix& A) const {
  const auto entry_of = [&](int i, int j) {
    const int* const columns = A.innerIndexPtr();
    const int* const end = columns + A.outerIndexPtr()[i + 1];
    const int* const at = std::lower_bound(columns + A.outerIndexPtr()[i], end, j);
    return at != end && *at == j ? A.valuePtr() + (at - columns) : nullptr;
  };
  for_each_held(a, b, [&](int i, int j, double weight) {
    double* const coupling = entry_of(i, j);
    if (!coupling) return;
    *coupling -= weight;
    *entry_of(j, i) -= weight;
    *entry_of(i, i) += weight;
    *entry_of(j, j) += weight;
  });
}

SparseMatrix TexelSpace::regularised_system(double a, double b, const Progress& progress) const {
  SparseMatrix A = system(a, b, progress);
  data_->hold_weak(a, b, A);
  return A;
}

SparseMatrix TexelSpace::weighted_system(double a, double b, std::span<const float> conductivity,
                                         const Progress& progress) const {
  require(std::ssize(conductivity) == element_count(), "one conductivity per element is needed");
  SparseMatrix A = data_->assemble(a, b, conductivity, progress);
  data_->hold_weak(a, b, A);
  return A;
}

Vector TexelSpace::lumped_mass() const {
  const Data& d = *data_;
  Vector mass = Vector::Zero(size());
  parallel_for(size(), [&](std::int64_t i) {
    d.for_each_coupling(int(i), {}, [&](int, double m, double) { mass[i] += m; });
  });
  return mass;
}

Signal TexelSpace::stiffness_times(const Signal& psi, std::span<const double> beta) const {
  return stiffness_rows({}, psi, beta);
}

Signal TexelSpace::stiffness_rows(std::span<const int> rows, const Signal& psi,
                                  std::span<const double> beta) const {
  require(psi.rows() == size(), "one row per texel is needed");
  require(beta.empty() || std::ssize(beta) == size(), "one modulation per texel is needed");
  const Data& d = *data_;
  const auto mean_beta = [&](const std::array<int, 4>& corners) {
    if (beta.empty()) return 1.0;
    double sum = 0;
    for (int c : corners) sum += beta[d.unknown[c]];
    return sum / 4;
  };
  // Of a seam block: the corners of the cell whose pieces it holds.
  const auto block_beta = [&](const SeamBlocks::Block& block) {
    if (beta.empty()) return 1.0;
    if (block.cell < 0) {
      double sum = 0;
      for (int k = 0; k < block.count; ++k) sum += beta[d.cells.seams.texels[block.first + k]];
      return sum / block.count;
    }
    int k = 0;
    while (k + 1 < d.grid.texture_count() && d.grid.first_cell(k + 1) <= block.cell) ++k;
    const int local = block.cell - d.grid.first_cell(k), width = d.grid.texture(k).width + 1;
    return mean_beta(d.grid.corners(k, local % width - 1, local / width - 1));
  };
  return d.stiffness_product(
      rows, psi, [&](int, const std::array<int, 4>& corners) { return mean_beta(corners); },
      [&](int block) { return block_beta(d.cells.seams.blocks[block]); });
}

Signal TexelSpace::gather(std::span<const Image<float>> pictures) const {
  const Data& d = *data_;
  require(std::ssize(pictures) == d.grid.texture_count(),
          fmt::format("{} pictures for {} textures: give one each", pictures.size(),
                      d.grid.texture_count()));
  const int channels = pictures.front().channels();
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const TextureSize& size = d.grid.texture(k);
    if (pictures[k].width() != size.width || pictures[k].height() != size.height ||
        pictures[k].channels() != channels)
      throw InvalidInput(
          fmt::format("picture {} is {} x {} with {} channels where {} x {} with {} was wanted", k,
                      pictures[k].width(), pictures[k].height(), pictures[k].channels(), size.width,
                      size.height, channels));
  }
  Signal signal(size(), channels);
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < channels; ++c) signal(i, c) = pixel[c];
  });
  return signal;
}

void TexelSpace::scatter(const Signal& signal, std::span<Image<float>> pictures) const {
  const Data& d = *data_;
  require(signal.rows() == size() && std::ssize(pictures) == d.grid.texture_count() &&
              signal.cols() == pictures.front().channels(),
          "a signal of this space and the pictures it was gathered from are needed");
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < signal.cols(); ++c) pixel[c] = float(signal(i, c));
  });
}

std::int64_t TexelSpace::bytes() const {
  const Data& d = *data_;
  const auto size = [](const auto& v) { return std::int64_t(v.capacity() * sizeof(v[0])); };
  return size(d.metrics) + size(d.cells.kind) + size(d.cells.cut) + size(d.cells.info) +
         size(d.cells.whole) + size(d.cells.seams.blocks) + size(d.cells.seams.texels) +
         size(d.cells.seams.mass) + size(d.cells.seams.stiffness) + size(d.cells.seams.means) + size(d.texels.places) +
         size(d.texels.positions) + size(d.texels.chart) + size(d.texels.interior) +
         size(d.unknown) + size(d.block_offsets) + size(d.parts);
}

}  // namespace mq
