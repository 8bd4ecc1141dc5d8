#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <numbers>

#include "fixtures.h"
#include "mq/trace/detail/straight_paths.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

using namespace fixtures;

constexpr double for_ever = std::numeric_limits<double>::infinity();

Vector3 place(const Surface& surface, const SurfacePoint& p) {
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 3; ++k) sum += p.barycentric[k] * surface.mesh.position(p.triangle, k);
  return sum;
}

std::vector<Vector3> places(const Surface& surface, const std::vector<SurfacePoint>& points) {
  std::vector<Vector3> all;
  for (const SurfacePoint& p : points) all.push_back(place(surface, p));
  return all;
}

/// A field in space, taken at the middle of every triangle.
Vector sampled(const Surface& surface, const auto& field) {
  std::vector<Vector3> values;
  for (int t = 0; t < surface.triangle_count(); ++t)
    values.push_back(field(
        (surface.mesh.position(t, 0) + surface.mesh.position(t, 1) + surface.mesh.position(t, 2)) /
        3));
  return field_in_frames(surface, values);
}

/// Points inside triangles, on edges and at vertices, of all triangles of which `wanted` holds.
std::vector<SurfacePoint> starts_where(const Surface& surface, const auto& wanted) {
  std::vector<SurfacePoint> starts;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (const Vector3& b : {Vector3(0.2, 0.3, 0.5), Vector3(0.5, 0, 0.5), Vector3(0, 1, 0)}) {
      const SurfacePoint p{t, b};
      if (wanted(place(surface, p))) starts.push_back(p);
    }
  return starts;
}

double at(const Surface& surface, const Vector& P, const SurfacePoint& p) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += p.barycentric[k] * P[surface.mesh.triangles[p.triangle][k]];
  return sum;
}

/// Hills and valleys, and noise from vertex to vertex.
Vector rough_potential(const Surface& surface, double noise) {
  Vector P(surface.mesh.vertex_count());
  const Random random(5);
  for (int v = 0; v < P.size(); ++v) {
    const Vector3& p = surface.mesh.positions[v];
    P[v] = std::sin(5 * p.x()) + std::cos(4 * p.y() + p.z()) +
           noise * random.uniform(std::uint64_t(v), -1, 1);
  }
  return P;
}

/// Whether a point is at a vertex that no neighbour lies below.
bool at_minimum(const Surface& surface, const Vector& P, const SurfacePoint& p) {
  if (p.barycentric.maxCoeff() != 1) return false;
  int corner = 0;
  p.barycentric.maxCoeff(&corner);
  const int v = surface.mesh.triangles[p.triangle][corner];
  for (const Triangle& t : surface.mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (t[k] == v && (P[t[(k + 1) % 3]] < P[v] || P[t[(k + 2) % 3]] < P[v])) return false;
  return true;
}

class ConstantField : public ::testing::TestWithParam<std::pair<double, Vector3>> {};

TEST_P(ConstantField, LeadsStraightThroughAnyTriangles) {
  const auto [jitter, X] = GetParam();
  const Surface surface = make_surface(flat_square(16, jitter));
  const TraceMesh mesh(surface);
  const SurfaceFlow flow = SurfaceFlow::along(mesh, sampled(surface, [&](auto) { return X; }));
  const auto inside = [&](const Vector3& p) {
    const Vector3 end = p + 0.3 * X;
    return p.head<2>().minCoeff() > 0.1 && p.head<2>().maxCoeff() < 0.9 &&
           end.head<2>().minCoeff() > 0.1 && end.head<2>().maxCoeff() < 0.9;
  };
  const auto starts = starts_where(surface, inside);
  ASSERT_GT(starts.size(), 100U);
  const Traced traced = flow.trace(starts, 0.3);
  for (std::size_t i = 0; i < starts.size(); ++i)
    EXPECT_LT((place(surface, traced.ends[i]) - place(surface, starts[i]) - 0.3 * X).norm(), 1e-12);
  EXPECT_EQ(traced.counts.paths, std::ssize(starts));
  EXPECT_EQ(traced.counts.cut_short, 0);
}

// On the regular grid these run along edges, along diagonals and from vertex to vertex.
INSTANTIATE_TEST_SUITE_P(
    OnASquare, ConstantField,
    ::testing::Values(std::pair(0.24, Vector3(0.8, 0.31, 0)),
                      std::pair(0.24, Vector3(-0.5, 0.7, 0)), std::pair(0.0, Vector3(1, 0, 0)),
                      std::pair(0.0, Vector3(0, -1, 0)), std::pair(0.0, Vector3(1, 1, 0)),
                      std::pair(0.0, Vector3(-1, -1, 0)), std::pair(0.0, Vector3(1, 0.5, 0)),
                      std::pair(0.0, Vector3(-0.5, 1, 0))));

TEST(SurfaceFlow, ComesBackWhereNothingSlides) {
  const Surface surface = make_surface(torus(60, 40));
  const TraceMesh mesh(surface);
  const Vector field = sampled(surface, [](const Vector3& p) {
    const Vector3 around = Vector3::UnitZ().cross(p), out = Vector3(p.x(), p.y(), 0).normalized();
    return Vector3(around + around.normalized().cross(p - out));
  });
  const auto starts = starts_where(surface, [](auto) { return true; });
  const Traced there = SurfaceFlow::along(mesh, field).trace(starts, 2.0);
  const Traced back = SurfaceFlow::along(mesh, -field).trace(there.ends, 2.0);
  EXPECT_EQ(there.counts.edges + back.counts.edges, 0);
  double worst = 0;
  for (std::size_t i = 0; i < starts.size(); ++i)
    worst = std::max(worst, (place(surface, back.ends[i]) - place(surface, starts[i])).norm());
  const double crossings = double(there.counts.triangles) / double(starts.size());
  EXPECT_LT(worst, 1e-11 * crossings);
}

TEST(SurfaceFlow, ClosesGreatCirclesOfARotation) {
  double errors[2];
  for (const int level : {5, 6}) {
    const Surface surface = make_surface(sphere(level));
    const TraceMesh mesh(surface);
    const Vector field = sampled(surface, [](const Vector3& p) {
      return Vector3(Vector3::UnitZ().cross(p) / p.squaredNorm());
    });
    const auto starts =
        starts_where(surface, [](const Vector3& p) { return std::abs(p.z()) < 0.2; });
    const Traced traced = SurfaceFlow::along(mesh, field).trace(starts, 2 * std::numbers::pi);
    double sum = 0;
    for (std::size_t i = 0; i < starts.size(); ++i)
      sum += (place(surface, traced.ends[i]) - place(surface, starts[i])).norm();
    errors[level - 5] = sum / double(starts.size());
  }
  EXPECT_LT(errors[1], 1e-2);  // 16,384 triangles
  EXPECT_GT(std::log2(errors[0] / errors[1]), 0.9);
}

TEST(SurfaceFlow, FallsToMinimaOfThePotentialAndNowhereElse) {
  for (const double noise : {0.0, 0.02, 2.0}) {
    const Surface surface = make_surface(torus(48, 24));
    const TraceMesh mesh(surface);
    const Vector P = rough_potential(surface, noise);
    const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
    const auto starts = starts_where(surface, [](auto) { return true; });
    const Traced traced = flow.trace(starts, for_ever);
    for (const SurfacePoint& end : traced.ends) EXPECT_TRUE(at_minimum(surface, P, end));
    EXPECT_EQ(traced.counts.cut_short, 0);
    EXPECT_EQ(traced.counts.resting, traced.counts.paths);
    const Traced late = flow.trace(starts, 1e6);
    for (std::size_t i = 0; i < starts.size(); ++i)
      EXPECT_EQ(late.ends[i].barycentric, traced.ends[i].barycentric);
  }
}

TEST(SurfaceFlow, FallsAllTheTime) {
  const Surface surface = make_surface(sphere(4));
  const TraceMesh mesh(surface);
  const Vector P = rough_potential(surface, 0.3);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  const auto starts = starts_where(surface, [](auto) { return true; });
  std::vector<SurfacePoint> now = starts;
  int falling = 0;
  for (int step = 0; step < 12; ++step) {
    const Traced next = flow.trace(now, 0.005);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double before = at(surface, P, now[i]), after = at(surface, P, next.ends[i]);
      if (at_minimum(surface, P, now[i])) {
        EXPECT_EQ(after, before);
      } else {
        EXPECT_LT(after, before);
      }
      falling += after < before;
    }
    now = next.ends;
  }
  EXPECT_GT(falling, 5000);
  // Twelve flows in a row are one.
  const Traced whole = flow.trace(starts, 0.06);
  for (std::size_t i = 0; i < starts.size(); ++i)
    EXPECT_LT((place(surface, whole.ends[i]) - place(surface, now[i])).norm(), 1e-9);
}

TEST(SurfaceFlow, DriftsApartExponentiallyFromTheRidgeOfAParabola) {
  // P = −½kx², so that x(t) = x₀·e^{kt}.
  const Surface surface = make_surface(flat_square(200, 0.1));
  const TraceMesh mesh(surface);
  const double k = 3;
  Vector P(surface.mesh.vertex_count());
  for (int v = 0; v < P.size(); ++v) P[v] = -0.5 * k * std::pow(surface.mesh.positions[v].x(), 2);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  const auto starts = starts_where(surface, [](const Vector3& p) {
    return p.x() > 0.1 && p.x() < 0.3 && std::abs(p.y() - 0.5) < 0.2;
  });
  for (const double time : {0.1, 0.3}) {
    const Traced traced = flow.trace(starts, time);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const double expected = place(surface, starts[i]).x() * std::exp(k * time);
      EXPECT_NEAR(place(surface, traced.ends[i]).x(), expected, 0.01 * expected);
    }
  }
}

TEST(SurfaceFlow, SlidesAlongConvergingEdges) {
  // A valley along the diagonal, falling towards (1, 1).
  const Surface surface = make_surface(flat_square(1));
  const TraceMesh mesh(surface);
  Vector P(4);
  P << 0, 2, 3, -1;  // (0,0) (1,0) (0,1) (1,1)
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  const std::vector<SurfacePoint> start = {{0, {0.5, 0, 0.5}}};  // the middle of the diagonal
  const Traced traced = flow.trace(start, 0.5);
  // Speed √½ along the diagonal of length √2, from its middle.
  EXPECT_LT((place(surface, traced.ends[0]) - Vector3(0.75, 0.75, 0)).norm(), 1e-14);
  EXPECT_EQ(traced.counts.edges, 1);
  EXPECT_TRUE(at_minimum(surface, P, flow.trace(start, for_ever).ends[0]));
}

TEST(SurfaceFlow, TakesTheFasterSideOfADivergingEdge) {
  const Surface surface = make_surface(flat_square(1));
  const TraceMesh mesh(surface);
  Vector P(4);
  P << 0, -1, -3, 0;  // a ridge along the diagonal, steeper towards (0, 1)
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  for (const int triangle : {0, 1}) {
    const Vector3 b = triangle == 0 ? Vector3(0.5, 0, 0.5) : Vector3(0.5, 0.5, 0);
    const SurfacePoint start{triangle, b};
    ASSERT_LT((place(surface, start) - Vector3(0.5, 0.5, 0)).norm(), 1e-15);
    const Vector3 end = place(surface, flow.trace(std::vector{start}, for_ever).ends[0]);
    EXPECT_LT((end - Vector3(0, 1, 0)).norm(), 1e-14);
  }
}

TEST(SurfaceFlow, StaysInsideOnGridsWhoseEveryPathMeetsVertices) {
  for (const auto& X : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(-1, -1, 0), Vector3(1, -1, 0),
                        Vector3(2, 1, 0)}) {
    const Surface surface = make_surface(flat_square(8));
    const TraceMesh mesh(surface);
    const Vector field = sampled(surface, [&](auto) { return X; });
    const SurfaceFlow flow = SurfaceFlow::along(mesh, field);
    const Traced vertices = flow.trace_vertices(100);
    const auto straight = straight_paths(
        mesh, field, starts_where(surface, [](auto) { return true; }), 100, {.step = 0.1});
    for (const auto& traced : {vertices, straight}) {
      for (const Vector3& p : places(surface, traced.ends)) {
        ASSERT_TRUE(p.allFinite());
        EXPECT_GE(p.head<2>().minCoeff(), 0);
        EXPECT_LE(p.head<2>().maxCoeff(), 1 + 1e-15);
        // Where the boundary lets it go no further.
        for (int axis = 0; axis < 2; ++axis)
          if (X[axis] != 0 && X[1 - axis] == 0) {
            EXPECT_EQ(p[axis], X[axis] > 0 ? 1 : 0);
          }
      }
      EXPECT_EQ(traced.counts.cut_short, 0);
    }
  }
}

TEST(SurfaceFlow, SlidesAlongBoundariesToWhereTheyLeadNoFurther) {
  const Surface surface = make_surface(flat_square(6, 0.2));
  const TraceMesh mesh(surface);
  const SurfaceFlow flow =
      SurfaceFlow::along(mesh, sampled(surface, [](auto) { return Vector3(1, 0.25, 0); }));
  for (const Vector3& p : places(surface, flow.trace_vertices(50).ends))
    EXPECT_LT((p - Vector3(1, 1, 0)).norm(), 1e-12);
}

TEST(SurfaceFlow, EndsAtTrianglesWithoutAreaAndAtCutEdges) {
  Mesh mesh = beside(nonmanifold_edge(), flat_square(2));
  const int first = 5;
  mesh.triangles.push_back({first + 0, first + 2, first + 1});  // collinear, on the boundary
  const Surface surface = make_surface(mesh);
  ASSERT_EQ(surface.degenerate.back(), 1);
  const TraceMesh walked(surface);
  Vector P(surface.mesh.vertex_count());
  for (int v = 0; v < P.size(); ++v) P[v] = surface.mesh.positions[v].y();
  const SurfaceFlow flow = SurfaceFlow::downhill(walked, P);
  const Traced traced = flow.trace_vertices(for_ever);
  for (int v = 0; v < P.size(); ++v) {
    if (traced.ends[v].triangle < 0) continue;
    EXPECT_LE(at(surface, P, traced.ends[v]), P[v]);
    EXPECT_EQ(surface.degenerate[traced.ends[v].triangle], 0);
  }
  const SurfacePoint start{surface.triangle_count() - 1, {0.2, 0.3, 0.5}};
  EXPECT_EQ(flow.trace(std::vector{start}, 1.0).ends[0].barycentric, start.barycentric);
}

TEST(SurfaceFlow, GivesTheSameBitsForAnyNumberOfThreadsAndAnyOrderOfStarts) {
  const Surface surface = make_surface(sphere(5));
  const TraceMesh mesh(surface);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, rough_potential(surface, 0.1));
  auto starts = starts_where(surface, [](auto) { return true; });
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return flow.trace(starts, 0.2);
  };
  const Traced one = with_threads(1);
  for (const std::size_t threads : {2U, 7U}) {
    const Traced many = with_threads(threads);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      ASSERT_EQ(many.ends[i].triangle, one.ends[i].triangle);
      ASSERT_EQ(many.ends[i].barycentric, one.ends[i].barycentric);
    }
    EXPECT_EQ(many.counts.triangles, one.counts.triangles);
  }
  std::ranges::reverse(starts);
  const Traced reversed = flow.trace(starts, 0.2);
  for (std::size_t i = 0; i < starts.size(); ++i)
    ASSERT_EQ(reversed.ends[i].barycentric, one.ends[starts.size() - 1 - i].barycentric);
}

TEST(Advect, KeepsTheRangeOfEveryChannelAndCarriesAllAlike) {
  const Surface surface = make_surface(sphere(5));
  const TraceMesh mesh(surface);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, rough_potential(surface, 0.1));
  Signal signal(surface.mesh.vertex_count(), 5);
  const Random random(2);
  for (int i = 0; i < signal.size(); ++i)
    signal.data()[i] = random.uniform(std::uint64_t(i), -3, 7);
  signal.col(4).setConstant(0.1);
  signal.col(3) = signal.col(0);
  for (const double time : {0.0, 0.01, 1.0, 1e6}) {
    const Signal after = flow.advect(signal, time).signal;
    for (int c = 0; c < 5; ++c) {
      EXPECT_LE(after.col(c).maxCoeff(), signal.col(c).maxCoeff());
      EXPECT_GE(after.col(c).minCoeff(), signal.col(c).minCoeff());
    }
    EXPECT_EQ(after.col(3), after.col(0));
    EXPECT_EQ(after.col(4), signal.col(4));
    if (time == 0) {
      EXPECT_EQ(after, signal);
    }
  }
}

TEST(Advect, TakesValuesAtTheEndsOfPaths) {
  const Surface surface = make_surface(flat_square(10, 0.2));
  const TraceMesh mesh(surface);
  const Vector P = rough_potential(surface, 0);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  Signal positions(surface.mesh.vertex_count(), 3);
  for (int v = 0; v < positions.rows(); ++v) positions.row(v) = surface.mesh.positions[v];
  const Signal found = flow.advect(positions, 0.05).signal;
  const Traced traced = flow.trace_vertices(0.05);
  for (int v = 0; v < positions.rows(); ++v)
    EXPECT_LT((found.row(v).transpose() - place(surface, traced.ends[v])).norm(), 1e-15);
}

TEST(SurfaceFlow, RefusesWhatIsNoPath) {
  const Surface surface = make_surface(tetrahedron());
  const TraceMesh mesh(surface);
  EXPECT_THROW(SurfaceFlow::downhill(mesh, Vector::Zero(3)), InvalidInput);
  EXPECT_THROW(SurfaceFlow::downhill(mesh, Vector::Constant(4, NAN)), InvalidInput);
  EXPECT_THROW(SurfaceFlow::along(mesh, Vector::Zero(7)), InvalidInput);
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, Vector::Zero(4));
  EXPECT_THROW(flow.trace_vertices(-1), InvalidInput);
  EXPECT_THROW(flow.trace_vertices(NAN), InvalidInput);
  EXPECT_THROW(flow.trace(std::vector<SurfacePoint>{{4, {1, 0, 0}}}, 1), InvalidInput);
  EXPECT_THROW(flow.trace(std::vector<SurfacePoint>{{0, {1, 1, 0}}}, 1), InvalidInput);
  EXPECT_THROW(straight_paths(mesh, Vector::Zero(8), {}, 1, {.step = 0}), InvalidInput);
  const Mesh none;
  EXPECT_THROW(TraceMesh(make_surface(none)), InvalidInput);
}

TEST(StraightPaths, AreGeodesicsWhereNoStepEndsThem) {
  // From any triangle of a cylinder's development the straight line goes on unbent.
  const Surface surface = make_surface(sphere(5));
  const TraceMesh mesh(surface);
  const Vector field = sampled(
      surface, [](const Vector3& p) { return Vector3(Vector3::UnitZ().cross(p).normalized()); });
  std::vector<SurfacePoint> starts;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const SurfacePoint p{t, {0.3, 0.3, 0.4}};
    if (std::abs(place(surface, p).z()) < 0.03) starts.push_back(p);
  }
  ASSERT_GT(starts.size(), 20U);
  const Traced traced = straight_paths(mesh, field, starts, std::numbers::pi, {});
  for (std::size_t i = 0; i < starts.size(); ++i)
    EXPECT_LT((place(surface, traced.ends[i]) + place(surface, starts[i])).norm(), 0.06);
}

TEST(StraightPaths, AgreeWithTheExactOnesInFirstOrderOfTheStep) {
  const Surface surface = make_surface(flat_square(128));
  const TraceMesh mesh(surface);
  const Vector field =
      sampled(surface, [](const Vector3& p) { return Vector3(0.5 - p.y(), p.x() - 0.5, 0); });
  const auto starts = starts_where(
      surface, [](const Vector3& p) { return (p - Vector3(0.5, 0.5, 0)).norm() < 0.3; });
  const auto exact = places(surface, SurfaceFlow::along(mesh, field).trace(starts, 1.0).ends);
  double errors[2];
  for (const int i : {0, 1}) {
    const auto found =
        places(surface, straight_paths(mesh, field, starts, 1.0, {.step = i ? 0.02 : 0.04}).ends);
    double sum = 0;
    for (std::size_t n = 0; n < found.size(); ++n) sum += (found[n] - exact[n]).norm();
    errors[i] = sum / double(found.size());
  }
  EXPECT_GT(std::log2(errors[0] / errors[1]), 0.8);
  EXPECT_LT(errors[1], 0.01);
}

TEST(StraightPaths, RestNowhereButHoverWhereFieldsOppose) {
  const Surface surface = make_surface(flat_square(1));
  const TraceMesh mesh(surface);
  // Towards the diagonal from both sides.
  const Vector field = sampled(surface, [](const Vector3& p) {
    return p.x() > p.y() ? Vector3(-1, 1, 0) : Vector3(1, -1, 0);
  });
  const std::vector<SurfacePoint> start = {{0, {0.3, 0.4, 0.3}}};
  const Vector3 end = place(surface, straight_paths(mesh, field, start, 5, {.step = 0.01}).ends[0]);
  EXPECT_LT(std::abs(end.x() - end.y()), 0.015);
  const Traced exact = SurfaceFlow::along(mesh, field).trace(start, 5);
  EXPECT_EQ(exact.counts.resting, 1);
  const Vector3 there = place(surface, exact.ends[0]);
  EXPECT_LT(std::abs(there.x() - there.y()), 1e-15);
}

}  // namespace
}  // namespace mq
