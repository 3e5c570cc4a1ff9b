#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "stiction/sensing/known_contacts.hpp"
#include "stiction/world/read.hpp"

namespace stiction::bench {

struct Arm {
  const char* name;
  const char* urdf;
};
inline constexpr Arm kArms[] = {{"ur5", "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"},
                                {"panda", "package://example-robot-data/robots/panda_description/urdf/panda.urdf"},
                                {"iiwa of capsules", "models/iiwa_primitives.urdf"}};

inline std::shared_ptr<const sensing::Sensor> make_sensor(const Arm& arm, int samples) {
  const std::vector<std::filesystem::path> packages{STICTION_PACKAGE_DIR};
  const auto scene = world::parse_scene(fmt::format("robots: [{{name: arm, urdf: '{}'}}]", arm.urdf), STICTION_SOURCE_DIR, packages);
  sensing::SensorOptions options;
  options.samples = samples;
  return sensing::Sensor::make(world::Model::make(scene), options);
}

/// Links behind at least so many joints, as indices into Sensor::links().
inline std::vector<int> links_behind(const sensing::Sensor& sensor, int joints) {
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(sensor.links().size()); ++i)
    if (sensor.links()[static_cast<std::size_t>(i)].joints >= joints) out.push_back(i);
  return out;
}

}  // namespace stiction::bench
