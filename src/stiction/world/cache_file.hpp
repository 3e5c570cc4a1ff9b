// Files that the program keeps between runs, so that it need not compute the same results again.
#pragma once

#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace stiction::world {

/// Folder of the cache: $STICTION_CACHE, else $XDG_CACHE_HOME/stiction or ~/.cache/stiction. The result is empty, which means no cache, if
/// STICTION_CACHE is set to an empty text, or if it is not set and neither other folder is an absolute path. Reads the environment.
std::filesystem::path default_cache_dir();

/// Writes a file of the cache, and creates its folder. The file is written completely or not at all; a failure is silent. Threads and
/// processes may write the same file at the same time.
void store_in_cache(const std::filesystem::path& file, const std::string& bytes);

/// Composes the bytes of a cache file: title (layout and version, one line), key, SHA-256 of the contents, contents.
std::string seal(std::string_view title, std::string_view key, std::string_view contents);

/// Reads the contents of a cache file; nullopt if the file does not exist, is damaged, or has another title or key.
std::optional<std::string> read_sealed(const std::filesystem::path& file, std::string_view title, std::string_view key);

/// Appends numbers in their binary form.
template <class T>
void append_values(std::string& bytes, const T* values, std::size_t n) {
  bytes.append(reinterpret_cast<const char*>(values), n * sizeof(T));
}

/// Removes n numbers from the front of `bytes`. @returns false, and removes nothing, if there are fewer
template <class T>
bool take_values(std::string_view& bytes, T* into, std::size_t n) {
  if (n > bytes.size() / sizeof(T)) return false;
  std::memcpy(into, bytes.data(), n * sizeof(T));
  bytes.remove_prefix(n * sizeof(T));
  return true;
}

}  // namespace stiction::world
