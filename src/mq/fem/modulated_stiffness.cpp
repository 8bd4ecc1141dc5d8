// Of the 3 × 3 texels around texel i, row by row, its cell q is that of texels q/2·3 + q%2 + {0, 1, 3, 4}.

#include "mq/fem/modulated_stiffness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

namespace {

constexpr std::int64_t rows_at_once = 16384;  // to a thread

}  // namespace

ModulatedStiffness::ModulatedStiffness(const TexelSpace& space, const Signal& psi) : space_(space), psi_(psi) {
  require(psi.rows() == space.size() && psi.cols() > 0,
          fmt::format("a signal of {} × {} was given for {} texels", psi.rows(), psi.cols(), space.size()));
  shares_.resize(4 * std::size_t(psi.size()));
  kept_.assign(std::size_t(space.size()), 0);
  keep_seam_rows();
}

void ModulatedStiffness::SeamRows::append(const SeamRows& others) {
  const auto append_starts = [](std::vector<int>& to, const std::vector<int>& from) {
    const int before = to.back();
    for (std::size_t i = 1; i < from.size(); ++i) to.push_back(before + from[i]);
  };
  append_starts(starts, others.starts);
  append_starts(corner_starts, others.corner_starts);
  corners.insert(corners.end(), others.corners.begin(), others.corners.end());
  shares.insert(shares.end(), others.shares.begin(), others.shares.end());
}

void ModulatedStiffness::keep_seam_rows() {
  for (int i = 0; i < space_.size(); ++i)
    if (!space_.data_->is_grid_row(i)) at_seams_.push_back(i);
  constexpr std::int64_t block = 512;
  std::vector<SeamRows> blocks((at_seams_.size() + block - 1) / block);
  parallel_blocks(std::ssize(at_seams_), block, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) add_row(at_seams_[std::size_t(i)], blocks[std::size_t(begin / block)]);
  });
  for (const SeamRows& found : blocks) seam_rows_.append(found);
}

/// What several pieces of one cell give is added up.
void ModulatedStiffness::add_row(int texel, SeamRows& rows) const {
  const TexelSpace::Data& d = *space_.data_;
  const auto channels = std::size_t(psi_.cols());
  std::vector<int> elements;  // of this row
  const auto share_of = [&](int element, std::span<const int> texels) {
    const auto known = std::ranges::find(elements, element);
    const std::size_t before_this_row = std::size_t(rows.starts.back());
    const std::size_t at = before_this_row + std::size_t(known - elements.begin());
    if (known == elements.end()) {
      elements.push_back(element);
      for (const int k : texels) rows.corners.push_back(k);
      rows.corner_starts.push_back(int(rows.corners.size()));
      rows.shares.resize(rows.shares.size() + channels, 0);
    }
    return Eigen::Map<Eigen::RowVectorXd>(rows.shares.data() + at * channels, std::ptrdiff_t(channels));
  };
  const auto unknowns_of = [&](std::array<int, 4> texels) {
    for (int& k : texels) k = d.unknown[std::size_t(k)];
    return texels;
  };
  d.for_each_cell(d.texels.places[std::size_t(texel)], [&](const Incidence& at) {
    if (!d.active(at.cell)) return;
    const CellIntegrals& cell = d.integrals(at.cell);
    const std::array<int, 4> corners = unknowns_of(at.corners);
    auto share = share_of(at.cell, corners);
    for (int k = 0; k < 4; ++k)
      if (k != at.corner)
        share += cell.stiffness[stiffness_at[at.corner][k]] * (psi_.row(corners[std::size_t(k)]) - psi_.row(texel));
  });
  for (const TexelSpace::Data::Part& part : d.blocks_of(texel)) {
    const SeamBlocks::Block& block = d.cells.seams.blocks[std::size_t(part.block)];
    auto share = block.cell < 0 ? share_of(d.element_of_block(part.block),
                                           {d.cells.seams.texels.data() + block.first, std::size_t(block.count)})
                                : share_of(block.cell, unknowns_of(d.corners_of(block.cell)));
    d.visit_block(part, [&](int j, double, double s) {
      if (j != texel) share += s * (psi_.row(j) - psi_.row(texel));
    });
  }
  rows.starts.push_back(rows.starts.back() + int(elements.size()));
}

/// (S_e·ψ)_i of the cells of a texel; 0 where no chart is.
template <int channels>
void ModulatedStiffness::keep_shares(int texel) {
  using Row = Eigen::Array<double, channels, 1>;
  const TexelSpace::Data& d = *space_.data_;
  const int count = int(psi_.cols());
  double* const shares = shares_.data() + std::int64_t(texel) * 4 * count;
  const auto value = [&](int i) { return Eigen::Map<const Row>(psi_.data() + std::int64_t(i) * count, count); };
  d.for_each_inner_cell(d.texels.places[std::size_t(texel)], [&](const Incidence& at) {
    Row sum = Row::Zero(count);
    if (d.active(at.cell)) {
      const CellIntegrals& cell = d.integrals(at.cell);
      for (int k = 0; k < 4; ++k)
        if (k != at.corner)
          sum += cell.stiffness[stiffness_at[at.corner][k]] * (value(d.unknown[at.corners[k]]) - value(texel));
    }
    Eigen::Map<Row>(shares + (3 - at.corner) * count, count) = sum;
  });
  kept_[std::size_t(texel)] = 1;
}

template <int channels>
void ModulatedStiffness::take_seam_row(int texel, std::span<const std::span<const double>> betas, double* to) const {
  using Row = Eigen::Array<double, channels, 1>;
  const int count = int(psi_.cols());
  const auto row = std::size_t(std::ranges::lower_bound(at_seams_, texel) - at_seams_.begin());
  for (const std::span<const double> beta : betas) {
    Row sum = Row::Zero(count);
    for (int e = seam_rows_.starts[row]; e < seam_rows_.starts[row + 1]; ++e) {
      const int first = seam_rows_.corner_starts[std::size_t(e)], end = seam_rows_.corner_starts[std::size_t(e) + 1];
      double total = 0;
      for (int c = first; c < end; ++c)
        if (const int k = seam_rows_.corners[std::size_t(c)]; k >= 0) total += beta[std::size_t(k)];
      sum += total / (end - first) *
             Eigen::Map<const Row>(seam_rows_.shares.data() + std::int64_t(e) * count, count);
    }
    Eigen::Map<Row>(to, count) = sum;
    to += count;
  }
}

template <int channels>
void ModulatedStiffness::take_rows(std::span<const int> wanted, std::span<const std::span<const double>> betas,
                                   Signal& result) {
  using Row = Eigen::Array<double, channels, 1>;
  const TexelSpace::Data& d = *space_.data_;
  const int count = int(psi_.cols());
  parallel_for(std::ssize(wanted), [&](std::int64_t r) {
    const int i = wanted[std::size_t(r)];
    if (!d.is_grid_row(i)) return take_seam_row<channels>(i, betas, result.data() + r * result.cols());
    if (!kept_[std::size_t(i)]) keep_shares<channels>(i);
    const double* const shares = shares_.data() + std::int64_t(i) * 4 * count;
    const Texels::Place& place = d.texels.places[std::size_t(i)];
    const int* const around = d.unknowns_around(place);
    const int width = d.grid.texture(place.texture).width;
    double* to = result.data() + r * result.cols();
    for (const std::span<const double> beta : betas) {
      std::array<double, 9> near;
      for (int n = 0; n < 9; ++n) {
        const int unknown = around[n / 3 * width + n % 3];
        near[std::size_t(n)] = unknown < 0 ? 0 : beta[std::size_t(unknown)];
      }
      Row sum = Row::Zero(count);
      for (int q = 0; q < 4; ++q) {
        const double* const corner = near.data() + q / 2 * 3 + q % 2;
        sum += (corner[0] + corner[1] + corner[3] + corner[4]) / 4 *
               Eigen::Map<const Row>(shares + q * count, count);
      }
      Eigen::Map<Row>(to, count) = sum;
      to += count;
    }
  }, rows_at_once);
}

Signal ModulatedStiffness::rows(std::span<const int> wanted, std::span<const std::span<const double>> betas) {
  for (const std::span<const double> beta : betas)
    require(std::ssize(beta) == space_.size(), "one modulation per texel is needed");
  const Eigen::Index channels = psi_.cols();
  Signal result(std::ssize(wanted), channels * std::ssize(betas));
  switch (channels) {
    case 1: take_rows<1>(wanted, betas, result); break;
    case 3: take_rows<3>(wanted, betas, result); break;
    case 4: take_rows<4>(wanted, betas, result); break;
    default: take_rows<Eigen::Dynamic>(wanted, betas, result);
  }
  return result;
}

}  // namespace mq
