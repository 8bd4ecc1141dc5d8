// Paths on real meshes: open, cut, with slivers and triangles without area.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "fixtures.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/trace/detail/straight_paths.h"
#include "mq/trace/surface_flow.h"
#include "places.h"

namespace mq {
namespace {

std::vector<std::filesystem::path> meshes() {
  std::vector<std::filesystem::path> paths;
  std::error_code ignored;
  for (const char* folder : {"A_textured", "C_untextured", "B_sequences/gears_tvm"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             places::data() / folder, ignored))
      if (entry.path().extension() == ".obj" || entry.path().extension() == ".ply")
        paths.push_back(entry.path());
  std::ranges::sort(paths);
  return paths;
}

/// Waves over the whole mesh with noise from vertex to vertex.
Vector rough_potential(const Mesh& mesh, double diagonal, double noise) {
  Vector P(mesh.vertex_count());
  const Random random(5);
  for (int v = 0; v < P.size(); ++v) {
    const Vector3 p = mesh.positions[v] * (20 / diagonal);
    P[v] = std::sin(p.x()) + std::cos(p.y()) * std::sin(0.7 * p.z()) +
           noise * random.uniform(std::uint64_t(v));
  }
  return P;
}

double at(const Mesh& mesh, const Vector& P, const SurfacePoint& p) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += p.barycentric[k] * P[mesh.triangles[p.triangle][k]];
  return sum;
}

TEST(RealMeshes, LetPathsFallToRestAndNeverLeaveThem) {
  const auto paths = meshes();
  if (paths.empty()) GTEST_SKIP() << "no test data in " << places::data();
  int walked = 0;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.string());
    const Surface surface =
        make_surface(read_model(path, {{}, ReadModelOptions::Pictures::skip}).mesh);
    const Mesh& mesh = surface.mesh;
    const Box box = bounding_box(mesh);
    const TraceMesh trace(surface);
    for (const double noise : {0.0, 1e-9, 0.5}) {
      const Vector P = rough_potential(mesh, box.diagonal(), noise);
      const Traced traced =
          SurfaceFlow::downhill(trace, P).trace_vertices(std::numeric_limits<double>::infinity());
      EXPECT_EQ(traced.counts.cut_short, 0);
      for (int v = 0; v < mesh.vertex_count(); ++v) {
        const SurfacePoint& end = traced.ends[v];
        if (end.triangle < 0) continue;
        ASSERT_TRUE(end.barycentric.allFinite());
        ASSERT_LE(at(mesh, P, end), P[v] + 1e-15 * std::abs(P[v]));
        // At a vertex, or where P does not change along an edge.
        if (end.barycentric.maxCoeff() == 1) continue;
        const Triangle& t = mesh.triangles[end.triangle];
        int equal = 0;
        for (int k = 0; k < 3; ++k)
          equal += end.barycentric[k] == 0 && P[t[(k + 1) % 3]] == P[t[(k + 2) % 3]];
        ASSERT_EQ(equal, 1);
      }
    }
    // Any other field: finite for a finite time.
    std::vector<Vector3> wind(mesh.triangles.size(), Vector3(0.3, 1, -0.2));
    const Vector field = field_in_frames(surface, wind);
    std::vector<SurfacePoint> starts;
    for (int t = 0; t < surface.triangle_count(); t += 7) starts.push_back({t, {0.2, 0.3, 0.5}});
    const double time = 0.2 * box.diagonal();
    const Traced exact = SurfaceFlow::along(trace, field).trace(starts, time);
    const Traced straight =
        straight_paths(trace, field, starts, time, {.step = trace.mean_edge_length()});
    for (const Traced* traced : {&exact, &straight})
      for (const SurfacePoint& end : traced->ends) {
        ASSERT_TRUE(end.barycentric.allFinite());
        ASSERT_GE(end.barycentric.minCoeff(), 0);
        ASSERT_NEAR(end.barycentric.sum(), 1, 1e-12);
      }
    ++walked;
  }
  EXPECT_GT(walked, 15);
}

}  // namespace
}  // namespace mq
