#include "mq/model/detail/texel_values.h"

#include <algorithm>

#include "mq/base/parallel.h"

namespace mq {

bool lacks_alpha(int channels, int most) {
  return channels + 1 == most && colour_channels(most) != most;
}

void for_each_block(std::span<const int> unknowns, const std::function<void(std::span<const int>)>& work) {
  constexpr std::int64_t block = 4096;
  const std::int64_t count = (std::ssize(unknowns) + block - 1) / block;
  parallel_for(
      count,
      [&](std::int64_t k) {
        const std::int64_t first = k * block;
        work(unknowns.subspan(std::size_t(first), std::size_t(std::min(block, std::ssize(unknowns) - first))));
      },
      1);
}

Image<float> stored_at(std::span<const int> unknowns, const PlaceOfUnknown& place, const Image<float>& pixels) {
  Image<float> stored(int(unknowns.size()), 1, pixels.channels());
  for (int n = 0; n < stored.width(); ++n) {
    const Texels::Place at = place(unknowns[std::size_t(n)]);
    std::ranges::copy(pixels.pixel(at.x, at.y), stored.pixel(n, 0).begin());
  }
  return stored;
}

void take_values(std::span<const int> unknowns, const PlaceOfUnknown& place, const Texture& texture,
                 const ValueSpace& space, Signal& values) {
  const int channels = texture.pixels.channels();
  for_each_block(unknowns, [&](std::span<const int> block) {
    const Image<float> worked = decoded(stored_at(block, place, texture.pixels), texture, space);
    for (int n = 0; n < worked.width(); ++n)
      for (int c = 0; c < int(values.cols()); ++c)
        values(block[std::size_t(n)], c) = c < channels ? double(worked(n, 0, c)) : 1.0;
  });
}

void put_values(std::span<const int> unknowns, const PlaceOfUnknown& place, const Signal& values,
                const ValueSpace& space, Texture& texture) {
  for_each_block(unknowns, [&](std::span<const int> block) {
    Image<float> worked(int(block.size()), 1, int(values.cols()));
    for (int n = 0; n < worked.width(); ++n)
      for (int c = 0; c < int(values.cols()); ++c) worked(n, 0, c) = float(values(block[std::size_t(n)], c));
    const Image<float> stored = encoded(worked, texture, space);
    for (int n = 0; n < stored.width(); ++n) {
      const Texels::Place at = place(block[std::size_t(n)]);
      const auto to = texture.pixels.pixel(at.x, at.y);
      std::copy_n(stored.pixel(n, 0).begin(), to.size(), to.begin());
    }
  });
}

}  // namespace mq
