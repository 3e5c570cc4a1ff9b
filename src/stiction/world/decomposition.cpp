#include "stiction/world/decomposition.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/call_coacd.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

namespace fs = std::filesystem;

/// First line of a file: what follows has this layout and comes from this version of the library.
constexpr std::string_view kHeader = "stiction convex parts 1, coacd " STICTION_COACD_VERSION "\n";
constexpr std::size_t kDigits = 64;              ///< of a SHA-256
constexpr std::uint64_t kMaxPoints = 1'000'000;  ///< of one part; more is damage
constexpr double kSnap = 5e-4;                   ///< of half the longest edge of the bounding box

template <class T>
void append(std::string& bytes, const T* values, std::size_t n) {
  bytes.append(reinterpret_cast<const char*>(values), n * sizeof(T));
}

/// SHA-256 of everything that decides the parts.
std::string calc_key(const Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options) {
  std::string bytes(kHeader);
  const std::array<std::int64_t, 3> sizes{vertices.cols(), triangles.cols(), options.max_parts};
  append(bytes, sizes.data(), sizes.size());
  append(bytes, &options.threshold, 1);
  append(bytes, vertices.data(), static_cast<std::size_t>(vertices.size()));
  append(bytes, triangles.data(), static_cast<std::size_t>(triangles.size()));
  return core::sha256(bytes);
}

/// Points of each part, as: header, key, SHA-256 of the rest, number of parts, for each the number of points and the points.
std::string write_parts(std::string_view key, const std::vector<Matrix3Xd>& parts) {
  std::string rest;
  const std::uint64_t count = parts.size();
  append(rest, &count, 1);
  for (const Matrix3Xd& part : parts) {
    const auto n = static_cast<std::uint64_t>(part.cols());
    append(rest, &n, 1);
    append(rest, part.data(), static_cast<std::size_t>(part.size()));
  }
  return fmt::format("{}{}\n{}\n", kHeader, key, core::sha256(rest)) + rest;
}

/// nullopt when the file is not there, damaged, of another version or of another mesh.
std::optional<std::vector<Matrix3Xd>> read_parts(const fs::path& file, std::string_view key) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::size_t start = kHeader.size() + 2 * (kDigits + 1);
  if (bytes.size() < start || !bytes.starts_with(kHeader)) return std::nullopt;
  std::string_view rest = std::string_view(bytes).substr(start);
  const std::string expected = fmt::format("{}{}\n{}\n", kHeader, key, core::sha256(rest));
  if (!bytes.starts_with(expected)) return std::nullopt;

  const auto take = [&](void* into, std::size_t size) {
    if (rest.size() < size) return false;
    std::memcpy(into, rest.data(), size);
    rest.remove_prefix(size);
    return true;
  };
  std::uint64_t count = 0, n = 0;
  if (!take(&count, sizeof count)) return std::nullopt;
  std::vector<Matrix3Xd> parts;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!take(&n, sizeof n) || n > kMaxPoints) return std::nullopt;
    Matrix3Xd part(3, static_cast<Eigen::Index>(n));
    if (!take(part.data(), n * 3 * sizeof(double))) return std::nullopt;
    parts.push_back(std::move(part));
  }
  if (!rest.empty()) return std::nullopt;
  return parts;
}

/// The library moves the surface by some 1e-4 of its size where it cuts. Corners that were there before go back to where they were, so
/// that faces of the mesh stay flat and in their place.
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

/// Hulls of the parts. A part without a volume is a sliver of a cut and is left out.
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

fs::path default_cache_dir() {
  const auto folder = [](const char* variable, const char* below) {
    const char* value = std::getenv(variable);
    const fs::path path = value != nullptr ? value : "";
    return path.is_absolute() ? path / below : fs::path();  // as the XDG specification has it, relative ones do not count
  };
  const fs::path xdg = folder("XDG_CACHE_HOME", "stiction");
  return xdg.empty() ? folder("HOME", ".cache/stiction") : xdg;
}

/// Under a name of its own first, so that a reader never sees half a file.
void store_in_cache(const fs::path& file, const std::string& bytes) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return;
  const fs::path part = fmt::format("{}.{}.part", file.string(), ::getpid());
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out << bytes;
    out.close();
    if (out) fs::rename(part, file, error);
    if (out && !error) return;
  }
  fs::remove(part, error);
}

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
  if (!file.empty()) store_in_cache(file, write_parts(key, parts));
  return hulls;
}

}  // namespace stiction::world
