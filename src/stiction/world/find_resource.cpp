#include <charconv>
#include <string>
#include <system_error>
#include <vector>

#include "stiction/world/urdf.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

fs::path existing(const fs::path& path) {
  std::error_code error;  // set for names that no file can have
  return fs::is_regular_file(path, error) ? path : fs::path();
}

/// Decodes each %XX of a text into its byte; returns the text unchanged if one of them is invalid.
std::string decode_percent(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const std::string_view digits = text.substr(i + 1, 2);
    unsigned byte = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
    if (error != std::errc() || digits.size() != 2 || end != digits.data() + 2 || byte == 0) return std::string(text);
    out += static_cast<char>(byte);
    i += 2;
  }
  return out;
}

/// Possible readings of a path: as it is written, with %XX decoded, and with '\' replaced by '/'.
std::vector<fs::path> readings_of(std::string_view text) {
  std::vector<fs::path> out{fs::path(text)};
  const auto add = [&](const std::string& other) {
    if (fs::path(other) != out.back()) out.emplace_back(other);
  };
  const std::string decoded = decode_percent(text);
  add(decoded);
  std::string slashes = decoded;
  for (char& c : slashes) c = c == '\\' ? '/' : c;
  add(slashes);
  return out;
}

fs::path find_in_packages(const fs::path& rest, const fs::path& base_dir, std::span<const fs::path> package_dirs) {
  if (rest.empty()) return {};
  const fs::path package = *rest.begin();
  const fs::path inside = rest.lexically_relative(package);
  const auto look_in = [&](const fs::path& dir) {
    if (auto found = existing(dir / rest); !found.empty()) return found;
    const fs::path name = dir.filename().empty() ? dir.parent_path().filename() : dir.filename();
    return name == package ? existing(dir / inside) : fs::path();
  };
  for (const auto& dir : package_dirs) {
    if (auto found = look_in(dir); !found.empty()) return found;
  }
  const fs::path start = fs::absolute(base_dir.empty() ? "." : base_dir).lexically_normal();
  for (fs::path dir = start; !dir.empty(); dir = dir.parent_path()) {
    if (auto found = look_in(dir); !found.empty()) return found;
    if (dir == dir.parent_path()) break;
  }
  return {};
}

/// Removes a scheme from a URI. @returns whether the URI had it
bool take(std::string_view scheme, std::string_view& uri) {
  if (!uri.starts_with(scheme)) return false;
  uri.remove_prefix(scheme.size());
  return true;
}

}  // namespace

fs::path find_resource(std::string_view uri, const fs::path& base_dir, std::span<const fs::path> package_dirs) {
  const bool in_package = take("package://", uri) || take("model://", uri);
  if (in_package) {
    while (uri.starts_with('/')) uri.remove_prefix(1);  // package:///… is seen in the wild
  } else if (take("file://", uri)) {
    if (constexpr std::string_view kHere = "localhost/"; uri.starts_with(kHere)) uri.remove_prefix(kHere.size() - 1);
  } else {
    (void)take("file:", uri);
  }
  for (const fs::path& path : readings_of(uri)) {
    if (auto found = in_package ? find_in_packages(path, base_dir, package_dirs) : existing(base_dir / path); !found.empty()) return found;
  }
  return {};
}

}  // namespace stiction::world
