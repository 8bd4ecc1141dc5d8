// Filtering textures: what must not change it (where charts lie, how they are turned, in which
// pictures, in which order triangles come) and what it must keep (the mean, everything for beta 1).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::cut_squares;
using fixtures::CutOptions;
using Place = Texels::Place;

/// Corners at whole multiples of 2⁻²⁰ texel, so that moves by whole texels and quarter turns about
/// them are exact.
Mesh on_fine_grid(Mesh mesh, const TextureSize& size) {
  const auto round = [](double x) { return std::round(x * 0x1p20) / 0x1p20; };
  for (Vector2& uv : mesh.uvs)
    uv = Vector2((round(uv.x() * size.width - 0.5) + 0.5) / size.width,
                 (round(uv.y() * size.height - 0.5) + 0.5) / size.height);
  return mesh;
}

/// A cut square and a texture for it.
struct Model {
  Mesh mesh;
  std::vector<TextureSize> sizes;
};

/// Where on the first model a texel of the second lies.
using Home = std::function<Place(const Place&, int chart)>;

/// Filters noise on both models, the same at the same places, and expects the same back.
void expect_same_result(const Model& first, const Model& second, const Home& home) {
  const auto a = fixtures::textured(first.mesh, first.sizes);
  const auto b = fixtures::textured(second.mesh, second.sizes);
  const TexelSpace space_a(a->surface, a->atlas), space_b(b->surface, b->atlas);
  ASSERT_EQ(space_a.size(), space_b.size());
  EXPECT_FALSE(fixtures::shares_texels(space_a) || fixtures::shares_texels(space_b));
  const auto key = [](const Place& p) { return std::tuple(p.texture, p.y, p.x); };
  std::map<std::tuple<int, int, int>, int> number;
  for (int i = 0; i < space_a.size(); ++i) number[key(space_a.texels().places[i])] = i;
  std::vector<int> twin(space_b.size());
  for (int i = 0; i < space_b.size(); ++i) {
    const auto at = number.find(key(home(space_b.texels().places[i], space_b.texels().chart[i])));
    ASSERT_NE(at, number.end());
    twin[i] = at->second;
  }
  const Signal psi_a = test::random_signal(space_a.size(), 2);
  const Signal psi_b = psi_a(twin, Eigen::all);
  for (const double weight : {1e-3, 1e-1})
    for (const double beta : {0.0, 3.0}) {
      const Signal phi_a = ScreenedPoisson(space_a, weight).solve(psi_a, beta).signal;
      const Signal phi_b = ScreenedPoisson(space_b, weight).solve(psi_b, beta).signal;
      EXPECT_GT((phi_a - psi_a).cwiseAbs().maxCoeff(), 0.1);
      EXPECT_LT((phi_b - phi_a(twin, Eigen::all)).cwiseAbs().maxCoeff(), 1e-9)
          << "weight " << weight << ", beta " << beta;
    }
}

Place stay(const Place& place, int) { return place; }

Model model_of(const CutOptions& options, const TextureSize& size) {
  return {on_fine_grid(fixtures::cut_square(options), size), {size}};
}

std::vector<std::pair<CutOptions, TextureSize>> models() {
  CutOptions slanted = fixtures::slanted();
  slanted.scale = 0.45;
  return {{fixtures::turned(fixtures::odd_angle), {96, 96}}, {slanted, {96, 160}}};
}

/// The vertices of the texture that chart c uses.
std::vector<char> uvs_of(const Mesh& mesh, const CutOptions& options, int part) {
  std::vector<char> used(mesh.uvs.size());
  const Atlas atlas = make_atlas(make_surface(mesh), {{96, 96}});
  EXPECT_EQ(std::ssize(atlas.charts), options.charts());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (atlas.chart[t] == part)
      for (int uv : mesh.corner_uvs[t]) used[uv] = 1;
  return used;
}

TEST(TexelFilter, IsUnchangedByMovingOneChartWholeTexels) {
  for (auto [options, size] : models()) {
    const Model before = model_of(options, size);
    Model after = before;
    const std::vector<char> moved = uvs_of(before.mesh, options, 1);
    for (std::size_t k = 0; k < moved.size(); ++k)
      if (moved[k]) after.mesh.uvs[k] += Vector2(2.0 / size.width, -3.0 / size.height);
    // Three texels down in uv are three rows down in the picture.
    expect_same_result(before, after, [](const Place& p, int chart) {
      return chart == 1 ? Place{p.texture, p.x - 2, p.y - 3} : p;
    });
  }
}

TEST(TexelFilter, IsUnchangedByTurningOneChartAQuarter) {
  for (CutOptions options : {fixtures::turned(fixtures::odd_angle), fixtures::slanted()}) {
    options.scale = 0.45;
    const TextureSize size{96, 96};
    const Model before = model_of(options, size);
    Model after = before;
    const std::vector<char> turned = uvs_of(before.mesh, options, 1);
    const Vector2 middle = fixtures::middle_of_part(options, 1);  // 71.5, 71.5 in texels
    for (std::size_t k = 0; k < turned.size(); ++k)
      if (turned[k]) {
        const Vector2 d = before.mesh.uvs[k] - middle;
        after.mesh.uvs[k] = middle + Vector2(-d.y(), d.x());
      }
    // Counter-clockwise seen with v upward: column 71.5 + dy, row 71.5 - dx in rows downward.
    expect_same_result(before, after, [](const Place& p, int chart) {
      return chart == 1 ? Place{p.texture, 143 - p.y, p.x} : p;
    });
  }
}

TEST(TexelFilter, IsUnchangedBySplittingATextureInTwo) {
  for (auto [options, size] : models()) {
    const Model before = model_of(options, size);
    Model after = before;
    const int half = size.width / 2;
    after.sizes = {{half, size.height}, {half, size.height}};
    for (Vector2& uv : after.mesh.uvs) uv.x() = 2 * uv.x() - (uv.x() > 0.5);
    for (int t = 0; t < after.mesh.triangle_count(); ++t)
      after.mesh.textures[t] = before.mesh.uv(t, 0).x() > 0.5;
    expect_same_result(before, after, [&](const Place& p, int) {
      return Place{0, p.x + (p.texture ? half : 0), p.y};
    });
  }
}

TEST(TexelFilter, IsUnchangedByTheOrderOfTrianglesCornersAndVertices) {
  for (auto [options, size] : models()) {
    const Model before = model_of(options, size);
    const Mesh& mesh = before.mesh;
    const auto shuffled = [](int n, std::uint64_t seed) {
      std::vector<int> order(n);
      std::iota(order.begin(), order.end(), 0);
      const Random random(seed);
      for (int i = n - 1; i > 0; --i) std::swap(order[i], order[random.bits(i) % (i + 1)]);
      return order;
    };
    Model after = before;
    const std::vector<int> vertex = shuffled(mesh.vertex_count(), 1);
    for (int v = 0; v < mesh.vertex_count(); ++v)
      after.mesh.positions[vertex[v]] = mesh.positions[v];
    const std::vector<int> triangle = shuffled(mesh.triangle_count(), 2);
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int s = triangle[t], c = (k + t) % 3;
        after.mesh.triangles[s][c] = vertex[mesh.triangles[t][k]];
        after.mesh.corner_uvs[s][c] = mesh.corner_uvs[t][k];
        after.mesh.textures[s] = mesh.textures[t];
      }
    expect_same_result(before, after, stay);
  }
}

/// Mean colours, by the lumped mass.
Eigen::RowVectorXd mean(const TexelSpace& space, const Signal& signal) {
  const Vector mass = space.mass() * Vector::Ones(space.size());
  return mass.transpose() * signal / mass.sum();
}

/// Texels that hardly any point of the surface shows are held to their neighbours in what is solved
/// (`TexelSpace::regularised_system`); the addition sums to 0 over every row, so means stay.
TEST(TexelFilter, KeepsTheMeanWhereTexelsAreHeld) {
  int held = 0;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    held += (space.regularised_system(1, 1e-3) - space.system(1, 1e-3)).norm() > 0;
    const Signal psi = test::random_signal(space.size(), 3);
    for (const double weight : {1e-4, 1e-2, 1.0, ScreenedPoisson::infinite_weight})
      for (const double beta : {0.0, 3.0}) {
        const Signal phi = ScreenedPoisson(space, weight).solve(psi, beta).signal;
        EXPECT_LT((mean(space, phi) - mean(space, psi)).cwiseAbs().maxCoeff(), 1e-11)
            << cut.name << ", weight " << weight << ", beta " << beta;
      }
  }
  EXPECT_GE(held, 4);
}

/// Refuses its matrix a few times, as a factorisation does that rounding makes indefinite.
SolverFactory reluctant(int times) {
  return [times](const SparseMatrix& A, const Progress& progress) mutable {
    if (times-- > 0) throw NotPositiveDefinite("not yet");
    return direct_solver()(A, progress);
  };
}

TEST(TexelFilter, KeepsTheMeanWithARaisedDiagonal) {
  const Cut cut = fixtures::cut("", fixtures::slanted(), {96, 160});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 3);
  for (const double weight : {1e-4, 1e-2, 1.0, ScreenedPoisson::infinite_weight})
    for (const int times : {1, 4}) {  // by 1e-12, by 1e-9
      const Filtered filtered = ScreenedPoisson(space, weight, reluctant(times)).solve(psi, 3);
      EXPECT_NE(filtered.report.method.find("raised"), std::string::npos);
      EXPECT_LT((mean(space, filtered.signal) - mean(space, psi)).cwiseAbs().maxCoeff(), 1e-6)
          << "weight " << weight << ", refused " << times;
    }
}

TEST(TexelFilter, ReturnsTheInputBitForBitForBetaOne) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const Signal psi = test::random_signal(space.size(), 3);
    for (const double weight : {1e-3, ScreenedPoisson::infinite_weight})
      EXPECT_TRUE(ScreenedPoisson(space, weight).solve(psi, 1).signal == psi) << cut.name;
  }
}

/// Only gradients count, and those asked for are a linear function's: it comes back across all
/// seams, up to a constant. Texels that are held to their neighbours
/// (`TexelSpace::regularised_system`, τ = 1e-4) pull along borders with a ten-thousandth of the
/// gradient; without any, the screen of 1e-10 is left.
TEST(TexelFilter, FindsLinearFunctionsFromTheirGradient) {
  int without = 0, with = 0;
  for (const Cut& cut : cut_squares()) {
    if (!cut.apart) continue;
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const bool held = (space.regularised_system(0, 1) - space.system(0, 1)).norm() > 0;
    const auto linear = [](const Vector2& p) { return p.x() - 0.6 * p.y() - 0.2; };  // of mean 0
    const std::vector<Vector3> gradient(cut.model->surface.triangle_count(), Vector3(1, -0.6, 0));
    const ScreenedPoisson equation(space, ScreenedPoisson::infinite_weight);
    const Signal found =
        equation.solve_towards(Signal::Zero(space.size(), 1), space.divergence({gradient})).signal;
    const Mesh& mesh = cut.model->surface.mesh;
    const Random random(3);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const Vector3 l = fixtures::random_point(random, t);
      ASSERT_NEAR(fixtures::value_at(space, found, t, l),
                  linear(fixtures::on_surface(mesh, t, l).head<2>()), held ? 1e-3 : 1e-8)
          << cut.name;
    }
    ++(held ? with : without);
  }
  EXPECT_EQ(without, 2);
  EXPECT_EQ(with, 8);
}

TEST(TexelFilter, KeepsTheMeanHoweverLargeTheWeight) {
  const fixtures::Cut cut =
      fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {160, 160});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 3);
  const Eigen::RowVectorXd mean = (space.mass() * psi).colwise().sum() / space.scale().area;
  for (const double weight : {1.0, 1e3, 1e6}) {
    const Signal phi =
        ScreenedPoisson(space, weight, multigrid_solver(space.texels())).solve(psi, 0).signal;
    const Eigen::RowVectorXd after = (space.mass() * phi).colwise().sum() / space.scale().area;
    EXPECT_LT((after - mean).cwiseAbs().maxCoeff(), 0.1 / 65535) << weight;

    const auto precise = multigrid_solver(space.texels(), {.tolerance = 1e-8});
    const Signal by_cycles = ScreenedPoisson(space, weight, precise).solve(psi, 0).signal;
    const Signal exact = ScreenedPoisson(space, weight).solve(psi, 0).signal;
    EXPECT_LT((by_cycles - exact).cwiseAbs().maxCoeff(), 0.5 / 65535) << weight;
  }
}

TEST(TexelFilter, IsTheSameInTwoStepsBetweenWhichTheSpaceLetsGo) {
  const fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {160, 160});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 3);
  std::vector<double> beta(std::size_t(space.size()), 2.0);
  for (const bool even : {true, false}) {
    if (!even) beta.front() = 0.5;
    const ScreenedPoisson equation(space, 1e-3, space.multigrid());
    const Signal expected = equation.solve(psi, beta).signal;
    Signal change = gradient_change(space, psi, beta);
    space.let_go_of_integrals();
    EXPECT_EQ(Signal(equation.correction(std::move(change)).signal + psi), expected);
    space.integrate_again();
  }
}

}  // namespace
}  // namespace mq
