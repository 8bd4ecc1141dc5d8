// Optical flow in the texels themselves: known motions over seams, and what must not move.

#include "mq/flow/texture_flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "flow/moved_signals.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

/// Three channels of smooth noise at the texels, moved along.
struct MovedTexture {
  MovedTexture(const Mesh& mesh, const TextureSize& size, double waves, const fixtures::Motion& back)
      : model(fixtures::textured(mesh, {size})), space(model->surface, model->atlas) {
    const Noise noise(7);
    for (Signal* signal : {&source, &target}) {
      signal->resize(space.size(), 3);
      for (int i = 0; i < space.size(); ++i) {
        const Vector3 place = space.texels().position(i);
        const Vector3 p = waves * (signal == &source ? place : back(place));
        for (int c = 0; c < 3; ++c) (*signal)(i, c) = noise(p + Vector3(31.4, 7.3, 3.7) * c);
      }
    }
  }

  /// Mean distance, in texels, of the ends of paths to where their texels truly go.
  double end_point_error(const Vector& field, const fixtures::Motion& truth) const {
    const TraceAtlas domain(model->surface, model->atlas, space);
    const TexelVectorSpace vectors(model->surface, model->atlas, space);
    const std::vector<ChartPlace> starts = domain.starts().places;
    const auto ends = AtlasFlow::along(domain, vectors.velocities(field)).trace(starts, 1).ends;
    double sum = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
      sum += (domain.position(ends[i]) - truth(domain.position(starts[i]))).norm();
    return sum / double(ends.size()) / space.scale().texel_spacing;
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  Signal source, target;
};

MeshFlowOptions up_to(double texels) {
  MeshFlowOptions options;
  options.largest = {2 * texels, Length::Unit::texels};
  options.detail = {};
  return options;
}

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
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.gradient_weight = 1; }), 0.15);
  EXPECT_LT(error_with([](MeshFlowOptions& o) { o.detail = {20, Length::Unit::percent}; }), 0.15);
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
