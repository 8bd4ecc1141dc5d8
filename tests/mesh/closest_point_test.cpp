#include "mq/mesh/closest_point.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "fixtures.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using namespace fixtures;

Vector3 at(const Mesh& mesh, const ClosestPoint& c) {
  return c.barycentric[0] * mesh.position(c.triangle, 0) +
         c.barycentric[1] * mesh.position(c.triangle, 1) +
         c.barycentric[2] * mesh.position(c.triangle, 2);
}

TEST(ClosestPoint, OfATriangleIsInsideOnAnEdgeOrAVertex) {
  const Mesh mesh = one_triangle();
  const auto expect = [&](const Vector3& from, const Vector3& to) {
    const ClosestPoint c = closest_point(mesh, 0, from);
    EXPECT_TRUE(at(mesh, c).isApprox(to, 1e-15) || (to.isZero() && at(mesh, c).norm() < 1e-15));
    EXPECT_NEAR(c.squared_distance, (from - to).squaredNorm(), 1e-15);
    EXPECT_NEAR(c.barycentric.sum(), 1, 1e-15);
    EXPECT_GE(c.barycentric.minCoeff(), 0);
  };
  expect({0.2, 0.3, 5}, {0.2, 0.3, 0});
  expect({0.5, -2, 1}, {0.5, 0, 0});
  expect({1, 1, 1}, {0.5, 0.5, 0});
  expect({-1, -1, 0}, {0, 0, 0});
  expect({3, 0, 0}, {1, 0, 0});
}

TEST(ClosestPoint, OfADegenerateTriangleIsThatOfItsEdges) {
  Mesh mesh = one_triangle();
  mesh.positions = {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  EXPECT_NEAR(closest_point(mesh, 0, {2, 2, 2}).squared_distance, 0, 1e-15);
  mesh.positions = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  EXPECT_DOUBLE_EQ(closest_point(mesh, 0, {0, 0, 0}).squared_distance, 1);
}

TEST(ClosestPoint, IsThatOfComparingAllTriangles) {
  Mesh mesh = beside(torus(30, 20), nonmanifold_edge());
  for (Vector3& p : mesh.positions) p = 1e-3 * p + Vector3(1000, -2000, 500);
  const ClosestPointFinder find(mesh);
  const Random random(9);
  std::vector<Vector3> points(mesh.positions);  // at a vertex several triangles are equally close
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double reach = std::pow(10, random.uniform(4 * i, -5, 3));
    points.push_back(Vector3(1000, -2000, 500) + reach * Vector3(random.uniform(4 * i + 1, -1, 1),
                                                                 random.uniform(4 * i + 2, -1, 1),
                                                                 random.uniform(4 * i + 3, -1, 1)));
  }
  const std::vector<ClosestPoint> found = find(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ClosestPoint best = closest_point(mesh, 0, points[i]);
    for (int t = 1; t < mesh.triangle_count(); ++t) {
      const ClosestPoint c = closest_point(mesh, t, points[i]);
      if (c.squared_distance < best.squared_distance) best = c;
    }
    ASSERT_EQ(found[i].triangle, best.triangle) << i;
    ASSERT_EQ(found[i].squared_distance, best.squared_distance) << i;
  }
}

TEST(ClosestPoint, IsTheSameFromAnyGuess) {
  Mesh mesh = beside(torus(30, 20), nonmanifold_edge());
  const Random random(11);
  std::vector<Vector3> points(mesh.positions);  // at a vertex several triangles are equally close
  for (std::uint64_t i = 0; i < 1000; ++i)
    points.push_back(std::pow(10, random.uniform(4 * i, -5, 3)) *
                     Vector3(random.uniform(4 * i + 1, -1, 1), random.uniform(4 * i + 2, -1, 1),
                             random.uniform(4 * i + 3, -1, 1)));
  std::vector<ClosestPoint> guesses(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)  // −1 and what is too large are of no triangle
    guesses[i].triangle = int(i * 37 % std::size_t(mesh.triangle_count() + 2)) - 1;
  for (int step = 0; step < 3; ++step) {
    for (Vector3& p : mesh.positions) p = 1.1 * p + Vector3(0.3 * p.y(), 100, step);
    const ClosestPointFinder find(mesh);
    const std::vector<ClosestPoint> found = find(points), guessed = find(points, guesses);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(guessed[i].triangle, found[i].triangle) << i;
      ASSERT_EQ(guessed[i].squared_distance, found[i].squared_distance) << i;
      ASSERT_EQ(guessed[i].barycentric, found[i].barycentric) << i;
    }
  }
}

TEST(ClosestPoint, AmongThoseAcceptedIsThatOfComparingThem) {
  const Mesh mesh = torus(30, 20);
  const ClosestPointFinder find(mesh);
  const Random random(5);
  int none = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Vector3 p(random.uniform(3 * i, -1.5, 1.5), random.uniform(3 * i + 1, -1.5, 1.5),
                    random.uniform(3 * i + 2, -0.6, 0.6));
    // Accepted are triangles, and points with x above that of p, no farther than the radius.
    const auto accept = [&](const ClosestPoint& c) {
      return c.triangle % 3 != 0 && at(mesh, c).x() > p.x();
    };
    const double radius = 0.3;
    ClosestPoint best;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const ClosestPoint c = closest_point(mesh, t, p);
      if (accept(c) && c.squared_distance <= radius * radius &&
          (best.triangle < 0 || c.squared_distance < best.squared_distance))
        best = c;
    }
    const ClosestPoint found = find.among(p, radius, accept);
    EXPECT_EQ(found.triangle, best.triangle);
    if (best.triangle < 0)
      ++none;
    else
      EXPECT_EQ(found.squared_distance, best.squared_distance);
  }
  EXPECT_GT(none, 100);
  EXPECT_LT(none, 900);
}

TEST(ClosestPoint, OnASphereIsTheRadialProjection) {
  const Mesh mesh = sphere(6);
  const ClosestPointFinder find(mesh);
  const Random random(4);
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Vector3 p(random.uniform(3 * i, -2, 2), random.uniform(3 * i + 1, -2, 2),
                    random.uniform(3 * i + 2, -2, 2));
    EXPECT_NEAR(std::sqrt(find(p).squared_distance), std::abs(p.norm() - 1), 1e-3);
  }
}

TEST(ClosestPoint, CopesWithPointsFarAway) {
  const Mesh mesh = sphere(3);
  const ClosestPointFinder find(mesh);
  for (const double far : {1e3, 1e8, 1e20, 1e100})
    EXPECT_NEAR(std::sqrt(find({far, 0, 0}).squared_distance) / (far - 1), 1, 0.01);
}

TEST(ClosestPoint, RefusesWhatHasNone) {
  EXPECT_THROW(ClosestPointFinder(Mesh{}), InvalidInput);
  const Mesh mesh = one_triangle();
  const ClosestPointFinder find(mesh);
  const Vector3 nowhere(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  EXPECT_THROW(find(nowhere), InvalidInput);
}

}  // namespace
}  // namespace mq
