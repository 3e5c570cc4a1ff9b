#pragma once

#include <optional>
#include <string_view>

namespace stiction::core {

/// The number at the start of a text, which is taken off the text: decimal digits with a point, an exponent, a sign; "inf" and "nan" as well.
/// Numbers that are too large are infinite, those that are too small are 0. The same in every locale. nullopt where no number stands there;
/// the text then stays as it is.
/// Tests: tests/core/number_test.cpp
std::optional<double> take_number(std::string_view& text) noexcept;

/// A text that is one number and nothing else.
std::optional<double> parse_number(std::string_view text) noexcept;

}  // namespace stiction::core
