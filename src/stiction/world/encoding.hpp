#pragma once

#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace stiction::world {

/// Line, from 1, of the first bytes that are no UTF-8: a character that is cut off, longer than it has to be, or that does not exist.
std::optional<int> line_of_foreign_bytes(std::string_view text);

/// A file as it is. @throws core::InvalidInput: it cannot be read
std::string read_bytes(const std::filesystem::path& file);

/// The text of an XML file in UTF-8. Latin-1 (ISO-8859-1) is translated where the file declares it; its declaration then says UTF-8.
/// @param bytes  of the file   @throws core::InvalidInput "file:line: what: …": bytes that are neither
/// Tests: tests/world/bad_input_test.cpp
std::string xml_text(std::string bytes, const std::filesystem::path& file, std::string_view what);

/// Name of the root element of an XML text, which is read no further; empty where there is no element.
/// Tests: tests/world/foreign_xml_test.cpp
std::string find_root(std::istream& text);

}  // namespace stiction::world
