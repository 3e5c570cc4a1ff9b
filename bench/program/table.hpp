#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app.hpp"

namespace stiction::app {

/// Figures of others [s]: published ones, and those of a peer program, of which each file of rows says what it is.
struct Reference {
  std::optional<double> published, peer;
};

struct Row {
  std::string name;
  double median_s = 0, p95_s = 0, p99_s = 0;
  Reference reference;
  std::optional<long> allocations;
  int failures = 0;
  std::optional<double> contacts;  ///< median number of a step
};

struct BenchArguments {
  std::string filter;
  std::vector<std::string> tasks;  ///< to time steps of, in place of all rows; names of built-in ones, or files
  int repeat = 5;
  bool json = false;
};

using BenchClock = std::chrono::steady_clock;
inline double seconds_since(BenchClock::time_point start) { return std::chrono::duration<double>(BenchClock::now() - start).count(); }

/// @param seconds  not empty
Row make_row(std::string name, std::vector<double> seconds, const Reference& reference, std::optional<long> allocations, int failures);

/// The rows so far, each printed as soon as it is known.
class BenchTable {
 public:
  explicit BenchTable(BenchArguments arguments) : arguments_(std::move(arguments)), dirs_(data_dirs()) {}

  /// The name has the filter in it, and nobody has asked to stop.
  bool wanted(std::string_view name) const { return name.find(arguments_.filter) != std::string_view::npos && !interrupted(); }
  const std::vector<std::string>& tasks() const { return arguments_.tasks; }
  int repeat() const { return arguments_.repeat; }
  const std::vector<std::filesystem::path>& task_dirs() const { return dirs_; }
  /// The folder of robots and scenes beside that of the tasks. @throws core::InvalidInput
  std::filesystem::path models_dir() const;

  ProgressLine& line() { return line_; }
  void add(Row row);
  const std::vector<Row>& rows() const { return rows_; }

 private:
  BenchArguments arguments_;
  std::vector<std::filesystem::path> dirs_;
  ProgressLine line_;
  std::vector<Row> rows_;
};

/// Each adds the rows of its part that are wanted.
void add_step_rows(BenchTable& table);
void add_task_rows(BenchTable& table);  ///< steps of BenchTable::tasks
void add_cone_rows(BenchTable& table);
void add_plan_rows(BenchTable& table);
void add_sensing_rows(BenchTable& table);
void add_control_rows(BenchTable& table);

}  // namespace stiction::app
