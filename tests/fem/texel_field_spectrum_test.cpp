// Eigenfields with a vector per texel: on the sphere as they are known, elsewhere as another basis has them.
#include "mq/fem/texel_field_spectrum.h"

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

/// A mesh and its texels.
struct Dotted {
  Dotted(const Mesh& mesh, const TextureSize& size)
      : model(fixtures::textured(mesh, {size})),
        space(model->surface, model->atlas),
        vectors(model->surface, model->atlas, space) {}

  double product(const TangentField& X, const TangentField& Y) const {
    double sum = 0;
    for (int t = 0; t < model->surface.triangle_count(); ++t)
      sum += triangle_area(model->surface.mesh, t) * X[std::size_t(t)].dot(Y[std::size_t(t)]);
    return sum;
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TexelVectorSpace vectors;
};

/// On the unit sphere l(l+1) − 1: six times 1, rotations and gradients of x, y, z, then ten times 5.
TEST(TexelFieldSpectrum, OfTheSphereIsKnownAndOfSecondOrder) {
  std::vector<double> errors;
  for (const int side : {1, 2}) {
    const Dotted sphere(fixtures::cut_sphere(40, fixtures::turned(fixtures::odd_angle)), {90 * side, 60 * side});
    const FieldSpectrum found = texel_field_spectrum(sphere.vectors, 16);
    ASSERT_EQ(found.values.size(), 16);
    EXPECT_EQ(found.unknowns, 2 * sphere.space.size());
    errors.push_back(0);
    for (int k = 0; k < 16; ++k)
      errors.back() = std::max(errors.back(), std::abs(found.values[k] / (k < 6 ? 1 : 5) - 1));
    // The first six are spanned by those six, of which the squares of products sum to 1.
    for (int k = 0; k < 6; ++k) {
      double inside = 0;
      for (int n = 0; n < 6; ++n) {
        TangentField truth(found.fields[0].size());
        for (int t = 0; t < sphere.model->surface.triangle_count(); ++t) {
          const Vector3 axis = Vector3::Unit(n % 3), at = triangle_normal(sphere.model->surface.mesh, t);
          truth[std::size_t(t)] = n < 3 ? Vector3(axis - axis.dot(at) * at) : Vector3(axis.cross(at));
        }
        const double part = sphere.product(found.fields[std::size_t(k)], truth);
        inside += part * part / sphere.product(truth, truth);
      }
      EXPECT_NEAR(sphere.product(found.fields[std::size_t(k)], found.fields[std::size_t(k)]), 1, 1e-9);
      EXPECT_NEAR(inside, 1, 0.01);
    }
  }
  EXPECT_LT(errors[1], 0.01);
  EXPECT_GT(errors[0] / errors[1], 3.2);
}

TEST(TexelFieldSpectrum, AgreesWithThatAtVertices) {
  const Mesh mesh = make_sample("torus", {.texture_size = 160, .triangles = 8000}).mesh;
  const Dotted torus(mesh, {160, 160});
  const FieldSpectrum texels = texel_field_spectrum(torus.vectors, 8),
                      vertices = field_spectrum(torus.model->surface, {.basis = FieldBasis::vertex, .count = 8});
  for (int k = 0; k < 8; ++k) EXPECT_NEAR(texels.values[k] / vertices.values[k], 1, 0.02) << k;
}

TEST(TexelFieldSpectrum, RefusesMoreThanThereAre) {
  const Dotted square(fixtures::cut_square(fixtures::turned(fixtures::odd_angle, 1)), {4, 4});
  EXPECT_THROW(texel_field_spectrum(square.vectors, 2 * square.space.size() + 1), InvalidInput);
  EXPECT_THROW(texel_field_spectrum(square.vectors, 0), InvalidInput);
}

}  // namespace
}  // namespace mq
