#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <span>

#include "cli/models.h"
#include "cli/refusal.h"
#include "mq/image/colour.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

/// The point of the strip that a texel of either chart shows: charts span u 0.05 to 0.45 and 0.55
/// to 0.95, v 0.1 to 0.9.
std::array<double, 2> on_strip(int x, int y, int width, int height) {
  const double u = (x + 0.5) / width, v = 1 - (y + 0.5) / height;
  return {u < 0.5 ? (u - 0.05) / 0.4 : 1 + (u - 0.55) / 0.4, (v - 0.1) / 0.8};
}

/// A smooth picture on the strip, in the light of linear values, and the right half times `gain`.
Image<float> picture(int width, int height, double gain) {
  Image<float> image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto [s, t] = on_strip(x, y, width, height);
      const double light = 0.25 + 0.08 * std::sin(5 * s + 2 * t) + 0.05 * std::cos(7 * t);
      for (int c = 0; c < 3; ++c)
        image(x, y, c) =
            float(srgb_from_linear(light * (1 - 0.1 * c) * (x < width / 2 ? 1 : gain)));
    }
  return image;
}

/// strip.obj with that picture.
void write_gains(const Folder& folder, double gain, int width = 160, int height = 120) {
  write_strip(folder);
  write_image(folder / "strip.png", picture(width, height, gain), Depth::u16);
}

Result stitch(const Folder& folder, const std::string& output, const Words& more) {
  Words words = {"stitch", "strip.obj", "-o", output, "--json"};
  words.insert(words.end(), more.begin(), more.end());
  return marquetry(folder, words);
}

/// Root mean square of log(a / b), less its mean, inside the charts.
double log_difference(const Image<float>& a, const Image<float>& b) {
  double sum = 0, squares = 0;
  int count = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      const auto [s, t] = on_strip(x, y, a.width(), a.height());
      const double from = x < a.width() / 2 ? 0 : 1;
      const bool inside = t > 0.02 && t < 0.98 && s > from + 0.02 && s < from + 0.98;
      if (!inside) continue;
      for (int c = 0; c < 3; ++c, ++count) {
        const double d = std::log(linear_from_srgb(a(x, y, c)) / linear_from_srgb(b(x, y, c)));
        sum += d, squares += d * d;
      }
    }
  return std::sqrt(squares / count - sum * sum / count / count);
}

/// Corrections that spread over the whole surface, and nothing else.
const Words as_published = {"--exposure", "keep", "--alpha", "100"};

TEST(Stitch, TakesGainsOutInWhateverSpace) {
  const Folder folder;
  write_gains(folder, 1.5);
  const Image<float> truth = picture(160, 120, 1);
  for (const char* space : {"stored", "linear", "log"}) {
    const Result result = stitch(folder, "out.png", {"--space", space, "--overwrite"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(log_difference(read_texture(folder / "out.png").pixels, truth), 2.0 / 255) << space;
    // Half of it in each of two regions of one size.
    EXPECT_NEAR(result.json()["result"]["largest_gain"].get<double>(), std::sqrt(1.5), 0.01) << space;
  }
  const Result kept = stitch(folder, "out.png", {"--exposure", "keep", "--overwrite"});
  EXPECT_GT(log_difference(read_texture(folder / "out.png").pixels, truth), 0.1);
  EXPECT_FALSE(kept.json()["result"].contains("largest_gain"));
}

TEST(Stitch, SpreadsGainsOverTheWholeSurfaceInLogSpace) {
  const Folder folder;
  write_gains(folder, 1.5);
  const Image<float> truth = picture(160, 120, 1);
  Words words = as_published;
  words.insert(words.end(), {"--space", "log"});
  const Result result = stitch(folder, "out.png", words);
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "out.png").pixels;
  EXPECT_GT(log_difference(before, truth), 0.1);
  EXPECT_LT(log_difference(after, truth), 1.0 / 255);
  const Json json = result.json()["result"];
  EXPECT_EQ(json["regions"], 2);
  EXPECT_EQ(json["unseen"], 0);
  EXPECT_GT(json["seams"]["before"]["rms"].get<double>(), 0.1);
  EXPECT_LT(json["seams"]["after"]["rms"].get<double>(), 0.003);
  EXPECT_LT(json["borders"]["after"]["across"].get<double>(),
            0.3 * json["borders"]["before"]["across"].get<double>());
  EXPECT_LT(json["mean_drift"].get<double>(), 1e-6);
}

/// A number from 0 to 1 for the colour of a label and a channel.
double of_label(std::span<const float> colour, int channel) {
  unsigned bits = unsigned(channel + 1);
  for (const float c : colour) bits = bits * 2654435761U + unsigned(std::lround(255 * c));
  return (bits >> 8 & 1023) / 1023.0;
}

/// Root mean square of a − b less its mean per channel, where `used` is not black.
double rms_up_to_constants(const Image<float>& a, const Image<float>& b, const Image<float>& used) {
  double squares = 0, count = 0;
  for (int c = 0; c < 3; ++c) {
    double sum = 0, square = 0, n = 0;
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        if (used(x, y) == 0) continue;
        const double d = a(x, y, c) - b(x, y, c);
        sum += d, square += d * d, n += 1;
      }
    squares += square - sum * sum / n, count += n;
  }
  return std::sqrt(squares / count);
}

/// Every chart of a model shifted by a constant of its own. Coarse textures do not show the same on
/// both sides of a seam to begin with, and that difference is taken out, too: what comes back is
/// the original as stitching leaves it, and the original itself the better the finer it is.
TEST(Stitch, RecoversAPictureOfWhichChartsWereShifted) {
  const Folder folder;
  for (const int size : {256, 512}) {
    ASSERT_EQ(marquetry(folder, {"sample", "bust", "--size", std::to_string(size), "--depth", "16",
                                 "-o", "bust.obj"})
                  .status,
              0);
    ASSERT_EQ(marquetry(folder, {"mask", "bust.obj", "-w", "chart", "-o", "charts.png"}).status, 0);
    ASSERT_EQ(marquetry(folder, {"mask", "bust.obj", "-w", "depth", "-o", "used.png"}).status, 0);
    const Image<float> charts = read_texture(folder / "charts.png").pixels;
    const Image<float> used = read_texture(folder / "used.png").pixels;
    Image<float> original = read_texture(folder / "bust.png").pixels;
    for (float& value : original.values()) value = 0.25F + value / 2;
    Image<float> shifted = original;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int c = 0; c < 3; ++c)
          shifted(x, y, c) += float(0.4 * of_label(charts.pixel(x, y), c) - 0.2);
    write_image(folder / "original.png", original, Depth::u16);
    write_image(folder / "shifted.png", shifted, Depth::u16);
    for (const std::string name : {"original", "shifted"}) {
      const Result result =
          marquetry(folder, {"stitch", "bust.obj", name + ".png", "-o", name + "_out.png", "--exposure", "keep",
                             "--alpha", "100"});
      ASSERT_EQ(result.status, 0) << result.error;
    }
    const Image<float> found = read_texture(folder / "shifted_out.png").pixels;
    const Image<float> stitched = read_texture(folder / "original_out.png").pixels;
    const double before = rms_up_to_constants(shifted, original, used),
                 after = rms_up_to_constants(found, original, used),
                 twin = rms_up_to_constants(found, stitched, used);
    std::cout << size << ": in steps of 8 bits " << 255 * before << " before, " << 255 * after
              << " after, " << 255 * twin << " from the stitched original\n";
    EXPECT_GT(before, 20.0 / 255);
    EXPECT_LT(after, (size < 512 ? 2.5 : 1.0) / 255) << size;
    EXPECT_LT(twin, 0.05 / 255) << size;
  }
}

/// Borders as published take a step of the slope out of a picture that needs nothing, and more of it than ours changes.
TEST(Stitch, MakesBordersLevelWhereAskedTo) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "strip.png", picture(64, 48, 1));
  const auto changed = [&](const char* borders) {
    const Result result = marquetry(folder, {"stitch", "strip.obj", "-o", "out.exr", "--depth", "float", "--overwrite", "--exposure",
                                             "keep", "--alpha", "0.01", "--borders", borders});
    EXPECT_EQ(result.status, 0) << result.error;
    const Image<float> after = read_texture(folder / "out.exr").pixels, before = read_texture(folder / "strip.png").pixels;
    double sum = 0;
    for (int y = 8; y < 40; ++y)
      for (int x = 5; x < 59; ++x) sum += std::pow(after(x, y, 0) - before(x, y, 0), 2);
    return std::sqrt(sum);
  };
  const double level = changed("level"), continued = changed("continued");
  EXPECT_GT(level, 0.02);
  EXPECT_LT(continued, level / 4);
}

TEST(Stitch, ReturnsConstantsAndSingleRegionsUnchanged) {
  const Folder folder;
  write_gains(folder, 1.5);
  write_image(folder / "one.png", Image<float>(8, 8, 3, 0.4F));
  const Result same = stitch(folder, "same.png", {"--labels", "one.png"});
  ASSERT_EQ(same.status, 0) << same.error;
  EXPECT_THAT(same.error, HasSubstr("one.png: 8 × 8 pixels, where the texture has 160 × 120"));
  EXPECT_THAT(same.error, HasSubstr("one region only"));
  EXPECT_TRUE(file_bytes(folder / "same.png") == file_bytes(folder / "strip.png"));
  write_image(folder / "strip.png", Image<float>(64, 48, 4, 0.7F));
  ASSERT_EQ(stitch(folder, "grey.png", {}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "grey.png") == file_bytes(folder / "strip.png"));
}

/// A hole at the border of a chart, whose colour is around the chart too. The chart begins at column 3.
TEST(Stitch, FillsTheGutterBesideWhatIsUnseen) {
  const Folder folder;
  write_gains(folder, 1, 64, 48);
  Image<float> labels(64, 48, 3, 1.0F), hole = read_texture(folder / "strip.png").pixels;
  for (int y = 18; y < 30; ++y)
    for (int x = 0; x < 12; ++x)
      for (int c = 0; c < 3; ++c) labels(x, y, c) = 0, hole(x, y, c) = c == 1;
  write_image(folder / "labels.png", labels);
  write_image(folder / "strip.png", hole);
  const Result result = stitch(folder, "out.png", {"--labels", "labels.png", "--unseen", "#000000"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> before = read_texture(folder / "strip.png").pixels,
                     after = read_texture(folder / "out.png").pixels;
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(after(0, 24, c), after(3, 24, c));
    EXPECT_LT(after(0, 24, 1), 0.95F);
    // Elsewhere the gutter is as it was.
    EXPECT_EQ(after(0, 8, c), before(0, 8, c));
    EXPECT_EQ(after(63, 24, c), before(63, 24, c));
    EXPECT_EQ(after(20, 0, c), before(20, 0, c));
  }
}

TEST(Stitch, FillsWhatTheLabelsSayIsUnseen) {
  const Folder folder;
  write_gains(folder, 1, 64, 48);
  Image<float> labels(64, 48, 3, 1.0F), hole = read_texture(folder / "strip.png").pixels;
  for (int y = 18; y < 30; ++y)
    for (int x = 10; x < 22; ++x)
      for (int c = 0; c < 3; ++c) labels(x, y, c) = 0, hole(x, y, c) = c == 1;
  write_image(folder / "labels.png", labels);
  write_image(folder / "strip.png", hole, Depth::u16);
  const Result result =
      stitch(folder, "out.png", {"--labels", "labels.png", "--unseen", "#000000"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["unseen"], 144);
  const Result mistyped =
      stitch(folder, "other.png", {"--labels", "labels.png", "--unseen", "#123456"});
  EXPECT_THAT(mistyped.error, HasSubstr("--unseen #123456: no texel has this label"));
  const Image<float> after = read_texture(folder / "out.png").pixels, truth = picture(64, 48, 1);
  for (int y = 14; y < 34; ++y)
    for (int x = 6; x < 26; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(after(x, y, c), truth(x, y, c), 0.06);
}

/// Two photographs of the whole picture, the second brighter, with alpha for what they show.
TEST(Stitch, MakesOneTextureOfPartialOnes) {
  const Folder folder;
  write_gains(folder, 1, 64, 48);
  const Image<float> truth = picture(64, 48, 1);
  for (const int k : {0, 1}) {
    Image<float> partial(64, 48, 4);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        const double s = on_strip(x, y, 64, 48)[0];
        for (int c = 0; c < 3; ++c) partial(x, y, c) = truth(x, y, c) + 0.1F * float(k);
        partial(x, y, 3) = float(std::clamp(k == 0 ? 1.4 - s : s - 0.6, 0.0, 1.0));
      }
    write_image(folder / ("part" + std::to_string(k) + ".png"), partial, Depth::u16);
  }
  const Result result = stitch(
      folder, "out.png", {"--partial", "part0.png", "--partial", "part1.png", "--alpha", "1e4", "--exposure", "keep"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["regions"], 2);
  const Image<float> after = read_texture(folder / "out.png").pixels;
  EXPECT_EQ(after.channels(), 3);
  double low = 1, high = -1;
  for (int y = 8; y < 40; ++y)
    for (int x = 5; x < 60; ++x) {
      if (x > 25 && x < 38) continue;
      low = std::min(low, double(after(x, y, 0) - truth(x, y, 0)));
      high = std::max(high, double(after(x, y, 0) - truth(x, y, 0)));
    }
  EXPECT_LT(high - low, 1.0 / 255);
  EXPECT_NEAR((low + high) / 2, 0.05, 0.02);
}

/// OpenEXR stores colours multiplied by alpha: what a photograph shows half counts in full.
TEST(Stitch, TakesPartialTexturesOfExrAsThoseOfPng) {
  const Folder folder;
  write_gains(folder, 1, 64, 48);
  const Image<float> truth = picture(64, 48, 1);
  for (const int k : {0, 1}) {
    Image<float> partial(64, 48, 4);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) partial(x, y, c) = truth(x, y, c) + 0.1F * float(k);
        partial(x, y, 3) = std::clamp(0.5F + (k == 0 ? 1 : -1) * float(x - 32) / 64, 0.0F, 1.0F);
      }
    write_image(folder / (std::to_string(k) + "a.png"), partial, Depth::u16);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < 3; ++c) partial(x, y, c) = float(linear_from_srgb(partial(x, y, c)));
    write_image(folder / (std::to_string(k) + "b.exr"), partial, Depth::half);
  }
  std::vector<Image<float>> found;
  for (const std::string name : {"a.png", "b.exr"}) {
    const std::string output = "out_" + name.substr(0, 1) + ".png";
    ASSERT_EQ(stitch(folder, output, {"--partial", "0" + name, "--partial", "1" + name}).status, 0);
    found.push_back(read_texture(folder / output).pixels);
  }
  for (std::size_t i = 0; i < found[0].values().size(); ++i)
    ASSERT_NEAR(found[0].values()[i], found[1].values()[i], 2e-3) << i;
}

TEST(Stitch, ReadsPartialTexturesAsTheModelStoresColours) {
  const Folder folder;
  write_strip(folder);
  Image<float> light(64, 48, 3, 0.5F), shown(64, 48, 4, 0.5F);
  write_image(folder / "light.exr", light, Depth::f32);
  write_image(folder / "shown.png", shown, Depth::u16);
  const Result result = marquetry(
      folder, {"stitch", "strip.obj", "light.exr", "--partial", "shown.png", "-o", "out.exr"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_NEAR(read_texture(folder / "out.exr").pixels(16, 24, 1), linear_from_srgb(0.5), 1e-4);
}

/// By mistake the model's own texture, each of whose colours would be a region.
TEST(Stitch, TakesNoPictureOfShadesForLabels) {
  const Folder folder;
  write_strip(folder, 128, 96);
  Image<float> shades(128, 96, 3);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x) shades(x, y, 0) = float(x) / 255, shades(x, y, 1) = float(y) / 255;
  write_image(folder / "shades.png", shades, Depth::u8);
  const Result result = stitch(folder, "out.png", {"--labels", "shades.png"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("a picture of labels has a colour for each photograph"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
}

TEST(Stitch, RefusesWhatDoesNotFit) {
  const Folder folder;
  write_gains(folder, 1.5, 64, 48);
  const auto error = [&](const Words& more) {
    Words words = {"stitch", "strip.obj", "-o", "out.png"};
    words.insert(words.end(), more.begin(), more.end());
    return refusal(folder, words, "out.png");
  };
  write_image(folder / "small.png", Image<float>(8, 8, 4, 0.5F));
  write_image(folder / "grey.png", Image<float>(64, 48, 1, 0.5F));
  write_image(folder / "black.png", Image<float>(64, 48, 3, 0.0F));
  write_image(folder / "labels.jpg", Image<float>(64, 48, 3, 0.0F));
  write_image(folder / "shown.png", Image<float>(64, 48, 4, 1.0F));
  EXPECT_THAT(error({"--partial", "small.png"}), HasSubstr("is 8 x 8, and the texture 64 x 48"));
  EXPECT_THAT(error({"--partial", "strip.png"}), HasSubstr("no alpha channel"));
  EXPECT_THAT(error({"--partial", "strip.png", "--confidence", "black.png"}),
              HasSubstr("no texel is seen"));
  EXPECT_THAT(error({"--partial", "grey.png", "--confidence", "black.png"}),
              HasSubstr("has 1 channel"));
  EXPECT_THAT(error({"--partial", "strip.png", "--confidence", "a.png", "--confidence", "b.png"}),
              HasSubstr("found 2 pictures for 1 picture"));
  EXPECT_THAT(error({"--labels", "black.png", "--unseen", "0"}), HasSubstr("no texel is seen"));
  EXPECT_THAT(error({"--labels", "labels.jpg"}), HasSubstr("save it as PNG"));
  EXPECT_THAT(error({"--labels", "grey.png", "--unseen", "1,2"}), HasSubstr("--unseen"));
  EXPECT_THAT(error({"--unseen", "red"}), HasSubstr("--unseen: found 'red'"));
  EXPECT_THAT(error({"--labels", "black.png", "--partial", "shown.png", "--unseen", "0"}),
              HasSubstr("--unseen is a label of regions"));
  EXPECT_THAT(error({"--labels", "grey.png", "--partial", "shown.png"}),
              HasSubstr("grey.png: --labels: found the number"));
  write_bytes(folder / "fan.ply", coloured_ply);
  const Result result = marquetry(folder, {"stitch", "fan.ply", "-o", "out.png"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("no texture coordinates"));
}

}  // namespace
}  // namespace mq::test
