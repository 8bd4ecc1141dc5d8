// The published basis: what it shares with ours, and what a node near a seam costs in it.
#include "mq/baseline/quadratic_seam_basis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "fem/scaled_spectrum.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::CutOptions;

/// Four charts, each turned by another angle.
Cut turned_charts(int size) { return fixtures::cut("", fixtures::turned(fixtures::odd_angle), {size, size}); }

double sum_of(const std::vector<BasisWeight>& weights) {
  double sum = 0;
  for (const BasisWeight& w : weights) sum += w.weight;
  return sum;
}

double value_of(const std::vector<BasisWeight>& weights, const Vector& values) {
  double sum = 0;
  for (const BasisWeight& w : weights) sum += w.weight * values[w.unknown];
  return sum;
}

/// Values that know nothing of each other.
Vector rough(int size) {
  Vector values(size);
  for (int i = 0; i < size; ++i) values[i] = std::sin(12.9898 * i);
  return values;
}

TEST(QuadraticSeamBasis, AddsUpToOneAndIsTheSameFromBothSides) {
  const Cut cut = turned_charts(48);
  const Surface& surface = cut.model->surface;
  const QuadraticSeamBasis basis(surface, cut.model->atlas);
  const Vector values = rough(basis.size());
  int on_seams = 0;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    EXPECT_NEAR(sum_of(basis.basis_at(h / 3, {0.2, 0.5, 0.3})), 1, 1e-12);
    if (cut.model->atlas.edges[std::size_t(h)] != EdgeKind::seam || surface.twins[std::size_t(h)] < 0) continue;
    for (const double s : {0.137, 0.5, 0.81}) {
      const auto at = [&](HalfEdge side, double along) {
        Vector3 place = Vector3::Zero();
        place[side % 3] = 1 - along, place[(side + 1) % 3] = along;
        return value_of(basis.basis_at(side / 3, place), values);
      };
      EXPECT_NEAR(at(h, s), at(surface.twins[std::size_t(h)], 1 - s), 1e-7) << h;
      ++on_seams;
    }
  }
  EXPECT_GT(on_seams, 50);
}

TEST(QuadraticSeamBasis, HasTheMatricesOfASignalSpace) {
  const Cut cut = turned_charts(40);
  const QuadraticSeamBasis basis(cut.model->surface, cut.model->atlas);
  const SparseMatrix M = basis.system(1, 0), S = basis.system(0, 1);
  const Vector ones = Vector::Ones(basis.size());
  EXPECT_NEAR(ones.dot(M * ones), 1, 1e-9);
  EXPECT_LT((S * ones).norm(), 1e-9);
  const Vector f = rough(basis.size());
  EXPECT_GT(f.dot(M * f), 0);
  EXPECT_GE(f.dot(S * f), 0);
  EXPECT_LT((M - SparseMatrix(M.transpose())).norm(), 1e-12);
}

/// Away from seams both are the bilinear functions of the texels.
TEST(QuadraticSeamBasis, IsBilinearInsideOfCharts) {
  const Cut cut = turned_charts(48);
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const QuadraticSeamBasis basis(cut.model->surface, cut.model->atlas);
  std::map<std::array<int, 3>, int> number;
  for (int i = 0; i < basis.size(); ++i) number[basis.texels()[std::size_t(i)]] = i;
  const SparseMatrix S = basis.system(0, 1), ours = space.stiffness();
  int compared = 0;
  for (int i = 0; i < space.size(); ++i) {
    const auto& texels = space.texels();
    if (!texels.interior[std::size_t(i)]) continue;
    const auto key = [&](int k) {
      const Texels::Place& p = texels.places[std::size_t(k)];
      return std::array{p.texture, p.x, p.y};
    };
    for (SparseMatrix::InnerIterator it(ours, i); it; ++it, ++compared)
      ASSERT_NEAR(S.coeff(number.at(key(i)), number.at(key(int(it.col())))), it.value(), 1e-9);
  }
  EXPECT_GT(compared, 1000);
}

/// Solutions of −wΔφ + φ = f with free border on the square, cut into four turned charts.
TEST(QuadraticSeamBasis, ConvergesWithTheSecondPower) {
  std::array<double, 2> errors;
  for (const int k : {0, 1}) {
    const Cut cut = turned_charts(48 << k);
    const QuadraticSeamBasis basis(cut.model->surface, cut.model->atlas);
    const double pi = std::acos(-1.0), w = 0.02;
    const auto exact = [&](const Vector3& p) { return std::cos(2 * pi * p.x()) * std::cos(pi * p.y()); };
    // The right-hand side by the mass matrix of the exact solution's values at texels that lie on the surface is not to be had
    // for those beside charts, so it is integrated.
    Vector b = Vector::Zero(basis.size());
    const Surface& surface = cut.model->surface;
    constexpr int cuts = 24;
    for (int t = 0; t < surface.triangle_count(); ++t)
      for (int i = 0; i < cuts; ++i)
        for (int j = 0; j < cuts - i; ++j)
          for (int half = 0; half < (j + i + 1 < cuts ? 2 : 1); ++half) {
            const double third = half ? 2.0 / 3 : 1.0 / 3, u = (i + third) / cuts, v = (j + third) / cuts;
            const Vector3 place(1 - u - v, u, v);
            Vector3 p = Vector3::Zero();
            for (int c = 0; c < 3; ++c) p += place[c] * surface.mesh.position(t, c);
            const double area = (surface.mesh.position(t, 1) - surface.mesh.position(t, 0)).cross(surface.mesh.position(t, 2) - surface.mesh.position(t, 0)).norm() / 2;
            for (const auto& [n, weight] : basis.basis_at(t, place))
              b[n] += area / (cuts * cuts) * weight * (1 + 5 * pi * pi * w) * exact(p);
          }
    SparseMatrix A = basis.system(1, w);
    const double trace = A.diagonal().mean();
    for (int i = 0; i < A.rows(); ++i) A.coeffRef(i, i) += 1e-9 * trace;  // texels that hardly meet the surface
    const Vector phi = DirectSolver(A).solve(b);
    double sum = 0;
    int count = 0;
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 place(0.3, 0.45, 0.25);
      Vector3 p = Vector3::Zero();
      for (int c = 0; c < 3; ++c) p += place[c] * surface.mesh.position(t, c);
      sum += std::pow(value_of(basis.basis_at(t, place), phi) - exact(p), 2);
      ++count;
    }
    errors[std::size_t(k)] = std::sqrt(sum / count);
  }
  EXPECT_LT(errors[0], 0.02);
  EXPECT_GT(errors[0] / errors[1], 3) << errors[0] << ' ' << errors[1];
}

/// Seams so far off the texel lines that they run along.
Cut seams_off_lines(double offset) {
  CutOptions options;
  options.jitter = 0;
  options.cells = 4;
  options.scale = 0.75;
  options.shift = [=](int chart) { return Vector2(offset * (chart + 1) / 24, -offset / 24); };
  return fixtures::cut("", options, {24, 24});
}

/// The largest eigenvalue of the scaled system, and its condition, go with 1/d; ours are bounded.
TEST(QuadraticSeamBasis, CostsOneOverTheDistanceOfANodeFromASeam) {
  std::vector<double> published, ours, distance;
  for (const double offset : {1e-1, 1e-2, 1e-3}) {
    const Cut cut = seams_off_lines(offset);
    const QuadraticSeamBasis basis(cut.model->surface, cut.model->atlas);
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const SparseMatrix S = basis.system(0, 1), M = basis.system(1, 0);
    double largest = 0, own = 0;
    for (int i = 0; i < S.rows(); ++i) largest = std::max(largest, S.coeff(i, i));
    const SparseMatrix T = space.stiffness();
    for (int i = 0; i < T.rows(); ++i) own = std::max(own, T.coeff(i, i));
    published.push_back(largest);
    ours.push_back(own);
    distance.push_back(basis.nearest_node());
  }
  EXPECT_NEAR(distance[2], 1e-3, 1e-6);
  EXPECT_GT(published[1] / published[0], 5);
  EXPECT_GT(published[2] / published[1], 7);
  EXPECT_LT(ours[2] / ours[0], 1.5);
}

}  // namespace
}  // namespace mq
