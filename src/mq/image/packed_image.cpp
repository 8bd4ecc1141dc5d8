#include "mq/image/packed_image.h"

#include <bit>
#include <limits>
#include <utility>

#include "mq/base/parallel_values.h"

namespace mq {
namespace {

template <class Word>
constexpr float largest = float(std::numeric_limits<Word>::max());

/// The word that stands for a value; of one that none stands for, any.
template <class Word>
Word nearest(float value) {
  return value >= 0 && value <= 1 ? Word(value * largest<Word> + 0.5F) : Word(0);
}

template <class Word>
bool is_exact(float value) {
  return std::bit_cast<std::uint32_t>(float(nearest<Word>(value)) / largest<Word>) == std::bit_cast<std::uint32_t>(value);
}

template <class Word>
bool all_exact(std::span<const float> values) {
  return parallel_all(std::ssize(values), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      if (!is_exact<Word>(values[std::size_t(i)])) return false;
    return true;
  });
}

template <class Word>
OverwrittenVector<Word> words_of(std::span<const float> values) {
  OverwrittenVector<Word> words;
  words.resize(values.size());
  parallel_blocks(std::ssize(values), values_at_once, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) words[std::size_t(i)] = nearest<Word>(values[std::size_t(i)]);
  });
  return words;
}

template <class Word>
void take_words(const OverwrittenVector<Word>& words, std::span<float> values) {
  parallel_blocks(std::ssize(values), values_at_once, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) values[std::size_t(i)] = float(words[std::size_t(i)]) / largest<Word>;
  });
}

}  // namespace

PackedImage::PackedImage(Image<float>&& image)
    : width_(image.width()), height_(image.height()), channels_(image.channels()) {
  Image<float> taken = std::exchange(image, {});
  const std::span<const float> values = taken.values();
  if (all_exact<std::uint8_t>(values))
    values_ = words_of<std::uint8_t>(values);
  else if (all_exact<std::uint16_t>(values))
    values_ = words_of<std::uint16_t>(values);
  else
    values_ = std::move(taken);
}

Image<float> PackedImage::unpacked() && {
  if (auto* whole = std::get_if<Image<float>>(&values_)) return std::move(*whole);
  Image<float> image(width_, height_, channels_);
  if (const auto* bytes = std::get_if<OverwrittenVector<std::uint8_t>>(&values_))
    take_words(*bytes, image.values());
  else
    take_words(std::get<OverwrittenVector<std::uint16_t>>(values_), image.values());
  return image;
}

std::int64_t PackedImage::bytes() const {
  const std::int64_t count = std::int64_t(width_) * height_ * channels_;
  constexpr std::int64_t size[] = {4, 1, 2};
  return count * size[values_.index()];
}

}  // namespace mq
