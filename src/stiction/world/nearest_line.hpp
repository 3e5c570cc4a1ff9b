#pragma once

#include <functional>
#include <utility>

namespace stiction::world {

/// y ≈ slope·x + offset.
struct NearestLine {
  double slope = 0, offset = 0;
  double error = 0;  ///< largest distance in y over the values that were looked at
};

/// The line with the smallest largest distance from y = f(x), over 65 values of x evenly in a range. Of them those count for which y is in
/// its range, where there are two and more. Tests: tests/world/mjcf_couplings_test.cpp
NearestLine nearest_line(const std::function<double(double)>& f, std::pair<double, double> x_range, std::pair<double, double> y_range);

}  // namespace stiction::world
