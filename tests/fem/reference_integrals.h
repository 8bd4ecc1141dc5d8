#pragma once
/// Integrals of bilinear functions on charts, written down a second time: cells and triangles cut by
/// half-planes in long double, Gauss points in a square collapsed to a triangle, exact to degree 6.
/// Nothing of the library takes part but the rounded corners of the triangles.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/fem/texels.h"
#include "mq/linear/matrix.h"

namespace mq::fixtures {

using Real = long double;
using RealPoint = std::array<Real, 2>;
using RealPolygon = std::vector<RealPoint>;

/// The part of a convex polygon where a·x + b·y <= c.
inline RealPolygon cut_by_line(const RealPolygon& polygon, Real a, Real b, Real c) {
  RealPolygon result;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const RealPoint &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const Real dp = a * p[0] + b * p[1] - c, dq = a * q[0] + b * q[1] - c;
    if (dp <= 0) result.push_back(p);
    if (dp * dq < 0)
      result.push_back({p[0] + dp / (dp - dq) * (q[0] - p[0]), p[1] + dp / (dp - dq) * (q[1] - p[1])});
  }
  return result;
}

/// Calls visit(x, y, weight) for points of a rule on a convex polygon, exact to degree 6.
template <class Visit>
void for_each_gauss_point(const RealPolygon& polygon, const Visit& visit) {
  const Real near = std::sqrt(Real(3) / 7 - Real(2) / 7 * std::sqrt(Real(6) / 5)) / 2,
             far = std::sqrt(Real(3) / 7 + Real(2) / 7 * std::sqrt(Real(6) / 5)) / 2;
  const Real wide = (18 + std::sqrt(Real(30))) / 72, thin = (18 - std::sqrt(Real(30))) / 72;
  const std::array<Real, 4> points = {Real(0.5) - far, Real(0.5) - near, Real(0.5) + near,
                                      Real(0.5) + far};
  const std::array<Real, 4> weights = {thin, wide, wide, thin};
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const RealPoint &o = polygon[0], &p = polygon[k - 1], &q = polygon[k];
    const Real twice = std::abs((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]));
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const Real s = points[i], t = points[j] * (1 - s);  // o + s (p − o) + t (q − o)
        visit(o[0] + s * (p[0] - o[0]) + t * (q[0] - o[0]),
              o[1] + s * (p[1] - o[1]) + t * (q[1] - o[1]),
              weights[i] * weights[j] * (1 - s) * twice);
      }
  }
}

/// The corners of a triangle in texels.
inline RealPolygon corners_of(const Atlas& atlas, int triangle) {
  RealPolygon corners;
  for (const TexelPoint& p : atlas.corners[triangle])
    corners.push_back({Real(p.x) / Real(TexelPoint::one), Real(p.y) / Real(TexelPoint::one)});
  return corners;
}

/// J, the derivative of position by texels, a column each for x and y.
using RealJacobian = Eigen::Matrix<Real, 3, 2>;
inline RealJacobian jacobian_of(const Surface& surface, const Atlas& atlas, int triangle) {
  const RealPolygon p = corners_of(atlas, triangle);
  Eigen::Matrix<Real, 2, 2> texel;
  RealJacobian space;
  for (int k = 0; k < 2; ++k) {
    texel.col(k) << p[k + 1][0] - p[0][0], p[k + 1][1] - p[0][1];
    space.col(k) = (surface.mesh.position(triangle, k + 1) - surface.mesh.position(triangle, 0)).cast<Real>();
  }
  return space * texel.inverse();
}

/// √|g| and √|g| g⁻¹ of g = JᵀJ.
struct RealMetric {
  Real density, a, b, c;
};
inline RealMetric metric_of(const RealJacobian& J) {
  const Eigen::Matrix<Real, 2, 2> g = J.transpose() * J;
  const Real density = std::sqrt(g.determinant());
  return {density, g(1, 1) / density, -g(0, 1) / density, g(0, 0) / density};
}
inline RealMetric real(const TexelMetric& m) { return {m.density, m.a, m.b, m.c}; }

/// Texels of one clamped texture and their values and slopes at a point.
struct RealSample {
  int triangle;
  Real x, y, weight;  ///< in texels, texels²
  std::array<int, 4> texels;
  std::array<Real, 4> value, dx, dy;
};

/// Calls visit(sample) for points of all triangles, one texture.
template <class Visit>
void for_each_reference_point(const Atlas& atlas, const Texels& texels, const Visit& visit) {
  std::map<std::array<int, 2>, int> number;
  for (int i = 0; i < texels.size(); ++i) number[{texels.places[i].x, texels.places[i].y}] = i;
  const TextureSize& size = atlas.textures[0];
  for (int t = 0; t < int(atlas.chart.size()); ++t) {
    if (atlas.chart[t] < 0) continue;
    const RealPolygon corners = corners_of(atlas, t);
    const auto range = [&](int d) {
      const auto [low, high] = std::minmax({corners[0][d], corners[1][d], corners[2][d]});
      return std::array{int(std::floor(low)), int(std::floor(high))};
    };
    const auto [left, right] = range(0);
    const auto [top, bottom] = range(1);
    for (int j = top; j <= bottom; ++j)
      for (int i = left; i <= right; ++i) {
        RealPolygon piece = cut_by_line(corners, -1, 0, -i);
        piece = cut_by_line(piece, 1, 0, i + 1);
        piece = cut_by_line(piece, 0, -1, -j);
        piece = cut_by_line(piece, 0, 1, j + 1);
        if (piece.size() < 3) continue;
        RealSample s{t, 0, 0, 0, {}, {}, {}, {}};
        for (int k = 0; k < 4; ++k) {
          const auto inside = [](int at, int n) { return std::min(std::max(at, 0), n - 1); };
          const auto at =
              number.find({inside(i + (k & 1), size.width), inside(j + (k >> 1), size.height)});
          s.texels[k] = at == number.end() ? -1 : at->second;
        }
        for_each_gauss_point(piece, [&](Real x, Real y, Real weight) {
          if (weight == 0) return;  // of a cell that a side merely runs along
          require(*std::min_element(s.texels.begin(), s.texels.end()) >= 0, "a texel is missing");
          s.x = x, s.y = y, s.weight = weight;
          for (int k = 0; k < 4; ++k) {
            const int p = k & 1, q = k >> 1;
            const Real fx = p ? x - i : 1 - (x - i), fy = q ? y - j : 1 - (y - j);
            s.value[k] = fx * fy;
            s.dx[k] = (p ? 1 : -1) * fy;
            s.dy[k] = (q ? 1 : -1) * fx;
          }
          visit(s);
        });
      }
  }
}

/// Mass and stiffness with a metric per triangle.
struct ReferenceMatrices {
  SparseMatrix mass, stiffness;
};
inline ReferenceMatrices reference_matrices(const Atlas& atlas, const Texels& texels,
                                            const std::vector<RealMetric>& metrics) {
  std::map<std::array<int, 2>, std::array<Real, 2>> sums;
  std::array<int, 4> cell{-1, -1, -1, -1};
  Eigen::Matrix<Real, 4, 4> M = Eigen::Matrix<Real, 4, 4>::Zero(), S = M;
  const auto add_cell = [&] {
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4 && cell[0] >= 0; ++j) {
        auto& sum = sums[{cell[i], cell[j]}];
        sum[0] += M(i, j);
        sum[1] += S(i, j);
      }
    M.setZero(), S.setZero();
  };
  for_each_reference_point(atlas, texels, [&](const RealSample& s) {
    if (s.texels != cell) add_cell();
    cell = s.texels;
    const RealMetric& m = metrics[s.triangle];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        M(i, j) += s.weight * m.density * s.value[i] * s.value[j];
        S(i, j) += s.weight * (m.a * s.dx[i] * s.dx[j] + m.c * s.dy[i] * s.dy[j] +
                               m.b * (s.dx[i] * s.dy[j] + s.dy[i] * s.dx[j]));
      }
  });
  add_cell();
  Entries mass, stiffness;
  for (const auto& [at, sum] : sums) {
    mass.emplace_back(at[0], at[1], double(sum[0]));
    stiffness.emplace_back(at[0], at[1], double(sum[1]));
  }
  const int n = texels.size();
  return {sparse_matrix(n, n, mass), sparse_matrix(n, n, stiffness)};
}

}  // namespace mq::fixtures
