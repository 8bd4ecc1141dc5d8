#include "mq/fem/texel_space.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "fem/cut_squares.h"
#include "fem/reference_integrals.h"
#include "fem/scaled_spectrum.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/random.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::cut_squares;
using fixtures::CutOptions;
using fixtures::sample;
using fixtures::scaled_spectrum;
using fixtures::shares_texels;
using fixtures::Textured;
using fixtures::turned;
using fixtures::value_at;

std::unique_ptr<Textured> square(const CutOptions& options, int size = 48) {
  return fixtures::textured(fixtures::cut_square(options), {{size, size}});
}

/// Those whose matrices can be looked at as a whole.
std::vector<Cut> small_cut_squares() {
  std::vector<Cut> all = cut_squares();
  std::erase_if(all, [](const Cut& cut) { return cut.size.width * cut.size.height > 48 * 48; });
  EXPECT_EQ(all.size(), 10);
  return all;
}

Signal column(const SparseMatrix& matrix) { return matrix * Signal::Ones(matrix.cols(), 1); }

TEST(TexelSpace, KnowsWhereTexelsLieFarFromTheOriginToo) {
  const CutOptions options = turned(fixtures::odd_angle);
  const auto here = square(options);
  const Vector3 away(5e5, 4.1e6, 300);
  Mesh moved = fixtures::cut_square(options);
  for (Vector3& p : moved.positions) p += away;
  const auto there = fixtures::textured(moved, {{48, 48}});
  const TexelSpace near(here->surface, here->atlas), far(there->surface, there->atlas);
  ASSERT_EQ(near.size(), far.size());
  EXPECT_EQ(near.texels().origin.norm(), 0);
  for (int k = 0; k < near.size(); ++k)
    EXPECT_LT((far.texels().position(k) - away - near.texels().position(k)).norm(), 1e-6) << k;
}

/// A picture of one bit per pixel may say so in a few bytes.
TEST(TexelSpace, IsRefusedWhereItsTexelsAreMoreThanMemoryHolds) {
  const auto huge = square({}, 30000);
  if (available_memory() > std::int64_t(80e9)) GTEST_SKIP() << "this machine has memory for 900 million texels";
  EXPECT_THROW(TexelSpace(huge->surface, huge->atlas), OutOfMemory);
}

TEST(TexelSpace, MassSumsToTheArea) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-13) << cut.name;
    EXPECT_GT(space.mass().diagonal().minCoeff(), 0) << cut.name;
    EXPECT_LE((space.lumped_mass() - column(space.mass())).cwiseAbs().maxCoeff(), 1e-15)
        << cut.name;
  }
}

TEST(TexelSpace, StiffnessVanishesOnConstantsAndIsSymmetric) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const SparseMatrix S = space.stiffness(), M = space.mass();
    EXPECT_LT(column(S).cwiseAbs().maxCoeff(), 1e-12) << cut.name;
    EXPECT_LT((S - SparseMatrix(S.transpose())).norm(), 1e-12 * S.norm()) << cut.name;
    EXPECT_LT((M - SparseMatrix(M.transpose())).norm(), 1e-13 * M.norm()) << cut.name;
  }
}

TEST(TexelSpace, StiffnessIsSemidefinite) {
  for (const Cut& cut : small_cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const SparseMatrix S = space.stiffness();
    const Eigen::VectorXd d = S.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = d.asDiagonal() * Eigen::MatrixXd(S) * d.asDiagonal();
    const auto values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
            .eigenvalues();
    EXPECT_GT(values[0], -1e-12) << cut.name;
    EXPECT_GT(values[1], 1e-6) << cut.name << ": one component, one constant";
  }
}

TEST(TexelSpace, ReproducesLinearFunctionsAcrossSeams) {
  const auto linear = [](const Vector2& p) { return p.x() - 0.6 * p.y() + 0.2; };
  const double integral_of_square = 1.0 / 3 + 0.36 / 3 + 0.04 - 0.3 + 0.2 - 0.12;
  std::vector<std::string> left_out;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    EXPECT_EQ(shares_texels(space), !cut.apart) << cut.name;
    if (!cut.apart) {  // one texel, two places: no function is linear on both charts
      left_out.push_back(cut.name);
      continue;
    }
    const Signal phi = sample(cut, space, linear);
    EXPECT_NEAR((phi.transpose() * (space.stiffness() * phi))(0, 0), 1.36, 1e-11) << cut.name;
    EXPECT_NEAR((phi.transpose() * (space.mass() * phi))(0, 0), integral_of_square, 1e-11)
        << cut.name;
    const Mesh& mesh = cut.model->surface.mesh;
    const Random random(5);
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (std::uint64_t k = 0; k < 10; ++k) {
        const Vector3 l = fixtures::random_point(random, 10 * std::uint64_t(t) + k);
        const Vector2 p = fixtures::on_surface(mesh, t, l).head<2>();
        ASSERT_NEAR(value_at(space, phi, t, l), linear(p), 1e-11) << cut.name << " triangle " << t;
      }
    for (HalfEdge h : fixtures::seams_of(*cut.model))
      for (double s : {0.0, 1e-9, 0.137, 0.5, 0.77, 1.0}) {
        const Vector3 l = fixtures::on_half_edge(h, s);
        const Vector2 p = fixtures::on_surface(mesh, h / 3, l).head<2>();
        ASSERT_NEAR(value_at(space, phi, h / 3, l), linear(p), 1e-11) << cut.name << " seam " << h;
      }
  }
  EXPECT_EQ(left_out, (std::vector<std::string>{"charts of few texels", "charts below a texel"}));
}

TEST(TexelSpace, IsAPartitionOfUnity) {
  const Random random(6);
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const Signal ones = Signal::Ones(space.size(), 1);
    const auto triangles = std::uint64_t(cut.model->surface.triangle_count());
    for (std::uint64_t k = 0; k < 8000; ++k)
      ASSERT_NEAR(value_at(space, ones, int(k % triangles), fixtures::random_point(random, k)), 1,
                  1e-13)
          << cut.name;
    const std::vector<HalfEdge> seams = fixtures::seams_of(*cut.model);
    for (std::uint64_t k = 0; k < 2000 && !seams.empty(); ++k)
      for (HalfEdge h :
           {seams[k % seams.size()], cut.model->surface.twins[seams[k % seams.size()]]})
        ASSERT_NEAR(value_at(space, ones, h / 3, fixtures::on_half_edge(h, random.uniform(k))), 1,
                    1e-13)
            << cut.name;
  }
}

/// Every basis function has one value, to rounding: on a seam the weight λ of its values is 1.
TEST(TexelSpace, HasOneValueOnBothSidesOfASeam) {
  const Random random(8);
  int tested = 0;
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const std::vector<HalfEdge> seams = fixtures::seams_of(*cut.model);
    EXPECT_EQ(seams.empty(), cut.model->atlas.charts.size() == 1) << cut.name;
    for (HalfEdge h : seams) {
      std::vector<double> places = {0.0, 1e-9, 0.5, 1.0};
      for (int k = 0; k < 6; ++k) places.push_back(random.uniform(6 * h + k));
      for (double s : places) {
        std::map<int, double> difference;
        for (const BasisWeight& w : space.basis_at(h / 3, fixtures::on_half_edge(h, s)))
          difference[w.unknown] += w.weight;
        const HalfEdge twin = cut.model->surface.twins[h];
        for (const BasisWeight& w : space.basis_at(twin / 3, fixtures::on_half_edge(twin, 1 - s)))
          difference[w.unknown] -= w.weight;
        for (const auto& [texel, d] : difference)
          ASSERT_NEAR(d, 0, 1e-13) << cut.name << ", seam " << h << " at " << s;
        ++tested;
      }
    }
  }
  EXPECT_GT(tested, 10000);
}

/// The four weights around a point, by its texel coordinates in extended precision.
TEST(TexelSpace, IsBilinearAwayFromSeams) {
  const Random random(9);
  for (const CutOptions& options : {turned(fixtures::odd_angle), fixtures::slanted()}) {
    const Cut cut = fixtures::cut("", options, {96, 160});
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    std::map<std::array<int, 2>, int> unknown;
    for (int i = 0; i < space.size(); ++i)
      unknown[{space.texels().places[i].x, space.texels().places[i].y}] = i;
    int tested = 0;
    for (std::uint64_t k = 0; k < 20000; ++k) {
      const int t = int(k % cut.model->surface.triangle_count());
      const Vector3 l = fixtures::random_point(random, k);
      const fixtures::RealPolygon corner = fixtures::corners_of(cut.model->atlas, t);
      fixtures::Real x = 0, y = 0;
      for (int c = 0; c < 3; ++c) x += l[c] * corner[c][0], y += l[c] * corner[c][1];
      const int i = int(std::floor(x)), j = int(std::floor(y));
      std::map<int, double> expected;
      bool inside = true;
      for (int c = 0; c < 4; ++c) {
        const std::array<int, 2> at{i + (c & 1), j + (c >> 1)};
        inside = inside && unknown.count(at) && space.texels().interior[unknown[at]];
        expected[unknown[at]] = double((1 - std::abs(x - at[0])) * (1 - std::abs(y - at[1])));
      }
      if (!inside) continue;
      ++tested;
      std::map<int, double> found;
      for (const BasisWeight& w : space.basis_at(t, l)) found[w.unknown] = w.weight;
      ASSERT_EQ(found.size(), 4);
      for (const auto& [texel, weight] : expected) ASSERT_NEAR(found[texel], weight, 1e-14);
    }
    EXPECT_GT(tested, 10000);
  }
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
      EXPECT_NEAR(it.value() / h2, weight[far], 1e-14);
    }
    for (SparseMatrix::InnerIterator it(S, i); it; ++it)
      EXPECT_NEAR(it.value(), it.col() == i ? 8.0 / 3 : -1.0 / 3, 1e-14);
  }
  EXPECT_GT(tested, 1000);
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
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    Signal psi(space.size(), 2);
    const Random random(4);
    for (int i = 0; i < space.size(); ++i)
      psi(i, 0) = random.uniform(2 * i, 0, 1), psi(i, 1) = random.uniform(2 * i + 1, 0, 1);
    const Signal expected = space.stiffness() * psi;
    EXPECT_LT((space.stiffness_times(psi) - expected).norm(), 1e-12 * expected.norm()) << cut.name;
    const std::vector<double> twice(space.size(), 2.0);
    EXPECT_LT((space.stiffness_times(psi, twice) - 2 * expected).norm(), 1e-12 * expected.norm())
        << cut.name;
    EXPECT_EQ(space.stiffness_times(Signal::Constant(space.size(), 1, 0.1)).cwiseAbs().maxCoeff(),
              0)
        << cut.name;
  }
}

TEST(TexelSpace, ModulatedStiffnessIsThatOfItsCells) {
  const Cut cut = fixtures::cut("", turned(fixtures::odd_angle), {48, 48});
  const auto& model = cut.model;
  const TexelSpace space(model->surface, model->atlas);
  std::vector<double> beta(space.size());
  for (int i = 0; i < space.size(); ++i) beta[i] = space.texels().chart[i] == 1 ? 1.0 : 0.0;
  const Signal phi = sample(cut, space, [](const Vector2& p) { return p.x(); });
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
  int tested = 0;
  for (const Cut& cut : cut_squares()) {
    if (!cut.apart) continue;
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const Signal x = sample(cut, space, [](const Vector2& p) { return p.x(); });
    const std::vector<Vector3> field(cut.model->surface.triangle_count(), Vector3(1, 0, 0.7));
    const Signal b = space.divergence({field});
    EXPECT_LT((b - space.stiffness_times(x)).cwiseAbs().maxCoeff(), 1e-11) << cut.name;
    EXPECT_NEAR(b.sum(), 0, 1e-12) << cut.name;
    ++tested;
  }
  EXPECT_EQ(tested, 10);
}

TEST(TexelSpace, DivergenceOfDifferencesIsStiffnessTimesThePotential) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const auto edges = space.edges();
    const Random random(14);
    Signal psi(space.size(), 1), z(Eigen::Index(edges.size()), 1);
    for (int i = 0; i < space.size(); ++i) psi(i, 0) = random.uniform(i, 0, 1);
    for (std::size_t e = 0; e < edges.size(); ++e)
      z(e, 0) = psi(edges[e][1], 0) - psi(edges[e][0], 0);
    const Signal expected = space.stiffness_times(psi);
    EXPECT_LT((space.edge_divergence(edges, z) - expected).norm(), 1e-12 * expected.norm())
        << cut.name;
  }
}

TEST(TexelSpace, SoftSeamsApproachContinuityAsThePenaltyGrows) {
  const Cut cut = fixtures::cut("", turned(fixtures::odd_angle), {48, 48});
  const auto& model = cut.model;
  TexelSpaceOptions options;
  options.seams = TexelSpaceOptions::Seams::soft;
  options.seam_penalty = 10;
  const TexelSpace space(model->surface, model->atlas, options);
  EXPECT_NEAR(column(space.mass()).sum(), 1.0, 1e-13);
  EXPECT_LT(column(space.stiffness()).cwiseAbs().maxCoeff(), 1e-11);
  // A linear function agrees on both sides: no penalty.
  const Signal phi = sample(cut, space, [](const Vector2& p) { return p.x() - p.y(); });
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
        const Signal psi = Signal::Constant(space.size(), 1, 0.25);
        const Signal phi = DirectSolver(space.system(1, 1e-3)).solve(space.mass() * psi);
        EXPECT_LT((phi.array() - 0.25).abs().maxCoeff(), 1e-9);
      }
}

TEST(TexelSpace, CouplesOnlyWhatMeetsOnLongThinTextures) {
  // Seams that run down the texture on one side run along it on the other, over hundreds of cells.
  const auto model =
      fixtures::textured(fixtures::cut_square(turned(fixtures::quarter_turn)), {{900, 3}});
  const TexelSpace space(model->surface, model->atlas);
  SparseMatrix integrated(space.size(), space.size());
  std::vector<Eigen::Triplet<double>> entries;
  space.for_each_piece([&](const TexelSamples& samples) {
    const double density = texel_metric(model->surface, model->atlas, samples.triangle).density;
    const Signal block =
        samples.values.transpose() * (density * samples.weights).asDiagonal() * samples.values;
    for (std::size_t i = 0; i < samples.texels.size(); ++i)
      for (std::size_t j = 0; j < samples.texels.size(); ++j)
        if (block(i, j) != 0)
          entries.emplace_back(samples.texels[i], samples.texels[j], block(i, j));
  });
  integrated.setFromTriplets(entries.begin(), entries.end());
  EXPECT_LT((space.mass() - integrated).norm(), 1e-12 * integrated.norm());

  const auto longer =
      fixtures::textured(fixtures::cut_square(turned(fixtures::quarter_turn)), {{8000, 3}});
  const TexelSpace large(longer->surface, longer->atlas);
  EXPECT_LT(large.mass().nonZeros(), 40 * std::int64_t(large.size()));
  EXPECT_NEAR(column(large.mass()).sum(), 1.0, 1e-11);
}

TEST(TexelSpace, IsSolvableWhereTipsOfChartsMakeTexelsDependent) {
  for (const Cut& cut : small_cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const double w = 1e-2;
    const SparseMatrix A = space.regularised_system(1, w), plain = space.system(1, w);
    EXPECT_EQ(A.nonZeros(), plain.nonZeros());
    EXPECT_LT((A - SparseMatrix(A.transpose())).norm(), 1e-13 * A.norm()) << cut.name;
    EXPECT_LT((column(A) - column(plain)).cwiseAbs().maxCoeff(), 1e-13) << cut.name;
    const auto [largest, condition] = scaled_spectrum(A);
    EXPECT_LT(condition, 1e5) << cut.name << ", without: " << scaled_spectrum(plain).second;
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

TEST(TexelSpace, CountsTilesOnceThatOnlyOneSideGoesOver) {
  for (const Vector2& tiles : {Vector2(3.4, 0.6), Vector2(0.6, 3.4)}) {
    const auto tiled = [&](int cells) {
      Mesh mesh = fixtures::flat_square(cells);
      for (Vector2& uv : mesh.uvs) uv = uv.cwiseProduct(tiles) + Vector2(0.13, 0.21);
      return fixtures::textured(mesh, {{48, 40, Wrap::repeat}});
    };
    const auto large = tiled(1), small = tiled(8);
    const TexelSpace counted(large->surface, large->atlas), cut(small->surface, small->atlas);
    ASSERT_EQ(cut.size(), counted.size());
    EXPECT_NEAR(column(counted.mass()).sum(), 1, 1e-11);
    EXPECT_LT((counted.stiffness() - cut.stiffness()).norm(), 1e-11 * cut.stiffness().norm());
  }
}

TEST(TexelSpace, RefusesAnAtlasWithRefusedDefects) {
  Mesh mesh = fixtures::flat_square(4);
  mesh.uvs[12] += Vector2(0.6, 0);  // an inner vertex over its neighbours
  const auto model = fixtures::textured(mesh, {{16, 16}});
  try {
    TexelSpace space(model->surface, model->atlas);
    FAIL() << "nothing was thrown";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("flipped"), std::string::npos) << error.what();
  }
}

/// A mesh and a copy of it one unit above with the same texture coordinates; of every other chart
/// the copy comes first.
Mesh with_copy_above(const Mesh& mesh) {
  const auto model = fixtures::textured(mesh, {{64, 64}});
  Mesh both = mesh;
  both.triangles.clear();
  both.corner_uvs.clear();
  both.textures.clear();
  for (const Vector3& p : mesh.positions) both.positions.push_back(p + Vector3(0, 0, 1));
  for (int c = 0; c < int(model->atlas.charts.size()); ++c)
    for (const bool above : {c % 2 == 1, c % 2 == 0})
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (model->atlas.chart[t] != c) continue;
        Triangle corners = mesh.triangles[t];
        if (above)
          for (int& v : corners) v += mesh.vertex_count();
        both.triangles.push_back(corners);
        both.corner_uvs.push_back(mesh.corner_uvs[t]);
      }
  return both;
}

TEST(TexelSpace, PlacesTexelsThatCopiesShareOnOneOfThem) {
  const auto model =
      fixtures::textured(with_copy_above(fixtures::cut_square({.parts = 3})), {{90, 90}});
  ASSERT_EQ(model->atlas.charts.size(), 18);
  const TexelSpace space(model->surface, model->atlas);
  for (const auto& position : space.texels().positions) EXPECT_NEAR(position[2], 0, 1e-6);
}

}  // namespace
}  // namespace mq
