// S_(pq)(rs) = a σ_p σ_r ∫ y_q y_s + c τ_q τ_s ∫ x_p x_r + b (σ_p τ_s ∫ y_q x_r + σ_r τ_q ∫ x_p
// y_s), σ_0 = τ_0 = −1, σ_1 = τ_1 = 1, with the integrals of products of two read off the nine
// moments through x_0 + x_1 = 1. Only the six entries off the diagonal are kept: rows sum to zero
// exactly.

#include "mq/fem/texel_cells.h"

#include <Eigen/Core>
#include <cmath>

#include "mq/fem/detail/quadrature.h"

namespace mq {
namespace {

using Lanes = Eigen::Array<double, 8, 1>;

/// The six points of the rule in lanes, weight 0 in the last two.
struct RuleLanes {
  Lanes l1 = Lanes::Zero(), l2 = Lanes::Zero(), weight = Lanes::Zero();
  RuleLanes() {
    for (int q = 0; q < 6; ++q) {
      l1[q] = triangle_rule_4()[q].l1;
      l2[q] = triangle_rule_4()[q].l2;
      weight[q] = triangle_rule_4()[q].weight;
    }
  }
};

}  // namespace

std::array<double, 9> bernstein_moments(std::span<const std::array<double, 2>> polygon) {
  static const RuleLanes rule;
  std::array<Lanes, 9> sums;
  sums.fill(Lanes::Zero());
  const auto& o = polygon[0];
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const double ux = polygon[k - 1][0] - o[0], uy = polygon[k - 1][1] - o[1];
    const double vx = polygon[k][0] - o[0], vy = polygon[k][1] - o[1];
    const double area = std::abs(ux * vy - uy * vx) / 2;
    const Lanes x = o[0] + rule.l1 * ux + rule.l2 * vx, y = o[1] + rule.l1 * uy + rule.l2 * vy;
    const Lanes x0 = 1 - x, y0 = 1 - y, weight = rule.weight * area;
    const Lanes bx[3] = {x0 * x0, x0 * x, x * x};
    const Lanes by[3] = {y0 * y0 * weight, y0 * y * weight, y * y * weight};
    for (int q = 0; q < 3; ++q)
      for (int p = 0; p < 3; ++p) sums[p + 3 * q] += bx[p] * by[q];
  }
  std::array<double, 9> moments;
  for (int k = 0; k < 9; ++k) {
    moments[k] = 0;
    for (int lane = 0; lane < 6; ++lane) moments[k] += sums[k][lane];
  }
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
