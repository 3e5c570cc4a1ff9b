#include "stiction/world/srdf.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"

namespace stiction::world {

std::vector<std::pair<std::string, std::string>> read_srdf(const std::filesystem::path& file) {
  const std::string text = xml_text(read_bytes(file), file, "srdf");
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw core::InvalidInput(
        fmt::format("{}:{}: srdf: got malformed XML ({}), expected an SRDF", file.string(), document.ErrorLineNum(), document.ErrorName()));
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const auto* e = document.RootElement()->FirstChildElement("disable_collisions"); e != nullptr;
       e = e->NextSiblingElement("disable_collisions")) {
    const char *a = e->Attribute("link1"), *b = e->Attribute("link2");
    if (a == nullptr || b == nullptr)
      throw core::InvalidInput(fmt::format("{}:{}: disable_collisions: got {}, expected link1 and link2", file.string(), e->GetLineNum(),
                                           a == nullptr ? "no link1" : "no link2"));
    pairs.emplace_back(a, b);
  }
  return pairs;
}

}  // namespace stiction::world
