#include "sensing/robots.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "stiction/world/read.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::sensing::test {

namespace fs = std::filesystem;

std::shared_ptr<const world::Model> make_robot(const std::string& urdf) {
  const stiction::test::TemporaryFolder folder;
  const fs::path& dir = folder.path();
  std::ofstream(dir / "robot.urdf") << urdf;
  auto model = world::Model::make(world::parse_scene("robots: [{name: robot, urdf: robot.urdf}]", dir));
  return model;
}

std::shared_ptr<const world::Model> make_arm(const std::string& urdf) {
  const std::vector<fs::path> packages{stiction::test::package_dir()};
  return world::Model::make(world::parse_scene("robots: [{name: arm, urdf: '" + urdf + "'}]", stiction::test::source_dir(), packages));
}

int body_index(const world::Model& model, std::string_view name) {
  for (std::size_t i = 0; i < model.bodies().size(); ++i)
    if (model.bodies()[i].name == name) return static_cast<int>(i);
  ADD_FAILURE() << "no body " << name;
  return -1;
}

}  // namespace stiction::sensing::test
