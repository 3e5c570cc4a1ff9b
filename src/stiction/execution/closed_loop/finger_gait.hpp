#pragma once

#include <memory>
#include <vector>

#include "stiction/execution/closed_loop/active_hold.hpp"
#include "stiction/planning/plan.hpp"

namespace stiction::execution {

/// Turns a free object to its goal in the hand that holds it: all fingers turn it by c, and then one after the other goes back to where it first touched the
/// object, while the others hold it. The object follows by ActiveHold a reference on the straight way from its pose X_0 at the start to the goal,
///
///   R* = exp(φ* e) R_0 ,   p* = p_0 + φ*/θ (p_G − p_0) ,   θ e = log(R_G R_0ᵀ) ,   φ* = φ + ω t ≤ φ + c                              (E.23)
///
/// from the twist φ about e that the object has when a turn begins. ω = 0.6 rad/s, c = 0.3 rad. While fingers go back the reference is the rotation that the
/// object then has. A turn to the goal goes beyond it by what the turns before came short of it.
///
/// Tests: tests/execution/finger_gait_test.cpp
class FingerGait {
 public:
  /// @param friction  multiplies every μ, > 0
  FingerGait(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, double friction);

  /// Three fingers or more, a goal that is a pose and near in place, and an object that would roll away without them: with the fingers off it a regrasp
  /// would call it unstable (planning::RegraspSimulation::is_stable).
  bool applies(VectorRef q);

  /// From here to the goal; where the fingers first touched the object stays from one start to the next.
  void start(VectorRef q);
  /// The next command. @param q  as measured (n_q)  @param u  command in force, replaced by the next (n_a)  @param period  until the next call [s], > 0
  /// @returns that of ActiveHold: where it is not Solved, fingers that hold keep their commands
  core::Status update(VectorRef q, double period, Eigen::VectorXd& u);

  /// All fingers have turned the object, and none has left it since.
  bool has_turned() const;
  /// The last two turns brought it nearer to the goal by less than half of what they turned.
  bool stalls() const;
  /// That goes back; −1: none.
  int finger() const { return finger_; }
  /// Where the object is to be now (n_q).
  const Eigen::VectorXd& reference() const { return q_ref_; }

 private:
  enum class Phase {
    Close,   ///< fingers come to the object
    Turn,    ///< all turn it
    Settle,  ///< … and let it follow
    Return   ///< one goes back
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
  double length_;  ///< L of the object [m]

  Phase phase_ = Phase::Close;
  double time_ = 0;                        ///< in the phase [s]
  int finger_ = -1;                        ///< that goes back
  Eigen::VectorXd q_ref_;                  ///< (n_q)
  Eigen::VectorXd q_home_, u_home_;        ///< where the fingers first touched the object (n_q), (n_a)
  std::vector<Eigen::VectorXd> stations_;  ///< of the finger that goes back: commands of its joints
  world::Pose from_;                       ///< X_0
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
  double angle_ = 0;    ///< θ [rad]
  double twist_ = 0;    ///< φ [rad]
  double turn_ = 0;     ///< by which the turn goes on [rad]
  bool aimed_ = false;  ///< the last turn was to come to the goal
  double short_ = 0;    ///< by how much such turns came short of it, in sum [rad]
  double nearest_ = 0;  ///< at the start and after turns, the least [tolerances of the goal]
  int idle_ = 0;        ///< turns that gained nothing, in a row
};

}  // namespace stiction::execution
