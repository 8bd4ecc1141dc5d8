// Paths do not depend on how triangles and their corners are numbered.

#include <gtest/gtest.h>

#include <limits>

#include "fixtures.h"
#include "mq/base/random.h"
#include "mq/trace/detail/straight_paths.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

/// A square of four triangles around its middle and four beside them: vertices inside and on boundaries of
/// one and of more triangles.
Mesh cross_of_triangles() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0},    {1, 0.1, 0},  {1.1, 1, 0}, {-0.1, 1.1, 0},
                    {0.45, 0.5, 0}, {0.6, -0.7, 0}, {1.8, 0.4, 0}, {0.5, 1.9, 0}};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 6}, {3, 2, 7}};
  return mesh;
}

/// Where paths from all vertices, edges and middles of triangles end, numbered as in `cross_of_triangles`.
template <class Follow>
std::vector<Vector3> ends_as_numbered(int rotation, int first, const Random& random, const Follow& follow) {
  const Mesh as_made = cross_of_triangles();
  const int count = as_made.triangle_count();
  Mesh mesh = as_made;
  std::vector<Vector3> vectors;
  std::vector<SurfacePoint> starts(std::size_t(3 * count));
  for (int n = 0; n < count; ++n) {
    const int made = (n + first) % count;  // triangle n is that one, its corner k that one's corner k + rotation
    for (int k = 0; k < 3; ++k) mesh.triangles[n][k] = as_made.triangles[made][(k + rotation) % 3];
    vectors.push_back({random.uniform(2 * made, -1, 1), random.uniform(2 * made + 1, -1, 1), 0});
    const Vector3 of_made[] = {{0.2, 0.3, 0.5}, {0.6, 0, 0.4}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
      SurfacePoint& start = starts[std::size_t(3 * made + i)];
      start.triangle = n;
      for (int k = 0; k < 3; ++k) start.barycentric[k] = of_made[i][(k + rotation) % 3];
    }
  }
  const Surface surface = make_surface(mesh);
  const TraceMesh walked(surface);
  std::vector<Vector3> ends;
  for (const SurfacePoint& end : follow(walked, field_in_frames(surface, vectors), starts).ends)
    ends.push_back(point_at(surface.mesh, end));
  return ends;
}

template <class Follow>
void expect_same_for_any_numbering(const Follow& follow) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Random random(seed);
    const std::vector<Vector3> wanted = ends_as_numbered(0, 0, random, follow);
    for (int rotation = 0; rotation < 3; ++rotation)
      for (int first = 0; first < 7; ++first) {
        const std::vector<Vector3> found = ends_as_numbered(rotation, first, random, follow);
        for (std::size_t i = 0; i < found.size(); ++i)
          ASSERT_LT((found[i] - wanted[i]).norm(), 1e-9) << seed << ": " << rotation << ", " << first << ", " << i;
      }
  }
}

TEST(Numbering, DoesNotMatterToPathsWithoutSteps) {
  for (const double time : {0.4, 3.0})
    expect_same_for_any_numbering([&](const TraceMesh& mesh, const Vector& field, const auto& starts) {
      return SurfaceFlow::along(mesh, field).trace(starts, time);
    });
}

TEST(Numbering, DoesNotMatterToStraightPaths) {
  for (const double step : {0.3, std::numeric_limits<double>::infinity()})
    expect_same_for_any_numbering([&](const TraceMesh& mesh, const Vector& field, const auto& starts) {
      return straight_paths(mesh, field, starts, 1.7, {.step = step});
    });
}

}  // namespace
}  // namespace mq
