#pragma once

#include <optional>
#include <string_view>

namespace stiction::core {

/// Largest number that an input may state. Squares and cubes of larger ones are infinite, and their differences no number.
inline constexpr double kLargestNumber = 1e50;

/// Reads the number at the start of a text and removes it from the text. The number has decimal digits, and may have a point, an exponent and
/// a sign; "inf" and "nan" are numbers too. A number too large for a double becomes infinite, and one too small becomes 0. The result is the
/// same in every locale.
/// @returns nullopt if the text does not start with a number; the text then stays unchanged
/// Tests: tests/core/number_test.cpp
std::optional<double> take_number(std::string_view& text) noexcept;

/// Reads a text that consists of one number only; nullopt for any other text.
std::optional<double> parse_number(std::string_view text) noexcept;

}  // namespace stiction::core
