#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {

/// The mistake of a caller whose path the system refuses: no permission, too long a name, a loop of links.
/// @returns InvalidInput "PATH: got a path that cannot be used (REASON), expected a file or folder that can be read"
InvalidInput to_invalid_input(const std::filesystem::filesystem_error& error);

/// Says why a file cannot be read: there is none, it is a folder or a device, or there is no permission.
std::string describe_unreadable(const std::filesystem::path& file);

/// Reads a file, or what comes through a pipe, to its end. @param expected  for example "a YAML file"
/// @throws InvalidInput: "FILE: file: got REASON, expected EXPECTED"
std::string read_file(const std::filesystem::path& file, std::string_view expected);

}  // namespace stiction::core
