#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/shapes.hpp"

// After the others: its macros are not shy.
extern "C" {
#include <libqhull_r/libqhull_r.h>
}

namespace stiction::world {

using Eigen::Vector3d;

namespace {

/// Triangles as triples of points (3 × 3n), as read.
using Soup = std::vector<Vector3d>;

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mesh: got {}, expected {}", file.string(), got, expected));
}

/// Triangles of an STL, OBJ or DAE file, in the frame of the file; empty when there are none.
Soup read_triangles(const std::filesystem::path& file) {
  Assimp::Importer importer;
  // Points and lines are no surface: leave them out.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (scene == nullptr) fail(file, fmt::format("a file that cannot be read ({})", importer.GetErrorString()), "a mesh");
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      if (mesh.mFaces[f].mNumIndices != 3) continue;
      for (unsigned k = 0; k < 3; ++k) {
        const aiVector3D& p = mesh.mVertices[mesh.mFaces[f].mIndices[k]];
        soup.emplace_back(p.x, p.y, p.z);
      }
    }
  }
  return soup;
}

double calc_soup_volume(const Eigen::Matrix3Xd& points, const Vector3d& reference) {
  double volume = 0;
  for (Eigen::Index i = 0; i + 2 < points.cols(); i += 3) {
    volume += (points.middleCols<3>(i).colwise() - reference).determinant() / 6;
  }
  return std::abs(volume);
}

/// Runs qhull and frees what it took, whatever happens.
class Qhull {
 public:
  explicit Qhull(std::vector<double>& points) {
    qh_zero(&qh_, stderr);
    sink_ = std::tmpfile();  // qhull reports by printing: nobody reads it
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

ConvexMesh make_convex_hull(const Eigen::Matrix3Xd& points) {
  if (!points.allFinite()) core::throw_invalid("points", "a coordinate that is not finite", "finite points");
  if (points.cols() < 4) core::throw_invalid("points", fmt::format("{} points", points.cols()), "at least 4");
  std::vector<double> copy(points.data(), points.data() + points.size());
  Qhull hull(copy);
  if (!hull.good()) core::throw_invalid("points", "points in one plane or nearly so", "a body with a volume");
  return hull.mesh();
}

ConvexMesh load_convex_mesh(const std::filesystem::path& file, const Vector3d& scale, NonConvex non_convex) {
  if (!std::filesystem::is_regular_file(file)) fail(file, "a file that does not exist", "an STL, OBJ or DAE file");
  if (!scale.allFinite() || scale.cwiseAbs().minCoeff() <= 0) fail(file, "a scale that is 0 or not finite", "three numbers other than 0");
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".stl" && extension != ".obj" && extension != ".dae") fail(file, fmt::format("'{}'", extension), ".stl, .obj or .dae");
  const Soup soup = read_triangles(file);
  if (soup.size() < 12) fail(file, fmt::format("{} triangles", soup.size() / 3), "a closed convex mesh");
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(soup.size()));
  for (std::size_t i = 0; i < soup.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = soup[i].cwiseProduct(scale);
  if (!points.allFinite()) fail(file, "a vertex that is not finite", "finite vertices");

  ConvexMesh hull;
  try {
    hull = make_convex_hull(points);
  } catch (const core::InvalidInput&) {
    fail(file, "a flat mesh", "a body with a volume");
  }
  const double hull_volume = calc_volume_properties(Shape{Mesh{std::make_shared<const ConvexMesh>(hull)}}).volume;
  const double volume = calc_soup_volume(points, hull.vertices.rowwise().mean());
  if (non_convex == NonConvex::Refuse && std::abs(hull_volume - volume) > 0.01 * hull_volume) {
    fail(file, fmt::format("a mesh that encloses {:.1f} % of its convex hull", 100 * volume / hull_volume),
         "a closed convex mesh (split it into convex parts, or ask for its hull)");
  }
  hull.source = file.string();
  return hull;
}

}  // namespace stiction::world
