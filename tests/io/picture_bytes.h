#pragma once
/// Small picture files put together byte by byte: kinds that no writer of this project makes.

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace mq::test {

inline std::string big_endian(std::uint32_t value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

inline std::string png_chunk(const std::string& type, const std::string& data) {
  std::uint32_t crc = ~0u;
  for (const char c : type + data) {
    crc ^= std::uint8_t(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return big_endian(std::uint32_t(data.size())) + type + data + big_endian(~crc);
}

/// A zlib stream that stores `data` (below 64 kB) as it is.
inline std::string zlib_stored(const std::string& data) {
  std::uint32_t a = 1, b = 0;
  for (const char c : data) a = (a + std::uint8_t(c)) % 65521, b = (b + a) % 65521;
  const auto n = std::uint16_t(data.size());
  const auto inverse = std::uint16_t(~n);
  return std::string("\x78\x01\x01") + char(n & 255) + char(n >> 8) + char(inverse & 255) +
         char(inverse >> 8) + data + big_endian(b << 16 | a);
}

/// The least significant byte first, as in OpenEXR and one kind of TIFF.
template <class Number>
std::string little_endian(Number value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

/// An OpenEXR file of one row: four channels of 32 bits, R, G, B and A of each pixel in turn.
inline std::string exr_row(const std::vector<float>& rgba) {
  const int width = int(rgba.size() / 4);
  const auto attribute = [](const std::string& name, const std::string& type,
                            const std::string& value) {
    return name + '\0' + type + '\0' + little_endian(int(value.size())) + value;
  };
  std::string channels;
  for (const char name : std::string("ABGR"))
    channels += std::string(1, name) + '\0' + little_endian(2) + little_endian(0) +
                little_endian(1) + little_endian(1);
  const std::string window =
      little_endian(0) + little_endian(0) + little_endian(width - 1) + little_endian(0);
  std::string file = little_endian(20000630) + little_endian(2) +
                     attribute("channels", "chlist", channels + '\0') +
                     attribute("compression", "compression", std::string(1, '\0')) +
                     attribute("dataWindow", "box2i", window) +
                     attribute("displayWindow", "box2i", window) +
                     attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
                     attribute("pixelAspectRatio", "float", little_endian(1.0F)) +
                     attribute("screenWindowCenter", "v2f", std::string(8, '\0')) +
                     attribute("screenWindowWidth", "float", little_endian(1.0F)) + '\0';
  file += little_endian(std::uint64_t(file.size() + 8));
  file += little_endian(0) + little_endian(int(rgba.size() * 4));
  for (const int channel : {3, 2, 1, 0})
    for (int x = 0; x < width; ++x) file += little_endian(rgba[std::size_t(4 * x + channel)]);
  return file;
}

/// A TIFF file of one row of red, green, blue and alpha with 8 bits. `extra` is the kind of alpha:
/// 1 associated, 2 not.
inline std::string tiff_row(const std::vector<int>& rgba, int extra) {
  const auto entry = [](int tag, int type, int count, int value) {
    return little_endian(std::uint16_t(tag)) + little_endian(std::uint16_t(type)) +
           little_endian(count) + little_endian(value);
  };
  const std::string bits = little_endian(std::uint64_t(0x0008000800080008));
  const int pixels = 8 + int(bits.size());
  std::string file = "II*" + std::string(1, '\0') + little_endian(pixels + int(rgba.size())) + bits;
  for (const int value : rgba) file += char(value);
  file += little_endian(std::uint16_t(11)) + entry(256, 3, 1, int(rgba.size() / 4)) +
          entry(257, 3, 1, 1) + entry(258, 3, 4, 8) + entry(259, 3, 1, 1) + entry(262, 3, 1, 2) +
          entry(273, 4, 1, pixels) + entry(277, 3, 1, 4) + entry(278, 3, 1, 1) +
          entry(279, 4, 1, int(rgba.size())) + entry(284, 3, 1, 1) + entry(338, 3, 1, extra);
  return file + little_endian(0);
}

struct PngHead {
  std::uint32_t width, height;
  int bits = 8;
  int color = 2;  ///< 0 grey, 2 RGB, 3 palette, 4 grey with alpha, 6 RGBA
  int interlace = 0;
};

/// `rows` holds every scanline with its filter byte; `before` further chunks ahead of it.
inline std::string png_file(const PngHead& head, const std::string& rows,
                            const std::string& before = "") {
  const std::string data = big_endian(head.width) + big_endian(head.height) + char(head.bits) +
                           char(head.color) + char(0) + char(0) + char(head.interlace);
  return std::string("\x89PNG\r\n\x1a\n") + png_chunk("IHDR", data) + before +
         png_chunk("IDAT", zlib_stored(rows)) + png_chunk("IEND", "");
}

inline std::string jpeg_segment(int marker, const std::string& data) {
  return std::string("\xff") + char(marker) + char((data.size() + 2) >> 8) +
         char((data.size() + 2) & 255) + data;
}

/// EXIF that says nothing but an orientation, as JPEG holds it; a JPEG with it.
inline std::string exif_of(int orientation) {
  return std::string("Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 25) + char(orientation) +
         std::string(6, '\0');
}
inline std::string with_orientation(const std::string& jpeg, int orientation) {
  return jpeg.substr(0, 2) + jpeg_segment(0xe1, exif_of(orientation)) + jpeg.substr(2);
}

/// An 8 × 8 baseline JPEG of `components` middle-grey components: every block is the two bits
/// "no difference, end of block".
inline std::string grey_jpeg(int components) {
  std::string frame = {8, 0, 8, 0, 8, char(components)};
  std::string scan = {char(components)};
  for (int c = 1; c <= components; ++c) {
    frame += {char(c), 0x11, 0};
    scan += {char(c), 0};
  }
  const std::string one_code = std::string(1, 1) + std::string(15, 0) + std::string(1, 0);
  return "\xff\xd8" + jpeg_segment(0xDB, std::string(1, 0) + std::string(64, 1)) +
         jpeg_segment(0xC0, frame) + jpeg_segment(0xC4, std::string(1, 0) + one_code) +
         jpeg_segment(0xC4, std::string(1, 0x10) + one_code) +
         jpeg_segment(0xDA, scan + std::string({0, 63, 0})) +
         (components == 1   ? "\x3f"
          : components == 3 ? "\x03"
                            : std::string(1, 0)) +
         "\xff\xd9";
}

}  // namespace mq::test
