// Line integral convolution: values agree along the lines of the field and not across them, however
// the surface is cut into charts.

#include "mq/filter/line_integral.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "mq/fem/field_metric.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/linear/direct_solver.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

/// The lines of a constant field on the unit square, as a function of the place.
class Lines {
 public:
  Lines(const fixtures::CutOptions& options, int side, const Vector3& direction, double grain)
      : model_(fixtures::textured(fixtures::cut_square(options), {{side, side}})),
        space_(model_->surface, model_->atlas),
        closest_(model_->surface.mesh) {
    const std::vector<Vector3> field(model_->surface.mesh.triangles.size(), direction);
    TexelSpaceOptions across;
    across.metrics = texel_metrics_across(model_->surface, model_->atlas, field, 100);
    const TexelSpace stretched(model_->surface, model_->atlas, across);
    std::vector<Vector3> places;
    for (const auto& p : space_.texels().positions) places.emplace_back(p[0], p[1], p[2]);
    lines_ = line_integral(stretched, space_, solid_noise(places, grain, 7),
                           {.weight = 0.04, .sharpen_weight = 1e-4}, direct_solver())
                 .signal;
  }

  double operator()(const Vector2& p) const {
    const ClosestPoint at = closest_({p.x(), p.y(), 0});
    return fixtures::value_at(space_, lines_, at.triangle, at.barycentric);
  }

 private:
  std::unique_ptr<fixtures::Textured> model_;
  TexelSpace space_;
  ClosestPointFinder closest_;
  Signal lines_;
};

/// Of two functions at 2000 places of the middle of the square.
double correlation(const std::function<double(const Vector2&)>& f,
                   const std::function<double(const Vector2&)>& g) {
  const Random random(2);
  Eigen::ArrayXd a(2000), b(2000);
  for (int k = 0; k < 2000; ++k) {
    const Vector2 p(random.uniform(2 * k, 0.2, 0.8), random.uniform(2 * k + 1, 0.2, 0.8));
    a[k] = f(p), b[k] = g(p);
  }
  a -= a.mean();
  b -= b.mean();
  return (a * b).sum() / std::sqrt(a.square().sum() * b.square().sum());
}

/// How far one can go in a direction until values agree only by half.
double reach(const Lines& lines, const Vector2& direction) {
  double far = 0.001;
  const auto here = [&](const Vector2& p) { return lines(p); };
  const auto there = [&](const Vector2& p) { return lines(p + far * direction); };
  while (far < 0.2 && correlation(here, there) > 0.5) far *= 1.25;
  return far;
}

TEST(LineIntegral, AgreesTenTimesFartherAlongTheFieldThanAcross) {
  const double a = 0.6;
  const Lines lines(fixtures::turned(fixtures::odd_angle), 200,
                    Vector3(std::cos(a), std::sin(a), 0), 1.0 / 90);
  const double along = reach(lines, {std::cos(a), std::sin(a)}),
               across = reach(lines, {-std::sin(a), std::cos(a)});
  EXPECT_GE(along, 10 * across) << along << ' ' << across;
}

TEST(LineIntegral, IsTheSameHoweverTheSurfaceIsCut) {
  fixtures::CutOptions whole;
  whole.parts = 1;
  whole.scale = 0.9;
  const Vector3 direction(0.8, 0.6, 0);
  const Lines one(whole, 200, direction, 1.0 / 30),
      four(fixtures::turned(fixtures::odd_angle), 300, direction, 1.0 / 30);
  EXPECT_GE(correlation([&](const Vector2& p) { return one(p); },
                        [&](const Vector2& p) { return four(p); }),
            0.95);
}

// The hardest matrix there is for multigrid: a hundred times as far along the lines as across, at
// any angle to the texels.
TEST(LineIntegral, IsSolvedByMultigrid) {
  const auto model =
      fixtures::textured(fixtures::cut_square(fixtures::turned(fixtures::odd_angle)), {{200, 200}});
  const TexelSpace space(model->surface, model->atlas);
  std::vector<Vector3> places;
  for (const auto& p : space.texels().positions) places.emplace_back(p[0], p[1], p[2]);
  const Signal noise = solid_noise(places, 1.0 / 90, 7);
  for (const double angle : {0.0, 0.4, 0.6, 0.8}) {
    TexelSpaceOptions across;
    across.metrics =
        texel_metrics_across(model->surface, model->atlas,
                             std::vector<Vector3>(model->surface.mesh.triangles.size(),
                                                  Vector3(std::cos(angle), std::sin(angle), 0)),
                             100);
    const TexelSpace stretched(model->surface, model->atlas, across);
    const auto spread = [&](const SolverFactory& factory) {
      return line_integral(stretched, space, noise, {.weight = 0.04}, factory);
    };
    const Signal exact = spread(direct_solver()).signal;
    const LineIntegral lines = spread(multigrid_solver(space.texels(), {.tolerance = 0.02}));
    EXPECT_TRUE(lines.spread.converged);
    EXPECT_LE(lines.spread.cycles, 14) << angle;
    const double deviation = (exact.array() - exact.mean()).matrix().norm();
    EXPECT_GT(deviation, 0);
    EXPECT_LE((lines.signal - exact).norm(), 0.03 * deviation) << angle;
  }
}

TEST(LineIntegral, LeavesAConstantAlone) {
  const auto model = fixtures::textured(fixtures::cut_square({}), {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  const Signal constant = Signal::Constant(space.size(), 1, 0.3);
  const LineIntegral lines = line_integral(
      space, space, constant, {.weight = 0.1, .sharpen_weight = 1e-4}, direct_solver());
  EXPECT_LE((lines.signal - constant).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE((with_contrast(lines.signal).array() == 0.5).all());
}

/// Of texels of the unit square.
Signal function_of(const TexelSpace& space, const std::function<double(double, double)>& f) {
  Signal values(space.size(), 1);
  for (std::int64_t i = 0; i < space.size(); ++i)
    values(i, 0) = f(space.texels().positions[std::size_t(i)][0], space.texels().positions[std::size_t(i)][1]);
  return values;
}

// Fine waves five times as strong on the right as on the left, on a wave as wide as the square: the wide one goes,
// the fine ones become alike.
TEST(EvenedLines, AreAsClearEverywhereAndHaveNoBroadBands) {
  fixtures::CutOptions whole;
  whole.parts = 1;
  whole.scale = 0.9;
  const auto model = fixtures::textured(fixtures::cut_square(whole), {{300, 300}});
  const TexelSpace space(model->surface, model->atlas);
  const double wave = 2 * std::numbers::pi / 0.04;
  const Signal lines = function_of(space, [&](double x, double y) {
    return (1 + 4 * x) * std::sin(wave * y) + 5 * std::cos(std::numbers::pi * y);
  });
  const Signal even = evened(ScreenedPoisson(space, 0.04 * 0.04, direct_solver()), lines);
  const Signal fine = function_of(space, [&](double, double y) { return std::sqrt(2) * std::sin(wave * y); });
  double error = 0;
  for (std::int64_t i = 0; i < space.size(); ++i) {
    const auto& p = space.texels().positions[std::size_t(i)];
    if (std::min({p[0], p[1], 1 - p[0], 1 - p[1]}) < 0.15) continue;
    error = std::max(error, std::abs(even(i, 0) - fine(i, 0)));
  }
  EXPECT_LT(error, 0.2);
}

TEST(EvenedLines, AreTheSameTimesANumberAndNothingOfAConstant) {
  const auto model = fixtures::textured(fixtures::cut_square({}), {{40, 40}});
  const TexelSpace space(model->surface, model->atlas);
  const Signal lines = function_of(space, [](double x, double y) { return std::sin(60 * x + 10 * y); });
  const ScreenedPoisson means(space, 0.01, direct_solver());
  const Signal once = evened(means, lines);
  const Signal thrice = evened(means, 3 * lines);
  EXPECT_LE((once - thrice).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(once.cwiseAbs().maxCoeff(), 1);
  const Signal constant = Signal::Constant(space.size(), 1, 0.3);
  EXPECT_TRUE((evened(means, constant).array() == 0).all());
}

TEST(UsualGrain, IsTwoTexelsOfAnEvenTextureAndAQuarterOfAPerCentOfAFineOne) {
  for (const int side : {100, 400, 1600}) {
    const auto model = fixtures::textured(fixtures::cut_square({}), {{side, side}});
    const TexelSpace space(model->surface, model->atlas);
    EXPECT_NEAR(usual_grain(space), std::max(0.0025, 2 * space.scale().texel_spacing), 1e-9) << side;
  }
}

/// Three squares side by side, of which the last has texels of a side eight times as long.
TEST(UsualGrain, IsASpacingThatAFifthOfTheSurfaceExceeds) {
  Mesh mesh;
  const double scale[] = {0.4, 0.4, 0.05}, left[] = {0.05, 0.5, 0.92};
  for (int k = 0; k < 3; ++k) {
    const int first = 4 * k;
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner == 1 || corner == 2, y = corner > 1;
      mesh.positions.emplace_back(2 * k + x, y, 0);
      mesh.uvs.push_back(Vector2(left[k] + scale[k] * x, 0.1 + scale[k] * y));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  mesh.corner_uvs = mesh.triangles;
  const auto model = fixtures::textured(mesh, {{400, 400}});
  const TexelSpace space(model->surface, model->atlas);
  EXPECT_NEAR(usual_grain(space), 1 / (0.05 * 400), 1e-6);
}

TEST(SolidNoise, IsAFunctionOfThePlaceAndTheSeed) {
  const std::vector<Vector3> places = {{0.1, 0.2, 0.3}, {-5, 1e3, 2}, {0.1, 0.2, 0.3}};
  const Signal a = solid_noise(places, 0.05, 1), b = solid_noise(places, 0.05, 2);
  EXPECT_EQ(a(0, 0), a(2, 0));
  EXPECT_NE(a(0, 0), a(1, 0));
  EXPECT_NE(a(0, 0), b(0, 0));
  EXPECT_TRUE((a.array() >= 0).all() && (a.array() <= 1).all());
  EXPECT_THROW(solid_noise(places, 0), InvalidInput);
}

TEST(WithContrast, PutsTheMeanInTheMiddle) {
  Signal values(4, 1);
  values << 1, 3, 1, 3;
  const Signal grey = with_contrast(values, 2);
  EXPECT_DOUBLE_EQ(grey(0, 0), 0.25);
  EXPECT_DOUBLE_EQ(grey(1, 0), 0.75);
}

/// Conjugate gradients come nearer in the energy with every step, and so do the pictures.
/// So many deviations below the mean are 0, and as many above it 1.
TEST(WithContrast, PutsTheDeviationsAtTheEnds) {
  Signal signal(4, 2);
  signal << 3, 10, 5, 30, 3, 10, 5, 30;  // mean 4 and deviation 1; 20 and 10
  for (const double deviations : {1.0, 4.0}) {
    const Signal found = with_contrast(signal, deviations);
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 2; ++c) EXPECT_NEAR(found(i, c), 0.5 + (i % 2 == 1 ? 0.5 : -0.5) / deviations, 1e-12);
  }
}

TEST(LinesOver, GoTwoFifthsOfTheWayToBlackAndToWhite) {
  Signal colours(5, 3), grey(5, 1);
  colours << 0.5, 1, 0.3, 0.5, 1, 0.3, 0.5, 1, 0.3, 0.5, 0, 0.3, 2, 0.2, 0.3;
  grey << 0, 0.5, 1, 1, 0.75;
  const Signal found = lines_over(colours, grey, 2);
  const double expected[5][2] = {{0.3, 0.6}, {0.5, 1}, {0.7, 1}, {0.7, 0.4}, {2, 0.36}};
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(found(i, 0), expected[i][0], 1e-12) << i;
    EXPECT_NEAR(found(i, 1), expected[i][1], 1e-12) << i;
    EXPECT_EQ(found(i, 2), 0.3);
  }
}

TEST(WatchLinesForm, BeginsWithTheNoiseAndComesNearerToTheLines) {
  const auto model = fixtures::textured(fixtures::cut_square({}), {{60, 60}});
  const std::vector<Vector3> field(model->surface.mesh.triangles.size(), Vector3(1, 0.4, 0));
  TexelSpaceOptions across;
  across.metrics = texel_metrics_across(model->surface, model->atlas, field, 100);
  const TexelSpace space(model->surface, model->atlas, across);
  std::vector<Vector3> places;
  for (const auto& p : space.texels().positions) places.emplace_back(p[0], p[1], p[2]);
  const Signal noise = solid_noise(places, 0.03);
  const double weight = 0.01;
  const Signal lines = ScreenedPoisson(space, weight).solve(noise, 0).signal;
  const SparseMatrix A = space.regularised_system(1, weight);
  std::vector<int> steps;
  std::vector<double> errors;
  watch_lines_form(space, noise, weight, 64, [&](int step, const Signal& now) {
    if (step == 0) {
      EXPECT_TRUE(now == noise);
    }
    const Signal error = now - lines;
    steps.push_back(step);
    errors.push_back(error.cwiseProduct(A * error).sum());
  });
  EXPECT_EQ(steps, (std::vector<int>{0, 1, 2, 4, 8, 16, 32, 64}));
  for (std::size_t k = 1; k < errors.size(); ++k) EXPECT_LT(errors[k], errors[k - 1]) << k;
  EXPECT_LT(errors.back(), 0.02 * errors.front());
}

}  // namespace
}  // namespace mq
