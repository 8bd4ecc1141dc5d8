// What is not linear in a signal, element by element: ψᵀS_eψ = Σ_{i<j} −S_ij (ψ_i − ψ_j)² of a cell
// by its six couplings, of a seam block by all pairs of its texels.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mq/base/error.h"
#include "mq/fem/detail/mixed.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

namespace {

/// ∫ 1 over the pieces in a cell: Σ_pq M_pq from moments of x_0 + x_1 = 1 squared.
double area_of(const CellIntegrals& cell) {
  double area = 0;
  for (int q = 0; q < 3; ++q)
    for (int p = 0; p < 3; ++p) area += (p == 1 ? 2 : 1) * (q == 1 ? 2 : 1) * cell.mass[p + 3 * q];
  return area;
}

float norm_of(double energy, double area) {
  return area > 0 && energy > 0 ? float(std::sqrt(energy / area)) : 0.0F;
}

/// Full matrix of a cell from its six integrals.
std::array<double, 16> full(const CellIntegrals& cell) {
  std::array<double, 16> S{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (i != j) {
        S[4 * i + j] = cell.stiffness[stiffness_at[i][j]];
        S[4 * i + i] -= S[4 * i + j];
      }
  return S;
}

}  // namespace

int TexelSpace::element_count() const {
  data_->require_integrals();
  return data_->grid.cell_count() + int(data_->cells.seams.blocks.size());
}

std::vector<float> TexelSpace::gradient_norms(const Signal& psi) const {
  data_->require_integrals();
  require(psi.rows() == size(), "one row per texel is needed");
  const Data& d = *data_;
  std::vector<float> norms(element_count(), 0.0F);
  const SeamBlocks& seams = d.cells.seams;
  const auto add = [&](int element, float norm) {
    norms[element] = norms[element] == 0 ? norm : std::hypot(norms[element], norm);
  };
  for_channel_groups(psi, [&](const auto& group) {
    const auto squared = [&](int i, int j) { return (group(i) - group(j)).square().sum(); };
    d.for_each_grid_cell([&](int id, const std::array<int, 4>& corners) {
      const CellIntegrals& cell = d.integrals(id);
      double energy = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j)
          energy -= cell.stiffness[stiffness_at[i][j]] *
                    squared(d.unknown[corners[i]], d.unknown[corners[j]]);
      add(id, norm_of(energy, area_of(cell)));
    });
    parallel_for(std::ssize(seams.blocks), [&](std::int64_t b) {
      const SeamBlocks::Block& block = seams.blocks[b];
      double energy = 0, area = 0;
      for (int i = 0; i < block.count; ++i)
        for (int j = i; j < block.count; ++j) {
          const std::int64_t at = block.first_value + SeamBlocks::index(i, j, block.count);
          area += (i == j ? 1 : 2) * seams.mass[at];
          if (i == j) continue;
          energy -= seams.stiffness[at] *
                    squared(seams.texels[block.first + i], seams.texels[block.first + j]);
        }
      add(d.element_of_block(int(b)), norm_of(energy, area));
    });
  });
  return norms;
}

void TexelSpace::for_each_summand(
    double a, double b, const std::function<void(std::span<const int>, std::span<const double>)>& visit) const {
  data_->require_integrals();
  const Data& d = *data_;
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const int width = d.grid.texture(k).width + 1, first = d.grid.first_cell(k);
    for (int c = first; c < first + width * d.grid.cell_rows(k); ++c) {
      if (!d.active(c)) continue;
      std::array<int, 4> own = d.grid.corners(k, (c - first) % width - 1, (c - first) / width - 1);
      for (int& texel : own) texel = d.unknown[texel];
      const CellIntegrals& cell = d.integrals(c);
      std::array<double, 16> A = full(cell);
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) A[4 * i + j] = b * A[4 * i + j] + a * cell.mass[mass_at[i][j]];
      visit(own, A);
    }
  }
  const SeamBlocks& seams = d.cells.seams;
  std::vector<double> A;
  for (const SeamBlocks::Block& block : seams.blocks) {
    const auto count = std::size_t(block.count);
    A.resize(count * count);
    for (int i = 0; i < block.count; ++i)
      for (int j = 0; j < block.count; ++j) {
        const std::int64_t at =
            block.first_value + SeamBlocks::index(std::min(i, j), std::max(i, j), block.count);
        A[std::size_t(i) * count + j] = a * seams.mass[at] + b * seams.stiffness[at];
      }
    visit({seams.texels.data() + block.first, count}, A);
  }
  d.for_each_held(a, b, [&](int i, int j, double weight) {
    bool coupled = false;
    d.for_each_coupling(i, {}, [&](int k, double, double) { coupled |= k == j; });
    if (!coupled) return;
    const std::array<int, 2> pair{i, j};
    const std::array<double, 4> values{weight, -weight, -weight, weight};
    visit(pair, values);
  });
}

std::vector<int> TexelSpace::first_texels() const {
  const Data& d = *data_;
  d.require_integrals();
  std::vector<int> first(std::size_t(element_count()), -1);
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const int width = d.grid.texture(k).width + 1, begin = d.grid.first_cell(k);
    parallel_for(std::int64_t(width) * d.grid.cell_rows(k), [&](std::int64_t local) {
      if (!d.active(begin + int(local))) return;
      std::array<int, 4> corners = d.grid.corners(k, int(local) % width - 1, int(local) / width - 1);
      for (int& texel : corners) texel = d.unknown[texel];
      first[std::size_t(begin + local)] = *std::ranges::min_element(corners);
    });
  }
  const SeamBlocks& seams = d.cells.seams;
  for (std::size_t b = 0; b < seams.blocks.size(); ++b) {
    const SeamBlocks::Block& block = seams.blocks[b];
    if (block.count == 0) continue;
    const auto begin = seams.texels.begin() + std::ptrdiff_t(block.first);
    first[std::size_t(d.element_of_block(int(b)))] = *std::min_element(begin, begin + block.count);
  }
  return first;
}

Vector TexelSpace::means_around(std::span<const float> elements) const {
  data_->require_integrals();
  require(std::ssize(elements) == element_count(), "one value per element is needed");
  const Data& d = *data_;
  Vector means(size());
  parallel_for(size(), [&](std::int64_t i) {
    double sum = 0, mass = 0, plain = 0;
    int count = 0;
    const auto add = [&](int element, double share) {
      // Next to seams a share may be a little below 0.
      sum += std::max(0.0, share) * elements[element];
      mass += std::max(0.0, share);
      plain += elements[element];
      ++count;
    };
    d.for_each_cell(d.texels.places[i], [&](const Incidence& at) {
      if (!d.active(at.cell)) return;
      const CellIntegrals& cell = d.integrals(at.cell);
      double share = 0;
      for (int k = 0; k < 4; ++k) share += cell.mass[mass_at[at.corner][k]];
      add(at.cell, share);
    });
    for (const Data::Part& part : d.blocks_of(int(i))) {
      double share = 0;
      d.visit_block(part, [&](int, double m, double) { share += m; });
      add(d.element_of_block(part.block), share);
    }
    means[i] = mass > 0 ? sum / mass : count > 0 ? plain / count : 0;
  });
  return means;
}

/// From the matrices of a cell: x and y are bilinear, and ∫ √|g| ⟨∇x, ∇y⟩ says the mean of b.
std::vector<TexelSpace::CellMetric> TexelSpace::cell_metrics() const {
  data_->require_integrals();
  const Data& d = *data_;
  std::vector<CellMetric> metrics(d.grid.cell_count());
  d.for_each_grid_cell([&](int id, const std::array<int, 4>&) {
    const CellIntegrals& cell = d.integrals(id);
    const double area = area_of(cell);
    if (!(area > 0)) return;
    const auto& [s01, s02, s03, s12, s13, s23] = cell.stiffness;
    metrics[id] = {-(s01 + s03 + s12 + s23) / area, -(s03 - s12) / area, -(s02 + s03 + s12 + s13) / area};
  });
  std::vector<SeamBlocks::CellMean> means = d.cells.seams.means;
  std::ranges::stable_sort(means, {}, &SeamBlocks::CellMean::cell);
  for (std::size_t k = 0; k < means.size();) {
    const int id = means[k].cell;
    double area = 0;
    CellMetric sum;
    for (; k < means.size() && means[k].cell == id; ++k) {
      area += means[k].surface;
      sum.xx += means[k].metric[0];
      sum.xy += means[k].metric[1];
      sum.yy += means[k].metric[2];
    }
    if (area > 0) metrics[id] = {sum.xx / area, sum.xy / area, sum.yy / area};
  }
  return metrics;
}

Signal TexelSpace::weighted_stiffness_times(const Signal& psi,
                                            std::span<const float> conductivity) const {
  require(psi.rows() == size() && std::ssize(conductivity) == element_count(),
          "one row per texel and one conductivity per element are needed");
  const Data& d = *data_;
  return d.stiffness_product(
      {}, psi, [&](int cell, const std::array<int, 4>&) { return double(conductivity[cell]); },
      [&](int block) { return double(conductivity[d.element_of_block(block)]); });
}

void TexelSpace::for_each_mixed_element(std::span<const int> labels,
                                        const std::function<void(const Element&)>& visit) const {
  data_->require_integrals();
  require(std::ssize(labels) == size(), "one label per texel is needed");
  const Data& d = *data_;
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const int width = d.grid.texture(k).width + 1, first = d.grid.first_cell(k);
    for (int c = first; c < first + width * d.grid.cell_rows(k); ++c) {
      if (!d.active(c)) continue;
      const int local = c - first;
      std::array<int, 4> own = d.grid.corners(k, local % width - 1, local / width - 1);
      for (int& texel : own) texel = d.unknown[texel];
      if (!mixed(own, labels)) continue;
      const std::array<double, 16> S = full(d.integrals(c));
      visit({own, own, S});
    }
  }
  std::vector<double> S;
  int k = 0;
  for (const SeamBlocks::Block& block : d.cells.seams.blocks) {
    const std::span<const int> unknowns(d.cells.seams.texels.data() + block.first,
                                        std::size_t(block.count));
    if (!mixed(unknowns, labels)) continue;
    S.resize(std::size_t(block.count) * block.count);
    for (int i = 0; i < block.count; ++i)
      for (int j = 0; j < block.count; ++j)
        S[std::size_t(i) * block.count + j] = d.cells.seams.stiffness[std::size_t(
            block.first_value + SeamBlocks::index(std::min(i, j), std::max(i, j), block.count))];
    if (block.cell < 0) {
      visit({{}, unknowns, S});
      continue;
    }
    if (block.cell < d.grid.first_cell(k)) k = 0;
    while (k + 1 < d.grid.texture_count() && d.grid.first_cell(k + 1) <= block.cell) ++k;
    const int local = block.cell - d.grid.first_cell(k), width = d.grid.texture(k).width + 1;
    std::array<int, 4> own = d.grid.corners(k, local % width - 1, local / width - 1);
    for (int& texel : own) texel = d.unknown[texel];
    visit({own, unknowns, S});
  }
}

}  // namespace mq
