// Every URDF of the package example-robot-data loads as it is, without a key beside its file.
#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

TEST(PublicRobots, OfExampleRobotData_LoadAsTheyAre) {
  const fs::path packages[] = {stiction::test::package_dir()};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(packages[0] / "example-robot-data" / "robots")) {
    if (entry.path().extension() == ".urdf") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 60u);
  std::string refused;
  std::size_t loaded = 0;
  for (const fs::path& file : files) {
    RobotSpec robot;
    robot.name = "robot";
    robot.urdf = file;
    robot.package_dirs = {packages[0]};
    Scene scene;
    scene.robots = {robot};
    try {
      const auto model = Model::make(scene);
      ++loaded;
      EXPECT_TRUE((model->stiffness().array() > 0).all()) << file;
      EXPECT_TRUE((model->lower().array() < model->upper().array()).all()) << file;
    } catch (const core::InvalidInput& e) {
      refused += std::string(e.what()) + "\n";
    }
  }
  RecordProperty("loaded", static_cast<int>(loaded));
  EXPECT_GE(69 * loaded, 66 * files.size()) << loaded << " of " << files.size() << "\n" << refused;
}

}  // namespace
}  // namespace stiction::world
