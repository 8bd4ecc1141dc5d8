// Borders as published: no differences are asked for between regions, of steps and of slopes alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/fem/image_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/stitch.h"
#include "mq/linear/coupled_pairs.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

constexpr double gradients_alone = ScreenedPoisson::infinite_weight;

std::vector<int> labels_left_of(const SignalSpace& space, double x) {
  std::vector<int> labels;
  for (const Vector3& p : space.positions()) labels.push_back(p.x() < x);
  return labels;
}

Signal across(const SignalSpace& space) {
  Signal psi(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) psi(i, 0) = space.positions()[std::size_t(i)].x();
  return psi;
}

Signal levelled(const SignalSpace& space, const Signal& psi, const std::vector<int>& labels) {
  Stitcher stitcher(space, gradients_alone, labels);
  stitcher.set_borders(Borders::level);
  return stitcher.stitch(psi).signal;
}

/// A ramp loses what it rises by in the column of cells between the regions, h, whatever the step between them was; the
/// rest stays to rounding.
void expect_level(const SignalSpace& space, double border, double h, double tolerance) {
  const std::vector<int> labels = labels_left_of(space, border);
  Signal psi = across(space);
  for (int i = 0; i < space.size(); ++i) psi(i, 0) += 0.3 * labels[std::size_t(i)];
  const Signal found = levelled(space, psi, labels);
  Signal expected = across(space);
  for (int i = 0; i < space.size(); ++i) expected(i, 0) += h * labels[std::size_t(i)];
  const Vector mass = space.lumped_mass();
  const double shift = (mass.transpose() * (found - expected)).sum() / mass.sum();
  EXPECT_LT((found.array() - shift - expected.array()).abs().maxCoeff(), tolerance);
}

TEST(LevelBorders, TakeTheSlopeOfOneColumnOfCells) {
  const VertexSpace vertices(make_surface(fixtures::flat_square(16)));
  expect_level(vertices, 0.49, 1.0 / 16, 1e-6);
  const ImageSpace pixels(24, 10);
  expect_level(pixels, 11, 1, 1e-5);
}

TEST(LevelBorders, AreTheFieldOfThesisLessItsPairsAcross) {
  const fixtures::Cut cut = fixtures::cut("", fixtures::slanted(), {48, 40});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const std::vector<int> labels = labels_left_of(space, 0.4);
  const Signal psi = test::random_signal(space.size(), 2);
  const std::vector<std::array<int, 2>> edges = space.edges();
  Signal z(std::ssize(edges), 2);
  int mixed = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [i, j] = edges[e];
    const bool is_mixed = labels[std::size_t(i)] != labels[std::size_t(j)];
    mixed += is_mixed;
    z.row(Eigen::Index(e)) = is_mixed ? Eigen::RowVector2d::Zero() : Eigen::RowVector2d(psi.row(j) - psi.row(i));
  }
  const Signal expected = space.edge_divergence(edges, z) - space.stiffness_times(psi);
  EXPECT_GT(mixed, 50);
  EXPECT_LT((level_borders(space, space.stiffness(), psi, labels) - expected).norm(), 1e-11 * expected.norm());
}

TEST(LevelBorders, ChangeNothingWhereThereIsOneRegion) {
  const VertexSpace space(make_surface(fixtures::flat_square(8)));
  const Signal psi = test::random_signal(space.size(), 3);
  EXPECT_TRUE(levelled(space, psi, std::vector<int>(std::size_t(space.size()), 4)) == psi);
}

/// Where nothing is seen nothing is asked, so that only the seen parts meet: here they do not, and nothing changes but the
/// fill.
TEST(LevelBorders, SayNothingOfWhatIsUnseen) {
  const VertexSpace space(make_surface(fixtures::flat_square(16)));
  std::vector<int> labels;
  for (const Vector3& p : space.positions()) labels.push_back(p.x() < 0.3 ? 0 : p.x() > 0.6 ? 1 : unseen);
  EXPECT_TRUE(level_borders(space, space.stiffness(), test::random_signal(space.size(), 1), labels).isZero(0));
}

/// Of what is unseen the thesis keeps the values and takes the differences: S·φ is asked for those within regions alone.
TEST(PublishedBorders, SolveTheThesisSystemWithWhatIsUnseen) {
  const ImageSpace space(30, 20);
  std::vector<int> labels;
  for (const Vector3& p : space.positions()) labels.push_back(p.x() < 9 ? 0 : p.x() > 18 ? 1 : unseen);
  const Signal psi = test::random_signal(space.size(), 2);
  const double weight = 5;
  Stitcher stitcher(space, weight, labels, direct_solver(), {}, Stitcher::Systems::one_each);
  stitcher.set_borders(Borders::published);
  const Signal found = stitcher.stitch(psi).signal;

  const SparseMatrix S = space.stiffness();
  std::vector<std::array<int, 2>> edges;
  for_each_coupled_pair(S, [&](int i, int j) { edges.push_back({i, j}); });
  Signal z = Signal::Zero(std::ssize(edges), 2);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [i, j] = edges[e];
    const int label = labels[std::size_t(i)];
    if (label == labels[std::size_t(j)] && label != unseen) z.row(Eigen::Index(e)) = psi.row(j) - psi.row(i);
  }
  const Signal change = space.edge_divergence(edges, z) - S * psi;
  EXPECT_LT((space.system(1, weight) * (found - psi) - weight * change).norm(), 1e-9 * weight * change.norm());
}

TEST(PublishedBorders, AreLevelOnesWhereAllIsSeen) {
  const fixtures::Cut cut = fixtures::cut("", fixtures::slanted(), {32, 28});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const std::vector<int> labels = labels_left_of(space, 0.4);
  const Signal psi = test::random_signal(space.size(), 2);
  Stitcher stitcher(space, 0.01, labels);
  stitcher.set_borders(Borders::level);
  const Signal level = stitcher.stitch(psi).signal;
  stitcher.set_borders(Borders::published);
  EXPECT_LT((stitcher.stitch(psi).signal - level).norm(), 1e-9 * psi.norm());
}

/// Pairs beside a hole would ask of elements that are not there.
TEST(LevelBorders, WantAllSeen) {
  const ImageSpace space(12, 8);
  std::vector<int> labels = labels_left_of(space, 5);
  labels[40] = unseen;
  Stitcher stitcher(space, 1, labels);
  stitcher.set_borders(Borders::level);
  EXPECT_THAT(fixtures::error_of([&] { stitcher.stitch(test::random_signal(space.size(), 1)); }),
              testing::HasSubstr("take published"));
}

}  // namespace
}  // namespace mq
