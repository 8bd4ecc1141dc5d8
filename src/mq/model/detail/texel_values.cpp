#include "mq/model/detail/texel_values.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

bool lacks_alpha(int channels, int most) {
  return channels + 1 == most && colour_channels(most) != most;
}

namespace {

constexpr std::int64_t unknowns_at_once = 4096;

}  // namespace

void for_each_block(const UnknownRange& unknowns, const std::function<void(std::span<const int>)>& work) {
  parallel_blocks(unknowns.size(), unknowns_at_once, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int> block(std::size_t(end - begin));
    std::iota(block.begin(), block.end(), unknowns.first + int(begin));
    work(block);
  });
}

void for_each_block(std::span<const int> unknowns, const std::function<void(std::span<const int>)>& work) {
  parallel_blocks(std::ssize(unknowns), unknowns_at_once, [&](std::int64_t begin, std::int64_t end) {
    work(unknowns.subspan(std::size_t(begin), std::size_t(end - begin)));
  });
}

Image<float> stored_at(std::span<const int> unknowns, const PlaceOfUnknown& place, const Image<float>& pixels) {
  Image<float> stored(int(unknowns.size()), 1, pixels.channels());
  for (int n = 0; n < stored.width(); ++n) {
    const Texels::Place at = place(unknowns[std::size_t(n)]);
    std::ranges::copy(pixels.pixel(at.x, at.y), stored.pixel(n, 0).begin());
  }
  return stored;
}

namespace {

template <class Unknowns>
void take_any_values(const Unknowns& unknowns, const PlaceOfUnknown& place, const Texture& texture,
                     const ValueSpace& space, Signal& values) {
  const int channels = texture.pixels.channels();
  for_each_block(unknowns, [&](std::span<const int> block) {
    const Image<float> worked = decoded(stored_at(block, place, texture.pixels), texture, space);
    for (int n = 0; n < worked.width(); ++n)
      for (int c = 0; c < int(values.cols()); ++c)
        values(block[std::size_t(n)], c) = c < channels ? double(worked(n, 0, c)) : 1.0;
  });
}

}  // namespace

void take_values(std::span<const int> unknowns, const PlaceOfUnknown& place, const Texture& texture,
                 const ValueSpace& space, Signal& values) {
  take_any_values(unknowns, place, texture, space, values);
}

void take_values(const UnknownRange& unknowns, const PlaceOfUnknown& place, const Texture& texture,
                 const ValueSpace& space, Signal& values) {
  take_any_values(unknowns, place, texture, space, values);
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
