#pragma once

#include <functional>
#include <string_view>

#include "app.hpp"

namespace stiction::app {

/// Runs the body of a program. A mistake in the command line, bad input or a fault becomes one message on stderr and, with --json among the words, one object on
/// stdout. @param program  as its user types it
/// @returns what the body returns, or the exit code of what it throws
int guard(std::string_view program, int argc, char** argv, const std::function<int()>& body);

}  // namespace stiction::app
