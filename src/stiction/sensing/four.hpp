#pragma once

#include <cstring>

namespace stiction::sensing::detail {

/// Four numbers in one SIMD register, if the processor has such: four samples, boxes or rays are processed at a time.
using V4 = double __attribute__((vector_size(32)));

inline V4 load(const double* p) {
  V4 out;
  std::memcpy(&out, p, sizeof(out));
  return out;
}

inline void store(const V4& x, double* p) { std::memcpy(p, &x, sizeof(x)); }

inline V4 largest(const V4& a, const V4& b) { return a > b ? a : b; }

}  // namespace stiction::sensing::detail
