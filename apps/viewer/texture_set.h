#pragma once
/// One version of a model's textures as the graphics card shows it, and as it can be read back.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gl.h"
#include "mq/base/parallel.h"
#include "mq/fem/texels.h"
#include "mq/io/model.h"

namespace mq::view {

/// Values are held as the textures' files hold them, 8 bits where these have 8, and uploaded by
/// tiles of which a texel changed. Any thread may change texels while it holds `lock`; the one with
/// the context uploads.
class TextureSet {
 public:
  /// The most texels a side that the graphics card takes; on the thread with the context.
  static int largest_side();

  /// Sizes, channels and depths of these, and their values; on any thread. Throws `Unsupported` where
  /// one has more texels a side than `largest`.
  TextureSet(const std::vector<Texture>& textures, int largest);
  /// The same values, of which nothing was uploaded yet.
  explicit TextureSet(const TextureSet& other);
  TextureSet& operator=(const TextureSet&) = delete;

  int size() const { return int(textures_.size()); }
  int width(int i) const { return textures_[std::size_t(i)]->width; }
  int height(int i) const { return textures_[std::size_t(i)]->height; }
  int channels(int i) const { return textures_[std::size_t(i)]->channels; }
  bool holds_light(int i) const { return textures_[std::size_t(i)]->light; }

  std::unique_lock<std::mutex> lock() const { return std::unique_lock(mutex_); }

  /// All values of a texture, from pixels of the same size and channels.
  void show(int i, const Image<float>& pixels);

  /// value(k, channel) at the places of texels, in parallel; unchanged ones cost no upload. Of
  /// `some` of them, each once, or of all.
  template <class Value>
  void change(const Texels& texels, const Value& value) {
    parallel_for(texels.size(),
                 [&](std::int64_t k) { change_texel(texels.places[std::size_t(k)], k, value); });
    changed_ = true;
  }
  template <class Value>
  void change(const Texels& texels, std::span<const int> some, const Value& value) {
    parallel_for(std::ssize(some), [&](std::int64_t i) {
      const int k = some[std::size_t(i)];
      change_texel(texels.places[std::size_t(k)], k, value);
    });
    changed_ = true;
  }

  /// All values of a texture, of four channels at most, as they would be stored.
  Image<float> image(int i) const;

  /// The values of one texel, as they would be stored; at most four channels.
  std::vector<float> texel(int i, int x, int y) const;

  /// Smallest and largest value of a channel, over all textures. Looks at tiles that changed since the
  /// last time.
  std::array<float, 2> range(int channel) const;

  /// Sends what changed to the graphics card, about so many texels at most. Returns how many.
  std::int64_t upload(std::int64_t most = std::numeric_limits<std::int64_t>::max());
  /// Whether values were put since they were uploaded; any thread may ask.
  bool has_changed() const { return changed_; }
  /// Once something was uploaded.
  const Picture& picture(int i) const { return *textures_[std::size_t(i)]->picture; }

 private:
  static constexpr int tile = 128;  ///< texels a side

  struct Held {
    Held() = default;
    explicit Held(const Held& other);

    int width = 0, height = 0, channels = 0;
    bool light = false;
    bool bytes = true;  ///< 8 bits a value
    std::vector<std::uint8_t> small;
    std::vector<float> large;
    std::vector<std::uint8_t> changed;   ///< per tile, since it was uploaded
    std::vector<std::uint8_t> unranged;  ///< per tile, since its range was asked for
    struct Range {
      std::array<float, 4> low, high;
    };
    std::vector<Range> ranges;  ///< per tile
    std::optional<Picture> picture;

    int columns() const { return (width + tile - 1) / tile; }
    void mark(int x, int y) {
      const std::size_t at = std::size_t(y / tile) * columns() + x / tile;
      // Written where it says something new: threads that write beside each other wait for one another.
      for (auto* const flags : {&changed, &unranged})
        if (std::atomic_ref flag((*flags)[at]); flag.load(std::memory_order_relaxed) == 0)
          flag.store(1, std::memory_order_relaxed);
    }
    Range range_of(int tile_number) const;
    /// Whether the value is another now.
    bool put(std::size_t at, float value) {
      if (!bytes) return std::exchange(large[at], value) != value;
      // As `std::lround`, which is called as a function: half is added to a float without rounding.
      const auto byte = std::uint8_t(int(double(std::clamp(value, 0.F, 1.F) * 255) + 0.5));
      return std::exchange(small[at], byte) != byte;
    }
    float get(std::size_t at) const { return bytes ? float(small[at]) / 255 : large[at]; }
  };

  template <class Value>
  void change_texel(const Texels::Place& at, std::int64_t k, const Value& value) {
    Held& held = *textures_[std::size_t(at.texture)];
    const std::size_t first = (std::size_t(at.y) * held.width + at.x) * 4;
    bool differs = false;
    for (int c = 0; c < std::min(held.channels, 4); ++c)
      differs |= held.put(first + c, float(value(k, c)));
    if (differs) held.mark(at.x, at.y);
  }

  std::vector<std::unique_ptr<Held>> textures_;
  mutable std::mutex mutex_;
  std::atomic<bool> changed_ = false;
};

}  // namespace mq::view
