#include "stiction/world/cache_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>

#include "stiction/core/sha256.hpp"

namespace stiction::world {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kDigits = 64;                  ///< hex digits of a SHA-256
constexpr std::uintmax_t kLargestFile = 256u << 20;  ///< [bytes]; the program writes no larger file

std::string make_head(std::string_view title, std::string_view key, std::string_view contents) {
  return fmt::format("{}{}\n{}\n", title, key, core::sha256(contents));
}

}  // namespace

fs::path default_cache_dir() {
  if (const char* own = std::getenv("STICTION_CACHE")) return own;
  const auto folder = [](const char* variable, const char* below) {
    const char* value = std::getenv(variable);
    const fs::path path = value != nullptr ? value : "";
    return path.is_absolute() ? path / below : fs::path();  // the XDG specification ignores relative paths
  };
  const fs::path xdg = folder("XDG_CACHE_HOME", "stiction");
  return xdg.empty() ? folder("HOME", ".cache/stiction") : xdg;
}

/// Writes under a temporary name first, so that a reader never sees half a file.
void store_in_cache(const fs::path& file, const std::string& bytes) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return;
  std::string part = file.string() + ".XXXXXX";
  const int descriptor = ::mkstemp(part.data());
  if (descriptor < 0) return;
  ::close(descriptor);
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out << bytes;
  out.close();
  if (out) fs::rename(part, file, error);
  if (!out || error) fs::remove(part, error);
}

std::string seal(std::string_view title, std::string_view key, std::string_view contents) {
  return make_head(title, key, contents).append(contents);
}

std::optional<std::string> read_sealed(const fs::path& file, std::string_view title, std::string_view key) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  const std::uintmax_t size = fs::file_size(file, error);
  const std::size_t head = title.size() + key.size() + 1 + kDigits + 1;
  if (error || size < head || size > kLargestFile) return std::nullopt;
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return std::nullopt;
  std::string contents = bytes.substr(head);
  if (!bytes.starts_with(make_head(title, key, contents))) return std::nullopt;
  return contents;
}

}  // namespace stiction::world
