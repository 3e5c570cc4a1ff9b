#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>
#include "support/environment.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world::test {

/// Vertices and triangles, from 0.
struct ObjMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;

  std::string text() const {
    std::string out;
    for (const auto& v : vertices) out += "v " + std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]) + "\n";
    for (const auto& t : triangles)
      out += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    return out;
  }

  /// Vertices and triangles of another one besides.
  void append(const ObjMesh& other) {
    const auto n = static_cast<int>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles) triangles.emplace_back(t.array() + n);
  }

  /// Wound the other way.
  void turn_inside_out() {
    for (auto& t : triangles) std::swap(t[0], t[1]);
  }

  double volume() const {
    double sum = 0;
    for (const auto& t : triangles)
      sum += vertices[static_cast<std::size_t>(t[0])].dot(
                 vertices[static_cast<std::size_t>(t[1])].cross(vertices[static_cast<std::size_t>(t[2])])) /
             6;
    return sum;
  }
};

inline ObjMesh make_block(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  ObjMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back((i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A cube of edge 2 about the origin with one of edge 1.2 taken out.
inline ObjMesh make_hollow_box() {
  ObjMesh inner = make_block(Eigen::Vector3d::Constant(-0.6), Eigen::Vector3d::Constant(0.6));
  inner.turn_inside_out();
  ObjMesh mesh = make_block(Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Constant(1));
  mesh.append(inner);
  return mesh;
}

/// 2 × 2 × 1 with the corner [1, 2] × [1, 2] taken out: volume 3.
inline ObjMesh make_l_prism() {
  constexpr double kOutline[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  ObjMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : kOutline) mesh.vertices.emplace_back(p[0], p[1], z);
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.emplace_back(a, c, b);
    mesh.triangles.emplace_back(a + 6, b + 6, c + 6);
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.emplace_back(i, j, j + 6);
    mesh.triangles.emplace_back(i, j + 6, i + 6);
  }
  return mesh;
}

/// A ring about z: circle of `tube` sides and radius 0.3 around a circle of `around` sides and radius 1.
inline ObjMesh make_ring(int around, int tube) {
  using std::numbers::pi;
  ObjMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / tube, r = 1 + 0.3 * std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), 0.3 * std::sin(b));
    }
  }
  const auto index = [&](int i, int j) { return (i % around) * tube + j % tube; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j), index(i + 1, j + 1));
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i, j + 1));
    }
  }
  return mesh;
}

/// A folder for every test, removed at the end, in which the cache lies too.
class MeshFiles : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(dir_ / name, std::ios::binary) << text;
    return dir_ / name;
  }

  static std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  /// The text without the name of the folder.
  std::string local(std::string text) const {
    const std::string prefix = dir_.string() + "/";
    for (auto at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) text.erase(at, prefix.size());
    return text;
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
  const stiction::test::EnvironmentVariable own_cache_{"STICTION_CACHE", nullptr};
  const stiction::test::EnvironmentVariable xdg_cache_{"XDG_CACHE_HOME", (dir_ / "cache").c_str()};
};

}  // namespace stiction::world::test
