#pragma once

#include <functional>
#include <utility>

namespace stiction::world {

/// A line y ≈ slope·x + offset.
struct NearestLine {
  double slope = 0, offset = 0;
  double error = 0;  ///< largest distance in y over the sampled values
};

/// Finds the line with the smallest maximum distance from y = f(x), sampled at 65 even values of x in a range. If at least two samples have y
/// within its range, only such samples count. Tests: tests/world/mjcf_couplings_test.cpp
NearestLine nearest_line(const std::function<double(double)>& f, std::pair<double, double> x_range, std::pair<double, double> y_range);

}  // namespace stiction::world
