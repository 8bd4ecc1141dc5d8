#include "mq/filter/sample_fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>

#include "mq/base/error.h"
#include "mq/fem/image_space.h"

namespace mq {
namespace {

using Function = std::function<double(const Vector3&)>;

/// A flat square of n × n texels, and samples on it, k × k to a texel.
struct Square {
  explicit Square(int side) : rectangle(side, side), n(side) {}

  struct Samples {
    std::vector<SurfacePoint> points;
    std::vector<double> areas;
    std::vector<char> seen;
  };

  Samples samples(int k) const {
    Samples found;
    const Mesh& mesh = rectangle.sheet().surface.mesh;
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int i = 0; i < n * k; ++i)
        for (int j = 0; i + j < n * k; ++j) {
          const double x = (i + 1.0 / 3) / (n * k), y = (j + 1.0 / 3) / (n * k);
          found.points.push_back({t, Vector3(1 - x - y, x, y)});
          found.areas.push_back(1);
          found.seen.push_back(1);
        }
    return found;
  }

  Vector3 place(const SurfacePoint& p) const { return point_at(rectangle.sheet().surface.mesh, p) / n; }

  Signal values(const Samples& samples, const Function& f) const {
    Signal values(std::ssize(samples.points), 1);
    for (std::size_t s = 0; s < samples.points.size(); ++s)
      values(Eigen::Index(s), 0) = f(place(samples.points[s]));
    return values;
  }

  /// Root mean square of the signal against the function, at other points than those of the fit and an
  /// eighth away from the rim, along which functions are constant.
  double error(const Signal& signal, const Function& f) const {
    const Samples at = samples(5);
    double sum = 0, count = 0;
    for (const SurfacePoint& p : at.points) {
      if ((place(p) - Vector3(0.5, 0.5, 0)).cwiseAbs().maxCoeff() > 0.375) continue;
      double value = -f(place(p));
      for (const BasisWeight& b : rectangle.basis_at(p.triangle, p.barycentric))
        value += b.weight * signal(b.unknown, 0);
      sum += value * value, ++count;
    }
    return std::sqrt(sum / count);
  }

  ImageSpace rectangle;
  int n;
};

SampleFit fit_of(const Square& square, const Square::Samples& samples, const Signal& values) {
  SampleFit fit(square.rectangle, int(values.cols()));
  fit.add(samples.points, samples.areas, values, samples.seen);
  return fit;
}

TEST(SampleFit, KeepsConstants) {
  const Square square(9);
  const auto samples = square.samples(2);
  const SampleFit fit =
      fit_of(square, samples, Signal::Constant(std::ssize(samples.points), 3, 0.375));
  EXPECT_LT((fit.mean().array() - 0.375).abs().maxCoeff(), 1e-14);
  EXPECT_LT((fit.least_squares().signal.array() - 0.375).abs().maxCoeff(), 1e-9);
}

TEST(SampleFit, ErrorsFallWithTheSquareOfTheSpacing) {
  const Function f = [](const Vector3& p) { return std::sin(5 * p.x() + 1) * std::cos(4 * p.y()); };
  double means[3], fits[3];
  for (int level = 0; level < 3; ++level) {
    const Square square(16 << level);
    const auto samples = square.samples(3);
    const SampleFit fit = fit_of(square, samples, square.values(samples, f));
    means[level] = square.error(fit.mean(), f);
    fits[level] = square.error(fit.least_squares().signal, f);
  }
  for (int level = 1; level < 3; ++level) {
    EXPECT_GT(std::log2(means[level - 1] / means[level]), 1.9);
    EXPECT_GT(std::log2(fits[level - 1] / fits[level]), 1.9);
  }
  EXPECT_LT(fits[2], means[2] / 2);
}

TEST(SampleFit, GivesBackASignalOfTheSpaceAndTheMeanBlursIt) {
  const Square square(24);
  Signal texels(square.rectangle.size(), 1);
  for (int i = 0; i < texels.rows(); ++i) texels(i, 0) = (i * 7919 % 101) / 100.0;
  const auto samples = square.samples(3);
  Signal values = Signal::Zero(std::ssize(samples.points), 1);
  for (std::size_t s = 0; s < samples.points.size(); ++s)
    for (const BasisWeight& b : square.rectangle.basis_at(samples.points[s].triangle,
                                                                  samples.points[s].barycentric))
      values(Eigen::Index(s), 0) += b.weight * texels(b.unknown, 0);
  const SampleFit fit = fit_of(square, samples, values);
  const double off = (fit.least_squares().signal - texels).norm() / std::sqrt(texels.rows());
  const double blurred = (fit.mean() - texels).norm() / std::sqrt(texels.rows());
  EXPECT_LT(off, 0.004);  // η against the mass of the finest waves, 1/9: a hundredth of their size
  EXPECT_GT(blurred, 0.1);
}

TEST(SampleFit, SaysWhatIsNotKnownAndLeavesIt0) {
  const Square square(16);
  auto samples = square.samples(2);
  for (std::size_t s = 0; s < samples.points.size(); ++s)
    samples.seen[s] = square.place(samples.points[s]).x() < 0.5;
  const SampleFit fit =
      fit_of(square, samples, Signal::Constant(std::ssize(samples.points), 1, 0.5));
  const std::vector<char> known = fit.known();
  const Signal best = fit.least_squares().signal;
  for (int i = 0; i < 256; ++i) {
    if (i % 16 < 7 || i % 16 > 8) {
      EXPECT_EQ(bool(known[std::size_t(i)]), i % 16 < 7) << i;
    }
    EXPECT_NEAR(best(i, 0), known[std::size_t(i)] ? 0.5 : 0, 1e-9) << i;
  }
}

TEST(SampleFit, HasTheSameBitsForAnyNumberOfThreads) {
  const auto of_threads = [](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Square square(40);
    const auto samples = square.samples(2);
    return fit_of(square, samples, square.values(samples, [](const Vector3& p) {
             return std::sin(31 * p.x() + 17 * p.y());
           })).least_squares().signal;
  };
  EXPECT_EQ(of_threads(1), of_threads(2));
}

TEST(SampleFit, RefusesWhatDoesNotFit) {
  const Square square(4);
  const auto samples = square.samples(1);
  SampleFit fit(square.rectangle, 3);
  const Signal grey = Signal::Zero(std::ssize(samples.points), 1);
  EXPECT_THROW(fit.add(samples.points, samples.areas, grey, samples.seen), InvalidInput);
}

}  // namespace
}  // namespace mq
