#include "stiction/core/find_upwards.hpp"

#include <dlfcn.h>
#include <link.h>

#include <system_error>

namespace stiction::core {

namespace fs = std::filesystem;

namespace {

/// Path of the program or shared library that this function was linked into; empty if the system does not report it.
fs::path own_file() {
  std::error_code error;
  Dl_info info{};
  void* extra = nullptr;
  const bool known = dladdr1(reinterpret_cast<const void*>(&own_file), &info, &extra, RTLD_DL_LINKMAP) != 0;
  const auto* const map = static_cast<const link_map*>(extra);
  // The loader gives the program itself no name (and dladdr repeats argv[0], which may be anything).
  const bool is_library = known && map != nullptr && map->l_name != nullptr && map->l_name[0] != '\0';
  const fs::path file = fs::canonical(is_library ? fs::path(map->l_name) : fs::path("/proc/self/exe"), error);
  return error ? fs::path() : file;
}

}  // namespace

fs::path find_upwards(const fs::path& name, int levels) {
  static const fs::path start = own_file().parent_path();
  if (start.empty() || name.empty()) return {};
  fs::path folder = start;
  for (int level = 0; level <= levels; ++level, folder = folder.parent_path()) {
    std::error_code error;
    if (fs::exists(folder / name, error)) return folder / name;
    if (folder == folder.root_path()) break;
  }
  return {};
}

}  // namespace stiction::core
