#include "mq/linear/stencil_rows.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "fem/cut_squares.h"
#include "fem/patchwork.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/fem/grid_levels.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/galerkin.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::cut_squares;

Signal random_values(int rows, int columns) {
  Signal values(rows, columns);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = Random(3).uniform(int(i), 0, 1);
  return values;
}

bool has_pattern_of(const SparseMatrix& A, const SparseMatrix& B) {
  return A.rows() == B.rows() && A.nonZeros() == B.nonZeros() &&
         std::equal(A.outerIndexPtr(), A.outerIndexPtr() + A.rows() + 1, B.outerIndexPtr()) &&
         std::equal(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros(), B.innerIndexPtr());
}

/// A larger texture, so that there are stencils beside everything that is none.
std::unique_ptr<fixtures::Textured> charts() {
  return fixtures::textured(fixtures::cut_square(fixtures::turned(fixtures::odd_angle, 3)), {{160, 160}});
}

// Cuts of the small textures leave hardly any stencil, some none at all; all kinds of texels are among them, weak ones too.
TEST(StencilSystem, IsTheRegularisedMatrix) {
  int stencils = 0;
  std::vector<Cut> all = cut_squares();
  all.push_back(fixtures::cut("three charts", fixtures::turned(fixtures::odd_angle, 3), {160, 160}));
  for (const Cut& cut : all) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const SparseMatrix expected = space.regularised_system(1, 1e-2);
    const auto system = space.stencil_system(1, 1e-2);
    ASSERT_TRUE(system) << cut.name;
    const SparseMatrix found = system->matrix();
    ASSERT_TRUE(has_pattern_of(found, expected)) << cut.name;
    EXPECT_EQ(system->rows.entries(), expected.nonZeros());
    EXPECT_LE((found - expected).norm(), 1e-15 * expected.norm()) << cut.name;
    EXPECT_EQ(system->layout.irregular, make_layout(expected, space.texels()).irregular) << cut.name;
    stencils += int(system->layout.runs.size());
  }
  EXPECT_GT(stencils, 1000);
}

TEST(StencilSystem, HasTheSameBitsForAnyNumberOfThreads) {
  const auto model = charts();
  const TexelSpace space(model->surface, model->atlas);
  const SparseMatrix reference = space.stencil_system(1, 1e-3)->matrix();
  for (const int threads : {1, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const SparseMatrix A = space.stencil_system(1, 1e-3)->matrix();
    EXPECT_TRUE(std::equal(A.valuePtr(), A.valuePtr() + A.nonZeros(), reference.valuePtr())) << threads;
  }
}

TEST(StencilRows, ListClusteredRowsBesideTheIrregular) {
  const auto model = charts();
  const TexelSpace space(model->surface, model->atlas);
  auto [layout, rows] = *space.stencil_system(1, 1e-2);
  const SparseMatrix all = rows.matrix(layout);
  for (std::size_t r = 0; r < layout.runs.size(); r += 7) layout.clustered.push_back(layout.runs[r].first);
  std::ranges::sort(layout.clustered);
  ASSERT_GT(layout.clustered.size(), 10U);
  rows.list_clustered(layout);
  for (int p = 0; p < layout.listed_count(); ++p) {
    const int k = layout.listed(p);
    EXPECT_EQ(Vector(rows.listed().row(k).transpose()), Vector(all.row(k).transpose())) << k;
  }
  EXPECT_EQ(rows.listed().nonZeros() + 9 * (space.size() - layout.listed_count()), all.nonZeros());
  EXPECT_TRUE(has_pattern_of(rows.matrix(layout), all));
}

TEST(StencilRows, HaveTheGalerkinProductOfTheirMatrix) {
  const auto model = charts();
  const TexelSpace space(model->surface, model->atlas);
  const auto system = space.stencil_system(1, 1e-2);
  const SparseMatrix A = system->matrix();
  const GridCoarsening grid =
      coarsen_grid(space.texels(), std::vector<GridStep>(std::size_t(space.texels().chart_count())));
  const SparseMatrix found = galerkin(system->rows, system->layout, *grid.transfer),
                     expected = galerkin(A, *grid.transfer);
  ASSERT_TRUE(has_pattern_of(found, expected));
  EXPECT_LE((found - expected).norm(), 1e-15 * expected.norm());
}

TEST(StencilRows, OfAMatrixHaveItsRows) {
  const auto p = fixtures::make_patchwork({.size = 70, .charts = 3});
  const SparseMatrix A = p.system(1, 1e-3);
  const StencilLayout layout = make_layout(A, p.texels);
  const SparseMatrix found = StencilRows(A, layout).matrix(layout);
  ASSERT_TRUE(has_pattern_of(found, A));
  EXPECT_LE((found - A).norm(), 1e-15 * A.norm());
}

TEST(StencilSystem, IsSolvedAsItsMatrixIs) {
  const auto model = charts();
  const TexelSpace space(model->surface, model->atlas);
  const SolverFactory multigrid = space.multigrid({.tolerance = 1e-9});
  ASSERT_TRUE(multigrid.takes_stencils());
  const Signal B = random_values(space.size(), 3);
  std::unique_ptr<LinearSolver> solver = multigrid(*space.stencil_system(1, 1e-3), {});
  for (const double w : {1e-3, 1e-4}) {
    if (w == 1e-4) solver->take(*space.stencil_system(1, w));
    Signal X = Signal::Zero(B.rows(), B.cols()), Y = X;
    EXPECT_TRUE(solver->solve(B, X).converged);
    EXPECT_TRUE(multigrid(space.regularised_system(1, w), {})->solve(B, Y).converged);
    EXPECT_LE((X - Y).cwiseAbs().maxCoeff(), 1e-8 * Y.cwiseAbs().maxCoeff());
    EXPECT_LE((space.regularised_system(1, w) * X - B).norm(), 1e-8 * B.norm());
  }
  EXPECT_THROW(solver->take(*TexelSpace(model->surface, model->atlas, {.seams = TexelSpaceOptions::Seams::soft})
                                 .stencil_system(1, 1e-3)),
               InvalidInput);
}

TEST(TexelSpace, LetsGoOfItsIntegralsAndTexelsAndHasThemAgain) {
  const auto model = charts();
  const TexelSpace space(model->surface, model->atlas);
  const Signal psi = random_values(space.size(), 3);
  const Signal product = space.stiffness_times(psi);
  const SparseMatrix A = space.regularised_system(1, 1e-3);
  const std::vector<Vector3> positions = space.positions();
  const std::vector<int> charts_of_texels = space.texels().chart, boundary = space.boundary();
  const std::int64_t before = space.bytes();
  const auto expect_as_before = [&] {
    EXPECT_EQ(space.bytes(), before);
    EXPECT_EQ(space.stiffness_times(psi), product);
    const SparseMatrix again = space.regularised_system(1, 1e-3);
    ASSERT_EQ(again.nonZeros(), A.nonZeros());
    EXPECT_TRUE(std::equal(A.valuePtr(), A.valuePtr() + A.nonZeros(), again.valuePtr()));
    EXPECT_EQ(space.positions(), positions);
    EXPECT_EQ(space.texels().chart, charts_of_texels);
    EXPECT_EQ(space.boundary(), boundary);
  };
  space.let_go_of_integrals();
  EXPECT_LT(double(space.bytes()), 0.4 * double(before));
  EXPECT_EQ(space.positions(), positions);
  EXPECT_THROW((void)space.stiffness_times(psi), InvalidInput);
  EXPECT_THROW((void)space.system(1, 0), InvalidInput);
  EXPECT_THROW((void)space.stencil_system(1, 0), InvalidInput);
  EXPECT_THROW((void)space.lumped_mass(), InvalidInput);
  EXPECT_THROW((void)space.element_count(), InvalidInput);
  EXPECT_THROW((void)space.boundary(), InvalidInput);
  EXPECT_THROW((void)space.largest_shown(psi.col(0)), InvalidInput);
  space.integrate_again();
  expect_as_before();

  const auto places_again_equal = [&, before_them = space.texels().places] {
    return std::ranges::equal(space.texels().places, before_them, [](const Texels::Place& a, const Texels::Place& b) {
      return a.texture == b.texture && a.x == b.x && a.y == b.y;
    });
  };
  std::vector<Image<float>> pictures;
  for (const TextureSize& size : model->atlas.textures) pictures.emplace_back(size.width, size.height, 3);
  for (int twice = 0; twice < 2; ++twice) {
    space.let_go_of_texels();
    EXPECT_LT(double(space.bytes()), 0.1 * double(before));
    EXPECT_THROW((void)space.positions(), InvalidInput);
    EXPECT_THROW((void)space.gather(pictures), InvalidInput);
    EXPECT_THROW(space.scatter(psi, pictures), InvalidInput);
    EXPECT_EQ(space.size(), psi.rows());
    if (twice == 0) space.place_again();
    if (twice == 0) EXPECT_TRUE(places_again_equal());
  }
  space.integrate_again();
  EXPECT_TRUE(places_again_equal());
  expect_as_before();
}

}  // namespace
}  // namespace mq
