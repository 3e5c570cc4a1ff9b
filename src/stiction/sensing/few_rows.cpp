#include "stiction/sensing/few_rows.hpp"

#include <cmath>
#include <numbers>

namespace stiction::sensing {
namespace {

constexpr double kMany = 1e4;  // freedom from which on Student's distribution is the normal one

/// P(|t| > x) of Student's distribution, and its slope. With u² = ν/(ν + x²) it is 2 Γ((ν+1)/2)/(√π Γ(ν/2)) u^ν Σ_k c_k u^{2k}/(ν + 2k), c_k = (2k)!/(4^k k!²).
struct Tail {
  double value, slope;
};

Tail calc_tail(double freedom, double x) {
  const double u2 = freedom / (freedom + x * x);
  const double log_scale = std::lgamma(0.5 * (freedom + 1)) - std::lgamma(0.5 * freedom);
  double sum = 0, term = 1;
  for (int k = 0; term > 1e-14 * sum; ++k) {
    sum += term / (freedom + 2 * k);
    term *= u2 * (2 * k + 1) / (2 * k + 2);
  }
  const double scale = 2 * std::exp(log_scale) / std::sqrt(std::numbers::pi);
  return {scale * std::pow(u2, 0.5 * freedom) * sum, -scale / std::sqrt(freedom) * std::pow(u2, 0.5 * (freedom + 1))};
}

}  // namespace

double calc_student_variance(double freedom) {
  if (!(freedom < kMany)) return 1;
  return freedom > 4 ? freedom / (freedom - 2) : 2;
}

double calc_student_bound(double freedom, double deviations) {
  if (!(freedom < kMany)) return deviations;
  const double rare = std::erfc(deviations / std::numbers::sqrt2);
  // Newton's method on ln P over ln x, which is concave and nearly straight in the tail.
  double x = deviations;
  for (int i = 0; i < 50; ++i) {
    const Tail tail = calc_tail(freedom, x);
    const double step = std::log(tail.value / rare) * tail.value / (x * -tail.slope);
    x *= std::exp(step);
    if (std::abs(step) < 1e-12) break;
  }
  return x / std::sqrt(calc_student_variance(freedom));
}

}  // namespace stiction::sensing
