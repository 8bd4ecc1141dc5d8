// What a step of flow makes less, each term by its closed form or worked out another way, so that no factor can be
// wrong in one of them (4.23).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "flow/moved_texture.h"
#include "mq/fem/edges.h"
#include "mq/fem/vector_basis.h"
#include "mq/flow/surface_systems.h"

namespace mq {
namespace {

using fixtures::Pair;
using std::numbers::pi;

/// A solver of a basis for pairs on the unit sphere.
struct OnSphere {
  explicit OnSphere(FlowBasis basis, const std::optional<ThesisFlow>& thesis = {})
      : pair(fixtures::moved(fixtures::sphere(4, fixtures::icosahedron()), 2, fixtures::rotation(0.1, Vector3(0.2, 0.3, 1)))),
        mesh(pair.surface), solver(mesh, basis, thesis) {}

  DataTerms data() const { return data_terms(mesh.space(), pair.target - pair.source, pair.source); }

  Pair pair;
  FlowMesh mesh;
  DirectFlowSolver solver;
};

Vector3 circumcentre(const Mesh& mesh, int t) {
  const Vector3 a = mesh.position(t, 1) - mesh.position(t, 0), b = mesh.position(t, 2) - mesh.position(t, 0), n = a.cross(b);
  return mesh.position(t, 0) + (a.squaredNorm() * b.cross(n) + b.squaredNorm() * n.cross(a)) / (2 * n.squaredNorm());
}

/// X = e_z × p on the unit sphere, a Killing field: ∫ |∇X|² = ∫ K|X|² = 8π/3 (Bochner), of which forms and gradients
/// with their ∫ (div X)² + (curl X)² = ∫ |∇X|² + K|X|² have twice as much.
TEST(FlowEnergy, OfARotationOfTheSphereIsKnown) {
  const double truth = 8 * pi / 3;
  for (const FlowBasis basis : fixtures::bases) {
    const OnSphere on(basis);
    const Mesh& m = on.pair.surface.mesh;
    const std::vector<FlatTriangle>& shapes = on.mesh.space().shapes();
    Vector x = Vector::Zero(on.solver.size());
    if (basis == FlowBasis::vertex) {
      for (int v = 0; v < m.vertex_count(); ++v) {
        const Vector3 X = fixtures::around_z(m.positions[std::size_t(v)]), &n = on.mesh.normal(v), &a = on.mesh.axis(v);
        x.segment<2>(2 * std::int64_t(v)) = Vector2(X.dot(a), X.dot(n.cross(a)));
      }
    } else if (basis == FlowBasis::triangle) {
      for (int t = 0; t < m.triangle_count(); ++t) {
        const Vector3 first = (m.position(t, 1) - m.position(t, 0)).normalized(),
                      normal = first.cross(m.position(t, 2) - m.position(t, 0)).normalized(),
                      X = fixtures::around_z(circumcentre(m, t));
        ASSERT_LT(std::abs(shapes[std::size_t(t)].corner(1).y()), 1e-12);
        x.segment<2>(2 * std::int64_t(t)) = Vector2(X.dot(first), X.dot(normal.cross(first)));
      }
    } else if (basis == FlowBasis::gradient) {
      for (int v = 0; v < m.vertex_count(); ++v) x[m.vertex_count() + v] = m.positions[std::size_t(v)].z();  // X = J∇z
    } else {
      const Edges edges = make_edges(on.pair.surface, shapes);
      for (int e = 0; e < edges.count(); ++e) {
        const Vector3 &from = m.positions[std::size_t(edges.vertices[std::size_t(e)][0])],
                      &to = m.positions[std::size_t(edges.vertices[std::size_t(e)][1])];
        x[e] = fixtures::around_z((from + to) / 2).dot(to - from);
      }
    }
    const bool forms = basis == FlowBasis::gradient || basis == FlowBasis::whitney;
    EXPECT_NEAR(on.solver.smoothness_energy(x) / (forms ? 2 * truth : truth), 1, 0.01) << int(basis);
    if (basis == FlowBasis::vertex) {
      EXPECT_NEAR(smoothness_energy(on.mesh, x) / truth, 1, 0.01);
    }
  }
}

/// What each triangle's share of the smoothness adds to the matrix is what it adds to the energy.
TEST(FlowEnergy, IsThatOfTheMatrixWhateverTheTrianglesShares) {
  const Pair pair = fixtures::moved(fixtures::sphere(2, fixtures::icosahedron()), 2, fixtures::rotation(0.1, Vector3(0.2, 0.3, 1)));
  const FlowMesh mesh(pair.surface);
  const DataTerms data = data_terms(mesh.space(), pair.target - pair.source, pair.source);
  const Random random(8);
  std::vector<double> shares;
  for (int t = 0; t < pair.surface.triangle_count(); ++t) shares.push_back(random.uniform(std::uint64_t(t), 0.1, 2));
  Vector z(2 * mesh.vertex_count());
  for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = random.uniform(std::uint64_t(1000 + i), -1, 1);
  const double weight = 3 * data.trace;
  const auto energy = [&](double w, const std::vector<double>& of) {
    return z.dot(scalar_matrix(vertex_system(mesh, data, w, of).matrix) * z);
  };
  for (const std::vector<double>& of : {std::vector<double>{}, shares}) {
    const double smoothness = weight * smoothness_energy(mesh, z, of);
    EXPECT_NEAR((energy(weight, of) - energy(0, of)) / smoothness, 1, 1e-3);
    EXPECT_NEAR((energy(2 * weight, of) - energy(weight, of)) / smoothness, 1, 1e-3);
  }
}

/// At the least D·Y + w·S·Y + d = 0, so that −⟨d, Y⟩ = ⟨Y, D·Y⟩ + w·⟨Y, S·Y⟩.
TEST(FlowEnergy, IsLeastWhereItsTermsBalanceInEveryBasis) {
  for (const FlowBasis basis : fixtures::bases) {
    OnSphere on(basis);
    const DataTerms data = on.data();
    for (const double length : {0.03, 0.3}) {
      const double weight = length * length * data.trace / on.mesh.area();
      const auto [linear, quadratic] = data.products(on.solver.solve(data, weight));
      const double smoothness = weight * on.solver.smoothness_energy(on.solver.coefficients());
      EXPECT_GT(smoothness, -0.01 * linear) << int(basis);
      EXPECT_GT(quadratic, -0.01 * linear) << int(basis);
      // Potentials are held, by their pins, a little more than the others.
      EXPECT_NEAR((quadratic + smoothness) / -linear, 1, basis == FlowBasis::gradient ? 2e-3 : 1e-4) << int(basis);
      EXPECT_NEAR(on.solver.smoothness_term() / smoothness, 1, 1e-12) << int(basis);
    }
  }
}

/// The thesis weighs smoothness by ½ε‖D‖, on a surface of area 1.
TEST(FlowEnergy, HasHalfOfEpsilonTimesTheNormOfDForTheThesis) {
  const ThesisFlow thesis{.epsilon = 300};
  OnSphere on(FlowBasis::gradient, thesis);
  const DataTerms data = on.data();
  on.solver.solve(data, 1);
  // D of potentials on the surface scaled to area 1: gradients are longer by √area, integrals smaller by area.
  const SparseMatrix P = gradient_prolongation(on.mesh.space());
  std::vector<Eigen::Triplet<double>> entries;
  for (int t = 0; t < int(data.triangles.size()); ++t) {
    const DataTerms::Triangle& G = data.triangles[std::size_t(t)];
    entries.emplace_back(2 * t, 2 * t, G.xx);
    entries.emplace_back(2 * t, 2 * t + 1, G.xy);
    entries.emplace_back(2 * t + 1, 2 * t, G.xy);
    entries.emplace_back(2 * t + 1, 2 * t + 1, G.yy);
  }
  SparseMatrix G(P.rows(), P.rows());
  G.setFromTriplets(entries.begin(), entries.end());
  const double norm = SparseMatrix(P.transpose() * G * P).norm() * on.mesh.area();
  EXPECT_NEAR(on.solver.smoothness_term() / on.solver.smoothness_energy(on.solver.coefficients()) / (150 * norm), 1, 1e-9);
}

/// At every level of a flow the energy falls by Y, and Y balances both terms, so that α* = −⟨d, Y⟩ / ⟨Y, D·Y⟩ follows from
/// what they changed: with b = −⟨d, Y⟩ = q + s the data's change is q − 2b and α* = b/q. (By α*·Y, which is the least of
/// the data's term alone, the sum E changes by α*(α* − 2)·b: it rises where α* > 2, at large lengths.)
void expect_fall(const MeshFlow& flow, double tolerance, const std::string& what) {
  ASSERT_GT(flow.levels.size(), 2U) << what;
  for (const MeshFlowLevel& level : flow.levels) {
    const auto [data, smoothness] = level.change;
    EXPECT_LT(data, 0) << what;
    EXPECT_GT(smoothness, 0) << what;
    EXPECT_GE(level.scale, 1 - 1e-3) << what;
    EXPECT_NEAR(level.scale * (data + 2 * smoothness) / (data + smoothness), 1, tolerance) << what << level.length;
    EXPECT_LT(data + smoothness, 0) << what << level.length;
    EXPECT_GT(level.smoothness, 0) << what;
  }
}

/// The same rotation in texels.
TEST(FlowEnergy, OfARotationOfTheSphereIsKnownInTexels) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  for (const int side : {1, 2}) {
    const auto model = fixtures::textured(fixtures::cut_sphere(32 * side, cut), {{200 * side, 150 * side}});
    const TexelSpace space(model->surface, model->atlas);
    const TexelVectorSpace vectors(model->surface, model->atlas, space);
    Vector z(2 * space.size());
    for (int i = 0; i < space.size(); ++i) {
      const Vector3 X = fixtures::around_z(space.texels().position(i));
      const TangentPlane plane = vectors.plane(i);
      z.segment<2>(2 * std::int64_t(i)) = Vector2(X.dot(plane.first), X.dot(plane.second));
    }
    const double truth = 8 * pi / 3, energy = vectors.smoothness_energy(z);
    EXPECT_NEAR(energy / truth, 1, 0.02 / (side * side));
    const BlockMatrix<double> L = vectors.system(0, 1);
    double product = 0;
    for (int i = 0; i < L.rows(); ++i)
      for (int e = L.starts[std::size_t(i)]; e < L.starts[std::size_t(i) + 1]; ++e) {
        const std::array<double, 4>& block = L.blocks[std::size_t(e)];
        const auto a = z.segment<2>(2 * std::int64_t(i)), b = z.segment<2>(2 * std::int64_t(L.columns[std::size_t(e)]));
        product += a[0] * (block[0] * b[0] + block[1] * b[1]) + a[1] * (block[2] * b[0] + block[3] * b[1]);
      }
    EXPECT_NEAR(product / energy, 1, 1e-5);
    const std::vector<float> half(std::size_t(space.element_count()), 0.5F);
    EXPECT_NEAR(vectors.smoothness_energy(z, half) / energy, 0.5, 1e-12);
  }
}

TEST(FlowEnergy, FallsAtEveryLevelInEveryBasis) {
  const Pair pair = fixtures::turned_torus(3);
  expect_fall(mesh_flow(pair.surface, pair.source, pair.target, fixtures::from(12)), 0.02, "multigrid ");
  for (const FlowBasis basis : fixtures::bases) {
    MeshFlowOptions options = fixtures::from(12);
    options.solver = FlowSolver::direct;
    options.basis = basis;
    expect_fall(mesh_flow(pair.surface, pair.source, pair.target, options), 0.02, fmt::format("basis {} ", int(basis)));
  }
}

TEST(FlowEnergy, FallsAtEveryLevelInTexels) {
  const auto cut = fixtures::turned(fixtures::odd_angle, 2);
  const Mesh mesh = fixtures::cut_torus({.cells = 48, .parts = 2, .jitter = 0, .scale = cut.scale, .angle = cut.angle,
                                         .shift = cut.shift});
  const fixtures::MovedTexture moved(mesh, {160, 160}, 2, fixtures::rotation(0.1, Vector3::UnitZ()));
  const TextureFlow flow(moved.model->surface, moved.model->atlas, moved.space, moved.source, moved.target,
                         fixtures::up_to(8));
  expect_fall(flow.flow(), 0.03, "texels ");
}

}  // namespace
}  // namespace mq
