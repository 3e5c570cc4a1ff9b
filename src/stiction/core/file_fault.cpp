#include "stiction/core/file_fault.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace stiction::core {

InvalidInput to_invalid_input(const std::filesystem::filesystem_error& error) {
  const std::string path = error.path1().empty() ? "working folder" : error.path1().string();
  return InvalidInput(
      fmt::format("{}: got a path that cannot be used ({}), expected a file or folder that can be read", path, error.code().message()));
}

std::string describe_unreadable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  switch (status.type()) {
    case std::filesystem::file_type::not_found:
      return "no file of this name";
    case std::filesystem::file_type::directory:
      return "a folder";
    case std::filesystem::file_type::none:
      return error.message();
    case std::filesystem::file_type::regular:
    case std::filesystem::file_type::fifo:
      return "a file without permission to read it";
    default:
      return "a device";
  }
}

std::string read_file(const std::filesystem::path& file, std::string_view expected) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  const bool is_readable = std::filesystem::is_regular_file(status) || std::filesystem::is_fifo(status);
  std::ifstream in;
  if (is_readable) in.open(file, std::ios::binary);
  if (!is_readable || !in) throw_invalid(file.string() + ": file", describe_unreadable(file), expected);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace stiction::core
