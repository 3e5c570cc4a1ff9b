#pragma once

#include <filesystem>

namespace stiction::test {

/// Root of the source tree. A function of a file of its own: tests compile to the same objects wherever the tree lies.
std::filesystem::path source_dir();

/// Where packages of robots lie (`package://example-robot-data/…`).
std::filesystem::path package_dir();

}  // namespace stiction::test
