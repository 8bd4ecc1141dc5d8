// What a brush reaches: all of a ball where the surface is flat, across seams, and one side of a fold.
#include "mq/fem/surface_ball.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "fem/cut_squares.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

Vector3 place_of(const TexelSpace& space, int k) {
  return space.texels().position(k);
}

std::vector<int> reached(const fixtures::Textured& model, const TexelSpace& space,
                         const Vector3& place, double radius) {
  const ClosestPoint at = ClosestPointFinder(model.surface.mesh)(place);
  return SurfaceBall(space).reach(at.triangle, at.barycentric, place, radius);
}

TEST(SurfaceBall, IsTheBallWhereTheSurfaceIsFlatHoweverItIsCut) {
  for (const int parts : {1, 3}) {
    fixtures::CutOptions cut;
    cut.parts = parts;
    cut.angle = [](int chart) { return 0.4 * chart; };
    const auto model = fixtures::textured(fixtures::cut_square(cut), {{120, 120}});
    const TexelSpace space(model->surface, model->atlas);
    const Vector3 place(0.45, 0.4, 0);
    const double radius = 0.22;
    std::vector<int> inside;
    for (int k = 0; k < space.size(); ++k)
      if ((place_of(space, k) - place).norm() < radius) inside.push_back(k);
    ASSERT_GT(inside.size(), 500U);
    EXPECT_EQ(reached(*model, space, place, radius), inside) << parts;
  }
}

TEST(VertexBall, IsTheBallOnAFlatMeshAndOneSideOfAFold) {
  fixtures::CutOptions cut;
  cut.jitter = 0;
  Mesh mesh = fixtures::cut_square(cut);
  const Surface flat = make_surface(mesh);
  const VertexSpace space(flat);
  const Vector3 place(0.45, 0.4, 0);
  const double radius = 0.22;
  std::vector<int> inside;
  for (int v = 0; v < space.size(); ++v)
    if ((flat.mesh.positions[std::size_t(v)] - place).norm() < radius) inside.push_back(v);
  ASSERT_GT(inside.size(), 10U);
  EXPECT_EQ(VertexBall(space, flat.mesh.positions)
                .reach(ClosestPointFinder(flat.mesh)(place).triangle, place, radius),
            inside);
  for (Vector3& p : mesh.positions)
    if (p.x() > 0.5) p = Vector3(1 - p.x(), p.y(), 0.02);
  const Surface folded = make_surface(mesh);
  const VertexSpace on_fold(folded);
  const Vector3 below(0.2, 0.5, 0);
  const std::vector<int> found =
      VertexBall(on_fold, folded.mesh.positions)
          .reach(ClosestPointFinder(folded.mesh)(below).triangle, below, 0.2);
  EXPECT_FALSE(found.empty());
  for (const int v : found) EXPECT_LT(folded.mesh.positions[std::size_t(v)].z(), 0.01);
}

/// A square folded like a sheet of paper, the halves so close that a ball holds parts of both.
TEST(SurfaceBall, DoesNotReachThroughToTheOtherSide) {
  fixtures::CutOptions cut;
  cut.jitter = 0;
  Mesh mesh = fixtures::cut_square(cut);
  for (Vector3& p : mesh.positions)
    if (p.x() > 0.5) p = Vector3(1 - p.x(), p.y(), 0.02);
  const auto model = fixtures::textured(mesh, {{120, 120}});
  const TexelSpace space(model->surface, model->atlas);
  const auto on_both_sides = [&](const Vector3& place, double radius) {
    std::array<int, 2> count = {0, 0};
    for (const int k : reached(*model, space, place, radius))
      ++count[place_of(space, k).z() > 0.01 ? 1 : 0];
    return count;
  };
  const auto [below, above] = on_both_sides({0.2, 0.5, 0}, 0.15);
  EXPECT_GT(below, 200);
  EXPECT_EQ(above, 0);
  // Nearer to the fold the way around it is in the ball.
  const auto [near_below, near_above] = on_both_sides({0.42, 0.5, 0}, 0.15);
  EXPECT_GT(near_below, 200);
  EXPECT_GT(near_above, 200);
}

/// Over all couplings of the stiffness, one by one.
std::vector<int> reached_over_edges(const TexelSpace& space, const std::vector<int>& begin, const Vector3& place,
                                    double radius) {
  std::vector<std::vector<int>> around(std::size_t(space.size()));
  for (const auto& [i, j] : space.edges()) {
    around[std::size_t(i)].push_back(j);
    around[std::size_t(j)].push_back(i);
  }
  std::vector<char> seen(std::size_t(space.size()), 0);
  std::vector<int> ahead = begin, found;
  while (!ahead.empty()) {
    const int k = ahead.back();
    ahead.pop_back();
    if (std::exchange(seen[std::size_t(k)], 1) || !((place_of(space, k) - place).norm() < radius)) continue;
    found.push_back(k);
    ahead.insert(ahead.end(), around[std::size_t(k)].begin(), around[std::size_t(k)].end());
  }
  std::ranges::sort(found);
  return found;
}

TEST(SurfaceBall, IsWhatCouplingsReach) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const ClosestPointFinder closest(cut.model->surface.mesh);
    SurfaceBall ball(space);
    for (const double radius : {0.02, 0.1, 0.4, 3.0})
      for (const Vector3& place : {Vector3(0.31, 0.48, 0), Vector3(0.5, 0.5, 0), Vector3(0.97, 0.04, 0)}) {
        const ClosestPoint at = closest(place);
        if (cut.model->atlas.chart[std::size_t(at.triangle)] < 0) continue;
        std::vector<int> begin;
        for (const auto& [texel, weight] : space.basis_at(at.triangle, at.barycentric)) begin.push_back(texel);
        EXPECT_EQ(ball.reach(at.triangle, at.barycentric, place, radius),
                  reached_over_edges(space, begin, place, radius))
            << cut.name << ", " << radius;
      }
  }
}

TEST(SurfaceBall, CrossesTheBorderOfATextureThatRepeats) {
  // One chart of which the right half lies in the next tile.
  fixtures::CutOptions cut;
  cut.parts = 1;
  cut.scale = 0.8;
  cut.shift = [](int) { return Vector2(0.5, 0); };
  const auto model =
      fixtures::textured(fixtures::cut_square(cut), {{64, 64, Wrap::repeat}});
  const TexelSpace space(model->surface, model->atlas);
  const Vector3 place(0.5, 0.5, 0);
  int left = 0, right = 0;
  for (const int k : reached(*model, space, place, 0.2))
    ++(space.texels().places[std::size_t(k)].x < 32 ? left : right);
  EXPECT_GT(left, 100);
  EXPECT_GT(right, 100);
}

}  // namespace
}  // namespace mq
