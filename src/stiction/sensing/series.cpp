#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/sensing/npz.hpp"
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

void mark_gaps(Series& series) {
  constexpr double kUsualSteps = 5;
  std::vector<double> steps;
  for (std::size_t i = 1; i < series.times.size(); ++i) steps.push_back(series.times[i] - series.times[i - 1]);
  if (steps.empty()) return;
  const double usual = core::quantile(steps, 0.5);
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (steps[i] > kUsualSteps * usual) series.gaps.push_back(static_cast<int>(i) + 1);
}

/// @param n  joints
Series load_csv(const std::filesystem::path& file, Eigen::Index n) {
  std::ifstream stream(file);
  if (!stream)
    throw core::InvalidInput(fmt::format("{}: series: got a file that cannot be read, expected a CSV or NPZ file", file.string()));
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

/// Arrays t (moments), q and tau (moments × n).
Series load_npz(const std::filesystem::path& file, Eigen::Index n) {
  const auto arrays = read_npz(file);
  const auto fail = [&](const std::string& got, const std::string& expected) {
    throw core::InvalidInput(fmt::format("{}: series: got {}, expected {}", file.string(), got, expected));
  };
  const auto find = [&](const std::string& name) -> const Eigen::MatrixXd& {
    const auto found = arrays.find(name);
    if (found == arrays.end()) fail(fmt::format("no array '{}'", name), "t, q and tau");
    return found->second;
  };
  const Eigen::MatrixXd &t = find("t"), &q = find("q"), &tau = find("tau");
  if (t.size() == 0) fail("no moment", "at least one");
  const auto require = [&](const char* name, const Eigen::MatrixXd& array, Eigen::Index columns) {
    if (array.rows() != t.rows() || array.cols() != columns)
      fail(fmt::format("{} of shape ({}, {})", name, array.rows(), array.cols()), fmt::format("({}, {})", t.rows(), columns));
    if (!array.allFinite()) fail(fmt::format("a number of {} that is not finite", name), "finite numbers");
  };
  require("t", t, 1);
  require("q", q, n);
  require("tau", tau, n);
  for (Eigen::Index i = 1; i < t.rows(); ++i)
    if (!(t(i, 0) > t(i - 1, 0))) fail(fmt::format("t[{}] = {} after {}", i, t(i, 0), t(i - 1, 0)), "times that increase");
  Series out;
  out.times.assign(t.data(), t.data() + t.size());
  out.q = q.transpose();
  out.tau = tau.transpose();
  return out;
}

}  // namespace

Series load_series(const std::filesystem::path& file, const world::Model& model) {
  Series out = file.extension() == ".npz" ? load_npz(file, model.n_a()) : load_csv(file, model.n_a());
  mark_gaps(out);
  return out;
}

}  // namespace stiction::sensing
