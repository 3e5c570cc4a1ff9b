#pragma once

#include <memory>
#include <vector>

#include "stiction/execution/closed_loop/active_hold.hpp"
#include "stiction/planning/plan.hpp"

namespace stiction::execution {

/// Turns a free object to its goal in the hand that holds it. All fingers turn the object by 0.3 rad. Then the fingers go back, one after the other, to where they
/// first touched it, while the others hold. By ActiveHold the object follows a reference on the straight way from its pose X_0 at the start to the goal,
///
///   R* = exp(α* e) R_0 ,   p* = p_0 + α*/θ (p_G − p_0) ,   θ e = log(R_G R_0ᵀ) ,   α* = α + 0.6 rad/s · t_turn ≤ α + 0.3 rad        (E.23)
///
/// where α is the twist of the object about e when a turn begins, and t_turn the time since then. While fingers go back, the reference keeps the rotation that
/// the object then has. A turn that should reach the goal goes beyond it by the sum of what earlier such turns fell short of it.
///
/// Tests: tests/execution/finger_gait_test.cpp
class FingerGait {
 public:
  /// @param friction  factor of every μ, > 0
  FingerGait(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, double friction);

  /// True for a hand of three fingers or more, a goal that is a pose and near in position, and an object that would roll away if the fingers left it: a regrasp
  /// would then call it unstable (planning::RegraspSimulation::is_stable).
  bool applies(VectorRef q);

  /// Starts from q. The places at which the fingers first touched the object are kept from one start to the next.
  void start(VectorRef q);
  /// Computes the next command.
  /// @param q  measured (n_q)  @param u  command in force (n_a), replaced by the next one  @param period  until the next call [s], > 0
  /// @returns the status of ActiveHold; if it is not Solved, fingers that hold keep their commands
  core::Status update(VectorRef q, double period, Eigen::VectorXd& u);

  /// True after all fingers turned the object and before a finger leaves it.
  bool has_turned() const;
  /// True if each of the last two turns gained less than half of its angle towards the goal.
  bool stalls() const;
  /// The finger that goes back; −1: none.
  int finger() const { return finger_; }
  /// Present reference of the object (n_q).
  const Eigen::VectorXd& reference() const { return q_ref_; }

 private:
  enum class Phase {
    Close,   ///< fingers close on the object
    Turn,    ///< all fingers turn it
    Settle,  ///< fingers wait until the object has followed
    Return   ///< one finger goes back
  };
  void enter(Phase phase) { phase_ = phase, time_ = 0; }
  void advance(VectorRef q, const Eigen::VectorXd& u, double period);
  void begin_turn(VectorRef q);
  void begin_return(VectorRef q, const Eigen::VectorXd& u, int finger);
  void end_turn(VectorRef q);
  void turn();
  void move_finger(Eigen::VectorXd& u) const;
  void set_reference(const world::Pose& X_WB);
  double calc_twist(VectorRef q) const;
  Eigen::VectorXd calc_lift(VectorRef q, int finger);
  const std::vector<int>& chain(int finger) const { return hold_.fingers().chains[static_cast<std::size_t>(finger)]; }

  std::shared_ptr<const world::Model> model_;
  planning::Goal goal_;
  ActiveHold hold_;
  double length_;  ///< length L of the object [m]

  Phase phase_ = Phase::Close;
  double time_ = 0;                        ///< time in the present phase [s]
  int finger_ = -1;                        ///< the finger that goes back; −1: none
  Eigen::VectorXd q_ref_;                  ///< (n_q)
  Eigen::VectorXd q_home_, u_home_;        ///< state and commands when the fingers first touched the object (n_q), (n_a)
  std::vector<Eigen::VectorXd> stations_;  ///< waypoints of the finger that goes back: commands of its joints
  world::Pose from_;                       ///< X_0
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
  double angle_ = 0;    ///< θ [rad]
  double twist_ = 0;    ///< φ [rad]
  double turn_ = 0;     ///< angle of the present turn [rad]
  bool aimed_ = false;  ///< the last turn should have reached the goal
  double short_ = 0;    ///< sum of the angles by which such turns fell short of it [rad]
  double nearest_ = 0;  ///< least distance from the goal at the start and after turns [tolerances of the goal]
  int idle_ = 0;        ///< number of turns in a row that gained too little
};

}  // namespace stiction::execution
