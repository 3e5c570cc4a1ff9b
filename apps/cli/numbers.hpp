#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

// Numbers of the command line. All of them are read here, whatever the locale, and refused in the same words:
// "--timeout: got 'nan', expected a number > 0".

namespace stiction::app {

/// What a finite number has to be.
enum class Bound {
  Positive,     ///< > 0
  NonNegative,  ///< ≥ 0
};

/// Integers from `low` to `high`, both included.
struct Range {
  int low = 0, high = 1;
};

/// Each declares one option. A value that is set already is the default, which the help shows.
/// The parser throws core::InvalidInput by the name of the option where the word is no such number.
CLI::Option* add_number(CLI::App& command, const std::string& option, double& value, const std::string& meaning, Bound bound);
CLI::Option* add_number(CLI::App& command, const std::string& option, std::optional<double>& value, const std::string& meaning,
                        Bound bound);
CLI::Option* add_integer(CLI::App& command, const std::string& option, int& value, const std::string& meaning, Range range);
CLI::Option* add_integer(CLI::App& command, const std::string& option, std::optional<int>& value, const std::string& meaning, Range range);
CLI::Option* add_integer(CLI::App& command, const std::string& option, std::optional<std::uint64_t>& value, const std::string& meaning);
/// Numbers with commas between them. @param count  how many there have to be; nothing: at least one
CLI::Option* add_numbers(CLI::App& command, const std::string& option, std::vector<double>& values, const std::string& meaning, Bound bound,
                         std::optional<std::size_t> count = std::nullopt);

/// Numbers with spaces or commas between them, nothing for ~. @throws core::InvalidInput naming the option
std::vector<std::optional<double>> parse_numbers(std::string_view option, const std::string& text);

}  // namespace stiction::app
