#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "stiction/sensing/known_contacts.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/read.hpp"

namespace stiction::bench {

struct Arm {
  std::string name, urdf;
};
inline const Arm kUr5 = {"ur5", "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"};
inline const Arm kPanda = {"panda", "package://example-robot-data/robots/panda_description/urdf/panda.urdf"};
inline const Arm kCapsules = {"iiwa of capsules", "models/iiwa_primitives.urdf"};
inline const Arm kMeshes = {"iiwa", "models/iiwa_meshes.urdf"};

/// Whether `make experiments` unpacked the meshes of the iiwa.
inline bool has_iiwa_meshes() {
  return std::filesystem::exists(std::filesystem::path(STICTION_PACKAGE_DIR) / "iiwa_description" / "iiwa7" / "link_6.obj");
}

/// The iiwa of meshes where there are any.
inline const Arm& best_iiwa() { return has_iiwa_meshes() ? kMeshes : kCapsules; }

/// Those that are measured; the iiwa of capsules last.
inline std::vector<Arm> list_arms() {
  std::vector<Arm> out{kUr5, kPanda};
  if (has_iiwa_meshes()) out.push_back(kMeshes);
  out.push_back(kCapsules);
  return out;
}

/// Models are read once, and hidden faces found once.
inline std::shared_ptr<const sensing::Sensor> make_sensor(const Arm& arm, sensing::SensorOptions options) {
  static std::map<std::string, std::shared_ptr<const world::Model>> models;
  const std::vector<std::filesystem::path> packages{STICTION_PACKAGE_DIR};
  auto& model = models[arm.urdf];
  if (!model)
    model =
        world::Model::make(world::parse_scene(fmt::format("robots: [{{name: arm, urdf: '{}'}}]", arm.urdf), STICTION_SOURCE_DIR, packages));
  options.surface.cache_dir = world::default_cache_dir();
  return sensing::Sensor::make(model, options);
}

/// Links behind at least so many joints, as indices into Sensor::links().
inline std::vector<int> links_behind(const sensing::Sensor& sensor, int joints) {
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(sensor.links().size()); ++i)
    if (sensor.links()[static_cast<std::size_t>(i)].joints >= joints) out.push_back(i);
  return out;
}

}  // namespace stiction::bench
