#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stiction/control/controller.hpp"
#include "stiction/execution/contact_control/base_sensor.hpp"
#include "stiction/sensing/contact_tracker.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::execution {

/// Known properties of the torques, from which all other numbers follow: docs/theory/contact_loop.md
struct ContactEstimatorOptions {
  sensing::SensorOptions sensor{.samples = 200};
  /// Its `noise` follows from `noise`, `lag` and `bias` below, and so does its `threshold` unless it is given. Its `torques` may hold rest and sign of the
  /// given torques, the covariance of their white noise in place of `noise`, and joints without a sensor.
  sensing::SenseOptions sense{.max_descents = 2};
  /// Standard deviation of each given torque, white noise behind a lag of `lag` [N m; N], > 0; the largest one if `sense` has a covariance.
  double noise = 0.05;
  double lag = 0.01;       ///< lag 1/K_O of the observer that gives the torques [s], > 0
  double least_force = 5;  ///< smallest force that counts as a contact [N], > 0: noise should move its point by less than a sample spacing
  /// Standard deviation of torque offsets, from sensors and from wrong weights [N m; N], ≥ 0. If it is positive, nothing may touch the arm during the first
  /// five lags, while the offsets are learned.
  double bias = 0;
  /// Dry friction of joints (n_a) [N m; N], ≥ 0. While a joint sticks, an unknown part of this friction is in the torques. No measurement at rest shows how
  /// large the part will be, so the friction adds to the noise of every tick. Empty: none.
  Eigen::VectorXd friction{};
  /// F: standard deviation of the normal prior of forces [N], > 0. Without it, noise would be explained by a touch near an axis with hundreds of newtons.
  double plausible_force = 30;
  /// Candidates are reported if their score (C.12) is within this of the best, ≥ 0; 9 are three standard deviations.
  double score_margin = 9;
  std::optional<BaseSensorOptions> base{};  ///< force and moment sensor under the base, whose wrench update() then needs; empty: none
  int max_candidates = 4;                   ///< largest number of reported hypotheses, ≥ 1
  /// Largest number of contacts that act together, 1 to sensing::kMostContacts. Sets of more contacts are reported only if fewer do not explain the torques
  /// and the larger set lowers the score by more than `score_margin`.
  int max_contacts = 3;
  sensing::ContactTrackerOptions tracker{};  ///< tracker of sets of two or more contacts; its cone is that of `sense`
  /// Number of points of the last tick from which descents also start, reported or not, ≥ max_candidates. Candidates are thus kept, so a tick searches only
  /// `sense.max_descents` more places, and several ticks search the whole surface.
  int pool = 8;
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Estimates contacts for a controller from joint angles and external joint torques alone. The candidates are those of `sensing::sense`, which also starts from
/// the candidates of the last tick. The estimator reports the candidates with the least score
///     l(p)/σ² + ‖f‖²/F² ,                                                                                               (C.12)
/// and those that are nearly as likely. The score is minus twice the logarithm of the posterior for noise σ and forces of standard deviation F. Candidates are
/// alternatives, and the controller bounds each of them. If no single contact explains the torques, sets of two and then of three contacts take its place,
/// scored with the sum of ‖f‖². `sensing::ContactTracker` follows the sets from tick to tick. Seven torques never isolate such a set (Y.11a): among all
/// possible forces the prior chooses, and every set that is nearly as likely is reported. With a wrench at the base (Y.9a) there are thirteen measurements,
/// and two contacts have ten unknowns. The other numbers follow from the properties of the torques:
///     T = T_O ⟨(3 s / f d)² − 1⟩₊ ,   σ² = s² T_O / (T_O + T) + P ,                                                         (C.13)
/// T is the time constant of a low-pass for torques with noise s behind the lag T_O. With it, three standard deviations move the point of the least force f
/// by less than the sample spacing d. σ is the remaining noise, with the variance P of offsets of deviation b. Offsets are learned while nothing touches the
/// arm, and change over about a radian, as errors of weights do.
/// Belongs to one thread. Tests: tests/execution/contact_estimator_test.cpp
class ContactEstimator {
 public:
  /// @throws core::InvalidInput: options out of range, no link to sense
  ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options);

  /// Forgets the last tick and the offsets.
  void reset();

  /// Updates the contacts from a sample of torques.
  /// @param dt  time since the last call [s], > 0    @param q  joints (n_a) when the torques were measured    @param tau  external torques (n_a) [N m; N]
  /// @param q_now  present joints (n_a), with which the contacts are moved along with their links
  /// @param base  wrench at the base when the torques were measured, if the options have a sensor; its noise is that of the options
  /// A sample with a number in q, tau or base that is not finite is left out: the contacts of the sample before are reported again, moved along with their
  /// links. The next sample then counts for the whole time. missed() says how many samples in a row were left out; the caller decides how long this may last.
  /// @throws core::InvalidInput: wrong sizes, q_now not finite, dt ≤ 0, a base without a sensor or a sensor without a base; nothing has changed then
  /// @returns contacts, valid until the next call; the same contact keeps its number while its point moves on its link by less than a few sample spacings
  std::span<const control::ContactForce> update(control::VectorRef q, control::VectorRef tau, control::VectorRef q_now, double dt,
                                                const sensing::BaseWrench* base = nullptr);

  const sensing::SenseResult& sensed() const { return sensed_; }                      ///< candidates for a single contact
  const std::vector<sensing::ContactSet>& hypotheses() const { return hypotheses_; }  ///< reported hypotheses, the most likely first
  const sensing::Sensor& sensor() const { return *sensor_; }
  double time_constant() const { return time_constant_; }          ///< T [s]
  double noise() const { return sensed_.noise; }                   ///< σ of the last tick, as in SenseResult [N m; N]
  const Eigen::VectorXd& offset() const { return tare_.offset; }   ///< learned offsets of the torques (n_a), then of the base (6) [N m; N]
  int missed() const { return missed_; }                           ///< samples left out since the last one that was used
  bool is_ready() const { return !has_offsets() || tare_.ready; }  ///< the offsets have been learned

 private:
  struct Tracked {
    int id;
    sensing::ContactPoint point;
    bool taken = false;
  };
  /// Offsets of the torques, learned while nothing touches the arm.
  struct Tare {
    Eigen::VectorXd offset;    ///< offset of each measurement [N m; N]
    Eigen::VectorXd q;         ///< joint positions of the last tick [rad; m] (n_a)
    Eigen::VectorXd variance;  ///< P of each offset [(N m)²; N²]
    double time = 0;           ///< time since the start [s]
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
  Eigen::VectorXd measured_;         ///< low-passed torques (n_a), then force and moment at the base (6) if there is a sensor
  Eigen::VectorXd offset_variance_;  ///< b² of each measurement
  Eigen::VectorXd hidden_;           ///< squared dry friction of each measurement
  sensing::BaseWrench base_;         ///< wrench at the base without its offset
  double time_constant_ = 0;         ///< T
  Eigen::VectorXd white_;            ///< variance of the white noise of each measurement after the low-pass [(N m)²; N²]
  Eigen::MatrixXd white_noise_;      ///< covariance of the torque noise if it differs between joints; else empty
  sensing::WhitenedTorques whitened_;
  Tare tare_;
  std::vector<sensing::ContactPoint> last_;
  std::vector<Tracked> tracked_, tracked_before_;
  sensing::ContactRowsWorkspace rows_work_;
  sensing::ContactRows rows_;
  std::vector<int> bodies_;                        ///< body of each link
  std::vector<sensing::ContactTracker> trackers_;  ///< trackers for two and for three contacts
  std::vector<sensing::ContactSet> hypotheses_, parents_;
  std::vector<control::ContactForce> contacts_;
  int next_id_ = 0;
  double since_sample_ = 0;  ///< time since the last used sample [s]
  int missed_ = 0;
};

}  // namespace stiction::execution
