#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/sensing/sense.hpp"

namespace stiction::sensing {

/// Joint angles and external torques over time; one column a moment.
struct Series {
  std::vector<double> times;  ///< increasing [s]
  Eigen::MatrixXd q;          ///< (n_a × moments) of the robots [rad or m]
  Eigen::MatrixXd tau;        ///< (n_a × moments) [N·m; N]
};

/// A contact that is known, in the link's frame.
struct KnownContact {
  int link = -1;  ///< index into Sensor::links()
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero(), f_L = Eigen::Vector3d::Zero();
};

/// A robot, what is known of its torques, and what was measured, as one YAML file says (schema: tasks/schema/sensing.schema.json).
struct Scenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const Sensor> sensor;
  SenseOptions options;
  Series series;                        ///< a single measurement is one moment at t = 0
  std::optional<KnownContact> contact;  ///< from which the torques were computed, where the file gives it instead of torques
};

/// A configuration with the torques of a contact that is known.
struct KnownCase {
  Eigen::VectorXd q, tau;
  KnownContact contact;
};

/// A force of `force` [N] in a direction uniform in the cone, at a point uniform by area on one of the links (indices into Sensor::links()),
/// at joint positions uniform in 90 % of their limits (of a turn where there are none).
KnownCase make_random_case(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, core::Random& random);

/// @param package_dirs  searched after those of each robot
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Scenario load_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
Scenario parse_scenario(const std::string& text, const std::filesystem::path& folder, std::span<const std::filesystem::path> package_dirs);

/// A CSV file of time, n_a joint angles and n_a torques a line, after a line of names.
/// @throws core::InvalidInput "FILE:LINE: …": empty, a wrong number of values, not a number, a time that does not increase
Series load_series(const std::filesystem::path& file, const world::Model& model);

/// Configuration (n_q) with the joints of the robots at the given positions and objects at their placed frames.
Eigen::VectorXd place_robots(const world::Model& model, VectorRef joints);

/// Distance of a known contact from a candidate: from the nearest of its points that explain the torques as well [m]; infinite on another link.
double calc_distance(const SenseResult& result, const Candidate& candidate, const KnownContact& contact);

}  // namespace stiction::sensing
