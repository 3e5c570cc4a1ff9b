#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <numeric>
#include <optional>

#include "stiction/core/file_fault.hpp"
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

/// The character between the fields of a line: a semicolon if there is one, as commas may then stand in numbers, else a comma, a tab or blanks.
char find_separator(std::string_view line) {
  for (const char mark : {';', ',', '\t'})
    if (line.find(mark) != std::string_view::npos) return mark;
  return ' ';
}

/// The fields of a line, separated by marks that stand outside of quotation marks; nothing where a quotation mark is not closed.
std::optional<Strings> split_fields(std::string_view line, char separator) {
  Strings out(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
      out.back() += line[i++];
    } else if (line[i] == '"') {
      is_quoted = !is_quoted;
    } else if (line[i] == separator && !is_quoted) {
      if (separator != ' ' || !out.back().empty()) out.emplace_back();  // numbers stand under each other with several blanks
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

/// Expands numbers of the measured joints to all joints. @param rest  values of the other joints
Eigen::MatrixXd spread(const Eigen::MatrixXd& measured, const std::vector<int>& joints, const Eigen::VectorXd& rest) {
  Eigen::MatrixXd out = rest.replicate(1, measured.cols());
  for (std::size_t i = 0; i < joints.size(); ++i) out.row(joints[i]) = measured.row(static_cast<Eigen::Index>(i));
  return out;
}

/// What a file is whose first bytes are these, and what makes a table of it.
std::optional<std::pair<std::string_view, std::string_view>> find_other_format(std::string_view start) {
  struct Format {
    std::string_view start, what, remedy;
  };
  constexpr std::string_view kPandas = "pandas reads it, and to_csv(FILE, index=False) writes a table";
  constexpr std::string_view kBag = "`ros2 bag convert` makes an MCAP file of a bag, and stiction.load_joint_states reads that in Python";
  constexpr Format kFormats[] = {
      {"PAR1", "a Parquet file", kPandas},
      {"\x89MCAP", "an MCAP file", "stiction.load_joint_states reads it in Python, if its name ends in .mcap"},
      {"SQLite format 3", "a SQLite database, as bags of ROS 2 are", kBag},
      {"#ROSBAG", "a bag of ROS 1", "`rosbags-convert` makes an MCAP file of it"},
      {"\x93NUMPY", "one array of NumPy", "numpy.savez(FILE, t=t, q=q, tau=tau) writes three"},
      {"\x89HDF", "an HDF5 file", "h5py and numpy.savez make an .npz file of it"},
      {"MATLAB", "a MAT file", "scipy.io.loadmat and numpy.savez make an .npz file of it"},
      {"\x1f\x8b", "a file packed by gzip", "gunzip unpacks it"},
      {"PK\x03\x04", "a zip archive, as spreadsheets and .npz files are", "its name has to end in .npz, or it has to be saved as CSV"},
      {"{", "JSON", kPandas},
      {"[", "JSON", kPandas}};
  for (const Format& format : kFormats)
    if (start.starts_with(format.start)) return std::pair(format.what, format.remedy);
  return std::nullopt;
}

/// Says of times that are a second and more apart in whole numbers that they may be milliseconds.
void note_whole_times(const std::filesystem::path& file, Series& series) {
  constexpr std::size_t kFewest = 20;
  if (series.times.size() < kFewest) return;
  const auto is_whole = [](double t) { return t == std::floor(t); };
  if (!std::all_of(series.times.begin(), series.times.end(), is_whole)) return;
  series.notes.push_back(
      fmt::format("{}: series: all times are whole numbers, taken for seconds; a column time_ms is in milliseconds", file.string()));
}

/// A table of numbers, with or without a line of names.
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& file, const world::Model& model, const std::vector<int>& unmeasured)
      : file_(file), model_(model), unmeasured_(unmeasured), n_(model.n_a() - static_cast<Eigen::Index>(unmeasured.size())) {}

  Series read() {
    std::ifstream stream(file_);
    if (!stream || std::filesystem::is_directory(file_))
      throw core::InvalidInput(
          fmt::format("{}: series: got {}, expected a CSV or NPZ file", file_.string(), core::describe_unreadable(file_)));
    std::string text;
    while (std::getline(stream, text)) {
      ++line_;
      constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
      if (line_ == 1 && (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))) fail("text in UTF-16", "UTF-8");
      if (line_ == 1)
        if (const auto other = find_other_format(text))
          throw core::InvalidInput(
              fmt::format("{}: series: got {}, expected a CSV or NPZ file; {}", file_.string(), other->first, other->second));
      if (text.find('\0') != std::string::npos) fail("a byte 0", "text: numbers between commas");
      read_line(trim_spaces(text));
    }
    if (times_.empty() && left_out_ > 0)
      throw core::InvalidInput(
          fmt::format("{}: series: got {} lines that all lack a number, expected numbers in the columns of "
                      "every measured joint",
                      file_.string(), left_out_));
    if (times_.empty()) throw core::InvalidInput(fmt::format("{}: series: got no line of numbers, expected at least one", file_.string()));
    Series out;
    out.times = times_;
    const auto moments = static_cast<Eigen::Index>(times_.size());
    out.q = spread(Eigen::Map<const Eigen::MatrixXd>(q_.data(), n_, moments), columns_->joints, model_.neutral().tail(model_.n_a()));
    out.tau = spread(Eigen::Map<const Eigen::MatrixXd>(tau_.data(), n_, moments), columns_->joints, Eigen::VectorXd::Zero(model_.n_a()));
    out.notes = columns_->notes;
    if (left_out_ > 0)
      out.notes.push_back(fmt::format("{}: {} of {} lines lack a number and are left out, the first is line {}", file_.string(), left_out_,
                                      left_out_ + times_.size(), first_left_out_));
    if (columns_->seconds == 1) note_whole_times(file_, out);
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& got, const std::string& expected) const {
    throw core::InvalidInput(fmt::format("{}: got {}, expected {}", where(line_), got, expected));
  }
  std::string where(int line) const { return fmt::format("{}:{}: series", file_.string(), line); }
  std::string ordered() const { return fmt::format("{} finite numbers: a time, {} joint positions, {} torques", 1 + 2 * n_, n_, n_); }

  /// The first line that is no comment has names or numbers. numpy.savetxt writes names as a comment before the numbers.
  void read_line(std::string_view text) {
    if (text.empty()) return;
    if (text.starts_with('#')) {
      if (columns_) return;
      comments_.emplace_back(line_, text.substr(1));
      return;
    }
    if (!columns_) separator_ = find_separator(text);
    auto fields = split_fields(text, separator_);
    if (!fields) fail(quote(text), "as many quotation marks that open as that close");
    if (separator_ == ';') std::ranges::for_each(*fields, write_point);
    if (!columns_ && read_names(*fields, text)) return;
    read_row(*fields, text);
  }

  /// @returns whether the line has names; else the columns are known from a comment before it, or by their order
  bool read_names(const Strings& fields, std::string_view text) {
    const auto numbers =
        std::count_if(fields.begin(), fields.end(), [](const std::string& field) { return core::parse_number(field).has_value(); });
    if (numbers == 0) {
      columns_ = find_columns(fields, model_, where(line_), unmeasured_);
      is_named_ = true;
      n_columns_ = fields.size();
      return true;
    }
    n_columns_ = fields.size();
    if (read_names_in_comments()) return false;
    if (numbers != static_cast<std::ptrdiff_t>(fields.size())) fail(quote(text), "a name for every column, or " + ordered());
    if (n_columns_ != static_cast<std::size_t>(1 + 2 * n_)) fail(fmt::format("{} numbers", fields.size()), ordered());
    columns_ = make_ordered_columns(model_.n_a(), unmeasured_);
    return false;
  }

  /// Takes the last comment with a name for every column. Its names may stand between other characters than the numbers.
  /// @throws core::InvalidInput: a comment has as many words as there are columns, but does not name what is needed
  bool read_names_in_comments() {
    std::optional<core::InvalidInput> fault;
    for (auto comment = comments_.rbegin(); comment != comments_.rend() && n_columns_ > 1; ++comment) {
      const char separator = find_separator(comment->second);
      const auto names = split_fields(comment->second, separator);
      if (!names || names->size() != n_columns_) continue;
      try {
        columns_ = find_columns(*names, model_, where(comment->first), unmeasured_);
        return is_named_ = true;
      } catch (const core::InvalidInput& e) {
        if (!fault && separator == separator_) fault = e;  // else a sentence that happens to have as many words
      }
    }
    if (fault) throw *fault;
    return false;
  }

  void read_row(const Strings& fields, std::string_view text) {
    if (fields.size() != n_columns_) fail(fmt::format("{} fields", fields.size()), fmt::format("{}, one for each column", n_columns_));
    if (is_named_ && lacks_number(fields)) {
      if (left_out_++ == 0) first_left_out_ = line_;
      return;
    }
    const double time = columns_->seconds * number(fields, columns_->time, text);
    if (!times_.empty() && !(time > times_.back())) fail(fmt::format("time {} after {}", time, times_.back()), "times that increase");
    times_.push_back(time);
    for (const std::size_t column : columns_->q) q_.push_back(number(fields, column, text));
    for (const std::size_t column : columns_->tau) tau_.push_back(number(fields, column, text));
  }

  /// Whether a used column is empty or NaN, or says so in a word: no measurement at that moment.
  bool lacks_number(const Strings& fields) const {
    constexpr std::string_view kNone[] = {"", "null", "NULL", "None", "NA", "N/A", "n/a", "<NA>", "-"};
    const auto is_missing = [&](std::size_t column) {
      const auto value = core::parse_number(fields[column]);
      return std::ranges::find(kNone, fields[column]) != std::end(kNone) || (value && std::isnan(*value));
    };
    return is_missing(columns_->time) || std::any_of(columns_->q.begin(), columns_->q.end(), is_missing) ||
           std::any_of(columns_->tau.begin(), columns_->tau.end(), is_missing);
  }

  double number(const Strings& fields, std::size_t column, std::string_view text) const {
    const auto out = core::parse_number(fields[column]);
    if (!out || !std::isfinite(*out))
      fail(fmt::format("{}, with '{}' in column {}", quote(text), fields[column], column + 1), "a finite number");
    return *out;
  }

  /// Of a number with a decimal comma, which stands beside semicolons only.
  static void write_point(std::string& field) {
    const std::size_t comma = field.find(',');
    if (comma == std::string::npos) return;
    std::string number = field;
    number[comma] = '.';
    if (core::parse_number(number)) field = number;
  }

  static std::string quote(std::string_view text) { return fmt::format("'{}'", text.substr(0, 40)); }

  const std::filesystem::path& file_;
  const world::Model& model_;
  const std::vector<int>& unmeasured_;
  Eigen::Index n_;  ///< joints that are measured
  int line_ = 0;
  std::vector<std::pair<int, std::string>> comments_;  ///< before the numbers, with their lines
  char separator_ = ',';
  std::optional<SeriesColumns> columns_;
  std::size_t n_columns_ = 0, left_out_ = 0;
  bool is_named_ = false;
  int first_left_out_ = 0;
  std::vector<double> times_, q_, tau_;
};

Eigen::MatrixXd take_columns(const Eigen::MatrixXd& array, const std::vector<std::size_t>& columns) {
  Eigen::MatrixXd out(array.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) out.col(static_cast<Eigen::Index>(j)) = array.col(static_cast<Eigen::Index>(columns[j]));
  return out;
}

/// Arrays t (moments), q and tau (moments × n), whose columns are in the order of u, or in that of an array `joints` of names.
Series load_npz(const std::filesystem::path& file, const world::Model& model, const std::vector<int>& unmeasured) {
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
  const Eigen::Index n =
      is_named ? static_cast<Eigen::Index>(joints->second.size()) : model.n_a() - static_cast<Eigen::Index>(unmeasured.size());
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
  if (is_named) columns = find_joints(joints->second, model, fmt::format("{}: series", file.string()), unmeasured);
  const std::vector<int> measured = joints_but(model.n_a(), unmeasured);
  out.q = spread(take_columns(q, columns).transpose(), measured, model.neutral().tail(model.n_a()));
  out.tau = spread(take_columns(tau, columns).transpose(), measured, Eigen::VectorXd::Zero(model.n_a()));
  note_whole_times(file, out);
  return out;
}

/// Refuses torques that no motor of the robot can bear: they must have another unit.
void require_newton_metres(const std::filesystem::path& file, const world::Model& model, const Series& series) {
  constexpr double kMost = 20;  // times the effort that the robot's file states
  for (Eigen::Index j = 0; j < series.tau.rows(); ++j) {
    const double most = series.tau.row(j).cwiseAbs().maxCoeff(), effort = model.effort()[j];
    if (!std::isfinite(effort) || effort <= 0 || most <= kMost * effort) continue;
    throw core::InvalidInput(fmt::format(
        "{}: series: got torques of up to {:.4g} in joint '{}', {:.0f} times what its motor bears, expected N m (N of a slider); "
        "divide torques in N mm by 1000",
        file.string(), most, model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name, most / effort));
  }
}

/// Refuses joint angles that are none in radians: far beyond the limits, and beyond half a turn.
void require_radians(const std::filesystem::path& file, const world::Model& model, const Series& series) {
  for (Eigen::Index j = 0; j < series.q.rows(); ++j) {
    const world::Dof& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)];
    const double most = series.q.row(j).cwiseAbs().maxCoeff();
    const double limit = std::max({std::abs(dof.lower), std::abs(dof.upper), std::numbers::pi});
    if (dof.kind != world::DofKind::Revolute || !std::isfinite(limit) || most <= 2 * limit) continue;
    throw core::InvalidInput(
        fmt::format("{}: series: got positions of up to {:.4g} in joint '{}', whose limits are {:.4g} and {:.4g}, expected rad; multiply "
                    "degrees by pi/180",
                    file.string(), most, dof.name, dof.lower, dof.upper));
  }
}

/// Refuses times that are none in seconds.
void require_seconds(const std::filesystem::path& file, const Series& series) {
  constexpr double kLatest = 1e11;  // the year 5138, since 1970
  const double last = series.times.back();
  if (last > kLatest)
    throw core::InvalidInput(
        fmt::format("{}: series: got a time of {:.4g}, expected seconds; divide milliseconds by 1000, and nanoseconds by 1e9, or name the "
                    "column time_ms or time_ns",
                    file.string(), last));
}

}  // namespace

Series load_series(const std::filesystem::path& file, const world::Model& model, const std::vector<int>& unmeasured) {
  if (file.extension() == ".mcap")
    throw core::InvalidInput(fmt::format(
        "{}: series: got an MCAP file, expected CSV or NPZ; stiction.load_joint_states('{}').save('log.npz') makes one in Python",
        file.string(), file.filename().string()));
  Series out = file.extension() == ".npz" ? load_npz(file, model, unmeasured) : CsvReader(file, model, unmeasured).read();
  require_seconds(file, out);
  require_radians(file, model, out);
  require_newton_metres(file, model, out);
  mark_gaps(out);
  return out;
}

}  // namespace stiction::sensing
