#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/number.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/sensing/npz.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/sensing/series_columns.hpp"

namespace stiction::sensing {
namespace {

using Strings = std::vector<std::string>;

std::string_view trim_spaces(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The fields of a line, separated by commas that stand outside of quotation marks; nothing where a quotation mark is not closed.
std::optional<Strings> split_fields(std::string_view line) {
  Strings out(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
      out.back() += line[i++];
    } else if (line[i] == '"') {
      is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      out.emplace_back();
    } else {
      out.back() += line[i];
    }
  }
  if (is_quoted) return std::nullopt;
  for (std::string& field : out) field = trim_spaces(field);
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

/// A table of numbers, with or without a line of names.
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& file, const world::Model& model) : file_(file), model_(model), n_(model.n_a()) {}

  Series read() {
    std::ifstream stream(file_);
    if (!stream)
      throw core::InvalidInput(fmt::format("{}: series: got a file that cannot be read, expected a CSV or NPZ file", file_.string()));
    std::string text;
    while (std::getline(stream, text)) {
      ++line_;
      constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      read_line(trim_spaces(text));
    }
    if (times_.empty()) throw core::InvalidInput(fmt::format("{}: series: got no line of numbers, expected at least one", file_.string()));
    Series out;
    out.times = times_;
    const auto moments = static_cast<Eigen::Index>(times_.size());
    out.q = Eigen::Map<const Eigen::MatrixXd>(q_.data(), n_, moments);
    out.tau = Eigen::Map<const Eigen::MatrixXd>(tau_.data(), n_, moments);
    out.notes = columns_->notes;
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& got, const std::string& expected) const {
    throw core::InvalidInput(fmt::format("{}: got {}, expected {}", where(line_), got, expected));
  }
  std::string where(int line) const { return fmt::format("{}:{}: series", file_.string(), line); }
  std::string ordered() const { return fmt::format("{} finite numbers: a time, {} joint positions, {} torques", 1 + 2 * n_, n_, n_); }

  /// The first line that is no comment has names or numbers. numpy.savetxt writes names as the last comment before the numbers.
  void read_line(std::string_view text) {
    if (text.empty()) return;
    if (text.starts_with('#')) {
      if (columns_) return;
      comment_ = text.substr(1);
      comment_line_ = line_;
      return;
    }
    const auto fields = split_fields(text);
    if (!fields) fail(quote(text), "as many quotation marks that open as that close");
    if (!columns_ && read_names(*fields, text)) return;
    read_row(*fields, text);
  }

  /// @returns whether the line has names; else the columns are known from the comment before it, or by their order
  bool read_names(const Strings& fields, std::string_view text) {
    const auto numbers =
        std::count_if(fields.begin(), fields.end(), [](const std::string& field) { return core::parse_number(field).has_value(); });
    if (numbers == 0) {
      columns_ = find_columns(fields, model_, where(line_));
      n_columns_ = fields.size();
      return true;
    }
    n_columns_ = fields.size();
    if (const auto names = split_fields(comment_); names && names->size() == fields.size() && fields.size() > 1) {
      columns_ = find_columns(*names, model_, where(comment_line_));
      return false;
    }
    if (numbers != static_cast<std::ptrdiff_t>(fields.size())) fail(quote(text), "a name for every column, or " + ordered());
    if (n_columns_ != static_cast<std::size_t>(1 + 2 * n_)) fail(fmt::format("{} numbers", fields.size()), ordered());
    columns_ = make_ordered_columns(static_cast<int>(n_));
    return false;
  }

  void read_row(const Strings& fields, std::string_view text) {
    if (fields.size() != n_columns_) fail(fmt::format("{} fields", fields.size()), fmt::format("{}, one for each column", n_columns_));
    const double time = number(fields, columns_->time, text);
    if (!times_.empty() && !(time > times_.back())) fail(fmt::format("time {} after {}", time, times_.back()), "times that increase");
    times_.push_back(time);
    for (const std::size_t column : columns_->q) q_.push_back(number(fields, column, text));
    for (const std::size_t column : columns_->tau) tau_.push_back(number(fields, column, text));
  }

  double number(const Strings& fields, std::size_t column, std::string_view text) const {
    const auto out = core::parse_number(fields[column]);
    if (!out || !std::isfinite(*out))
      fail(fmt::format("{}, with '{}' in column {}", quote(text), fields[column], column + 1), "a finite number");
    return *out;
  }

  static std::string quote(std::string_view text) { return fmt::format("'{}'", text.substr(0, 40)); }

  const std::filesystem::path& file_;
  const world::Model& model_;
  Eigen::Index n_;  ///< joints
  int line_ = 0, comment_line_ = 0;
  std::string comment_;
  std::optional<SeriesColumns> columns_;
  std::size_t n_columns_ = 0;
  std::vector<double> times_, q_, tau_;
};

Eigen::MatrixXd take_columns(const Eigen::MatrixXd& array, const std::vector<std::size_t>& columns) {
  Eigen::MatrixXd out(array.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) out.col(static_cast<Eigen::Index>(j)) = array.col(static_cast<Eigen::Index>(columns[j]));
  return out;
}

/// Arrays t (moments), q and tau (moments × n), whose columns are in the order of u, or in that of an array `joints` of names.
Series load_npz(const std::filesystem::path& file, const world::Model& model) {
  const NpzArrays content = read_npz(file);
  const auto& arrays = content.numbers;
  const auto fail = [&](const std::string& got, const std::string& expected) {
    throw core::InvalidInput(fmt::format("{}: series: got {}, expected {}", file.string(), got, expected));
  };
  const auto find = [&](const std::string& name) -> const Eigen::MatrixXd& {
    const auto found = arrays.find(name);
    if (found == arrays.end()) fail(fmt::format("no array '{}'", name), "t, q and tau");
    return found->second;
  };
  const Eigen::MatrixXd &t = find("t"), &q = find("q"), &tau = find("tau");
  const auto joints = content.words.find("joints");
  const bool is_named = joints != content.words.end();
  const Eigen::Index n = is_named ? static_cast<Eigen::Index>(joints->second.size()) : model.n_a();
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
  std::vector<std::size_t> columns(static_cast<std::size_t>(n));
  std::iota(columns.begin(), columns.end(), std::size_t{0});
  if (is_named) columns = find_joints(joints->second, model, fmt::format("{}: series", file.string()));
  out.q = take_columns(q, columns).transpose();
  out.tau = take_columns(tau, columns).transpose();
  return out;
}

}  // namespace

Series load_series(const std::filesystem::path& file, const world::Model& model) {
  Series out = file.extension() == ".npz" ? load_npz(file, model) : CsvReader(file, model).read();
  mark_gaps(out);
  return out;
}

}  // namespace stiction::sensing
