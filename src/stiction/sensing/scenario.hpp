#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/sensing/known_contacts.hpp"

namespace stiction::sensing {

/// Joint angles and external torques over time; one column per moment.
struct Series {
  std::vector<double> times;               ///< increasing [s]
  Eigen::MatrixXd q;                       ///< (n_a × moments) joint positions [rad or m]
  Eigen::MatrixXd tau;                     ///< (n_a × moments) [N·m; N]
  std::vector<std::vector<int>> pushed{};  ///< simulated robots only: indices of the pushes that act at each moment
  std::vector<BaseWrench> base{};          ///< wrenches under the base, at every moment; empty: not measured
  std::vector<int> gaps{};                 ///< moments before which lines are missing, judged by the usual time step
  std::vector<std::string> notes{};        ///< a sentence each on columns of the file that were not read or need an explanation
};

/// Input of execution::simulate_poke(): a simulated robot that is pushed, in place of a measurement.
struct Poke {
  /// A push at a contact of Scenario::contacts. Its force is that of the start and stays constant in W.
  struct Push {
    int contact = 0;
    double begin = 0, duration = 0;                     ///< [s]
    Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< [N]
  };
  std::vector<Push> pushes;     ///< at most as many at the same time as sensing seeks
  Eigen::VectorXd start, end;   ///< joint positions (n_a) at which the commanded motion starts and ends, at rest
  double duration = 0;          ///< [s]
  double period = 0.02;         ///< time between measurements [s]
  double time_constant = 0.01;  ///< lag of the momentum observer [s]
  double noise = 0.05;          ///< standard deviation of its estimates [N·m; N]
  double bias = 0;              ///< standard deviation of the offset of each torque sensor [N·m; N]
  double bias_reach = 0;        ///< distance in joint positions over which offsets change [rad; m]; 0: constant
  double inertia_error = 0;     ///< share by which the masses in the observer's model are too large [-]
  std::uint64_t seed = 0;       ///< seed of noise and offsets
};

/// A robot, its torque model and its measurements, as read from one YAML file (tasks/sensing_scenario_file.hpp).
struct Scenario {
  std::string name, description;
  std::filesystem::path file;
  std::shared_ptr<const Sensor> sensor;
  SenseOptions options;
  int max_contacts = 1;  ///< contacts at the same time; above 1, or with a wrench at the base, sense_contacts() is called as well
  Series series;         ///< a single measurement is one moment at t = 0
  std::vector<ContactPoint> contacts;  ///< contacts from which the torques were computed, if the file has contacts instead of torques
  std::optional<Poke> poke;            ///< if set, `series` is empty until the poke is simulated
  std::optional<BaseWrench> base;      ///< measured under the base, or computed from the contacts; not with a recorded series

  /// The torques are computed from known contacts, and so are external ones.
  bool is_computed() const { return poke || !contacts.empty(); }
  bool asks_for_sets() const { return max_contacts > 1 || base; }
  ContactSetOptions set_options() const;
  /// The known contacts that act at a moment.
  std::vector<ContactPoint> contacts_at(std::size_t moment) const;
  /// The wrench measured under the base at a moment, or null.
  const BaseWrench* base_at(std::size_t moment) const;
};

/// Sets the rest of the torques from moments of the series in which nothing touches the robot, and their noise as well if `noise` is true.
/// Uses calibrate() and adds its notes to those of the series. @throws core::InvalidInput: as calibrate()
void set_rest(Scenario& scenario, std::span<const Eigen::Index> moments, bool noise);

/// Reads a CSV or NPZ file: a CSV file whose first line names its columns (find_columns() says by which names), or a CSV file without names
/// whose lines have a time, n_a joint positions and n_a torques in the order of u; or an NPZ file of t (moments), q and tau (moments ×
/// n_a), which may name its columns in an array `joints`. A step of more than five usual ones (their median) is a gap.
/// In a table with names, a line with a NaN or an empty field in a used column is skipped; a note states the number of skipped lines.
/// @param unmeasured  joints that are not in the file: they rest at the allowed position nearest to 0, and their torque of 0 is not used
/// @throws core::InvalidInput "FILE:LINE: …": empty, no column for a joint or several, a wrong number of values, not a number, a time that does not increase,
/// torques far above the effort of the motors (as in N·mm)
Series load_series(const std::filesystem::path& file, const world::Model& model, const std::vector<int>& unmeasured = {});

}  // namespace stiction::sensing
