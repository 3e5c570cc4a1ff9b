#pragma once

#include <cmath>
#ifdef __AVX__
#include <immintrin.h>
#endif

namespace stiction::cone::detail {

/// Four doubles. A compiler vector type: one AVX register where there is one, two of SSE or NEON elsewhere.
using V4 = double __attribute__((vector_size(32), may_alias));

inline V4 load(const double* p) { return *reinterpret_cast<const V4*>(p); }  // p aligned to 32 bytes
inline void store(double* p, V4 v) { *reinterpret_cast<V4*>(p) = v; }
inline V4 all(double x) { return V4{x, x, x, x}; }
#ifdef __AVX__
inline V4 max(V4 a, V4 b) { return _mm256_max_pd(a, b); }  // b where either is NaN
inline V4 min(V4 a, V4 b) { return _mm256_min_pd(a, b); }
#else
inline V4 max(V4 a, V4 b) { return a > b ? a : b; }
inline V4 min(V4 a, V4 b) { return a < b ? a : b; }
#endif
inline V4 abs(V4 a) { return max(a, -a); }

inline V4 sqrt(V4 a) {
#ifdef __AVX__
  return _mm256_sqrt_pd(a);
#else
  return V4{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
#endif
}

inline double sum(V4 a) { return (a[0] + a[1]) + (a[2] + a[3]); }
inline double largest(V4 a) {
  const double p = a[0] > a[1] ? a[0] : a[1];
  const double q = a[2] > a[3] ? a[2] : a[3];
  return p > q ? p : q;
}

/// (Σa, Σb, Σc, Σd)
inline V4 sums(V4 a, V4 b, V4 c, V4 d) {
  const V4 ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const V4 cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

}  // namespace stiction::cone::detail
