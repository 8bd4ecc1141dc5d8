#include "mq/evolving/evolving_mesh.h"

#include <gtest/gtest.h>

#include <limits>

#include "mq/base/error.h"
#include "mq/baseline/forgetful.h"

namespace mq {
namespace {

/// A square of two triangles.
Mesh square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Frames 3, 5, 7: the square; then its second triangle is cut in two by a new vertex.
EvolvingMesh square_cut_late() {
  EvolvingMesh evolving;
  evolving.segments.push_back(segment_of(square()));
  Mesh cut = square();
  cut.positions.emplace_back(0, 0.5, 0);
  cut.triangles = {{0, 1, 2}, {0, 2, 4}, {4, 2, 3}};
  evolving.segments.push_back(segment_of(cut));
  evolving.segments[1].triangle_ids = {0, 2, 3};
  evolving.frames = {{3, 0, square().positions}, {5, 0, square().positions}, {7, 1, cut.positions}};
  return evolving;
}

TEST(EvolvingMesh, GivesTheMeshOfAFrame) {
  const EvolvingMesh evolving = square_cut_late();
  EXPECT_NO_THROW(check(evolving));
  EXPECT_EQ(evolving.mesh(1).triangles, square().triangles);
  EXPECT_EQ(evolving.mesh(2).triangle_count(), 3);
  EXPECT_EQ(evolving.mesh(2).positions[4], Vector3(0, 0.5, 0));
}

TEST(EvolvingMesh, KnowsWhenTrianglesLive) {
  const auto spans = triangle_lifespans(square_cut_late());
  ASSERT_EQ(spans.size(), 4U);
  const int expected[4][2] = {{0, 2}, {0, 1}, {2, 2}, {2, 2}};
  for (int id = 0; id < 4; ++id) {
    EXPECT_EQ(spans[id].id, id);
    EXPECT_EQ(spans[id].first, expected[id][0]);
    EXPECT_EQ(spans[id].last, expected[id][1]);
  }
}

TEST(EvolvingMesh, CountsWhatIsKeptBornAndGone) {
  const EvolvingMesh evolving = square_cut_late();
  const SegmentChange found = change(evolving.segments[0], evolving.segments[1]);
  EXPECT_EQ(found.kept, 1);
  EXPECT_EQ(found.added, 2);
  EXPECT_EQ(found.removed, 1);
  EXPECT_EQ(next_triangle_id(evolving), 4);
  EXPECT_EQ(next_vertex_id(evolving), 5);
}

TEST(EvolvingMesh, RefusesATriangleThatComesBack) {
  EvolvingMesh evolving = square_cut_late();
  evolving.segments.push_back(evolving.segments[0]);
  evolving.frames.push_back({9, 2, square().positions});
  EXPECT_THROW(triangle_lifespans(evolving), InvalidInput);
}

TEST(EvolvingMesh, RefusesAnIdWithOtherVertices) {
  EvolvingMesh evolving = square_cut_late();
  evolving.segments[1].vertex_ids = {0, 1, 9, 3, 4};
  EXPECT_THROW(triangle_lifespans(evolving), InvalidInput);
}

TEST(EvolvingMesh, LetsATriangleBeginAtAnotherCorner) {
  EvolvingMesh evolving = square_cut_late();
  evolving.segments[1].triangles[0] = {1, 2, 0};
  EXPECT_EQ(triangle_lifespans(evolving)[0].last, 2);
  evolving.segments[1].triangles[0] = {1, 0, 2};  // turned over
  EXPECT_THROW(triangle_lifespans(evolving), InvalidInput);
}

TEST(EvolvingMesh, RefusesWhatDoesNotFitTogether) {
  const auto refused = [](auto spoil) {
    EvolvingMesh evolving = square_cut_late();
    spoil(evolving);
    EXPECT_THROW(check(evolving), InvalidInput);
  };
  refused([](EvolvingMesh& e) { e.segments[0].triangles[1][2] = 4; });
  refused([](EvolvingMesh& e) { e.segments[0].triangles[1][2] = -1; });
  refused([](EvolvingMesh& e) { e.segments[0].triangle_ids[1] = 0; });
  refused([](EvolvingMesh& e) { e.segments[0].vertex_ids[1] = -1; });
  refused([](EvolvingMesh& e) { e.segments[1].triangle_ids.pop_back(); });
  refused([](EvolvingMesh& e) { e.segments[0].corner_uvs.resize(1); });
  refused([](EvolvingMesh& e) { e.segments[0].corner_uvs.assign(2, {0, 0, 0}); });
  refused([](EvolvingMesh& e) { e.frames[2].positions.pop_back(); });
  refused([](EvolvingMesh& e) { e.frames[1].number = 3; });
  refused([](EvolvingMesh& e) { e.frames[0].segment = 1; });
  refused([](EvolvingMesh& e) { e.frames[2].segment = 2; });
  refused([](EvolvingMesh& e) {
    e.frames[0].positions[0].x() = std::numeric_limits<double>::quiet_NaN();
  });
}

TEST(Renewed, KeepsShapesAndForgetsTriangles) {
  const EvolvingMesh evolving = square_cut_late();
  const EvolvingMesh by_segment = with_new_ids(evolving, Forgetting::segments),
                     by_frame = with_new_ids(evolving, Forgetting::frames);
  EXPECT_EQ(by_segment.segments.size(), 2U);
  EXPECT_EQ(by_frame.segments.size(), 3U);
  for (const EvolvingMesh* mesh : {&by_segment, &by_frame}) {
    EXPECT_NO_THROW(check(*mesh));
    for (int f = 0; f < 3; ++f) {
      EXPECT_EQ(mesh->mesh(f).positions, evolving.mesh(f).positions);
      EXPECT_EQ(mesh->mesh(f).triangles, evolving.mesh(f).triangles);
      EXPECT_EQ(mesh->frames[f].number, evolving.frames[f].number);
    }
  }
  for (const Lifespan& span : triangle_lifespans(by_segment))
    EXPECT_EQ(span.last - span.first, span.id < 2 ? 1 : 0);
  for (const Lifespan& span : triangle_lifespans(by_frame)) EXPECT_EQ(span.first, span.last);
}

}  // namespace
}  // namespace mq
