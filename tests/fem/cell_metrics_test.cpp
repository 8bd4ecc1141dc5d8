// What cells between texels say of the surface: on flat charts it is known.

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/atlas/texel_grid.h"

namespace mq {
namespace {

TEST(CellMetrics, AreThoseOfTheMapWhereChartsAreFlat) {
  // uv = map · p of chart c, and texels are uv scaled, y downwards: dx = T dp, and g⁻¹ = T Tᵀ.
  const fixtures::CutOptions options = fixtures::slanted(2);
  const TextureSize size{160, 120};
  const auto model = fixtures::textured(fixtures::cut_square(options), {size});
  const TexelSpace space(model->surface, model->atlas);
  const std::vector<TexelSpace::CellMetric> metrics = space.cell_metrics();
  const TexelGrid grid(model->atlas.textures);
  ASSERT_EQ(std::ssize(metrics), grid.cell_count());
  const Texels& texels = space.texels();
  int looked_at = 0;
  for (int i = 0; i < space.size(); ++i) {
    if (!texels.interior[std::size_t(i)]) continue;
    Eigen::Matrix2d T = fixtures::map_of_part(options, texels.chart[std::size_t(i)]);
    T.row(0) *= size.width;
    T.row(1) *= -size.height;
    const Eigen::Matrix2d G = T * T.transpose();
    const auto& at = texels.places[std::size_t(i)];
    const TexelSpace::CellMetric& found = metrics[std::size_t(grid.cell(0, at.x, at.y))];
    EXPECT_NEAR(found.xx, G(0, 0), 1e-9 * G.norm());
    EXPECT_NEAR(found.xy, G(0, 1), 1e-9 * G.norm());
    EXPECT_NEAR(found.yy, G(1, 1), 1e-9 * G.norm());
    ++looked_at;
  }
  EXPECT_GT(looked_at, 500);
}

TEST(CellMetrics, AreThereWhereAndOnlyWhereChartsAre) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    int covered = 0;
    for (const TexelSpace::CellMetric& metric : space.cell_metrics()) {
      if (metric.xx == 0 && metric.xy == 0 && metric.yy == 0) continue;
      EXPECT_GT(metric.xx, 0) << cut.name;
      EXPECT_GT(metric.xx * metric.yy - metric.xy * metric.xy, 0) << cut.name;
      ++covered;
    }
    EXPECT_GT(covered, 0) << cut.name;
  }
}

TEST(MeansAround, KeepConstantsAndStayBetweenWhatIsThere) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    std::vector<float> elements(std::size_t(space.element_count()), 3.0F);
    const Vector constant = space.means_around(elements);
    EXPECT_LT((constant.array() - 3).abs().maxCoeff(), 1e-12) << cut.name;
    const Random random(5);
    for (std::size_t e = 0; e < elements.size(); ++e) elements[e] = float(random.uniform(e));
    const Vector means = space.means_around(elements);
    EXPECT_GE(means.minCoeff(), 0) << cut.name;
    EXPECT_LE(means.maxCoeff(), 1) << cut.name;
    EXPECT_GT(means.maxCoeff() - means.minCoeff(), 0.1) << cut.name;
  }
}

TEST(MeansAround, WeighElementsByWhatTheyAreOfATexel) {
  // ∫ f φ_t over ∫ φ_t, summed with ∫ φ_t over all texels, is ∫ f.
  const auto model = fixtures::textured(fixtures::cut_square({.parts = 1, .scale = 0.5}), {{48, 48}});
  const TexelSpace space(model->surface, model->atlas);
  Signal x(space.size(), 1);
  for (int i = 0; i < x.rows(); ++i) x(i, 0) = 2 * space.texels().position(i).x();
  std::vector<float> norms = space.gradient_norms(x);  // 2 wherever a chart is
  const Vector means = space.means_around(norms);
  EXPECT_NEAR(means.dot(space.lumped_mass()), 2 * model->surface.area, 1e-4);
}

}  // namespace
}  // namespace mq
