// Fields with a vector per texel: exact on flat surfaces however these are cut, of second order on curved ones.

#include "mq/fem/texel_vector_space.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <numbers>

#include "fem/cut_squares.h"
#include "mq/linear/eigen.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

/// z of a field in space, seen at the texels.
template <class Field>
Vector coefficients(const TexelVectorSpace& vectors, const Field& field) {
  Vector z(2 * std::int64_t(vectors.size()));
  for (int i = 0; i < vectors.size(); ++i) {
    const TangentPlane plane = vectors.plane(i);
    const Vector3 X = field(i);
    z[2 * i] = plane.first.dot(X);
    z[2 * i + 1] = plane.second.dot(X);
  }
  return z;
}

struct Vectors {
  explicit Vectors(std::unique_ptr<fixtures::Textured> textured)
      : model(std::move(textured)), space(model->surface, model->atlas), vectors(model->surface, model->atlas, space) {}

  SparseMatrix matrix(double a, double b) const { return scalar_matrix(vectors.system(a, b)); }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TexelVectorSpace vectors;
};

Vectors sphere(int side) {
  const auto options = fixtures::turned(fixtures::odd_angle);
  return Vectors(fixtures::textured(fixtures::cut_sphere(40, options), {{3 * side, 2 * side}}));
}

TEST(TexelVectorSpace, PlanesTurnIntoEachOtherByTheLeastRotation) {
  const TangentPlane here(Vector3(0.2, -0.4, 0.9)), there(Vector3(-0.5, 0.3, 0.4));
  EXPECT_NEAR(std::abs(here.turn(there)), 1, 1e-15);
  EXPECT_NEAR(std::abs(here.turn(there) * there.turn(here) - 1.0), 0, 1e-15);
  EXPECT_NEAR(std::abs(here.turn(here) - 1.0), 0, 1e-15);
  // What is orthogonal to both normals stays.
  const Vector3 axis = here.normal.cross(there.normal).normalized();
  const std::complex<double> before(here.first.dot(axis), here.second.dot(axis)), after = here.turn(there) * before;
  EXPECT_LT((there.in_space(after.real(), after.imag()) - axis).norm(), 1e-14);
}

TEST(TexelVectorSpace, ConstantFieldsOfAFlatSurfaceDoNotChangeHoweverItIsCut) {
  const Vector3 constant(0.8, -0.6, 0);
  for (fixtures::Cut& cut : fixtures::cut_squares()) {
    const Vectors flat(std::move(cut.model));
    const Vector z = coefficients(flat.vectors, [&](int) { return constant; });
    const SparseMatrix L = flat.matrix(0, 1), M = flat.matrix(1, 0);
    EXPECT_LT(std::abs(z.dot(L * z)), 1e-12 * L.diagonal().sum()) << cut.name;
    EXPECT_LT((L * z).norm(), 1e-11 * L.norm()) << cut.name;
    EXPECT_NEAR(z.dot(M * z), 1, 1e-11) << cut.name;
    const Random random(5);
    for (int k = 0; k < 200; ++k) {
      const int triangle = int(random.uniform(1000 + std::uint64_t(k)) * flat.model->surface.triangle_count());
      const Vector3 found = flat.vectors.value(z, triangle, fixtures::random_point(random, std::uint64_t(k)));
      EXPECT_LT((found - constant).norm(), 1e-12) << cut.name;
    }
  }
}

TEST(TexelVectorSpace, AFieldThatGrowsFromAPointHasTheEnergyOfItsSlope) {
  for (const fixtures::CutOptions& options : {fixtures::turned(fixtures::odd_angle), fixtures::slanted()}) {
    const TextureSize size{96, 96};
    const Vectors flat(fixtures::textured(fixtures::cut_square(options), {size}));
    const std::vector<Vector2> points = fixtures::texels_on_square(options, size, flat.space.texels());
    const Vector z = coefficients(flat.vectors, [&](int i) {
      const Vector2& p = points[std::size_t(i)];
      return Vector3(p.x() - 0.3 * p.y(), 0.3 * p.x() + p.y(), 0);
    });
    EXPECT_NEAR(z.dot(flat.matrix(0, 1) * z), 2 * (1 + 0.3 * 0.3), 1e-9);
    EXPECT_NEAR(z.dot(flat.matrix(1, 0) * z), (1 + 0.3 * 0.3) * 2.0 / 3, 1e-9);
    EXPECT_NEAR(flat.vectors.smoothness_energy(z), 2 * (1 + 0.3 * 0.3), 1e-9);
    int measured = 0;
    for (const float norm : flat.vectors.gradient_norms(z))
      if (norm != 0) {
        EXPECT_NEAR(norm, std::sqrt(2 * (1 + 0.3 * 0.3)), 2e-3);
        ++measured;
      }
    EXPECT_GT(measured, flat.vectors.size() / 2);
  }
}

TEST(TexelVectorSpace, MatricesAreSymmetricAndSemidefinite) {
  const Vectors sphere = mq::sphere(12);
  const SparseMatrix L = sphere.matrix(0, 1), M = sphere.matrix(1, 0);
  EXPECT_LT(SparseMatrix(L - SparseMatrix(L.transpose())).norm(), 1e-13 * L.norm());
  EXPECT_LT(SparseMatrix(M - SparseMatrix(M.transpose())).norm(), 1e-13 * M.norm());
  const Vector values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(L), Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_GT(values[0], 0);  // a sphere has no parallel field
  std::vector<float> half(std::size_t(sphere.space.element_count()), 0.5F);
  EXPECT_LT(SparseMatrix(scalar_matrix(sphere.vectors.system(0, 1, half)) - 0.5 * L).norm(), 1e-7 * L.norm());
}

TEST(TexelVectorSpace, HasTheSpectrumOfAFlatTorus) {
  Mesh mesh = fixtures::flat_square(7);
  for (Vector2& uv : mesh.uvs) uv += Vector2(0.31, 0.17);  // over the border of a texture that repeats
  const Vectors torus(fixtures::textured(mesh, {{64, 64, Wrap::repeat}}));
  ASSERT_EQ(torus.vectors.size(), 64 * 64);
  const Vector values = smallest_eigenpairs(torus.matrix(0, 1), torus.matrix(1, 0), {.count = 20}).values;
  const double unit = std::pow(2 * std::numbers::pi, 2);
  for (int k = 0; k < 20; ++k) {
    const double exact = k < 2 ? 0 : k < 10 ? 1 : k < 18 ? 2 : 4;
    EXPECT_NEAR(values[k] / unit, exact, exact > 0 ? 0.01 * exact : 1e-9) << k;
  }
}

TEST(TexelVectorSpace, HasTheSpectrumOfASphereToSecondOrder) {
  const auto errors = [](int side) {
    const Vectors round = sphere(side);
    const Vector values = smallest_eigenpairs(round.matrix(0, 1), round.matrix(1, 0), {.count = 16}).values;
    double most = 0;
    for (int k = 0; k < 16; ++k) most = std::max(most, std::abs(values[k] / (k < 6 ? 1 : 5) - 1));  // l(l + 1) − 1
    return most;
  };
  const double coarse = errors(16), fine = errors(32);
  EXPECT_LT(fine, 0.01);
  EXPECT_GT(std::log2(coarse / fine), 1.8);
}

TEST(TexelVectorSpace, GradientsOfLinearFunctionsAreExact) {
  const fixtures::CutOptions options = fixtures::turned(fixtures::odd_angle);
  fixtures::Cut cut = fixtures::cut("", options, {64, 64});
  const Vector3 slope(0.7, -0.2, 0);
  TexelSpace own(cut.model->surface, cut.model->atlas);
  const Signal psi = fixtures::sample(cut, own, [&](const Vector2& p) { return slope.x() * p.x() + slope.y() * p.y(); });
  const Vectors flat(std::move(cut.model));
  const Signal gradient = flat.vectors.gradient(psi);
  EXPECT_LT((gradient.col(0) - coefficients(flat.vectors, [&](int) { return slope; })).cwiseAbs().maxCoeff(), 1e-10);
  for (const Vector3& X : flat.vectors.on_triangles(gradient.col(0))) EXPECT_LT((X - slope).norm(), 1e-10);
}

TEST(TexelVectorSpace, PathsAlongAConstantFieldAreStraight) {
  const fixtures::CutOptions options = fixtures::turned(fixtures::odd_angle, 3);
  const Vectors flat(fixtures::textured(fixtures::cut_square(options), {{96, 96}}));
  const Vector3 way(0.12, 0.07, 0);
  const Vector z = coefficients(flat.vectors, [&](int) { return way; });
  const TraceAtlas domain(flat.model->surface, flat.model->atlas, flat.space);
  const std::vector<ChartPlace> starts = domain.starts().places;
  const TracedTexels traced = AtlasFlow::along(domain, flat.vectors.velocities(z)).trace(starts, 1);
  int compared = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Vector3 from = domain.position(starts[i]), to = domain.position(traced.ends[i]), end = from + way;
    if (from.x() < 0 || from.y() < 0 || end.x() > 1 || end.y() > 1) continue;
    EXPECT_LT((to - end).norm(), 1e-6);  // positions have single precision
    ++compared;
  }
  EXPECT_GT(compared, std::ssize(starts) / 2);
}

TEST(TexelVectorSpace, CyclesOfItsTransfersSolveInAFewSteps) {
  const Vectors round = sphere(64);
  const double spacing = round.space.scale().texel_spacing, weight = 400 * spacing * spacing;
  BlockMultigrid multigrid(round.vectors.transfers(1, weight), {.tolerance = 1e-8});
  const BlockMatrix<double> A = round.vectors.regularised_system(1, weight);
  const SparseMatrix scalar = scalar_matrix(A);
  multigrid.set_matrix(A);
  const Random random(3);
  Vector truth(scalar.rows()), z = Vector::Zero(scalar.rows());
  for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] = random.uniform(std::uint64_t(i), -1, 1);
  const SolveReport report = multigrid.solve(scalar * truth, z);
  EXPECT_LT((z - truth).norm(), 1e-5 * truth.norm());
  EXPECT_LT(std::pow(report.residuals.back(), 1.0 / report.cycles), 0.15) << report.cycles;
}

}  // namespace
}  // namespace mq
