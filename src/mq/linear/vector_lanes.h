#pragma once
/// Short vectors of floats in the compiler's own words: GCC and Clang turn them into whatever the
/// machine has. Included by sources with kernels only.

#include <cstring>

namespace mq {

template <int N>
struct FloatPack {
  typedef float Type __attribute__((vector_size(4 * N)));
  typedef int Mask __attribute__((vector_size(4 * N)));
};
template <>
struct FloatPack<1> {
  using Type = float;
};

/// N floats side by side.
template <int N>
using Floats = typename FloatPack<N>::Type;

template <int N>
inline Floats<N> load(const float* p) {
  Floats<N> v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

template <int N>
inline void store(float* p, Floats<N> v) {
  std::memcpy(p, &v, sizeof v);
}

/// Each of `Texels` values repeated for its `Lanes` lanes.
template <int Texels, int Lanes>
inline Floats<Texels * Lanes> spread(Floats<Texels> v) {
  if constexpr (Lanes == 1) {
    return v;
  } else if constexpr (Texels == 1) {
    return Floats<Lanes>{} + v;
  } else {
    static_assert(Texels == 4 && Lanes == 4);
    return __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
  }
}

}  // namespace mq
