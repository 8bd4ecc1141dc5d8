// The multigrid cycle of a texel system by itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mq/fem/texel_cycle.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/conjugate_gradients.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

struct CycleModel {
  Surface surface;
  Atlas atlas;
  TexelSpace space;
  SparseMatrix A;

  CycleModel(const Sample& sample, double alpha)
      : surface(make_surface(sample.mesh)),
        atlas(make_atlas(surface, {sample.texture})),
        space(surface, atlas),
        A(space.regularised_system(1, alpha * atlas.surface_area)) {}
};

CycleModel sphere_model() { return {make_sample("sphere", {.texture_size = 96, .triangles = 1200}), 1e-3}; }

Signal waves(Eigen::Index rows, double first) {
  Signal values(rows, 3);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index c = 0; c < 3; ++c) values(i, c) = std::sin(first * double(i) + double(c));
  return values;
}

TEST(TexelCycle, IsSymmetricAndPositive) {
  const CycleModel model = sphere_model();
  const TexelCycle cycle(model.A, model.space.texels());
  const Signal x = waves(model.A.rows(), 0.37), y = waves(model.A.rows(), 1.91);
  Signal Cx, Cy;
  cycle.apply(x, Cx);
  cycle.apply(y, Cy);
  const double xy = Cx.cwiseProduct(y).sum(), yx = Cy.cwiseProduct(x).sum();
  const double xx = Cx.cwiseProduct(x).sum(), yy = Cy.cwiseProduct(y).sum();
  EXPECT_GT(xx, 0);
  EXPECT_GT(yy, 0);
  EXPECT_NEAR(xy, yx, 1e-4 * std::sqrt(xx * yy));
}

TEST(TexelCycle, MakesConjugateGradientsShort) {
  const CycleModel model = sphere_model();
  const TexelCycle cycle(model.A, model.space.texels());
  const Signal B = model.space.stiffness_times(waves(model.A.rows(), 0.37));
  Signal X = Signal::Zero(B.rows(), B.cols());
  const SolveReport report = conjugate_gradients(
      model.A, B, X, [&](const Signal& R, Signal& Z) { cycle.apply(R, Z); }, {.tolerance = 1e-8});
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.cycles, 12);
}

TEST(TexelCycle, HasCoarseFunctionsThatSumToOne) {
  const CycleModel model = sphere_model();
  const TexelCycle cycle(model.A, model.space.texels());
  for (const double share : {0.5, 0.1, 0.02}) {
    int rows = 0, largest = 0;
    const int columns = cycle.for_each_interpolated(share, [&](int row, std::span<const WeightedIndex> terms) {
      EXPECT_EQ(row, rows++);
      double sum = 0;
      for (std::size_t k = 0; k < terms.size(); ++k) {
        sum += double(terms[k].weight);
        EXPECT_GT(terms[k].weight, 0);
        if (k > 0) {
          EXPECT_LT(terms[k - 1].index, terms[k].index);
        }
        largest = std::max(largest, terms[k].index);
      }
      EXPECT_NEAR(sum, 1, 1e-5);
    });
    EXPECT_EQ(rows, cycle.rows());
    EXPECT_LT(columns, std::max(share * rows, MultigridOptions().coarsest_rows + 1.0));
    EXPECT_LT(largest, columns);
  }
}

}  // namespace
}  // namespace mq
