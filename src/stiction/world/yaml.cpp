#include "stiction/world/yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "stiction/core/faults.hpp"
#include "stiction/core/file_fault.hpp"
#include "stiction/core/number.hpp"
#include "stiction/world/encoding.hpp"

namespace stiction::world {

using core::InvalidInput;

struct YamlNode::Data {
  Kind kind = Kind::Null;
  std::shared_ptr<const std::filesystem::path> file;
  int line = 1;
  std::string path;
  std::string scalar;
  bool quoted = false;
  std::vector<YamlNode> items;
  std::vector<std::pair<std::string, YamlNode>> entries;
};

namespace {

std::string join_path(const std::string& parent, std::string_view key) {
  return parent.empty() ? std::string(key) : fmt::format("{}.{}", parent, key);
}

/// Beginning of a message about a value. A text in memory has a folder in place of a file, and its messages name no line.
std::string locate(const std::filesystem::path& file, int line, std::string_view path) {
  if (path.empty()) path = "top level";
  return file.has_filename() ? fmt::format("{}:{}: {}", file.string(), line, path) : std::string(path);
}

/// Shortens a long text for messages, without cutting a character in two.
std::string shorten(const std::string& text) {
  constexpr std::size_t kMost = 100;
  if (text.size() <= kMost) return text;
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end) + " …";
}

/// Reads a decimal number, or NaN or infinity in the spellings of YAML and C.
std::optional<double> read_number(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::string_view rest = lower;
  double sign = 1;
  if (!rest.empty() && (rest[0] == '+' || rest[0] == '-')) {
    if (rest[0] == '-') sign = -1;
    rest.remove_prefix(1);
  }
  if (rest == ".nan" || rest == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (rest == ".inf" || rest == "inf" || rest == "infinity") return sign * std::numeric_limits<double>::infinity();
  if (rest.empty() || !(std::isdigit(static_cast<unsigned char>(rest[0])) || rest[0] == '.')) return std::nullopt;
  const auto value = core::parse_number(rest);
  return value ? std::optional(sign * *value) : std::nullopt;
}

/// Largest number of values per character of a text; without aliases there is less than one value per character.
constexpr std::size_t kNodesPerCharacter = 32;

/// Number (from 1) of the first line whose leading blanks contain a tab.
std::optional<int> line_indented_by_tab(const std::string& text) {
  int number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size()), first = text.find_first_not_of(" \t", begin);
    if (first < end && text.substr(begin, first - begin).find('\t') != std::string::npos) return number;
    begin = end + 1;
  }
  return std::nullopt;
}

std::vector<std::string> to_strings(std::span<const std::string_view> names) { return {names.begin(), names.end()}; }

}  // namespace

/// Copies a yaml-cpp tree into ours.
struct YamlBuilder {
  std::shared_ptr<const std::filesystem::path> file;
  std::size_t left;  ///< number of nodes still allowed: nested aliases can expand beyond any memory

  YamlNode build(const YAML::Node& in, const std::string& path, int depth = 0) {
    if (left-- == 0) {
      throw InvalidInput(fmt::format("{}: got aliases that stand for more than {} values a character, expected fewer",
                                     locate(*file, in.Mark().line + 1, path), kNodesPerCharacter));
    }
    if (depth > 64)
      throw InvalidInput(fmt::format("{}: got more than 64 nested levels, expected fewer", locate(*file, in.Mark().line + 1, path)));
    auto data = std::make_shared<YamlNode::Data>();
    data->file = file;
    data->line = std::max(in.Mark().line, 0) + 1;  // an empty file has no mark
    data->path = path;
    switch (in.Type()) {
      case YAML::NodeType::Undefined:
      case YAML::NodeType::Null:
        break;
      case YAML::NodeType::Scalar:
        data->kind = YamlNode::Kind::Scalar;
        data->scalar = in.Scalar();
        data->quoted = in.Tag() == "!";
        break;
      case YAML::NodeType::Sequence: {
        data->kind = YamlNode::Kind::Sequence;
        int i = 0;
        for (const auto& item : in) data->items.push_back(build(item, fmt::format("{}[{}]", path, i++), depth + 1));
        break;
      }
      case YAML::NodeType::Map:
        data->kind = YamlNode::Kind::Map;
        for (const auto& entry : in) {
          const int line = entry.first.Mark().line + 1;
          if (!entry.first.IsScalar()) {
            throw InvalidInput(fmt::format("{}: got a key that is not a word, expected words as keys", locate(*file, line, path)));
          }
          const std::string key = entry.first.Scalar();
          for (const auto& [other, value] : data->entries) {
            if (other == key) {
              throw InvalidInput(fmt::format("{}: got this key twice, expected it once", locate(*file, line, join_path(path, key))));
            }
          }
          YamlNode value = build(entry.second, join_path(path, key), depth + 1);
          if (value.is_map() || value.is_sequence() || value.kind() == YamlNode::Kind::Null) {  // name the line of the key
            auto moved = std::make_shared<YamlNode::Data>(*value.data_);
            moved->line = line;
            value = YamlNode(std::move(moved));
          }
          data->entries.emplace_back(key, std::move(value));
        }
        break;
    }
    return YamlNode(std::move(data));
  }
};

YamlNode YamlNode::parse(const std::string& text, const std::filesystem::path& file) {
  if (const auto line = line_of_foreign_bytes(text)) {
    throw InvalidInput(fmt::format("{}: got bytes that are not UTF-8, expected text in UTF-8", locate(file, *line, "file")));
  }
  if (const auto at = text.find('\0'); at != std::string::npos) {
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
    throw InvalidInput(fmt::format("{}: got a byte 0, expected text", locate(file, static_cast<int>(line), "file")));
  }
  if (const auto found = find_stand_in(text))
    throw InvalidInput(fmt::format("{}: got {}, expected YAML; {}", locate(file, 1, "file"), found->what, found->remedy));
  if (const auto first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf"); first != std::string::npos && text[first] == '<')
    throw InvalidInput(fmt::format(
        "{}: got XML, expected YAML: `stiction import` makes a task of a whole scene in MJCF, URDF or SDF, and a scene names the "
        "file of a robot as `mjcf` or `urdf`",
        locate(file, 1, "file")));
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    for (std::size_t i = 1; i < documents.size(); ++i) {
      if (!documents[i].IsNull())
        throw InvalidInput(fmt::format("{}: got a second document, expected one: '---' ends the first",
                                       locate(file, documents[i].Mark().line + 1, "file")));
    }
    return YamlBuilder{std::make_shared<const std::filesystem::path>(file), kNodesPerCharacter * (text.size() + 1)}.build(
        documents.empty() ? YAML::Node() : documents[0], "");
  } catch (const YAML::Exception& e) {
    if (const auto line = line_indented_by_tab(text))
      throw InvalidInput(
          fmt::format("{}: got a tab in front of a line, expected spaces: YAML indents with them alone", locate(file, *line, "file")));
    throw InvalidInput(fmt::format("{}: got malformed YAML ({}), expected valid YAML", locate(file, e.mark.line + 1, "file"), e.msg));
  }
}

YamlNode YamlNode::load(const std::filesystem::path& file) { return parse(core::read_file(file, "a YAML file"), file); }

YamlNode::Kind YamlNode::kind() const { return data_ ? data_->kind : Kind::Null; }

const std::filesystem::path& YamlNode::file() const {
  static const std::filesystem::path kNone;
  return data_ ? *data_->file : kNone;
}

int YamlNode::line() const { return data_ ? data_->line : 0; }

const std::string& YamlNode::path() const {
  static const std::string kNone;
  return data_ ? data_->path : kNone;
}

std::string YamlNode::where() const { return locate(file(), line(), path()); }

bool YamlNode::is_number() const { return is_scalar() && !data_->quoted && read_number(data_->scalar).has_value(); }

std::string YamlNode::describe() const {
  switch (kind()) {
    case Kind::Null:
      return "nothing";
    case Kind::Scalar:
      return is_number() ? data_->scalar : fmt::format("'{}'", shorten(data_->scalar));
    case Kind::Sequence:
      return fmt::format("a list of {}", data_->items.size());
    case Kind::Map:
      return "a map";
  }
  return "";
}

void YamlNode::fail(std::string_view got, std::string_view expected) const {
  throw InvalidInput(fmt::format("{}: got {}, expected {}", where(), got, expected));
}

void YamlNode::fail(std::string_view expected) const { fail(describe(), expected); }

void YamlNode::fail_unknown(std::string_view what, std::string_view name, std::span<const std::string> known) const {
  fail(fmt::format("unknown {} '{}'", what, name), known.empty() ? "none (there are none)" : "one of " + list_with_hint(name, known));
}

void YamlNode::require_map() const {
  if (!is_map()) fail("a map");
}

void YamlNode::require_map(std::span<const std::string_view> allowed) const {
  require_map();
  core::Faults faults;
  for (const auto& [key, value] : data_->entries) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    faults.add(fmt::format("{}: got an unknown key, expected one of {}", value.where(), list_with_hint(key, to_strings(allowed))));
  }
  faults.raise();
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::entries() const {
  require_map();
  return data_->entries;
}

std::optional<YamlNode> YamlNode::find(std::string_view key) const {
  require_map();
  for (const auto& [name, value] : data_->entries) {
    if (name == key) return value;
  }
  return std::nullopt;
}

bool YamlNode::has(std::string_view key) const { return find(key).has_value(); }

YamlNode YamlNode::at(std::string_view key) const {
  if (auto value = find(key)) return *value;
  throw InvalidInput(fmt::format("{}: got nothing, expected this key", locate(file(), line(), join_path(path(), key))));
}

YamlNode YamlNode::without(std::string_view key) const {
  require_map();
  auto data = std::make_shared<Data>(*data_);
  std::erase_if(data->entries, [&](const auto& entry) { return entry.first == key; });
  return YamlNode(std::move(data));
}

std::vector<YamlNode> YamlNode::items() const {
  if (!is_sequence()) fail("a list");
  return data_->items;
}

std::vector<YamlNode> YamlNode::items(std::size_t n) const {
  if (!is_sequence() || data_->items.size() != n) fail(fmt::format("a list of {}", n));
  return data_->items;
}

double YamlNode::number() const {
  if (!is_number()) fail("a number");
  const double value = *read_number(data_->scalar);
  if (!std::isfinite(value)) fail("a finite number");
  if (std::abs(value) > core::kLargestNumber) fail(fmt::format("a number of at most {}", core::kLargestNumber));
  return value;
}

double YamlNode::positive() const {
  const double value = number();
  if (!(value > 0)) fail("a number > 0");
  return value;
}

int YamlNode::positive_int() const {
  const auto value = integer();
  if (value < 1 || value > std::numeric_limits<int>::max()) fail("an integer ≥ 1");
  return static_cast<int>(value);
}

double YamlNode::nonnegative() const {
  const double value = number();
  if (!(value >= 0)) fail("a number ≥ 0");
  return value;
}

std::int64_t YamlNode::integer() const {
  std::int64_t value = 0;
  if (!is_scalar() || data_->quoted) fail("an integer");
  const char* end = data_->scalar.data() + data_->scalar.size();
  const auto [stop, error] = std::from_chars(data_->scalar.data(), end, value);
  if (error != std::errc() || stop != end) fail("an integer");
  return value;
}

bool YamlNode::boolean() const {
  const auto is_one_of = [&](std::initializer_list<std::string_view> spellings) {
    return is_scalar() && !data_->quoted && std::find(spellings.begin(), spellings.end(), data_->scalar) != spellings.end();
  };
  if (is_one_of({"true", "True", "TRUE"})) return true;  // the core schema of YAML 1.2
  if (is_one_of({"false", "False", "FALSE"})) return false;
  fail("true or false");
}

std::string YamlNode::string() const {
  if (!is_scalar() || data_->scalar.empty()) fail("a word");
  return data_->scalar;
}

std::string YamlNode::one_of(std::span<const std::string_view> names) const {
  const std::string value = string();
  if (std::find(names.begin(), names.end(), value) == names.end()) {
    fail(fmt::format("one of {}", list_with_hint(value, to_strings(names))));
  }
  return value;
}

Eigen::VectorXd YamlNode::vector() const {
  const auto values = items();
  Eigen::VectorXd out(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) out[static_cast<Eigen::Index>(i)] = values[i].number();
  return out;
}

Eigen::VectorXd YamlNode::vector(int n) const {
  if (!is_sequence() || static_cast<int>(data_->items.size()) != n) fail(fmt::format("a list of {} numbers", n));
  return vector();
}

Eigen::Vector3d YamlNode::vector3() const { return vector(3); }

double YamlNode::number_or(std::string_view key, double fallback) const {
  const auto value = find(key);
  return value ? value->number() : fallback;
}

double YamlNode::positive_or(std::string_view key, double fallback) const {
  const auto value = find(key);
  return value ? value->positive() : fallback;
}

double YamlNode::nonnegative_or(std::string_view key, double fallback) const {
  const auto value = find(key);
  return value ? value->nonnegative() : fallback;
}

std::int64_t YamlNode::integer_or(std::string_view key, std::int64_t fallback) const {
  const auto value = find(key);
  return value ? value->integer() : fallback;
}

bool YamlNode::boolean_or(std::string_view key, bool fallback) const {
  const auto value = find(key);
  return value ? value->boolean() : fallback;
}

std::string YamlNode::string_or(std::string_view key, std::string fallback) const {
  const auto value = find(key);
  return value ? value->string() : std::move(fallback);
}

YamlNode merge(const YamlNode& base, const YamlNode& over) {
  if (!base.is_map() || !over.is_map()) return over;
  auto data = std::make_shared<YamlNode::Data>(*over.data_);
  data->entries = base.data_->entries;
  for (const auto& [mine, other] : {std::pair("rpy", "quaternion_wxyz"), std::pair("quaternion_wxyz", "rpy")}) {
    if (over.has(mine))
      std::erase_if(data->entries, [&](const auto& entry) { return entry.first == other; });  // two spellings of a rotation
  }
  for (const auto& [key, value] : over.data_->entries) {
    const auto found = std::find_if(data->entries.begin(), data->entries.end(), [&](const auto& entry) { return entry.first == key; });
    if (found == data->entries.end()) {
      data->entries.emplace_back(key, value);
    } else {
      found->second = merge(found->second, value);
    }
  }
  return YamlNode(std::move(data));
}

}  // namespace stiction::world
