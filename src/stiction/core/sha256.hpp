#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stiction::core {

/// SHA-256 (FIPS 180-4) as 64 lower-case hex digits.
std::string sha256(std::string_view bytes);

/// Of the contents of a file. @throws core::InvalidInput when it cannot be read
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace stiction::core
