// Normal maps in tangent space, processed across seams.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fixtures.h"
#include "model/normal_maps.h"
#include "mq/base/error.h"
#include "mq/filter/denoise.h"
#include "mq/filter/seam_values.h"
#include "mq/filter/screened_poisson.h"
#include "mq/image/resample.h"
#include "mq/model/model_paints.h"
#include "mq/model/texture_fill.h"

namespace mq {
namespace {

using test::bumps;
using test::flat_bust;
using test::normal_signal;
using test::paint_bumps;
using test::with_normal_map;
using testing::HasSubstr;

Vector3 row(const Signal& values, int i) { return values.row(i).head<3>().transpose(); }

/// n = N + d of all unknowns.
Signal normals_of(const TextureSignal& signal, const Signal& d) {
  Signal n = signal.shading_normals() + d.leftCols(3);
  n.rowwise().normalize();
  return n;
}

/// As they were after filtering, and put into a copy of the model.
Image<float> filtered(const TexturedModel& model, double beta, const Length& length,
                      Depth depth = Depth::f32) {
  const TextureSignal signal = normal_signal(model);
  const double weight = weight_from_length(length, signal.space().scale());
  const Signal before = signal.values();
  Model after = model.model;
  after.textures[0].format.depth = depth;
  signal.put(before, ScreenedPoisson(signal.space(), weight).solve(before, beta).signal, after);
  return after.textures[0].pixels;
}

TEST(NormalMap, FlatComesBackBitForBitOnACurvedSurface) {
  for (const Depth depth : {Depth::u8, Depth::f32}) {
    const TexturedModel model = flat_bust(256, depth);
    ASSERT_GT(model.atlas->seam_count, 0);
    EXPECT_EQ(normal_signal(model).values().cwiseAbs().maxCoeff(), 0);
    for (const double beta : {0.0, 5.0})
      EXPECT_EQ(filtered(model, beta, {5, Length::Unit::percent}), model.model.textures[0].pixels);
  }
}

TEST(NormalMap, ComesBackBitForBitWithBetaOne) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.3);
  EXPECT_EQ(filtered(model, 1, {3, Length::Unit::texels}), model.model.textures[0].pixels);
  EXPECT_NE(filtered(model, 0, {3, Length::Unit::texels}), model.model.textures[0].pixels);
}

TEST(NormalMap, TurnedToTheModelAndBackIsTheSame) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.3);
  const Image<float> before = model.model.textures[0].pixels;
  const TextureSignal signal = normal_signal(model);
  const Signal d = signal.values();
  Signal moved = d;
  moved.array() += 0.2;
  signal.put(d, moved, model.model);
  EXPECT_NE(model.model.textures[0].pixels, before);
  signal.put(moved, d, model.model);
  double most = 0;
  for (std::size_t i = 0; i < before.values().size(); ++i)
    most = std::max(most, std::abs(double(before.values()[i]) -
                                   double(model.model.textures[0].pixels.values()[i])));
  EXPECT_LT(most, 1e-6);
}

/// What is put is what is read again, to rounding, and of unit length.
TEST(NormalMap, HoldsTheNormalsThatArePut) {
  TexturedModel model = flat_bust(256);
  const TextureSignal signal = normal_signal(model);
  const Signal wanted = bumps(signal, 0.3);
  paint_bumps(model, 0.3);
  EXPECT_LT((signal.values() - wanted).cwiseAbs().maxCoeff(), 2e-6);
  const Image<float> normals = normals_from_colours(model.model.textures[0].pixels);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      EXPECT_NEAR(std::hypot(normals(x, y, 0), normals(x, y, 1), normals(x, y, 2)), 1, 1e-5);
}

/// A smooth field in the model's axes has no jumps, however charts lie; what is stored has.
TEST(NormalMap, JumpsAtSeamsAreThoseOfTheNormals) {
  for (const int side : {256, 512}) {
    TexturedModel model = flat_bust(side);
    const TextureSignal signal = normal_signal(model);
    const SeamDifference flat = texture_seams(model, *signal.shading_frames());
    EXPECT_LT(flat.worst.difference, 1e-6) << "the shading normals themselves";
    paint_bumps(model, 0.5);
    const double stored = texture_seams(model).rms;
    const double seen = texture_seams(model, *signal.shading_frames()).rms;
    EXPECT_GT(stored, 0.05);
    EXPECT_LT(seen, side == 256 ? 2e-3 : 5e-4);
  }
}

/// Two squares side by side; the chart of the second lies turned by quarters, and mirrored.
Mesh two_squares(int turns, bool mirrored) {
  Mesh mesh;
  const int n = 8;
  for (int half = 0; half < 2; ++half)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n, t = double(j) / n;
        mesh.positions.emplace_back(half + s, t, 0.2 * std::sin(2 * (half + s)));
        Vector2 uv(s - 0.5, t - 0.5);
        if (half == 1) {
          if (mirrored) uv.x() = -uv.x();
          for (int k = 0; k < turns; ++k) uv = Vector2(-uv.y(), uv.x());
        }
        // Texel centres 2 to 29 and 34 to 61 of 64.
        mesh.uvs.emplace_back((half * 32 + 16 + 27 * uv.x()) / 64, (16 + 27 * uv.y()) / 32);
      }
  for (int half = 0; half < 2; ++half)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int v = half * (n + 1) * (n + 1) + j * (n + 1) + i;
        mesh.triangles.push_back({v, v + 1, v + n + 2});
        mesh.triangles.push_back({v, v + n + 2, v + n + 1});
      }
  mesh.corner_uvs = mesh.triangles;
  // One vertex where the squares meet, so that shading normals are smooth there.
  for (Triangle& t : mesh.triangles)
    for (int& v : t) {
      const int w = v - (n + 1) * (n + 1);
      if (w >= 0 && w % (n + 1) == 0) v = w + n;
    }
  return mesh;
}

/// The normal at a place, as a renderer sees it.
Vector3 shown(const TexturedModel& model, const TextureSignal& signal, const SurfacePoint& at) {
  const Mesh& mesh = model.surface.mesh;
  const Vector2 uv = interpolate(at.barycentric, [&](int k) { return mesh.uv(at.triangle, k); });
  const Image<float>& pixels = model.model.textures[0].pixels;
  std::array<float, 3> value;
  sample(pixels, uv.x() * pixels.width() - 0.5, (1 - uv.y()) * pixels.height() - 0.5, Wrap::clamp,
         value);
  return signal.shading_frames()->at(at).to_model(
      Vector3(2 * value[0] - 1, 2 * value[1] - 1, 2 * value[2] - 1));
}

/// Rows of `d` by where texels lie, those inside the squares alone.
using Rows = std::map<std::pair<long, long>, Vector3>;
Rows in_space(const TextureSignal& signal, const Signal& d) {
  Rows rows;
  for (int i = 0; i < signal.space().size(); ++i) {
    const Vector3 p = 27 * signal.space().texels().position(i);
    const std::pair place(std::lround(p.x()), std::lround(p.y()));
    if (place.first % 27 != 0 && place.second % 27 != 0 && place.first > 0 && place.first < 54 &&
        place.second > 0 && place.second < 27)
      rows[place] = row(d, i);
  }
  return rows;
}

/// Of x and y alone, which charts say exactly; z of texels beside an edge is that of either triangle.
void paint_waves(TexturedModel& model) {
  const TextureSignal signal = normal_signal(model);
  const Signal flat = Signal::Zero(signal.space().size(), 3);
  Signal waves = flat;
  for (int i = 0; i < signal.space().size(); ++i) {
    const Vector3 p = signal.space().texels().position(i);
    waves.row(i) << 0.3 * std::sin(7 * p.x() + 2 * p.y()), 0.3 * std::cos(6 * p.y()), -0.1;
  }
  signal.put(flat, waves, model.model);
}

TEST(NormalMap, IsFilteredAlikeHoweverItsChartsLie) {
  Rows first;
  for (const bool mirrored : {false, true})
    for (int turns = 0; turns < 4; ++turns) {
      Texture map = test::flat_map(64, Depth::f32);
      map.pixels = Image<float>(64, 32, 3, 0.5F);
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) map.pixels(x, y, 2) = 1;
      TexturedModel model = with_normal_map(two_squares(turns, mirrored), map);
      ASSERT_GT(model.atlas->seam_count, 0);
      paint_waves(model);
      model.model.textures[0].pixels = filtered(model, 3, {2, Length::Unit::texels});
      const TextureSignal signal = normal_signal(model);
      const Rows found = in_space(signal, signal.values());
      if (first.empty()) first = found;
      ASSERT_EQ(found.size(), 2u * 26 * 26);
      double most = 0;
      for (const auto& [place, d] : found) most = std::max(most, (d - first.at(place)).norm());
      EXPECT_LT(most, 1e-5) << mirrored << turns;
    }
}

/// Filtered in tangent space a map is its bake in object space filtered, F(n), but for what the filter
/// does to the shading normals, F(N) − N.
TEST(NormalMap, IsFilteredAsItsBakeInObjectSpace) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.2);
  const TextureSignal signal = normal_signal(model);
  const Signal d = signal.values(), shading = signal.shading_normals();
  const Signal baked = normals_of(signal, d);
  for (const double texels : {1.0, 3.0}) {
    const ScreenedPoisson equation(
        signal.space(),
        weight_from_length({texels, Length::Unit::texels}, signal.space().scale()));
    const Signal ours = normals_of(signal, equation.solve(d, 0).signal);
    Signal theirs = equation.solve(baked, 0).signal;
    Signal without = theirs - equation.solve(shading, 0).signal + shading;
    theirs.rowwise().normalize(), without.rowwise().normalize();
    Signal smooth_shading = equation.solve(shading, 0).signal;
    smooth_shading.rowwise().normalize();
    const auto off = [](const Signal& a, const Signal& b) {
      return (a - b).norm() / std::sqrt(double(a.rows()));
    };
    EXPECT_LT((ours - without).cwiseAbs().maxCoeff(), 1e-5) << texels;
    EXPECT_LT(std::abs(off(ours, theirs) / off(smooth_shading, shading) - 1), 0.1) << texels;
    EXPECT_GT(off(ours, baked), 2.0 / 255) << "it changes something";
  }
}

TEST(NormalMap, SeamsAreTakenOutInObjectSpace) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.08);
  Messages messages;
  TextureSignalOptions options = test::normals_in(NormalAxes::tangent);
  options.space = soft_seams(*model.atlas);
  const TextureSignal signal(model, options, messages);
  const double before = texture_seams(model, *signal.shading_frames()).rms;
  const std::vector<char> free = seam_texels(model.surface, *model.atlas, signal.space());
  const Signal values = signal.values();
  signal.put(values, smooth_at_seams(signal.space(), values, free, Smooth::change).signal, model.model);
  const double after = texture_seams(model, *signal.shading_frames()).rms;
  EXPECT_GT(before, 2e-3);
  EXPECT_LT(after, before / 5);
}

TEST(NormalMap, IsFilledOverTheSurface) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.4);
  const std::vector<Coverage> coverage = texel_coverage(model.surface, *model.atlas);
  Image<float>& pixels = model.model.textures[0].pixels;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      if (coverage[0].triangle(x, y) < 0) std::ranges::fill(pixels.pixel(x, y), 0.0F);
  Messages messages;
  const TextureFill fill(
      model, {.values = test::normals_in(NormalAxes::tangent).values}, messages);
  const double before = texture_seams(model, *fill.signal().shading_frames()).rms;
  fill.put(fill.solve(), model.model);
  EXPECT_GT(before, 0.05);
  EXPECT_LT(texture_seams(model, *fill.signal().shading_frames()).rms, 5e-3);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) EXPECT_GT(pixels(x, y, 2), 0.5F);
}

TEST(NormalMap, LosesNoise) {
  TexturedModel model = flat_bust(256);
  paint_bumps(model, 0.6, 0.2);
  const TextureSignal signal = normal_signal(model);
  const Signal clean = signal.values();
  Image<float>& pixels = model.model.textures[0].pixels;
  const Image<float> noise = fixtures::noise(256, 256, 2);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      for (int c = 0; c < 2; ++c) pixels(x, y, c) += 0.1F * (noise(x, y, c) - 0.5F);
  const Signal noisy = signal.values();
  const Denoised found =
      denoise(signal.space(), noisy, {}, {.weight = usual_denoise_weight(signal.space())});
  EXPECT_LT((found.signal - clean).norm(), 0.5 * (noisy - clean).norm());
}

TEST(NormalMap, GreenDownIsGreenUpTurned) {
  TexturedModel model = flat_bust(128);
  paint_bumps(model, 0.5);
  const Signal up = normal_signal(model).values();
  Image<float>& pixels = model.model.textures[0].pixels;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) pixels(x, y, 1) = 1 - pixels(x, y, 1);
  const TextureSignal down = normal_signal(model, NormalAxes::tangent_down);
  EXPECT_LT((down.values() - up).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_GT((normal_signal(model).values() - up).cwiseAbs().maxCoeff(), 0.1);
  TexturedModel again = flat_bust(128);
  down.put(Signal::Zero(up.rows(), up.cols()), up, again.model);
  double most = 0;
  for (std::size_t i = 0; i < pixels.values().size(); ++i)
    most = std::max(most, double(std::abs(pixels.values()[i] - again.model.textures[0].pixels.values()[i])));
  EXPECT_LT(most, 1e-5);
}

TEST(NormalMap, IsFoundByItsValues) {
  TexturedModel model = flat_bust(128);
  paint_bumps(model, 0.5);
  const auto axes = [&] {
    return normal_signal(model, NormalAxes::as_found).value_space().axes;
  };
  EXPECT_EQ(axes(), NormalAxes::tangent);
  const TextureSignal signal = normal_signal(model);
  const Signal object = normals_of(signal, signal.values());
  std::vector<Image<float>> pictures{model.model.textures[0].pixels};
  signal.space().scatter(object, pictures);
  model.model.textures[0].pixels = colours_from_normals(pictures[0]);
  EXPECT_EQ(axes(), NormalAxes::object);
}

/// Mirrored halves of a body share their texels, as in models for games: each half has unknowns of its
/// own, and a symmetric body comes back symmetric and without jumps.
Mesh mirrored_halves() {
  Mesh mesh = two_squares(0, false);
  // The second square becomes the first one, seen in the plane x = 1.
  const int n = 8, count = (n + 1) * (n + 1);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      Vector3 p = mesh.positions[std::size_t(j * (n + 1) + n - i)];
      p.x() = 2 - p.x();
      mesh.positions[std::size_t(count + j * (n + 1) + i)] = p;
      mesh.uvs[std::size_t(count + j * (n + 1) + i)] =
          mesh.uvs[std::size_t(j * (n + 1) + n - i)] + Vector2(1, 0);  // another tile: another chart
    }
  return mesh;
}

TEST(NormalMap, OfOverlappingChartsIsProcessedForEach) {
  Texture map = test::flat_map(64, Depth::f32);
  map.pixels = Image<float>(64, 32, 3, 0.5F);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3 n = Vector3(0.5 * std::sin(0.4 * x), 0.3 * std::cos(0.3 * y), 1).normalized();
      for (int c = 0; c < 3; ++c) map.pixels(x, y, c) = float((n[c] + 1) / 2);
    }
  TexturedModel model = with_normal_map(mirrored_halves(), map);
  Messages messages;
  TextureSignalOptions options = test::normals_in(NormalAxes::tangent);
  EXPECT_THAT(fixtures::error_of([&] { TextureSignal(model, options, messages); }),
              HasSubstr("charts lie on top of each other"));
  options.shared = TextureSignalOptions::SharedTexels::as_normals_need;
  const TextureSignal signal(model, options, messages);
  EXPECT_GT(signal.space().size(), 2 * 27 * 27);
  const Signal before = signal.values();
  const Signal after = smooth(signal.space(), before, {3, Length::Unit::texels}).signal;
  signal.put(before, after, model.model);
  EXPECT_NE(model.model.textures[0].pixels, map.pixels);
  const TextureSignal again(model, options, messages);
  for (int t = 0; t < 128; ++t) {
    const Vector3 here = shown(model, again, {t, Vector3(0.25, 0.35, 0.4)});
    EXPECT_NEAR(here.norm(), 1, 1e-9);
  }
  // Mirrored unknowns are mirrored vectors, before and after: the copies that are not shown too.
  double most = 0;
  for (int i = 0; i < signal.space().size(); ++i) {
    Vector3 mirror = signal.space().texels().position(i);
    mirror.x() = 2 - mirror.x();
    double nearest = 1e9;
    int other = -1;
    for (int k = 0; k < signal.space().size(); ++k)
      if (const double away = (signal.space().texels().position(k) - mirror).norm(); away < nearest)
        nearest = away, other = k;
    if (nearest > 1e-4) continue;
    Vector3 seen = row(after, other);
    seen.x() = -seen.x();
    most = std::max(most, (seen - row(after, i)).norm());
  }
  EXPECT_LT(most, 0.02);
}

TEST(NormalMap, IsRefusedWithoutZ) {
  TexturedModel model = flat_bust(128, Depth::u8);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) model.model.textures[0].pixels(x, y, 2) = 0;
  EXPECT_THAT(fixtures::error_of([&] { normal_signal(model); }), HasSubstr("blue is 0"));
  model.model.textures[0].pixels = Image<float>(128, 128, 2, 0.5F);
  EXPECT_THAT(fixtures::error_of([&] { normal_signal(model); }),
              HasSubstr("2 channels: of x and y alone"));
}

TEST(NormalMap, ThatLooksOddIsWarnedOf) {
  TexturedModel model = flat_bust(128, Depth::u8);
  Image<float>& pixels = model.model.textures[0].pixels;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      if (x % 8 == 0) pixels(x, y, 2) = 0.2F;       // z = −0.6
      if (x % 8 == 1) pixels(x, y, 2) = 140.0F / 255;  // short
    }
  struct Heard : Messages {
    std::string all;
    void warning(const std::string& text) override { all += text + "\n"; }
  } heard;
  const TextureSignal signal(model, test::normals_in(NormalAxes::tangent), heard);
  EXPECT_THAT(heard.all, HasSubstr("point below the surface"));
  EXPECT_THAT(heard.all, HasSubstr("shorter or longer than 1"));
  EXPECT_TRUE(signal.values().allFinite());
}

}  // namespace
}  // namespace mq
