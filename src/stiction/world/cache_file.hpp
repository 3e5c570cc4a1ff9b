// Files that the program keeps between runs, so that it need not compute again what it computed before.
#pragma once

#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace stiction::world {

/// $STICTION_CACHE, else $XDG_CACHE_HOME/stiction or ~/.cache/stiction. Empty, which stands for nowhere, when STICTION_CACHE is set to
/// nothing, and when it is not set and neither of the others names an absolute folder. Reads the environment.
std::filesystem::path default_cache_dir();

/// Writes a file of the cache, with its folder: whole or not at all, and nothing is said where it cannot be written. Threads and processes
/// may write the same file at the same time.
void store_in_cache(const std::filesystem::path& file, const std::string& bytes);

/// What a file of the cache holds: title (layout and version, one line), key, SHA-256 of the contents, contents.
std::string seal(std::string_view title, std::string_view key, std::string_view contents);

/// The contents; nullopt when the file is not there, is damaged, or has another title or key.
std::optional<std::string> read_sealed(const std::filesystem::path& file, std::string_view title, std::string_view key);

/// Appends numbers as they lie in memory.
template <class T>
void append_values(std::string& bytes, const T* values, std::size_t n) {
  bytes.append(reinterpret_cast<const char*>(values), n * sizeof(T));
}

/// Takes numbers from the front. @returns false, and takes nothing, where there are fewer
template <class T>
bool take_values(std::string_view& bytes, T* into, std::size_t n) {
  if (n > bytes.size() / sizeof(T)) return false;
  std::memcpy(into, bytes.data(), n * sizeof(T));
  bytes.remove_prefix(n * sizeof(T));
  return true;
}

}  // namespace stiction::world
