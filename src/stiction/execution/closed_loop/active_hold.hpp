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
  std::vector<int> joints;               ///< indices into u, of all fingers
  std::vector<std::vector<int>> pairs;   ///< per finger: pairs of its last link with the object, of fingers that have some
  std::vector<std::vector<int>> chains;  ///< per finger of these: indices into u
};
/// Branches of robots that have two or more of them; a free object that hangs on nothing. Empty: nothing here can hold it.
Fingers find_fingers(const world::Model& model, int object);

/// Where the last link of a finger is nearest to the object.
struct FingerGap {
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  double phi;                 ///< [m]
  std::span<const int> dofs;  ///< that change it
  Eigen::Map<const Rows> J;   ///< contact Jacobian by them; its first row is the gradient of phi
};

/// Keeps a free object where it is with the fingers of a hand, while nothing else moves them.
///
///   min_du  ‖p⁺ − p*‖²/s² + r²‖θ⁺ ⊖ θ*‖²/s² + w_du‖du/d‖² + w_s‖K(u + du − qᵃ⁺)/(F d)‖² + w_tip Σ_f g_f⁺²/s²                     (E.21)
///   s.t.    |du| ≤ 0.5 d/s · period ,  u + du within the joint limits and ahead of the joints by 0.9 effort/K at most
///
/// The next state is linear in du: that of the exact step at u, with B of the smoothed one. s = 0.1 L, r = L/1.55, F the weight of the object, d = 1 rad, or L
/// of a sliding joint (in the third cost L of every one); g_f is the gap between the last link of a finger and the object.
class ActiveHold {
 public:
  /// @param friction  multiplies every μ, > 0
  ActiveHold(const std::shared_ptr<const world::Model>& model, int object, double friction);

  bool applies() const { return !fingers_.joints.empty(); }
  const Fingers& fingers() const { return fingers_; }
  /// At q (n_q), until the next call of anything here. @param finger  of `pairs`
  std::optional<FingerGap> find_gap(VectorRef q, int finger);
  /// The object is held where q (n_q) has it. A reference is farther from the object than s at no time: it is drawn along.
  void start(VectorRef q);
  /// Commands of a finger that goes elsewhere stay as they are, and its gap counts for nothing. @param finger  of `pairs`; −1: none
  void leave(int finger);
  /// The next command. @param q  as measured (n_q)  @param u  command in force, replaced by the next (n_a)  @param period  until the next call [s], > 0
  /// @returns Solved; else u stays: the status of the step or of the program. No heap use once contacts have been as many
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
  Eigen::VectorXd d_;     ///< per joint of the fingers
  Eigen::VectorXd lift_;  ///< of the object's weight, F d (n) [N m, N]
  dynamics::StepOptions exact_, smoothed_;
  dynamics::StepWorkspace exact_work_, smoothed_work_;
  dynamics::StepResult next_, slope_;
  contact::Workspace geometry_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  std::vector<contact::Contact> contacts_;
  std::vector<double> jacobian_;
  Eigen::VectorXd q_ref_, error_;  ///< (n_q), (n_v)
  Eigen::VectorXd row_;            ///< of one residual by du (n)
  Eigen::VectorXd gradient_;       ///< at du = 0 (n)
  int left_ = -1;                  ///< the finger that goes elsewhere
  control::BoundedQp qp_;
  control::BoundedQpWorkspace qp_work_;
  control::BoundedQpResult solution_;
};

}  // namespace stiction::execution
