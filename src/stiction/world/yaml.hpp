#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stiction::world {

/// A value of a YAML file that knows its file, line and path. Every reader below throws core::InvalidInput with the message
/// "FILE:LINE: field.path: got …, expected …" if the value has another type or range. Cheap to copy; the tree is immutable.
class YamlNode {
 public:
  enum class Kind {
    Null,
    Scalar,
    Sequence,
    Map
  };

  YamlNode() = default;
  /// Parses a text.
  /// @param file  file that contains the text. A folder ending in '/' means a text in memory: its paths are relative to the folder, and messages
  ///              name its values by their path only
  /// @throws if the text is malformed or a key repeats
  static YamlNode parse(const std::string& text, const std::filesystem::path& file);
  static YamlNode load(const std::filesystem::path& file);  ///< @throws if the file cannot be read

  Kind kind() const;
  const std::filesystem::path& file() const;  ///< file that contains this value (with `base` it may differ from the loaded file)
  int line() const;                           ///< from 1
  const std::string& path() const;            ///< "scene.robots[0].urdf"; empty at the top
  std::string where() const;                  ///< beginning of messages: "FILE:LINE: path", or "path" for a text in memory

  bool is_map() const { return kind() == Kind::Map; }
  bool is_sequence() const { return kind() == Kind::Sequence; }
  bool is_scalar() const { return kind() == Kind::Scalar; }
  bool is_number() const;  ///< an unquoted scalar that reads as a number, NaN and infinities included

  // Maps
  void require_map(std::span<const std::string_view> allowed) const;  ///< requires a map without other keys
  void require_map(std::initializer_list<std::string_view> allowed) const { require_map(std::span(allowed.begin(), allowed.size())); }
  void require_map() const;
  std::vector<std::pair<std::string, YamlNode>> entries() const;  ///< entries of a map, in file order
  bool has(std::string_view key) const;
  YamlNode at(std::string_view key) const;                   ///< @throws when missing
  std::optional<YamlNode> find(std::string_view key) const;  ///< nullopt when missing
  YamlNode without(std::string_view key) const;              ///< the same map without one key

  // Sequences
  std::vector<YamlNode> items() const;
  std::vector<YamlNode> items(std::size_t n) const;  ///< requires exactly n items

  // Values
  double number() const;       ///< finite
  double positive() const;     ///< finite, > 0
  double nonnegative() const;  ///< finite, ≥ 0
  std::int64_t integer() const;
  int positive_int() const;  ///< ≥ 1
  bool boolean() const;      ///< true or false
  std::string string() const;
  std::string one_of(std::span<const std::string_view> names) const;
  std::string one_of(std::initializer_list<std::string_view> names) const { return one_of(std::span(names.begin(), names.size())); }
  Eigen::VectorXd vector() const;       ///< finite numbers, any length
  Eigen::VectorXd vector(int n) const;  ///< exactly n finite numbers
  Eigen::Vector3d vector3() const;

  // Values of optional keys
  double number_or(std::string_view key, double fallback) const;
  double positive_or(std::string_view key, double fallback) const;
  double nonnegative_or(std::string_view key, double fallback) const;
  std::int64_t integer_or(std::string_view key, std::int64_t fallback) const;
  bool boolean_or(std::string_view key, bool fallback) const;
  std::string string_or(std::string_view key, std::string fallback) const;

  /// Throws "FILE:LINE: path: got GOT, expected EXPECTED". Without `got` the value itself is quoted.
  [[noreturn]] void fail(std::string_view expected) const;
  [[noreturn]] void fail(std::string_view got, std::string_view expected) const;
  /// Throws the message for a name that is not in `known`, with the nearest known name as a hint.
  [[noreturn]] void fail_unknown(std::string_view what, std::string_view name, std::span<const std::string> known) const;

  std::string describe() const;  ///< the value in a few words, for messages

 private:
  struct Data;
  friend YamlNode merge(const YamlNode& base, const YamlNode& over);
  friend struct YamlBuilder;
  explicit YamlNode(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

/// Merges `over` into `base`: maps are merged key by key, any other value is replaced.
YamlNode merge(const YamlNode& base, const YamlNode& over);

/// Loads a file. If its top level has a key `base: other.yaml` (relative to that file), the other file is loaded first, in the same way, and this
/// file is merged into it. The result has no key `base`. @throws core::InvalidInput, also for a circle of bases
YamlNode load_yaml_with_base(const std::filesystem::path& file);

/// The same for a text in memory. @param folder  folder for its relative paths
YamlNode parse_yaml_with_base(const std::string& text, const std::filesystem::path& folder);

/// Lists the known names as "a, b, c"; if one of them is similar to `name`, adds "; did you mean 'b'?".
std::string list_with_hint(std::string_view name, std::span<const std::string> known);

}  // namespace stiction::world
