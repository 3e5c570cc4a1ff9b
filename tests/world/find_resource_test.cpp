// Spellings of the names of files, as URDFs of all kinds of programs have them.
#include <gtest/gtest.h>

#include "stiction/world/urdf.hpp"
#include "world/robot_files.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

class FindResource : public testing::Test {
 protected:
  void SetUp() override {
    mesh_ = folder_.write(fs::path("My Robots (v2)") / "größe" / "meshes" / "tip part.stl", "mesh");
    base_ = mesh_.parent_path().parent_path();
    fs::create_symlink(mesh_, base_ / "link.stl");
  }

  static std::string encode(std::string text) {
    for (const auto& [from, to] : {std::pair<std::string, std::string>{" ", "%20"}, {"(", "%28"}, {"ö", "%c3%B6"}, {"ß", "%C3%9f"}}) {
      for (auto at = text.find(from); at != std::string::npos; at = text.find(from)) text.replace(at, from.size(), to);
    }
    return text;
  }

  bool finds(const std::string& uri, const std::vector<fs::path>& packages = {}) const {
    const fs::path found = find_resource(uri, base_, packages);
    return !found.empty() && fs::equivalent(found, mesh_);
  }

  const RobotFolder folder_{};
  fs::path mesh_{}, base_{};
};

TEST_F(FindResource, FindsOneFileByAllOfItsSpellings) {
  const std::string absolute = mesh_.string();
  for (const std::string& uri :
       {absolute, "file://" + absolute, "file:" + absolute, "file://localhost" + absolute, "file://" + encode(absolute), encode(absolute),
        std::string("meshes/tip part.stl"), std::string("meshes/tip%20part.stl"), std::string("./meshes/../meshes/tip part.stl"),
        std::string("file://meshes/tip part.stl"), std::string("meshes\\tip part.stl"), std::string("link.stl"),
        std::string("package://größe/meshes/tip part.stl"), std::string("package:///gr%C3%B6%C3%9Fe/meshes/tip%20part.stl"),
        std::string("package://größe\\meshes\\tip part.stl"), std::string("model://größe/meshes/tip part.stl")})
    EXPECT_TRUE(finds(uri)) << uri;
}

TEST_F(FindResource, FileWhoseNameIsAsWritten_GoesFirst) {
  const fs::path literal = folder_.write(fs::path("My Robots (v2)") / "größe" / "meshes" / "tip%20part.stl", "other");
  EXPECT_TRUE(fs::equivalent(find_resource("meshes/tip%20part.stl", base_, {}), literal));
  EXPECT_TRUE(finds("meshes/tip part.stl"));
}

TEST_F(FindResource, PackagesAreFoundInTheFoldersGiven) {
  const fs::path elsewhere = folder_.path();
  EXPECT_TRUE(find_resource("package://größe/meshes/tip part.stl", elsewhere, {}).empty());
  EXPECT_FALSE(find_resource("package://größe/meshes/tip part.stl", elsewhere, std::vector{base_.parent_path()}).empty());
}

TEST_F(FindResource, WhatIsNowhereIsEmpty) {
  for (const char* uri : {"", "package://", "package:///", "file://", "meshes", "meshes/tip%2", "meshes/tip%zzpart.stl", "meshes/%00",
                          "package://none/tip.stl", "http://host/tip.stl"})
    EXPECT_TRUE(find_resource(uri, base_, {}).empty()) << uri;
}

}  // namespace
}  // namespace stiction::world::test
