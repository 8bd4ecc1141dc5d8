// Matrices are gathered row by row from the integrals of the (at most four) cells around a texel
// and from the seam blocks it takes part in, so that rows are independent: any number of threads,
// one result. A row whose texel no seam touches is a 3 × 3 stencil and takes a path of its own.

#include "mq/fem/texel_space.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/atlas/overlap_depth.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

namespace {

struct Term {
  int column;
  double value;
};

/// The terms of one row after another, those of one column added up: found by a small hash table.
/// For one thread.
class RowTerms {
 public:
  void start() {
    terms_.clear();
    std::ranges::fill(slots_, -1);
  }

  void add(int column, double value) {
    int& slot = slots_[slot_of(column)];
    if (slot >= 0) {
      terms_[slot].value += value;
      return;
    }
    slot = int(terms_.size());
    terms_.push_back({column, value});
    if (2 * terms_.size() > slots_.size()) grow();
  }

  int count() const { return int(terms_.size()); }

  /// Their columns increasing. The row takes no further terms.
  const std::vector<Term>& sorted() {
    std::sort(terms_.begin(), terms_.end(),
              [](const Term& p, const Term& q) { return p.column < q.column; });
    return terms_;
  }

 private:
  std::size_t slot_of(int column) const {
    constexpr std::uint32_t golden_ratio = 2654435769U;  // times 2^32
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = (std::uint32_t(column) * golden_ratio >> 12) & mask;
    while (slots_[at] >= 0 && terms_[slots_[at]].column != column) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), -1);
    for (std::size_t k = 0; k < terms_.size(); ++k) slots_[slot_of(terms_[k].column)] = int(k);
  }

  std::vector<int> slots_ = std::vector<int>(128, -1);  ///< a power of two; −1: empty
  std::vector<Term> terms_;
};

RowTerms& row_terms() {
  thread_local RowTerms terms;
  return terms;
}

}  // namespace

int TexelSpace::Data::row_size(int i) const {
  const Texels::Place& at = texels.places[i];
  if (inner(at) && blocks_of(i).empty()) {
    const int width = grid.texture(at.texture).width + 1;
    const int* cell = cells.kind.data() + grid.cell(at.texture, at.x - 1, at.y - 1);
    const bool c00 = cell[0] >= 0, c10 = cell[1] >= 0, c01 = cell[width] >= 0,
               c11 = cell[width + 1] >= 0;
    return 1 + c00 + c10 + c01 + c11 + (c00 || c10) + (c01 || c11) + (c00 || c01) + (c10 || c11);
  }
  RowTerms& terms = row_terms();
  terms.start();
  for_each_coupling(i, {}, [&](int j, double, double) { terms.add(j, 0); });
  return terms.count();
}

void TexelSpace::Data::fill_row(int i, double a, double b, std::span<const float> conductivity,
                                int* columns, double* values) const {
  const Texels::Place& at = texels.places[i];
  if (!inner(at) || !blocks_of(i).empty()) {
    RowTerms& terms = row_terms();
    terms.start();
    for_each_coupling(i, conductivity,
                      [&](int j, double m, double s) { terms.add(j, a * m + b * s); });
    for (const Term& term : terms.sorted()) *columns++ = term.column, *values++ = term.value;
    return;
  }
  double sums[9] = {};
  bool coupled[9] = {};
  const TextureSize& size = grid.texture(at.texture);
  const int first = grid.first_cell(at.texture) + at.y * (size.width + 1) + at.x;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const int id = first + dy * (size.width + 1) + dx;
      if (!active(id)) continue;
      const CellIntegrals& cell = integrals(id);
      const int corner = 3 - dx - 2 * dy, origin = dx + 3 * dy;
      const double factor = conductivity.empty() ? b : b * conductivity[id];
      double diagonal = 0;
      for (int d = 0; d < 4; ++d) {
        const int place = origin + (d & 1) + 3 * (d >> 1);
        coupled[place] = true;
        sums[place] += a * cell.mass[mass_at[corner][d]];
        if (d == corner) continue;
        const double s = factor * cell.stiffness[stiffness_at[corner][d]];
        sums[place] += s;
        diagonal -= s;
      }
      sums[4] += diagonal;
    }
  const int* around =
      unknown.data() + grid.first_texel(at.texture) + (at.y - 1) * size.width + at.x - 1;
  for (int place = 0; place < 9; ++place)
    if (coupled[place]) {
      *columns++ = around[place / 3 * size.width + place % 3];
      *values++ = sums[place];
    }
}

void TexelSpace::Data::count_rows() {
  const int n = texels.size();
  std::vector<int> sizes(n);
  parallel_for(
      n, [&](std::int64_t i) { sizes[i] = row_size(int(i)); }, 4096);
  row_offsets.assign(n + 1, 0);
  std::int64_t sum = 0;
  for (int i = 0; i < n; ++i) {
    sum += sizes[i];
    row_offsets[i + 1] = int(std::min<std::int64_t>(sum, INT32_MAX));
  }
  require(sum < INT32_MAX,
          fmt::format("the {} texels that the charts use make a system of more than 2^31 entries "
                      "(texels couple to 8 others): use smaller textures",
                      n));
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
  data_->count_rows();
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
  const int n = texels.size();
  SparseMatrix matrix(n, n);
  matrix.resizeNonZeros(row_offsets.back());
  std::copy(row_offsets.begin(), row_offsets.end(), matrix.outerIndexPtr());
  parallel_blocks(n, 4096, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t i = begin; i < end; ++i) {
      const int at = row_offsets[i];
      fill_row(int(i), a, b, conductivity, matrix.innerIndexPtr() + at, matrix.valuePtr() + at);
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
         size(d.unknown) + size(d.block_offsets) + size(d.parts) + size(d.row_offsets);
}

}  // namespace mq
