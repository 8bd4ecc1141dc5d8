// A wall whose texture comes in tiles.
#include <gtest/gtest.h>

#include "mq/base/error.h"
#include "mq/sample/wall.h"

namespace mq {
namespace {

TEST(Wall, HasAChartForEachTileAndSeamsBetweenAll) {
  const Wall wall = make_wall({.tiles = 2, .texture_size = 32, .squares = 2});
  const Surface surface = make_surface(wall.mesh);
  EXPECT_EQ(surface.components, 1);
  const Atlas atlas = make_atlas(surface, wall.textures);
  EXPECT_EQ(wall.tiles.size(), 4u);
  EXPECT_EQ(atlas.charts.size(), 4u);
  EXPECT_EQ(atlas.seam_count, 8);  // two borders of four squares
  for (const Chart& chart : atlas.charts) {
    EXPECT_FALSE(chart.mirrored);
    EXPECT_NEAR(chart.texel_area, 24 * 24, 1e-6);  // within the gutter
  }
}

TEST(Wall, RefusesWhatNamesOfTilesCannotCount) {
  EXPECT_THROW(make_wall({.tiles = 11}), InvalidInput);
  EXPECT_THROW(make_wall({.tiles = 0}), InvalidInput);
  EXPECT_THROW(make_wall({.texture_size = 8}), InvalidInput);
}

}  // namespace
}  // namespace mq
