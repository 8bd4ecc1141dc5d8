// Fields taken apart: orthogonal parts that sum to the field, and nothing but what topology allows is left.

#include "mq/fem/hodge_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "atlas/atlas_fixtures.h"
#include "fem/field_product.h"
#include "fem/handlebody.h"
#include "mq/base/random.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using fixtures::product;

/// Random vectors in the planes of triangles.
TangentField noise(const Surface& surface) {
  const Random random(7);
  Vector components(2 * surface.triangle_count());
  for (Eigen::Index i = 0; i < components.size(); ++i) components[i] = random.uniform(std::uint64_t(i)) - 0.5;
  return field_in_space(surface, components);
}

Vector heights(const Surface& surface) {
  Vector values(surface.mesh.vertex_count());
  for (Eigen::Index v = 0; v < values.size(); ++v) {
    const Vector3& p = surface.mesh.positions[std::size_t(v)];
    values[v] = std::sin(2 * p.x()) + p.y() * p.z();
  }
  return values;
}

Mesh holed_square() {
  Mesh mesh = fixtures::flat_square(12, 0.1);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Vector3 m = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
    return (m - Vector3(0.3, 0.3, 0)).norm() < 0.15 || (m - Vector3(0.7, 0.6, 0)).norm() < 0.15;
  });
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  return mesh;
}

std::vector<Mesh> meshes() {
  return {fixtures::cut_sphere(8, {}), fixtures::torus(20, 12), test::handlebody(2, 5), fixtures::flat_square(8, 0.2),
          holed_square()};
}

TEST(HodgeParts, AreOrthogonalAndSumToTheField) {
  for (const Mesh& mesh : meshes()) {
    const Surface surface = make_surface(mesh);
    const TangentField X = noise(surface);
    const HodgeParts parts = hodge_parts(surface, X);
    const double whole = product(surface, X, X);
    EXPECT_NEAR(product(surface, parts.gradient, parts.curl), 0, 1e-12 * whole);
    EXPECT_NEAR(product(surface, parts.gradient, parts.harmonic), 0, 1e-12 * whole);
    EXPECT_NEAR(product(surface, parts.curl, parts.harmonic), 0, 1e-12 * whole);
    for (std::size_t t = 0; t < X.size(); ++t)
      EXPECT_LT((parts.gradient[t] + parts.curl[t] + parts.harmonic[t] - X[t]).norm(), 1e-13);
    EXPECT_GT(product(surface, parts.gradient, parts.gradient), 0.05 * whole);
    EXPECT_GT(product(surface, parts.curl, parts.curl), 0.05 * whole);
  }
}

TEST(HodgeParts, OfAGradientIsThatGradientAndItsPotential) {
  for (const Mesh& mesh : meshes()) {
    const Surface surface = make_surface(mesh);
    Vector u = heights(surface);
    const TangentField X = gradient_field(surface, u);
    const HodgeParts parts = hodge_parts(surface, X);
    const double whole = product(surface, X, X);
    EXPECT_LT(product(surface, parts.curl, parts.curl), 1e-20 * whole);
    EXPECT_LT(product(surface, parts.harmonic, parts.harmonic), 1e-20 * whole);
    u.array() -= u.mean();
    EXPECT_LT((parts.potential - u).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(HodgeParts, OfATurnedGradientThatEndsAtBoundariesIsCurl) {
  const Surface surface = make_surface(fixtures::torus(24, 16));
  TangentField X = gradient_field(surface, heights(surface));
  for (int t = 0; t < surface.triangle_count(); ++t) X[std::size_t(t)] = triangle_normal(surface.mesh, t).cross(X[std::size_t(t)]);
  const HodgeParts parts = hodge_parts(surface, X);
  const double whole = product(surface, X, X);
  EXPECT_LT(product(surface, parts.gradient, parts.gradient), 1e-20 * whole);
  EXPECT_LT(product(surface, parts.harmonic, parts.harmonic), 1e-20 * whole);
  // v at the middles of edges is that of the vertices at their ends.
  const Vector u = heights(surface);
  double mean = 0;
  for (const auto& [i, j] : parts.edges.vertices) mean += (u[i] + u[j]) / 2 / parts.edges.count();
  for (int e = 0; e < parts.edges.count(); ++e) {
    const auto& [i, j] = parts.edges.vertices[std::size_t(e)];
    EXPECT_NEAR(parts.stream[e], (u[i] + u[j]) / 2 - mean, 1e-10);
  }
  EXPECT_EQ(stream_at_vertices(surface, parts).size(), surface.mesh.vertex_count());
}

TEST(HodgeParts, LeaveHarmonicFieldsAloneAndNothingElse) {
  for (const Mesh& mesh : meshes()) {
    const Surface surface = make_surface(mesh);
    const std::vector<TangentField> harmonic = harmonic_fields(surface);
    for (const TangentField& H : harmonic) {
      const HodgeParts parts = hodge_parts(surface, H);
      EXPECT_NEAR(product(surface, parts.harmonic, parts.harmonic), 1, 1e-9);
    }
    // What is left of any field is a combination of them.
    TangentField left = hodge_parts(surface, noise(surface)).harmonic;
    const double before = product(surface, left, left);
    EXPECT_EQ(before > 1e-6, !harmonic.empty()) << before;
    for (const TangentField& H : harmonic) {
      const double share = product(surface, H, left);
      for (std::size_t t = 0; t < left.size(); ++t) left[t] -= share * H[t];
    }
    EXPECT_LT(product(surface, left, left), 1e-16 * std::max(before, 1.0));
  }
}

TEST(HodgeParts, CopeWithComponentsAndTrianglesWithoutArea) {
  Mesh mesh = fixtures::torus(16, 10);
  const Mesh square = fixtures::flat_square(4, 0.2);
  const int offset = mesh.vertex_count();
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  for (const Vector3& p : square.positions) mesh.positions.push_back(p + Vector3(5, 0, 0));
  for (const Triangle& t : square.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  mesh.triangles.push_back({offset, offset, offset + 1});
  const Surface surface = make_surface(mesh);
  const TangentField X = noise(surface);
  const HodgeParts parts = hodge_parts(surface, X);
  EXPECT_NEAR(product(surface, parts.gradient, parts.curl), 0, 1e-12);
  EXPECT_EQ(parts.harmonic.back(), Vector3(0, 0, 0));
  TangentField bad = X;
  bad[3].x() = std::nan("");
  EXPECT_THROW(hodge_parts(surface, bad), InvalidInput);
  bad.pop_back();
  EXPECT_THROW(hodge_parts(surface, bad), InvalidInput);
}

}  // namespace
}  // namespace mq
