#pragma once

#include <map>
#include <utility>

#include "stiction/tasks/check_figures.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// Compares a plan file with the task and with itself, without the dynamics:
///   edited           the text matches its digest
///   status           Solved
///   start, goal      equal to those of the task; a goal from the command line is allowed
///   settings         search options equal those of the task, except seed, threads, scheme, anytime, and options given beside the task
///   dynamics         step and sub-step are at least as fine as the task's, by the same laws
///   error            stored goal error of the last knot
///   quaternion_norm, joint_limits, command_limits, command_step, display_poses, stored_cone   checked at every knot
class FileCheck {
 public:
  FileCheck(const Task& task, const PlanFile& plan, const CheckOptions& options);
  void run();
  void report(CheckReport& out) const;

 private:
  struct Place {
    int segment = -1, knot = -1;
  };
  std::string here(std::string_view what) const;
  void check_start();
  void check_goal();
  void check_settings();
  void check_dynamics();
  void check_state(const Eigen::VectorXd& q);
  void check_command(const Eigen::VectorXd& before, const Eigen::VectorXd& u);
  void check_cones(const StoredKnot& knot);
  void check_display(const StoredKnot& knot);
  bool revolute(int joint) const;
  void see_outside(Worst& figure, double lower, double upper, int joint, double x);

  const Task& task_;
  const PlanFile& plan_;
  const CheckOptions& limits_;
  const planning::PlannerOptions searched_;  ///< options of the plan
  const planning::PlannerOptions wanted_;    ///< options of the task, or options that were given beside it
  const world::Model& model_;
  std::map<std::pair<int, int>, const world::Pair*> pairs_{};  ///< pairs of geometries, the lower one first
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  Place place_;
  Worst edited_, status_, start_, goal_, settings_, dynamics_, error_, quaternion_norm_, joint_limits_, command_limits_, command_step_,
      display_, stored_cone_;
};

}  // namespace stiction::tasks
