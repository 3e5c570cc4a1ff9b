#pragma once

#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

/// Kinds of YAML files that the commands read.
enum class FileKind {
  Task,
  Sensing,
  Control,
  Touch
};

/// Refuses a file of another kind in one sentence, in place of a sentence for each of its keys.
/// @throws core::InvalidInput: `top` has keys that only another kind of file has; the message names the command that reads that file
/// Tests: tests/python/test_command_line.py
void refuse_other_kind(const world::YamlNode& top, FileKind wanted);

}  // namespace stiction::tasks
