#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stiction/control/controller.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::execution {

struct ContactEstimatorOptions {
  sensing::SensorOptions sensor;
  sensing::SenseOptions sense;
  /// Low-pass on the torques [s], ≥ 0. A force is kept by the deflection of the springs, and torques say only where and which way it acts.
  double time_constant = 0.05;
  /// F: forces are taken to be normal with this standard deviation before torques are seen [N], > 0. A touch near an axis needs a force of hundreds of newtons
  /// to make what noise alone makes.
  double plausible_force = 30;
  /// Candidates whose score (C.12) is within this of the best are told, ≥ 0: three standard deviations.
  double score_margin = 9;
  int max_candidates = 4;  ///< room, ≥ 1
  ContactEstimatorOptions() { sense.max_descents = 24, sensor.samples = 200; }
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Contacts for a controller, from joint angles and external joint torques alone: candidates of `sensing::sense`, started from those of the last tick as well,
/// with the least
///     l(p)/σ² + ‖f‖²/F² ,                                                                                               (C.12)
/// minus twice the logarithm of their posterior with noise σ and forces of standard deviation F, and those that are nearly as likely. They are alternatives,
/// of which the controller bounds each. Belongs to one thread.
/// Tests: tests/execution/contact_estimator_test.cpp
class ContactEstimator {
 public:
  /// @throws core::InvalidInput: options out of range, no link to sense
  ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options);

  /// Forgets the last tick.
  void reset();

  /// @param dt  since the last call [s], > 0    @param q  joints (n_a) when the torques were measured    @param tau  external torques (n_a) [N m; N]
  /// @param q_now  joints (n_a) now: contacts have moved on with their links
  /// @returns contacts, valid until the next call; the same contact keeps its number while its point moves on its link by less than a few sample spacings
  std::span<const control::ContactForce> update(control::VectorRef q, control::VectorRef tau, control::VectorRef q_now, double dt);

  const sensing::SenseResult& sensed() const { return sensed_; }
  const sensing::Sensor& sensor() const { return *sensor_; }

 private:
  struct Tracked {
    int id;
    sensing::ContactPoint point;
    bool taken = false;
  };
  void rank_candidates();
  Tracked* find_tracked(const sensing::ContactPoint& point);

  std::shared_ptr<const sensing::Sensor> sensor_;
  ContactEstimatorOptions options_;
  sensing::SenseWorkspace work_;
  sensing::SenseResult sensed_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  Eigen::VectorXd q_full_, tau_;
  std::vector<sensing::ContactPoint> last_;
  std::vector<Tracked> tracked_, tracked_before_;
  std::vector<std::pair<double, int>> scores_;
  std::vector<control::ContactForce> contacts_;
  int next_id_ = 0;
};

}  // namespace stiction::execution
