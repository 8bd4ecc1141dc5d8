// Smaller and smaller textures of one atlas, whose charts come to lie closer than texels.

#include "mq/flow/texture_levels.h"

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

/// ⟨φ, S·φ⟩ / ⟨φ, M·φ⟩ of channels without their means.
Vector quotients(const TexelSpace& space, Signal signal) {
  const SparseMatrix M = space.mass();
  const Vector weights = M * Vector::Ones(signal.rows());
  signal.rowwise() -= (weights.transpose() * signal / weights.sum()).eval();
  return (signal.cwiseProduct(space.stiffness_times(signal)).colwise().sum().array() /
          signal.cwiseProduct(Signal(M * signal)).colwise().sum().array())
      .transpose();
}

/// x, y and z are eigenfunctions of the unit sphere of eigenvalue 2; places that had texels in common with others would be
/// far off.
TEST(FlowTextures, KeepPlacesApartWhoseChartsComeCloserThanTexels) {
  const auto sphere = fixtures::textured(make_sample("sphere", {.texture_size = 512}).mesh, {{512, 512}});
  const TexelSpace space(sphere->surface, sphere->atlas);
  const FlowTextures textures(sphere->surface, sphere->atlas, space, 4000);
  ASSERT_EQ(textures.count(), 4);
  for (int m = 1; m < textures.count(); ++m) {
    const Texels& texels = textures[m].space().texels();
    Signal places(texels.size(), 3);
    for (int i = 0; i < texels.size(); ++i) places.row(i) = texels.position(i).transpose();
    for (const double value : quotients(textures[m].space(), places)) EXPECT_NEAR(value, 2, 0.1) << m;
  }
}

}  // namespace
}  // namespace mq
