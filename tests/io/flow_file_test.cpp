#include "mq/io/flow_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/flo.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using ::testing::HasSubstr;

/// Sixteenths of pixels, unknown at (2, 1).
Image<float> example() {
  Image<float> field(5, 3, 2);
  for (std::size_t i = 0; i < field.values().size(); ++i) field.values()[i] = float(i) / 16 - 0.5F;
  field(2, 1, 0) = field(2, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  return field;
}

void expect_example(const Image<float>& field) {
  const Image<float> wanted = example();
  ASSERT_EQ(field.width(), 5);
  ASSERT_EQ(field.height(), 3);
  ASSERT_EQ(field.channels(), 2);
  for (std::size_t i = 0; i < wanted.values().size(); ++i) {
    if (std::isnan(wanted.values()[i]))
      EXPECT_TRUE(std::isnan(field.values()[i]));
    else
      EXPECT_EQ(field.values()[i], wanted.values()[i]);
  }
}

std::string error_of(const std::filesystem::path& path) {
  try {
    read_flow(path);
  } catch (const IoError& error) {
    return error.what();
  }
  return "";
}

using FlowFile = FolderTest;

TEST_F(FlowFile, ComesBackFromEveryFormat) {
  for (const char* name : {"a.flo", "a.png", "a.exr"}) {
    write_flow(folder / name, example());
    expect_example(read_flow(folder / name));
  }
}

TEST_F(FlowFile, LiesInBytesAsTheBenchmarksHaveIt) {
  Image<float> field(2, 1, 2);
  field(0, 0, 0) = 1.5F, field(0, 0, 1) = -2, field(1, 0, 0) = 3, field(1, 0, 1) = INFINITY;
  write_flow(folder / "a.flo", field);
  const Bytes bytes = read_file(folder / "a.flo");
  ASSERT_EQ(bytes.size(), 28U);
  EXPECT_EQ(text_of(bytes).substr(0, 4), "PIEH");
  float values[4];
  std::memcpy(values, bytes.data() + 12, 16);
  EXPECT_EQ(values[0], 1.5F);
  EXPECT_EQ(values[1], -2.0F);
  EXPECT_GT(values[3], 1e9F);

  write_flow(folder / "a.png", field);
  const Texture stored = read_texture(folder / "a.png");
  EXPECT_EQ(stored.format.depth, Depth::u16);
  EXPECT_EQ(std::round(stored.pixels(0, 0, 0) * 65535), 32768 + 96);
  EXPECT_EQ(std::round(stored.pixels(0, 0, 1) * 65535), 32768 - 128);
  EXPECT_EQ(std::round(stored.pixels(0, 0, 2) * 65535), 1);
  EXPECT_EQ(stored.pixels(1, 0, 2), 0);

  write_flow(folder / "a.exr", field);
  EXPECT_EQ(picture_info(folder / "a.exr").channels, (std::vector<std::string>{"U", "V"}));
}

TEST_F(FlowFile, IsRefusedWhereverItIsCutOrChanged) {
  write_flow(folder / "a.flo", example());
  const Bytes whole = read_file(folder / "a.flo");
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_THROW(flow_from_bytes(ByteView(whole).first(length), "a.flo"), IoError) << length;
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_THROW(flow_from_bytes(longer, "a.flo"), IoError);
  for (std::size_t at = 0; at < 12; ++at)
    for (const int bits : {0x01, 0x80, 0xff}) {
      Bytes changed = whole;
      changed[at] ^= std::byte(bits);
      EXPECT_THROW(flow_from_bytes(changed, "a.flo"), IoError) << at;
    }
  // Numbers of any kind are vectors or unknown.
  Bytes wild = whole;
  for (std::size_t i = 12; i < wild.size(); ++i) wild[i] = std::byte(37 * i * i + i / 3);
  const Image<float> any = flow_from_bytes(wild, "a.flo");
  for (const float value : any.values()) EXPECT_TRUE(std::isnan(value) || std::abs(value) < 1e9F);
}

TEST_F(FlowFile, IsUnknownWhereItIsMarkedInAnyOfTheWaysInUse) {
  for (const float mark : {1e9F, -1e9F, 1e10F, 1.6666667e9F, INFINITY, -INFINITY, NAN}) {
    Image<float> field(2, 1, 2, 3.5F);
    field(1, 0, 1) = mark;
    Bytes bytes = bytes_of_flow(field);
    std::memcpy(bytes.data() + 12 + 3 * 4, &mark, 4);
    const Image<float> read = flow_from_bytes(bytes, "a.flo");
    EXPECT_EQ(read(0, 0), 3.5F);
    EXPECT_TRUE(std::isnan(read(1, 0, 0)) && std::isnan(read(1, 0, 1))) << mark;
  }
}

TEST_F(FlowFile, InPicturesIsRefusedWhereTheyAreCut) {
  for (const char* name : {"a.png", "a.exr"}) {
    write_flow(folder / name, example());
    const Bytes whole = read_file(folder / name);
    for (const double part : {0.0, 0.3, 0.7}) {
      write_file(folder / name, ByteView(whole).first(std::size_t(part * double(whole.size()))));
      EXPECT_THAT(error_of(folder / name), HasSubstr(name)) << part;
    }
  }
}

TEST_F(FlowFile, SaysWhatItFoundAndWanted) {
  write_image(folder / "grey.png", Image<float>(4, 4, 1));
  EXPECT_THAT(error_of(folder / "grey.png"), HasSubstr("three of 16 (KITTI)"));
  write_image(folder / "rgb.png", Image<float>(4, 4, 3));
  EXPECT_THAT(error_of(folder / "rgb.png"), HasSubstr("of 8 bits"));
  write_image(folder / "rgba.exr", Image<float>(4, 4, 4), Depth::f32);
  EXPECT_THAT(error_of(folder / "rgba.exr"), HasSubstr("4 channels"));
  EXPECT_THAT(error_of(folder / "none.flo"), HasSubstr("none.flo"));
  EXPECT_THROW(read_flow(folder / "a.txt"), InvalidInput);
  Image<float> fast(2, 2, 2);
  fast(1, 0, 1) = 600;
  EXPECT_THROW(write_flow(folder / "a.png", fast), InvalidInput);
  EXPECT_THROW(write_flow(folder / "a.flo", Image<float>(2, 2, 3)), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

}  // namespace
}  // namespace mq
