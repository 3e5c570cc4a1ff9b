#include "stiction/core/file_fault.hpp"

#include <fmt/format.h>

#include <string>

namespace stiction::core {

InvalidInput to_invalid_input(const std::filesystem::filesystem_error& error) {
  const std::string path = error.path1().empty() ? "working folder" : error.path1().string();
  return InvalidInput(
      fmt::format("{}: got a path that cannot be used ({}), expected a file or folder that can be read", path, error.code().message()));
}

}  // namespace stiction::core
