// What `bake` shows on another model, and that the program does as the library.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cli/models.h"
#include "model/program_files.h"
#include "mq/base/error.h"
#include "mq/io/image_file.h"
#include "mq/mesh/coarsen.h"
#include "mq/model/baked_signal.h"
#include "mq/model/detail/source_colours.h"
#include "mq/model/outputs.h"
#include "mq/sample/sample.h"
#include "mq/unwrap/unwrap.h"

namespace mq {
namespace {

/// A flat square [0, 1]² of one chart, `cells`² squares fine, in the corner of a texture that it
/// covers by `part`, quarter turns on.
Mesh square(int cells, double part = 1, int turns = 0) {
  Mesh mesh;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) {
      const Vector2 p(double(x) / cells, double(y) / cells);
      mesh.positions.emplace_back(p.x(), p.y(), 0);
      mesh.uvs.push_back(part * (turns % 2 ? Vector2(1 - p.y(), p.x()) : p));
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

/// What is painted: smooth, of one channel for each of three directions.
double painted(const Vector2& p, int c) {
  return 0.5 + 0.3 * std::sin(6 * p.x() + 2 * c) * std::cos(5 * p.y() - c);
}

Texture painting(int side, double part = 1) {
  Texture texture;
  texture.name = "painting";
  texture.pixels = Image<float>(side, side, 3);
  texture.format = {.depth = Depth::f32, .file_format = "tiff", .tags = nullptr};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int c = 0; c < 3; ++c)
        texture.pixels(x, y, c) =
            float(painted(Vector2(x + 0.5, side - y - 0.5) / (side * part), c));
  return texture;
}

TexturedModel loaded(Mesh mesh, std::vector<Texture> textures, std::optional<int> side = {}) {
  Model model;
  model.path = "square.obj";
  model.mesh = std::move(mesh);
  model.textures = std::move(textures);
  Messages messages;
  return textured_model(std::move(model), {.side = side}, messages);
}

struct Bake {
  BakedSignal baked;
  double error = 0;  ///< root mean square against the painting, away from the rim
};

/// Of a painting on fine texels to a square of other triangles, turned by a quarter.
Bake bake_painting(int source_side, int target_side, const BakeOptions& options = {}) {
  const TexturedModel source = loaded(square(3), {painting(source_side)});
  TexturedModel target = loaded(square(5, 1, 1), {painting(4)}, target_side);
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  Bake bake{.baked = mq::bake(source, target, signal, options, messages)};
  put_baked(bake.baked, signal, {}, target);
  const Image<float>& pixels = target.model.textures[0].pixels;
  double sum = 0, count = 0;
  const int rim = target_side / 8;
  for (int y = rim; y < target_side - rim; ++y)
    for (int x = rim; x < target_side - rim; ++x)
      for (int c = 0; c < 3; ++c) {
        const Vector2 uv = Vector2(x + 0.5, target_side - y - 0.5) / target_side;
        const double off = pixels(x, y, c) - painted({uv.y(), 1 - uv.x()}, c);
        sum += off * off, ++count;
      }
  bake.error = std::sqrt(sum / count);
  return bake;
}

TEST(Bake, IsOfSecondOrderInTheSizeOfTexels) {
  double means[3], fits[3];
  for (int level = 0; level < 3; ++level) {
    const Bake coarser = bake_painting(512, 32 << level),
               as_fine = bake_painting(80 << level, 64 << level);
    EXPECT_EQ(coarser.baked.kind, BakedSignal::Kind::mean);
    EXPECT_EQ(as_fine.baked.kind, BakedSignal::Kind::least_squares);
    means[level] = coarser.error;
    fits[level] = as_fine.error;
  }
  for (int level = 1; level < 3; ++level) {
    EXPECT_GT(std::log2(means[level - 1] / means[level]), 1.85);
    EXPECT_GT(std::log2(fits[level - 1] / fits[level]), 1.85);
  }
}

TEST(Bake, TakesItsPointsFromTheSameTriangles) {
  // Both layers of a folded strip lie in one place: only the number of a triangle tells them apart.
  Mesh layers = square(2);
  const Mesh other = layers;
  for (const Vector3& p : other.positions) layers.positions.push_back(p);
  for (const Vector2& uv : other.uvs) layers.uvs.push_back(uv);
  for (Vector2& uv : layers.uvs) uv.x() *= 0.45;
  for (std::size_t v = other.uvs.size(); v < layers.uvs.size(); ++v) layers.uvs[v].x() += 0.55;
  for (std::size_t t = 0; t < other.triangles.size(); ++t) {
    Triangle copy = other.triangles[t];
    for (int k = 0; k < 3; ++k) copy[k] += other.vertex_count();
    layers.triangles.push_back(copy);
  }
  layers.corner_uvs = layers.triangles;
  Texture halves = painting(64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) halves.pixels(x, y, c) = x < 32 ? 0.25F : 0.75F;
  Messages messages;
  Model model;
  model.path = "layers.obj";
  model.mesh = layers;
  model.textures = {halves};
  const LoadOptions apart{.weld = {.kind = WeldOptions::Kind::none}};
  const TexturedModel source = textured_model(model, apart, messages);
  std::swap(model.mesh.uvs, layers.uvs);
  for (Vector2& uv : model.mesh.uvs) uv.y() = 1 - uv.y();
  const TexturedModel target = textured_model(model, apart, messages);
  const TextureSignal signal(target, baking_options(target), messages);
  const BakedSignal baked = bake(source, target, signal, {}, messages);
  EXPECT_EQ(baked.same, baked.points);
  const Texels& texels = signal.space().texels();
  for (int i = 0; i < texels.size(); ++i)
    EXPECT_NEAR(baked.values(i, 0), texels.places[std::size_t(i)].x < 32 ? 0.25 : 0.75, 1e-6) << i;
}

TEST(Bake, FillsWhatLiesOnNothingAndCountsIt) {
  const TexturedModel source = loaded(square(4), {painting(64)});
  Mesh larger = square(4);
  for (Vector3& p : larger.positions) p.x() *= 2;
  const TexturedModel target = loaded(larger, {painting(64)});
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  const BakedSignal baked = bake(source, target, signal, {}, messages);
  EXPECT_NEAR(double(baked.unseen), 64 * 32, 3 * 64);
  EXPECT_TRUE(baked.values.allFinite());
  EXPECT_GE(baked.values.minCoeff(), 0.15);
  EXPECT_LE(baked.values.maxCoeff(), 0.85);
}

/// A two-hundredth of the target's two triangles, in its corner.
TEST(Bake, FindsASourceThatIsASmallPartOfTheTarget) {
  const TexturedModel source = loaded(square(4), {painting(64)});
  Mesh larger = square(1);
  for (Vector3& p : larger.positions) p.head<2>() *= 14;
  const TexturedModel target = loaded(larger, {painting(64)});
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  const BakedSignal baked = bake(source, target, signal, {.within = 1e-3}, messages);
  EXPECT_GT(double(baked.unseen), 0.98 * 64 * 64);
  EXPECT_LT(baked.unseen, 64 * 64);
}

TEST(Bake, RefusesWhatFacesNothingOrHasNoColours) {
  const TexturedModel source = loaded(square(4), {painting(16)});
  Mesh away = square(3);
  for (Vector3& p : away.positions) p.z() += 10;
  const TexturedModel target = loaded(away, {painting(16)});
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  EXPECT_THROW(bake(source, target, signal, {}, messages), InvalidInput);
  TexturedModel plain = loaded(square(3), {painting(16)});
  plain.model.textures.clear();
  EXPECT_THROW(bake(plain, target, signal, {}, messages), InvalidInput);
  EXPECT_THROW(bake(source, target, signal, {.within = -1}, messages), InvalidInput);
}

TEST(Bake, ShowsABustOnAQuarterOfItsTriangles) {
  const Sample bust = make_sample("bust", {.texture_size = 512, .triangles = 8000});
  Texture texture;
  texture.name = "bust.png";
  texture.pixels = paint(bust);
  texture.format = {.depth = Depth::f32, .file_format = "tiff", .tags = nullptr};
  const TexturedModel source = loaded(bust.mesh, {texture});
  const double spacing = 3.0 * std::sqrt(source.surface.area / source.surface.triangle_count());
  const CoarsenedSurface coarse = coarsen(source.surface, spacing);
  const int triangles = coarse.surface.triangle_count();
  EXPECT_LT(triangles, 0.3 * source.surface.triangle_count());
  EXPECT_GT(triangles, 0.15 * source.surface.triangle_count());
  const Unwrapped unwrapped = unwrap(coarse.surface, {.width = 512, .height = 512});
  Mesh mesh = coarse.surface.mesh;
  mesh.uvs = unwrapped.uvs;
  mesh.corner_uvs = unwrapped.corner_uvs;
  TexturedModel target = loaded(mesh, {texture}, 512);
  Messages messages;
  const TextureSignal signal(target, baking_options(target), messages);
  const BakedSignal baked = bake(source, target, signal, {}, messages);
  EXPECT_EQ(baked.same, 0);
  EXPECT_LT(double(baked.unseen), 0.03 * double(baked.values.rows()));
  EXPECT_TRUE(baked.values.allFinite());
  put_baked(baked, signal, {}, target);
  // Where the two surfaces are a texel apart, what is painted differs by no more than along one.
  std::vector<double> off;
  const int count = target.surface.triangle_count();
  const SourceColours shown(target.model, target.surface.mesh, {}, {});
  for (int t = 0; t < count; ++t) {
    const SurfacePoint middle{t, Vector3::Constant(1.0 / 3)};
    std::array<double, 3> values{};
    ASSERT_TRUE(shown.at(middle, values));
    const Vector3 wanted = bust.colors(point_at(target.surface.mesh, middle), 0);
    off.push_back((Vector3(values[0], values[1], values[2]) - wanted).cwiseAbs().maxCoeff());
  }
  std::ranges::sort(off);
  EXPECT_LT(off[off.size() / 2], 0.03);
}

TEST(Bake, GivesVerticesAndTexturesEachOthersColours) {
  const TexturedModel source = loaded(square(3), {painting(256)});
  TexturedModel target = loaded(square(32), {painting(4)});
  Messages messages;
  const VertexColourSignal signal(target);
  const BakedSignal baked = bake(source, target, signal, {}, messages);
  put_baked(baked, signal, {}, target);
  const std::vector<float>& colours = target.model.colors.values;
  ASSERT_EQ(colours.size(), 3 * target.model.mesh.positions.size());
  double worst = 0;
  for (std::size_t v = 0; v < target.model.mesh.positions.size(); ++v) {
    const Vector3& p = target.model.mesh.positions[v];
    if ((p - Vector3(0.5, 0.5, 0)).cwiseAbs().maxCoeff() > 0.4) continue;
    for (int c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(colours[3 * v + std::size_t(c)] - painted(p.head<2>(), c)));
  }
  EXPECT_LT(worst, 0.01);
  target.model.textures.clear();
  target.model.mesh.uvs.clear();
  target.model.mesh.corner_uvs.clear();
  TexturedModel back = loaded(square(3), {painting(4)}, 64);
  const TextureSignal texels(back, baking_options(back), messages);
  put_baked(bake(target, back, texels, {}, messages), texels, {}, back);
  const Image<float> wanted = painting(64).pixels;
  for (int y = 8; y < 56; ++y)
    for (int x = 8; x < 56; ++x)
      EXPECT_NEAR(back.model.textures[0].pixels(x, y, 0), wanted(x, y, 0), 0.02);
}

TEST(VerbBake, CarriesTheStripToItsOwnChartsTurned) {
  TwoCharts strip;
  run(strip.folder, {"unwrap", "strip.obj", "-o", "other.obj", "--size", "64"});
  run(strip.folder, {"bake", "strip.obj", "other.obj", "-o", "out.png", "--size", "48"});
  TexturedModel target =
      load_textured_model(strip.folder / "other.obj", {.side = 48}, strip.messages);
  const TextureSignal signal(target, baking_options(target), strip.messages);
  put_baked(bake(strip.model, target, signal, {}, strip.messages), signal, {}, target);
  Outputs(strip.folder / "ours.png", target.model, Outputs::Kind::pictures).write(target.model, {});
  EXPECT_TRUE(bytes(strip.folder, "ours.png") == bytes(strip.folder, "out.png"));
}

}  // namespace
}  // namespace mq
