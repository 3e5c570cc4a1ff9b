#include "stiction/core/file_fault.hpp"

#include <fmt/format.h>

namespace stiction::core {

InvalidInput to_invalid_input(const std::filesystem::filesystem_error& error) {
  return InvalidInput(fmt::format("{}: got a path that cannot be used ({}), expected a file or folder that can be read",
                                  error.path1().string(), error.code().message()));
}

}  // namespace stiction::core
