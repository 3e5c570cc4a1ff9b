#pragma once

namespace stiction::sensing {

/// Variance of a number whose own deviation is known from ν others alone, in units of the variance that these show: that of Student's distribution, ν/(ν − 2), and 2 where
/// ν ≤ 4. @param freedom  ν > 0; infinite: 1
double calc_student_variance(double freedom);

/// How many deviations √calc_student_variance() such a number exceeds no more often than a normal number exceeds `deviations`. 4 become 4.6 with ν = 40, 5.7 with 9.
/// @param freedom  ν > 0  @param deviations  > 0
/// Tests: tests/sensing/few_rows_test.cpp (tables)
double calc_student_bound(double freedom, double deviations);

}  // namespace stiction::sensing
