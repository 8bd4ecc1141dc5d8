// Mass and stiffness of the points of a cell near a seam, as sums of squares: rows of a matrix V are scaled so that
// mass is VᵀV, and two rows per point so that stiffness is that of theirs,
//
//     a gx² + 2 b gx gy + c gy² = (√a gx + b/√a gy)² + (gy/√a)²,   as a c − b² = 1.

#include <algorithm>
#include <cmath>

#include "mq/fem/detail/seam_basis.h"

namespace mq {
namespace {

/// Leaves out the texels whose terms cancel: they would be unknowns that nothing determines.
void drop_zero_rows(SeamCell::Matrices& matrices) {
  const std::size_t count = matrices.texels.size();
  std::vector<char> zero(count, 0);
  for (std::size_t i = 0, at = 0; i < count; at += count - i, ++i)
    zero[i] = matrices.mass[at] == 0 && matrices.stiffness[at] == 0;
  if (std::ranges::count(zero, 1) == 0) return;
  std::size_t kept = 0, kept_value = 0;
  for (std::size_t i = 0, at = 0; i < count; ++i)
    for (std::size_t j = i; j < count; ++j, ++at) {
      if (zero[i] || zero[j]) continue;
      matrices.mass[kept_value] = matrices.mass[at];
      matrices.stiffness[kept_value++] = matrices.stiffness[at];
    }
  for (std::size_t i = 0; i < count; ++i)
    if (!zero[i]) matrices.texels[kept++] = matrices.texels[i];
  matrices.texels.resize(kept);
  matrices.mass.resize(kept_value);
  matrices.stiffness.resize(kept_value);
}

}  // namespace

/// The corners' and the curves' parts in all columns, 0 where they have none.
void SeamCell::spread_curves(std::size_t stride) {
  spread_.assign((4 + 3 * curves_.size()) * stride, 0);
  for (const int own : corner_) {
    bool left = false, right = false, top = false, bottom = false;  // several at the border of a picture
    for (int k = 0; k < 4; ++k) {
      if (corner_[k] != own) continue;
      (k & 1 ? right : left) = true;
      (k >> 1 ? bottom : top) = true;
    }
    double* const corner = spread_.data() + local_[own];
    corner[0] = left, corner[stride] = double(right) - double(left);
    corner[2 * stride] = top, corner[3 * stride] = double(bottom) - double(top);
  }
  for (std::size_t c = 0; c < curves_.size(); ++c)
    for (int k = curves_[c].first_entry; k < curves_[c].end_entry; ++k) {
      const int at = local_[entries_[k].texel];
      if (at < 0) continue;
      double* const value = spread_.data() + (4 + 3 * c) * stride + std::size_t(at);
      value[0] = entries_[k].c0, value[stride] = entries_[k].c1, value[2 * stride] = entries_[k].c2;
    }
}

void SeamCell::integrate(const std::vector<TexelMetric>& metrics, std::size_t first, std::size_t most_texels,
                         Matrices& matrices) {
  matrices.texels.clear();
  matrices.end = choose_texels(first, most_texels, matrices.texels);
  for (int& texel : matrices.texels) texel = texels_[texel];
  const std::size_t points = matrices.end - first, columns = matrices.texels.size();
  const std::size_t stride = (columns + column_step - 1) / column_step * column_step;
  spread_curves(stride);
  scales_.resize(4 * points);
  double *const mass = scales_.data(), *const along = mass + points, *const across = along + points,
                *const down = across + points;
  int triangle = -1;
  double density = 0, root = 0, slant = 0;
  for (std::size_t q = 0; q < points; ++q) {
    if (triangles_[first + q] != triangle) {
      triangle = triangles_[first + q];
      const TexelMetric& metric = metrics[std::size_t(triangle)];
      density = std::sqrt(metric.density), root = std::sqrt(metric.a), slant = metric.b / root;
    }
    const double weight = std::sqrt(weights_[first + q]);
    mass[q] = weight * density, along[q] = weight * root, across[q] = weight * slant, down[q] = weight / root;
  }
  room_.resize((3 * points + 4) * stride);
  matrices.mass.resize(columns * (columns + 1) / 2);
  matrices.stiffness.resize(columns * (columns + 1) / 2);
  const SeamPoints of{int(points), int(columns), int(stride), x_.data() + first, y_.data() + first, mass, along,
                      across, down, first_terms_.data() + first, terms_.data(), spread_.data() + 4 * stride,
                      spread_.data()};
  seam_kernels().block(of, room_.data(), matrices.mass.data(), matrices.stiffness.data());
  drop_zero_rows(matrices);
}

}  // namespace mq
