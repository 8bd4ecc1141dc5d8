// Divergence, curl and Hodge energy of fields with a vector per texel.

#include "mq/fem/texel_vector_calculus.h"

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/linear/eigen.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

struct TexelFields {
  explicit TexelFields(const Mesh& mesh, const TextureSize& size)
      : model(fixtures::textured(mesh, {size})), space(model->surface, model->atlas), vectors(model->surface, model->atlas, space) {}

  Vector divergence(const Vector& z) const { return divergence_moments(vectors, z); }
  Vector curl(const Vector& z) const { return curl_moments(vectors, z); }
  SparseMatrix hodge() const { return scalar_matrix(hodge_laplacian(vectors)); }
  SparseMatrix matrix(double a, double b) const { return scalar_matrix(vectors.system(a, b)); }
  /// visit(texel, bound) of those away from the boundary: next to seams, where functions are no polynomials, the rule
  /// is off by a hundredth or so of ∫ |∇φ|.
  template <class Visit>
  void for_each_inner(const Visit& visit) const {
    const std::vector<int> boundary = space.boundary();
    for (int i = 0; i < space.size(); ++i)
      if (!std::ranges::binary_search(boundary, i))
        visit(i, space.texels().interior[std::size_t(i)] ? 1e-10 : 0.02 * space.scale().texel_spacing);
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TexelVectorSpace vectors;
};

Vector seen(const TexelVectorSpace& vectors, int i, const Vector3& X) {
  const TangentPlane plane = vectors.plane(i);
  return Vector2(plane.first.dot(X), plane.second.dot(X));
}

TEST(TexelVectorCalculus, LinearFieldsHaveTheirDivergenceAndCurlOverSeams) {
  for (const fixtures::CutOptions& options : {fixtures::turned(fixtures::odd_angle), fixtures::slanted()}) {
    const TextureSize size{64, 64};
    const TexelFields flat(fixtures::cut_square(options), size);
    const std::vector<Vector2> points = fixtures::texels_on_square(options, size, flat.space.texels());
    Vector out(2 * std::int64_t(flat.space.size())), round = out;
    for (int i = 0; i < flat.space.size(); ++i) {
      const Vector2& p = points[std::size_t(i)];
      out.segment<2>(2 * i) = seen(flat.vectors, i, {p.x(), p.y(), 0});
      round.segment<2>(2 * i) = seen(flat.vectors, i, {-p.y(), p.x(), 0});
    }
    const Vector mass = flat.space.lumped_mass();
    const Vector divergence = flat.divergence(out), curl = flat.curl(round), none = flat.curl(out), no = flat.divergence(round);
    EXPECT_NEAR(divergence.sum(), 0, 1e-10);
    flat.for_each_inner([&](int i, double bound) {
      EXPECT_NEAR(divergence[i], -2 * mass[i], bound);
      EXPECT_NEAR(curl[i], -2 * mass[i], bound);
      EXPECT_NEAR(none[i], 0, bound);
      EXPECT_NEAR(no[i], 0, bound);
    });
    // ∫ div² + curl² = 4 of each, ∫ |∇X|² = 2.
    EXPECT_NEAR(out.dot(flat.hodge() * out), 4, 1e-9);
    EXPECT_NEAR(round.dot(flat.hodge() * round), 4, 1e-9);
  }
}

TEST(TexelVectorCalculus, TheDivergenceOfAGradientIsTheStiffness) {
  const fixtures::CutOptions options = fixtures::turned(fixtures::odd_angle);
  fixtures::Cut cut = fixtures::cut("", options, {64, 64});
  const TexelFields flat(fixtures::cut_square(options), {64, 64});
  const Signal psi = fixtures::sample(cut, flat.space, [](const Vector2& p) { return 0.3 * p.x() - 1.1 * p.y(); });
  const Vector gradient = flat.vectors.gradient(psi).col(0);
  EXPECT_LT((flat.divergence(gradient) - flat.space.stiffness_times(psi).col(0)).cwiseAbs().maxCoeff(), 1e-10);
  const Vector curl = flat.curl(gradient);
  flat.for_each_inner([&](int i, double bound) { EXPECT_NEAR(curl[i], 0, bound); });
}

TEST(TexelVectorCalculus, WithoutCurvatureAndBoundaryHodgeIsTheConnectionLaplacian) {
  Mesh mesh = fixtures::flat_square(5);
  for (Vector2& uv : mesh.uvs) uv += Vector2(0.31, 0.17);
  const TexelFields torus(mesh, {24, 24, Wrap::repeat});
  const SparseMatrix L = torus.matrix(0, 1);
  EXPECT_LT(SparseMatrix(torus.hodge() - L).norm(), 1e-10 * L.norm());
}

TEST(TexelVectorCalculus, ATorusComesToHaveTwoHarmonicFieldsAndAGap) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const auto gap = [&](int side) {
    const TexelFields torus(
        fixtures::cut_torus({.cells = side / 2, .jitter = 0, .scale = cut.scale, .angle = cut.angle, .shift = cut.shift}),
        {side, side});
    const SparseMatrix H = torus.hodge();
    EXPECT_LT(SparseMatrix(H - SparseMatrix(H.transpose())).norm(), 1e-12 * H.norm());
    const Vector values = smallest_eigenpairs(H, torus.matrix(1, 0), {.count = 4}).values;
    EXPECT_GT(values[0], 0);
    return values[1] / values[2];
  };
  const double coarse = gap(40), fine = gap(80);
  EXPECT_LT(fine, 0.01);
  EXPECT_GT(coarse / fine, 2.8) << coarse;
}

TexelFields of_sample(const char* name, int side, int triangles) {
  const Sample sample = make_sample(name, {.texture_size = side, .triangles = triangles});
  return TexelFields(sample.mesh, sample.texture);
}

TEST(TexelVectorCalculus, AButtonOfGenusFourComesToHaveEightHarmonicFieldsAndAGap) {
  const auto gap = [](int side) {
    const TexelFields button = of_sample("genus4", side, 50000);
    const Vector values = smallest_eigenpairs(button.hodge(), button.matrix(1, 0), {.count = 9}).values;
    EXPECT_GT(values[0], 0);
    return values[7] / values[8];
  };
  const double coarse = gap(96), fine = gap(192);
  EXPECT_LT(fine, 0.04);
  EXPECT_GT(coarse / fine, 2.8) << coarse;
}

/// On triangles finer than texels: curvature would gather at their vertices else. Eigenvalues are of the connection
/// Laplacian.
TEST(TexelVectorCalculus, HowASurfaceIsCutMattersToSecondOrder) {
  const auto difference = [](int side) {
    const auto values = [&](const char* name) {
      const TexelFields fields = of_sample(name, side, 30000);
      return smallest_eigenpairs(fields.matrix(0, 1), fields.matrix(1, 0), {.count = 8}).values;
    };
    const Vector whole = values("cap"), cut = values("cap_28");
    return (whole - cut).cwiseAbs().maxCoeff() / whole[7];
  };
  const double coarse = difference(64), fine = difference(128);
  EXPECT_LT(fine, 0.012);
  EXPECT_GT(std::log2(coarse / fine), 1.8) << coarse;
}

TEST(TexelVectorCalculus, FieldsOfASphereAreGradientsAndTurnedGradients) {
  const TexelFields sphere(fixtures::cut_sphere(24, fixtures::turned(fixtures::odd_angle)), {3 * 24, 2 * 24});
  const Vector values = smallest_eigenpairs(sphere.hodge(), sphere.matrix(1, 0), {.count = 16}).values;
  for (int k = 0; k < 16; ++k) EXPECT_NEAR(values[k], k < 6 ? 2 : 6, k < 6 ? 0.03 : 0.15) << k;  // l(l + 1)
}

}  // namespace
}  // namespace mq
