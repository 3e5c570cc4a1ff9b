#include "stiction/world/encoding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <utility>

#include "stiction/core/invalid_input.hpp"

namespace stiction::world {

std::optional<int> line_of_foreign_bytes(std::string_view text) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) -> unsigned { return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0; };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
    if (length == 0) return line;
    unsigned code = length == 1 ? first : first & (0xFFU >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      if ((byte(k) & 0xC0U) != 0x80) return line;
      code = code << 6 | (byte(k) & 0x3FU);
    }
    constexpr unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < kLeast[length] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return line;
    if (first == '\n') ++line;
    i += length;
  }
  return std::nullopt;
}

namespace {

constexpr std::string_view kDeclaration = "<?xml";

/// Finds the name of the encoding in an XML declaration, without quotes; empty if there is none.
std::string_view declared_encoding(std::string_view text) {
  if (!text.starts_with(kDeclaration)) return {};
  const std::string_view declaration = text.substr(0, text.find("?>"));
  const auto key = declaration.find("encoding");
  if (key == std::string_view::npos) return {};
  const auto open = declaration.find_first_of("\"'", key);
  if (open == std::string_view::npos) return {};
  const auto close = declaration.find(declaration[open], open + 1);
  return close == std::string_view::npos ? std::string_view{} : declaration.substr(open + 1, close - open - 1);
}

bool is_latin1(std::string_view name) {
  std::string lower(name);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower == "iso-8859-1" || lower == "iso8859-1" || lower == "latin1" || lower == "latin-1";
}

std::string from_latin1(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
    } else {  // its code point has two bytes
      out += static_cast<char>(0xC0U | byte >> 6);
      out += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return out;
}

}  // namespace

std::optional<StandIn> find_stand_in(std::string_view bytes) {
  if (bytes.starts_with("version https://git-lfs.github.com"))
    return StandIn{"a pointer of Git LFS", "`git lfs pull` fetches the file itself"};
  std::string start(bytes.substr(0, 256));
  std::ranges::transform(start, start.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (start.find("<!doctype html") == std::string::npos) return std::nullopt;
  return StandIn{"a web page", "download the file itself"};
}

std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) core::throw_invalid(file.string(), "a file that cannot be read", "a readable file");
  std::string bytes;
  std::array<char, 1u << 16> block;
  while (in.read(block.data(), block.size()), in.gcount() > 0) bytes.append(block.data(), static_cast<std::size_t>(in.gcount()));
  return bytes;
}

std::string xml_text(std::string bytes, const std::filesystem::path& file, std::string_view what) {
  if (const std::string_view name = declared_encoding(bytes); is_latin1(name)) {
    const auto at = static_cast<std::size_t>(name.data() - bytes.data());
    bytes.replace(at, name.size(), "UTF-8");
    return from_latin1(bytes);
  }
  if (const auto line = line_of_foreign_bytes(bytes)) {
    throw core::InvalidInput(
        fmt::format("{}:{}: {}: got bytes that are not UTF-8, expected UTF-8, or ISO-8859-1 with a declaration that says so", file.string(),
                    *line, what));
  }
  return bytes;
}

namespace {

/// Skips the text up to and including `end`.
void skip_behind(std::istream& text, std::string_view end) {
  std::string last;
  for (char c = 0; !last.ends_with(end) && text.get(c);) {
    last += c;
    if (last.size() > end.size()) last.erase(0, 1);
  }
}

/// Skips the rest of a comment or a document type after "<!". Declarations inside a document type have angle brackets too.
void skip_declaration(std::istream& text) {
  char c = 0;
  if (text.get(c) && c == '-') return skip_behind(text, "-->");
  for (int open = c == '>' ? 0 : 1; open > 0 && text.get(c);) open += c == '<' ? 1 : c == '>' ? -1 : 0;
}

}  // namespace

std::string find_root(std::istream& text) {
  for (char c = 0; text.get(c);) {
    if (c != '<') continue;
    const int next = text.peek();
    if (next == '?') {
      skip_behind(text, "?>");
    } else if (next == '!') {
      text.get(c);
      skip_declaration(text);
    } else {
      std::string name;
      while (text.get(c) && std::string_view(" \t\r\n/>").find(c) == std::string_view::npos) name += c;
      return name;
    }
  }
  return "";
}

}  // namespace stiction::world
