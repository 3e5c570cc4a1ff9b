#include "stiction/world/decomposition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/call_coacd.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

namespace fs = std::filesystem;

/// First line of a cache file: layout of the file, and version of the library that made the parts.
constexpr std::string_view kHeader = "stiction convex parts 1, coacd " STICTION_COACD_VERSION "\n";
constexpr std::uint64_t kMaxPoints = 1'000'000;  ///< largest number of points of a part; a file with more is damaged
constexpr double kSnap = 5e-4;                   ///< snap distance, in units of half the longest edge of the bounding box

/// SHA-256 of everything that decides the parts.
std::string calc_key(const Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options) {
  std::string bytes(kHeader);
  const std::array<std::int64_t, 3> sizes{vertices.cols(), triangles.cols(), options.max_parts};
  append_values(bytes, sizes.data(), sizes.size());
  append_values(bytes, &options.threshold, 1);
  append_values(bytes, vertices.data(), static_cast<std::size_t>(vertices.size()));
  append_values(bytes, triangles.data(), static_cast<std::size_t>(triangles.size()));
  return core::sha256(bytes);
}

/// Encodes the parts: number of parts, then for each part the number of points and the points.
std::string write_parts(const std::vector<Matrix3Xd>& parts) {
  std::string out;
  const std::uint64_t count = parts.size();
  append_values(out, &count, 1);
  for (const Matrix3Xd& part : parts) {
    const auto n = static_cast<std::uint64_t>(part.cols());
    append_values(out, &n, 1);
    append_values(out, part.data(), static_cast<std::size_t>(part.size()));
  }
  return out;
}

/// Reads the parts; nullopt if the file does not exist, is damaged, or is of another version or mesh.
std::optional<std::vector<Matrix3Xd>> read_parts(const fs::path& file, std::string_view key) {
  const auto bytes = read_sealed(file, kHeader, key);
  if (!bytes) return std::nullopt;
  std::string_view rest = *bytes;
  std::uint64_t count = 0, n = 0;
  if (!take_values(rest, &count, 1)) return std::nullopt;
  std::vector<Matrix3Xd> parts;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!take_values(rest, &n, 1) || n > kMaxPoints) return std::nullopt;
    Matrix3Xd part(3, static_cast<Eigen::Index>(n));
    if (!take_values(rest, part.data(), 3 * n)) return std::nullopt;
    parts.push_back(std::move(part));
  }
  if (!rest.empty()) return std::nullopt;
  return parts;
}

/// Moves corners of the parts back to the vertices of the mesh, so that faces of the mesh stay flat and in their place. The library moves the
/// surface by about 1e-4 of its size where it cuts.
void snap(const Matrix3Xd& vertices, std::vector<Matrix3Xd>& parts) {
  const double reach = kSnap / 2 * (vertices.rowwise().maxCoeff() - vertices.rowwise().minCoeff()).maxCoeff();
  for (Matrix3Xd& part : parts) {
    for (Eigen::Index i = 0; i < part.cols(); ++i) {
      Eigen::Index nearest = 0;
      const double distance = (vertices.colwise() - part.col(i)).colwise().squaredNorm().minCoeff(&nearest);
      if (distance <= reach * reach) part.col(i) = vertices.col(nearest);
    }
  }
}

/// Makes the hulls of the parts. A part without volume is a sliver of a cut and is left out.
std::vector<ConvexMesh> make_hulls(const std::vector<Matrix3Xd>& parts) {
  std::vector<ConvexMesh> hulls;
  for (const Matrix3Xd& part : parts) {
    try {
      hulls.push_back(make_convex_hull(part));
    } catch (const core::InvalidInput&) {
      continue;
    }
  }
  const auto center = [](const ConvexMesh& mesh) -> Vector3d { return mesh.vertices.rowwise().mean(); };
  std::sort(hulls.begin(), hulls.end(), [&](const ConvexMesh& a, const ConvexMesh& b) {
    const Vector3d p = center(a), q = center(b);
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  });
  return hulls;
}

}  // namespace

std::vector<ConvexMesh> decompose(const Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options,
                                  const fs::path& cache_dir) {
  if (!(options.threshold >= Decomposition::kMinThreshold && options.threshold <= 1))
    core::throw_invalid("convex_decomposition.threshold", fmt::format("{}", options.threshold), "a number from 0.01 to 1");
  if (options.max_parts < 1) core::throw_invalid("convex_decomposition.max_parts", fmt::format("{}", options.max_parts), "an integer ≥ 1");
  const std::string key = calc_key(vertices, triangles, options);
  const fs::path file = cache_dir.empty() ? fs::path() : cache_dir / (key + ".parts");
  if (!file.empty()) {
    if (const auto parts = read_parts(file, key)) {
      if (auto hulls = make_hulls(*parts); !hulls.empty()) return hulls;
    }
  }
  std::vector<Matrix3Xd> parts = call_coacd(vertices, triangles, options);
  snap(vertices, parts);
  auto hulls = make_hulls(parts);
  if (hulls.empty()) core::throw_invalid("convex_decomposition", "no part with a volume", "a mesh that encloses a volume");
  if (!file.empty()) store_in_cache(file, seal(kHeader, key, write_parts(parts)));
  return hulls;
}

}  // namespace stiction::world
