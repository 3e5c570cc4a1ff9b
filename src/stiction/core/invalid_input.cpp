#include "stiction/core/invalid_input.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/core/number.hpp"

namespace stiction::core {

void throw_invalid(std::string_view field, std::string_view got, std::string_view expected) {
  throw InvalidInput(fmt::format("{}: got {}, expected {}", field, got, expected));
}

void require_size(std::string_view field, long got, long expected) {
  if (got != expected) throw_invalid(field, fmt::format("{} numbers", got), fmt::format("{}", expected));
}

void require_finite(std::string_view field, double value) {
  if (!std::isfinite(value)) throw_invalid(field, fmt::format("{}", value), "a finite number");
  if (std::abs(value) > kLargestNumber)
    throw_invalid(field, fmt::format("{}", value), fmt::format("a number of at most {}", kLargestNumber));
}

void require_finite(std::string_view field, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i]) <= kLargestNumber)) require_finite(fmt::format("{}[{}]", field, i), values[i]);
  }
}

void require_positive(std::string_view field, double value) {
  if (!(std::isfinite(value) && value > 0)) throw_invalid(field, fmt::format("{}", value), "a finite number > 0");
  require_finite(field, value);
}

void require_nonnegative(std::string_view field, double value) {
  if (!(std::isfinite(value) && value >= 0)) throw_invalid(field, fmt::format("{}", value), "a finite number ≥ 0");
  require_finite(field, value);
}

}  // namespace stiction::core
