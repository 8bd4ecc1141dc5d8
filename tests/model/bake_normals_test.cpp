// Normal maps in tangent space, carried to other charts and other meshes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "model/normal_maps.h"
#include "mq/base/error.h"
#include "mq/image/resample.h"
#include "mq/mesh/coarsen.h"
#include "mq/mesh/facing_points.h"
#include "mq/mesh/orient.h"
#include "mq/model/baked_signal.h"
#include "mq/model/model_paints.h"
#include "mq/model/unwrapped_model.h"

namespace mq {
namespace {

using test::flat_bust;
using test::flat_map;
using testing::HasSubstr;

constexpr double step = 2.0 / 255;  ///< of a vector in 8 bits

TexturedModel with_map(Mesh mesh, Texture map) {
  map.meaning = TextureMeaning::normals;
  return test::with_normal_map(std::move(mesh), std::move(map));
}

/// The same triangles in other charts, with a map of `side`² texels to be baked.
TexturedModel unwrapped_again(const TexturedModel& source, int side) {
  TexturedModel target = source;
  put_unwrapped(unwrap(source.surface, {.width = side, .height = side}), target);
  return with_map(target.model.mesh, flat_map(side, Depth::f32));
}

BakedSignal bake_onto_it(const TexturedModel& source, TexturedModel& target,
                         const BakeOptions& options = {}) {
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  BakedSignal baked = bake(source, target, signal, options, messages);
  put_baked(baked, signal, {}, target);
  return baked;
}

/// The normal at a place, as a renderer sees it.
Vector3 seen(const TexturedModel& model, const ShadingFrames& frames, const SurfacePoint& at) {
  const Mesh& mesh = model.surface.mesh;
  const Vector2 uv = interpolate(at.barycentric, [&](int k) { return mesh.uv(at.triangle, k); });
  const Image<float>& pixels = model.model.textures[0].pixels;
  std::array<float, 3> value;
  sample(pixels, uv.x() * pixels.width() - 0.5, (1 - uv.y()) * pixels.height() - 0.5, Wrap::clamp,
         value);
  return frames.at(at).to_model(Vector3(2 * value[0] - 1, 2 * value[1] - 1, 2 * value[2] - 1));
}

/// What a model should show where; 0: it does not matter.
using Wanted = std::function<Vector3(const SurfacePoint&, const Vector3& shading)>;

/// How far it is from it inside triangles, in order: those that count.
std::vector<double> differences(const TexturedModel& model, const Wanted& wanted,
                                const std::function<bool(const Vector3&)>& counts = {}) {
  const ShadingFrames frames(model, NormalAxes::tangent);
  std::vector<double> off;
  for (int t = 0; t < model.surface.triangle_count(); ++t) {
    const SurfacePoint at{t, Vector3(0.4, 0.35, 0.25)};
    if (counts && !counts(point_at(model.surface.mesh, at))) continue;
    const Vector3 there = wanted(at, frames.at(at).normal.normalized());
    if (!there.isZero()) off.push_back((seen(model, frames, at) - there).norm());
  }
  std::ranges::sort(off);
  return off;
}

/// What a share of them does not exceed.
double share(const std::vector<double>& sorted, double of) {
  return sorted[std::size_t(of * double(sorted.size()))];
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / double(values.size()));
}

TEST(BakeNormals, OfAFlatMapAreFlatInOtherCharts) {
  for (const Depth depth : {Depth::u8, Depth::f32}) {
    const TexturedModel source = [&] {
      TexturedModel bust = flat_bust(128, depth, 2000);
      bust.model.textures[0].meaning = TextureMeaning::normals;
      return bust;
    }();
    TexturedModel target = unwrapped_again(source, 128);
    const BakedSignal baked = bake_onto_it(source, target);
    EXPECT_EQ(baked.same, baked.points);
    EXPECT_EQ(baked.values.cwiseAbs().maxCoeff(), 0);
    const Image<float>& pixels = target.model.textures[0].pixels;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x) {
        EXPECT_EQ(std::lround(pixels(x, y, 0) * 255), 128);
        EXPECT_EQ(std::lround(pixels(x, y, 1) * 255), 128);
        EXPECT_EQ(pixels(x, y, 2), 1);
      }
  }
}

/// A flat square whose chart lies turned by quarters, and mirrored.
Mesh turned_square(int cells, int turns, bool mirrored) {
  Mesh mesh;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) {
      const Vector2 p(double(x) / cells, double(y) / cells);
      mesh.positions.emplace_back(p.x(), p.y(), 0);
      Vector2 uv(mirrored ? 1 - p.x() : p.x(), p.y());
      for (int k = 0; k < turns; ++k) uv = Vector2(1 - uv.y(), uv.x());
      mesh.uvs.push_back(uv);
    }
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const int v = y * (cells + 1) + x;
      mesh.triangles.push_back({v, v + 1, v + cells + 2});
      mesh.triangles.push_back({v, v + cells + 2, v + cells + 1});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

Vector3 wavy(const Vector3& p) { return bumpy(Vector3::UnitZ(), p, {.length = 0.7}); }

/// A map of known normals: of a square that is not turned, so that its axes are the model's.
TexturedModel painted_square(int side, Depth depth = Depth::f32) {
  Texture map = flat_map(side, depth);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Vector3 n = wavy(Vector3(x + 0.5, side - y - 0.5, 0) / side);
      for (int c = 0; c < 3; ++c) {
        const double code = (n[c] + 1) / 2;
        map.pixels(x, y, c) = float(depth == Depth::u8 ? std::round(255 * code) / 255 : code);
      }
    }
  return with_map(turned_square(3, 0, false), map);
}

/// Away from the rim, where lookups go beyond the picture.
double off_in_the_square(const TexturedModel& model) {
  return rms(differences(
      model,
      [&](const SurfacePoint& at, const Vector3&) {
        return wavy(point_at(model.surface.mesh, at));
      },
      [](const Vector3& p) { return (p - Vector3(0.5, 0.5, 0)).cwiseAbs().maxCoeff() < 0.375; }));
}

TEST(BakeNormals, AreThoseOfTheSurfaceHoweverChartsLie) {
  const TexturedModel source = painted_square(128, Depth::u8);
  for (const bool mirrored : {false, true})
    for (int turns = 0; turns < 4; ++turns) {
      TexturedModel target = with_map(turned_square(12, turns, mirrored), flat_map(128));
      bake_onto_it(source, target);
      EXPECT_LT(off_in_the_square(target), step / 2) << mirrored << turns;
    }
}

TEST(BakeNormals, AreOfSecondOrderInTheSizeOfTexels) {
  for (const bool fits : {false, true}) {
    double error[3];
    for (int level = 0; level < 3; ++level) {
      const TexturedModel source = painted_square(fits ? 40 << level : 512);
      TexturedModel target = with_map(turned_square(13, 1, true), flat_map(32 << level));
      const BakedSignal baked = bake_onto_it(source, target);
      EXPECT_EQ(baked.kind == BakedSignal::Kind::least_squares, fits);
      error[level] = off_in_the_square(target);
    }
    for (int level = 1; level < 3; ++level)
      EXPECT_GT(std::log2(error[level - 1] / error[level]), 1.8) << fits << error[level];
  }
}

constexpr double bump_length = 0.8;

/// The bust with bumps.
TexturedModel bumpy_bust(int side, int triangles = 2000) {
  TexturedModel bust = flat_bust(side, Depth::f32, triangles);
  test::paint_bumps(bust, bump_length);
  bust.model.textures[0].meaning = TextureMeaning::normals;
  return bust;
}

double off_bumps(const TexturedModel& model) {
  return rms(differences(model, [&](const SurfacePoint& at, const Vector3& shading) {
    return bumpy(shading, point_at(model.surface.mesh, at), {.length = bump_length});
  }));
}

double seams_of(const TexturedModel& model) {
  return texture_seams(model, ShadingFrames(model, NormalAxes::tangent)).rms;
}

TEST(BakeNormals, GoToNewChartsAndBack) {
  const TexturedModel source = bumpy_bust(256);
  EXPECT_LT(off_bumps(source), step);
  TexturedModel target = unwrapped_again(source, 256), back = flat_bust(256, Depth::f32, 2000);
  bake_onto_it(source, target);
  EXPECT_LT(off_bumps(target), step);
  EXPECT_LT(seams_of(target), 1.0 / 255) << "a step of the code";
  target.model.textures[0].meaning = back.model.textures[0].meaning = TextureMeaning::normals;
  bake_onto_it(target, back);
  EXPECT_LT(off_bumps(back), 1.5 * step);
  for (const TexturedModel* model : {&target, &back})
    for (int y = 0; y < 256; ++y)
      for (int x = 0; x < 256; ++x) {
        const auto pixel = model->model.textures[0].pixels.pixel(x, y);
        const Vector3 n(2 * pixel[0] - 1, 2 * pixel[1] - 1, 2 * pixel[2] - 1);
        EXPECT_NEAR(n.norm(), 1, 1e-3);
      }
}

/// The bust on a quarter of its triangles, unwrapped.
TexturedModel quarter_of(const TexturedModel& source, int side) {
  const double spacing = 3.0 * std::sqrt(source.surface.area / source.surface.triangle_count());
  const CoarsenedSurface coarse = coarsen(source.surface, spacing);
  const Unwrapped unwrapped = unwrap(coarse.surface, {.width = side, .height = side});
  Mesh mesh = coarse.surface.mesh;
  mesh.uvs = unwrapped.uvs;
  mesh.corner_uvs = unwrapped.corner_uvs;
  return with_map(mesh, flat_map(side, Depth::f32));
}

TEST(BakeNormals, OnAQuarterOfTheTrianglesShowWhatTheSourceDoes) {
  const TexturedModel source = bumpy_bust(256, 5000);
  TexturedModel target = quarter_of(source, 256);
  ASSERT_LT(target.surface.triangle_count(), 0.3 * source.surface.triangle_count());
  const ShadingFrames frames(source, NormalAxes::tangent);
  const FacingPoints points(target.surface.mesh, source.surface.mesh,
                            {.most_distance = BakeOptions{}.within});
  const Wanted of_source = [&](const SurfacePoint& at, const Vector3&) {
    const SurfacePoint there = points(at.triangle, at.barycentric);
    return there.triangle < 0 ? Vector3(Vector3::Zero()) : seen(source, frames, there);
  };
  const std::vector<double> flat = differences(target, of_source);
  bake_onto_it(source, target);
  const std::vector<double> baked = differences(target, of_source);
  EXPECT_GT(double(baked.size()), 0.9 * target.surface.triangle_count());
  EXPECT_LT(share(baked, 0.5), step / 2);
  EXPECT_LT(share(baked, 0.95), 8 * step) << "creases that the coarse mesh bridges";
  EXPECT_LT(rms(baked), rms(flat) / 10);
}

TEST(BakeNormals, OfAShapeAreItsShadingNormals) {
  TexturedModel source = flat_bust(256);
  TexturedModel target = quarter_of(source, 256);
  const ShadingFrames frames(source, NormalAxes::tangent);
  const FacingPoints points(target.surface.mesh, source.surface.mesh,
                            {.most_distance = BakeOptions{}.within});
  const Wanted of_shape = [&](const SurfacePoint& at, const Vector3&) {
    const SurfacePoint there = points(at.triangle, at.barycentric);
    return there.triangle < 0 ? Vector3(Vector3::Zero())
                              : Vector3(frames.at(there).normal.normalized());
  };
  const std::vector<double> before = differences(target, of_shape);
  source.model.textures.clear();
  const BakedSignal baked =
      bake_onto_it(source, target, {.shown = BakeOptions::Shown::shading_normals});
  ASSERT_TRUE(baked.normals);
  const std::vector<double> after = differences(target, of_shape);
  EXPECT_LT(share(after, 0.5), step / 2);
  EXPECT_LT(rms(after), rms(before) / 5);
}

/// A part of the source that faces the wrong way shows the same from the other side.
TEST(BakeNormals, AreTurnedOverWhereTheSourceFacesInward) {
  const TexturedModel source = painted_square(256);
  std::vector<int> all(std::size_t(source.surface.triangle_count()));
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = int(t);
  const TexturedModel inward =
      with_map(with_flipped(source.model.mesh, all), source.model.textures[0]);
  TexturedModel first = with_map(turned_square(7, 1, false), flat_map(128, Depth::f32)), second = first;
  bake_onto_it(source, first);
  bake_onto_it(inward, second);
  const ShadingFrames frames(first, NormalAxes::tangent);
  for (int t = 0; t < first.surface.triangle_count(); ++t) {
    const SurfacePoint at{t, Vector3(0.4, 0.35, 0.25)};
    const Vector3 outer = seen(first, frames, at), inner = seen(second, frames, at);
    // Its frame is (x, y, −z): the map (a, b, c) is (a, b, −c), and from behind (−a, −b, c).
    EXPECT_LT((Vector3(-outer.x(), -outer.y(), outer.z()) - inner).norm(), 1e-3) << t;
  }
}

TEST(BakeNormals, InObjectSpaceStayThereOrAreTakenToTangentSpace) {
  TexturedModel source = painted_square(128);
  TexturedModel target = with_map(turned_square(7, 3, true), flat_map(128, Depth::f32));
  const BakeOptions object{.values = {.axes = NormalAxes::object}};
  EXPECT_FALSE(bake_onto_it(source, target, object).normals);
  const Image<float>& pixels = target.model.textures[0].pixels;
  const Vector3 wanted = wavy(Vector3(63.5, 64.5, 0) / 128);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(2 * pixels(63, 63, c) - 1, wanted[c], 0.05) << c;
  BakeOptions tangent = object;
  tangent.to_tangent_space = true;
  EXPECT_TRUE(bake_onto_it(source, target, tangent).normals);
  EXPECT_LT(off_in_the_square(target), step / 2);
}

TEST(BakeNormals, AreRefusedWhereTheyCannotBe) {
  const TexturedModel source = painted_square(64);
  const auto message = [&](const TexturedModel& from, TexturedModel target) -> std::string {
    try {
      bake_onto_it(from, target);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  const TexturedModel plain = with_map(turned_square(7, 0, false), flat_map(64));
  EXPECT_EQ(message(source, plain), "");
  Mesh twice = turned_square(7, 0, false);
  for (std::size_t t = 0; t < twice.corner_uvs.size() / 2; ++t)
    twice.corner_uvs[t + twice.corner_uvs.size() / 2] = twice.corner_uvs[t];
  EXPECT_THAT(message(source, with_map(twice, flat_map(64))),
              HasSubstr("lie on top of each other"));
  TexturedModel without_z = source;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) without_z.model.textures[0].pixels(x, y, 2) = 0;
  EXPECT_THAT(message(without_z, plain), HasSubstr("x and y alone"));
  Messages messages;
  EXPECT_THROW(bake(source, plain, VertexColourSignal(plain), {}, messages), Unsupported);
}

}  // namespace
}  // namespace mq
