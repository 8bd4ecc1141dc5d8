// A ring whose hole closes and opens again: what is away from the hole is the same surface all the while.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/sequences.h"
#include "mq/evolving/evolving_mesh.h"
#include "mq/mesh/surface.h"
#include "mq/sample/implicit.h"
#include "remesh/remesh_models.h"

namespace mq {
namespace {

/// Two tubes of one ring, of which the inner one is this far from the axis; nothing moves but the hole's wall.
double ring_with_hole(const Vector3& p, double inner) {
  return smooth_union(test::ring(p), test::torus_distance(p, inner, 0.2), 0.05);
}

/// The radii of the inner tube over time. At 0.12 the hole is closed.
constexpr double inner_tubes[] = {0.55, 0.45, 0.12, 0.12, 0.45, 0.55};

bool is_closed(double inner) { return inner < 0.2; }

MemoryFrames closing_and_opening() {
  std::vector<MemoryFrames::Frame> frames;
  for (const double inner : inner_tubes) {
    Model model;
    model.mesh = test::meshed([inner](const Vector3& p) { return ring_with_hole(p, inner); }, 3000,
                              is_closed(inner) ? 2 : 0);
    frames.push_back({int(frames.size()), std::move(model), {}});
  }
  return MemoryFrames(std::move(frames));
}

/// Not less than a node's spacing from what moves.
bool is_outside(const Mesh& mesh, int t) {
  return std::ranges::all_of(mesh.triangles[std::size_t(t)], [&](int v) {
    return std::hypot(mesh.positions[std::size_t(v)].x(), mesh.positions[std::size_t(v)].y()) > 0.7;
  });
}

TEST(SequenceTracker, KeepsTheIdsAwayFromAHoleThatClosesAndOpens) {
  const MemoryFrames frames = closing_and_opening();
  MemoryStore store;
  SequenceTracker(frames, store, coarse({.follow = {.remeshing = Remeshing::parts}})).run();
  const EvolvingMesh& evolving = store.mesh();
  ASSERT_EQ(evolving.frames.size(), std::size(inner_tubes));
  for (int f = 0; f < int(evolving.frames.size()); ++f) {
    const Mesh mesh = evolving.mesh(f);
    const Surface surface = make_surface(mesh, {WeldOptions::Kind::none});
    EXPECT_EQ(test::topology_problems(mesh), "") << f;
    EXPECT_EQ(surface.boundary_edges, 0) << f;
    EXPECT_EQ(surface.euler_characteristic, is_closed(inner_tubes[f]) ? 2 : 0) << f;
  }
  const std::vector<Lifespan> spans = triangle_lifespans(evolving);
  const EvolvingSegment& first = evolving.segments.front();
  const Mesh mesh = evolving.mesh(0);
  int outside = 0;
  for (int t = 0; t < first.triangle_count(); ++t) {
    if (!is_outside(mesh, t)) continue;
    ++outside;
    const auto span = std::ranges::find(spans, first.triangle_ids[std::size_t(t)], &Lifespan::id);
    ASSERT_NE(span, spans.end());
    EXPECT_EQ(span->first, 0);
    EXPECT_EQ(span->last, int(evolving.frames.size()) - 1) << "triangle " << t;
  }
  EXPECT_GT(outside, first.triangle_count() / 3);
  EXPECT_LT(outside, first.triangle_count());
  EXPECT_GE(evolving.segments.size(), 3U);
}

}  // namespace
}  // namespace mq
