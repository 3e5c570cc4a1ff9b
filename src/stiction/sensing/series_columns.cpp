#include "stiction/sensing/series_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {
namespace {

using Strings = std::vector<std::string>;

constexpr std::string_view kPathSeparators = "/.: ";
constexpr std::string_view kSeparators = "/.: _-";

constexpr std::string_view kLibfranka = "tau_ext_hat_filtered";

/// A quantity of a joint that a column may hold.
struct Quantity {
  std::string_view what;                     ///< in messages
  std::string_view symbol;                   ///< stands before a number, or before the name of a joint
  std::vector<std::string_view> words;       ///< that mean the same
  std::vector<std::string_view> last_words;  ///< used if no column has one of `words`
};

const Quantity& position() {
  static const Quantity out{"position", "q", {"q", "position", "pos", "actual_q"}, {}};
  return out;
}

/// Efforts of ROS and motor torques are total torques. They are used if no other column has external torques.
const Quantity& torque() {
  static const Quantity out{
      "torque", "tau", {"tau", kLibfranka, "tau_ext", "external_torque"}, {"effort", "tau_j", "torque", "actual_current_as_torque"}};
  return out;
}

constexpr std::string_view kTimeNames[] = {"t", "t_s", "time", "time_s", "__time", "timestamp", "stamp", "seconds", "sec", "elapsed"};
constexpr std::string_view kUnits[] = {"s", "rad", "m", "n", "nm", "n m", "n*m", "n·m"};

std::string to_lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// Without an SI unit in brackets at its end. Other units stay, so that degrees are not taken for radians.
std::string_view without_unit(std::string_view name) {
  const std::size_t open = name.find_last_of("[(");
  if (open == std::string_view::npos || open == 0 || name.empty() || name.back() != (name[open] == '[' ? ']' : ')')) return name;
  const std::string unit = to_lower(name.substr(open + 1, name.size() - open - 2));
  if (std::find(std::begin(kUnits), std::end(kUnits), unit) == std::end(kUnits)) return name;
  name = name.substr(0, open);
  while (!name.empty() && (name.back() == ' ' || name.back() == '_')) name.remove_suffix(1);
  return name;
}

/// Name of a column of time without its unit, and the seconds of this unit.
std::pair<std::string, double> split_time_unit(std::string_view given) {
  constexpr std::pair<std::string_view, double> kTimeUnits[] = {{"ms", 1e-3},      {"msec", 1e-3}, {"us", 1e-6},
                                                                {"\u00b5s", 1e-6}, {"ns", 1e-9},   {"nsec", 1e-9}};
  std::string name = to_lower(without_unit(given));
  for (const auto& [unit, seconds] : kTimeUnits) {
    for (const auto& [open, close] : {std::pair("[", "]"), std::pair("(", ")"), std::pair("_", "")}) {
      const std::string end = fmt::format("{}{}{}", open, unit, close);
      if (name.size() <= end.size() || !name.ends_with(end)) continue;
      name.resize(name.size() - end.size());
      while (!name.empty() && (name.back() == ' ' || name.back() == '_')) name.pop_back();
      return {name, seconds};
    }
  }
  return {name, 1.0};
}

bool is_at_boundary(std::string_view name, std::size_t at) {
  return at == 0 || kPathSeparators.find(name[at - 1]) != std::string_view::npos;
}

/// word SEPARATOR joint or joint SEPARATOR word, at the end of a path.
bool says(std::string_view name, std::string_view word, std::string_view joint) {
  const std::size_t length = word.size() + 1 + joint.size();
  if (name.size() < length || !is_at_boundary(name, name.size() - length)) return false;
  const std::string_view end = name.substr(name.size() - length);
  const auto is_pair = [&](std::size_t first) { return kSeparators.find(end[first]) != std::string_view::npos; };
  const bool joint_last = is_pair(word.size()) && end.ends_with(joint) && to_lower(end.substr(0, word.size())) == word;
  const bool word_last = is_pair(joint.size()) && end.starts_with(joint) && to_lower(end.substr(joint.size() + 1)) == word;
  return joint_last || word_last;
}

/// A part of the path of a name.
bool has_part(std::string_view name, std::string_view part) {
  for (std::size_t at = name.find(part); at != std::string_view::npos; at = name.find(part, at + 1)) {
    const std::size_t end = at + part.size();
    if (is_at_boundary(name, at) && (end == name.size() || kPathSeparators.find(name[end]) != std::string_view::npos)) return true;
  }
  return false;
}

struct Joint {
  std::string full, robot, name;  ///< full: robot/name
  bool is_unique = true;          ///< no other robot has a joint of this name
};

/// All joints, and whether each is measured.
std::vector<Joint> all_joints_of(const world::Model& model) {
  std::vector<Joint> out;
  for (const world::Dof& dof : model.dofs().last(static_cast<std::size_t>(model.n_a()))) {
    const std::size_t slash = dof.name.find('/');
    out.push_back({dof.name, dof.name.substr(0, slash), dof.name.substr(slash + 1)});
  }
  for (Joint& joint : out)
    joint.is_unique = std::count_if(out.begin(), out.end(), [&](const Joint& other) { return other.name == joint.name; }) == 1;
  return out;
}

std::vector<Joint> joints_of(const world::Model& model, const std::vector<int>& unmeasured) {
  const std::vector<Joint> all = all_joints_of(model);
  std::vector<Joint> out;
  for (const int j : joints_but(model.n_a(), unmeasured)) out.push_back(all[static_cast<std::size_t>(j)]);
  return out;
}

bool says_joint(std::string_view name, std::string_view word, const Joint& joint) {
  if (says(name, word, joint.full)) return true;
  return says(name, word, joint.name) && (joint.is_unique || has_part(name, joint.robot));
}

/// Columns of a table as they are looked up.
class Table {
 public:
  Table(const Strings& names, const world::Model& model, const std::string& where, const std::vector<int>& unmeasured)
      : names_(names), joints_(joints_of(model, unmeasured)), where_(where) {}

  /// Column of the time, and the seconds of its unit.
  std::pair<std::size_t, double> find_time() {
    std::vector<std::size_t> found;
    double seconds = 1;
    const bool is_libfranka =
        std::any_of(names_.begin(), names_.end(), [](const std::string& name) { return name.find(kLibfranka) != std::string::npos; });
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto [name, of_unit] = split_time_unit(names_[i]);
      const bool is_duration = name == "duration" && (is_libfranka || of_unit != 1);
      if (!is_duration && std::find(std::begin(kTimeNames), std::end(kTimeNames), name) == std::end(kTimeNames)) continue;
      found.push_back(i);
      seconds = is_duration && of_unit == 1 ? 1e-3 : of_unit;  // franka::logToCSV writes milliseconds
    }
    return {take(found, "the time", "a column named t, time or __time [s], or time_ms, time_us or time_ns"), seconds};
  }

  std::vector<std::size_t> find(const Quantity& quantity) {
    std::vector<std::vector<std::size_t>> found;
    for (const Joint& joint : joints_) found.push_back(find_joint(quantity, joint));
    const bool has_none = std::all_of(found.begin(), found.end(), [](const auto& columns) { return columns.empty(); });
    auto numbered = has_none ? find_numbers(quantity.words) : std::nullopt;
    if (has_none && !numbered && (numbered = find_numbers(quantity.last_words))) has_efforts_ = true;
    if (numbered) {
      for (const std::size_t column : *numbered) taken_.push_back(column);
      return *numbered;
    }
    std::vector<std::size_t> out;
    for (std::size_t j = 0; j < joints_.size(); ++j)
      out.push_back(
          take(found[j], fmt::format("the {} of the joint '{}'", quantity.what, joints_[j].full),
               fmt::format(
                   "one column for each joint that is measured, such as '{}_{}', in any order, or a table without a line of names; a joint "
                   "without a torque sensor is named in sensing.unmeasured",
                   quantity.symbol, joints_[j].is_unique ? joints_[j].name : joints_[j].full)));
    return out;
  }

  /// Torques come from columns of efforts.
  bool has_efforts() const { return has_efforts_; }

  Strings find_unread() const {
    Strings out;
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (!names_[i].empty() && std::find(taken_.begin(), taken_.end(), i) == taken_.end()) out.push_back(fmt::format("'{}'", names_[i]));
    return out;
  }

 private:
  std::vector<std::size_t> find_joint(const Quantity& quantity, const Joint& joint) {
    const auto find_words = [&](std::span<const std::string_view> words) {
      std::vector<std::size_t> out;
      for (std::size_t i = 0; i < names_.size(); ++i) {
        const std::string_view name = without_unit(names_[i]);
        if (std::any_of(words.begin(), words.end(), [&](std::string_view word) { return says_joint(name, word, joint); })) out.push_back(i);
      }
      return out;
    };
    auto found = find_words(quantity.words);
    if (!found.empty()) return found;
    found = find_words(quantity.last_words);
    has_efforts_ |= !found.empty();
    return found;
  }

  /// q0 … or q1 …, also as q_1, q.1 and q[1].
  std::optional<std::vector<std::size_t>> find_numbers(std::span<const std::string_view> words) const {
    const std::size_t n = joints_.size();
    std::vector<std::optional<std::size_t>> of_number(n + 1);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto number = read_number(without_unit(names_[i]), words);
      if (!number) continue;
      if (*number <= n && of_number[*number] && names_[*of_number[*number]] == names_[i])
        throw core::InvalidInput(fmt::format("{}: got the column '{}' more than once, expected every name once", where_, names_[i]));
      if (*number > n || of_number[*number]) return std::nullopt;
      of_number[*number] = i;
    }
    if (of_number.front().has_value() == of_number.back().has_value()) return std::nullopt;
    std::vector<std::size_t> out;
    for (std::size_t j = 0; j < n; ++j) {
      const auto& column = of_number[j + (of_number.front() ? 0 : 1)];
      if (!column) return std::nullopt;
      out.push_back(*column);
    }
    return out;
  }

  static std::optional<std::size_t> read_number(std::string_view name, std::span<const std::string_view> words) {
    for (const std::string_view word : words) {
      if (word == "position" || word == "pos" || word == "effort" || word == "torque")
        continue;  // arrays of messages have an order of their own
      if (name.size() <= word.size() || to_lower(name.substr(0, word.size())) != word) continue;
      std::string_view rest = name.substr(word.size());
      if (rest.front() == '[' && rest.back() == ']')
        rest = rest.substr(1, rest.size() - 2);
      else if (rest.front() == '_' || rest.front() == '.')
        rest.remove_prefix(1);
      std::size_t out = 0;
      const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), out);
      if (!rest.empty() && read.ec == std::errc() && read.ptr == rest.data() + rest.size()) return out;
    }
    return std::nullopt;
  }

  std::size_t take(const std::vector<std::size_t>& found, const std::string& what, const std::string& expected) {
    if (found.size() == 1 && std::find(taken_.begin(), taken_.end(), found[0]) == taken_.end()) {
      taken_.push_back(found[0]);
      return found[0];
    }
    Strings names;
    for (const std::size_t i : found) names.push_back(fmt::format("'{}'", names_[i]));
    const std::string got = found.empty()       ? fmt::format("no column for {} among '{}'", what, fmt::join(names_, "', '"))
                            : found.size() == 1 ? fmt::format("the column {} for {} and for something else", names[0], what)
                                                : fmt::format("the columns {} for {}", fmt::join(names, " and "), what);
    throw core::InvalidInput(fmt::format("{}: got {}, expected {}", where_, got, expected));
  }

  const Strings& names_;
  std::vector<Joint> joints_;
  const std::string& where_;
  std::vector<std::size_t> taken_;
  bool has_efforts_ = false;
};

}  // namespace

std::vector<int> joints_but(int n_a, const std::vector<int>& unmeasured) {
  std::vector<int> out;
  for (int j = 0; j < n_a; ++j)
    if (std::find(unmeasured.begin(), unmeasured.end(), j) == unmeasured.end()) out.push_back(j);
  return out;
}

SeriesColumns make_ordered_columns(int n_a, const std::vector<int>& unmeasured) {
  SeriesColumns out;
  out.joints = joints_but(n_a, unmeasured);
  out.q.resize(out.joints.size());
  out.tau.resize(out.joints.size());
  std::iota(out.q.begin(), out.q.end(), std::size_t{1});
  std::iota(out.tau.begin(), out.tau.end(), 1 + out.q.size());
  return out;
}

SeriesColumns find_columns(const Strings& names, const world::Model& model, const std::string& where, const std::vector<int>& unmeasured) {
  Table table(names, model, where, unmeasured);
  SeriesColumns out;
  out.joints = joints_but(model.n_a(), unmeasured);
  std::tie(out.time, out.seconds) = table.find_time();
  out.q = table.find(position());
  out.tau = table.find(torque());
  if (out.seconds != 1)
    out.notes.push_back(fmt::format("{}: the times in '{}' are taken for {}", where, names[out.time],
                                    out.seconds == 1e-3   ? "milliseconds"
                                    : out.seconds == 1e-6 ? "microseconds"
                                                          : "nanoseconds"));
  if (const Strings unread = table.find_unread(); !unread.empty())
    out.notes.push_back(fmt::format("{}: columns that are not read: {}", where, fmt::join(unread, ", ")));
  if (table.has_efforts())
    out.notes.push_back(fmt::format(
        "{}: efforts are taken for the external torques; the torques of gravity and of friction have to be taken off them first", where));
  const bool is_libfranka =
      std::any_of(out.tau.begin(), out.tau.end(), [&](std::size_t column) { return names[column].find(kLibfranka) != std::string::npos; });
  if (is_libfranka)
    out.notes.push_back(
        fmt::format("{}: '{}' is what the robot does to its surroundings, so it needs sensing.sign: -1", where, kLibfranka));
  return out;
}

std::vector<std::size_t> find_joints(const Strings& names, const world::Model& model, const std::string& where,
                                     const std::vector<int>& unmeasured) {
  std::vector<std::size_t> out;
  for (const Joint& joint : joints_of(model, unmeasured)) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == joint.full || (joint.is_unique && names[i] == joint.name)) found.push_back(i);
    if (found.size() != 1)
      throw core::InvalidInput(fmt::format("{}: got joints '{}' with {} '{}', expected every joint of the robots once", where,
                                           fmt::join(names, "', '"), found.empty() ? "no" : "more than one", joint.full));
    out.push_back(found[0]);
  }
  return out;
}

}  // namespace stiction::sensing
