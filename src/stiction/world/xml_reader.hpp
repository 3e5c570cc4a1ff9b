#pragma once

#include <fmt/format.h>
#include <tinyxml2.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/number.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

using tinyxml2::XMLElement;

/// Parses the text of a URDF ("urdf"), an SRDF ("srdf") or an MJCF ("mjcf"). @param file  name of the file in messages
/// @returns its root element; nullptr if the text has no element because it is empty or contains only comments
/// @throws core::InvalidInput: malformed XML, or a root element of another format; the message names the format
const XMLElement* parse_xml(tinyxml2::XMLDocument& document, const std::string& text, const std::filesystem::path& file,
                            std::string_view format);

/// Reads elements of an XML file. Errors name the file and the line of the element.
class XmlReader {
 public:
  /// @param file  name of the file in messages
  explicit XmlReader(const std::filesystem::path& file) : file_(file) {}

  [[noreturn]] void fail(const XMLElement& at, std::string_view what, std::string_view got, std::string_view expected) const {
    throw core::InvalidInput(fmt::format("{}:{}: {}: got {}, expected {}", file_.string(), at.GetLineNum(), what, got, expected));
  }

  std::string label(const XMLElement& at) const {
    const char* name = at.Attribute("name");
    return name ? fmt::format("{} '{}'", at.Name(), name) : fmt::format("{}", at.Name());
  }

  std::string required(const XMLElement& at, const char* attribute) const {
    const char* value = at.Attribute(attribute);
    if (value == nullptr || *value == '\0') fail(at, label(at), fmt::format("no attribute {}", attribute), "one");
    return value;
  }

  const XMLElement& child(const XMLElement& at, const char* name) const {
    const XMLElement* found = at.FirstChildElement(name);
    if (found == nullptr) fail(at, label(at), fmt::format("no element {}", name), "one");
    return *found;
  }

  double number(const XMLElement& at, const char* attribute, bool infinite_allowed = false) const {
    const auto values = numbers(at, attribute, required(at, attribute), 1, infinite_allowed);
    return values[0];
  }

  double nonnegative(const XMLElement& at, const char* attribute) const {
    const double value = number(at, attribute);
    if (!(value >= 0)) fail(at, fmt::format("{} {}", at.Name(), attribute), fmt::format("{}", value), "a number > 0, or 0 for no shape");
    return value;
  }

  Eigen::Vector3d vector3(const XMLElement& at, const char* attribute, std::optional<Eigen::Vector3d> fallback = std::nullopt) const {
    if (fallback && at.Attribute(attribute) == nullptr) return *fallback;
    return numbers(at, attribute, required(at, attribute), 3, false);
  }

  Eigen::Vector4d vector4(const XMLElement& at, const char* attribute) const {
    return numbers(at, attribute, required(at, attribute), 4, false);
  }

  /// Reads the pose of <origin>, whose rotation is `rpy` or, since version 1.2 of the format, `quat_xyzw`.
  Pose origin(const XMLElement& at) const;

  /// Reads a text that is a number, with or without blanks around it; nullopt for any other text.
  /// @param infinite_allowed  false: the number must be finite, and at most core::kLargestNumber
  static std::optional<double> try_number(std::string_view text, bool infinite_allowed) {
    const auto values = try_numbers(text, 1, infinite_allowed);
    return values ? std::optional((*values)[0]) : std::nullopt;
  }

 private:
  static std::optional<Eigen::VectorXd> try_numbers(std::string_view text, int n, bool infinite_allowed) {
    const std::string_view between = n > 1 ? " \t\r\n\f\v," : " \t\r\n\f\v";
    const auto skip = [&] { text.remove_prefix(std::min(text.find_first_not_of(between), text.size())); };
    Eigen::VectorXd out(n);
    for (int i = 0; i < n; ++i) {
      skip();
      const auto value = core::take_number(text);
      if (!value || !(std::abs(*value) <= core::kLargestNumber || (infinite_allowed && !std::isnan(*value)))) return std::nullopt;
      out[i] = *value;
    }
    skip();
    return text.empty() ? std::optional(out) : std::nullopt;
  }

  Eigen::VectorXd numbers(const XMLElement& at, const char* attribute, const std::string& text, int n, bool infinite_allowed) const {
    if (const auto values = try_numbers(text, n, infinite_allowed)) return *values;
    fail(at, fmt::format("{} {}", at.Name(), attribute), fmt::format("'{}'", text),
         (n == 1 ? std::string("a finite number") : fmt::format("{} finite numbers", n)) +
             (text.find('$') == std::string::npos ? "" : ", which xacro makes of it"));
  }

  std::filesystem::path file_;
};

}  // namespace stiction::world
