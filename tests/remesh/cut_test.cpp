// Cutting triangles and closing gaps: the parts that local remeshing is made of.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "mq/remesh/detail/clip_surfaces.h"
#include "mq/remesh/detail/seam.h"
#include "mq/remesh/detail/zip_curves.h"
#include "remesh/remesh_models.h"

namespace mq::test {
namespace {

/// Two flat rings of points around one another as curves, the inner kept of the target.
struct TwoCircles {
  SurfacePair pair;
  CutCurve outer, inner;

  TwoCircles(int n, int m, double radius) {
    const auto add = [&](double r, double a, char of_target) {
      pair.mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), 0);
      pair.normals.emplace_back(0, 0, 1);
      pair.of_target.push_back(of_target);
      return pair.mesh.vertex_count() - 1;
    };
    // What is kept lies on the left: outside of the one, inside of the other.
    for (int i = 0; i < n; ++i) outer.vertices.push_back(add(1, -2 * std::numbers::pi * i / n, 0));
    for (int k = 0; k < m; ++k)
      inner.vertices.push_back(add(radius, 1 + 2 * std::numbers::pi * k / m, 1));
    outer.kind = inner.kind = CutCurve::Kind::closed;
  }
};

TEST(Zip, FillsTheRingBetweenTwoCircles) {
  for (const auto& [n, m] : {std::pair{30, 30}, std::pair{40, 9}, std::pair{3, 50}}) {
    const TwoCircles circles(n, m, 0.4);
    const Strip strip = zip(circles.pair, circles.outer, circles.inner);
    ASSERT_EQ(std::ssize(strip.triangles), n + m);
    Mesh mesh = circles.pair.mesh;
    mesh.triangles = strip.triangles;
    double area = 0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      EXPECT_GT(triangle_normal(mesh, t).z(), 0.99);
      EXPECT_FALSE(is_bad(circles.pair, mesh.triangles[std::size_t(t)]));
      area += triangle_area(mesh, t);
    }
    const auto polygon = [](int k, double r) {
      return 0.5 * k * r * r * std::sin(2 * std::numbers::pi / k);
    };
    EXPECT_NEAR(area, polygon(n, 1) - polygon(m, 0.4), 1e-12);
    const Surface ring = make_surface(mesh, {WeldOptions::Kind::none});
    EXPECT_EQ(ring.boundary_edges, n + m);
    EXPECT_EQ(ring.euler_characteristic, 0);
  }
}

TEST(Zip, RefusesCurvesThatAreNoCurves) {
  const TwoCircles circles(8, 2, 0.4);
  EXPECT_NE(fixtures::error_of([&] { zip(circles.pair, circles.outer, circles.inner); }), "");
}

TEST(PairCurves, FindsPartnersByDistanceAndNormals) {
  TwoCircles circles(20, 16, 0.8);
  const CurvePairs found = pair_curves(circles.pair, {circles.inner, circles.outer}, 0.5);
  ASSERT_EQ(found.pairs.size(), 1U);
  EXPECT_EQ(found.pairs[0], (std::array{1, 0}));
  EXPECT_TRUE(pair_curves(circles.pair, {circles.inner, circles.outer}, 0.1).pairs.empty());
  for (std::size_t v = 20; v < circles.pair.normals.size(); ++v) circles.pair.normals[v] *= -1;
  EXPECT_EQ(pair_curves(circles.pair, {circles.inner, circles.outer}, 0.5).alone,
            (std::vector{0, 1}));
}

TEST(CutCurves, EncloseWhatIsKept) {
  const Surface sheet = make_surface(fixtures::flat_square(10)),
                ball = make_surface(fixtures::sphere(3));
  const SurfacePair pair = join(sheet, ball);
  std::vector<char> kept(pair.mesh.triangles.size());
  for (int t = 0; t < pair.mesh.triangle_count(); ++t)
    kept[std::size_t(t)] = pair.triangle_of_target(t) ? pair.mesh.position(t, 0).z() > 0.2
                                                      : pair.mesh.position(t, 0).x() > 0.45;
  clean_cut(pair, kept);
  const std::vector<CutCurve> curves = cut_curves(pair, kept);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].kind, CutCurve::Kind::open);
  EXPECT_EQ(curves[0].edge_count(), 10);
  EXPECT_EQ(curves[1].kind, CutCurve::Kind::closed);
  // The upper part lies on the left.
  Vector3 turn = Vector3::Zero();
  for (int i = 0; i < curves[1].edge_count(); ++i) {
    const int v = curves[1].vertices[std::size_t(i)];
    const int w = curves[1].vertices[std::size_t((i + 1) % curves[1].edge_count())];
    turn += pair.mesh.positions[std::size_t(v)].cross(pair.mesh.positions[std::size_t(w)]);
  }
  EXPECT_GT(turn.z(), 0);
}

TEST(CutLongTriangles, StaysConformingAndCoversTheSame) {
  const Surface sheet = make_surface(fixtures::flat_square(3, 0.2)),
                ball = make_surface(fixtures::sphere(2));
  SurfacePair pair = join(sheet, ball);
  const auto near = [](const SurfacePair& p, int t) {
    return (p.mesh.position(t, 0) - Vector3(0.4, 0.5, 0)).norm() < 0.3 + longest_edge(p.mesh, t);
  };
  ASSERT_TRUE(cut_long_triangles(pair, 0.06, 100'000, near));
  const Surface cut = make_surface(pair.mesh, {WeldOptions::Kind::none});
  EXPECT_EQ(topology_problems(pair.mesh), "");
  EXPECT_EQ(cut.twins, pair.twins);
  EXPECT_NEAR(cut.area, sheet.area + ball.area, 1e-12);
  EXPECT_GT(pair.mesh.triangle_count(), 2 * (sheet.triangle_count() + ball.triangle_count()));
  for (int t = 0; t < pair.mesh.triangle_count(); ++t) {
    EXPECT_TRUE(longest_edge(pair.mesh, t) <= 0.06 || !near(pair, t));
    const Mesh& source = pair.triangle_of_target(t) ? ball.mesh : sheet.mesh;
    const int whole = pair.source_triangle[std::size_t(t)];
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(closest_point(source, whole, pair.mesh.position(t, k)).squared_distance, 1e-28);
  }
  EXPECT_FALSE(cut_long_triangles(pair, 1e-3, 10'000, near));
}

TEST(Crossed, AreTrianglesThatPassThroughOneAnother) {
  const std::vector<Vector3> p = {{0, 0, 0},     {1, 0, 0},        {0, 1, 0},  {0.2, 0.2, -1},
                                  {0.2, 0.2, 1}, {0.3, 0.2, 1},    {0, 0, 1},  {0.5, -1, -1},
                                  {0.5, -1, 1},  {0.5, 0.25, 0.1}, {2, 2, -1}, {2, 2, 1}};
  const Triangle flat{0, 1, 2};
  EXPECT_TRUE(cross(p, flat, {3, 4, 5}));
  EXPECT_TRUE(cross(p, {7, 8, 9}, flat));
  EXPECT_FALSE(cross(p, flat, {10, 11, 5}));
  EXPECT_FALSE(cross(p, flat, {0, 1, 6}));
  EXPECT_FALSE(cross(p, flat, {0, 6, 4}));
  EXPECT_TRUE(cross(p, flat, {0, 3, 4}));
  const std::vector<Triangle> asked = {flat, {10, 11, 5}}, others = {{3, 4, 5}};
  EXPECT_EQ(crossed(p, asked, others), (std::vector<char>{1, 0}));
  EXPECT_EQ(crossed(p, asked, {}), (std::vector<char>{0, 0}));
  EXPECT_EQ(crossed_by(p, others, asked), (std::vector<char>{1}));
}

TEST(Crossed, FindsWhatAnExhaustiveSearchFinds) {
  const Mesh ball = fixtures::sphere(3);
  const Mesh mesh = fixtures::beside(ball, mapped(ball, [](const Vector3& q) {
                                       return Vector3(0.8 * q + Vector3(0.61, 0.13, 0.27));
                                     }));
  std::vector<char> slow(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < slow.size(); ++i)
    for (std::size_t j = 0; j < slow.size(); ++j)
      if (i != j && cross(mesh.positions, mesh.triangles[i], mesh.triangles[j])) slow[i] = 1;
  EXPECT_GT(std::ranges::count(slow, char(1)), 20);
  EXPECT_EQ(crossed(mesh.positions, mesh.triangles, {}), slow);
}

TEST(TriangleQuality, IsOneWhereAllSidesAreEqual) {
  const Vector3 a(0, 0, 0), b(1, 0, 0), c(0.5, std::sqrt(0.75), 0), up(0, 0, 1);
  EXPECT_NEAR(triangle_quality(a, b, c, up), 1, 1e-15);
  EXPECT_NEAR(triangle_quality(a, c, b, up), -1, 1e-15);
  EXPECT_EQ(triangle_quality(a, b, b, up), 0);
}

}  // namespace
}  // namespace mq::test
