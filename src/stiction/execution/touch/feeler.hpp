#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/sensing/observer.hpp"
#include "stiction/sensing/sense.hpp"
#include "stiction/sensing/touch_onset.hpp"

namespace stiction::execution {

/// True if a joint moves a body. @param joint  index in u
inline bool moves_body(const world::Model& model, int joint, const world::Body& body) {
  return std::ranges::binary_search(body.dofs, model.n_vu() + joint);
}

/// Detects when and where an arm is touched, from the external torques of a momentum observer. Rows of the observer follow each other with its lag T_O,
///     r_k = φ r_{k−1} + (1 − φ) τ_k ,   φ = exp(−h/T_O) ,                                                          (G.4)
/// so the noise of the rows is correlated and a touch appears slowly. The rows τ_k = (r_k − φ r_{k−1})/(1 − φ) have neither fault; `TouchOnset` and sense()
/// use them. Belongs to one thread. Tests: tests/execution/guarded_test.cpp
class Feeler {
 public:
  /// @param arm  scenario whose observer, period and estimator describe the torques; it must outlive the feeler
  /// @param joints  joints whose torques are used; a touch is searched on the links that they move. Empty: all joints, and the links that the estimator senses
  /// @param friction  friction that the observer subtracts; null: none
  /// @throws core::InvalidInput: joints that move no link
  explicit Feeler(const ControlScenario& arm, std::vector<int> joints = {}, const sensing::JointFriction* friction = nullptr);

  /// Forgets rest and touch. Until start(), nothing may touch the arm, and the rows are averaged.
  void listen();
  /// Takes the mean of the rows since listen() as the torques at rest. @throws core::InvalidInput: there was no row
  void start();
  /// Takes a row of the observer, a period after the row before. @param q  joints (n_a)  @returns true if something touches; false before start()
  bool update(const Eigen::VectorXd& external, const Eigen::VectorXd& q);

  /// While true, a touch does not end (TouchOnset::keep_touch).
  void keep_touch(bool keep) {
    if (onset_) onset_->keep_touch(keep);
  }

  bool touches() const { return onset_ && onset_->touches(); }
  int rows() const { return rows_; }  ///< number of rows since listen() or settle()
  double age() const;                 ///< time since the touch began, estimated from torques [s]

  /// Restarts the mean that identify() uses: from now on the contact force is constant.
  void settle();
  /// Estimates the contact from the mean of the rows since settle(). @param q  joints (n_a)  @throws core::InvalidInput: nothing touches
  const sensing::SenseResult& identify(const Eigen::VectorXd& q);

  /// Force at a given point and direction of a link that best explains the torques of the last identify(); a few joints cannot tell more.
  /// @param f_L  unit, in the frame of the link  @returns [N]
  double calc_force(int body, const Eigen::Vector3d& p_L, const Eigen::Vector3d& f_L) const;

  /// Force of a given contact that best explains the mean of the rows since settle(), without a search for its place. @param torque  of a force of 1 N (n_a)
  /// @returns [N]; 0 without a touch or a row
  double calc_force(const Eigen::VectorXd& torque) const;

  const sensing::Sensor& sensor() const { return *sensor_; }

 private:
  void allow_for(const sensing::JointFriction& friction);
  void watch_friction(const Eigen::VectorXd& q);
  Eigen::VectorXd select(const Eigen::VectorXd& of_all) const;

  const ControlScenario& arm_;
  std::vector<int> joints_;
  std::shared_ptr<const sensing::Sensor> sensor_;
  sensing::SenseWorkspace work_;
  sensing::SenseResult sensed_;
  sensing::SenseOptions options_;  ///< options of the last identify()
  Eigen::VectorXd q_full_, tau_;   ///< configuration (n_q) and torques (n_a) of the last identify()
  double memory_;                  ///< φ
  Eigen::MatrixXd noise_;          ///< covariance of a row of joints_
  Eigen::VectorXd drift_;
  Eigen::VectorXd friction_;  ///< dry friction of joints_; empty: none
  double stiction_speed_ = 1;
  Eigen::VectorXd last_q_, sign_;     ///< joints at the row before; tanh(q̇/v₀) of joints_
  Eigen::VectorXd last_, row_, sum_;  ///< r_{k−1}; τ_k; sum of the rows since listen() or settle()
  int rows_ = 0;                      ///< number of rows in sum_
  std::optional<sensing::TouchOnset> onset_;
};

}  // namespace stiction::execution
