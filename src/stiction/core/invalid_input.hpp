#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stiction::core {

/// A mistake of the caller. The message names the field, what was given and what was expected.
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @throws InvalidInput "FIELD: got GOT, expected EXPECTED"
[[noreturn]] void throw_invalid(std::string_view field, std::string_view got, std::string_view expected);

void require_size(std::string_view field, long got, long expected);
void require_finite(std::string_view field, double value);
void require_finite(std::string_view field, std::span<const double> values);
void require_positive(std::string_view field, double value);     ///< finite and > 0
void require_nonnegative(std::string_view field, double value);  ///< finite and ≥ 0

}  // namespace stiction::core
