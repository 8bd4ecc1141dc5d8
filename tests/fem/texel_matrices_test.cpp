// M, S and the divergence of the texel space against integrals that share nothing with it
// (reference_integrals.h), with the surface's metric and with others.

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "fem/cut_squares.h"
#include "fem/reference_integrals.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using fixtures::corners_of;
using fixtures::Cut;
using fixtures::cut_squares;
using fixtures::jacobian_of;
using fixtures::metric_of;
using fixtures::on_surface;
using fixtures::Real;
using fixtures::RealMetric;

/// The largest difference of entries of the rows asked for, over the largest entry.
template <class Rows>
double difference(const SparseMatrix& A, const SparseMatrix& B, const Rows& rows) {
  const SparseMatrix D = A - B;
  double worst = 0, largest = 0;
  for (int i = 0; i < A.rows(); ++i) {
    for (SparseMatrix::InnerIterator it(B, i); it; ++it)
      largest = std::max(largest, std::abs(it.value()));
    if (!rows(i)) continue;
    for (SparseMatrix::InnerIterator it(D, i); it; ++it)
      worst = std::max(worst, std::abs(it.value()));
  }
  return worst / largest;
}

std::vector<RealMetric> metrics_of(const Cut& cut, const TexelSpaceOptions& options) {
  std::vector<RealMetric> metrics;
  for (int t = 0; t < cut.model->surface.triangle_count(); ++t)
    metrics.push_back(options.metrics.empty()
                          ? metric_of(jacobian_of(cut.model->surface, cut.model->atlas, t))
                          : fixtures::real(options.metrics[t]));
  return metrics;
}

/// Any metrics at all: stretched up to 1 : 6, densities over a factor of 20.
std::vector<TexelMetric> random_metrics(const Cut& cut) {
  const Random random(21);
  std::vector<TexelMetric> metrics;
  for (int t = 0; t < cut.model->surface.triangle_count(); ++t) {
    const double stretch = std::exp(random.uniform(3 * t, 0, 1.8));
    const double angle = random.uniform(3 * t + 1, 0, 3.2), c = std::cos(angle), s = std::sin(angle);
    TexelMetric m;
    m.density = std::exp(random.uniform(3 * t + 2, -10, -7));
    m.stretch = stretch;
    m.a = c * c * stretch + s * s / stretch;
    m.b = c * s * (stretch - 1 / stretch);
    m.c = s * s * stretch + c * c / stretch;
    metrics.push_back(m);
  }
  return metrics;
}

/// The charts of a cut square as surfaces of their own: nothing but bilinear functions.
Cut torn(const Cut& cut) {
  return {cut.name + ", torn", cut.options, cut.size, cut.apart,
          fixtures::textured(fixtures::torn(cut.model->surface.mesh), {cut.size})};
}

/// Where no seam is near, integrals are exact: all rows of torn charts, the inner ones of others.
void expect_reference_integrals(const Cut& cut, const TexelSpaceOptions& options = {}) {
  const TexelSpace space(cut.model->surface, cut.model->atlas, options);
  const auto reference =
      reference_matrices(cut.model->atlas, space.texels(), metrics_of(cut, options));
  const bool seams = cut.model->atlas.seam_count > 0;
  const auto rows = [&](int i) { return !seams || space.texels().interior[i]; };
  EXPECT_LT(difference(space.mass(), reference.mass, rows), 1e-13) << cut.name;
  EXPECT_LT(difference(space.stiffness(), reference.stiffness, rows), 1e-13) << cut.name;
}

TEST(TexelMatrices, AreTheIntegralsOfBilinearFunctionsAwayFromSeams) {
  for (const Cut& cut : cut_squares()) {
    expect_reference_integrals(cut);
    expect_reference_integrals(torn(cut));
  }
}

TEST(TexelMatrices, AreTheIntegralsWithAnyMetricPerTriangle) {
  for (const Cut& cut : cut_squares())
    expect_reference_integrals(torn(cut), {.metrics = random_metrics(cut)});
}

/// Next to seams the matrices are what the points of `for_each_piece` say, with any metric.
TEST(TexelMatrices, AreSumsOverThePointsOfPieces) {
  for (const Cut& cut : cut_squares())
    for (const bool own : {true, false}) {
      const TexelSpaceOptions options{.metrics = own ? std::vector<TexelMetric>() : random_metrics(cut)};
      const TexelSpace space(cut.model->surface, cut.model->atlas, options);
      const std::vector<RealMetric> metrics = metrics_of(cut, options);
      Entries mass, stiffness;
      space.for_each_piece([&](const TexelSamples& p) {
        const RealMetric& metric = metrics[p.triangle];
        const auto weights = p.weights.asDiagonal();
        const Eigen::MatrixXd M = double(metric.density) * p.values.transpose() * weights * p.values;
        const Eigen::MatrixXd S = p.dx.transpose() * weights * (double(metric.a) * p.dx + double(metric.b) * p.dy) +
                                  p.dy.transpose() * weights * (double(metric.b) * p.dx + double(metric.c) * p.dy);
        for (std::size_t i = 0; i < p.texels.size(); ++i)
          for (std::size_t j = 0; j < p.texels.size(); ++j) {
            mass.emplace_back(p.texels[i], p.texels[j], M(i, j));
            stiffness.emplace_back(p.texels[i], p.texels[j], S(i, j));
          }
      });
      const auto all = [](int) { return true; };
      const int n = space.size();
      EXPECT_LT(difference(space.mass(), sparse_matrix(n, n, mass), all), 1e-13) << cut.name;
      EXPECT_LT(difference(space.stiffness(), sparse_matrix(n, n, stiffness), all), 1e-13) << cut.name;
    }
}

/// Slopes are those of the values: central differences of `basis_at`, a step of 1e-6 texels.
/// Where slopes jump or turn, one-sided differences say by how much the central one is off.
TEST(TexelMatrices, HaveTheSlopesOfTheBasis) {
  const double step = 1e-6;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    int tested = 0, bent = 0, pieces = 0;
    space.for_each_piece([&](const TexelSamples& p) {
      const bool near_seam = p.texels.size() > 4;
      if (pieces++ % (near_seam ? 5 : 4)) return;
      const fixtures::RealPolygon c = corners_of(cut.model->atlas, p.triangle);
      Eigen::Matrix2d edges;
      for (int k = 0; k < 2; ++k)
        edges.col(k) << double(c[k + 1][0] - c[0][0]), double(c[k + 1][1] - c[0][1]);
      const Eigen::Matrix2d inverse = edges.inverse();
      for (Eigen::Index q = 0; q < p.values.rows(); q += 3) {
        const Vector3 l = p.barycentric.row(q).transpose();
        if (l.minCoeff() * std::abs(edges.determinant()) < 100 * step * edges.cwiseAbs().maxCoeff())
          continue;  // a step could leave the triangle
        for (int axis = 0; axis < 2; ++axis) {
          const Eigen::Vector2d d = inverse.col(axis) * step;
          const Vector3 move(-d.sum(), d.x(), d.y());
          std::map<int, std::array<double, 3>> value;
          for (int side : {-1, 0, 1})
            for (const BasisWeight& w : space.basis_at(p.triangle, l + side * move))
              value[w.unknown][side + 1] = w.weight;
          for (std::size_t k = 0; k < p.texels.size(); ++k) {
            const auto [left, middle, right] = value[p.texels[k]];
            ASSERT_NEAR(middle, p.values(q, k), 1e-10) << cut.name;
            const double slope = axis ? p.dy(q, k) : p.dx(q, k);
            const double forward = (right - middle) / step, backward = (middle - left) / step;
            ++tested;
            bent += std::abs(forward - backward) > 1e-3;
            ASSERT_NEAR((forward + backward) / 2, slope, 1e-5 + std::abs(forward - backward))
                << cut.name;
          }
        }
      }
    });
    EXPECT_GT(tested, 500) << cut.name;
    EXPECT_LT(bent, 0.05 * tested) << cut.name;
  }
}

/// 2-D Dirichlet energy is conformally invariant: S feels no density, M and the divergence are
/// proportional to it.
TEST(TexelMatrices, StiffnessIsThatOfEveryConformalMetric) {
  for (const Cut& cut : cut_squares()) {
    TexelSpaceOptions options{.metrics = random_metrics(cut)};
    const TexelSpace space(cut.model->surface, cut.model->atlas, options);
    for (std::size_t t = 0; t < options.metrics.size(); ++t)
      options.metrics[t].density *= 1 + double(t % 7);
    const TexelSpace conformal(cut.model->surface, cut.model->atlas, options);
    EXPECT_EQ((space.stiffness() - conformal.stiffness()).norm(), 0) << cut.name;
    EXPECT_GT((space.mass() - conformal.mass()).norm(), space.mass().norm()) << cut.name;
    for (TexelMetric& metric : options.metrics) metric.density *= 4;
    const TexelSpace larger(cut.model->surface, cut.model->atlas, options);
    EXPECT_EQ((larger.mass() - 4 * conformal.mass()).norm(), 0) << cut.name;
  }
}

TEST(TexelMatrices, RefuseMetricsThatAreNone) {
  const Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {48, 48});
  const std::vector<TexelMetric> good = random_metrics(cut);
  const auto space = [&](const std::vector<TexelMetric>& metrics) {
    return TexelSpace(cut.model->surface, cut.model->atlas, {.metrics = metrics});
  };
  EXPECT_NO_THROW(space(good));
  std::vector<TexelMetric> bad = good;
  bad.pop_back();
  EXPECT_THROW(space(bad), InvalidInput);
  for (const TexelMetric& metric :
       {TexelMetric{1, 1, 0, 2}, TexelMetric{1, -1, 0, -1}, TexelMetric{0, 1, 0, 1},
        TexelMetric{1, 1, std::nan(""), 1}, TexelMetric{std::nan(""), 1, 0, 1}}) {
    bad = good;
    bad[7] = metric;
    EXPECT_THROW(space(bad), InvalidInput);
  }
}

/// b_t = ∫ dφ_t(X) dA with X a vector in space per triangle and the density of the metric.
Signal reference_divergence(const Cut& cut, const Texels& texels, const std::vector<RealMetric>& metrics,
                            const std::vector<Vector3>& field) {
  std::vector<Eigen::Matrix<Real, 2, 1>> in_texels;
  for (int t = 0; t < cut.model->surface.triangle_count(); ++t) {
    const fixtures::RealJacobian J = jacobian_of(cut.model->surface, cut.model->atlas, t);
    const Eigen::Matrix<Real, 2, 2> g = J.transpose() * J;
    in_texels.push_back(g.inverse() * (J.transpose() * field[t].cast<Real>()));
  }
  Signal b = Signal::Zero(texels.size(), 1);
  fixtures::for_each_reference_point(cut.model->atlas, texels, [&](const fixtures::RealSample& s) {
    const auto& xi = in_texels[s.triangle];
    for (int k = 0; k < 4; ++k)
      b(s.texels[k], 0) += double(s.weight * metrics[s.triangle].density *
                                  (xi[0] * s.dx[k] + xi[1] * s.dy[k]));
  });
  return b;
}

TEST(TexelDivergence, IsTheIntegralWithAnyMetric) {
  for (const Cut& cut : cut_squares())
    for (const Cut& tried : {torn(cut)})
      for (const bool own : {true, false}) {
        const TexelSpaceOptions options{.metrics = own ? std::vector<TexelMetric>() : random_metrics(tried)};
        const TexelSpace space(tried.model->surface, tried.model->atlas, options);
        const Random random(31);
        std::vector<Vector3> field;
        for (int t = 0; t < tried.model->surface.triangle_count(); ++t)
          field.push_back({random.uniform(3 * t, -1, 1), random.uniform(3 * t + 1, -1, 1),
                           random.uniform(3 * t + 2, -1, 1)});
        const Signal expected =
            reference_divergence(tried, space.texels(), metrics_of(tried, options), field);
        EXPECT_LT((space.divergence({field}) - expected).cwiseAbs().maxCoeff(),
                  1e-13 * expected.cwiseAbs().maxCoeff())
            << tried.name;
      }
}

/// With X the metric's own gradient of ψ it is S·ψ; with the surface's gradient it is not.
TEST(TexelDivergence, OfTheMetricsOwnGradientIsStiffnessTimesThePotential) {
  const Cut cut = torn(fixtures::cut("", fixtures::slanted(), {30, 50}));
  const TexelSpaceOptions options{.metrics = random_metrics(cut)};
  const TexelSpace space(cut.model->surface, cut.model->atlas, options);
  Signal psi(space.size(), 1);  // a texel's column: slope (1, 0) in texels
  for (int i = 0; i < space.size(); ++i) psi(i, 0) = space.texels().places[i].x;
  std::vector<Vector3> own, of_the_surface;
  for (int t = 0; t < cut.model->surface.triangle_count(); ++t) {
    const fixtures::RealJacobian J = jacobian_of(cut.model->surface, cut.model->atlas, t);
    const TexelMetric& m = options.metrics[t];
    own.push_back((J.cast<double>() * Vector2(m.a, m.b)) / m.density);
    const Eigen::Matrix<Real, 2, 2> g = J.transpose() * J;
    of_the_surface.push_back((J * g.inverse().col(0)).cast<double>());
  }
  const Signal b = space.divergence({own, of_the_surface}), expected = space.stiffness_times(psi);
  EXPECT_LT((b.col(0) - expected).norm(), 1e-12 * expected.norm());
  EXPECT_GT((b.col(1) - expected).norm(), 0.1 * expected.norm());
}

/// The vector from the middle of the square, turned by 90 degrees or not.
Vector2 position_field(const Vector3& p, bool turned) {
  const Vector2 x = p.head<2>() - Vector2(0.5, 0.5);
  return turned ? Vector2(-x.y(), x.x()) : x;
}

/// −b_t / ∫φ_t for b_t = ∫ ⟨X, ∇φ_t⟩ is the divergence; that of −J·X is the curl.
struct Divergences {
  Signal moments;  ///< of x and of Jx
  Vector share;    ///< ∫φ_t
};
Divergences of_position_fields(const Cut& cut, const TexelSpace& space) {
  Divergences result{Signal::Zero(space.size(), 2), Vector::Zero(space.size())};
  space.for_each_piece([&](const TexelSamples& p) {
    const RealMetric metric = metric_of(jacobian_of(cut.model->surface, cut.model->atlas, p.triangle));
    const Eigen::Matrix<double, 3, 2> J =
        jacobian_of(cut.model->surface, cut.model->atlas, p.triangle).cast<double>();
    const Eigen::Matrix2d inverse = J.topRows<2>().inverse();
    for (Eigen::Index q = 0; q < p.weights.size(); ++q) {
      const double weight = p.weights[q] * double(metric.density);
      const Vector3 at = on_surface(cut.model->surface.mesh, p.triangle, p.barycentric.row(q).transpose());
      for (std::size_t k = 0; k < p.texels.size(); ++k) {
        result.share[p.texels[k]] += weight * p.values(q, k);
        for (const bool turned : {false, true}) {
          const Vector2 xi = inverse * position_field(at, turned);
          result.moments(p.texels[k], turned) += weight * (xi.x() * p.dx(q, k) + xi.y() * p.dy(q, k));
        }
      }
    }
  });
  return result;
}

/// Texels whose function is 0 on the border of the square.
std::vector<char> off_the_border(const Cut& cut, const TexelSpace& space) {
  std::vector<char> off(space.size(), 1);
  for (HalfEdge h = 0; h < HalfEdge(cut.model->atlas.edges.size()); ++h)
    if (cut.model->atlas.edges[h] == EdgeKind::boundary)
      for (int k = 0; k <= 200; ++k)
        for (const BasisWeight& w : space.basis_at(h / 3, fixtures::on_half_edge(h, k / 200.0)))
          off[w.unknown] = 0;
  return off;
}

/// Exact inside charts. Next to seams the rule is not: within η of a seam functions have kinks along
/// its normals, at every texel line either side crosses, and pieces are not parted there. What that
/// leaves of ∫∇φ_t is a part in a hundred or less of a texel's width, alternates, and sums to 0 over
/// the texels of a cell, against linear functions too: orders of convergence are not touched.
TEST(TexelDivergence, OfThePositionIsTwoAndOfItsTurnZero) {
  int inner = 0, at_seams = 0;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const Divergences d = of_position_fields(cut, space);
    const std::vector<char> off = off_the_border(cut, space);
    const double h = cut.model->atlas.texel_spacing();
    for (int i = 0; i < space.size(); ++i) {
      if (!off[i]) continue;
      const double error =
          std::max(std::abs(d.moments(i, 0) + 2 * d.share[i]), std::abs(d.moments(i, 1)));
      if (space.texels().interior[i]) {
        ASSERT_LT(error, 1e-12 * h * h) << cut.name;
        ++inner;
      } else {
        ASSERT_LT(error, 0.02 * h) << cut.name;
        ++at_seams;
      }
    }
  }
  EXPECT_GT(inner, 5000);
  EXPECT_GT(at_seams, 5000);
}

/// The field of differences z_ij: of x, whose integral along an edge is the difference of |x|²/2, and
/// of Jx, where it is x_i × x_j. Their weak divergences, 2 and 0, are those of inner stencils.
TEST(TexelDivergence, OfDifferencesOfThePositionIsTwoAndOfItsTurnZero) {
  int inner = 0;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    std::vector<Vector2> x = texels_on_square(cut.options, cut.size, space.texels());
    const auto edges = space.edges();
    Signal z(std::ssize(edges), 2);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const Vector2 &p = x[edges[e][0]], &q = x[edges[e][1]];
      z.row(e) << (q.squaredNorm() - p.squaredNorm()) / 2, p.x() * q.y() - p.y() * q.x();
    }
    const Signal b = space.edge_divergence(edges, z);
    const Vector share = space.mass() * Vector::Ones(space.size());
    const std::vector<char> off = off_the_border(cut, space);
    const double h = cut.model->atlas.texel_spacing();
    for (int i = 0; i < space.size(); ++i) {
      if (!space.texels().interior[i] || !off[i]) continue;
      ++inner;
      ASSERT_NEAR(b(i, 0), -2 * share[i], 5e-11 * h) << cut.name;
      ASSERT_NEAR(b(i, 1), 0, 5e-11 * h) << cut.name;
    }
  }
  EXPECT_GT(inner, 5000);
}

}  // namespace
}  // namespace mq
