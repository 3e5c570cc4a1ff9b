#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "bindings.hpp"

// Scenes, tasks and options as Python values: read by the same reader as files, so that keys, defaults and messages are the same.

namespace stiction::python {

/// A value as YAML in one line: None, bool, int, float, str, os.PathLike, Pose, NumPy scalars and arrays, lists, tuples, dicts with words as
/// keys. @throws core::InvalidInput "PATH: got a value of type …, expected …"  @param path  of the value, for messages
std::string yaml_text(nb::handle value, const std::string& path = "");

/// Folder that paths in a dict are relative to: `base`, or the working folder.
std::filesystem::path folder_of(const std::optional<std::filesystem::path>& base);

}  // namespace stiction::python
