#pragma once
/// Integration over triangles by positive rules that are exact for the polynomials used here.

#include <array>
#include <cmath>

namespace mq {

/// Barycentric coordinates and weight; the weights of a rule add up to 1 (the triangle's area).
struct TrianglePoint {
  double l0, l1, l2, weight;
};

/// Exact for polynomials of degree 2: the edge midpoints.
inline constexpr std::array<TrianglePoint, 3> triangle_rule_2 = {
    {{0.5, 0.5, 0, 1.0 / 3}, {0, 0.5, 0.5, 1.0 / 3}, {0.5, 0, 0.5, 1.0 / 3}}};

/// Exact for polynomials of degree 4: six points (Strang and Fix 1973), in closed form.
inline const std::array<TrianglePoint, 6>& triangle_rule_4() {
  static const std::array<TrianglePoint, 6> rule = [] {
    const double root10 = std::sqrt(10.0), inner = std::sqrt(38 - 44 * std::sqrt(0.4));
    const double spread = std::sqrt(213125 - 53320 * root10);
    const double a = (8 - root10 + inner) / 18, b = (8 - root10 - inner) / 18;
    const double wa = (620 + spread) / 3720, wb = (620 - spread) / 3720;
    return std::array<TrianglePoint, 6>{{{1 - 2 * a, a, a, wa},
                                         {a, 1 - 2 * a, a, wa},
                                         {a, a, 1 - 2 * a, wa},
                                         {1 - 2 * b, b, b, wb},
                                         {b, 1 - 2 * b, b, wb},
                                         {b, b, 1 - 2 * b, wb}}};
  }();
  return rule;
}

}  // namespace mq
