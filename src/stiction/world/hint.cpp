#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "stiction/world/yaml.hpp"

namespace stiction::world {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

std::string list_with_hint(std::string_view name, std::span<const std::string> known) {
  std::string text = fmt::format("{}", fmt::join(known, ", "));
  std::size_t best = std::numeric_limits<std::size_t>::max();
  const std::string* nearest = nullptr;
  for (const auto& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best) best = distance, nearest = &candidate;
  }
  if (nearest != nullptr && best > 0 && best <= std::max<std::size_t>(1, std::max(name.size(), nearest->size()) / 3)) {
    text += fmt::format("; did you mean '{}'?", *nearest);
  }
  return text;
}

}  // namespace stiction::world
