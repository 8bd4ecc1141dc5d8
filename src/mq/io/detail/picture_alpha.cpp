#include "mq/io/detail/picture_alpha.h"

namespace mq {
namespace {

using OIIO::ImageSpec;

/// Alpha is the last of two or four channels where the file says so.
bool says_alpha(const ImageSpec& spec) {
  return (spec.nchannels == 2 || spec.nchannels == 4) && spec.alpha_channel == spec.nchannels - 1;
}

/// A pixel of less alpha shows nothing, and its colours are kept as they lie in the file. Far below
/// what 16-bit floating point can hold.
constexpr float least_alpha = 1e-9F;

}  // namespace

bool is_associated(const ImageSpec& spec, const std::string& file_format) {
  const bool can = file_format == "openexr" || file_format == "tiff" || file_format == "targa";
  return can && says_alpha(spec) && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
}

void divide_by_alpha(std::span<float> values, int channels) {
  for (std::size_t i = 0; i < values.size(); i += channels)
    if (const float alpha = values[i + channels - 1]; alpha > least_alpha)
      for (int c = 0; c < channels - 1; ++c) values[i + c] /= alpha;
}

std::vector<float> multiplied_by_alpha(std::span<const float> values, int channels) {
  std::vector<float> result(values.begin(), values.end());
  for (std::size_t i = 0; i < result.size(); i += channels)
    if (const float alpha = result[i + channels - 1]; alpha > least_alpha)
      for (int c = 0; c < channels - 1; ++c) result[i + c] *= alpha;
  return result;
}

}  // namespace mq
