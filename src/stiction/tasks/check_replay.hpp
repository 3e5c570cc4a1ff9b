#pragma once

#include <utility>

#include "stiction/contact/contact.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/check_figures.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// Checks the physics of a plan: a replay from its start at half the sub-step, and one full sub-step from every stored knot to the next.
///   goal_position, goal_angle, path_…   end of the replay
///   penetration, force_cone, force_gap, slide, failed_steps   of the replay; penetration also of the stored states
///   stored_position, stored_angle, stored_force, stored_contact   stored knots compared with the full sub-step; an unsolved plan may lack
///                                                                 forces
///   regrasp_contact                                               of stored regrasps
///   bystander_move, bystander_tip                                 of the replay, if the task has bystanders
///   effort                                                        of stored knots
///   max_force, brace                                              of the replay and of full sub-steps; max_force also of stored forces
/// Only forces above a share of the pair's own force are checked, so that a heavy body elsewhere in the scene hides no small force.
class Replay {
 public:
  Replay(const Task& task, const PlanFile& plan, const CheckOptions& options);
  core::Status run(const core::RunControl& control, CheckReport& out);
  void report(CheckReport& out) const;

 private:
  struct Place {
    int segment = -1, knot = -1;
  };
  /// A branch of a robot (finger, arm, trunk): its joints, and the pairs that change with it.
  struct Branch {
    std::vector<int> joints;  ///< indices of q
    std::vector<int> pairs;
  };

  std::string here() const;
  std::string here(std::string_view what) const;
  const std::string& joint_name(int j) const { return plan_.joints[static_cast<std::size_t>(j)]; }
  std::string pair_name(int pair) const;
  std::string pair_name(int pair, double share) const;
  double friction(int pair) const;
  double least_force(int pair) const;
  bool tells_forces() const;

  void find_branches();
  void check_regrasp(std::size_t segment);
  void see_hold(std::size_t segment, const StoredKnot& away);
  std::optional<PoseError> slip_aside(const StoredKnot& away, int side);
  Eigen::VectorXd calc_gravity_aside(const Eigen::VectorXd& q, int side) const;
  std::pair<double, int> deepest(const Eigen::VectorXd& q);
  bool step(const Eigen::VectorXd& q, const Eigen::VectorXd& u);
  void half_step(const Eigen::VectorXd& u, Eigen::VectorXd& q);
  void see_bystanders(const Eigen::VectorXd& q);
  void see_effort(const StoredKnot& knot);
  void see_press();
  void see_stored_press(const StoredKnot& knot);
  double effort_allowance() const;
  void check_stored(const Eigen::VectorXd& q_before, const StoredKnot& knot);
  void check_stored_contacts(const StoredKnot& knot);
  void check_stored_forces(const Eigen::VectorXd& q_before, const StoredKnot& knot);
  void compare_states(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Worst& position, Worst& angle);
  void compare_with_path(const Eigen::VectorXd& q, const Eigen::VectorXd& q_stored);

  const PlanFile& plan_;
  const CheckOptions& limits_;
  const world::Model& model_;
  dynamics::StepWorkspace step_work_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  contact::Workspace contact_work_;
  std::vector<contact::Contact> contacts_;
  dynamics::StepOptions step_options_;
  dynamics::StepResult result_;
  std::vector<int> goal_objects_;
  std::optional<planning::Bystanders> bystanders_;
  double brace_force_ = 0;  ///< planner's limit on the robot's force on itself or on fixed bodies [N]
  PoseError stays_{0, 0};   ///< planner's limit on the motion of an object that stays in place during a regrasp
  long unstable_ = 0;       ///< regrasps in which an object would move farther under tilted gravity
  std::vector<Branch> branches_;
  double start_penetration_ = 0;
  long steps_ = 0;
  long failed_steps_ = 0;
  Place place_;
  PoseError end_{0, 0};
  Worst penetration_, joint_limits_, force_cone_, force_gap_, regrasp_contact_, unstable_releases_, stored_position_, stored_angle_,
      stored_force_, stored_contact_, path_position_, path_angle_, slide_, effort_, max_force_, brace_, bystander_move_, bystander_tip_;
};

}  // namespace stiction::tasks
