#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace stiction::core {

/// The quantile p of n values: the sorted value whose rank is nearest to p (n − 1).
/// @param values  in any order
/// @param p       in [0, 1]; 0.5 gives the median, the upper one if n is even
/// @returns NaN if there are no values
/// Tests: tests/core/quantile_test.cpp
inline double quantile(std::vector<double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace stiction::core
