// A surface in triangles of one size: its area and topology, how far apart vertices are, values taken from it.

#include "mq/fem/evenly_spaced_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "mq/base/error.h"
#include "mq/mesh/components.h"

namespace mq {
namespace {

using std::numbers::pi;

std::vector<double> edge_lengths(const VertexSpace& space, const SparseMatrix& S) {
  const auto places = space.positions();
  std::vector<double> lengths;
  for (int i = 0; i < S.rows(); ++i)
    for (SparseMatrix::InnerIterator it(S, i); it; ++it)
      if (it.col() > i) lengths.push_back((places[std::size_t(i)] - places[std::size_t(it.col())]).norm());
  std::ranges::sort(lengths);
  return lengths;
}

/// Of triangles both much smaller and much larger than asked for.
TEST(EvenlySpacedSurface, PutsVerticesAboutAsFarApartAsAsked) {
  for (const auto& [around, along] : {std::pair{200, 120}, {12, 8}, {300, 10}}) {
    const Surface surface = make_surface(fixtures::torus(around, along));
    const double spacing = 0.06 * std::sqrt(surface.area / (4 * pi));
    const EvenlySpacedSurface even(surface, spacing);
    const std::vector<double> lengths = edge_lengths(even.space(), even.space().stiffness());
    EXPECT_NEAR(lengths[lengths.size() / 2], spacing, 0.35 * spacing) << around << " × " << along;
    EXPECT_LT(lengths[lengths.size() * 98 / 100], 1.8 * spacing) << around << " × " << along;
    EXPECT_GT(lengths[lengths.size() * 2 / 100], 0.4 * spacing) << around << " × " << along;
    const double expected = EvenlySpacedSurface::expected_size(surface, spacing);
    EXPECT_NEAR(even.space().size(), expected, 0.5 * expected) << around << " × " << along;
    EXPECT_NEAR(even.space().scale().area, surface.area, 0.02 * surface.area);
  }
}

TEST(EvenlySpacedSurface, GivesValuesToTheSquareOfTheSpacing) {
  const auto model = fixtures::textured(fixtures::cut_square(fixtures::turned(fixtures::odd_angle)), {{128, 128}});
  const TexelSpace texels(model->surface, model->atlas);
  const std::vector<Vector3> places = fixtures::places_of(texels);
  const auto wave = [](const Vector3& p) { return std::cos(pi * p.x()) * std::cos(2 * pi * p.y()); };
  std::vector<double> errors;
  for (const double spacing : {0.08, 0.04, 0.02}) {
    const EvenlySpacedSurface even(model->surface, spacing);
    const std::vector<Vector3> vertices = even.space().positions();
    Signal values(std::ssize(vertices), 2);
    for (std::size_t v = 0; v < vertices.size(); ++v) values.row(Eigen::Index(v)) << wave(vertices[v]), 1;
    const Signal found = even.at({places, {}}, values);
    double sum = 0, mass = 0;
    const Vector weights = texels.lumped_mass();
    for (std::size_t i = 0; i < places.size(); ++i) {
      sum += std::abs(weights[Eigen::Index(i)]) * std::pow(found(Eigen::Index(i), 0) - wave(places[i]), 2);
      mass += std::abs(weights[Eigen::Index(i)]);
    }
    errors.push_back(std::sqrt(sum / mass));
    EXPECT_LE((found.col(1).array() - 1).abs().maxCoeff(), 1e-9);
  }
  EXPECT_LT(errors.back(), 3e-3);
  EXPECT_GT(std::log2(errors[0] / errors[2]), 3.2);
}

/// Two squares one on the other, in different triangles: each keeps its own values, and a place of neither has those of one.
TEST(EvenlySpacedSurface, TellsComponentsApartThatLieOnEachOther) {
  Mesh mesh;
  for (int sheet = 0; sheet < 2; ++sheet) {
    const int first = int(mesh.positions.size());
    for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)}) mesh.positions.push_back(p);
    for (const Triangle& t : sheet == 0 ? std::array{Triangle{0, 1, 2}, Triangle{0, 2, 3}}
                                        : std::array{Triangle{0, 1, 3}, Triangle{1, 2, 3}})
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  const Surface surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  const std::vector<int> components = triangle_components(surface);
  ASSERT_EQ(components, (std::vector{0, 0, 2, 2}));
  const EvenlySpacedSurface even(surface, 0.05);
  ASSERT_EQ(std::ssize(even.components()), even.space().size());
  Signal values(even.space().size(), 1);
  for (int v = 0; v < even.space().size(); ++v) values(v, 0) = even.components()[std::size_t(v)];
  const std::vector<Vector3> points(4, Vector3(0.3, 0.7, 0));
  const Signal found = even.at({points, std::array{0, 2, 2, -1}}, values);
  EXPECT_NEAR(found(0, 0), 0, 1e-12);
  EXPECT_NEAR(found(1, 0), 2, 1e-12);
  EXPECT_NEAR(found(2, 0), 2, 1e-12);
  EXPECT_TRUE(found(3, 0) < 1e-12 || found(3, 0) > 2 - 1e-12);
  EXPECT_THROW(even.at({points, std::array{0, 1, 2, 2}}, values), InvalidInput);
}

TEST(EvenlySpacedSurface, RefusesASpacingOfNothing) {
  const Surface surface = make_surface(fixtures::torus(8, 6));
  EXPECT_THROW(EvenlySpacedSurface(surface, 0), InvalidInput);
  EXPECT_THROW(EvenlySpacedSurface(surface, -1), InvalidInput);
  const EvenlySpacedSurface even(surface, 0.5);
  EXPECT_THROW(even.at({}, Signal::Zero(3, 1)), InvalidInput);
}

}  // namespace
}  // namespace mq
