#include "stiction/world/mesh_contents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"

namespace stiction::world {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mesh: got {}, expected {}", file.string(), got, expected));
}

/// Checks the size that the header of a binary STL states. A text has no byte 0 at its start.
void require_stl_size(const std::filesystem::path& file, std::string_view bytes) {
  constexpr std::size_t kHeader = 84, kTriangle = 50;  // bytes; the header ends with the number of triangles
  if (bytes.size() < kHeader || bytes.substr(0, kHeader).find('\0') == std::string_view::npos) return;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeader - 4, 4);
  if (const std::size_t size = kHeader + kTriangle * count; size != bytes.size())
    fail(file, fmt::format("a binary STL of {} bytes that states {} triangles", bytes.size(), count),
         fmt::format("{} bytes; the file may be cut off", size));
}

/// Checks the indices of a COLLADA file. Assimp reads a text that is no number again and again, until the memory is full.
void require_dae_indices(const std::filesystem::path& file, std::string_view bytes) {
  constexpr std::string_view kElement = "<p>";
  for (auto at = bytes.find(kElement); at != std::string_view::npos; at = bytes.find(kElement, at + 1)) {
    const std::size_t begin = at + kElement.size(), end = std::min(bytes.find('<', begin), bytes.size());
    const std::size_t wrong = bytes.find_first_not_of("+-0123456789 \t\r\n", begin);
    if (wrong >= end) continue;
    const auto c = static_cast<unsigned char>(bytes[wrong]);
    fail(file,
         fmt::format("{} among the indices of its triangles",
                     std::isprint(c) != 0 ? fmt::format("'{}'", bytes[wrong]) : fmt::format("a byte {:#04x}", c)),
         "whole numbers");
  }
}

}  // namespace

void require_mesh_contents(const std::filesystem::path& file, std::string_view bytes) {
  if (const auto found = find_stand_in(bytes)) fail(file, found->what, fmt::format("a mesh; {}", found->remedy));
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".stl") require_stl_size(file, bytes);
  if (extension == ".dae") require_dae_indices(file, bytes);
}

}  // namespace stiction::world
