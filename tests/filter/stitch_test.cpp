// Stitching: offsets between parts vanish, everything else stays.
#include "mq/filter/stitch.h"
#include "mq/fem/image_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::cut_squares;
using fixtures::places_of;

/// Screening that is as good as none: on the unit square it leaves 1e-6 of the slowest offset.
constexpr double almost_no_screen = 1e5;

/// A space, its unknowns' places and chart numbers or another partition.
struct Ground {
  const SignalSpace& space;
  std::vector<Vector3> places;
  std::vector<int> labels;
  SparseMatrix stiffness;

  Ground(const SignalSpace& s, std::vector<Vector3> p, std::vector<int> l)
      : space(s), places(std::move(p)), labels(std::move(l)), stiffness(s.stiffness()) {}
};

/// Quadrants around a point, crossing charts.
std::vector<int> quadrants(const std::vector<Vector3>& places) {
  std::vector<int> labels;
  for (const Vector3& p : places) labels.push_back((p.x() > 0.37) + 2 * (p.y() > 0.58));
  return labels;
}

double offset(int label, int channel) { return 0.3 * std::sin(2.3 * label + 1.1 * channel + 1); }

Signal with_offsets(Signal signal, const std::vector<int>& labels) {
  for (Eigen::Index i = 0; i < signal.rows(); ++i)
    for (Eigen::Index c = 0; c < signal.cols(); ++c) signal(i, c) += offset(labels[i], int(c));
  return signal;
}

/// Root mean square of the difference of two signals up to a constant per channel, over the area.
double rms_up_to_constants(const SignalSpace& space, const Signal& a, const Signal& b) {
  const Vector mass = space.mass() * Vector::Ones(space.size());
  Signal d = a - b;
  d.rowwise() -= (mass.transpose() * d / mass.sum()).eval();
  return std::sqrt((mass.transpose() * d.cwiseAbs2()).sum() / (mass.sum() * double(d.cols())));
}

Signal stitched(const Ground& ground, const Signal& psi, double weight = almost_no_screen) {
  return ScreenedPoisson(ground.space, weight)
      .solve_change(psi, stitch_regions(ground.space, psi, ground.labels))
      .signal;
}

Signal evaluated(const std::vector<Vector3>& places, const auto& function) {
  Signal signal(std::ssize(places), 2);
  for (std::size_t i = 0; i < places.size(); ++i)
    signal.row(Eigen::Index(i)) << function(places[i]), 1 - 0.5 * function(places[i]);
  return signal;
}

double waves(const Vector3& p) {
  return 0.5 + 0.25 * std::sin(2 * std::numbers::pi * (2 * p.x() + p.y())) +
         0.15 * std::cos(2 * std::numbers::pi * (p.x() - 3 * p.y()));
}

TEST(Stitch, ReturnsConstantsAndSingleRegionsBitForBit) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    Ground ground(space, places_of(space), space.texels().chart);
    const Signal constant = Signal::Constant(space.size(), 3, 0.3);
    EXPECT_TRUE(stitched(ground, constant) == constant) << cut.name;
    std::ranges::fill(ground.labels, 7);
    const Signal noise = test::random_signal(space.size(), 3);
    EXPECT_TRUE(stitched(ground, noise) == noise) << cut.name;
  }
}

TEST(Stitch, RemovesOffsetsFromLinearFunctions) {
  const auto linear = [](const Vector3& p) { return 0.2 + 0.5 * p.x() - 0.3 * p.y(); };
  int tried = 0;
  for (const Cut& cut : cut_squares()) {
    if (!cut.apart || cut.size.width < 20) continue;  // charts below a texel: places are rough
    const TexelSpace texels(cut.model->surface, cut.model->atlas);
    // Texels that are held to their neighbours pull along borders with 1e-4 of the slope.
    const bool held = (texels.regularised_system(0, 1) - texels.system(0, 1)).norm() > 0;
    const std::vector<Vector3> places = places_of(texels);
    for (const auto& labels : {texels.texels().chart, quadrants(places)}) {
      const Ground ground(texels, places, labels);
      const Signal truth = evaluated(places, linear);
      const Signal found = stitched(ground, with_offsets(truth, labels));
      EXPECT_LT(rms_up_to_constants(texels, found, truth), held ? 1e-3 : 2e-6) << cut.name;
      ++tried;
    }
  }
  EXPECT_GE(tried, 12);
  const Surface surface = make_surface(fixtures::flat_square(20, 0.2));
  const VertexSpace vertices(surface);
  const Ground ground(vertices, surface.mesh.positions, quadrants(surface.mesh.positions));
  const Signal truth = evaluated(ground.places, linear);
  EXPECT_LT(
      rms_up_to_constants(vertices, stitched(ground, with_offsets(truth, ground.labels)), truth),
      2e-6);
}

/// Where texels hang outside charts, held to their neighbours, and for functions that bend: better
/// than one step of 8 bits, and the finer the better; flat borders are off by a step of the slope.
TEST(Stitch, RemovesOffsetsFromPictures) {
  for (const int scale : {1, 2}) {
    fixtures::CutOptions options = fixtures::turned(fixtures::odd_angle);
    const Cut cut = fixtures::cut("", options, {256 * scale, 256 * scale});
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const std::vector<Vector3> places = places_of(space);
    for (const auto& labels : {space.texels().chart, quadrants(places)}) {
      const Ground ground(space, places, labels);
      const Signal truth = evaluated(places, waves), shown = with_offsets(truth, labels);
      const double before = rms_up_to_constants(space, shown, truth);
      const double after = rms_up_to_constants(space, stitched(ground, shown), truth);
      EXPECT_GT(before, 0.1);
      EXPECT_LT(after, 0.1 / 255 / scale) << scale;
    }
  }
}

TEST(Stitch, KeepsTheMeanOfEachComponent) {
  const Cut cut = fixtures::cut("", fixtures::slanted(), {96, 160});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Ground ground(space, places_of(space), space.texels().chart);
  const Signal psi = test::random_signal(space.size(), 3);
  const Vector mass = space.mass() * Vector::Ones(space.size());
  for (const double weight : {1e-2, 1.0, ScreenedPoisson::infinite_weight}) {
    const Signal change = stitched(ground, psi, weight) - psi;
    EXPECT_GT(change.cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_LT((mass.transpose() * change).cwiseAbs().maxCoeff(), 1e-9);
  }
}

/// Unseen parts are filled with a function that has no extremum inside them; what was there before
/// does not matter, and what is around stays. Here the harmonic function is the linear one itself.
TEST(Stitcher, FillsWhatIsUnseen) {
  const Surface surface = make_surface(fixtures::flat_square(40));
  const VertexSpace space(surface);
  const std::vector<Vector3>& places = surface.mesh.positions;
  Ground ground(space, places, std::vector<int>(places.size(), 0));
  const Signal truth = evaluated(places, [](const Vector3& p) { return p.x(); });
  Signal psi = truth, other = truth;
  for (std::size_t i = 0; i < places.size(); ++i)
    if ((places[i] - Vector3(0.5, 0.5, 0)).norm() < 0.2) {
      ground.labels[i] = unseen;
      psi(Eigen::Index(i), 0) = 9;
      other(Eigen::Index(i), 0) = -4;
    }
  const Stitcher stitcher(space, 1e-2, ground.labels);
  const auto result = [&](const Signal& values) {
    const Signal filled = stitcher.fill(values);
    return stitcher.solve(filled, stitch_regions(ground.space, filled, ground.labels)).signal;
  };
  EXPECT_LT((result(other) - result(psi)).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((result(psi) - truth).cwiseAbs().maxCoeff(), 2e-3);
}

/// A step that runs through a hole: the seen part is stitched as if the hole were cut out.
TEST(Stitcher, StitchesAroundWhatIsUnseen) {
  const Surface surface = make_surface(fixtures::flat_square(40));
  const VertexSpace space(surface);
  const std::vector<Vector3>& places = surface.mesh.positions;
  Ground ground(space, places, {});
  for (const Vector3& p : places)
    ground.labels.push_back((p - Vector3(0.5, 0.5, 0)).norm() < 0.1 ? unseen : p.x() > 0.51);
  const Signal truth = evaluated(places, [](const Vector3& p) { return p.y(); });
  Signal psi = truth;
  for (std::size_t i = 0; i < places.size(); ++i)
    psi.row(Eigen::Index(i)).array() += ground.labels[i] == 1 ? 0.3 : 0;
  const Stitcher stitcher(space, 1e4, ground.labels);
  const Signal filled = stitcher.fill(psi);
  const Signal found =
      stitcher.solve(filled, stitch_regions(ground.space, filled, ground.labels)).signal;
  EXPECT_GT(rms_up_to_constants(space, filled, truth), 0.1);
  EXPECT_LT(rms_up_to_constants(space, found, truth), 1.0 / 255);
}

/// What both make is the same, bit for bit, with a hole and without.
TEST(Stitcher, OneSystemAtATimeMakesTheSame) {
  const Surface surface = make_surface(fixtures::flat_square(30));
  const VertexSpace space(surface);
  const std::vector<Vector3>& places = surface.mesh.positions;
  const Signal psi = test::random_signal(space.size(), 2), offset = 0.1 * test::random_signal(space.size(), 2);
  for (const double hole : {0.0, 0.15}) {
    std::vector<int> labels;
    for (const Vector3& p : places)
      labels.push_back((p - Vector3(0.5, 0.5, 0)).norm() < hole ? unseen : p.x() > 0.51);
    BeyondBorders beyond(space, labels, 2);
    ASSERT_FALSE(beyond.unknowns_of(0).empty());
    for (const int i : beyond.unknowns_of(0)) beyond.put(0, i, psi.row(i) + Eigen::RowVector2d(0.2, -0.1));
    const Stitcher kept(space, 1e-2, labels);
    const Stitcher once(space, 1e-2, labels, {}, {}, Stitcher::Systems::one_each);
    const Signal both = kept.stitch(psi, beyond, offset).signal;
    EXPECT_GT((both - psi).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_EQ(both, once.stitch(psi, beyond, offset).signal) << hole;
    EXPECT_EQ(kept.stitch(psi).signal, once.stitch(psi).signal) << hole;
  }
}

/// How far a change of unknown i goes beyond those of its neighbours in the same region, and
/// whether it has less than a hundredth of their stiffness.
struct Outlier {
  double excess = 0;
  bool weak = false;
};
Outlier outlier(const Ground& ground, const Signal& change, int i) {
  double low = 1e9, high = -1e9, most = 0;
  for (SparseMatrix::InnerIterator it(ground.stiffness, i); it; ++it) {
    const int j = int(it.col());
    if (j == i || ground.labels[j] != ground.labels[i]) continue;
    low = std::min(low, change(j, 0)), high = std::max(high, change(j, 0));
    most = std::max(most, ground.stiffness.coeff(j, j));
  }
  return {std::max(low - change(i, 0), change(i, 0) - high),
          ground.stiffness.coeff(i, i) < 0.01 * most};
}

TEST(Stitcher, KeepsTexelsThatHardlyCountBetweenTheirNeighbours) {
  double worst = 0;
  int weak = 0;
  for (const double shift : {0.001, 0.01, 0.03}) {  // texels that charts reach into so far
    fixtures::CutOptions options = fixtures::turned(fixtures::quarter_turn);
    options.jitter = 0;
    options.scale = 0.75;
    options.shift = [&](int) { return Vector2((0.5 + shift) / 48, (0.5 + shift) / 48); };
    const Cut cut = fixtures::cut("", options, {48, 48});
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    const Ground ground(space, places_of(space), space.texels().chart);
    const Signal psi = with_offsets(test::random_signal(space.size(), 1), ground.labels);
    const Signal asked = stitch_regions(ground.space, psi, ground.labels);
    const Signal raw =
        ScreenedPoisson(space, almost_no_screen).solve_change(psi, asked).signal - psi;
    const Signal change =
        Stitcher(space, almost_no_screen, ground.labels).solve(psi, asked).signal - psi;
    for (int i = 0; i < space.size(); ++i) {
      const Outlier now = outlier(ground, change, i);
      if (!now.weak) continue;
      ++weak;
      worst = std::max(worst, outlier(ground, raw, i).excess);
      EXPECT_LT(now.excess, 1e-9) << shift << ", texel " << i;
    }
    EXPECT_LT((change - raw).norm(), 0.5 * raw.norm());
  }
  EXPECT_GT(weak, 20);
  EXPECT_GT(worst, 0.05);
}

TEST(Stitcher, LeavesComponentsThatNobodySeesConstant) {
  Mesh far = fixtures::tetrahedron();
  for (Vector3& p : far.positions) p += Vector3(9, 0, 0);
  const Surface surface = make_surface(fixtures::beside(fixtures::sphere(2), far));
  const VertexSpace space(surface);
  std::vector<int> labels(std::size_t(space.size()), 0);
  std::fill(labels.end() - 4, labels.end(), unseen);
  Signal psi = test::random_signal(space.size(), 2);
  psi.bottomRows(4).setConstant(0.5);
  const Stitcher stitcher(space, 1e-2, labels);
  const Signal filled = stitcher.fill(psi);
  EXPECT_LT((filled - psi).cwiseAbs().maxCoeff(), 1e-9);
}

/// Two photographs of the same noise, with an offset between them, overlapping in a band.
std::vector<Partial> overlapping(const Signal& truth, const std::vector<Vector3>& places) {
  std::vector<Partial> partials(2, Partial{truth, std::vector<double>(places.size(), 0.0)});
  partials[1].values.array() += 0.25;
  for (std::size_t i = 0; i < places.size(); ++i) {
    partials[0].confidence[i] = std::max(0.0, 0.65 - places[i].x());
    partials[1].confidence[i] = std::max(0.0, places[i].x() - 0.35);
  }
  return partials;
}

TEST(StitchPartials, FindsTheOffsetWhereBothSee) {
  for (const Cut& cut : cut_squares()) {
    if (!cut.apart || cut.size.width < 40) continue;
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    if ((space.regularised_system(0, 1) - space.system(0, 1)).norm() > 0) continue;
    const std::vector<Vector3> places = places_of(space);
    const Signal truth = test::random_signal(space.size(), 2);
    const std::vector<Partial> partials = overlapping(truth, places);
    const Composite composite = best_of(partials);
    EXPECT_GT(rms_up_to_constants(space, composite.values, truth), 0.1);
    const Ground ground(space, places, composite.labels);
    const Signal change = stitch_partials(ground.space, partials, composite);
    const Signal found =
        ScreenedPoisson(space, almost_no_screen).solve_change(composite.values, change).signal;
    EXPECT_LT(rms_up_to_constants(space, found, truth), 1e-5) << cut.name;
  }
}

TEST(StitchPartials, ReturnConsistentPhotographsUnchanged) {
  const Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {48, 48});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const std::vector<Vector3> places = places_of(space);
  const Signal truth = test::random_signal(space.size(), 2);
  std::vector<Partial> partials = overlapping(truth, places);
  partials[1].values = truth;
  const Composite composite = best_of(partials);
  EXPECT_TRUE(composite.values == truth);
  const Ground ground(space, places, composite.labels);
  const Signal change = stitch_partials(ground.space, partials, composite);
  const Signal found = ScreenedPoisson(space, 1e-2).solve_change(truth, change).signal;
  EXPECT_LT((found - truth).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(StitchPartials, TakeTheOneThatIsWantedWhereItShowsAnything) {
  const std::vector<Partial> partials = {{Signal::Constant(3, 1, 1.0), {0.5, 0.5, 0}},
                                         {Signal::Constant(3, 1, 2.0), {0.2, 0, 0.1}}};
  const Composite composite = best_of(partials, std::vector{1, 1, unseen});
  EXPECT_EQ(composite.labels, (std::vector{1, 0, 1}));
  EXPECT_EQ(composite.values, (Signal(3, 1) << 2, 1, 2).finished());
  EXPECT_THAT(fixtures::error_of([&] {
                best_of(partials, std::vector{0, 2, 0});
              }),
              testing::HasSubstr("found photograph 2, wanted a number from 0 to 1"));
}

TEST(StitchPartials, TakeTheMostConfident) {
  const std::vector<Partial> partials = {{Signal::Constant(3, 1, 1.0), {0.5, 0, 0}},
                                         {Signal::Constant(3, 1, 3.0), {0.5, 0.2, 0}}};
  const Composite composite = best_of(partials);
  EXPECT_THAT(composite.labels, testing::ElementsAre(0, 1, unseen));
  EXPECT_EQ(composite.values(0, 0), 1);
  EXPECT_EQ(composite.values(1, 0), 3);
  EXPECT_EQ(composite.values(2, 0), 2);
  EXPECT_FALSE(fixtures::error_of([&] { best_of({}); }).empty());
  std::vector<Partial> negative = partials;
  negative[0].confidence[1] = -1;
  EXPECT_FALSE(fixtures::error_of([&] { best_of(negative); }).empty());
}

TEST(BorderJump, TellsStepsFromTheRest) {
  const Surface surface = make_surface(fixtures::flat_square(10));
  const VertexSpace space(surface);
  std::vector<int> labels;
  Signal psi(surface.mesh.vertex_count(), 1);
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    labels.push_back(surface.mesh.positions[v].x() > 0.45);
    psi(v, 0) = 0.4 * labels.back();
  }
  const BorderJump jump = border_jump(space.stiffness(), psi, labels);
  EXPECT_NEAR(jump.across, 0.4, 1e-12);
  EXPECT_EQ(jump.within, 0);
  EXPECT_GT(jump.pairs, 10);
}

TEST(Stitcher, RefusesPhotographsAndLabelsThatDoNotFit) {
  const ImageSpace space(4, 3);
  const Signal psi = Signal::Zero(12, 2);
  const Partial whole{psi, std::vector<double>(12, 1)};
  std::vector<int> labels(12, 0);
  labels[5] = 2;  // of two photographs
  const std::vector<Partial> two = {whole, whole};
  EXPECT_THROW(Stitcher(space, 1, labels).stitch(psi, two), InvalidInput);
  EXPECT_THROW(stitch_partials(space, two, {psi, labels}), InvalidInput);
  labels[5] = 1;
  const Stitcher stitcher(space, 1, labels);
  EXPECT_NO_THROW(stitcher.stitch(psi, two));
  for (const Partial& odd :
       {Partial{Signal::Zero(3, 2), whole.confidence},
        Partial{Signal::Zero(12, 1), whole.confidence}, Partial{psi, std::vector<double>(3, 1)}})
    EXPECT_THROW(stitcher.stitch(psi, std::vector<Partial>{whole, odd}), InvalidInput);
  EXPECT_THROW(stitcher.fill(Signal::Zero(3, 2)), InvalidInput);
  EXPECT_THROW(Stitcher(space, 1, labels).regroup({0, 1}), InvalidInput);
  const std::vector<int> few(5, 0);
  EXPECT_THROW(mean_drift(space, psi, psi, few), InvalidInput);
  EXPECT_THROW(mean_drift(space, psi, Signal::Zero(3, 2), labels), InvalidInput);
  EXPECT_THROW(border_jump(space.stiffness(), psi, few), InvalidInput);
}

}  // namespace
}  // namespace mq
