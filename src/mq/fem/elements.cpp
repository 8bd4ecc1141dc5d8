#include "mq/fem/elements.h"

#include <array>
#include <vector>

#include "mq/base/error.h"
#include "mq/fem/texel_space_data.h"

namespace mq {
namespace {

template <class Numbers>
bool mixed(const Numbers& unknowns, std::span<const int> labels) {
  for (const int i : unknowns)
    if (labels[i] != labels[unknowns[0]]) return true;
  return false;
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

void TexelSpace::for_each_mixed_element(std::span<const int> labels,
                                        const std::function<void(const Element&)>& visit) const {
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

MixedElements mixed_elements(const TexelSpace& space) {
  return [&space](std::span<const int> labels, const std::function<void(const Element&)>& visit) {
    space.for_each_mixed_element(labels, visit);
  };
}

MixedElements mixed_elements(const VertexSpace& space) {
  return [&space](std::span<const int> labels, const std::function<void(const Element&)>& visit) {
    require(std::ssize(labels) == space.size(), "one label per vertex is needed");
    for (int t = 0; t < space.triangle_count(); ++t) {
      const Triangle& own = space.triangles()[t];
      const FlatTriangle& shape = space.shapes()[t];
      if (shape.empty() || !mixed(own, labels)) continue;
      std::array<double, 9> S{};
      for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double s = shape.half_cotangent(k);
        S[3 * i + j] = S[3 * j + i] = -s;
        S[4 * i] += s, S[4 * j] += s;
      }
      visit({own, own, S});
    }
  };
}

}  // namespace mq
