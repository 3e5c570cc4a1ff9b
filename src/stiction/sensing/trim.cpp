#include "stiction/sensing/trim.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "stiction/core/sha256.hpp"
#include "stiction/world/cache_file.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

enum Face : char {
  kFlatFace = 'f',
  kHidden = 'h',
  kKept = 'k',
  kTurned = 't'
};
constexpr std::string_view kHeader = "stiction faces 1\n";

Face classify(const Matrix3Xd& corners, Index t, int body, const Visibility* visibility, double size) {
  constexpr double kFlat = 1e-12;  // share of the squared size: an area that rounding makes
  const double lift = 1e-6 * size;
  const Vector3d area = calc_area_vector(corners, t);
  if (!(area.norm() > kFlat * size * size)) return kFlatFace;
  if (visibility == nullptr) return kKept;
  const Vector3d n = area.normalized(), center = corners.middleCols<3>(3 * t).rowwise().mean();
  if (visibility->is_seen(body, center, n, lift)) return kKept;
  for (int k = 0; k < 3; ++k)
    if (visibility->is_seen(body, center + 0.9 * (corners.col(3 * t + k) - center), n, lift)) return kKept;
  return visibility->is_seen(body, center, -n, lift) ? kTurned : kHidden;
}

std::string classify_all(const Matrix3Xd& corners, int body, const Visibility* visibility) {
  const double size = calc_diagonal(corners);
  std::string out;
  for (Index t = 0; t < corners.cols() / 3; ++t) out += classify(corners, t, body, visibility, size);
  return out;
}

std::string with_header(const std::string& key, std::string_view faces) {
  return fmt::format("{}{}\n{}\n{}", kHeader, key, core::sha256(faces), faces);
}

/// Reads the cache; nullopt if the file is missing, damaged, of another version or of another robot.
std::optional<std::string> read_faces(const std::filesystem::path& file, const std::string& key, Index count) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto n = static_cast<std::size_t>(count);
  if (bytes.size() < n) return std::nullopt;
  std::string faces = bytes.substr(bytes.size() - n);
  if (bytes != with_header(key, faces)) return std::nullopt;
  return faces;
}

std::string find_faces(const Matrix3Xd& corners, int body, const Visibility* visibility, const std::filesystem::path& cache_dir) {
  if (visibility == nullptr || cache_dir.empty()) return classify_all(corners, body, visibility);
  const std::string key = core::sha256(fmt::format("{} {}", visibility->key(), body));
  const std::filesystem::path file = cache_dir / (key + ".faces");
  if (auto faces = read_faces(file, key, corners.cols() / 3)) return *std::move(faces);
  std::string faces = classify_all(corners, body, visibility);
  world::store_in_cache(file, with_header(key, faces));
  return faces;
}

}  // namespace

Vector3d calc_area_vector(const Matrix3Xd& corners, Index t) {
  const Vector3d a = corners.col(3 * t), b = corners.col(3 * t + 1), c = corners.col(3 * t + 2);
  return 0.5 * (b - a).cross(c - a);
}

double calc_diagonal(const Matrix3Xd& points) { return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm(); }

Trimmed trim(const Matrix3Xd& corners, int body, const Visibility* visibility, const std::filesystem::path& cache_dir) {
  const std::string faces = find_faces(corners, body, visibility, cache_dir);
  const auto count = [&](Face face) { return static_cast<int>(std::count(faces.begin(), faces.end(), face)); };
  Trimmed out;
  out.hidden = count(kHidden);
  out.turned = count(kTurned);
  out.flat = count(kFlatFace);
  out.corners.resize(3, 3 * (static_cast<Index>(faces.size()) - out.hidden - out.flat));
  Index at = 0;
  for (Index t = 0; t < corners.cols() / 3; ++t) {
    const char face = faces[static_cast<std::size_t>(t)];
    if (face == kHidden || face == kFlatFace) continue;
    const bool turn = face == kTurned;
    for (const int k : {0, turn ? 2 : 1, turn ? 1 : 2}) out.corners.col(at++) = corners.col(3 * t + k);
  }
  return out;
}

int count_open_edges(const Matrix3Xd& corners) {
  using Point = std::array<double, 3>;
  const auto point = [&](Index i) { return Point{corners(0, i), corners(1, i), corners(2, i)}; };
  std::vector<std::pair<Point, Point>> edges;
  for (Index t = 0; t < corners.cols() / 3; ++t) {
    for (Index k = 0; k < 3; ++k) {
      const Point a = point(3 * t + k), b = point(3 * t + (k + 1) % 3);
      if (a != b) edges.push_back(std::minmax(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  int open = 0;
  for (auto begin = edges.begin(); begin != edges.end();) {
    const auto end = std::find_if(begin, edges.end(), [&](const auto& edge) { return edge != *begin; });
    open += end - begin != 2;
    begin = end;
  }
  return open;
}

}  // namespace stiction::sensing
