#include <system_error>

#include "stiction/world/urdf.hpp"

namespace stiction::world {

std::filesystem::path find_resource(std::string_view uri, const std::filesystem::path& base_dir,
                                    std::span<const std::filesystem::path> package_dirs) {
  namespace fs = std::filesystem;
  const auto existing = [](const fs::path& path) {
    std::error_code error;  // of names that no file can have
    return fs::is_regular_file(path, error) ? path : fs::path();
  };
  constexpr std::string_view kPackage = "package://";
  constexpr std::string_view kFile = "file://";
  if (uri.starts_with(kFile)) return existing(fs::path(uri.substr(kFile.size())));
  if (!uri.starts_with(kPackage)) return existing(base_dir / fs::path(uri));

  uri.remove_prefix(kPackage.size());
  while (uri.starts_with('/')) uri.remove_prefix(1);  // package:///… is seen in the wild
  const fs::path rest(uri);
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

}  // namespace stiction::world
