#pragma once
/// Short vectors of floats in the compiler's own words: GCC and Clang turn them into whatever the
/// instruction set has. Included by kernels only (base/kernel_forms.h).

#include <cstdint>
#include <cstring>
#include <utility>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace mq::MARQUETRY_FORM {

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

/// Floats of a vector register.
#if defined(__AVX512F__)
inline constexpr int register_floats = 16;
#elif defined(__AVX__)
inline constexpr int register_floats = 8;
#else
inline constexpr int register_floats = 4;
#endif

/// Floats that are computed with at once: a register of them, but a row's lanes where these are eight. Values of a
/// matrix are then read as one operand each, where to spread two of them takes more than half a register saves.
template <int lanes>
inline constexpr int pack_floats = lanes == 8 ? lanes : register_floats;

/// How many rows' lanes these are.
template <int lanes>
inline constexpr int pack_rows = pack_floats<lanes> / lanes;

template <int N>
struct LaneCount {
  static constexpr int lanes = N;
};

/// body(LaneCount<lanes>) for the lanes there are: 1, 4 or 8.
template <class Body>
inline void for_lanes(int lanes, const Body& body) {
  if (lanes == 1)
    body(LaneCount<1>{});
  else if (lanes == 4)
    body(LaneCount<4>{});
  else
    body(LaneCount<8>{});
}

/// Sums over a vector have so many partial ones in every form, whatever a register holds, so that
/// their bits do not depend on it.
inline constexpr int partial_sums = 16;

/// Each of `Texels` values repeated for its `Lanes` lanes.
template <int Texels, int Lanes>
inline Floats<Texels * Lanes> spread(Floats<Texels> v) {
  if constexpr (Lanes == 1) {
    return v;
  } else if constexpr (Texels == 1) {
    return Floats<Lanes>{} + v;
  } else if constexpr (Texels == 2) {
    return Floats<8>{v[0], v[0], v[0], v[0], v[1], v[1], v[1], v[1]};
  } else {
    static_assert(Texels == 4 && Lanes == 4);
#ifdef __AVX512F__
    // Said in general words this goes through memory, at twenty times the time.
    const __m512i index = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    return _mm512_maskz_permutexvar_ps(0xffff, index, _mm512_zextps128_ps512(v));
#else
    return __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
#endif
  }
}

/// `lanes` values repeated to fill a register.
template <int lanes>
inline Floats<pack_floats<lanes>> repeat(const float* p) {
  if constexpr (lanes == 1) {
    return Floats<register_floats>{} + *p;
  } else if constexpr (lanes == pack_floats<lanes>) {
    return load<lanes>(p);
  } else {
    static_assert(lanes == 4);
#ifdef __AVX512F__
    return _mm512_maskz_broadcast_f32x4(0xffff, _mm_loadu_ps(p));
#else
    return Floats<2 * lanes>{p[0], p[1], p[2], p[3], p[0], p[1], p[2], p[3]};
#endif
  }
}

/// Values count … count + N − 1 of the 2·N values of a and then b.
template <int count, class Pack>
inline Pack shifted(Pack a, Pack b) {
  constexpr int N = sizeof(Pack) / sizeof(float);
  return [&]<int... i>(std::integer_sequence<int, i...>) {
    return __builtin_shufflevector(a, b, (count + i)...);
  }(std::make_integer_sequence<int, N>{});
}

}  // namespace mq::MARQUETRY_FORM
