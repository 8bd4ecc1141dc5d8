#include <cstdlib>

#include "mq/base/error.h"
#include "mq/io/mp4.h"

/// Any bytes are refused or read; what is read is positive.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  try {
    const Mp4Video video = mp4_video(std::as_bytes(std::span(data, size)), "fuzz.mp4");
    if (video.codec.size() != 4 || (video.pictures && *video.pictures < 1) ||
        (video.rate && !(*video.rate > 0)))
      std::abort();
  } catch (const IoError&) {
  }
  return 0;
}
