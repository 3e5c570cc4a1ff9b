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

/// Whether a joint moves a body. @param joint  index in u
inline bool moves_body(const world::Model& model, int joint, const world::Body& body) {
  return std::ranges::binary_search(body.dofs, model.n_vu() + joint);
}

/// When and where an arm is touched, from the external torques of a momentum observer. Rows of the observer follow each other with its lag T_O,
///     r_k = φ r_{k−1} + (1 − φ) τ_k ,   φ = exp(−h/T_O) ,                                                          (G.4)
/// so that their noise has a memory and a touch comes in slowly. The rows τ_k = (r_k − φ r_{k−1})/(1 − φ) have neither; `TouchOnset` and sense() are told of these.
/// Belongs to one thread. Tests: tests/execution/guarded_test.cpp
class Feeler {
 public:
  /// @param arm  whose observer, period and estimator say what is known of torques; it outlives the feeler
  /// @param joints  whose torques are looked at: a touch is looked for on the links that they move; empty: all, and the links that the estimator senses
  /// @param friction  that the observer takes off; null: none
  /// @throws core::InvalidInput: joints that move no link
  explicit Feeler(const ControlScenario& arm, std::vector<int> joints = {}, const sensing::JointFriction* friction = nullptr);

  /// Forgets rest and touch: the rows from now on are heard while nothing touches, until start().
  void listen();
  /// The mean of the rows heard is the rest. @throws core::InvalidInput: none was heard
  void start();
  /// A row of the observer, a period after the one before. @param q  joints (n_a)  @returns whether something touches; false before start()
  bool update(const Eigen::VectorXd& external, const Eigen::VectorXd& q);

  bool touches() const { return onset_ && onset_->touches(); }
  double age() const;  ///< of the touch, as far as torques tell [s]

  /// The rows from now on, in place of all since the touch began, are what identify() looks at: the force is as it will be.
  void settle();
  /// What touches, from the mean of the rows since settle(). @param q  joints (n_a)  @throws core::InvalidInput: nothing touches
  const sensing::SenseResult& identify(const Eigen::VectorXd& q);

  /// The force on a link along a direction that makes the torques of the last identify() best: all that few joints tell. @param f_L  unit, in the frame of the link  @returns [N]
  double calc_force(int body, const Eigen::Vector3d& p_L, const Eigen::Vector3d& f_L) const;

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
  sensing::SenseOptions options_;  ///< of the last identify()
  Eigen::VectorXd q_full_, tau_;   ///< the same (n_q), (n_a)
  double memory_;                  ///< φ
  Eigen::MatrixXd noise_;          ///< covariance of a row, of joints_
  Eigen::VectorXd drift_;
  Eigen::VectorXd friction_;  ///< dry, of joints_; empty: none
  double stiction_speed_ = 1;
  Eigen::VectorXd last_q_, sign_;     ///< joints of the row before; tanh(q̇/v₀), of joints_
  Eigen::VectorXd last_, row_, sum_;  ///< r_{k−1}, τ_k, of the rows heard or since settle()
  int rows_ = 0;                      ///< in sum_
  std::optional<sensing::TouchOnset> onset_;
};

}  // namespace stiction::execution
