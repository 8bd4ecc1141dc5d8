// Any bytes are refused by an error of ours, or are a picture that can be written in the format it was
// read from: with the same size and channels, and value for value where the format loses nothing.

#include <string>

#include "fuzz/document.h"
#include "mq/base/error.h"
#include "mq/io/detail/picture_codec.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

constexpr double most_pixels = 1 << 20;  // more takes time and finds nothing that fewer do not

bool keeps_values(const PixelFormat& format) {
  return format.file_format != "jpeg" && format.depth != Depth::f32;
}

void read_and_write(std::span<const std::byte> bytes) {
  const std::string name = "fuzz.tga";  // the one format without a mark of its own
  const PictureInfo info = picture_codec().info(bytes, name);
  if (double(info.width) * info.height * double(info.channels.size()) > most_pixels) return;
  const Texture read = read_texture_bytes(bytes, name);
  expect(read.pixels.width() == info.width && read.pixels.height() == info.height);
  const EncodedPicture written = texture_bytes(read, read.format.file_format);
  const Texture again = read_texture_bytes(written.bytes, name);
  expect(again.pixels.width() == info.width && again.pixels.height() == info.height);
  if (keeps_values(read.format) && again.pixels.channels() == read.pixels.channels())
    expect(again.pixels == read.pixels);
}

}  // namespace
}  // namespace mq

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  try {
    mq::read_and_write(std::as_bytes(std::span(data, size)));
  } catch (const mq::Error&) {
  }
  return 0;
}
