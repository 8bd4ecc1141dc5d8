#include "mq/io/detail/picture_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel_values.h"
#include "mq/base/words.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

const char* words_for(Depth depth) {
  switch (depth) {
    case Depth::u8: return "8 bits per channel";
    case Depth::u16: return "16 bits per channel";
    case Depth::half: return "16-bit floating point";
    case Depth::f32: break;
  }
  return "32-bit floating point";
}

[[noreturn]] void fail_not_finite(const std::string& name, const Image<float>& pixels,
                                  std::size_t index, const char* remedy) {
  const std::size_t pixel = index / pixels.channels();
  fail_picture(name, fmt::format("pixel (column {}, row {}) holds {} in channel {}; {}",
                                 pixel % pixels.width(), pixel / pixels.width(),
                                 pixels.values()[index], index % pixels.channels(), remedy));
}

}  // namespace

void check_finite(const std::string& name, const Image<float>& pixels, std::size_t begin,
                  std::size_t end, const char* remedy) {
  const auto values = pixels.values().subspan(begin, end - begin);
  const auto finite = [](float value) { return std::isfinite(value); };
  if (parallel_all(std::ssize(values), [&](std::int64_t first, std::int64_t last) {
        return std::all_of(values.begin() + first, values.begin() + last, finite);
      }))
    return;
  fail_not_finite(name, pixels, begin + std::size_t(std::ranges::find_if_not(values, finite) - values.begin()), remedy);
}

void check_writable(const Texture& texture, const std::string& name, const FileFormat& format) {
  const Image<float>& pixels = texture.pixels;
  if (pixels.empty()) throw InvalidInput(fmt::format("{}: the picture has no pixels", name));
  if (pixels.channels() > format.max_channels)
    throw InvalidInput(fmt::format("{}: {}, of which {} holds {}; choose .exr or .tif{}", name,
                                   counted(pixels.channels(), "channel"), format.name,
                                   format.max_channels, pixels.channels() <= 4 ? " or .png" : ""));
  if (format.max_channels == 3 && pixels.channels() == 2)
    throw InvalidInput(
        fmt::format("{}: grey with alpha, which jpeg does not hold; choose .png", name));
  check_finite(name, pixels, 0, pixels.values().size(), "nothing was written");
}

std::vector<std::string> notes_on(const std::string& name, const Texture& texture,
                                  const FileFormat& format, Depth depth, std::int64_t clamped,
                                  bool light) {
  std::vector<std::string> notes;
  const Depth wanted = texture.format.depth;
  const bool loses =
      depth == Depth::u8 ? wanted != depth : depth == Depth::u16 && wanted > Depth::u16;
  if (loses || (wanted == Depth::half && depth == Depth::f32))
    notes.push_back(fmt::format("{}: {} cannot hold {}; written with {}", name, format.name,
                                words_for(wanted), words_for(depth)));
  if (format.name != "openexr" && light && depth <= Depth::u16)
    notes.push_back(fmt::format(
        "{}: holds light, {}; write .exr to keep its range", name,
        format.name == "png" ? "and says so by its gamma of 1, which not all programs heed"
                             : "which its format cannot say, so that it will be shown too dark"));
  if (clamped > 0)
    notes.push_back(fmt::format("{}: {} beyond what {} can hold ({:.2g} % of all), clamped", name,
                                counted(clamped, "value"), words_for(depth),
                                100 * double(clamped) / double(texture.pixels.values().size())));
  if (format.name == "jpeg")
    notes.push_back(
        fmt::format("{}: every pixel is encoded again as JPEG (quality 98); write .png "
                    "to keep untouched texels exactly",
                    name));
  return notes;
}

}  // namespace mq
