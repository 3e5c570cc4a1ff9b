#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stiction/control/controller.hpp"
#include "stiction/execution/contact_control/base_sensor.hpp"
#include "stiction/sensing/contact_tracker.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::execution {

/// What is known of the torques. The rest follows: docs/theory/control.md
struct ContactEstimatorOptions {
  sensing::SensorOptions sensor{.samples = 200};
  /// `noise` and `threshold` are those of `noise`, `lag`, `bias` below. `torques` may have rest and sign of the torques as they are given, the covariance of their white
  /// noise in place of `noise`, and joints without a sensor.
  sensing::SenseOptions sense{.max_descents = 2};
  double noise =
      0.05;  ///< standard deviation of each torque as it is given, white before a lag of `lag` [N m; N], > 0; the largest where `sense` has a covariance
  double lag = 0.01;       ///< 1/K_O of the observer that gives them [s], > 0
  double least_force = 5;  ///< smallest force that matters to who asks [N], > 0: noise is to move its point by less than a sample spacing
  /// Standard deviation of offsets of the torques, of sensors and of weights that are not as thought [N m; N], ≥ 0. Where there are any, nothing may touch
  /// the arm while the first are learned, five lags long.
  double bias = 0;
  /// Dry friction of joints, of which torques have an unknown part while a joint sticks (n_a) [N m; N], ≥ 0: no rest tells what it will be, so that it adds to the noise of
  /// every tick. Empty: none.
  Eigen::VectorXd friction{};
  /// F: forces are taken to be normal with this standard deviation before torques are seen [N], > 0. A touch near an axis needs a force of hundreds of newtons
  /// to make what noise alone makes.
  double plausible_force = 30;
  /// Candidates whose score (C.12) is within this of the best are reported, ≥ 0: three standard deviations.
  double score_margin = 9;
  std::optional<BaseSensorOptions>
      base{};              ///< of a force and moment sensor under the base, which update() is then told of; nullopt: there is none
  int max_candidates = 4;  ///< hypotheses that are reported, ≥ 1
  /// Contacts that may act together, 1 to sensing::kMostContacts. More than one are reported where fewer do not explain the torques, and only if they lower the score
  /// by more than `score_margin`.
  int max_contacts = 3;
  sensing::ContactTrackerOptions tracker{};  ///< of sets of more than one; its cone is that of `sense`
  /// Points of the last tick from which descents start as well, reported or not, ≥ max_candidates: what is found is kept, so that a tick searches only
  /// `sense.max_descents` more places, and the whole surface is searched over several ticks.
  int pool = 8;
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Contacts for a controller, from joint angles and external joint torques alone: candidates of `sensing::sense`, started from those of the last tick as well,
/// with the least
///     l(p)/σ² + ‖f‖²/F² ,                                                                                               (C.12)
/// minus twice the logarithm of their posterior with noise σ and forces of standard deviation F, and those that are nearly as likely. They are alternatives,
/// of which the controller bounds each. Where no single contact explains the torques, sets of two and then of three do in their place, with the sum of ‖f‖², followed
/// from tick to tick by `sensing::ContactTracker`. Seven torques never isolate such a set (Y.11a): forces are those of the prior among all that would do, and every
/// set that is nearly as likely is reported. With a wrench at the base (Y.9a) thirteen numbers are measured, and two contacts have ten. What follows from what is known of the torques:
///     T = T_O ⟨(3 s / f d)² − 1⟩₊ ,   σ² = s² T_O / (T_O + T) + P ,                                                         (C.13)
/// a low-pass of T on torques with noise s behind the lag T_O, so that three deviations move the point of the least force f by less than the sample spacing d, and
/// the noise left with the variance P of offsets of deviation b, which are learned while nothing touches the arm; like weights they change over a radian.
/// Belongs to one thread. Tests: tests/execution/contact_estimator_test.cpp
class ContactEstimator {
 public:
  /// @throws core::InvalidInput: options out of range, no link to sense
  ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options);

  /// Forgets the last tick, and offsets.
  void reset();

  /// @param dt  since the last call [s], > 0    @param q  joints (n_a) when the torques were measured    @param tau  external torques (n_a) [N m; N]
  /// @param q_now  joints (n_a) now: contacts have moved on with their links
  /// @param base  the wrench there when the torques were measured, where the options have a sensor; its noise is that of the options
  /// A sample with a number in q, tau or base that is not finite is no measurement and is left out: the contacts of the sample before are reported again, moved on with
  /// their links, and the next sample counts for the time since. missed() says how many were left out in a row; who asks decides how long that may last.
  /// @throws core::InvalidInput: sizes, q_now that is not finite, dt ≤ 0, a base without a sensor or the other way round. Nothing has changed then
  /// @returns contacts, valid until the next call; the same contact keeps its number while its point moves on its link by less than a few sample spacings
  std::span<const control::ContactForce> update(control::VectorRef q, control::VectorRef tau, control::VectorRef q_now, double dt,
                                                const sensing::BaseWrench* base = nullptr);

  const sensing::SenseResult& sensed() const { return sensed_; }                      ///< single contacts
  const std::vector<sensing::ContactSet>& hypotheses() const { return hypotheses_; }  ///< that are reported, the likeliest first
  const sensing::Sensor& sensor() const { return *sensor_; }
  double time_constant() const { return time_constant_; }          ///< T [s]
  double noise() const { return sensed_.noise; }                   ///< σ of the last tick, as of SenseResult [N m; N]
  const Eigen::VectorXd& offset() const { return tare_.offset; }   ///< as learned of the torques (n_a), then of the base (6) [N m; N]
  int missed() const { return missed_; }                           ///< samples left out since the last one that was taken
  bool is_ready() const { return !has_offsets() || tare_.ready; }  ///< offsets are learned

 private:
  struct Tracked {
    int id;
    sensing::ContactPoint point;
    bool taken = false;
  };
  /// Offsets of the torques, learned while nothing touches the arm.
  struct Tare {
    Eigen::VectorXd offset;    ///< of what is measured [N m; N]
    Eigen::VectorXd q;         ///< joint positions of the last tick [rad; m] (n_a)
    Eigen::VectorXd variance;  ///< P of each offset [(N m)²; N²]
    double time = 0;           ///< since the start [s]
    bool ready = false;
  };
  void learn_offset(control::VectorRef q, double dt);
  void sense(control::VectorRef q, double dt);
  void rank_singles();
  void find_sets();
  bool needs_more() const;
  std::span<const sensing::ContactSet> make_parents(std::size_t tracker);
  void choose_reported();
  void take_sample(control::VectorRef q, control::VectorRef tau, const sensing::BaseWrench* base, double dt);
  bool has_offsets() const { return offset_variance_.maxCoeff() > 0; }
  const sensing::BaseWrench* base() const { return options_.base ? &base_ : nullptr; }
  void report();
  void place(control::VectorRef q_now);
  Tracked* find_tracked(const sensing::ContactPoint& point);
  double calc_rho() const;
  void set_noise();

  std::shared_ptr<const sensing::Sensor> sensor_;
  ContactEstimatorOptions options_;
  sensing::SenseOptions sense_;
  sensing::SenseWorkspace work_;
  sensing::SenseResult sensed_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  Eigen::VectorXd q_full_, external_;
  Eigen::VectorXd measured_;         ///< torques (n_a), then force and moment at the base where there is a sensor (6), after the low-pass
  Eigen::VectorXd offset_variance_;  ///< b² of each of them
  Eigen::VectorXd hidden_;           ///< c² of dry friction of each of them
  sensing::BaseWrench base_;         ///< less its offset
  double time_constant_ = 0;         ///< T
  Eigen::VectorXd white_;            ///< variance of white noise of all that is measured, after it [(N m)²; N²]
  Eigen::MatrixXd white_noise_;      ///< its covariance where it is not the same in every joint; else empty
  sensing::WhitenedTorques whitened_;
  Tare tare_;
  std::vector<sensing::ContactPoint> last_;
  std::vector<Tracked> tracked_, tracked_before_;
  sensing::ContactRowsWorkspace rows_work_;
  sensing::ContactRows rows_;
  std::vector<int> bodies_;                        ///< of the links
  std::vector<sensing::ContactTracker> trackers_;  ///< of two contacts, of three
  std::vector<sensing::ContactSet> hypotheses_, parents_;
  std::vector<control::ContactForce> contacts_;
  int next_id_ = 0;
  double since_sample_ = 0;  ///< [s]
  int missed_ = 0;
};

}  // namespace stiction::execution
