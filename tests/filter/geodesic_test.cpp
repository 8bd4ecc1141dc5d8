// Distances by the heat method against what they are on the square, the cylinder and the sphere,
// for texels and for vertices.

#include "mq/filter/geodesic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "atlas/laid_strips.h"
#include "filter/geodesic_squares.h"
#include "mq/atlas/separate_overlaps.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/direct.h"
#include "mq/linear/direct_solver.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

using fixtures::CutOptions;
using fixtures::four_charts;
using fixtures::nearest;
using fixtures::places_of;
using fixtures::position;
using fixtures::whole_square;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

using std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Errors {
  double mean = 0, max = 0;
};

/// Relative errors at random points of the surface that are more than three texels away.
Errors errors(const fixtures::Textured& model, const TexelSpace& space, const Vector& distance,
              const std::function<double(const Vector3&)>& exact) {
  const Random random(5);
  Errors result;
  int count = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const int t = int(random.bits(1'000'000 + k) % std::uint64_t(model.surface.triangle_count()));
    const Vector3 l = fixtures::random_point(random, k);
    const double d = exact(fixtures::on_surface(model.surface.mesh, t, l));
    if (d < 3 * space.scale().texel_spacing) continue;
    const double e = std::abs(fixtures::value_at(space, distance, t, l) - d) / d;
    result.mean += e;
    result.max = std::max(result.max, e);
    ++count;
  }
  result.mean /= count;
  return result;
}

Geodesic distances(const TexelSpace& space, int source) {
  return GeodesicDistance(space).from({{source, 0}});
}

Errors errors_on_square(const CutOptions& options, int texels, const Vector3& near) {
  const int side = int(std::lround(texels / options.scale));
  const auto model = fixtures::textured(fixtures::cut_square(options), {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const int source = nearest(space.texels(), near);
  const Vector3 from = position(space.texels(), source);
  const Geodesic found = distances(space, source);
  EXPECT_EQ(found.unreached, 0);
  EXPECT_LE(found.sweeps, 30);
  EXPECT_LE(found.change, 1e-3);
  return errors(*model, space, found.distance, [&](const Vector3& p) { return (p - from).norm(); });
}

TEST(GeodesicDistance, IsRightToHalfAPercentOnTheSquare) {
  const Vector3 middle(0.5, 0.5, 0);
  const Errors coarse = errors_on_square(whole_square(), 128, middle),
               fine = errors_on_square(whole_square(), 256, middle);
  EXPECT_LE(coarse.mean, 0.005);
  EXPECT_LE(coarse.max, 0.05);
  EXPECT_LE(fine.mean, 0.0025);
  EXPECT_LE(fine.max, 0.05);
}

/// The texels around a point that no texel lies at, as sources.
std::vector<GeodesicSource> around(const fixtures::Textured& model, const TexelSpace& space,
                                   const Vector3& place) {
  const ClosestPoint closest = ClosestPointFinder(model.surface.mesh)(place);
  std::vector<GeodesicSource> sources;
  for (const BasisWeight& w : space.basis_at(closest.triangle, closest.barycentric))
    if (w.weight > 1e-3)
      sources.push_back({w.unknown, (position(space.texels(), w.unknown) - place).norm(), place});
  return sources;
}

Geodesic distances_from_point(const fixtures::Textured& model, const TexelSpace& space,
                              const Vector3& place) {
  return GeodesicDistance(space).from(around(model, space, place));
}

/// Wherever between texels the source lies and however the square is cut. The last is 13 texels
/// from an edge, along which heat runs from there.
TEST(GeodesicDistance, DoesNotDependOnWhereBetweenTexelsTheSourceLies) {
  for (const CutOptions& options : {whole_square(), four_charts(), fixtures::slanted()})
    for (const Vector3& from : {Vector3(0.503, 0.5021, 0), Vector3(0.50390625, 0.50390625, 0),
                                Vector3(0.31, 0.42, 0), Vector3(0.5, 0.1, 0)}) {
      const int side = int(std::lround(128 / options.scale));
      const auto model = fixtures::textured(fixtures::cut_square(options), {{side, side}});
      const TexelSpace space(model->surface, model->atlas);
      const Vector distance = distances_from_point(*model, space, from).distance;
      const auto exact = [&](const Vector3& p) { return (p - from).norm(); };
      const Errors found = errors(*model, space, distance, exact);
      const bool is_near_edge = from.y() < 0.2;
      EXPECT_LE(found.mean, is_near_edge ? 0.006 : 0.004) << from.transpose();
      EXPECT_LE(found.max, is_near_edge ? 0.1 : 0.05) << from.transpose();
      // At the corners, which heat that does not leave rounds off by two or three texels.
      for (int t = 0; t < model->surface.triangle_count(); ++t)
        for (int k = 0; k < 3; ++k) {
          const Vector3& p = model->surface.mesh.position(t, k);
          if (p.x() != std::round(p.x()) || p.y() != std::round(p.y())) continue;
          EXPECT_NEAR(fixtures::value_at(space, distance, t, Vector3::Unit(k)), exact(p), 1.0 / 128)
              << from.transpose();
        }
    }
}

/// On texels that are 8, 16 and 64 times as long as wide, either way, the error is still a part of the longer side. With
/// heat that spreads by the mean of both sides it is 12 of them.
TEST(GeodesicDistance, IsRightWhereTexelsAreMuchLongerThanWide) {
  const Vector3 from(0.4, 0.4, 0);
  for (const TextureSize size : {TextureSize{64, 512}, {512, 32}, {16, 1024}}) {
    const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {size});
    const TexelSpace space(model->surface, model->atlas);
    const Geodesic found = distances_from_point(*model, space, from);
    EXPECT_LE(found.change, 1e-3) << size.width;
    const double longer = 1.0 / std::min(size.width, size.height);
    double most = 0, sum = 0;
    for (int i = 0; i < space.size(); ++i) {
      const double miss = std::abs(found.distance[i] - (position(space.texels(), i) - from).norm()) / longer;
      most = std::max(most, miss), sum += miss;
    }
    EXPECT_LE(most, 2) << size.width;
    EXPECT_LE(sum / space.size(), 0.5) << size.width;
  }
}

TEST(GeodesicDistance, HardlyNoticesSeams) {
  const Vector3 aside(0.31, 0.42, 0);
  const Errors whole = errors_on_square(whole_square(), 128, aside),
               cut = errors_on_square(four_charts(), 128, aside),
               slanted = errors_on_square(fixtures::slanted(), 128, aside);
  EXPECT_LE(cut.mean, 1.1 * whole.mean);
  EXPECT_LE(cut.max, 0.05);
  EXPECT_LE(slanted.mean, 1.5 * whole.mean);
  EXPECT_LE(slanted.max, 0.08);
}

/// A square rolled up: x around, y along; the circumference is 1.
Mesh rolled(const CutOptions& options) {
  Mesh mesh = fixtures::cut_square(options);
  for (Vector3& p : mesh.positions) {
    const double angle = p.x() == 1 ? 0 : 2 * pi * p.x();
    p = {std::cos(angle) / (2 * pi), std::sin(angle) / (2 * pi), p.y()};
  }
  return mesh;
}

TEST(GeodesicDistance, TakesTheShorterWayAroundACylinder) {
  for (const CutOptions& base : {whole_square(), four_charts()}) {
    std::vector<double> mean;
    for (const int texels : {64, 128, 256}) {
      CutOptions options = base;
      options.cells = 96;
      options.jitter = 0;
      const int side = int(std::lround(texels / options.scale));
      const auto model = fixtures::textured(rolled(options), {{side, side}});
      const TexelSpace space(model->surface, model->atlas);
      const int source = nearest(space.texels(), {-1 / (2 * pi), 0.02, 0.4});
      const auto unrolled = [](const Vector3& p) {
        return Vector2(std::atan2(p.y(), p.x()) / (2 * pi), p.z());
      };
      const Vector2 from = unrolled(position(space.texels(), source));
      const Geodesic found = distances(space, source);
      const Errors e = errors(*model, space, found.distance, [&](const Vector3& p) {
        const Vector2 d = unrolled(p) - from;
        return std::hypot(d.x() - std::round(d.x()), d.y());
      });
      mean.push_back(e.mean);
      EXPECT_LE(e.max, 0.1) << texels;
    }
    EXPECT_LE(mean[2], 0.004);
    EXPECT_GE(std::log2(mean[0] / mean[2]) / 2, 0.8) << mean[0] << ' ' << mean[1] << ' ' << mean[2];
  }
}

/// Near its rim, along which heat would run.
TEST(GeodesicDistance, IsRightAlongTheRimOfACylinder) {
  CutOptions options = four_charts();
  options.cells = 96;
  options.jitter = 0;
  const int side = int(std::lround(128 / options.scale));
  const auto model = fixtures::textured(rolled(options), {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const Vector3 from = model->surface.mesh.positions[std::size_t(96 / 2 + 97 * 2)];
  const auto unrolled = [](const Vector3& p) {
    return Vector2(std::atan2(p.y(), p.x()) / (2 * pi), p.z());
  };
  const Errors found = errors(*model, space, distances_from_point(*model, space, from).distance,
                              [&](const Vector3& p) {
                                const Vector2 d = unrolled(p) - unrolled(from);
                                return std::hypot(d.x() - std::round(d.x()), d.y());
                              });
  EXPECT_LE(found.mean, 0.008);
}

TEST(GeodesicDistance, IsAnArcOnTheSphere) {
  CutOptions options;
  options.scale = 0.6;
  options.angle = fixtures::odd_angle;
  std::vector<double> mean;
  for (const int side : {40, 80}) {
    const auto model =
        fixtures::textured(fixtures::cut_sphere(side / 2, options), {{3 * side, 2 * side}});
    const TexelSpace space(model->surface, model->atlas);
    const int source = nearest(space.texels(), Vector3(0.3, 0.5, 0.8).normalized());
    const Vector3 from = position(space.texels(), source).normalized();
    const Geodesic found = distances(space, source);
    mean.push_back(errors(*model, space, found.distance, [&](const Vector3& p) {
                     return std::atan2(from.cross(p).norm(), from.dot(p));
                   }).mean);
  }
  EXPECT_LE(mean[0], 0.01);
  EXPECT_LE(mean[1], 0.006);
}

TEST(GeodesicDistance, IsAnArcOnASphereOfVertices) {
  CutOptions options;
  std::vector<double> mean;
  for (const int n : {16, 48}) {
    const Surface surface = make_surface(fixtures::cut_sphere(n, options));
    const VertexSpace space(surface);
    const Vector3 from = surface.mesh.positions[7];
    const Geodesic found = GeodesicDistance(space).from({{7, 0}});
    double sum = 0;
    for (int v = 0; v < space.size(); ++v) {
      const Vector3& p = surface.mesh.positions[v];
      sum += std::abs(found.distance[v] - std::atan2(from.cross(p).norm(), from.dot(p)));
    }
    mean.push_back(sum / space.size() / (pi / 2));
  }
  EXPECT_LE(mean[0], 0.03);
  EXPECT_GE(std::log(mean[0] / mean[1]) / std::log(3.0), 0.8) << mean[0] << ' ' << mean[1];
}

// ------------------------------------------------------------------------ charts that share texels

/// Distances from a point near the strip's left end, at points all over it, and their errors there.
struct AlongStrip {
  std::vector<double> found;
  Errors errors;
};

AlongStrip along_strip(const Surface& surface, const Atlas& atlas) {
  const Vector3 from(0.03, 0.11, 0);
  const TexelSpace space(surface, atlas);
  const auto model = std::make_unique<fixtures::Textured>(fixtures::Textured{surface, atlas});
  const Vector distance = distances_from_point(*model, space, from).distance;
  const Random random(5);
  AlongStrip result;
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const int t = int(random.bits(1'000'000 + k) % std::uint64_t(surface.triangle_count()));
    const Vector3 l = fixtures::random_point(random, k);
    result.found.push_back(fixtures::value_at(space, distance, t, l));
  }
  result.errors =
      errors(*model, space, distance, [&](const Vector3& p) { return (p - from).norm(); });
  return result;
}

std::unique_ptr<fixtures::Textured> laid(const fixtures::StripOptions& options) {
  return fixtures::textured(fixtures::laid_strip(options), {options.size});
}

/// A strip of length 2 and width 1/4, its halves side by side in the texture: moved by whole texels
/// they are discretised alike, so distances are what they are where nothing is shared.
TEST(GeodesicDistance, IsTheSameWhereChartsThatShareTexelsAreLaidApart) {
  const auto apart = laid(fixtures::two_halves(18.5));
  ASSERT_FALSE(separate_overlaps(apart->surface, apart->atlas));
  const AlongStrip wanted = along_strip(apart->surface, apart->atlas);
  EXPECT_LE(wanted.errors.mean, 0.02);
  for (const double gap : {0.5, -0.5, -9.5}) {  // half a texel apart, overlapping, on one another
    const auto near = laid(fixtures::two_halves(gap));
    const auto moved = separate_overlaps(near->surface, near->atlas);
    ASSERT_TRUE(moved);
    const AlongStrip found = along_strip(near->surface, moved->atlas);
    for (std::size_t k = 0; k < wanted.found.size(); ++k)
      EXPECT_NEAR(found.found[k], wanted.found[k], 1e-5) << gap;
    // Where they share texels, heat takes the short way.
    EXPECT_GE(along_strip(near->surface, near->atlas).errors.mean, 0.2) << gap;
  }
}

TEST(GeodesicDistance, GoesAroundAChartThatIsBentBackOnItself) {
  const auto far = laid(fixtures::bent_back(4)), near = laid(fixtures::bent_back(0.6));
  const auto moved = separate_overlaps(near->surface, near->atlas);
  ASSERT_TRUE(moved);
  const Errors wanted = along_strip(far->surface, far->atlas).errors,
               found = along_strip(near->surface, moved->atlas).errors;
  // The narrower the gap, the more the bend's inner side is squeezed: 1.6 % at 1, 0.6 % at 2.2.
  EXPECT_LE(wanted.mean, 0.01);
  EXPECT_LE(found.mean, 0.025);
  EXPECT_GE(along_strip(near->surface, near->atlas).errors.mean, 0.2);
}

TEST(GeodesicDistance, GoesTwiceAroundARepeatingTexture) {
  const auto twice = laid(fixtures::around_twice());
  const auto unrolled = separate_overlaps(twice->surface, twice->atlas);
  ASSERT_TRUE(unrolled);
  EXPECT_LE(along_strip(twice->surface, unrolled->atlas).errors.mean, 0.02);
}

/// Within 3√t, six texels, of the far edge values are continued from inside by `fast_marching_distances`,
/// as everywhere at boundaries, which is felt for as many more.
double tolerance_at(int column) { return column < 96 - 12 ? 1e-4 : 5e-4; }

TEST(GeodesicDistance, IsThatToTheNearestOfManySources) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{96, 96}});
  const TexelSpace space(model->surface, model->atlas);
  std::vector<GeodesicSource> edge;
  for (int i = 0; i < space.size(); ++i)
    if (space.texels().places[i].x < 8) edge.push_back({i, 0});
  const Geodesic found = GeodesicDistance(space, direct_solver(), {.tolerance = 1e-5}).from(edge);
  for (int i = 0; i < space.size(); ++i) {
    const int column = space.texels().places[i].x;
    EXPECT_NEAR(found.distance[i], std::max(0, column - 7) / 96.0, tolerance_at(column));
  }
}

TEST(GeodesicDistance, BeginsAtTheDistancesThatSourcesHave) {
  const auto model = fixtures::textured(fixtures::cut_square(whole_square()), {{96, 96}});
  const TexelSpace space(model->surface, model->atlas);
  std::vector<GeodesicSource> edge;
  for (int i = 0; i < space.size(); ++i)
    if (space.texels().places[i].x == 0) edge.push_back({i, 0.25});
  const Geodesic found = GeodesicDistance(space, direct_solver(), {.tolerance = 1e-5}).from(edge);
  for (int i = 0; i < space.size(); ++i) {
    const int column = space.texels().places[i].x;
    EXPECT_NEAR(found.distance[i], 0.25 + column / 96.0, tolerance_at(column));
  }
}

TEST(GeodesicDistance, IsInfiniteWhereNoPathLeads) {
  const Mesh torn = fixtures::torn(fixtures::cut_square(four_charts()));
  const auto model = fixtures::textured(torn, {{64, 64}});
  const TexelSpace space(model->surface, model->atlas);
  const int source = 0, own = space.texels().chart[source];
  const Geodesic found = GeodesicDistance(space).from({{source, 0}});
  int elsewhere = 0;
  for (int i = 0; i < space.size(); ++i) {
    EXPECT_EQ(std::isinf(found.distance[i]), space.texels().chart[i] != own);
    elsewhere += space.texels().chart[i] != own;
  }
  EXPECT_EQ(found.unreached, elsewhere);
}

TEST(GeodesicDistance, IsFoundByMultigridOnPartsOfAFewTexels) {
  // The constants of each part are in the null space, and single precision must not look for them.
  const Mesh torn = fixtures::torn(fixtures::cut_square(four_charts()));
  const auto model = fixtures::textured(torn, {{40, 40}});
  const TexelSpace space(model->surface, model->atlas);
  const SolverFactory multigrid = multigrid_solver(space.texels(), {.tolerance = 1e-7});
  const Geodesic found = GeodesicDistance(space, multigrid).from({{0, 0}});
  const Geodesic exact = GeodesicDistance(space).from({{0, 0}});
  EXPECT_TRUE(found.report.converged);
  EXPECT_LE(found.report.cycles, 10);
  for (int i = 0; i < space.size(); ++i)
    if (std::isfinite(exact.distance[i])) {
      EXPECT_NEAR(found.distance[i], exact.distance[i], 1e-5);
    }
}

TEST(GeodesicDistance, GrowsWithTheSurface) {
  Mesh mesh = fixtures::torus(40, 30);
  const Vector small = GeodesicDistance(VertexSpace(make_surface(mesh))).from({{3, 0}}).distance;
  for (Vector3& p : mesh.positions) p *= 1024;
  const Vector large = GeodesicDistance(VertexSpace(make_surface(mesh))).from({{3, 0}}).distance;
  EXPECT_LE((large / 1024 - small).cwiseAbs().maxCoeff(), 1e-9);
}

/// Single precision on coarser levels, whose squares of areas leave its range long before the areas do.
/// (Below 1e-18 places, which are in single precision too, are off by a part of a texel.)
TEST(GeodesicDistance, IsFoundByMultigridInAnyUnit) {
  const auto in_unit = [](double unit) {
    Mesh mesh = fixtures::cut_square(four_charts());
    for (Vector3& p : mesh.positions) p *= unit;
    const auto model = fixtures::textured(mesh, {{96, 96}});
    const TexelSpace space(model->surface, model->atlas);
    return Vector(GeodesicDistance(space, multigrid_solver(space.texels())).from({{100, 0}}).distance / unit);
  };
  const Vector wanted = in_unit(1);
  for (const double unit : {0x1p37, 0x1p40, 0x1p-55})
    EXPECT_LE((in_unit(unit) - wanted).cwiseAbs().maxCoeff(), 1e-6 * wanted.maxCoeff()) << unit;
}

TEST(GeodesicDistance, HasTheSameBitsForAnyNumberOfThreads) {
  const auto model = fixtures::textured(fixtures::cut_square(four_charts()), {{160, 160}});
  std::vector<Vector> found;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    const TexelSpace space(model->surface, model->atlas);
    found.push_back(distances(space, 100).distance);
  }
  EXPECT_TRUE(found[0] == found[1] && found[0] == found[2]);
}

TEST(GeodesicDistance, RefusesSourcesThatAreNone) {
  const VertexSpace space(make_surface(fixtures::torus(10, 8)));
  const GeodesicDistance geodesic(space);
  EXPECT_THAT([&] { geodesic.from({}); },
              ThrowsMessage<InvalidInput>(HasSubstr("at least one source")));
  EXPECT_THAT(
      [&] {
        geodesic.from({{80, 0}});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("source 80 is none of the 80 unknowns")));
  EXPECT_THROW(geodesic.from({{0, std::nan("")}}), InvalidInput);
  EXPECT_THROW(geodesic.from({{0, -1}}), InvalidInput);
  EXPECT_THROW(GeodesicDistance(space, direct_solver(), {.time = 0}), InvalidInput);
}

}  // namespace
}  // namespace mq
