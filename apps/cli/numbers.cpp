#include "numbers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>

#include "stiction/core/invalid_input.hpp"

namespace stiction::app {
namespace {

/// What was given, short enough to be read.
std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  if (text.size() <= kLongest) return fmt::format("'{}'", text);
  return fmt::format("'{}…' ({} characters)", text.substr(0, kLongest / 2), text.size());
}

/// The number that the whole text is; nothing where it is none, or none of this type.
template <class Number>
std::optional<Number> read(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string_view name_of(Bound bound) { return bound == Bound::Positive ? "> 0" : "≥ 0"; }

bool holds(Bound bound, double value) { return std::isfinite(value) && (bound == Bound::Positive ? value > 0 : value >= 0); }

double parse_number(std::string_view option, std::string_view text, Bound bound) {
  const auto value = read<double>(text);
  if (!value || !holds(bound, *value)) core::throw_invalid(option, quote(text), fmt::format("a number {}", name_of(bound)));
  return *value;
}

template <class Integer>
Integer parse_integer(std::string_view option, std::string_view text, Integer low, Integer high) {
  const auto value = read<Integer>(text);
  if (!value || *value < low || *value > high) core::throw_invalid(option, quote(text), fmt::format("an integer from {} to {}", low, high));
  return *value;
}

using Take = std::function<void(const std::string& word)>;

CLI::Option* add(CLI::App& command, const std::string& option, const std::string& meaning, const std::string& type, const Take& take) {
  const auto each = [take](const CLI::results_t& words) {
    for (const std::string& word : words) take(word);
    return true;
  };
  return command.add_option(option, each, meaning)->type_name(type)->expected(1);
}

std::string type_of(Range range) { return fmt::format("INTEGER ({} to {})", range.low, range.high); }
std::string type_of(Bound bound) { return fmt::format("NUMBER ({})", name_of(bound)); }

}  // namespace

CLI::Option* add_number(CLI::App& command, const std::string& option, double& value, const std::string& meaning, Bound bound) {
  return add(command, option, meaning, type_of(bound),
             [option, &value, bound](const std::string& word) { value = parse_number(option, word, bound); })
      ->default_str(fmt::format("{:.4g}", value));
}

CLI::Option* add_number(CLI::App& command, const std::string& option, std::optional<double>& value, const std::string& meaning,
                        Bound bound) {
  return add(command, option, meaning, type_of(bound),
             [option, &value, bound](const std::string& word) { value = parse_number(option, word, bound); });
}

CLI::Option* add_integer(CLI::App& command, const std::string& option, int& value, const std::string& meaning, Range range) {
  return add(command, option, meaning, type_of(range),
             [option, &value, range](const std::string& word) { value = parse_integer(option, word, range.low, range.high); })
      ->default_str(fmt::format("{}", value));
}

CLI::Option* add_integer(CLI::App& command, const std::string& option, std::optional<int>& value, const std::string& meaning, Range range) {
  return add(command, option, meaning, type_of(range),
             [option, &value, range](const std::string& word) { value = parse_integer(option, word, range.low, range.high); });
}

CLI::Option* add_integer(CLI::App& command, const std::string& option, std::optional<std::uint64_t>& value, const std::string& meaning) {
  return add(command, option, meaning, "INTEGER (≥ 0)", [option, &value](const std::string& word) {
    value = parse_integer<std::uint64_t>(option, word, 0, std::numeric_limits<std::uint64_t>::max());
  });
}

CLI::Option* add_numbers(CLI::App& command, const std::string& option, std::vector<double>& values, const std::string& meaning, Bound bound,
                         std::optional<std::size_t> count) {
  const auto take = [option, &values, bound, count](const std::string& word) {
    values.clear();
    for (std::size_t at = 0; at <= word.size();) {
      const std::size_t end = std::min(word.find(',', at), word.size());
      values.push_back(parse_number(option, std::string_view(word).substr(at, end - at), bound));
      at = end + 1;
    }
    if (count && values.size() != *count)
      core::throw_invalid(option, quote(word), fmt::format("{} numbers {} with commas between them", *count, name_of(bound)));
  };
  CLI::Option* const out = add(command, option, meaning, type_of(bound) + ",…", take);
  return values.empty() ? out : out->default_str(fmt::format("{}", fmt::join(values, ",")));
}

std::vector<std::optional<double>> parse_numbers(std::string_view option, const std::string& text) {
  std::vector<std::optional<double>> out;
  const std::string_view separators = " ,\t";
  for (std::size_t at = text.find_first_not_of(separators); at != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
    const std::string_view word = std::string_view(text).substr(at, end - at);
    at = text.find_first_not_of(separators, end);
    if (word == "~") {  // any value
      out.push_back(std::nullopt);
      continue;
    }
    const auto value = read<double>(word);
    if (!value || !std::isfinite(*value)) core::throw_invalid(option, quote(word), "a number that is finite, or ~ for any value");
    out.push_back(value);
  }
  return out;
}

}  // namespace stiction::app
