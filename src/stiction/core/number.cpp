#include "stiction/core/number.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <limits>

namespace stiction::core {
namespace {

/// For an unsigned number outside the range of a double: true if it is too large, false if it is too small.
bool is_too_large(std::string_view number) {
  const std::size_t exponent_at = std::min(number.find_first_of("eE"), number.size());
  const std::string_view digits = number.substr(0, exponent_at);
  const std::size_t first = digits.find_first_of("123456789"), point = std::min(digits.find('.'), digits.size());
  // Number of digits before the point, counted from the first nonzero one. For a number below 1: minus the number of zeros after the point.
  const auto places = static_cast<std::ptrdiff_t>(point) - static_cast<std::ptrdiff_t>(first);
  if (exponent_at == number.size()) return places > 0;
  std::string_view power = number.substr(exponent_at + 1);
  if (power.starts_with('+')) power.remove_prefix(1);
  std::ptrdiff_t exponent = 0;
  if (std::from_chars(power.data(), power.data() + power.size(), exponent).ec == std::errc::result_out_of_range)
    return !power.starts_with('-');
  constexpr std::ptrdiff_t kEnough = std::ptrdiff_t{1} << 32;  // longer than any text
  return places + std::clamp(exponent, -kEnough, kEnough) > 0;
}

}  // namespace

std::optional<double> take_number(std::string_view& text) noexcept {
  const bool negative = text.starts_with('-');
  const std::string_view rest = text.substr(negative || text.starts_with('+') ? 1 : 0);
  if (rest.starts_with('-') || rest.starts_with('+')) return std::nullopt;
  double value = 0;
  const char* const end = rest.data() + rest.size();
  const auto [stop, error] = std::from_chars(rest.data(), end, value);
  if (error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range)
    value = is_too_large(rest.substr(0, static_cast<std::size_t>(stop - rest.data()))) ? std::numeric_limits<double>::infinity() : 0.0;
  text = {stop, static_cast<std::size_t>(end - stop)};
  return negative ? -value : value;
}

std::optional<double> parse_number(std::string_view text) noexcept {
  const auto value = take_number(text);
  return text.empty() ? value : std::nullopt;
}

}  // namespace stiction::core
