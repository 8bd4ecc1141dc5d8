// What spaces say element by element: gradient norms, conductivities.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/vertex_space.h"

namespace mq {
namespace {

/// 1, and 1 on all elements that have area.
void expect_conductivity_one_is_stiffness(const SignalSpace& space) {
  const Signal psi = test::random_signal(space.size(), 2);
  const std::vector<float> one(std::size_t(space.element_count()), 1.0F);
  EXPECT_LE(
      (space.weighted_stiffness_times(psi, one) - space.stiffness_times(psi)).cwiseAbs().maxCoeff(),
      1e-11);
  const SparseMatrix difference = space.weighted_system(2, 3, one) - space.regularised_system(2, 3);
  EXPECT_EQ(difference.norm(), 0);
}

void expect_conducted_is_its_matrix(const SignalSpace& space) {
  const Signal psi = test::random_signal(space.size(), 2);
  std::vector<float> some(std::size_t(space.element_count()));
  const Random random(3);
  for (std::size_t e = 0; e < some.size(); ++e) some[e] = float(random.uniform(e, 0.5, 2));
  const SparseMatrix S = space.weighted_system(0, 1, some);
  const Signal product = S * psi,
               weighted_stiffness_times = space.weighted_stiffness_times(psi, some);
  // Apart from what `regularised_system` adds at hardly visible texels.
  EXPECT_LE((product - weighted_stiffness_times).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LE((S * Vector::Ones(space.size())).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LE(weighted_stiffness_times.colwise().sum().cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Elements, AddUpToTheStiffness) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    SCOPED_TRACE(cut.name);
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    expect_conductivity_one_is_stiffness(space);
    expect_conducted_is_its_matrix(space);
  }
  const VertexSpace vertices(make_surface(fixtures::torus(20, 12)));
  expect_conductivity_one_is_stiffness(vertices);
  expect_conducted_is_its_matrix(vertices);
}

/// With a label of its own for every unknown all elements that couple any are mixed: together they are S.
TEST(Elements, AndWhatHoldsWeakTexelsAddUpToTheSystem) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    SparseMatrix sum = space.regularised_system(2, 3);
    const double largest = sum.coeffs().abs().maxCoeff();
    space.for_each_summand(2, 3, [&](std::span<const int> unknowns, std::span<const double> values) {
      for (std::size_t i = 0; i < unknowns.size(); ++i)
        for (std::size_t j = 0; j < unknowns.size(); ++j)
          sum.coeffRef(unknowns[i], unknowns[j]) -= values[i * unknowns.size() + j];
    });
    EXPECT_LE(sum.coeffs().abs().maxCoeff(), 1e-13 * largest) << cut.name;
  }
}

TEST(Elements, ThatAreMixedAddUpToTheStiffness) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    SCOPED_TRACE(cut.name);
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    std::vector<int> labels(std::size_t(space.size()));
    std::iota(labels.begin(), labels.end(), 0);
    const Signal psi = test::random_signal(space.size(), 1);
    Signal product = Signal::Zero(space.size(), 1);
    space.for_each_mixed_element(labels, [&](const Element& element) {
      const std::size_t n = element.unknowns.size();
      ASSERT_EQ(element.stiffness.size(), n * n);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          product(element.unknowns[i], 0) += element.stiffness[i * n + j] * psi(element.unknowns[j], 0);
    });
    EXPECT_LE((product - space.stiffness_times(psi)).cwiseAbs().maxCoeff(), 1e-10);
    space.for_each_mixed_element(std::vector<int>(labels.size(), 1), [](const Element&) { ADD_FAILURE() << "one label"; });
  }
}

/// In the order in which elements are counted; those that couple a texel with itself alone are not mixed.
TEST(Elements, KnowTheFirstTexelThatTheyCouple) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    SCOPED_TRACE(cut.name);
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    std::vector<int> labels(std::size_t(space.size())), seen;
    std::iota(labels.begin(), labels.end(), 0);
    space.for_each_mixed_element(
        labels, [&](const Element& element) { seen.push_back(*std::ranges::min_element(element.unknowns)); });
    const std::vector<int> first = space.first_texels();
    ASSERT_EQ(std::ssize(first), space.element_count());
    std::size_t found = 0;
    for (const int texel : first)
      if (found < seen.size() && texel == seen[found]) ++found;
    EXPECT_EQ(found, seen.size());
    EXPECT_LT(*std::ranges::max_element(first), space.size());
  }
}

/// A linear function has one gradient everywhere; elements without area have none.
TEST(Elements, MeasureTheGradientOfALinearFunction) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    SCOPED_TRACE(cut.name);
    if (!cut.apart) continue;
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    Signal psi(space.size(), 2);
    psi << fixtures::sample(cut, space, [](const Vector2& p) { return 3 * p.x(); }),
        fixtures::sample(cut, space, [](const Vector2& p) { return 4 * p.y() + 1; });
    int measured = 0;
    for (const float norm : space.gradient_norms(psi)) {
      if (norm == 0) continue;
      ++measured;
      EXPECT_NEAR(norm, 5, 0.01);
    }
    EXPECT_GT(measured, 0);
  }
}

}  // namespace
}  // namespace mq
