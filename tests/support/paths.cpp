#include "support/paths.hpp"

namespace stiction::test {

std::filesystem::path source_dir() { return STICTION_SOURCE_DIR; }

std::filesystem::path package_dir() { return STICTION_TEST_PACKAGE_DIR; }

}  // namespace stiction::test
