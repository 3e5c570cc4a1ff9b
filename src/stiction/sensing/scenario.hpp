#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/sensing/known_contacts.hpp"

namespace stiction::sensing {

/// Joint angles and external torques over time; one column a moment.
struct Series {
  std::vector<double> times;  ///< increasing [s]
  Eigen::MatrixXd q;          ///< (n_a × moments) of the robots [rad or m]
  Eigen::MatrixXd tau;        ///< (n_a × moments) [N·m; N]
};

/// A robot, what is known of its torques, and what was measured, as one YAML file says (schema: tasks/schema/sensing.schema.json).
struct Scenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const Sensor> sensor;
  SenseOptions options;
  int max_contacts = 1;                ///< at the same time; above 1, or with a wrench at the base, sense_contacts() is asked as well
  Series series;                       ///< a single measurement is one moment at t = 0
  std::vector<KnownContact> contacts;  ///< from which the torques were computed, where the file gives them instead of torques
  std::optional<BaseWrench> base;      ///< measured under the base, or computed from the contacts; not with a series

  bool asks_for_sets() const { return max_contacts > 1 || base; }
  ContactSetOptions set_options() const;
};

/// @param package_dirs  searched after those of each robot
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
Scenario load_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
Scenario parse_scenario(const std::string& text, const std::filesystem::path& folder, std::span<const std::filesystem::path> package_dirs);

/// A CSV file of time, n_a joint angles and n_a torques a line, after a line of names.
/// @throws core::InvalidInput "FILE:LINE: …": empty, a wrong number of values, not a number, a time that does not increase
Series load_series(const std::filesystem::path& file, const world::Model& model);

}  // namespace stiction::sensing
