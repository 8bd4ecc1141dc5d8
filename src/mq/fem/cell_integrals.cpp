// S_(pq)(rs) = a σ_p σ_r ∫ y_q y_s + c τ_q τ_s ∫ x_p x_r + b (σ_p τ_s ∫ y_q x_r + σ_r τ_q ∫ x_p
// y_s), σ_0 = τ_0 = −1, σ_1 = τ_1 = 1, with the integrals of products of two read off the nine
// moments through x_0 + x_1 = 1. Only the six entries off the diagonal are kept: rows sum to zero
// exactly.

#include "mq/fem/texel_cells.h"

#include "mq/fem/detail/quadrature.h"
#include "mq/fem/kernels/seam_kernels.h"

namespace mq {
namespace {

RuleLanes rule_in_lanes() {
  RuleLanes rule;
  for (int q = 0; q < 6; ++q) {
    rule.l1[q] = triangle_rule_4()[q].l1;
    rule.l2[q] = triangle_rule_4()[q].l2;
    rule.weight[q] = triangle_rule_4()[q].weight;
  }
  return rule;
}

}  // namespace

std::array<double, 9> bernstein_moments(std::span<const std::array<double, 2>> polygon) {
  static const RuleLanes rule = rule_in_lanes();
  std::array<double, 9> moments;
  seam_kernels().moments(rule, polygon.front().data(), int(polygon.size()), moments.data());
  return moments;
}

std::array<double, 9> bernstein_moments(const Piece& piece) {
  std::array<std::array<double, 2>, Piece::max_vertices> polygon;
  for (int k = 0; k < piece.count; ++k) polygon[k] = {piece.vertices[k].x, piece.vertices[k].y};
  return bernstein_moments(std::span(polygon.data(), std::size_t(piece.count)));
}

std::array<double, 9> whole_moments() {
  constexpr double third = 1.0 / 3, sixth = 1.0 / 6;
  constexpr double line[3] = {third, sixth, third};
  std::array<double, 9> moments;
  for (int q = 0; q < 3; ++q)
    for (int p = 0; p < 3; ++p) moments[p + 3 * q] = line[p] * line[q];
  return moments;
}

void add_integrals(const std::array<double, 9>& m, const TexelMetric& metric,
                   CellIntegrals& integrals) {
  for (int k = 0; k < 9; ++k) integrals.mass[k] += metric.density * m[k];
  const double a = metric.a, b = metric.b, c = metric.c;
  const double yy00 = m[0] + 2 * m[1] + m[2], yy01 = m[3] + 2 * m[4] + m[5],
               yy11 = m[6] + 2 * m[7] + m[8];
  const double xx00 = m[0] + 2 * m[3] + m[6], xx01 = m[1] + 2 * m[4] + m[7],
               xx11 = m[2] + 2 * m[5] + m[8];
  // xy_pq = ∫ x_p y_q
  const double xy00 = m[0] + m[3] + m[1] + m[4], xy01 = m[3] + m[6] + m[4] + m[7];
  const double xy10 = m[1] + m[4] + m[2] + m[5], xy11 = m[4] + m[7] + m[5] + m[8];
  std::array<double, 6>& s = integrals.stiffness;
  s[0] += -a * yy00 + c * xx01 + b * (xy10 - xy00);
  s[1] += a * yy01 - c * xx00 + b * (xy01 - xy00);
  s[2] += -a * yy01 - c * xx01 - b * (xy10 + xy01);
  s[3] += -a * yy01 - c * xx01 + b * (xy00 + xy11);
  s[4] += a * yy01 - c * xx11 + b * (xy10 - xy11);
  s[5] += -a * yy11 + c * xx01 + b * (xy01 - xy11);
}

}  // namespace mq
