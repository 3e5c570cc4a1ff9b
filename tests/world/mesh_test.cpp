// What a caller is told about a mesh that is open, degenerate or inconsistent, in a file or in memory.
#include <array>
#include <limits>
#include <string>

#include "stiction/world/model.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/visual_mesh.hpp"
#include "support/message_of.hpp"
#include "world/mesh_files.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector3d;
using stiction::test::message_of;

/// A COLLADA file of a box: x 0…0.2, y 0…0.4, z 0…0.6 m.
std::string collada_box(const std::string& up_axis) {
  std::string points, faces;
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) points += (i >> k & 1) != 0 ? std::to_string(0.2 * (k + 1)) + " " : "0 ";
  }
  for (int k = 0; k < 3; ++k) {
    const int u = 1 << (k + 1) % 3, v = 1 << (k + 2) % 3;
    for (const int at : {0, 1 << k}) {
      const int corner[] = {at, at | u, at | u | v, at | v};
      for (const auto& t : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        for (int j = 0; j < 3; ++j) faces += std::to_string(corner[t[static_cast<std::size_t>(at ? j : 2 - j)]]) + " ";
      }
    }
  }
  return "<?xml version='1.0' encoding='utf-8'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
         "<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified><unit name='meter' meter='1'/><up_axis>" +
         up_axis + "</up_axis></asset><library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a' count='24'>" + points +
         "</float_array><technique_common><accessor source='#a' count='8' stride='3'><param name='X' type='float'/><param name='Y' "
         "type='float'/><param name='Z' type='float'/></accessor></technique_common></source><vertices id='v'><input semantic='POSITION' "
         "source='#p'/></vertices><triangles count='12'><input semantic='VERTEX' source='#v' offset='0'/><p>" +
         faces +
         "</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'><node id='n' "
         "type='NODE'><instance_geometry url='#g'/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene "
         "url='#s'/></scene></COLLADA>";
}

class BadMesh : public test::MeshFiles {
 protected:
  std::string message(const std::string& obj, NonConvex non_convex = NonConvex::Decompose) {
    const auto file = write("a.obj", obj);
    return local(message_of([&] { load_mesh(file, Vector3d::Ones(), {non_convex, {}}); }));
  }
};

constexpr const char* kHull = "with convex_hull of the shape or convex_hulls of the robot)";

TEST_F(BadMesh, ColladaOfAnyUpAxis_KeepsTheNumbersOfTheFile) {
  for (const char* up_axis : {"X_UP", "Y_UP", "Z_UP"}) {
    const auto parts = load_mesh(write("a.dae", collada_box(up_axis)), Vector3d::Ones(), {NonConvex::Decompose, {}}).parts;
    ASSERT_EQ(parts.size(), 1u) << up_axis;
    EXPECT_LE((parts[0].vertices.rowwise().minCoeff() - Vector3d(0, 0, 0)).norm(), 1e-6) << up_axis;  // Assimp keeps floats
    EXPECT_LE((parts[0].vertices.rowwise().maxCoeff() - Vector3d(0.2, 0.4, 0.6)).norm(), 1e-6) << up_axis;
  }
}

/// Assimp would make a skeleton of the nodes, and its hull would be a body.
TEST_F(BadMesh, ColladaWithoutTriangles_IsNoMesh) {
  std::string text = collada_box("Z_UP"), nodes;
  for (const char* place : {"1 0 0", "0 1 0", "0 0 1", "1 1 1"}) nodes += std::string("<node><translate>") + place + "</translate></node>";
  const std::string instance = "<instance_geometry url='#g'/>";
  text.replace(text.find(instance), instance.size(), nodes);
  const auto file = write("a.dae", text);
  EXPECT_NE(message_of([&] { load_mesh(file, Vector3d::Ones(), {NonConvex::TakeHulls, {}}); }).find("mesh: got"), std::string::npos);
}

TEST_F(BadMesh, FilesThatAreNoMesh_AreNamedByWhatTheyAre) {
  const auto said = [&](const std::string& name, const std::string& bytes) {
    const auto file = write(name, bytes);
    return local(message_of([&] { load_mesh(file, Vector3d::Ones(), {NonConvex::TakeHulls, {}}); }));
  };
  for (const std::string name : {"a.stl", "a.obj", "a.dae"}) {
    EXPECT_EQ(said(name, "version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 2\n"),
              name + ": mesh: got a pointer of Git LFS, expected a mesh; `git lfs pull` fetches the file itself");
    EXPECT_EQ(said(name, "<!DOCTYPE html>\n<html/>"), name + ": mesh: got a web page, expected a mesh; download the file itself");
  }
  std::string stl(84 + 2 * 50, '\0');
  stl[80] = 3;
  EXPECT_EQ(said("a.stl", stl),
            "a.stl: mesh: got a binary STL of 184 bytes that states 3 triangles, expected 234 bytes; the file may be cut off");
}

/// Assimp would read the first wrong index until the memory is full.
TEST_F(BadMesh, ColladaWithIndicesThatAreNoNumbers_IsRefused) {
  for (const char* wrong : {"0>", "0.5", "x", "0,"}) {
    std::string text = collada_box("Z_UP");
    text.insert(text.find("<p>") + 3, wrong + std::string(" "));
    const auto file = write("a.dae", text);
    const std::string said = local(message_of([&] { load_mesh(file, Vector3d::Ones(), {NonConvex::TakeHulls, {}}); }));
    EXPECT_NE(said.find("among the indices of its triangles, expected whole numbers"), std::string::npos) << said;
    EXPECT_EQ(local(message_of([&] { (void)load_visual_mesh(file, Vector3d::Ones()); })), said);
  }
}

TEST_F(BadMesh, Open_SaysHowManyEdges) {
  test::ObjMesh mesh = test::make_l_prism();
  mesh.triangles.erase(mesh.triangles.begin() + 1);
  EXPECT_EQ(message(mesh.text()),
            std::string("a.obj: mesh: got an open mesh that is not convex: 3 of 30 edges have a triangle on one side only, expected a "
                        "closed mesh (or its hull, ") +
                kHull);
  EXPECT_EQ(message(mesh.text(), NonConvex::TakeHull), "no exception");
  EXPECT_EQ(message(mesh.text(), NonConvex::TakeHulls), "no exception");
}

TEST_F(BadMesh, TrianglesThatWindAgainstEachOther_AreCounted) {
  test::ObjMesh mesh = test::make_l_prism();
  std::swap(mesh.triangles[2][0], mesh.triangles[2][1]);
  EXPECT_EQ(
      message(mesh.text()),
      std::string("a.obj: mesh: got triangles that wind against each other at 3 of 30 edges, expected normals that all point outwards "
                  "(or its hull, ") +
          kHull);
}

TEST_F(BadMesh, InsideOutRepeatedAndCollapsed_AreTaken) {
  const double volume = 3;
  test::ObjMesh mesh = test::make_l_prism();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);  // inside out
  mesh.vertices.push_back(mesh.vertices[0]);             // the point of corner 0 again …
  for (int k = 0; k < 3; ++k) {
    if (mesh.triangles[0][k] == 0) mesh.triangles[0][k] = 12;
  }
  mesh.triangles.emplace_back(0, 12, 5);  // … and a triangle without an area
  const auto parts = load_mesh(write("a.obj", mesh.text()), Vector3d::Ones(), {NonConvex::Decompose, {}}).parts;
  double sum = 0;
  for (const auto& part : parts) sum += calc_volume_properties(Mesh{std::make_shared<const ConvexMesh>(part)}).volume;
  EXPECT_NEAR(sum, volume, 0.01);
}

TEST_F(BadMesh, ConvexSolids_AreTheirHullsAndOthersOneHullThatFillsThem) {
  test::ObjMesh blocks = test::make_block({0, 0, 0}, {1, 1, 1});
  blocks.append(test::make_block({2, 0, 0}, {3, 1, 1}));
  const auto load = [&](const test::ObjMesh& mesh, NonConvex choice) {
    return load_mesh(write("a.obj", mesh.text()), Vector3d::Ones(), {choice, {}});
  };
  const auto volume = [](const LoadedMesh& mesh) {
    double sum = 0;
    for (const auto& part : mesh.parts) sum += calc_volume_properties(Mesh{std::make_shared<const ConvexMesh>(part)}).volume;
    return sum;
  };
  const LoadedMesh two = load(blocks, NonConvex::TakeHulls), one = load(blocks, NonConvex::TakeHull);
  EXPECT_EQ(two.parts.size(), 2u);
  EXPECT_FALSE(two.filled);
  EXPECT_NEAR(volume(two), 2, 1e-9);
  EXPECT_EQ(one.parts.size(), 1u);
  EXPECT_NEAR(volume(one), 3, 1e-9);
  test::ObjMesh hollow = test::make_l_prism();
  hollow.append(test::make_block({5, 0, 0}, {6, 1, 1}));
  const LoadedMesh filled = load(hollow, NonConvex::TakeHulls);
  EXPECT_EQ(filled.parts.size(), 1u);
  EXPECT_TRUE(filled.filled);
  EXPECT_FALSE(load(test::make_block({0, 0, 0}, {1, 1, 1}), NonConvex::TakeHulls).filled);
}

TEST_F(BadMesh, WithoutAVolume_IsNamed) {
  EXPECT_EQ(message("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"),
            "a.obj: mesh: got a flat mesh, expected a body with a volume");
  // Every face of a tetrahedron with its other side, so that nothing is inside.
  EXPECT_EQ(message("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 2\nf 1 2 4\nf 1 4 2\n"),
            "a.obj: mesh: got a mesh that encloses no volume, expected a body with a volume");
}

TEST_F(BadMesh, NumbersThatAreNot_AreNamed) {
  EXPECT_EQ(message("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"),
            "a.obj: mesh: got a vertex that is not finite, expected finite vertices");
  EXPECT_EQ(message("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 9\nf 2 3 4\nf 1 3 4\n"),
            "a.obj: mesh: got a file that cannot be read (OBJ: vertex index out of range), expected a mesh");
}

TEST_F(BadMesh, InMemory_IsCheckedByTheModel) {
  const ConvexMesh good = make_convex_hull((Eigen::Matrix3Xd(3, 4) << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1).finished());
  const auto of = [&](auto&& change) {
    ConvexMesh mesh = good;
    mesh.source = "a.stl";
    change(mesh);
    Scene scene;
    scene.fixed.push_back({.name = "rock", .X_WB = {}, .geometries = {}});
    scene.fixed[0].geometries.push_back({.name = "m", .shape = Mesh{std::make_shared<const ConvexMesh>(mesh)}, .X_BG = {}});
    return message_of([&] { Model::make(scene); });
  };
  EXPECT_EQ(of([](ConvexMesh&) {}), "no exception");
  EXPECT_EQ(of([](ConvexMesh& m) { m.triangles(1, 2) = 4; }),
            "fixed[0]: m.mesh (a.stl): got triangle 2 with vertex 4, expected vertices 0 to 3");
  EXPECT_EQ(of([](ConvexMesh& m) { m.triangles(1, 2) = -1; }),
            "fixed[0]: m.mesh (a.stl): got triangle 2 with vertex -1, expected vertices 0 to 3");
  EXPECT_EQ(of([](ConvexMesh& m) { m.vertices(0, 3) = std::numeric_limits<double>::quiet_NaN(); }),
            "fixed[0]: m.mesh (a.stl): got vertex 3 that is not finite, expected finite vertices");
  EXPECT_EQ(of([](ConvexMesh& m) { m.vertices.col(3) = m.vertices.col(1); }).substr(0, 60),
            "fixed[0]: m.mesh (a.stl): got vertex 3 at the point (1, 0, 0");
  EXPECT_EQ(of([](ConvexMesh& m) { m.vertices.row(2).setZero(), m.vertices(0, 3) = 2, m.vertices(0, 0) = -1; }),
            "fixed[0]: m.mesh (a.stl): got volume 0, expected a volume > 0 (triangles that wind outwards)");
  EXPECT_EQ(of([](ConvexMesh& m) { m.triangles.row(0).swap(m.triangles.row(1)); }),
            "fixed[0]: m.mesh (a.stl): got volume -0.167, expected a volume > 0 (triangles that wind outwards)");
}

}  // namespace
}  // namespace stiction::world
