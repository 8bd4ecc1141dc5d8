// Fields of least order on edges: of differences they are the gradient, of anything else what points in the middle of
// triangles say.
#include <gtest/gtest.h>

#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/coupled_pairs.h"
#include "fem/cut_squares.h"

namespace mq {
namespace {

using Pairs = std::vector<std::array<int, 2>>;

Pairs coupled_pairs(const SignalSpace& space) {
  Pairs pairs;
  for_each_coupled_pair(space.stiffness(), [&](int i, int j) { pairs.push_back({i, j}); });
  return pairs;
}

Signal differences_along(const Pairs& pairs, const Signal& psi) {
  Signal z(std::ssize(pairs), psi.cols());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    z.row(Eigen::Index(k)) = psi.row(pairs[k][1]) - psi.row(pairs[k][0]);
  return z;
}

TEST(EdgeDivergence, OfDifferencesIsTheStiffnessTimesTheSignal) {
  const VertexSpace space(make_surface(fixtures::torus(20, 12)));
  const Signal psi = test::random_signal(space.size(), 2);
  const Pairs pairs = coupled_pairs(space);
  const Signal expected = space.stiffness_times(psi);
  EXPECT_LT((space.edge_divergence(pairs, differences_along(pairs, psi)) - expected).norm(), 1e-13 * expected.norm());
}

/// ω is linear on a triangle and ∇φ constant, so that its value in the middle is all that counts:
/// ⅓ Σ z_ij (∇φ_j − ∇φ_i). Pairs that are left out are 0.
TEST(EdgeDivergence, IntegratesTheFieldInTheMiddleOfTriangles) {
  const VertexSpace space(make_surface(fixtures::torus(20, 12)));
  Pairs pairs = coupled_pairs(space);
  std::erase_if(pairs, [](const auto& pair) { return (pair[0] + pair[1]) % 3 == 0; });
  const Signal z = test::random_signal(int(pairs.size()), 1);
  Signal field = Signal::Zero(2 * space.triangle_count(), 1);
  for (int t = 0; t < space.triangle_count(); ++t)
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const std::array<int, 2> pair{space.triangles()[std::size_t(t)][a], space.triangles()[std::size_t(t)][b]};
        const auto at = std::ranges::find(pairs, pair);
        if (at == pairs.end()) continue;
        const FlatTriangle& shape = space.shapes()[std::size_t(t)];
        field.middleRows(2 * t, 2) += z(at - pairs.begin(), 0) / 3 * (shape.gradient(b) - shape.gradient(a));
      }
  const Signal expected = space.gradient_moments(field), found = space.edge_divergence(pairs, z);
  EXPECT_GT(expected.norm(), 1);
  EXPECT_LT((found - expected).norm(), 1e-13 * expected.norm());
  EXPECT_LT(std::abs(found.sum()), 1e-12);
}

/// Fields add up: of half the pairs and of the other half.
TEST(EdgeDivergence, OfSomePairsOfTexelsIsTheirPartOfTheWhole) {
  const fixtures::Cut cut = fixtures::cut("", fixtures::slanted(), {48, 40});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 2);
  Pairs some = space.edges(), others;
  std::erase_if(some, [&](const auto& pair) {
    if ((pair[0] + pair[1]) % 3 > 0) return false;
    others.push_back(pair);
    return true;
  });
  const Signal sum = space.edge_divergence(some, differences_along(some, psi)) +
                     space.edge_divergence(others, differences_along(others, psi));
  const Signal expected = space.stiffness_times(psi);
  EXPECT_GT(std::ssize(others), 1000);
  EXPECT_LT((sum - expected).norm(), 1e-11 * expected.norm());
}

}  // namespace
}  // namespace mq
