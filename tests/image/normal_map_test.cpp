#include "mq/image/normal_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

Image<float> picture_of(float r, float g, float b) {
  Image<float> image(1, 1, 3);
  image(0, 0, 0) = r;
  image(0, 0, 1) = g;
  image(0, 0, 2) = b;
  return image;
}

TEST(NormalMap, StoresUnitVectors) {
  const Image<float> colours = colours_from_normals(picture_of(3, 0, 4));
  EXPECT_FLOAT_EQ(colours(0, 0, 0), 0.8F);
  EXPECT_FLOAT_EQ(colours(0, 0, 1), 0.5F);
  EXPECT_FLOAT_EQ(colours(0, 0, 2), 0.9F);
  const Image<float> back = normals_from_colours(colours);
  EXPECT_NEAR(std::hypot(back(0, 0, 0), back(0, 0, 1), back(0, 0, 2)), 1, 1e-6);
}

TEST(NormalMap, TurnsNothingIntoTheUndisturbedNormal) {
  EXPECT_EQ(colours_from_normals(picture_of(0, 0, 0)), picture_of(0.5F, 0.5F, 1));
}

TEST(NormalMap, KeepsFurtherChannels) {
  Image<float> image(1, 1, 4, 0.25F);
  EXPECT_EQ(colours_from_normals(normals_from_colours(image))(0, 0, 3), 0.25F);
}

TEST(NormalMap, RefusesFewerThanThreeChannels) {
  EXPECT_THROW(normals_from_colours(Image<float>(1, 1, 2)), InvalidInput);
}

TEST(NormalMap, TellsTangentSpaceByWhereNormalsPoint) {
  Image<float> normals(2, 2, 3, 0.0F), coverage(2, 2, 1, 1.0F);
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y) normals(x, y, 2) = 0.9F;
  EXPECT_EQ(share_upright(normals, coverage), 1);
  normals(0, 1, 2) = -0.9F;
  EXPECT_EQ(share_upright(normals, coverage), 0.75);
  coverage(0, 1) = 0;
  EXPECT_EQ(share_upright(normals, coverage), 1);
}

}  // namespace
}  // namespace mq
