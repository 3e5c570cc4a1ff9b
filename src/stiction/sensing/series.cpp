#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::sensing {
namespace {

/// The numbers of a line, separated by commas; nothing where a field is no finite number.
std::optional<std::vector<double>> read_numbers(const std::string& line) {
  std::vector<double> out;
  std::size_t begin = 0;
  while (begin <= line.size()) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::size_t first = line.find_first_not_of(" \t", begin);
    double value = 0;
    if (first == std::string::npos || first >= end) return std::nullopt;
    const auto read = std::from_chars(line.data() + first, line.data() + end, value);
    const std::size_t rest = line.find_first_not_of(" \t\r", static_cast<std::size_t>(read.ptr - line.data()));
    if (read.ec != std::errc() || !std::isfinite(value) || (rest != std::string::npos && rest < end)) return std::nullopt;
    out.push_back(value);
    begin = end + 1;
  }
  return out;
}

}  // namespace

Series load_series(const std::filesystem::path& file, const world::Model& model) {
  std::ifstream stream(file);
  if (!stream) throw core::InvalidInput(fmt::format("{}: series: got a file that cannot be read, expected a CSV file", file.string()));
  const Eigen::Index n = model.n_a();
  const auto fail = [&](int line, const std::string& got, const std::string& expected) {
    throw core::InvalidInput(fmt::format("{}:{}: series: got {}, expected {}", file.string(), line, got, expected));
  };
  std::vector<std::vector<double>> rows;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto numbers = read_numbers(text);
    if (!numbers && line == 1) continue;  // names of the columns
    const std::string expected = fmt::format("{} finite numbers: a time, {} joint positions, {} torques", 1 + 2 * n, n, n);
    if (!numbers) fail(line, fmt::format("'{}'", text.substr(0, 40)), expected);
    if (static_cast<Eigen::Index>(numbers->size()) != 1 + 2 * n) fail(line, fmt::format("{} numbers", numbers->size()), expected);
    if (!rows.empty() && !(numbers->front() > rows.back().front()))
      fail(line, fmt::format("time {} after {}", numbers->front(), rows.back().front()), "times that increase");
    rows.push_back(*numbers);
  }
  if (rows.empty()) throw core::InvalidInput(fmt::format("{}: series: got no line of numbers, expected at least one", file.string()));
  Series out;
  out.q.resize(n, static_cast<Eigen::Index>(rows.size()));
  out.tau.resize(n, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.times.push_back(rows[i].front());
    out.q.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(rows[i].data() + 1, n);
    out.tau.col(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::VectorXd>(rows[i].data() + 1 + n, n);
  }
  return out;
}

}  // namespace stiction::sensing
