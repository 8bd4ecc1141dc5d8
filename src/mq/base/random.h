#pragma once
/// Random numbers by count: value i of a seed is a pure function of both, so parallel loops draw
/// the same numbers whatever their order, and there is no state to share.

#include <cstdint>

namespace mq {

class Random {
 public:
  /// Different streams of one seed have nothing to do with each other.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : key_(mix(mix(seed) + 0x9e3779b97f4a7c15u * (stream + 1))) {}

  /// 64 random bits. Cost: two multiplications per round, two rounds (the finaliser of splitmix64:
  /// Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014).
  std::uint64_t bits(std::uint64_t count) const { return mix(mix(count + key_) ^ key_); }

  /// Uniform in [0, 1), a multiple of 2⁻⁵³.
  double uniform(std::uint64_t count) const { return double(bits(count) >> 11) * 0x1p-53; }

  /// Uniform in [low, high).
  double uniform(std::uint64_t count, double low, double high) const {
    return low + (high - low) * uniform(count);
  }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  std::uint64_t key_;
};

}  // namespace mq
