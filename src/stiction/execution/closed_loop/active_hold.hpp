#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/control/bounded_qp.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::execution {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// The fingers of a hand that holds a free object.
struct Fingers {
  std::vector<int> joints;               ///< joints of all fingers: indices into u
  std::vector<std::vector<int>> pairs;   ///< per finger: pairs of its last link with the object; fingers without such pairs are left out
  std::vector<std::vector<int>> chains;  ///< joints of each finger in `pairs`: indices into u
};
/// Finds the fingers that can hold an object: the branches of each robot that has two or more of them. Empty if there are none or the object is not free.
Fingers find_fingers(const world::Model& model, int object);

/// Gap between an object and the last link of a finger, at their nearest points.
struct FingerGap {
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  double phi;                 ///< signed distance [m]
  std::span<const int> dofs;  ///< velocity indices that change phi
  Eigen::Map<const Rows> J;   ///< contact Jacobian for these dofs; its first row is the gradient of phi
};

/// Keeps a free object in place with the fingers of a hand, while no plan commands them.
///
///   min_du  ‖p⁺ − p*‖²/s² + r²‖R⁺ ⊖ R*‖²/s² + w_du‖du/d‖² + w_s‖K(u + du − qᵃ⁺)/τ₀‖² + w_φ Σ_i φ_i⁺²/s²                          (E.21)
///   s.t.    |du| ≤ 0.5 d/s · period ,  u + du within the joint limits and ahead of the joints by 0.9 effort/K at most
///
/// The next state is that of the exact step at u, linear in du with B of the smoothed step. s = 0.1 L, r = L/1.55. d = 1 rad and τ₀ = m g L for a joint
/// that turns, L and m g for one that slides, with the weight m g of the object. φ_i is the gap between the last link of finger i and the object.
class ActiveHold {
 public:
  /// @param friction  factor of every μ, > 0
  ActiveHold(const std::shared_ptr<const world::Model>& model, int object, double friction);

  bool applies() const { return !fingers_.joints.empty(); }
  const Fingers& fingers() const { return fingers_; }
  /// Gap at q (n_q), valid until the next call of a member function. @param finger  index into `pairs`
  std::optional<FingerGap> find_gap(VectorRef q, int finger);
  /// Starts to hold the object at its pose in q (n_q). The reference later follows an object that moves farther than s away.
  void start(VectorRef q);
  /// Leaves out a finger that moves elsewhere: its commands stay unchanged and its gap has no cost. @param finger  index into `pairs`; −1: no finger
  void leave(int finger);
  /// Computes the next command.
  /// @param q  measured (n_q)  @param u  command in force (n_a), replaced by the next one  @param period  until the next call [s], > 0
  /// @returns Solved, or the status of the failed step or program, which leaves u unchanged. No heap use once there were as many contacts in an earlier call
  core::Status update(VectorRef q, double period, Eigen::VectorXd& u);

 private:
  core::Status predict(VectorRef q, const Eigen::VectorXd& u);
  void draw_along(VectorRef q);
  void add_pose();
  void add_strain(const Eigen::VectorXd& u);
  void add_gaps(VectorRef q);
  void add_row(double weight, double offset);
  std::optional<FingerGap> find_gap(int finger);
  bool is_left(int joint) const;
  void set_box(VectorRef q, const Eigen::VectorXd& u, double period);

  std::shared_ptr<const world::Model> model_;
  int object_, v_begin_;
  Fingers fingers_;
  double s_, r_;          ///< [m]
  Eigen::VectorXd d_;     ///< d of each finger joint [rad, m]
  Eigen::VectorXd lift_;  ///< τ₀, the force or torque of the object's weight at each joint (n) [N m, N]
  dynamics::StepOptions exact_, smoothed_;
  dynamics::StepWorkspace exact_work_, smoothed_work_;
  dynamics::StepResult next_, slope_;
  contact::Workspace geometry_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  std::vector<contact::Contact> contacts_;
  std::vector<double> jacobian_;
  Eigen::VectorXd q_ref_, error_;  ///< (n_q), (n_v)
  Eigen::VectorXd row_;            ///< derivative of one residual by du (n)
  Eigen::VectorXd gradient_;       ///< gradient of the cost at du = 0 (n)
  int left_ = -1;                  ///< the finger that is left out; −1: none
  control::BoundedQp qp_;
  control::BoundedQpWorkspace qp_work_;
  control::BoundedQpResult solution_;
};

}  // namespace stiction::execution
