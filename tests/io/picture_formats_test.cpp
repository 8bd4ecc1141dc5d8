// WebP, KTX, and what pictures say beside their pixels: orientation, profiles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/image_files.h"
#include "io/picture_bytes.h"

namespace mq {
namespace {

using test::error_of;
using test::levels;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class PictureFormats : public test::ImageFile {};

TEST_F(PictureFormats, KeepsColourUnderTransparentPixelsOfWebp) {
  Image<float> pixels = levels(40, 30, 4, 255);
  for (int x = 0; x < 40; ++x) pixels(x, 7, 3) = 0;
  write_image(folder / "a.webp", pixels);
  EXPECT_EQ(read_texture(folder / "a.webp").pixels, pixels);
  EXPECT_EQ(picture_info(folder / "a.webp").format.file_format, "webp");
}

TEST_F(PictureFormats, WritesGreyWebpAsColours) {
  EXPECT_THAT(write_image(folder / "a.webp", levels(9, 5, 1, 255)), ElementsAre(HasSubstr("no grey")));
  const Image<float> read = read_texture(folder / "a.webp").pixels;
  ASSERT_EQ(read.channels(), 3);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(read(3, 2, c), levels(9, 5, 1, 255)(3, 2, 0));
  EXPECT_THAT(error_of([&] { write_image(folder / "b.webp", Image<float>(16384, 1, 3)); }),
              HasSubstr("WebP holds 16383 a side; choose .png"));
}

TEST_F(PictureFormats, SaysThatWebpWithLossIsWrittenWithout) {
  // 8 x 8 pixels, by cwebp -q 30.
  const std::vector<unsigned char> file = {
      82, 73, 70, 70, 60, 0, 0, 0, 87, 69, 66, 80, 86, 80, 56, 32, 48, 0, 0, 0, 208, 1, 0,
      157, 1, 42, 8, 0, 8, 0, 4, 0, 104, 37, 176, 2, 116, 1, 14, 187, 5, 239, 0, 0, 254, 236,
      222, 21, 234, 86, 172, 40, 231, 247, 66, 198, 61, 132, 97, 55, 167, 101, 3, 249, 89,
      247, 64, 0};
  const Texture read = read_texture(put("l.webp", std::string(file.begin(), file.end())));
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("with loss")));
  Texture changed = read;
  changed.pixels(0, 0, 0) = 1;
  write_texture(folder / "n.webp", changed);
  EXPECT_EQ(read_texture(folder / "n.webp").pixels, changed.pixels);
  EXPECT_THAT(read_texture(folder / "n.webp").notes, IsEmpty());
}

TEST_F(PictureFormats, RefusesKtxWithAWayOut) {
  EXPECT_THAT(error_of([&] { read_texture(put("a.ktx2", "\xabKTX 20\xbb\r\n\x1a\n" + std::string(68, '\0'))); }),
              AllOf(HasSubstr("KTX container"), HasSubstr("decode it to PNG")));
}

/// Blocks of one colour, red where the file begins and green at the end of its first row.
std::string marked_jpeg(const fs::path& path, int orientation) {
  Image<float> pixels(48, 32, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) pixels(x, y, 0) = pixels(x + 32, y, 1) = 1;
  write_image(path, pixels);
  std::ifstream in(path, std::ios::binary);
  return test::with_orientation({std::istreambuf_iterator<char>(in), {}}, orientation);
}

TEST_F(PictureFormats, TurnsAPictureUprightAsItsTagSaysAndThenSaysSo) {
  // Where the file's first row and first column are seen (CIPA DC-008, Orientation).
  const char* sides[][2] = {{"top", "left"}, {"top", "right"},  {"bottom", "right"}, {"bottom", "left"},
                            {"left", "top"}, {"right", "top"}, {"right", "bottom"}, {"left", "bottom"}};
  const auto opposite = [](const std::string& side) -> std::string {
    return side == "top" ? "bottom" : side == "bottom" ? "top" : side == "left" ? "right" : "left";
  };
  for (int tag = 1; tag <= 8; ++tag) {
    SCOPED_TRACE(tag);
    const fs::path path = put("t.jpg", marked_jpeg(folder / "plain.jpg", tag));
    EXPECT_EQ(orientation(read_texture(path).format), tag);
    EXPECT_EQ(read_texture(path).pixels.width(), 48);
    const Texture upright = read_upright(path);
    EXPECT_EQ(upright.pixels.width(), tag < 5 ? 48 : 32);
    EXPECT_EQ(upright.notes.size(), tag == 1 ? 0u : 1u);
    const auto at = [&](const std::string& one, const std::string& two, int channel) {
      const bool right = one == "right" || two == "right", below = one == "bottom" || two == "bottom";
      return upright.pixels(right ? upright.pixels.width() - 1 : 0, below ? upright.pixels.height() - 1 : 0,
                            channel);
    };
    const std::string row = sides[tag - 1][0], column = sides[tag - 1][1];
    EXPECT_GT(at(row, column, 0), 0.9f);
    EXPECT_LT(at(row, column, 1), 0.1f);
    EXPECT_GT(at(row, opposite(column), 1), 0.9f);

    // As it was it is the file that was read; changed, in whatever format, it is not turned twice.
    write_texture(folder / "same.jpg", upright);
    EXPECT_EQ(get(folder / "same.jpg"), get(path));
    Texture changed = upright;
    changed.pixels(20, 20, 2) = 0.25f;
    for (const char* name : {"n.jpg", "n.png", "n.tif", "n.webp"}) {
      write_texture(folder / name, changed);
      const Texture back = read_upright(folder / name);
      EXPECT_EQ(orientation(back.format), 1) << name;
      EXPECT_EQ(back.pixels.width(), upright.pixels.width());
      EXPECT_NEAR(back.pixels(0, 0, 0), upright.pixels(0, 0, 0), 0.02) << name;
    }
  }
}

TEST_F(PictureFormats, TurnsWebpAndKeepsItsExif) {
  const std::string jpeg = marked_jpeg(folder / "plain.jpg", 6);
  write_texture(folder / "a.webp", read_texture(folder / "plain.jpg"));
  // VP8X says EXIF; pixels; EXIF.
  const std::string plain = get(folder / "a.webp");
  const auto little = [](std::size_t n) {
    return std::string{char(n & 255), char(n >> 8 & 255), char(n >> 16 & 255), char(n >> 24)};
  };
  const std::string exif = test::exif_of(6).substr(6);
  std::string body = "WEBPVP8X" + little(10) + std::string("\x08\0\0\0", 4) + std::string("\x2f\0\0\x1f\0\0", 6) +
                     plain.substr(12) + "EXIF" + little(exif.size()) + exif;
  const Texture turned = read_upright(put("t.webp", "RIFF" + little(body.size()) + body));
  EXPECT_EQ(turned.pixels.width(), 32);
  EXPECT_GT(turned.pixels(31, 0, 0), 0.9f);
  Texture changed = turned;
  changed.pixels(9, 9, 2) = 1;
  write_texture(folder / "n.webp", changed);
  EXPECT_THAT(get(folder / "n.webp"), HasSubstr("EXIF"));
  EXPECT_EQ(read_upright(folder / "n.webp").pixels, changed.pixels);
}

/// An ICC profile of that name, whose only tag says that it is as long as `said`.
std::string profile(const std::string& name, std::optional<std::uint32_t> said = {}) {
  std::string icc(128, '\0');
  icc.replace(12, 12, "mntrRGB XYZ ");
  icc.replace(8, 4, std::string("\x02\x10\0\0", 4));
  icc.replace(36, 4, "acsp");
  icc.replace(68, 12, std::string("\0\0\xf6\xd6\0\1\0\0\0\0\xd3\x2d", 12));  // D50
  std::string desc =
      "desc" + std::string(4, '\0') + test::big_endian(std::uint32_t(name.size() + 1)) + name + std::string(80, '\0');
  desc.resize((desc.size() + 3) / 4 * 4);
  icc += test::big_endian(1) + "desc" + test::big_endian(144) +
         test::big_endian(said.value_or(std::uint32_t(desc.size()))) + desc;
  return test::big_endian(std::uint32_t(icc.size())) + icc.substr(4);
}

std::string jpeg_with_profile(const std::string& icc) {
  const std::string jpeg = test::grey_jpeg(3), mark("ICC_PROFILE\0\1\1", 14);
  return jpeg.substr(0, 2) + test::jpeg_segment(0xe2, mark + icc) + jpeg.substr(2);
}

TEST_F(PictureFormats, NamesAProfileThatIsNotSrgb) {
  const auto read = [&](const std::string& name) {
    return read_texture(put("p.jpg", jpeg_with_profile(profile(name))));
  };
  EXPECT_THAT(read("sRGB IEC61966-2.1").notes, IsEmpty());
  const Texture adobe = read("Adobe RGB (1998)");
  EXPECT_THAT(adobe.notes, ElementsAre(HasSubstr("its ICC profile is \"Adobe RGB (1998)\", not sRGB: it is kept")));
  for (const char* name : {"n.png", "n.tif", "n.webp", "n.jpg"}) {
    write_texture(folder / name, adobe);
    EXPECT_THAT(read_texture(folder / name).notes, ElementsAre(HasSubstr("Adobe RGB"))) << name;
  }
}

/// OpenImageIO would read a tag of fewer than 12 bytes as one of four gigabytes.
TEST_F(PictureFormats, LeavesOutAProfileThatIsDamaged) {
  const Texture adobe = read_texture(put("p.jpg", jpeg_with_profile(profile("Adobe RGB (1998)"))));
  const auto expect_without = [&](const std::string& name, const std::string& bytes) {
    const Texture read = read_texture(put(name, bytes));
    EXPECT_THAT(read.notes, ElementsAre(HasSubstr("its colour profile is damaged and was left out"))) << name;
    EXPECT_TRUE(read.pixels == adobe.pixels) << name;
    const std::string again = name.ends_with("png") ? "again.tif" : "again.png";
    write_texture(folder / again, read);
    EXPECT_THAT(read_texture(folder / again).notes, IsEmpty()) << name;
  };
  for (const std::uint32_t size : {0U, 8U, 11U, 100'000U, 0xffff'ffffU})
    expect_without("d.jpg", jpeg_with_profile(profile("Adobe", size)));
  const std::string sound = profile("Adobe"), damaged = profile("Adobe", 8);
  const std::string first("ICC_PROFILE\0\1\2", 14), jpeg = test::grey_jpeg(3);
  expect_without("half.jpg", jpeg.substr(0, 2) + test::jpeg_segment(0xe2, first + sound) + jpeg.substr(2));
  const std::string loose = jpeg_with_profile(damaged);  // bytes that are no marker, as decoders forgive them
  expect_without("loose.jpg", loose.substr(0, 2) + test::jpeg_segment(0xfe, "c") + "loose" + loose.substr(2));
  write_texture(folder / "p.png", adobe);
  const std::string png = get(folder / "p.png");
  const std::size_t chunk = png.find("iCCP") - 4;
  const auto length = std::size_t(std::uint8_t(png[chunk + 2])) << 8 | std::uint8_t(png[chunk + 3]);
  expect_without("d.png", png.substr(0, chunk) + test::png_chunk("iCCP", std::string("x\0\0", 3) + test::zlib_stored(damaged)) +
                              png.substr(chunk + 12 + length));
  write_texture(folder / "p.tif", adobe);
  std::string tiff = get(folder / "p.tif");
  const std::size_t tag_size = tiff.rfind("acsp") - 36 + 140;
  tiff.replace(tag_size, 4, test::big_endian(8));
  expect_without("d.tif", tiff);
}

/// What of a PNG says how its colours are meant, each by itself and all together, is what it was; nothing comes to it.
TEST_F(PictureFormats, KeepsWhatAPngSaysOfItsColours) {
  const std::string gamma = test::png_chunk("gAMA", test::big_endian(45455));
  std::string xy;
  for (const std::uint32_t value : {31270U, 32900U, 64000U, 33000U, 21000U, 71000U, 15000U, 6000U})
    xy += test::big_endian(value);
  const std::string chromaticities = test::png_chunk("cHRM", xy), cicp = test::png_chunk("cICP", {9, 16, 0, 1}),
                    srgb = test::png_chunk("sRGB", std::string(1, '\0')),
                    icc = test::png_chunk("iCCP", std::string("own name\0\0", 10) +
                                                      test::zlib_stored(profile("Adobe RGB (1998)")));
  const std::string row("\0\x01\x80\xfe", 4);
  for (const std::string& colour : {gamma + chromaticities, cicp, srgb, icc, cicp + icc + gamma + chromaticities,
                                    cicp + srgb + gamma + chromaticities}) {
    Texture texture = read_texture(put("p.png", test::png_file({1, 1, 8, 2}, row, colour)));
    texture.pixels.values()[0] = 1;
    write_texture(folder / "n.png", texture);
    const std::string written = get(folder / "n.png");
    EXPECT_EQ(written.substr(33, colour.size()), colour);
    EXPECT_EQ(written.substr(33 + colour.size() + 4, 4), "IDAT") << "something else is in it";
    EXPECT_EQ(read_texture(folder / "n.png").pixels.values()[0], 1);
    write_texture(folder / "n.tif", texture);
    EXPECT_EQ(get(folder / "n.tif").find("cHRM"), std::string::npos);
  }
}

/// OpenEXR makes room for what an attribute promises before it reads it.
TEST_F(PictureFormats, RefusesAnExrWhoseHeadPromisesMoreThanThereIs) {
  write_image(folder / "a.exr", levels(9, 5, 3, 255), Depth::half);
  const std::string exr = get(folder / "a.exr");
  const auto error_with = [&](const std::string& attribute) {
    return error_of([&] { picture_info(put("b.exr", exr.substr(0, 8) + attribute + exr.substr(8))); });
  };
  const auto attribute = [](const std::string& type, int size, const std::string& value) {
    return "note" + std::string(1, '\0') + type + '\0' + test::little_endian(size) + value;
  };
  EXPECT_EQ(error_with(attribute("string", 3, "abc")), "");
  for (const int size : {2'000'000'000, -1})
    EXPECT_THAT(error_with(attribute("string", size, "abc")), HasSubstr("the head of the EXR file is cut short"));
  const std::string sides = test::little_endian(20'000) + test::little_endian(20'000);
  EXPECT_THAT(error_with(attribute("preview", 8, sides)), HasSubstr("'note' of its head does not fit into the 8 bytes"));
  EXPECT_THAT(error_with(attribute("stringvector", 4, test::little_endian(2'000'000'000))), HasSubstr("does not fit"));
}

TEST_F(PictureFormats, LetsNoLibraryPrint) {
  std::string damaged = test::png_file({4, 4}, std::string(4 * 13, '\0'));
  damaged[damaged.find("IDAT") + 12] ^= 1;
  put("damaged.png", damaged);
  testing::internal::CaptureStderr();
  const std::string error = error_of([&] { read_texture(folder / "damaged.png"); });
  std::fputs("others may\n", stderr);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "others may\n");
  EXPECT_THAT(error, HasSubstr("damaged.png: cut short or damaged"));
}

}  // namespace
}  // namespace mq
