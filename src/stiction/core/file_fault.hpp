#pragma once

#include <filesystem>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {

/// The mistake of a caller whose path the system refuses: no permission, too long a name, a loop of links.
/// @returns InvalidInput "PATH: got a path that cannot be used (REASON), expected a file or folder that can be read"
InvalidInput to_invalid_input(const std::filesystem::filesystem_error& error);

}  // namespace stiction::core
