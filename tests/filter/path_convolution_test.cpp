// Means along paths through texels, against those along straight lines, however the square is cut.

#include "mq/filter/path_convolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "mq/base/error.h"

namespace mq {
namespace {

/// A flat square with a constant field.
struct Combed {
  Combed(const fixtures::CutOptions& options, int side, const Vector3& direction)
      : model(fixtures::textured(fixtures::cut_square(options), {{side, side}})),
        space(model->surface, model->atlas),
        vectors(model->surface, model->atlas, space),
        domain(model->surface, model->atlas, space),
        starts(domain.starts()),
        field(vectors.from_triangles(TangentField(std::size_t(model->surface.triangle_count()), direction))) {}

  template <class Function>
  Signal signal(const Function& function) const {
    const std::vector<Vector3> places = space.positions();
    Signal values(std::ssize(places), 1);
    for (Eigen::Index i = 0; i < values.rows(); ++i) values(i, 0) = function(places[std::size_t(i)]);
    return values;
  }

  /// Whether a chart covers the texel's centre: others only serve lookups at seams.
  bool shows(std::size_t texel) const { return !starts.outside[texel]; }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TexelVectorSpace vectors;
  TraceAtlas domain;
  TraceAtlas::Starts starts;
  Vector field;
};

const Vector3 along = Vector3(0.8, 0.6, 0);
const Vector3 across = Vector3(-0.6, 0.8, 0);

std::vector<fixtures::CutOptions> cuts() {
  return {fixtures::turned(fixtures::odd_angle, 3), fixtures::turned(fixtures::quarter_turn, 3), fixtures::slanted(3),
          fixtures::turned([](int) { return 0.0; }, 1)};
}

TEST(PathConvolution, LeavesWhatDoesNotChangeAlongTheField) {
  for (const fixtures::CutOptions& options : cuts()) {
    const Combed square(options, 96, along);
    const PathConvolution lines(square.vectors, square.domain, square.field);
    const Signal even = square.signal([](const Vector3&) { return 0.7; });
    EXPECT_LT((lines.draw(even, 0.2).signal - even).cwiseAbs().maxCoeff(), 1e-12);
    // Linear functions are looked up as they are.
    const Signal linear = square.signal([](const Vector3& p) { return across.dot(p); });
    const Signal found = lines.draw(linear, 0.1).signal;
    const std::vector<Vector3> places = square.space.positions();
    double worst = 0;
    for (std::size_t i = 0; i < places.size(); ++i)  // away from where the square ends and paths slide along
      if ((places[i].head<2>().array() - 0.5).abs().maxCoeff() < 0.38 && square.shows(i))
        worst = std::max(worst, std::abs(found(Eigen::Index(i), 0) - linear(Eigen::Index(i), 0)));
    EXPECT_LT(worst, 1e-3);
  }
}

TEST(PathConvolution, IsTheMeanAlongStraightLines) {
  const double k = 2 * std::numbers::pi / 0.3, length = 0.1;
  for (const fixtures::CutOptions& options : cuts()) {
    const Combed square(options, 128, along);
    const PathConvolution lines(square.vectors, square.domain, square.field);
    const auto wave = [&](const Vector3& p) { return std::cos(k * along.dot(p)) + std::sin(25 * across.dot(p)); };
    const Signal found = lines.draw(square.signal(wave), length).signal;
    const int steps = int(std::ceil(length / square.space.scale().texel_spacing));
    double factor = 0, weights = 0;
    for (int j = -steps; j <= steps; ++j) {
      const double weight = 1 + std::cos(std::numbers::pi * j / (steps + 1));
      factor += weight * std::cos(k * length * j / steps);
      weights += weight;
    }
    factor /= weights;
    const std::vector<Vector3> places = square.space.positions();
    double worst = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      if ((places[i].head<2>().array() - 0.5).abs().maxCoeff() < 0.35 && square.shows(i))
        worst = std::max(worst, std::abs(found(Eigen::Index(i), 0) - factor * std::cos(k * along.dot(places[i])) -
                                         std::sin(25 * across.dot(places[i]))));
    EXPECT_LT(worst, 150 * std::pow(square.space.scale().texel_spacing, 2)) << options.parts << " " << square.space.scale().texel_spacing;
  }
}

TEST(PathConvolution, FadesWhereTheFieldIsWeakAndSaysWhatItDid) {
  const Combed square(fixtures::turned(fixtures::odd_angle, 2), 64, along);
  const Signal wave = square.signal([](const Vector3& p) { return std::cos(9 * p.x()); });
  const auto drawn = [&](double strength) {
    return PathConvolution(square.vectors, square.domain, strength * square.field).draw(wave, 0.1);
  };
  const ConvolvedPaths clear = drawn(1);
  EXPECT_GT(clear.counts.paths, 2 * square.space.size());
  const double mean = wave.mean();
  EXPECT_GT((clear.signal.array() - mean).abs().maxCoeff(), 0.5);
  for (const double strength : {0.0, 0.25, 5.0}) {
    const Signal wanted = (mean + std::min(strength, 1.0) * (clear.signal.array() - mean)).matrix();
    const Signal found = drawn(strength).signal;
    double worst = 0;
    for (Eigen::Index i = 0; i < found.rows(); ++i)
      if (square.shows(std::size_t(i))) worst = std::max(worst, std::abs(found(i, 0) - wanted(i, 0)));
    EXPECT_LT(worst, 1e-6) << strength;
  }
  const PathConvolution lines(square.vectors, square.domain, square.field);
  EXPECT_THROW(lines.draw(wave, 0), InvalidInput);
  EXPECT_THROW(lines.draw(Signal::Zero(3, 1), 1), InvalidInput);
}

}  // namespace
}  // namespace mq
