// Optical flow in the texels themselves: known motions over seams, and what must not move.

#include "mq/flow/cut_texture_flow.h"
#include "mq/flow/texture_flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "flow/moved_texture.h"

namespace mq {
namespace {

using fixtures::MovedTexture;
using fixtures::up_to;

TEST(TextureFlow, FindsHowATorusTurnsOverTheSeamsOfItsCharts) {
  const auto cut = fixtures::turned(fixtures::odd_angle, 2);
  const Mesh mesh = fixtures::cut_torus({.cells = 48, .parts = 2, .jitter = 0, .scale = cut.scale, .angle = cut.angle,
                                         .shift = cut.shift});
  const TextureSize size{160, 160};
  const double texel = MovedTexture(mesh, size, 2, [](const Vector3& p) { return p; }).space.scale().texel_spacing;
  for (const double texels : {1.0, 4.0, 12.0}) {
    const double angle = texels * texel;  // at a distance of 1 from the axis
    const MovedTexture moved(mesh, size, 2, fixtures::rotation(angle, Vector3::UnitZ()));
    const TextureFlow flow(moved.model->surface, moved.model->atlas, moved.space, moved.source, moved.target,
                           up_to(texels < 4 ? 8 : texels));
    EXPECT_LT(moved.end_point_error(flow.flow().field, fixtures::rotation(-angle, Vector3::UnitZ())), 0.1) << texels;
    EXPECT_LT(flow.flow().levels.back().error, 0.02 * flow.flow().blend_error);
  }
}

TEST(TextureFlow, FindsHowASphereTurns) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const Mesh mesh = fixtures::cut_sphere(24, cut);
  const TextureSize size{300, 200};
  const Vector3 axis(0.2, 0.3, 1);
  const double angle = 0.1;
  const MovedTexture moved(mesh, size, 2, fixtures::rotation(angle, axis));
  const TextureFlow flow(moved.model->surface, moved.model->atlas, moved.space, moved.source, moved.target, up_to(10));
  EXPECT_LT(moved.end_point_error(flow.flow().field, fixtures::rotation(-angle, axis)), 0.1);
}

TEST(TextureFlow, KeepsWhatDoesNotMoveBitForBit) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const MovedTexture still(fixtures::cut_sphere(12, cut), {96, 64}, 2, [](const Vector3& p) { return p; });
  const TextureFlow flow(still.model->surface, still.model->atlas, still.space, still.source, still.target);
  const WarpedPair met = flow.warp_pair(still.source, still.target, 0.5);
  EXPECT_TRUE(met.source == still.source);
  EXPECT_TRUE(met.target == still.target);
}

TEST(TextureFlow, SwappedTexturesMoveTheOtherWay) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const MovedTexture moved(fixtures::cut_sphere(24, cut), {150, 100}, 2, fixtures::rotation(0.05, Vector3::UnitZ()));
  const auto field = [&](const Signal& a, const Signal& b) {
    return TextureFlow(moved.model->surface, moved.model->atlas, moved.space, a, b, up_to(8)).flow().field;
  };
  const Vector there = field(moved.source, moved.target), back = field(moved.target, moved.source);
  EXPECT_LT((there + back).norm(), 1e-3 * there.norm());
}

/// Neither what both are brighter by, nor the contrast of one, nor the unit of length changes what is found, nor what is said
/// of it.
TEST(TextureFlow, DependsNeitherOnMeansNorOnUnits) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const Mesh mesh = fixtures::cut_sphere(12, cut);
  const auto flow_of = [&](double unit, const Eigen::RowVector3d& offset, double contrast = 1) {
    Mesh larger = mesh;
    for (Vector3& p : larger.positions) p *= unit;
    const MovedTexture moved(larger, {96, 64}, 2 / unit, fixtures::rotation(0.05, Vector3::UnitZ()));
    const Vector mass = moved.space.lumped_mass();
    const Eigen::RowVector3d mean = mass.transpose() * moved.target / mass.sum();
    const Signal source = moved.source.rowwise() + offset;
    const Signal target = (contrast * (moved.target.rowwise() - mean)).rowwise() + (mean + offset);
    return TextureFlow(moved.model->surface, moved.model->atlas, moved.space, source, target, up_to(6)).flow();
  };
  const MeshFlow flow = flow_of(1, {0, 0, 0});
  const double length = flow.field.norm();
  EXPECT_LT((flow_of(1, {5, -20, 1}).field - flow.field).norm(), 1e-3 * length);
  EXPECT_LT((flow_of(1, {5, -20, 1}, 0.5).field - flow.field).norm(), 0.02 * length);
  const MeshFlow scaled = flow_of(8, {0, 0, 0});
  EXPECT_LT((scaled.field / 8 - flow.field).norm(), 1e-3 * length);
  ASSERT_EQ(scaled.levels.size(), flow.levels.size());
  EXPECT_GT(flow.levels.back().smoothness, 0);
  EXPECT_NEAR(scaled.levels.back().smoothness / flow.levels.back().smoothness, 1, 1e-3);
  EXPECT_NEAR(scaled.levels.back().error / flow.levels.back().error, 1, 1e-3);
  for (const MeshFlowLevel& level : flow.levels) {
    EXPECT_GE(level.warp_seconds, 0);
  }
}

TEST(TextureFlow, FindsTheSameByItsOtherWays) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const double angle = 0.05;
  const MovedTexture moved(fixtures::cut_sphere(24, cut), {150, 100}, 2, fixtures::rotation(angle, Vector3::UnitZ()));
  const auto error_with = [&](const auto& change) {
    MeshFlowOptions options = up_to(8);
    change(options);
    const TextureFlow flow(moved.model->surface, moved.model->atlas, moved.space, moved.source, moved.target, options);
    return moved.end_point_error(flow.flow().field, fixtures::rotation(-angle, Vector3::UnitZ()));
  };
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.alignment = FlowAlignment::forward; }), 0.15);
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.robust_data = o.robust_smoothness = 0.5; }), 0.15);
  // Weights of what is robust are found anew as often as is asked for.
  const auto weighted = [&](int times) {
    return error_with([&](MeshFlowOptions& o) { o.robust_data = 0.05, o.reweightings = times; });
  };
  EXPECT_NE(weighted(1), weighted(4));
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.gradient_weight = 1; }), 0.15);
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.detail = {20, Length::Unit::percent}; }), 0.15);
}

/// On triangles of about a texel, and on larger ones, at whose corners are means.
TEST(CutTextureFlow, FindsHowASphereTurnsHoweverFarItIsCut) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const double angle = 0.06;
  const MovedTexture moved(fixtures::cut_sphere(12, cut), {96, 64}, 2, fixtures::rotation(angle, Vector3::UnitZ()));
  const Surface& surface = moved.model->surface;
  MeshFlowOptions options;
  options.largest = {10, Length::Unit::percent};
  options.detail = {0, Length::Unit::percent};
  for (const double edge : {1.5, 4.0}) {
    const CutTextureFlow flow(surface, moved.model->atlas, moved.space, moved.source, moved.target, options, edge);
    const TangentField field = flow.field();
    double error = 0, length = 0;
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 middle = (surface.mesh.position(t, 0) + surface.mesh.position(t, 1) + surface.mesh.position(t, 2)) / 3;
      const Vector3 truth = angle * Vector3::UnitZ().cross(middle);
      error += std::min((field[std::size_t(t)] - truth).norm(), (field[std::size_t(t)] + truth).norm());
      length += truth.norm();
    }
    EXPECT_LT(error, 0.1 * length) << edge;
    EXPECT_LT(flow.flow().levels.back().error, 0.02 * flow.flow().blend_error) << edge;
  }
}

TEST(TextureFlow, RefusesWhatOnlyTrianglesHave) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const MovedTexture still(fixtures::cut_sphere(6, cut), {48, 32}, 2, [](const Vector3& p) { return p; });
  MeshFlowOptions options;
  options.basis = FlowBasis::triangle;
  EXPECT_THROW(TextureFlow(still.model->surface, still.model->atlas, still.space, still.source, still.target, options),
               Unsupported);
  EXPECT_THROW(TextureFlow(still.model->surface, still.model->atlas, still.space, still.source,
                           Signal::Zero(3, 3)), InvalidInput);
}

}  // namespace
}  // namespace mq
