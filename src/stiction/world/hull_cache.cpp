#include "stiction/world/hull_cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "stiction/core/sha256.hpp"
#include "stiction/world/cache_file.hpp"

namespace stiction::world {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kTitle = "stiction hulls 1\n";
constexpr std::string_view kExtension = ".hulls";

/// Encodes hulls: `filled`, error, number of parts; then for each part the numbers of vertices and triangles, the vertices and the triangles.
std::string write_hulls(const LoadedMesh& mesh) {
  std::string out;
  const std::uint64_t filled = mesh.filled, count = mesh.parts.size();
  append_values(out, &filled, 1);
  append_values(out, &mesh.error, 1);
  append_values(out, &count, 1);
  for (const ConvexMesh& part : mesh.parts) {
    const std::uint64_t sizes[2] = {static_cast<std::uint64_t>(part.vertices.cols()), static_cast<std::uint64_t>(part.triangles.cols())};
    append_values(out, sizes, 2);
    append_values(out, part.vertices.data(), static_cast<std::size_t>(part.vertices.size()));
    append_values(out, part.triangles.data(), static_cast<std::size_t>(part.triangles.size()));
  }
  return out;
}

std::optional<ConvexMesh> take_hull(std::string_view& bytes) {
  std::uint64_t sizes[2] = {0, 0};
  if (!take_values(bytes, sizes, 2) || std::max(sizes[0], sizes[1]) > bytes.size()) return std::nullopt;
  ConvexMesh part{.vertices = Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(sizes[0])),
                  .triangles = Eigen::Matrix3Xi(3, static_cast<Eigen::Index>(sizes[1])),
                  .source = {}};
  if (!take_values(bytes, part.vertices.data(), 3 * sizes[0]) || !take_values(bytes, part.triangles.data(), 3 * sizes[1]))
    return std::nullopt;
  const bool valid = sizes[0] > 0 && sizes[1] > 0 && part.triangles.minCoeff() >= 0 && part.triangles.maxCoeff() < part.vertices.cols();
  return valid ? std::optional(std::move(part)) : std::nullopt;
}

std::optional<LoadedMesh> read_hulls(std::string_view bytes) {
  LoadedMesh out;
  std::uint64_t filled = 0, count = 0;
  if (!take_values(bytes, &filled, 1) || !take_values(bytes, &out.error, 1) || !take_values(bytes, &count, 1)) return std::nullopt;
  out.filled = filled != 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    auto part = take_hull(bytes);
    if (!part) return std::nullopt;
    out.parts.push_back(*std::move(part));
  }
  if (out.parts.empty() || !bytes.empty()) return std::nullopt;
  return out;
}

/// Reading all file sizes takes time, so the cache is trimmed for one new file in 16. Keys are hashes, so their first digit is random.
bool is_time_to_trim(const std::string& key) { return key.starts_with('0'); }

}  // namespace

fs::path hull_cache_dir() {
  const fs::path folder = default_cache_dir();
  return folder.empty() ? folder : folder / "hulls";
}

std::string calc_hull_key(std::string_view mesh, std::string_view how) {
  return core::sha256(fmt::format("{}{}\n{}\n{}", kTitle, STICTION_HULL_CODE, how, core::sha256(mesh)));
}

LoadedMesh find_or_make_hulls(const fs::path& folder, const std::string& key, const std::function<LoadedMesh()>& make) {
  if (folder.empty()) return make();
  const fs::path file = folder / fmt::format("{}{}", key, kExtension);
  if (const auto bytes = read_sealed(file, kTitle, key)) {
    if (auto kept = read_hulls(*bytes)) return *std::move(kept);
  }
  LoadedMesh made = make();
  store_in_cache(file, seal(kTitle, key, write_hulls(made)));
  if (is_time_to_trim(key)) trim_hull_cache(folder, kHullCacheLimit);
  return made;
}

void trim_hull_cache(const fs::path& folder, std::uintmax_t limit) {
  using Entry = std::tuple<fs::file_time_type, fs::path, std::uintmax_t>;
  std::vector<Entry> files;
  std::uintmax_t total = 0;
  std::error_code error;
  for (fs::directory_iterator at(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    // Temporary files of a program that was stopped while writing contain the extension inside a longer name; they count as well.
    if (at->path().filename().string().find(kExtension) == std::string::npos) continue;
    std::error_code gone;
    const std::uintmax_t size = at->is_regular_file(gone) ? at->file_size(gone) : 0;
    const fs::file_time_type written = at->last_write_time(gone);
    if (gone || size == 0) continue;
    files.emplace_back(written, at->path(), size);
    total += size;
  }
  std::sort(files.begin(), files.end());
  for (const auto& [written, path, size] : files) {
    if (total <= limit) break;
    fs::remove(path, error);
    total -= size;
  }
}

}  // namespace stiction::world
