#pragma once
/// Short vectors of doubles in the compiler's own words. Included by kernels only (base/kernel_forms.h).

#include <immintrin.h>

#include <cstring>

namespace mq::MARQUETRY_FORM {

/// Doubles of a vector register.
#if defined(__AVX512F__)
inline constexpr int register_doubles = 8;
#elif defined(__AVX__)
inline constexpr int register_doubles = 4;
#else
inline constexpr int register_doubles = 2;
#endif

typedef double Doubles __attribute__((vector_size(8 * register_doubles)));
/// Per double all ones or 0, as comparisons give it.
typedef long long DoublesMask __attribute__((vector_size(8 * register_doubles)));

inline Doubles load(const double* p) {
  Doubles v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline void store(double* p, Doubles v) { std::memcpy(p, &v, sizeof v); }

inline Doubles root(Doubles v) {
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_pd(0xff, v);
#elif defined(__AVX__)
  return _mm256_sqrt_pd(v);
#else
  return _mm_sqrt_pd(v);
#endif
}

inline bool any(DoublesMask mask) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask((__m512i)mask) != 0;
#elif defined(__AVX__)
  return _mm256_movemask_pd((__m256d)mask) != 0;
#else
  return _mm_movemask_pd((__m128d)mask) != 0;
#endif
}

}  // namespace mq::MARQUETRY_FORM
