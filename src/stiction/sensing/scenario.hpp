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
  std::vector<double> times;               ///< increasing [s]
  Eigen::MatrixXd q;                       ///< (n_a × moments) of the robots [rad or m]
  Eigen::MatrixXd tau;                     ///< (n_a × moments) [N·m; N]
  std::vector<std::vector<int>> pushed{};  ///< of a simulated robot: indices of the pushes that act
  std::vector<BaseWrench> base{};          ///< measured under the base, at every moment or never
  std::vector<int> gaps{};                 ///< moments before which lines are missing, by the usual step
  std::vector<std::string> notes{};        ///< a sentence each: columns of the file that were not read, or that need a word
};

/// A simulated robot that is pushed, in place of a measurement: what execution::simulate_poke() is given.
struct Poke {
  /// `contact` of Scenario::contacts with its force at the start, which stays as it is in the world.
  struct Push {
    int contact = 0;
    double begin = 0, duration = 0;                     ///< [s]
    Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< [N]
  };
  std::vector<Push> pushes;     ///< as many at the same time as sensing looks for
  Eigen::VectorXd start, end;   ///< joint positions (n_a) that joint springs go from and to, at rest there
  double duration = 0;          ///< [s]
  double period = 0.02;         ///< of measurements [s]
  double time_constant = 0.01;  ///< of the momentum observer [s]
  double noise = 0.05;          ///< standard deviation of its estimates [N·m; N]
  double bias = 0;              ///< standard deviation of the offset of each torque sensor [N·m; N]
  double bias_reach = 0;        ///< distance in joint positions over which offsets change [rad; m]; 0: constant
  double inertia_error = 0;     ///< share by which the masses that it knows are too large [-]
  std::uint64_t seed = 0;       ///< of noise and offsets
};

/// A robot, what is known of its torques, and what was measured, as one YAML file says (tasks/sensing_scenario_file.hpp).
struct Scenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const Sensor> sensor;
  SenseOptions options;
  int max_contacts = 1;                ///< at the same time; above 1, or with a wrench at the base, sense_contacts() is asked as well
  Series series;                       ///< a single measurement is one moment at t = 0
  std::vector<ContactPoint> contacts;  ///< from which the torques were computed, where the file gives them instead of torques
  std::optional<Poke> poke;            ///< then `series` is empty until it is simulated
  std::optional<BaseWrench> base;      ///< measured under the base, or computed from the contacts; not with a recorded series

  bool asks_for_sets() const { return max_contacts > 1 || base; }
  ContactSetOptions set_options() const;
  /// The known contacts that act at a moment.
  std::vector<ContactPoint> contacts_at(std::size_t moment) const;
  /// What was measured under the base at a moment, or null.
  const BaseWrench* base_at(std::size_t moment) const;
};

/// Rest of the torques from moments of the series in which nothing touches the robot, and with `noise` their noise as well (calibrate()), whose notes join those of
/// the series. @throws core::InvalidInput: as calibrate()
void set_rest(Scenario& scenario, std::span<const Eigen::Index> moments, bool noise);

/// A CSV file whose first line names its columns (find_columns() says by which names), or that has no names and on each line a time, n_a joint positions and
/// n_a torques in the order of u; or an NPZ file of t (moments), q and tau (moments × n_a), which may name its columns in an array `joints`.
/// A step of more than five usual ones (their median) is a gap.
/// In a table with names a line with a NaN or an empty field in a column that is read is no moment; a note says how many were left out.
/// @param unmeasured  joints that the file says nothing of: at rest at the position nearest to 0, with a torque of 0 that nobody looks at
/// @throws core::InvalidInput "FILE:LINE: …": empty, no column for a joint or several, a wrong number of values, not a number, a time that does not increase,
/// torques far above what the motors bear (N·mm)
Series load_series(const std::filesystem::path& file, const world::Model& model, const std::vector<int>& unmeasured = {});

}  // namespace stiction::sensing
