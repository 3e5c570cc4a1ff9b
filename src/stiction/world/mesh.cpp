#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/decomposition.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/hull_cache.hpp"
#include "stiction/world/mesh_contents.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/simplify_hull.hpp"

// Included last, because its macros clash with other headers.
extern "C" {
#include <libqhull_r/libqhull_r.h>
}

namespace stiction::world {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr double kConvexTolerance = 0.01;  ///< largest share of its hull that a convex mesh does not fill
constexpr double kLeastShare = 1e-6;       ///< least share of the hull; a mesh with less is a surface folded onto itself
constexpr std::string_view kHullKeys = "with convex_hull of the shape or convex_hulls of the robot";

/// Triangles as triples of points (3 × 3n), as read.
using Soup = std::vector<Vector3d>;

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mesh: got {}, expected {}", file.string(), got, expected));
}

/// A mesh file, which is opened once.
struct MeshFile {
  std::string extension;  ///< in lower case, with its dot
  std::string bytes;
};

/// Gives Assimp the bytes of one file and no other file. Assimp itself would open the file twice, and material files as well.
class OneFile final : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::string& bytes) : name_(std::move(name)), bytes_(bytes) {}
  bool Exists(const char* name) const override { return name_ == name; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override {
    return Exists(name) ? new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size()) : nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string name_;
  const std::string& bytes_;
};

/// Triangles of an STL, OBJ or DAE file, in the frame of the file; empty when there are none.
Soup read_triangles(const std::filesystem::path& file, const std::string& bytes) {
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(file.string(), bytes));  // the importer deletes it
  // Points and lines are no surface: leave them out.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // Keep the coordinates of the file, as Coal and ROS tools do: <up_axis> only tells a viewer how to show them.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);  // Assimp would draw the nodes of a file without triangles
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (scene == nullptr) fail(file, fmt::format("a file that cannot be read ({})", importer.GetErrorString()), "a mesh");
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      if (mesh.mFaces[f].mNumIndices != 3) continue;
      for (unsigned k = 0; k < 3; ++k) {
        const unsigned index = mesh.mFaces[f].mIndices[k];
        if (index >= mesh.mNumVertices)
          fail(file, fmt::format("a face with vertex {}", index), fmt::format("indices below {}", mesh.mNumVertices));
        const aiVector3D& p = mesh.mVertices[index];
        soup.emplace_back(p.x, p.y, p.z);
      }
    }
  }
  return soup;
}

MeshFile read_file(const std::filesystem::path& file, const Vector3d& scale) {
  if (!std::filesystem::is_regular_file(file)) fail(file, "a file that does not exist", "an STL, OBJ or DAE file");
  if (!scale.allFinite() || scale.cwiseAbs().minCoeff() <= 0) fail(file, "a scale that is 0 or not finite", "three numbers other than 0");
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".stl" && extension != ".obj" && extension != ".dae") fail(file, fmt::format("'{}'", extension), ".stl, .obj or .dae");
  MeshFile out{std::move(extension), read_bytes(file)};
  require_mesh_contents(file, out.bytes);
  return out;
}

/// Corners of the triangles (3 × 3n), scaled.
Matrix3Xd read_points(const std::filesystem::path& file, const MeshFile& contents, const Vector3d& scale) {
  const Soup soup = read_triangles(file, contents.bytes);
  if (soup.size() < 12) fail(file, fmt::format("{} triangles", soup.size() / 3), "a closed convex mesh");
  Matrix3Xd points(3, static_cast<Eigen::Index>(soup.size()));
  for (std::size_t i = 0; i < soup.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = soup[i].cwiseProduct(scale);
  if (!points.allFinite()) fail(file, "a vertex that is not finite", "finite vertices");
  return points;
}

/// Signed volume of closed triangles: positive if they wind outwards.
double calc_soup_volume(const Matrix3Xd& points, const Vector3d& reference) {
  double volume = 0;
  for (Eigen::Index i = 0; i + 2 < points.cols(); i += 3) {
    volume += (points.middleCols<3>(i).colwise() - reference).determinant() / 6;
  }
  return volume;
}

struct Surface {
  Matrix3Xd vertices;  ///< each point once, in the order of the coordinates
  Eigen::Matrix3Xi triangles;
};

/// Merges equal points, since files repeat a point for every triangle (STL) or normal. Triangles with two equal corners are removed, which keeps
/// a closed surface closed. @param inside_out  true: reverse the triangles
Surface weld(const Matrix3Xd& points, bool inside_out) {
  struct Corner {
    std::array<double, 3> point;
    Eigen::Index number;
  };
  std::vector<Corner> corners(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    corners[static_cast<std::size_t>(i)] = {{points(0, i) + 0.0, points(1, i) + 0.0, points(2, i) + 0.0}, i};  // −0 → 0
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.point < b.point; });
  Surface out;
  out.vertices.resize(3, points.cols());
  std::vector<int> vertex_of(corners.size());
  int n = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners[i].point != corners[i - 1].point) out.vertices.col(n++) = Eigen::Map<const Vector3d>(corners[i].point.data());
    vertex_of[static_cast<std::size_t>(corners[i].number)] = n - 1;
  }
  out.vertices.conservativeResize(3, n);
  std::vector<Eigen::Vector3i> triangles;
  for (std::size_t i = 0; i + 2 < vertex_of.size(); i += 3) {
    Eigen::Vector3i t(vertex_of[i], vertex_of[i + 1], vertex_of[i + 2]);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    if (inside_out) std::swap(t[1], t[2]);
    triangles.push_back(t);
  }
  out.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) out.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
  return out;
}

/// Checks that every edge has as many triangles on one side as on the other.
void require_closed(const std::filesystem::path& file, const Surface& surface) {
  struct Uses {
    int forward = 0, backward = 0;
  };
  std::map<std::pair<int, int>, Uses> edges;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = surface.triangles(k, t), b = surface.triangles((k + 1) % 3, t);
      Uses& uses = edges[std::minmax(a, b)];
      ++(a < b ? uses.forward : uses.backward);
    }
  }
  const auto open =
      std::count_if(edges.begin(), edges.end(), [](const auto& e) { return (e.second.forward + e.second.backward) % 2 != 0; });
  if (open > 0) {
    fail(file, fmt::format("an open mesh that is not convex: {} of {} edges have a triangle on one side only", open, edges.size()),
         fmt::format("a closed mesh (or its hull, {})", kHullKeys));
  }
  const auto turned = std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second.forward != e.second.backward; });
  if (turned > 0) {
    fail(file, fmt::format("triangles that wind against each other at {} of {} edges", turned, edges.size()),
         fmt::format("normals that all point outwards (or its hull, {})", kHullKeys));
  }
}

/// Splits a surface into parts that are connected by vertices, in the order of their first vertices.
std::vector<Surface> split(const Surface& surface) {
  std::vector<int> parent(static_cast<std::size_t>(surface.vertices.cols()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const auto& t : surface.triangles.colwise()) {
    for (int k = 1; k < 3; ++k) {
      const int a = root(t[0]), b = root(t[k]);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  std::map<int, std::vector<Eigen::Index>> triangles;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) triangles[root(surface.triangles(0, t))].push_back(t);
  if (triangles.size() == 1) return {surface};
  std::vector<Surface> out;
  for (const auto& [first, mine] : triangles) {
    Matrix3Xd points(3, 3 * static_cast<Eigen::Index>(mine.size()));
    for (std::size_t i = 0; i < mine.size(); ++i)
      points.middleCols<3>(3 * static_cast<Eigen::Index>(i)) = surface.vertices(Eigen::all, surface.triangles.col(mine[i]));
    out.push_back(weld(points, false));
  }
  return out;
}

/// Runs qhull, and frees its memory in all cases.
class Qhull {
 public:
  explicit Qhull(std::vector<double>& points) {
    qh_zero(&qh_, stderr);
    sink_ = std::tmpfile();  // qhull prints its messages; they are discarded
    char options[] = "qhull Qt Pp";
    status_ = qh_new_qhull(&qh_, 3, static_cast<int>(points.size() / 3), points.data(), false, options, nullptr, sink_);
  }
  ~Qhull() {
    qh_freeqhull(&qh_, !qh_ALL);
    int current = 0, total = 0;
    qh_memfreeshort(&qh_, &current, &total);
    if (sink_ != nullptr) std::fclose(sink_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  bool good() const { return status_ == 0; }

  ConvexMesh mesh() {
    std::map<int, int> index;  // qhull point → vertex, in point order so that the result is the same every time
    const vertexT* vertex = nullptr;
    for (vertex = qh_.vertex_list; vertex != nullptr && vertex->next != nullptr; vertex = vertex->next) {
      index[qh_pointid(&qh_, vertex->point)] = 0;
    }
    ConvexMesh mesh;
    mesh.vertices.resize(3, static_cast<Eigen::Index>(index.size()));
    int n = 0;
    for (auto& [point, position] : index) {
      mesh.vertices.col(n) = Eigen::Map<const Vector3d>(qh_.first_point + 3 * point);
      position = n++;
    }
    std::vector<Eigen::Vector3i> triangles;
    const Vector3d inside = mesh.vertices.rowwise().mean();
    for (const facetT* facet = qh_.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
      Eigen::Vector3i t;
      for (int k = 0; k < 3; ++k) t[k] = index.at(qh_pointid(&qh_, static_cast<vertexT*>(facet->vertices->e[k].p)->point));
      const Vector3d a = mesh.vertices.col(t[0]), b = mesh.vertices.col(t[1]), c = mesh.vertices.col(t[2]);
      if ((b - a).cross(c - a).dot(a - inside) < 0) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
    mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
    return mesh;
  }

 private:
  qhT qh_{};
  std::FILE* sink_ = nullptr;
  int status_ = 1;
};

}  // namespace

ConvexMesh make_convex_hull(const Matrix3Xd& points) {
  if (!points.allFinite()) core::throw_invalid("points", "a coordinate that is not finite", "finite points");
  if (points.cols() < 4) core::throw_invalid("points", fmt::format("{} points", points.cols()), "at least 4");
  std::vector<double> copy(points.data(), points.data() + points.size());
  Qhull hull(copy);
  if (!hull.good()) core::throw_invalid("points", "points in one plane or nearly so", "a body with a volume");
  return hull.mesh();
}

namespace {

struct Hull {
  ConvexMesh mesh;
  double share = 0;  ///< share of the hull's volume that the triangles enclose; negative if they wind inwards

  bool is_mesh() const { return std::abs(std::abs(share) - 1) <= kConvexTolerance; }
};

Hull calc_hull(const std::filesystem::path& file, const Matrix3Xd& points) {
  Hull out;
  try {
    out.mesh = make_convex_hull(points);
  } catch (const core::InvalidInput&) {
    fail(file, "a flat mesh", "a body with a volume");
  }
  out.mesh.source = file.string();
  const double volume = calc_volume_properties(Shape{Mesh{std::make_shared<const ConvexMesh>(out.mesh)}}).volume;
  out.share = calc_soup_volume(points, out.mesh.vertices.rowwise().mean()) / volume;
  return out;
}

/// Splits the solids of a file into convex parts. Files contain several solids that often overlap. Each is split separately, because the library
/// would first merge them into one surface on a grid, which moves faces by a percent of the size. If a surface bounds a hollow, the library has to
/// process all surfaces together.
std::vector<ConvexMesh> decompose_pieces(const std::filesystem::path& file, const Surface& surface, const Decomposition& options) {
  std::vector<Surface> pieces = split(surface);
  std::vector<Hull> hulls;
  for (const Surface& piece : pieces) hulls.push_back(calc_hull(file, piece.vertices(Eigen::all, piece.triangles.reshaped())));
  if (std::any_of(hulls.begin(), hulls.end(), [](const Hull& hull) { return hull.share < kLeastShare; })) {
    pieces = {surface};
    hulls.assign(1, Hull{});
  }
  std::vector<ConvexMesh> all;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (hulls[i].is_mesh()) {
      all.push_back(std::move(hulls[i].mesh));
      continue;
    }
    try {
      for (ConvexMesh& part : decompose(pieces[i].vertices, pieces[i].triangles, options, default_cache_dir()))
        all.push_back(std::move(part));
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(fmt::format("{}: {}", file.string(), e.what()));
    }
  }
  for (ConvexMesh& part : all) part.source = file.string();
  return all;
}

/// The solids of a file if all of them are convex, as in files of decomposition tools; else empty.
std::vector<ConvexMesh> take_hulls(const std::filesystem::path& file, const Surface& surface) {
  const std::vector<Surface> pieces = split(surface);
  std::vector<ConvexMesh> out;
  if (pieces.size() == 1) return out;
  for (const Surface& piece : pieces) {
    if (piece.triangles.cols() < 4) return {};
    try {
      Hull hull = calc_hull(file, piece.vertices(Eigen::all, piece.triangles.reshaped()));
      if (!hull.is_mesh()) return {};
      out.push_back(std::move(hull.mesh));
    } catch (const core::InvalidInput&) {  // flat
      return {};
    }
  }
  return out;
}

}  // namespace

std::string part_name(const std::string& name, std::size_t k, std::size_t parts) {
  return parts == 1 ? name : fmt::format("{}/part_{}", name, k);
}

namespace {

LoadedMesh make_parts(const std::filesystem::path& file, const Matrix3Xd& points, const MeshOptions& options) {
  Hull whole = calc_hull(file, points);
  LoadedMesh out;
  if (whole.is_mesh() || options.non_convex == NonConvex::TakeHull) {
    out.parts.push_back(std::move(whole.mesh));
    return out;
  }
  const Surface surface = weld(points, whole.share < 0);
  if (options.non_convex == NonConvex::TakeHulls) {
    out.parts = take_hulls(file, surface);
    out.filled = out.parts.empty();
    if (out.filled) out.parts.push_back(std::move(whole.mesh));
    return out;
  }
  require_closed(file, surface);
  if (std::abs(whole.share) < kLeastShare) fail(file, "a mesh that encloses no volume", "a body with a volume");
  out.parts = decompose_pieces(file, surface, options.decomposition);
  return out;
}

LoadedMesh make_simplified_parts(const std::filesystem::path& file, const Matrix3Xd& points, const MeshOptions& options) {
  LoadedMesh out = make_parts(file, points, options);
  if (options.tolerance == 0) return out;
  for (ConvexMesh& part : out.parts) {
    SimplifiedHull hull = simplify_hull_by_share(part, options.tolerance);
    out.error = std::max(out.error, hull.error);
    part = std::move(hull.mesh);
  }
  return out;
}

/// Describes all inputs of the hulls other than the bytes of the file and the code of this library.
std::string say_how(const MeshFile& contents, const Vector3d& scale, const MeshOptions& options) {
  return fmt::format("assimp {}.{}.{}.{:x} qhull {} file {} scale {:a} {:a} {:a} non-convex {} tolerance {:a}", aiGetVersionMajor(),
                     aiGetVersionMinor(), aiGetVersionPatch(), aiGetVersionRevision(), qh_version, contents.extension, scale[0], scale[1],
                     scale[2], static_cast<int>(options.non_convex), options.tolerance);
}

}  // namespace

LoadedMesh load_mesh(const std::filesystem::path& file, const Vector3d& scale, const MeshOptions& options) {
  const MeshFile contents = read_file(file, scale);
  const auto points = std::make_shared<const Matrix3Xd>(read_points(file, contents, scale));
  const auto make = [&] { return make_simplified_parts(file, *points, options); };
  const std::filesystem::path folder = options.non_convex == NonConvex::Decompose ? std::filesystem::path() : hull_cache_dir();
  LoadedMesh out =
      folder.empty() ? make() : find_or_make_hulls(folder, calc_hull_key(contents.bytes, say_how(contents, scale, options)), make);
  for (ConvexMesh& part : out.parts) {
    part.source = file.string();
    part.surface = points;
  }
  return out;
}

}  // namespace stiction::world
