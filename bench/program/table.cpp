#include "table.hpp"

#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"

namespace stiction::app {

Row make_row(std::string name, std::vector<double> seconds, const Reference& reference, std::optional<long> allocations, int failures) {
  Row row;
  row.name = std::move(name);
  row.reference = reference;
  row.allocations = allocations;
  row.failures = failures;
  row.median_s = core::quantile(seconds, 0.5);
  row.p95_s = core::quantile(seconds, 0.95);
  row.p99_s = core::quantile(seconds, 0.99);
  return row;
}

std::filesystem::path BenchTable::models_dir() const {
  for (const auto& dir : dirs_) {
    const auto models = dir.parent_path() / "models";
    if (std::filesystem::exists(models / "stacking.yaml")) return models;
  }
  core::throw_invalid("stacking.yaml", "not found", "a folder models/ beside that of the tasks");
}

void BenchTable::add(Row row) {
  line_.clear();
  std::FILE* const to = people(arguments_.json);
  const auto milliseconds = [](std::optional<double> s) { return s ? fmt::format("{:.4g}", 1e3 * *s) : std::string("–"); };
  if (rows_.empty())
    fmt::print(to, "{:42} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9}  allocations\n", "[ms]", "contacts", "median", "p95", "p99",
               "published", "peer", "published/ours");
  const std::string ratio = row.reference.published ? fmt::format("{:.0f}", *row.reference.published / row.median_s) : "–";
  fmt::print(to, "{:42} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9}  {}{}\n", row.name,
             row.contacts ? fmt::format("{:.0f}", *row.contacts) : "–", milliseconds(row.median_s), milliseconds(row.p95_s),
             milliseconds(row.p99_s), milliseconds(row.reference.published), milliseconds(row.reference.peer), ratio,
             row.allocations ? std::to_string(*row.allocations) : "–", row.failures ? fmt::format("  {} not solved", row.failures) : "");
  rows_.push_back(std::move(row));
}

}  // namespace stiction::app
