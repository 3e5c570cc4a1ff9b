#pragma once

namespace stiction::sensing {

/// Variance of a number whose deviation was estimated from ν others, relative to the estimated variance: ν/(ν − 2) as in Student's
/// distribution, and 2 for ν ≤ 4. @param freedom  ν > 0; infinite: 1
double calc_student_variance(double freedom);

/// Bound, in units of √calc_student_variance(), that such a number exceeds as rarely as a normal number exceeds `deviations`. 4 becomes 4.6
/// with ν = 40 and 5.7 with ν = 9.
/// @param freedom  ν > 0  @param deviations  > 0
/// Tests: tests/sensing/few_rows_test.cpp (tables)
double calc_student_bound(double freedom, double deviations);

}  // namespace stiction::sensing
