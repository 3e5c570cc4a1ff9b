#pragma once

#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace stiction::world {

/// Line (from 1) of the first bytes that are not UTF-8: a truncated, overlong or nonexistent character; nullopt if all bytes are UTF-8.
std::optional<int> line_of_foreign_bytes(std::string_view text);

/// Contents that a download leaves in place of a file.
struct StandIn {
  std::string_view what, remedy;
};
std::optional<StandIn> find_stand_in(std::string_view bytes);

/// Reads a file as bytes. @throws core::InvalidInput: the file cannot be read
std::string read_bytes(const std::filesystem::path& file);

/// Converts the bytes of an XML file to UTF-8. If the file declares Latin-1 (ISO-8859-1), its text is converted and its declaration becomes UTF-8.
/// @param bytes  contents of the file   @throws core::InvalidInput "file:line: what: …": bytes in neither encoding
/// Tests: tests/world/bad_input_test.cpp
std::string xml_text(std::string bytes, const std::filesystem::path& file, std::string_view what);

/// Name of the root element of an XML text; empty if there is no element. The text is read no further than that element.
/// Tests: tests/world/foreign_xml_test.cpp
std::string find_root(std::istream& text);

}  // namespace stiction::world
