#pragma once

#include <string>
#include <vector>

namespace stiction::app {

/// Goes on as a page that Python serves, `python -m MODULE ARGUMENTS`, with the packages and the module that belong to this program: signals and exit codes are
/// then those of the page.
/// @param command  that asked for it, for messages  @throws InstallationFault: something of it is missing
[[noreturn]] void become_page(const std::string& command, const std::string& module, const std::vector<std::string>& arguments);

}  // namespace stiction::app
