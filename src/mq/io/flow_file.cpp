#include "mq/io/flow_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/flo.h"
#include "mq/io/detail/held.h"
#include "mq/io/image_file.h"
#include "mq/io/picture_check.h"

namespace mq {

namespace {

constexpr float unknown_mark = 1e10F;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

constexpr float kitti_zero = 32768, kitti_steps = 64, largest_word = 65535;

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw IoError(name + ": " + what);
}

Image<float> read_kitti(const std::filesystem::path& path) {
  const Texture texture = read_texture(path);
  const Image<float>& stored = texture.pixels;
  if (stored.channels() != 3 || texture.format.depth != Depth::u16)
    fail(path.string(),
         fmt::format("has {} of {} bits; a PNG of optical flow has three of 16 (KITTI)",
                     counted(stored.channels(), "channel"),
                     texture.format.depth == Depth::u16 ? 16 : 8));
  Image<float> field(stored.width(), stored.height(), 2, nan);
  for (std::size_t p = 0; p < std::size_t(stored.pixel_count()); ++p) {
    const float* s = stored.values().data() + 3 * p;
    if (s[2] == 0) continue;
    for (std::size_t c = 0; c < 2; ++c)
      field.values()[2 * p + c] = (std::round(s[c] * largest_word) - kitti_zero) / kitti_steps;
  }
  return field;
}

Image<float> read_exr(const std::filesystem::path& path) {
  const Texture texture = read_texture(path);
  const int channels = texture.pixels.channels();
  if (channels != 2 && channels != 3)
    fail(path.string(), fmt::format("has {}; an EXR of optical flow has two, or three of which the "
                                    "first two count",
                                    counted(channels, "channel")));
  Image<float> field(texture.pixels.width(), texture.pixels.height(), 2);
  for (std::size_t p = 0; p < std::size_t(field.pixel_count()); ++p)
    for (std::size_t c = 0; c < 2; ++c)
      field.values()[2 * p + c] = texture.pixels.values()[std::size_t(channels) * p + c];
  mark_unknown_flow(field);
  return field;
}

std::vector<std::string> write_kitti(const std::filesystem::path& path, const Image<float>& field) {
  Image<float> stored(field.width(), field.height(), 3);
  for (int y = 0; y < field.height(); ++y)
    for (int x = 0; x < field.width(); ++x) {
      const auto v = field.pixel(x, y);
      if (!std::isfinite(v[0]) || !std::isfinite(v[1])) continue;
      for (int c = 0; c < 2; ++c) {
        const float word = std::round(v[c] * kitti_steps + kitti_zero);
        require(
            word >= 0 && word <= largest_word,
            fmt::format("{}: pixel (column {}, row {}) moves by {:g} pixels, and a PNG of optical "
                        "flow holds less than 512; choose .flo",
                        path.string(), x, y, v[c]));
        stored(x, y, c) = word / largest_word;
      }
      stored(x, y, 2) = 1 / largest_word;
    }
  return write_image(path, stored, Depth::u16);
}

std::vector<std::string> write_exr(const std::filesystem::path& path, const Image<float>& field) {
  Texture texture;
  texture.pixels = field;
  for (float& value : texture.pixels.values())
    if (!std::isfinite(value)) value = unknown_mark;
  texture.format = named_channels({"U", "V"}, Depth::f32);
  return write_texture(path, texture);
}

[[noreturn]] void fail_extension(const std::filesystem::path& path) {
  throw InvalidInput(path.string() +
                     ": optical flow comes as .flo, as .png (KITTI) or as .exr (two channels)");
}

}  // namespace

Image<float> read_flow(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".flo") return flow_from_bytes(read_file(path), path.string());
  if (extension == ".png") return read_kitti(path);
  if (extension == ".exr") return read_exr(path);
  fail_extension(path);
}

std::vector<std::string> write_flow(const std::filesystem::path& path, const Image<float>& field) {
  require(field.channels() == 2 && !field.empty(), "optical flow has two values per pixel");
  if (hold_flow(path, field)) return {};
  const std::string extension = lower_extension(path);
  if (extension == ".png") return write_kitti(path, field);
  if (extension == ".exr") return write_exr(path, field);
  if (extension != ".flo") fail_extension(path);
  write_file(path, bytes_of_flow(field));
  return {};
}

}  // namespace mq
