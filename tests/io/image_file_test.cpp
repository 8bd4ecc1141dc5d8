#include "mq/io/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "io/image_files.h"
#include "io/picture_bytes.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using test::error_of;
using test::ImageFile;
using test::levels;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

Image<float> reals(int width, int height, int channels) {
  Image<float> image(width, height, channels);
  for (int i = 0; float& v : image.values()) v = float(std::exp(0.3 * std::sin(i)) * 20 - 16), ++i;
  return image;
}

/// 0, 1/4, 1/2, ... to 31: exact in 16-bit floating point.
Image<float> halves(int width, int height, int channels) {
  Image<float> image(width, height, channels);
  for (int i = 0; float& v : image.values()) v = float(i++ % 128 - 64) / 4;
  return image;
}

TEST_F(ImageFile, GivesBackIntegersExactlyInEveryLosslessFormat) {
  for (const char* extension : {".png", ".tif", ".bmp", ".tga", ".webp"})
    for (const int channels : {1, 2, 3, 4}) {
      const bool narrow = extension != std::string(".png") && extension != std::string(".tif");
      if (narrow && channels < 3) continue;
      const fs::path path = folder / ("eight" + std::to_string(channels) + extension);
      const Image<float> pixels = levels(37, 300, channels, 255);
      EXPECT_THAT(write_image(path, pixels), IsEmpty()) << path;
      const Texture read = read_texture(path);
      EXPECT_EQ(read.pixels, pixels) << path;
      EXPECT_EQ(read.format.depth, Depth::u8);
      EXPECT_THAT(read.notes, IsEmpty());
      if (narrow) continue;
      const Image<float> fine = levels(37, 300, channels, 65535);
      EXPECT_THAT(write_image(path, fine, Depth::u16), IsEmpty()) << path;
      EXPECT_EQ(read_texture(path).pixels, fine) << path;
      EXPECT_EQ(read_texture(path).format.depth, Depth::u16);
    }
}

TEST_F(ImageFile, GivesBackFloatsExactly) {
  for (const int channels : {1, 3, 4, 7, 40}) {
    write_image(folder / "a.tif", reals(33, 270, channels), Depth::f32);
    EXPECT_EQ(read_texture(folder / "a.tif").pixels, reals(33, 270, channels)) << channels;
    if (channels == 4) continue;  // with alpha, see DividesTheColoursOfExrByAlpha
    write_image(folder / "a.exr", reals(33, 270, channels), Depth::f32);
    EXPECT_EQ(read_texture(folder / "a.exr").pixels, reals(33, 270, channels)) << channels;
    EXPECT_EQ(read_texture(folder / "a.exr").format.depth, Depth::f32);
    write_image(folder / "h.exr", halves(33, 270, channels), Depth::half);
    EXPECT_EQ(read_texture(folder / "h.exr").pixels, halves(33, 270, channels)) << channels;
    EXPECT_EQ(read_texture(folder / "h.exr").format.depth, Depth::half);
  }
}

TEST_F(ImageFile, ReadsAnIntegerAsItselfDividedByTheLargest) {
  const fs::path path =
      put("ramp.png", test::png_file({3, 1, 8, 0}, std::string("\0\x01\x80\xfe", 4)));
  EXPECT_THAT(read_texture(path).pixels.values(), ElementsAre(1 / 255.f, 128 / 255.f, 254 / 255.f));
}

TEST_F(ImageFile, RoundsToTheNearestLevelAndClamps) {
  Image<float> pixels(6, 1, 1);
  const float values[] = {100.4f / 255, 100.6f / 255, -0.001f, 1.001f, -3, 7};
  std::ranges::copy(values, pixels.values().begin());
  const auto notes = write_image(folder / "a.png", pixels);
  EXPECT_THAT(read_texture(folder / "a.png").pixels.values(),
              ElementsAre(100 / 255.f, 101 / 255.f, 0, 1, 0, 1));
  EXPECT_THAT(notes, ElementsAre(HasSubstr("2 values beyond what 8 bits")));
}

TEST_F(ImageFile, RefusesWhatIsNotANumberWithItsPlace) {
  Image<float> pixels(5, 4, 3);
  pixels(2, 3, 1) = std::numeric_limits<float>::quiet_NaN();
  for (const char* name : {"a.png", "a.exr"}) {
    EXPECT_THAT(error_of([&] { write_image(folder / name, pixels, Depth::f32); }),
                AllOf(HasSubstr(name), HasSubstr("(column 2, row 3) holds nan in channel 1")));
    EXPECT_FALSE(fs::exists(folder / name));
  }
}

TEST_F(ImageFile, RefusesToReadWhatIsNotANumber) {
  // No writer here makes one: a TIFF by hand, with one strip of one float.
  const auto word = [](int v) { return std::string({char(v & 255), char(v >> 8)}); };
  const auto entry = [&](int tag, int type, int value) {
    return word(tag) + word(type) + word(1) + word(0) + word(value) + word(0);
  };
  std::string tiff = std::string("II*\0\x08\0\0\0", 8) + word(9) + entry(256, 3, 1) +
                     entry(257, 3, 1) + entry(258, 3, 32) + entry(259, 3, 1) + entry(262, 3, 1) +
                     entry(273, 4, 8 + 2 + 9 * 12 + 4) + entry(277, 3, 1) + entry(279, 4, 4) +
                     entry(339, 3, 3) + std::string(4, 0);
  EXPECT_THAT(error_of([&] {
                read_texture(put("inf.tif", tiff + std::string({0, 0, char(0x80), 0x7f})));
              }),
              HasSubstr("(column 0, row 0) holds inf in channel 0"));
  EXPECT_EQ(read_texture(put("two.tif", tiff + std::string({0, 0, 0, 0x40}))).pixels(0, 0), 2);
}

TEST_F(ImageFile, KeepsColourUnderTransparentPixels) {
  Image<float> pixels = levels(9, 9, 4, 255);
  for (int x = 0; x < 9; ++x) pixels(x, 0, 3) = 0;
  for (const char* name : {"a.png", "a.tif", "a.tga"}) {
    write_image(folder / name, pixels);
    const Texture once = read_texture(folder / name);
    EXPECT_EQ(once.pixels, pixels) << name;
    write_texture(folder / name, once);
    EXPECT_EQ(read_texture(folder / name).pixels, pixels) << name;
  }
}

/// OpenEXR stores colours multiplied by alpha; the product is rounded once, so is the quotient.
TEST_F(ImageFile, DividesTheColoursOfExrByAlpha) {
  const std::vector<float> stored = {0.25F, 0.125F, 0, 0.5F, 2, -1, 0.5F, 1, 0.7F, 0.6F, 0.5F, 0};
  const Texture read = read_texture(put("a.exr", test::exr_row(stored)));
  EXPECT_THAT(read.pixels.values(), ElementsAre(0.5F, 0.25F, 0, 0.5F, 2, -1, 0.5F, 1,  //
                                                0.7F, 0.6F, 0.5F, 0));

  // As straight values in PNG, and back into a file that differs in one pixel only.
  Texture changed = read;
  write_texture(folder / "a.png", changed);
  EXPECT_EQ(read_texture(folder / "a.png").pixels(0, 0, 0), float(32768) / 65535);
  changed.pixels(1, 0, 0) = 3;
  write_texture(folder / "b.exr", changed);
  EXPECT_EQ(read_texture(folder / "b.exr").pixels, changed.pixels);

  for (const Depth depth : {Depth::half, Depth::f32}) {
    const Image<float> pixels = levels(40, 30, 4, 255);
    write_image(folder / "c.exr", pixels, depth);
    const Texture once = read_texture(folder / "c.exr");
    for (std::size_t i = 0; i < pixels.values().size(); ++i) {
      if (pixels.values()[i / 4 * 4 + 3] == 0) continue;
      // Alpha is rounded to 11 or 24 digits, and so is the product.
      EXPECT_NEAR(once.pixels.values()[i], pixels.values()[i], depth == Depth::half ? 1e-3 : 3e-7);
    }
    // What lies in 16 bits comes back from there to the bit, as often as it is written.
    write_encoded(folder / "d.exr", once);
    if (depth == Depth::half) {
      EXPECT_TRUE(get(folder / "d.exr") == get(folder / "c.exr"));
    }
  }
}

TEST_F(ImageFile, DividesTheColoursOfTiffByAlphaWhereItSaysSo) {
  const std::vector<int> stored = {64, 32, 0, 128, 200, 100, 50, 255, 9, 8, 7, 0};
  const Texture straight = read_texture(put("u.tif", test::tiff_row(stored, 2)));
  const Texture associated = read_texture(put("a.tif", test::tiff_row(stored, 1)));
  for (std::size_t i = 0; i < stored.size(); ++i)
    EXPECT_EQ(straight.pixels.values()[i], float(stored[i]) / 255) << i;
  EXPECT_FLOAT_EQ(associated.pixels(0, 0, 0), 64.0F / 128);
  EXPECT_FLOAT_EQ(associated.pixels(0, 0, 1), 32.0F / 128);
  EXPECT_EQ(associated.pixels(1, 0, 0), 200.0F / 255);
  EXPECT_EQ(associated.pixels(2, 0, 0), 9.0F / 255);

  // Each is written as it was: what did not change comes back exactly, what says associated still
  // does.
  for (Texture texture : {straight, associated}) {
    texture.pixels(1, 0, 1) = 0.75F;
    write_texture(folder / "b.tif", texture);
    EXPECT_EQ(read_texture(folder / "b.tif").pixels(1, 0, 1), float(191) / 255);
    texture.pixels(1, 0, 1) = float(191) / 255;
    EXPECT_EQ(read_texture(folder / "b.tif").pixels, texture.pixels);
  }
  // Every product of two levels.
  Image<float> pixels(256, 255, 4, 0.0F);
  for (int alpha = 1; alpha < 256; ++alpha)
    for (int colour = 0; colour < 256; ++colour) {
      pixels(colour, alpha - 1, 0) = float(colour) / float(alpha);
      pixels(colour, alpha - 1, 3) = float(alpha) / 255;
    }
  Texture texture = associated;
  texture.path.clear();
  texture.pixels = pixels;
  write_texture(folder / "p.tif", texture);
  const Image<float> back = read_texture(folder / "p.tif").pixels;
  for (int alpha = 1; alpha < 256; ++alpha)
    for (int colour = 0; colour < 256; ++colour)
      ASSERT_NEAR(back(colour, alpha - 1, 0) * float(alpha), colour, 1e-3);
}

TEST_F(ImageFile, ReadsPalettesAsColours) {
  const std::string palette = test::png_chunk("PLTE", "\x10\x20\x30\xff\x80\x01");
  const fs::path path =
      put("p.png", test::png_file({2, 1, 8, 3}, std::string("\0\1\0", 3), palette));
  EXPECT_THAT(read_texture(path).pixels.values(),
              ElementsAre(1, 128 / 255.f, 1 / 255.f, 16 / 255.f, 32 / 255.f, 48 / 255.f));
  const fs::path clear = put("c.png", test::png_file({2, 1, 8, 3}, std::string("\0\1\0", 3),
                                                     palette + test::png_chunk("tRNS", "\x40")));
  EXPECT_THAT(
      read_texture(clear).pixels.values(),
      ElementsAre(1, 128 / 255.f, 1 / 255.f, 1, 16 / 255.f, 32 / 255.f, 48 / 255.f, 64 / 255.f));
}

TEST_F(ImageFile, ReadsOneBitAsBlackAndWhite) {
  const fs::path path = put("b.png", test::png_file({4, 1, 1, 0}, std::string("\0\xa0", 2)));
  EXPECT_THAT(read_texture(path).pixels.values(), ElementsAre(1, 0, 1, 0));
  EXPECT_EQ(read_texture(path).format.depth, Depth::u8);
}

TEST_F(ImageFile, ReadsInterlacedPictures) {
  // Adam7 of 2 × 2: pass 1 holds (0,0), pass 6 (1,0), pass 7 the second row.
  const fs::path path =
      put("i.png", test::png_file({2, 2, 8, 0, 1}, std::string("\0\x0a\0\x14\0\x1e\x28", 7)));
  EXPECT_THAT(read_texture(path).pixels.values(),
              ElementsAre(10 / 255.f, 20 / 255.f, 30 / 255.f, 40 / 255.f));
}

TEST_F(ImageFile, RefusesCmykAndReadsGreyAndColourJpeg) {
  EXPECT_EQ(read_texture(put("g.jpg", test::grey_jpeg(1))).pixels,
            Image<float>(8, 8, 1, 128 / 255.f));
  EXPECT_EQ(read_texture(put("c.jpg", test::grey_jpeg(3))).pixels,
            Image<float>(8, 8, 3, 128 / 255.f));
  EXPECT_THAT(error_of([&] { read_texture(put("k.jpg", test::grey_jpeg(4))); }),
              AllOf(HasSubstr("k.jpg"), HasSubstr("CMYK"), HasSubstr("convert it to RGB")));
}

TEST_F(ImageFile, KeepsResolutionGammaAndProfile) {
  const std::string density =
      test::png_chunk("pHYs", test::big_endian(3937) + test::big_endian(3937) + std::string(1, 1));
  const std::string gamma = test::png_chunk("gAMA", test::big_endian(100000));
  const std::string plain = test::png_file({1, 1}, std::string(4, 0));
  const std::string tagged = test::png_file({1, 1}, std::string(4, 0), gamma + density);
  const auto rewritten = [&](const std::string& bytes) {
    write_texture(folder / "out.png", read_texture(put("in.png", bytes)));
    return get(folder / "out.png");
  };
  EXPECT_THAT(rewritten(tagged), AllOf(HasSubstr(density), HasSubstr(gamma)));
  EXPECT_THAT(rewritten(plain), ::testing::Not(::testing::AnyOf(
                                    HasSubstr("gAMA"), HasSubstr("sRGB"), HasSubstr("pHYs"))));
}

TEST_F(ImageFile, KeepsChannelNames) {
  write_image(folder / "a.exr", reals(3, 3, 6), Depth::f32);
  const auto names = picture_info(folder / "a.exr").channels;
  ASSERT_EQ(names.size(), 6u);
  write_texture(folder / "b.exr", read_texture(folder / "a.exr"));
  EXPECT_EQ(picture_info(folder / "b.exr").channels, names);
  EXPECT_EQ(read_texture(folder / "b.exr").pixels, reals(3, 3, 6));
}

TEST_F(ImageFile, WritesEqualBytesTwice) {
  const auto names = {"a.png", "a.jpg", "a.tif", "a.exr", "a.bmp", "a.tga", "a.webp"};
  std::vector<std::string> first;
  for (const char* name : names) {
    write_image(folder / name, levels(20, 20, 3, 255));
    first.push_back(get(folder / name));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // no date of writing, either
  for (std::size_t i = 0; const char* name : names) {
    write_image(folder / name, levels(20, 20, 3, 255));
    EXPECT_TRUE(get(folder / name) == first[i++]) << name;
  }
}

TEST_F(ImageFile, SaysWhatAFormatCannotHold) {
  EXPECT_THAT(write_image(folder / "a.png", halves(2, 2, 3), Depth::half),
              ElementsAre(HasSubstr("png cannot hold 16-bit floating point; written with 16 bits"),
                          HasSubstr("clamped")));
  EXPECT_THAT(write_image(folder / "a.jpg", levels(2, 2, 3, 65535), Depth::u16),
              ElementsAre(HasSubstr("jpeg cannot hold 16 bits"), HasSubstr("encoded again")));
  EXPECT_THAT(error_of([&] { write_image(folder / "a.jpg", levels(2, 2, 4, 255)); }),
              HasSubstr("4 channels, of which jpeg holds 3"));
  EXPECT_THAT(error_of([&] { write_image(folder / "a.gif", levels(2, 2, 4, 255)); }),
              HasSubstr("use .png"));
  EXPECT_THAT(error_of([&] { write_image(folder / "a.png", Image<float>()); }),
              HasSubstr("no pixels"));
}

TEST_F(ImageFile, KeepsJpegCloseToWhatItWas) {
  Image<float> smooth(64, 64, 3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) smooth(x, y, 0) = x / 64.f, smooth(x, y, 1) = y / 64.f;
  write_image(folder / "a.jpg", smooth);
  const Image<float> read = read_texture(folder / "a.jpg").pixels;
  for (std::size_t i = 0; i < read.values().size(); ++i)
    ASSERT_NEAR(read.values()[i], smooth.values()[i], 4 / 255.);
}

TEST_F(ImageFile, GoesByContentWhereTheExtensionIsWrong) {
  write_image(folder / "a.tif", levels(3, 3, 3, 65535), Depth::u16);
  fs::rename(folder / "a.tif", folder / "ä ö.jpg");
  EXPECT_EQ(read_texture(folder / "ä ö.jpg").pixels, levels(3, 3, 3, 65535));
  EXPECT_EQ(read_texture(folder / "ä ö.jpg").format.file_format, "tiff");
}

TEST_F(ImageFile, NoticesEveryPlaceWhereAFileMayBeCutShort) {
  for (const char* name : {"a.png", "a.jpg", "a.tif", "a.exr", "a.bmp", "a.tga", "a.webp"}) {
    write_image(folder / name, levels(16, 40, 3, 255));
    const std::string whole = get(folder / name);
    const Image<float> pixels = read_texture(folder / name).pixels;
    for (std::size_t n = 0; n < whole.size(); n += 1 + whole.size() / 300) {
      const fs::path cut = put(std::string("cut ") + name, whole.substr(0, n));
      // A cut behind the last pixel may pass, as long as every pixel is there.
      try {
        EXPECT_TRUE(read_texture(cut).pixels == pixels) << name << " cut at " << n;
      } catch (const IoError& error) {
        EXPECT_THAT(error.what(), HasSubstr("cut a."));
      }
    }
  }
}

TEST_F(ImageFile, NoticesATiffWhoseStripsAreMissing) {
  // Large enough for several strips, which the decoder would paint black.
  for (const Depth depth : {Depth::u8, Depth::f32}) {
    write_image(folder / "a.tif", levels(200, 300, 3, 255), depth);
    const std::string whole = get(folder / "a.tif");
    const Image<float> pixels = read_texture(folder / "a.tif").pixels;
    int refused = 0;
    for (const double share : {0.05, 0.2, 0.4, 0.6, 0.8, 0.95}) {
      const fs::path cut = put("cut.tif", whole.substr(0, std::size_t(share * double(whole.size()))));
      try {
        EXPECT_TRUE(read_texture(cut).pixels == pixels) << "cut at " << share;
      } catch (const IoError& error) {
        EXPECT_THAT(error.what(), HasSubstr("cut.tif"));
        ++refused;
      }
    }
    EXPECT_EQ(refused, 6);
  }
}

TEST_F(ImageFile, CopiesAPictureThatNothingChangedIn) {
  write_image(folder / "a.jpg", levels(30, 20, 3, 255));
  Texture texture = read_texture(folder / "a.jpg");
  write_texture(folder / "b.jpg", texture);
  EXPECT_EQ(get(folder / "b.jpg"), get(folder / "a.jpg"));
  texture.pixels(3, 2, 0) += 0.5F;
  write_texture(folder / "c.jpg", texture);
  EXPECT_NE(get(folder / "c.jpg"), get(folder / "a.jpg"));
}

TEST_F(ImageFile, NoticesDamagedPngPixels) {
  write_image(folder / "a.png", levels(16, 40, 3, 255));
  std::string bytes = get(folder / "a.png");
  bytes[bytes.size() / 2] ^= 1;
  EXPECT_THAT(error_of([&] { read_texture(put("a.png", bytes)); }), HasSubstr("damaged"));
}

TEST_F(ImageFile, RefusesWhatIsNoPicture) {
  const auto read = [&](const fs::path& path) { return error_of([&] { read_texture(path); }); };
  EXPECT_THAT(read(folder / "none.png"), HasSubstr("no such file"));
  EXPECT_THAT(read(folder), HasSubstr("directory"));
  EXPECT_THAT(read("/dev/null"), HasSubstr("not an ordinary file"));
  EXPECT_THAT(read(put("empty.png", "")), HasSubstr("empty"));
  EXPECT_THAT(read(put("text.png", "v 0 0 0\n")), HasSubstr("not a picture"));
  EXPECT_THAT(read(put("junk.tga", std::string(500, 'x'))), HasSubstr("junk.tga"));
}

TEST_F(ImageFile, RefusesAbsurdSizesBeforeAnythingIsAllocated) {
  EXPECT_THAT(error_of([&] {
                read_texture(put("w.png", test::png_file({100000, 1}, std::string(40, 0))));
              }),
              AllOf(HasSubstr("100000 x 1 pixels"), HasSubstr("32768 a side")));
  EXPECT_THAT(error_of([&] {
                read_texture(put("b.png", test::png_file({30000, 30000}, std::string(40, 0))));
              }),
              HasSubstr("bytes cannot hold 30000 x 30000 pixels"));
  write_image(folder / "e.exr", levels(4, 4, 3, 255));
  std::string exr = get(folder / "e.exr");
  exr[exr.find("box2i") + 10 + 15] = 0x7f;  // the highest byte of the last row's number
  EXPECT_THAT(error_of([&] { read_texture(put("e.exr", exr)); }),
              AllOf(HasSubstr("e.exr: 4 x 2130706436"), HasSubstr("32768 a side")));
}

TEST_F(ImageFile, BelievesALargeFlatPicture) {
  write_image(folder / "flat.png", Image<float>(4000, 3000, 3, 1));
  EXPECT_LT(fs::file_size(folder / "flat.png"), 60000u);
  EXPECT_EQ(read_texture(folder / "flat.png").pixels(3999, 2999, 2), 1);
}

TEST_F(ImageFile, ReadsOrRefusesDamagedFiles) {
  std::uint32_t state = 99;
  const auto random = [&](std::size_t below) {
    state = state * 1664525u + 1013904223u;
    return std::size_t(state >> 8) % below;
  };
  for (const char* name : {"a.png", "a.jpg", "a.tif", "a.exr", "a.bmp", "a.tga", "a.webp"}) {
    write_image(folder / name, levels(20, 20, 3, 255));
    const std::string whole = get(folder / name);
    for (int round = 0; round < 60; ++round) {
      std::string bytes = whole;
      for (int k = 0; k < 3; ++k) bytes[random(bytes.size())] = char(random(256));
      try {
        const Texture found = read_texture(put(name, bytes));
        for (const float v : found.pixels.values()) ASSERT_TRUE(std::isfinite(v));
      } catch (const IoError& error) {
        EXPECT_THAT(error.what(), HasSubstr(name));
      }
    }
  }
}

TEST_F(ImageFile, ReadsAndWritesInMemory) {
  Texture texture;
  texture.name = "embedded 0";
  texture.pixels = levels(5, 6, 3, 255);
  const EncodedPicture encoded = texture_bytes(texture, "png");
  const Texture read = read_texture_bytes(encoded.bytes, "embedded 0");
  EXPECT_EQ(read.pixels, texture.pixels);
  EXPECT_EQ(read.name, "embedded 0");
  EXPECT_TRUE(read.path.empty());
  EXPECT_THAT(error_of([&] { texture_bytes(texture, "gif"); }), HasSubstr("PNG, JPEG"));
  EXPECT_THAT(error_of([&] { read_texture_bytes({}, "embedded 1"); }), HasSubstr("embedded 1"));
}

TEST_F(ImageFile, ReadsTheHeadAlone) {
  write_image(folder / "a.png", levels(7, 5, 4, 65535), Depth::u16);
  const PictureInfo info = picture_info(folder / "a.png");
  EXPECT_EQ(info.width, 7);
  EXPECT_EQ(info.height, 5);
  EXPECT_THAT(info.channels, ElementsAre("R", "G", "B", "A"));
  EXPECT_EQ(info.format.depth, Depth::u16);
  EXPECT_EQ(info.format.file_format, "png");
}

TEST_F(ImageFile, LeavesTheOldPictureWhenTheNewOneCannotBeMade) {
  write_image(folder / "a.png", levels(4, 4, 3, 255));
  Image<float> bad(4, 4, 3);
  bad(0, 0) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(write_image(folder / "a.png", bad), IoError);
  EXPECT_EQ(read_texture(folder / "a.png").pixels, levels(4, 4, 3, 255));
}

TEST_F(ImageFile, WritesTiffThatCanBeReadWhereThereAreCameraTags) {
  // A JPEG whose EXIF says how the exposure was metered.
  const std::string exif("Exif\0\0II*\0\x08\0\0\0"
                         "\x01\0\x69\x87\x04\0\x01\0\0\0\x1a\0\0\0\0\0\0\0"
                         "\x01\0\x07\x92\x03\0\x01\0\0\0\x05\0\0\0\0\0\0\0",
                         50);
  const std::string jpeg = test::grey_jpeg(3);
  const Texture photo = read_texture(
      put("photo.jpg", jpeg.substr(0, 2) + test::jpeg_segment(0xe1, exif) + jpeg.substr(2)));
  write_texture(folder / "photo.tif", photo);
  const Texture tiff = read_texture(folder / "photo.tif");
  EXPECT_EQ(tiff.pixels, photo.pixels);
  write_texture(folder / "again.tif", tiff);
  EXPECT_EQ(read_texture(folder / "again.tif").pixels, photo.pixels);
}

}  // namespace
}  // namespace mq
