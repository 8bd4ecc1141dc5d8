#include "mq/filter/fill_unseen.h"

#include <gtest/gtest.h>

#include "mq/base/error.h"
#include "mq/fem/vertex_space.h"

namespace mq {
namespace {

/// A flat square of n × n squares, and beside it another one.
Mesh two_squares(int n) {
  Mesh mesh;
  for (int part = 0; part < 2; ++part) {
    const int first = mesh.vertex_count();
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) mesh.positions.emplace_back(x + 2.0 * n * part, y, 0);
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const int v = first + y * (n + 1) + x;
        mesh.triangles.push_back({v, v + 1, v + n + 2});
        mesh.triangles.push_back({v, v + n + 2, v + n + 1});
      }
  }
  return mesh;
}

TEST(FillUnseen, IsHarmonicAndKeepsWhatIsKnownToTheBit) {
  const Surface surface = make_surface(two_squares(8));
  const VertexSpace space(surface);
  Signal linear(space.size(), 2), psi;
  std::vector<char> known(space.size(), 1);
  for (int v = 0; v < space.size(); ++v) {
    const Vector3& p = surface.mesh.positions[v];
    linear.row(v) << 0.1 + 0.05 * p.x() - 0.03 * p.y(), 0.3;
    known[v] = std::abs(p.x() - 4) > 2 || std::abs(p.y() - 4) > 2 ? 1 : 0;
  }
  psi = linear;
  for (int v = 0; v < space.size(); ++v)
    if (!known[v]) psi.row(v).setConstant(0.9);
  const Signal filled = fill_unseen(space, known, psi);
  EXPECT_LT((filled - linear).cwiseAbs().maxCoeff(), 1e-6);
  for (int v = 0; v < space.size(); ++v)
    if (known[v]) {
      EXPECT_EQ(filled.row(v), psi.row(v));
    }
}

TEST(FillUnseen, LeavesAPieceOfWhichNothingIsKnownAsItWas) {
  const VertexSpace space(make_surface(two_squares(3)));
  Signal psi = Signal::Constant(space.size(), 1, 0.25);
  std::vector<char> known(space.size(), 1);
  for (int v = space.size() / 2; v < space.size(); ++v) known[v] = 0, psi(v, 0) = 0.75;
  const Signal filled = fill_unseen(space, known, psi);
  EXPECT_LT((filled - psi).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(FillUnseen, WantsToKnowOfEveryUnknown) {
  const VertexSpace space(make_surface(two_squares(2)));
  EXPECT_THROW(fill_unseen(space, std::vector<char>(3), Signal::Zero(space.size(), 1)),
               InvalidInput);
}

}  // namespace
}  // namespace mq
