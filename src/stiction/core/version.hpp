#pragma once

#include <string_view>

namespace stiction::core {

/// Version of the library, as in the file VERSION.
std::string_view version() noexcept;

}  // namespace stiction::core
