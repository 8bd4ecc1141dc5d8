#include <cmath>
#include <cstdlib>

#include "mq/base/error.h"
#include "mq/io/detail/flo.h"

/// Any bytes are refused or read; what is read is finite or unknown, and written again says the
/// same.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  try {
    const Image<float> field = flow_from_bytes(std::as_bytes(std::span(data, size)), "fuzz.flo");
    const Image<float> again = flow_from_bytes(bytes_of_flow(field), "again.flo");
    for (std::size_t i = 0; i < field.values().size(); ++i) {
      const float value = field.values()[i], other = again.values()[i];
      if (std::isinf(value) || (value != other && !(std::isnan(value) && std::isnan(other))))
        std::abort();
    }
  } catch (const IoError&) {
  }
  return 0;
}
