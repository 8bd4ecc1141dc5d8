#include "mq/fem/texel_space.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "atlas/atlas_fixtures.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::CutOptions;
using fixtures::Textured;

std::unique_ptr<Textured> square(const CutOptions& options, int size = 48) {
  return fixtures::textured(fixtures::cut_square(options), {{size, size}});
}

CutOptions turned(std::function<double(int)> angle, int parts = 2) {
  CutOptions options;
  options.parts = parts;
  options.cells = 6 * parts;
  options.angle = std::move(angle);
  options.scale = 0.6;
  options.shift = [](int chart) { return Vector2(0.0023 * chart, -0.0031 * chart); };
  return options;
}

/// Every way of cutting that the tests below run on: seams along texel lines, across them, vertices
/// on texel centres, tiny charts, charts that share texels.
std::vector<std::pair<std::string, std::unique_ptr<Textured>>> cut_squares() {
  std::vector<std::pair<std::string, std::unique_ptr<Textured>>> all;
  all.emplace_back("one chart", square([] {
                     CutOptions o;
                     o.parts = 1;
                     return o;
                   }()));
  all.emplace_back("turned by odd angles", square(turned(fixtures::odd_angle)));
  all.emplace_back("quarter turns", square(turned(fixtures::quarter_turn)));
  CutOptions on_lines = turned(fixtures::quarter_turn);
  on_lines.jitter = 0;
  on_lines.scale = 0.75;  // 36 of 48 texels for 12 cells: corners on texel centres
  on_lines.shift = [](int) { return Vector2(0.5 / 48, 0.5 / 48); };
  all.emplace_back("on texel lines", square(on_lines));
  on_lines.shift = [](int chart) {
    return Vector2((0.5 + 1e-8 * chart) / 48, (0.5 - 1e-7 * chart) / 48);
  };
  all.emplace_back("a hair beside texel lines", square(on_lines));
  all.emplace_back("36 charts", square(turned(fixtures::odd_angle, 6)));
  CutOptions crowded = turned(fixtures::odd_angle, 6);
  crowded.scale = 0.5;
  all.emplace_back("charts of few texels", square(crowded, 24));
  all.emplace_back("charts below a texel", square(crowded, 5));
  return all;
}

Signal column(const SparseMatrix& matrix) { return matrix * Signal::Ones(matrix.cols(), 1); }

/// Value at each texel of a function of space, by the affine map of the texel's chart.
Signal sample(const Textured& model, const TexelSpace& space,
              const std::function<double(const Vector3&)>& f) {
  Signal values(space.size(), 1);
  std::vector<int> triangle(model.atlas.charts.size(), -1);
  for (int t = 0; t < model.surface.triangle_count(); ++t)
    if (model.atlas.chart[t] >= 0 && triangle[model.atlas.chart[t]] < 0)
      triangle[model.atlas.chart[t]] = t;
  for (int i = 0; i < space.size(); ++i) {
    const auto& at = space.texels().places[i];
    const int chart = space.texels().chart[i];
    // A texel that only a seam couples in lies beyond every chart's cells; none here does.
    EXPECT_GE(chart, 0);
    const int t = triangle[chart];
    const auto& p = model.atlas.corners[t];
    Eigen::Matrix2d E;
    E << p[1].column() - p[0].column(), p[2].column() - p[0].column(), p[1].row() - p[0].row(),
        p[2].row() - p[0].row();
    const Eigen::Vector2d l =
        E.inverse() * Eigen::Vector2d(at.x - p[0].column(), at.y - p[0].row());
    const Mesh& m = model.surface.mesh;
    values(i, 0) = f(m.position(t, 0) + l[0] * (m.position(t, 1) - m.position(t, 0)) +
                     l[1] * (m.position(t, 2) - m.position(t, 0)));
  }
  return values;
}

bool shares_texels(const TexelSpace& space) {
  return std::any_of(space.defects().begin(), space.defects().end(), [](const Defect& d) {
    return d.kind == "shared_texels" || d.kind == "overlapping_triangles";
  });
}

TEST(TexelSpace, MassSumsToTheArea) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-13) << name;
    EXPECT_GT(space.mass().diagonal().minCoeff(), 0) << name;
  }
}

TEST(TexelSpace, StiffnessVanishesOnConstantsAndIsSymmetric) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    const SparseMatrix S = space.stiffness(), M = space.mass();
    EXPECT_LT(column(S).cwiseAbs().maxCoeff(), 1e-12) << name;
    EXPECT_LT((S - SparseMatrix(S.transpose())).norm(), 1e-12 * S.norm()) << name;
    EXPECT_LT((M - SparseMatrix(M.transpose())).norm(), 1e-13 * M.norm()) << name;
  }
}

TEST(TexelSpace, StiffnessIsSemidefinite) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (space.size() > 1500) continue;
    const SparseMatrix S = space.stiffness();
    const Eigen::VectorXd d = S.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = d.asDiagonal() * Eigen::MatrixXd(S) * d.asDiagonal();
    const auto values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
            .eigenvalues();
    EXPECT_GT(values[0], -1e-12) << name;
    EXPECT_GT(values[1], 1e-6) << name << ": one component, one constant";
  }
}

TEST(TexelSpace, ReproducesLinearFunctionsAcrossSeams) {
  const auto linear = [](const Vector3& p) { return p.x() - 0.6 * p.y() + 0.2; };
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (shares_texels(space)) continue;
    const Signal phi = sample(*model, space, linear);
    EXPECT_NEAR((phi.transpose() * (space.stiffness() * phi))(0, 0), 1.36, 1e-10) << name;
    const double integral_of_square = 1.0 / 3 + 0.36 / 3 + 0.04 - 0.3 + 0.2 - 0.12;
    EXPECT_NEAR((phi.transpose() * (space.mass() * phi))(0, 0), integral_of_square, 1e-11) << name;
    const Random random(5);
    for (std::uint64_t k = 0; k < 2000; ++k) {
      const int t = int(random.uniform(3 * k, 0, model->surface.triangle_count()));
      double u = random.uniform(3 * k + 1, 0, 1), v = random.uniform(3 * k + 2, 0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      if (k % 4 == 0) u = 0;  // on an edge, seams among them
      const Mesh& m = model->surface.mesh;
      const Vector3 p = m.position(t, 0) + u * (m.position(t, 1) - m.position(t, 0)) +
                        v * (m.position(t, 2) - m.position(t, 0));
      double value = 0;
      for (const TexelWeight& w : space.basis_at(t, {1 - u - v, u, v}))
        value += w.weight * phi(w.texel, 0);
      ASSERT_NEAR(value, linear(p), 1e-11) << name << " triangle " << t;
    }
  }
}

TEST(TexelSpace, IsAPartitionOfUnity) {
  const Random random(6);
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    for (std::uint64_t k = 0; k < 12500; ++k) {
      const int t = int(random.uniform(3 * k, 0, model->surface.triangle_count()));
      double u = random.uniform(3 * k + 1, 0, 1), v = random.uniform(3 * k + 2, 0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      if (k % 3 == 0) v = 0;
      double sum = 0;
      for (const TexelWeight& w : space.basis_at(t, {1 - u - v, u, v})) sum += w.weight;
      ASSERT_NEAR(sum, 1, 1e-13) << name;
    }
  }
}

TEST(TexelSpace, HasOneValueOnBothSidesOfASeam) {
  const Random random(8);
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    Signal phi(space.size(), 1);
    for (int i = 0; i < space.size(); ++i) phi(i, 0) = random.uniform(i, 0, 1);
    const auto value = [&](HalfEdge h, double s) {
      Vector3 l = Vector3::Zero();
      l[h % 3] = 1 - s;
      l[(h + 1) % 3 == h % 3 ? 0 : (h % 3 + 1) % 3] = s;
      double sum = 0;
      for (const TexelWeight& w : space.basis_at(h / 3, l)) sum += w.weight * phi(w.texel, 0);
      return sum;
    };
    int seams = 0;
    for (HalfEdge h = 0; h < HalfEdge(model->atlas.edges.size()); ++h) {
      if (model->atlas.edges[h] != EdgeKind::seam || model->surface.twins[h] < h) continue;
      ++seams;
      for (double s : {0.0, 1e-9, 0.137, 0.5, 0.77, 1.0})
        ASSERT_NEAR(value(h, s), value(model->surface.twins[h], 1 - s), 2e-12) << name << ' ' << s;
    }
    EXPECT_EQ(seams > 0, name != "one chart");
  }
}

TEST(TexelSpace, IsBilinearAwayFromSeams) {
  const auto model = square(turned(fixtures::odd_angle));
  const TexelSpace space(model->surface, model->atlas);
  std::vector<int> unknown(48 * 48, -1);
  for (int i = 0; i < space.size(); ++i)
    unknown[space.texels().places[i].y * 48 + space.texels().places[i].x] = i;
  const Random random(9);
  int tested = 0;
  for (std::uint64_t k = 0; k < 5000; ++k) {
    const int t = int(random.uniform(3 * k, 0, model->surface.triangle_count()));
    const Vector3 l(0.3, 0.5, 0.2);
    const auto& c = model->atlas.corners[t];
    const double x = l[0] * c[0].column() + l[1] * c[1].column() + l[2] * c[2].column();
    const double y = l[0] * c[0].row() + l[1] * c[1].row() + l[2] * c[2].row();
    const int i = int(std::floor(x)), j = int(std::floor(y));
    const auto inside = [&](int a, int b) {
      return unknown[b * 48 + a] >= 0 && space.texels().interior[unknown[b * 48 + a]];
    };
    if (!inside(i, j) || !inside(i + 1, j + 1)) continue;
    ++tested;
    for (const TexelWeight& w : space.basis_at(t, l)) {
      const auto& at = space.texels().places[w.texel];
      EXPECT_NEAR(w.weight, (1 - std::abs(x - at.x)) * (1 - std::abs(y - at.y)), 1e-13);
    }
  }
  EXPECT_GT(tested, 1000);
}

TEST(TexelSpace, HasTheTextbookStencilOnAnAlignedChart) {
  CutOptions options;
  options.parts = 1;
  options.cells = 6;
  options.jitter = 0;
  options.scale = 0.75;
  const auto model = square(options, 64);  // surface per texel: 1 / 48
  const TexelSpace space(model->surface, model->atlas);
  const SparseMatrix M = space.mass(), S = space.stiffness();
  const double h2 = 1.0 / 48 / 48;
  int tested = 0;
  for (int i = 0; i < space.size(); ++i) {
    if (!space.texels().interior[i]) continue;
    ++tested;
    const auto& a = space.texels().places[i];
    for (SparseMatrix::InnerIterator it(M, i); it; ++it) {
      const auto& b = space.texels().places[it.col()];
      const int far = std::abs(a.x - b.x) + std::abs(a.y - b.y);
      const double weight[3] = {16.0 / 36, 4.0 / 36, 1.0 / 36};
      EXPECT_NEAR(it.value() / h2, weight[far], 1e-13);
    }
    for (SparseMatrix::InnerIterator it(S, i); it; ++it)
      EXPECT_NEAR(it.value(), it.col() == i ? 8.0 / 3 : -1.0 / 3, 1e-13);
  }
  EXPECT_GT(tested, 1000);
}

/// M and S from a rule applied point by point to the basis functions themselves.
TEST(TexelSpace, AgreesWithQuadratureOfItsBasis) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (space.size() > 1600) continue;
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(space.size(), space.size()), S = M;
    space.for_each_piece([&](const TexelSamples& samples) {
      const TexelMetric metric = texel_metric(model->surface, model->atlas, samples.triangle);
      for (int q = 0; q < samples.weights.size(); ++q)
        for (std::size_t i = 0; i < samples.texels.size(); ++i)
          for (std::size_t j = 0; j < samples.texels.size(); ++j) {
            const double xi = samples.dx(q, i), yi = samples.dy(q, i), xj = samples.dx(q, j),
                         yj = samples.dy(q, j);
            M(samples.texels[i], samples.texels[j]) +=
                samples.weights[q] * metric.density * samples.values(q, i) * samples.values(q, j);
            S(samples.texels[i], samples.texels[j]) +=
                samples.weights[q] *
                (metric.a * xi * xj + metric.b * (xi * yj + yi * xj) + metric.c * yi * yj);
          }
    });
    EXPECT_LT((M - Eigen::MatrixXd(space.mass())).norm(), 1e-13 * M.norm()) << name;
    EXPECT_LT((S - Eigen::MatrixXd(space.stiffness())).norm(), 1e-12 * S.norm()) << name;
  }
}

/// Largest eigenvalue of D⁻¹A and the ratio to the smallest.
std::pair<double, double> scaled_spectrum(const SparseMatrix& A) {
  const Eigen::VectorXd d = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd B = d.asDiagonal() * Eigen::MatrixXd(A) * d.asDiagonal();
  const auto values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(B, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[values.size() - 1], values[values.size() - 1] / values[0]};
}

TEST(TexelSpace, StaysWellConditionedHoweverNearASeamIsToTexels) {
  CutOptions options;
  options.jitter = 0;
  options.cells = 4;
  options.scale = 0.75;
  double reference = 0;
  for (double offset : {0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 0.0}) {
    options.shift = [offset](int chart) {
      return Vector2((0.5 + offset * (chart + 1)) / 24, (0.5 - offset) / 24);
    };
    const auto model = square(options, 24);
    const TexelSpace space(model->surface, model->atlas);
    const auto [largest, condition] = scaled_spectrum(space.system(1, 1e-2));
    EXPECT_LT(largest, 8) << offset;
    if (reference == 0) reference = condition;
    EXPECT_LT(condition, 20 * reference) << offset;
  }
}

TEST(TexelSpace, VariesContinuouslyWithTheOffsetOfASeam) {
  CutOptions options;
  options.jitter = 0;
  options.cells = 4;
  options.scale = 0.75;
  const auto smooth = [&](double offset) {
    options.shift = [offset](int chart) {
      return Vector2((0.5 + offset * (chart % 2 ? 1 : -1)) / 24, 0.5 / 24);
    };
    const auto model = square(options, 24);
    const TexelSpace space(model->surface, model->atlas);
    Signal psi(space.size(), 1);
    for (int i = 0; i < space.size(); ++i) {
      const auto& at = space.texels().places[i];
      psi(i, 0) = std::sin(0.9 * at.x) * std::cos(0.7 * at.y);
    }
    const Signal phi = DirectSolver(space.system(1, 1e-2)).solve(space.mass() * psi);
    Image<float> picture(24, 24, 1);
    std::vector<Image<float>> pictures{picture};
    space.scatter(phi, pictures);
    return pictures[0];
  };
  const Image<float> at_zero = smooth(0);
  for (double offset : {1e-3, 1e-5}) {
    const Image<float> near = smooth(offset);
    double worst = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x)
        if (at_zero(x, y) != 0 && near(x, y) != 0)
          worst = std::max(worst, double(std::abs(at_zero(x, y) - near(x, y))));
    EXPECT_LT(worst, 20 * offset + 1e-6) << offset;
  }
}

/// What a smoothing does to a texel, by the texel's place in chart c (invariant under moves).
Signal smoothed(const TexelSpace& space, const std::function<double(const Texels::Place&)>& psi) {
  Signal values(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) values(i, 0) = psi(space.texels().places[i]);
  return DirectSolver(space.system(1, 1e-3)).solve(space.mass() * values);
}

double pattern(double x, double y) {
  return std::sin(0.8 * x + 0.1 * y * y) + 0.3 * std::cos(1.7 * y);
}

TEST(TexelSpace, IsUnchangedByMovingAChartWholeTexels) {
  CutOptions options = turned(fixtures::odd_angle);
  options.scale = 0.5;
  const auto move = [](int chart) {
    return chart == 1 ? Vector2(3.0 / 64, -5.0 / 64) : Vector2(0, 0);
  };
  const auto before = square(options, 64);
  const auto shift = options.shift;
  options.shift = [=](int chart) { return Vector2(shift(chart) + move(chart)); };
  const auto after = square(options, 64);
  const TexelSpace a(before->surface, before->atlas), b(after->surface, after->atlas);
  ASSERT_EQ(a.size(), b.size());
  // UV 5/64 down is 5 texel rows down.
  const Signal pa = smoothed(a, [&](const auto& p) { return pattern(p.x, p.y); });
  std::map<std::pair<int, int>, double> value;
  for (int i = 0; i < a.size(); ++i)
    value[{a.texels().places[i].x, a.texels().places[i].y}] = pa(i, 0);
  const int moved = before->atlas.chart[2 * 6];  // a triangle of the second chart
  std::map<std::pair<int, int>, int> chart_of;
  for (int i = 0; i < b.size(); ++i)
    chart_of[{b.texels().places[i].x, b.texels().places[i].y}] = b.texels().chart[i];
  const auto home = [&](int x, int y) {
    return chart_of[{x, y}] == moved ? std::pair(x - 3, y - 5) : std::pair(x, y);
  };
  const Signal pb = smoothed(b, [&](const auto& p) {
    const auto [x, y] = home(p.x, p.y);
    return pattern(x, y);
  });
  for (int i = 0; i < b.size(); ++i) {
    const auto at = home(b.texels().places[i].x, b.texels().places[i].y);
    ASSERT_TRUE(value.count(at));
    EXPECT_NEAR(pb(i, 0), value[at], 1e-9);
  }
}

TEST(TexelSpace, IsUnchangedByTurningTheTextureAQuarter) {
  const auto before = square(turned(fixtures::odd_angle), 48);
  Mesh mesh = before->surface.mesh;
  for (Vector2& uv : mesh.uvs) uv = Vector2(uv.y(), 1 - uv.x());
  const auto after = fixtures::textured(mesh, {{48, 48}});
  const TexelSpace a(before->surface, before->atlas), b(after->surface, after->atlas);
  const Signal pa = smoothed(a, [&](const auto& p) { return pattern(p.x, p.y); });
  // (u, v) -> (v, 1 - u): column x = u·W - ½ becomes row x; row y becomes column 47 - y.
  const Signal pb = smoothed(b, [&](const auto& p) { return pattern(p.y, 47 - p.x); });
  std::map<std::pair<int, int>, double> value;
  for (int i = 0; i < a.size(); ++i)
    value[{a.texels().places[i].x, a.texels().places[i].y}] = pa(i, 0);
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < b.size(); ++i)
    EXPECT_NEAR(pb(i, 0), (value[{b.texels().places[i].y, 47 - b.texels().places[i].x}]), 1e-9);
}

TEST(TexelSpace, IsUnchangedBySplittingATextureInTwo) {
  CutOptions options = turned(fixtures::odd_angle);
  const auto together = square(options, 48);
  options.texture = [](int chart) { return chart % 2; };
  const auto apart = fixtures::textured(fixtures::cut_square(options), {{48, 48}, {48, 48}});
  const TexelSpace a(together->surface, together->atlas), b(apart->surface, apart->atlas);
  ASSERT_EQ(a.size(), b.size());
  const auto f = [&](const auto& p) { return pattern(p.x, p.y); };
  const Signal pa = smoothed(a, f), pb = smoothed(b, f);
  std::map<std::pair<int, int>, double> value;
  for (int i = 0; i < a.size(); ++i)
    value[{a.texels().places[i].x, a.texels().places[i].y}] = pa(i, 0);
  for (int i = 0; i < b.size(); ++i)
    EXPECT_NEAR(pb(i, 0), (value[{b.texels().places[i].x, b.texels().places[i].y}]), 1e-9);
}

TEST(TexelSpace, IsUnchangedByTheOrderOfTriangles) {
  const auto model = square(turned(fixtures::quarter_turn), 48);
  Mesh mesh = model->surface.mesh;
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  std::reverse(mesh.corner_uvs.begin(), mesh.corner_uvs.end());
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    std::rotate(mesh.triangles[t].begin(), mesh.triangles[t].begin() + 1, mesh.triangles[t].end());
    std::rotate(mesh.corner_uvs[t].begin(), mesh.corner_uvs[t].begin() + 1,
                mesh.corner_uvs[t].end());
  }
  const auto other = fixtures::textured(mesh, {{48, 48}});
  const TexelSpace a(model->surface, model->atlas), b(other->surface, other->atlas);
  ASSERT_EQ(a.size(), b.size());
  const auto f = [&](const auto& p) { return pattern(p.x, p.y); };
  EXPECT_LT((smoothed(a, f) - smoothed(b, f)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(TexelSpace, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto model = square(turned(fixtures::odd_angle, 6), 200);
  std::vector<double> reference;
  for (int threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const TexelSpace space(model->surface, model->atlas);
    const SparseMatrix A = space.system(1, 1e-3);
    const std::vector<double> values(A.valuePtr(), A.valuePtr() + A.nonZeros());
    if (reference.empty()) reference = values;
    EXPECT_EQ(values, reference) << threads;
  }
}

TEST(TexelSpace, AppliesStiffnessWithoutAMatrix) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    Signal psi(space.size(), 2);
    const Random random(4);
    for (int i = 0; i < space.size(); ++i)
      psi(i, 0) = random.uniform(2 * i, 0, 1), psi(i, 1) = random.uniform(2 * i + 1, 0, 1);
    const Signal expected = space.stiffness() * psi;
    EXPECT_LT((space.stiffness_times(psi) - expected).norm(), 1e-12 * expected.norm()) << name;
    const std::vector<double> twice(space.size(), 2.0);
    EXPECT_LT((space.stiffness_times(psi, twice) - 2 * expected).norm(), 1e-12 * expected.norm())
        << name;
    EXPECT_EQ(space.stiffness_times(Signal::Constant(space.size(), 1, 0.1)).cwiseAbs().maxCoeff(),
              0)
        << name;
  }
}

TEST(TexelSpace, ModulatedStiffnessIsThatOfItsCells) {
  const auto model = square(turned(fixtures::odd_angle));
  const TexelSpace space(model->surface, model->atlas);
  std::vector<double> beta(space.size());
  for (int i = 0; i < space.size(); ++i) beta[i] = space.texels().chart[i] == 1 ? 1.0 : 0.0;
  const Signal phi = sample(*model, space, [](const Vector3& p) { return p.x(); });
  // ∫ β |∇x|² over one chart of four; cells of other charts read the texels of none.
  double expected = 0;
  for (int t = 0; t < model->surface.triangle_count(); ++t)
    if (model->atlas.chart[t] == 1)
      expected +=
          0.5 * (model->surface.mesh.position(t, 1) - model->surface.mesh.position(t, 0))
                    .cross(model->surface.mesh.position(t, 2) - model->surface.mesh.position(t, 0))
                    .norm();
  EXPECT_NEAR((phi.transpose() * space.stiffness_times(phi, beta))(0, 0), expected, 1e-10);
}

TEST(TexelSpace, DivergenceOfAGradientIsStiffnessTimesThePotential) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (shares_texels(space)) continue;
    const Signal x = sample(*model, space, [](const Vector3& p) { return p.x(); });
    const std::vector<Vector3> field(model->surface.triangle_count(), Vector3(1, 0, 0.7));
    EXPECT_LT((space.divergence({field}) - space.stiffness_times(x)).cwiseAbs().maxCoeff(), 1e-11)
        << name;
    // Twice the divergence theorem: ∫ ⟨X, ∇φ⟩ for X = the position, against φ = 1, is 0.
    EXPECT_NEAR(space.divergence({field}).sum(), 0, 1e-12) << name;
  }
}

TEST(TexelSpace, DivergenceOfDifferencesIsStiffnessTimesThePotential) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (space.size() > 2500) continue;
    const auto edges = space.edges();
    const Random random(14);
    Signal psi(space.size(), 1), z(Eigen::Index(edges.size()), 1);
    for (int i = 0; i < space.size(); ++i) psi(i, 0) = random.uniform(i, 0, 1);
    for (std::size_t e = 0; e < edges.size(); ++e)
      z(e, 0) = psi(edges[e][1], 0) - psi(edges[e][0], 0);
    const Signal expected = space.stiffness_times(psi);
    EXPECT_LT((space.edge_divergence(edges, z) - expected).norm(), 1e-12 * expected.norm()) << name;
  }
}

TEST(TexelSpace, SoftSeamsApproachContinuityAsThePenaltyGrows) {
  const auto model = square(turned(fixtures::odd_angle), 48);
  TexelSpaceOptions options;
  options.seams = TexelSpaceOptions::Seams::soft;
  options.seam_penalty = 10;
  const TexelSpace space(model->surface, model->atlas, options);
  EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-13);
  EXPECT_LT(column(space.stiffness()).cwiseAbs().maxCoeff(), 1e-11);
  // A linear function agrees on both sides: no penalty.
  const Signal phi = sample(*model, space, [](const Vector3& p) { return p.x() - p.y(); });
  EXPECT_NEAR((phi.transpose() * (space.stiffness() * phi))(0, 0), 2.0, 1e-9);
  options.seam_penalty = 0;
  const TexelSpace torn(model->surface, model->atlas, options);
  // Without a penalty every chart's constant is in the null space.
  Signal charts(torn.size(), 1);
  for (int i = 0; i < torn.size(); ++i) charts(i, 0) = torn.texels().chart[i];
  EXPECT_LT((torn.stiffness() * charts).norm(), 1e-11);
  EXPECT_GT((space.stiffness() * charts).norm(), 1);
}

TEST(TexelSpace, WorksOnTexturesOfAnySize) {
  for (int width : {1, 2, 3, 17})
    for (int height : {1, 2, 5})
      for (Wrap wrap : {Wrap::clamp, Wrap::repeat}) {
        Mesh mesh = fixtures::cut_square(turned(fixtures::odd_angle));
        if (wrap == Wrap::repeat)
          for (Vector2& uv : mesh.uvs) uv += Vector2(0.4, 0.3);
        const auto model = fixtures::textured(mesh, {{width, height, wrap}});
        const TexelSpace space(model->surface, model->atlas);
        EXPECT_LE(space.size(), width * height);
        EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-12) << width << " x " << height;
        EXPECT_LT(column(space.stiffness()).cwiseAbs().maxCoeff(), 1e-11);
        const Signal phi = smoothed(space, [](const auto&) { return 0.25; });
        EXPECT_LT((phi.array() - 0.25).abs().maxCoeff(), 1e-9);
      }
}

TEST(TexelSpace, IsSolvableWhereTipsOfChartsMakeTexelsDependent) {
  for (const auto& [name, model] : cut_squares()) {
    const TexelSpace space(model->surface, model->atlas);
    if (space.size() > 1500) continue;
    const double w = 1e-2;
    const SparseMatrix A = space.solvable(1, w), plain = space.system(1, w);
    EXPECT_EQ(A.nonZeros(), plain.nonZeros());
    EXPECT_LT((A - SparseMatrix(A.transpose())).norm(), 1e-13 * A.norm()) << name;
    EXPECT_LT((column(A) - column(plain)).cwiseAbs().maxCoeff(), 1e-13) << name;
    const auto [largest, condition] = scaled_spectrum(A);
    EXPECT_LT(condition, 1e5) << name << ", without: " << scaled_spectrum(plain).second;
  }
}

TEST(TexelSpace, CoversTrianglesThatLeaveTheirTextureByTiles) {
  for (Wrap wrap : {Wrap::clamp, Wrap::repeat})
    for (double low : {-5.0, -0.3}) {
      Mesh mesh = fixtures::flat_square(2);
      for (Vector2& uv : mesh.uvs) uv = Vector2(1.7 * uv.x() - 0.4, low + (1.2 - low) * uv.y());
      const auto model = fixtures::textured(mesh, {{512, 300, wrap}});
      const TexelSpace space(model->surface, model->atlas);
      EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-11) << low;
      EXPECT_LT(column(space.stiffness()).cwiseAbs().maxCoeff(), 1e-9) << low;
    }
}

TEST(TexelSpace, CountsManyTilesAsIfEachWereCutAlone) {
  const auto tiled = [](int cells) {  // triangles of 16 × 16 cells leave no tile twice, of 1 do
    Mesh mesh = fixtures::flat_square(cells);
    for (Vector2& uv : mesh.uvs) uv = Vector2(7.3 * uv.x() - 2.4, 5.6 * uv.y() + 1.7 * uv.x());
    return fixtures::textured(mesh, {{48, 40, Wrap::repeat}});
  };
  const auto large = tiled(1), small = tiled(16);
  const TexelSpace counted(large->surface, large->atlas), cut(small->surface, small->atlas);
  ASSERT_EQ(counted.size(), 48 * 40);
  ASSERT_EQ(cut.size(), counted.size());
  EXPECT_LT((counted.mass() - cut.mass()).norm(), 1e-11 * cut.mass().norm());
  EXPECT_LT((counted.stiffness() - cut.stiffness()).norm(), 1e-11 * cut.stiffness().norm());
}

TEST(TexelSpace, RefusesAnAtlasWithRefusedDefects) {
  Mesh mesh = fixtures::flat_square(4);
  mesh.uvs[12] += Vector2(0.6, 0);  // an inner vertex over its neighbours
  const auto model = fixtures::textured(mesh, {{16, 16}});
  try {
    TexelSpace space(model->surface, model->atlas);
    FAIL() << "nothing was thrown";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("turned over"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mq
