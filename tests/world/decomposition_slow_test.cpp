#include "stiction/world/decomposition.hpp"
#include "world/convex_parts.hpp"
#include "world/mesh_files.hpp"

// A closed cavity needs six convex parts around it at least, and every cut costs the library about a second.

namespace stiction::world {
namespace {

using DecomposeSlow = test::MeshFiles;

TEST_F(DecomposeSlow, Hollow_StaysHollow) {
  const test::ObjMesh mesh = test::make_hollow_box();
  const auto parts = load_mesh(write("hollow.obj", mesh.text()), Eigen::Vector3d::Ones(), {NonConvex::Decompose, {}}).parts;
  EXPECT_GE(parts.size(), 4u);
  EXPECT_GT(test::outside(parts, Eigen::Vector3d::Zero()), 0.5);
  EXPECT_NEAR(test::volume_of(parts), mesh.volume(), 0.05 * mesh.volume());
}

}  // namespace
}  // namespace stiction::world
