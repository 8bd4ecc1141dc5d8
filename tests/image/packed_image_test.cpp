#include "mq/image/packed_image.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

namespace mq {
namespace {

Image<float> picture(const auto& value) {
  Image<float> image(37, 11, 3);
  for (std::size_t i = 0; i < image.values().size(); ++i) image.values()[i] = value(i);
  return image;
}

void expect_kept(const Image<float>& image, std::int64_t bytes_per_value) {
  Image<float> given = image;
  PackedImage packed(std::move(given));
  EXPECT_EQ(packed.bytes(), bytes_per_value * std::ssize(image.values()));
  const Image<float> again = std::move(packed).unpacked();
  ASSERT_EQ(again.width(), image.width());
  ASSERT_EQ(again.height(), image.height());
  ASSERT_EQ(again.channels(), image.channels());
  for (std::size_t i = 0; i < image.values().size(); ++i)
    EXPECT_EQ(std::bit_cast<std::uint32_t>(again.values()[i]), std::bit_cast<std::uint32_t>(image.values()[i])) << i;
}

TEST(PackedImage, KeepsPicturesOfEightBitsAsBytes) {
  expect_kept(picture([](std::size_t i) { return float(i % 256) / 255.0F; }), 1);
}

TEST(PackedImage, KeepsPicturesOfSixteenBitsAsWords) {
  expect_kept(picture([](std::size_t i) { return float(i * 53 % 65536) / 65535.0F; }), 2);
  Image<float> large(256, 256, 1);
  for (std::size_t i = 0; i < large.values().size(); ++i) large.values()[i] = float(i) / 65535.0F;
  expect_kept(large, 2);
}

TEST(PackedImage, KeepsAllOthersAsTheyAre) {
  const auto but_for = [](float odd) {
    return picture([odd](std::size_t i) { return i == 500 ? odd : float(i % 256) / 255.0F; });
  };
  for (const float odd : {0.3F, -0.0F, -1.0F, 1.5F, std::nextafter(1.0F, 0.0F), std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::denorm_min(), 1e30F})
    expect_kept(but_for(odd), 4);
}

TEST(PackedImage, KeepsAnEmptyPicture) {
  EXPECT_TRUE(std::move(PackedImage(Image<float>())).unpacked().empty());
}

}  // namespace
}  // namespace mq
