#include "mq/filter/texture_shock.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "atlas/atlas_fixtures.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/baseline/cut_texture_shock.h"
#include "mq/trace/trace_atlas.h"

namespace mq {
namespace {

using namespace fixtures;

/// A disc with a blurred rim on the unit square.
double disc(const Vector3& p) {
  return 0.5 - 0.4 * std::tanh(12 * (std::hypot(p.x() - 0.47, p.y() - 0.52) - 0.28));
}

Mesh scaled(Mesh mesh, double unit) {
  for (Vector3& p : mesh.positions) p *= unit;
  return mesh;
}

struct Sheet {
  Sheet(const CutOptions& options, int side, double unit = 1)
      : model(textured(scaled(cut_square(options), unit), {{side, side}})),
        space(model->surface, model->atlas),
        signal(space.size(), 2) {
    for (int i = 0; i < space.size(); ++i) {
      const auto& p = space.texels().positions[i];
      signal(i, 0) = disc(Vector3(p[0], p[1], p[2]) / unit);
      signal(i, 1) = 1 - 0.5 * signal(i, 0);
    }
  }
  ShockedTexture shock(double tau) const {
    return texture_shock(model->surface, model->atlas, space, signal,
                         {.weights = {1e-4, 1e-4}, .time = {ShockTime::Unit::relative, tau}});
  }
  /// A channel of a signal at a point of the surface.
  double at(const Signal& values, int t, const Vector3& b) const {
    double sum = 0;
    for (const auto& [texel, weight] : space.basis_at(t, b)) sum += weight * values(texel, 0);
    return sum;
  }
  std::unique_ptr<Textured> model;
  TexelSpace space;
  Signal signal;
};

/// Noise: what is stored outside charts is not what is on the surface beside.
Signal noise_of(const TexelSpace& space) {
  Signal signal(space.size(), 2);
  const Random random(7);
  for (int i = 0; i < space.size(); ++i)
    for (int c = 0; c < 2; ++c) signal(i, c) = random.uniform(std::uint64_t(2 * i + c));
  return signal;
}

TEST(TextureShock, IsTheSameHoweverTheSurfaceIsCutIntoCharts) {
  const Sheet whole({.cells = 12, .parts = 1, .scale = 0.9}, 200);
  const Sheet cut({.cells = 12, .parts = 3, .scale = 0.62, .angle = odd_angle}, 290);
  const ShockedTexture one = whole.shock(3), many = cut.shock(3);
  EXPECT_NEAR(one.rate, many.rate, 0.05 * one.rate);
  double difference = 0, change = 0, seams = 0;
  int count = 0, at_seams = 0;
  for (int t = 0; t < whole.model->surface.triangle_count(); ++t) {
    for (const Vector3& b :
         {Vector3(1, 1, 1), Vector3(4, 1, 1), Vector3(1, 4, 1), Vector3(1, 1, 4)}) {
      const Vector3 at = b / b.sum();
      const double first = whole.at(one.signal, t, at), second = cut.at(many.signal, t, at);
      difference += std::abs(first - second);
      change += std::abs(first - whole.at(whole.signal, t, at));
      ++count;
    }
    // On edges of the triangle, among them all seams: both sides must be near the uncut one.
    for (int k = 0; k < 3; ++k) {
      if (cut.model->atlas.edges[3 * t + k] != EdgeKind::seam) continue;
      Vector3 at = Vector3::Zero();
      at[k] = at[(k + 1) % 3] = 0.5;
      seams += std::abs(whole.at(one.signal, t, at) - cut.at(many.signal, t, at));
      ++at_seams;
    }
  }
  EXPECT_GT(change / count, 0.02);
  EXPECT_LT(difference / count, 0.15 * change / count);
  ASSERT_GT(at_seams, 50);
  EXPECT_LT(seams / at_seams, 0.15 * change / count);
}

TEST(TextureShock, NeverLeavesTheRangeAndKeepsConstants) {
  const Sheet sheet({.cells = 6, .parts = 2, .scale = 0.7, .angle = odd_angle}, 64);
  for (const double tau : {0.5, 10.0, 1e6}) {
    const ShockedTexture shocked = sheet.shock(tau);
    EXPECT_EQ(shocked.counts.cut_short, 0);
    EXPECT_EQ(shocked.counts.paths, sheet.space.size());
    for (int c = 0; c < 2; ++c) {
      EXPECT_LE(shocked.signal.col(c).maxCoeff(), sheet.signal.col(c).maxCoeff());
      EXPECT_GE(shocked.signal.col(c).minCoeff(), sheet.signal.col(c).minCoeff());
    }
  }
  EXPECT_EQ(sheet.shock(0).signal, sheet.signal);
  const Signal constant = Signal::Constant(sheet.space.size(), 3, 0.3);
  EXPECT_EQ(texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, constant,
                          {.weights = {1e-4, 1e-4}, .time = {ShockTime::Unit::absolute, 1e6}})
                .signal,
            constant);
}

TEST(TextureShock, LeavesOutlinesAsSmoothAsTexelsAllow) {
  const Sheet sheet({.cells = 14, .parts = 1, .jitter = 0, .scale = 0.65, .angle = odd_angle}, 160);
  const double texel = std::sqrt(1.0 / sheet.space.size());
  const auto beyond = [&](int i) {
    const auto& p = sheet.space.texels().positions[i];
    return (std::hypot(p[0] - 0.47, p[1] - 0.52) - 0.28) / texel;
  };
  Signal blurred(sheet.space.size(), 1);
  for (int i = 0; i < sheet.space.size(); ++i) blurred(i, 0) = 0.5 - 0.4 * std::tanh(beyond(i) / 2);
  /// How far from the outline texels have come to be on the other side of it.
  const auto teeth = [&](const Signal& sharp) {
    double most = 0;
    for (int i = 0; i < sheet.space.size(); ++i)
      if ((sharp(i, 0) > 0.5) != (blurred(i, 0) > 0.5)) most = std::max(most, std::abs(beyond(i)));
    return most;
  };
  const ShockWeights weights{1e-5, 1e-5};
  const ShockTime time{ShockTime::Unit::relative, 4};
  const auto cut = [&](double longest_edge) {
    return teeth(cut_texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, blurred,
                                   {.weights = weights, .time = time, .longest_edge = longest_edge})
                     .signal);
  };
  const double found = teeth(texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, blurred,
                                           {.weights = weights, .time = time})
                                 .signal);
  const double fine = cut(0.7), coarse = cut(1.4);
  RecordProperty("teeth", fmt::format("{:.3f}; cut to 0.7 texels {:.3f}, to 1.4 {:.3f}", found, fine, coarse));
  // Outlines stay where they were.
  EXPECT_LT(found, 0.1);
  EXPECT_GT(fine, 0.2);
  EXPECT_GT(coarse, 0.35);
}

/// Of a texel on the rim of a disc as much is of the disc's value as lies in it.
TEST(TextureShock, LeavesTexelsOnAnOutlineTheMeanOfBothSides) {
  const Sheet sheet({.cells = 14, .parts = 1, .jitter = 0, .scale = 0.65, .angle = odd_angle}, 160);
  const double texel = std::sqrt(1.0 / sheet.space.size());
  Vector beyond(sheet.space.size());
  Signal blurred(sheet.space.size(), 1);
  for (int i = 0; i < sheet.space.size(); ++i) {
    const auto& p = sheet.space.texels().positions[i];
    beyond[i] = (std::hypot(p[0] - 0.47, p[1] - 0.52) - 0.28) / texel;
    blurred(i, 0) = 0.5 - 0.4 * std::tanh(beyond[i] / 2);
  }
  const Signal sharp =
      texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, blurred,
                    {.weights = {1e-5, 1e-5}, .time = {ShockTime::Unit::relative, 4}})
          .signal;
  double error = 0;
  int count = 0;
  for (int i = 0; i < sheet.space.size(); ++i) {
    if (std::abs(beyond[i]) > 0.45) continue;
    error += std::abs(sharp(i, 0) - (0.5 - 0.8 * beyond[i] / 1.1));
    ++count;
  }
  EXPECT_LT(error / count, 0.15);  // 0.24 where a texel is of one side or the other
}

TEST(TextureShock, DoesNotDependOnTheUnitOfLength) {
  // Edges and texels everywhere in line, so that rounding would have much to decide.
  const CutOptions options{.cells = 8, .parts = 2, .jitter = 0, .scale = 0.75};
  const auto noise_sharpened = [&](double unit) {
    const Sheet sheet(options, 96, unit);
    return texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space,
                         noise_of(sheet.space),
                         {.weights = {1e-4 * unit * unit, 1e-4 * unit * unit},
                          .time = {ShockTime::Unit::relative, 2}})
        .signal;
  };
  const Signal expected = noise_sharpened(1);
  EXPECT_EQ(noise_sharpened(128), expected);
  EXPECT_EQ(noise_sharpened(1.0 / 1024), expected);
  // Paths that begin as near to a ridge as positions are known may go down on either side of it.
  for (const double unit : {100.0, 0.3}) {
    const auto apart = ((noise_sharpened(unit) - expected).cwiseAbs().array() > 1e-4).count();
    EXPECT_LE(apart, expected.size() / 5000) << unit;
  }
}

TEST(TextureShock, LeavesEveryTexelAtTimeZero) {
  const Sheet sheet({.cells = 6, .parts = 3, .scale = 0.62, .angle = odd_angle}, 90);
  const Signal noise = noise_of(sheet.space);
  for (const auto unit : {ShockTime::Unit::relative, ShockTime::Unit::absolute})
    EXPECT_EQ(texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, noise,
                            {.weights = {1e-4, 1e-4}, .time = {unit, 0}})
                  .signal,
              noise);
}

TEST(TextureShock, MovesNoTexelFurtherThanItsPathGoes) {
  const Sheet sheet({.cells = 6, .parts = 3, .scale = 0.62, .angle = odd_angle}, 90);
  const Signal noise = noise_of(sheet.space);
  // The largest change is in proportion to the time while paths are short, rim or not.
  const auto change = [&](double time) {
    const ShockedTexture shocked =
        texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, noise,
                      {.weights = {1e-4, 1e-4}, .time = {ShockTime::Unit::relative, time}});
    return (shocked.signal - noise).cwiseAbs().maxCoeff();
  };
  const double least = change(1e-6);
  EXPECT_GT(least, 0);
  EXPECT_LT(least, 1e-3);
  EXPECT_LT(change(1e-4), 150 * least);
  EXPECT_GT(change(1), 0.1);
}

TEST(TextureShock, AgreesWithVerticesWhereTheMeshIsAsFine) {
  // A mesh whose vertices are texels: what is looked up differs by interpolation only.
  const Sheet sheet({.cells = 64, .parts = 1, .jitter = 0, .scale = 0.9}, 71);
  const Surface& surface = sheet.model->surface;
  const VertexSpace vertices(surface);
  Signal phi(vertices.size(), 1);
  for (int v = 0; v < phi.rows(); ++v) phi(v, 0) = disc(surface.mesh.positions[v]);
  const TraceMesh mesh(surface);
  const Shocked expected =
      transport_shock(mesh, vertices, phi, {1e-4, 1e-4}, {ShockTime::Unit::relative, 2});
  const ShockedTexture found = sheet.shock(2);
  double difference = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    difference += std::abs(sheet.at(found.signal, t, Vector3(1, 0, 0)) -
                           expected.signal(surface.mesh.triangles[t][0], 0));
  EXPECT_LT(difference / surface.triangle_count(), 0.01);
}

TEST(TextureShock, DoesNotDependOnTheSizeOfTheTexture) {
  const CutOptions options{.cells = 12, .parts = 3, .scale = 0.62, .angle = odd_angle};
  const Sheet coarse(options, 256), fine(options, 512);
  const auto shocked = [](const Sheet& sheet) {
    return texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, sheet.signal,
                         {.weights = {2e-4, 2e-4}, .time = {ShockTime::Unit::relative, 0.5}});
  };
  const ShockedTexture one = shocked(coarse), other = shocked(fine);
  EXPECT_NEAR(one.rate, other.rate, 0.01 * other.rate);
  EXPECT_NEAR(one.time, other.time, 0.01 * other.time);
  double difference = 0, change = 0;
  for (int t = 0; t < coarse.model->surface.triangle_count(); ++t)
    for (const Vector3& b : {Vector3(1, 1, 1), Vector3(4, 1, 1), Vector3(1, 4, 1), Vector3(1, 1, 4)}) {
      const Vector3 at = b / b.sum();
      difference += std::abs(coarse.at(one.signal, t, at) - fine.at(other.signal, t, at));
      change += std::abs(fine.at(other.signal, t, at) - fine.at(fine.signal, t, at));
    }
  EXPECT_LT(difference, 0.03 * change);
}

TEST(TextureShock, DoesNotDependOnHowTheSurfaceIsCutIntoTriangles) {
  // Without seams nothing does; basis functions next to seams, to a quarter of a texel, do a little.
  for (const auto& [parts, of_rate, of_values] : {std::tuple(1, 1e-9, 1e-6), std::tuple(2, 1e-4, 3e-3)}) {
    const auto shocked = [&](int cells) {
      const Sheet sheet(
          {.cells = cells, .parts = parts, .jitter = 0, .scale = 0.5, .angle = odd_angle, .shape = sheared}, 128);
      return sheet.shock(2);
    };
    const ShockedTexture one = shocked(4), other = shocked(16);
    EXPECT_NEAR(one.rate, other.rate, of_rate * one.rate);
    ASSERT_EQ(one.signal.rows(), other.signal.rows());
    EXPECT_LT((one.signal - other.signal).cwiseAbs().mean(), of_values) << parts;
  }
}

TEST(TextureShock, LeavesNoSeamWhereEdgesCrossOne) {
  const Sheet sheet({.cells = 12, .parts = 3, .scale = 0.62, .angle = odd_angle}, 290);
  const ShockedTexture shocked = sheet.shock(4);
  const TraceAtlas domain(sheet.model->surface, sheet.model->atlas, sheet.space);
  const auto across = [&](const Signal& signal) {
    double sum = 0, length = 0;
    domain.for_each_seam([&](double seam, const TraceAtlas::SeamPlaces& places) {
      for (double s = 0.05; s < 1; s += 0.1) {
        double difference = 0;
        const auto [here, there] = places(s);
        domain.for_each_corner(here, [&](int i, double w) { difference += w * signal(i, 0); });
        domain.for_each_corner(there, [&](int i, double w) { difference -= w * signal(i, 0); });
        sum += seam * difference * difference;
        length += seam;
      }
    });
    return std::sqrt(sum / length);
  };
  const Signal cut = cut_texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, sheet.signal,
                                       {.weights = {1e-4, 1e-4}, .time = {ShockTime::Unit::relative, 4}})
                         .signal;
  EXPECT_LT(across(shocked.signal), 0.6 * across(cut));
}

TEST(TextureShock, PreparedOnceGivesTheBitsOfEachTime) {
  const Sheet sheet({.cells = 12, .parts = 2, .scale = 0.7}, 150);
  const TextureShock prepared(sheet.model->surface, sheet.model->atlas, sheet.space, sheet.signal,
                              {.weights = {1e-4, 1e-4}, .time = {}});
  for (const double tau : {2.0, 0.5, 0.0}) {
    const ShockedTexture one = sheet.shock(tau), other = prepared.at({ShockTime::Unit::relative, tau});
    EXPECT_TRUE(one.signal == other.signal);
    EXPECT_EQ(one.time, other.time);
    EXPECT_EQ(one.counts.triangles, other.counts.triangles);
  }
}

TEST(TextureShock, KeepsThePotentialThatPathsRunDown) {
  const Sheet sheet({.cells = 12, .parts = 2, .scale = 0.7}, 60);
  const TextureShock prepared(sheet.model->surface, sheet.model->atlas, sheet.space, sheet.signal,
                              {.weights = {1e-4, 1e-4}, .time = {}});
  EXPECT_TRUE(prepared.potential() == shock_potential(sheet.space, sheet.signal, {1e-4, 1e-4}));
  EXPECT_GT(prepared.potential().maxCoeff(), 100 * std::abs(prepared.potential().minCoeff()));
}

TEST(TextureShock, RefusesValuesWhoseSlopesSquaredAreNoNumbers) {
  const Sheet sheet({.cells = 12, .parts = 2, .scale = 0.7}, 60);
  EXPECT_THROW(texture_shock(sheet.model->surface, sheet.model->atlas, sheet.space, 1e30 * sheet.signal,
                             {.weights = {}, .time = {}}),
               InvalidInput);
}

}  // namespace
}  // namespace mq
