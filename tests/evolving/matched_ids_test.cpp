#include "mq/evolving/matched_ids.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mq {
namespace {

/// Two triangles side by side, the second from u = `u` on.
EvolvingSegment pair_from(double u) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  mesh.uvs = {{0, 0}, {0.4, 0}, {0, 0.4}, {u, 0}, {u + 0.1, 0.4}, {u, 0.4}};
  mesh.corner_uvs = {{0, 1, 2}, {3, 4, 5}};
  return segment_of(mesh);
}

TEST(MatchedIds, LiveOnWhereTextureCoordinatesDo) {
  std::vector<EvolvingSegment> segments{pair_from(0.5), pair_from(0.7)};
  match_ids(segments);
  EXPECT_EQ(segments[0].triangle_ids, (std::vector<int>{0, 1}));
  EXPECT_EQ(segments[1].triangle_ids, (std::vector<int>{0, 2}));
  EXPECT_EQ(segments[1].vertex_ids, (std::vector<int>{0, 1, 2, 4}));
}

TEST(MatchedIds, BeginTrianglesWithTheSameCorner) {
  std::vector<EvolvingSegment> segments{pair_from(0.5), pair_from(0.5)};
  for (auto* corners : {&segments[1].triangles[1], &segments[1].corner_uvs[1]})
    std::rotate(corners->begin(), corners->begin() + 1, corners->end());
  match_ids(segments);
  EXPECT_EQ(segments[1].triangle_ids, segments[0].triangle_ids);
  EXPECT_EQ(segments[1].triangles, segments[0].triangles);
  EXPECT_EQ(segments[1].corner_uvs, segments[0].corner_uvs);
}

TEST(MatchedIds, AreNotTakenFromTwoTrianglesInOnePlace) {
  std::vector<EvolvingSegment> segments{pair_from(0.5), pair_from(0.5)};
  segments[0].corner_uvs[1] = segments[0].corner_uvs[0];
  match_ids(segments);
  EXPECT_EQ(segments[1].triangle_ids, (std::vector<int>{2, 3}));
}

TEST(MatchedIds, OfVerticesAreNeverGivenTwice) {
  // In the second segment the triangles no longer share an edge: two vertices would have one id.
  std::vector<EvolvingSegment> segments{pair_from(0.5), pair_from(0.5)};
  segments[1].vertex_ids = {0, 1, 2, 3, 4, 5};
  segments[1].triangles[1] = {4, 3, 5};
  match_ids(segments);
  EXPECT_NO_THROW(check(segments[1]));
  EXPECT_EQ(std::ranges::count(segments[1].triangle_ids, 0) + std::ranges::count(segments[1].triangle_ids, 1), 1);
}

TEST(MatchedIds, AreNewWithoutTextureCoordinates) {
  std::vector<EvolvingSegment> segments{pair_from(0.5), pair_from(0.5)};
  for (EvolvingSegment& segment : segments) segment.uvs.clear(), segment.corner_uvs.clear();
  match_ids(segments);
  EXPECT_EQ(segments[1].triangle_ids, (std::vector<int>{2, 3}));
}

}  // namespace
}  // namespace mq
