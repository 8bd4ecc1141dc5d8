#include "mq/track/track_template.h"

#include <gtest/gtest.h>

#include "mq/base/error.h"

namespace mq {
namespace {

/// n × n squares of side 1/n in the plane z = 0, each of two triangles.
Mesh sheet(int n) {
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.positions.emplace_back(double(i) / n, double(j) / n, 0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      mesh.triangles.push_back({v, v + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  return mesh;
}

/// A colour, and a place of the material, that are linear in the place.
Signal linear_colours(const Mesh& mesh) {
  Signal colours(mesh.vertex_count(), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v) colours.row(v) = 2 * mesh.positions[v].transpose();
  return colours;
}

/// The sheet with its last triangle cut in three by a new vertex in its middle.
EvolvingSegment cut_last(const EvolvingSegment& before) {
  EvolvingSegment after = before;
  const Triangle last = after.triangles.back();
  const int middle = after.vertex_count();
  after.vertex_ids.push_back(1000);
  after.triangles.pop_back();
  after.triangle_ids.pop_back();
  for (int k = 0; k < 3; ++k) {
    after.triangles.push_back({last[k], last[(k + 1) % 3], middle});
    after.triangle_ids.push_back(2000 + k);
  }
  return after;
}

std::vector<Vector3> with_middle(std::vector<Vector3> positions, const EvolvingSegment& before) {
  Vector3 middle = Vector3::Zero();
  for (const int v : before.triangles.back()) middle += positions[v] / 3;
  positions.push_back(middle);
  return positions;
}

TEST(TrackTemplate, CarriesOverWhatIsKeptAndLooksUpWhatIsNew) {
  const Mesh mesh = sheet(4);
  TrackTemplate before = new_template(mesh, linear_colours(mesh), mesh.positions, 0, 0);
  before.colours.array() += 0.25;  // so that kept and new can be told apart
  std::vector<Vector3> moved = mesh.positions;
  for (Vector3& p : moved) p.z() = 0.01;
  const EvolvingSegment after = cut_last(before.segment);
  Mesh material = mesh;
  for (Vector3& p : material.positions) p += Vector3(7, 0, 0);
  const MaterialFrame truth{mesh, material};
  const std::vector<Vector3> positions = with_middle(moved, before.segment);
  const TrackTemplate next =
      carried(before, after, positions, TrackTarget(mesh, linear_colours(mesh)), &truth);
  const int n = mesh.vertex_count(), kept = mesh.triangle_count() - 1;
  EXPECT_EQ(next.start, positions);
  for (int v = 0; v < n; ++v) {
    EXPECT_EQ(next.colours.row(v), before.colours.row(v));
    EXPECT_EQ(next.material[v], before.material[v]);
  }
  const Vector3 flat(positions[n].x(), positions[n].y(), 0);
  EXPECT_LT((next.colours.row(n).transpose() - 2 * flat).norm(), 1e-12);
  EXPECT_LT((next.material[n] - flat - Vector3(7, 0, 0)).norm(), 1e-12);
  for (int t = 0; t < kept; ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(next.rest[t][k].z(), 0);
  for (int t = kept; t < after.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(next.rest[t][k].z(), 0.01);
}

TEST(TrackTemplate, KnowsATriangleThatBeginsAtAnotherCorner) {
  const Mesh mesh = sheet(2);
  const TrackTemplate before = new_template(mesh, {}, {}, 0, 0);
  EvolvingSegment after = before.segment;
  std::rotate(after.triangles[3].begin(), after.triangles[3].begin() + 1, after.triangles[3].end());
  const TrackTemplate next = carried(before, after, mesh.positions, TrackTarget(mesh), nullptr);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(next.rest[3][k], mesh.positions[after.triangles[3][k]]);
}

TEST(TrackTemplate, MeasuresDistortionFromEachTrianglesOwnBirth) {
  const Mesh mesh = sheet(4);
  const TrackTemplate before = new_template(mesh, {}, {}, 0, 0);
  std::vector<Vector3> larger = mesh.positions;
  for (Vector3& p : larger) p *= 2;
  const EvolvingSegment after = cut_last(before.segment);
  const std::vector<Vector3> positions = with_middle(larger, before.segment);
  const TrackTemplate next = carried(before, after, positions, TrackTarget(mesh), nullptr);
  EXPECT_NEAR(distortion(before, larger).mean, 2, 1e-12);
  // The three new ones, 4 of 35 in area at birth, are as they were.
  EXPECT_NEAR(distortion(next, positions).mean, (31 * 2 + 4 * 1) / 35.0, 1e-12);
}

TEST(TrackTemplate, MovesNewVerticesAsTheirNeighboursDid) {
  const Mesh mesh = sheet(4);
  const EvolvingSegment before = segment_of(mesh);
  std::vector<Vector3> earlier = mesh.positions;
  for (Vector3& p : earlier) p -= Vector3(0.1, 0.2, 0.3);
  const EvolvingSegment after = cut_last(before);
  const std::vector<Vector3> positions = with_middle(mesh.positions, before);
  const std::vector<Vector3> found = positions_before(before, earlier, after, positions);
  for (std::size_t v = 0; v < positions.size(); ++v)
    EXPECT_LT((found[v] - positions[v] + Vector3(0.1, 0.2, 0.3)).norm(), 1e-14);
}

TEST(TrackTemplate, LeavesNewPartsWithoutNeighboursWhereTheyAre) {
  const Mesh mesh = sheet(1);
  const EvolvingSegment before = segment_of(mesh), other = segment_of(mesh, 100, 100);
  EXPECT_EQ(positions_before(before, mesh.positions, other, mesh.positions), mesh.positions);
}

TEST(TrackTemplate, GivesWhatRemeshingKeptItsIds) {
  const EvolvingSegment before = segment_of(sheet(1), 10, 20);
  Remeshed remeshed;
  remeshed.mesh = sheet(1);
  remeshed.template_vertices = {3, -1, 1, -1};
  remeshed.template_triangles = {-1, 1};
  const EvolvingSegment after = remeshed_segment(remeshed, before, 50, 60);
  EXPECT_EQ(after.vertex_ids, (std::vector<int>{13, 50, 11, 51}));
  EXPECT_EQ(after.triangle_ids, (std::vector<int>{60, 21}));
}

}  // namespace
}  // namespace mq
