#pragma once
/// A raster of pixels. Row 0 is the top row; pixel (x, y) has `channels` consecutive values.
/// Integer formats are held as their value divided by the largest (0 to 1), EXR as it is.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace mq {

template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, T value = T())
      : width_(width), height_(height), channels_(channels),
        values_(std::size_t(width) * height * channels, value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return values_.empty(); }
  std::int64_t pixel_count() const { return std::int64_t(width_) * height_; }

  T& operator()(int x, int y, int channel = 0) { return values_[offset(x, y) + channel]; }
  const T& operator()(int x, int y, int channel = 0) const { return values_[offset(x, y) + channel]; }

  /// The values of one pixel.
  std::span<T> pixel(int x, int y) { return {values_.data() + offset(x, y), std::size_t(channels_)}; }
  std::span<const T> pixel(int x, int y) const {
    return {values_.data() + offset(x, y), std::size_t(channels_)};
  }

  /// All values: pixel by pixel, row by row from the top.
  std::span<T> values() { return values_; }
  std::span<const T> values() const { return values_; }

  bool operator==(const Image&) const = default;

 private:
  std::size_t offset(int x, int y) const {
    return (std::size_t(y) * width_ + x) * channels_;
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> values_;
};

}  // namespace mq
