// Where two versions of textures differ most on a surface.
#include "mq/draw/texture_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "draw/drawn_model.h"

namespace mq {
namespace {

using namespace fixtures;
using ::testing::HasSubstr;

Image<float> with_spot(Image<float> image, int x, int y, int side, float value) {
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) image(x + i, y + j) = value;
  return image;
}

TEST(TextureDifference, HasNoPlaceWhereNothingDiffers) {
  const Model model(flat_square(2), noise(32, 32, 3));
  const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&model.texture});
  EXPECT_EQ(d.rms, 0);
  EXPECT_TRUE(d.places.empty());
  EXPECT_GE(d.looked, 32 * 32);
}

TEST(TextureDifference, IsTheStepWhereAllDiffersByOne) {
  const Model model(flat_square(4), Image<float>(64, 64, 3, 0.5F));
  const Image<float> after(64, 64, 3, 0.75F);
  const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&after});
  EXPECT_NEAR(d.rms, 0.25, 1e-6);
  ASSERT_FALSE(d.places.empty());
  EXPECT_NEAR(d.places[0].difference, 0.25, 1e-6);
  EXPECT_EQ(d.places[0].normal, Vector3(0, 0, 1));
}

/// A spot of 0.5 comes before a texel of 1.
TEST(TextureDifference, FindsWhatAPersonSeesAndThenTheNext) {
  const Model model(flat_square(2), Image<float>(256, 256, 1));
  const Image<float> after = with_spot(with_spot(model.texture, 200, 60, 8, 0.5F), 40, 200, 1, 1);
  const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&after});
  ASSERT_EQ(d.places.size(), 2U);
  EXPECT_NEAR(d.places[0].column, 203.5, 4);
  EXPECT_NEAR(d.places[0].row, 63.5, 4);
  EXPECT_NEAR(d.places[0].point.x(), 0.797, 0.02);
  EXPECT_NEAR(d.places[0].point.y(), 0.752, 0.02);
  EXPECT_EQ(d.places[0].texture, 0);
  EXPECT_EQ(d.places[1].column, 40);
  EXPECT_EQ(d.places[1].row, 200);
  EXPECT_GT(d.places[0].difference, d.places[1].difference);
  EXPECT_LT(d.places[1].difference, 0.2);
}

TEST(TextureDifference, HasPlacesThatAreApart) {
  const Model model(flat_square(2), Image<float>(256, 256, 1));
  const Image<float> after(256, 256, 1, 0.1F);
  const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&after}, {.apart = 50});
  EXPECT_GT(d.places.size(), 9U);
  EXPECT_LT(d.places.size(), 60U);
  for (std::size_t i = 0; i < d.places.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_GT((d.places[i].point - d.places[k].point).norm(), 50 * model.atlas.texel_spacing());
  const TextureDifference three =
      texture_difference(model.surface, model.atlas, {&model.texture}, {&after}, {.apart = 50, .most = 3});
  ASSERT_EQ(three.places.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(three.places[i].point, d.places[i].point);
}

/// Half of a spot on each side of the diagonal is as much as the whole of one, of which a side of 0.4 is a chart.
TEST(TextureDifference, SeesOverSeams) {
  const auto across = [](const Mesh& mesh) {
    const Model model(mesh, Image<float>(200, 200, 1));
    Image<float> after = model.texture;
    const Surface& surface = model.surface;
    for (int t = 0; t < 2; ++t)
      for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x) {
          // The texel's place on the surface.
          const auto& c = model.atlas.corners[std::size_t(t)];
          Eigen::Matrix2d edges;
          edges << c[1].column() - c[0].column(), c[2].column() - c[0].column(), c[1].row() - c[0].row(),
              c[2].row() - c[0].row();
          const Vector2 weights = edges.inverse() * Vector2(x - c[0].column(), y - c[0].row());
          if (weights.minCoeff() < 0 || weights.sum() > 1) continue;
          const Vector3 at = surface.mesh.position(t, 0) +
                             weights[0] * (surface.mesh.position(t, 1) - surface.mesh.position(t, 0)) +
                             weights[1] * (surface.mesh.position(t, 2) - surface.mesh.position(t, 0));
          if ((at - Vector3(0.5, 0.5, 0)).norm() < 0.1) after(x, y) = 1;
        }
    return texture_difference(surface, model.atlas, {&model.texture}, {&after}).places.at(0);
  };
  Mesh one_chart = two_chart_quad();
  one_chart.uvs = {{0.05, 0.05}, {0.45, 0.05}, {0.45, 0.45}, {0.05, 0.45}};
  one_chart.corner_uvs = {{0, 1, 2}, {0, 2, 3}};
  const DifferencePlace seam = across(two_chart_quad()), whole = across(one_chart);
  EXPECT_NEAR(seam.difference, whole.difference, 0.02);
  EXPECT_LT((seam.point - Vector3(0.5, 0.5, 0)).norm(), 0.12);
}

/// Of a leaf's two sides a person sees one at a time.
TEST(TextureDifference, HasAPlaceOnEachSideOfALeaf) {
  Mesh leaf;
  for (const double z : {0.001, 0.0})
    for (const Vector2& at : {Vector2(0, 0), Vector2(1, 0), Vector2(1, 1), Vector2(0, 1)}) {
      leaf.positions.emplace_back(at.x(), at.y(), z);
      leaf.uvs.emplace_back(0.05 + 0.4 * at.x() + (z > 0 ? 0.5 : 0.0), 0.05 + 0.9 * at.y());
    }
  leaf.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
  leaf.corner_uvs = leaf.triangles;
  const Model model(leaf, Image<float>(64, 64, 1));
  const Image<float> after(64, 64, 1, 0.5F);
  const TextureDifference d =
      texture_difference(model.surface, model.atlas, {&model.texture}, {&after}, {.apart = 1000});
  ASSERT_EQ(d.places.size(), 2U);
  EXPECT_EQ(d.places[0].normal.z(), -d.places[1].normal.z());
}

/// Triangles much smaller than texels are looked at in their middle.
TEST(TextureDifference, SeesTrianglesThatCoverNoTexel) {
  const Model model(flat_square(40), Image<float>(8, 8, 1));
  const Image<float> after(8, 8, 1, 0.5F);
  const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&after});
  EXPECT_GE(d.looked, 3200);
  EXPECT_NEAR(d.rms, 0.5, 1e-6);
}

TEST(TextureDifference, IsTheSameForAnyNumberOfThreads) {
  const Model model(flat_square(40, 0.2), noise(128, 128, 3));
  const Image<float> after = noise(128, 128, 3);
  Image<float> other = after;
  for (float& value : other.values()) value = value * value;
  std::vector<DifferencePlace> first;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
    const TextureDifference d = texture_difference(model.surface, model.atlas, {&model.texture}, {&other});
    if (threads == 1) first = d.places;
    ASSERT_EQ(d.places.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(d.places[i].point, first[i].point);
      EXPECT_EQ(d.places[i].difference, first[i].difference);
    }
  }
}

TEST(TextureDifference, RefusesWhatCannotBeCompared) {
  const Model model(flat_square(2), Image<float>(16, 16, 1));
  const Image<float> small(8, 16, 1);
  EXPECT_THAT(error_of([&] { texture_difference(model.surface, model.atlas, {&model.texture}, {&small}); }),
              HasSubstr("16"));
  Image<float> broken = model.texture;
  broken(5, 6) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(error_of([&] { texture_difference(model.surface, model.atlas, {&model.texture}, {&broken}); }),
              HasSubstr("texel (column 5, row 6): only finite"));
  EXPECT_THAT(error_of([&] {
                texture_difference(model.surface, model.atlas, {&model.texture}, {&model.texture}, {.most = 0});
              }),
              HasSubstr("above 0"));
}

}  // namespace
}  // namespace mq
