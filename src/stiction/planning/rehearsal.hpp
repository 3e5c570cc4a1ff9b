#pragma once

#include <memory>

#include "stiction/planning/object_space.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/planning/speed_limits.hpp"

namespace stiction::planning {

/// How a rehearsal ended.
struct RehearsalResult {
  bool holds = false;
  int lost = -1;      ///< where it does not: the segment of the plan in which the objects left it
  Eigen::VectorXd q;  ///< where it ended (n_q)
  long steps = 0, failed_steps = 0;
};

/// Carries out plans in time, as they are executed, by steps that know the inertia of the objects and the dampers of the joints: (E.10),
/// docs/theory/execution.md. Quasi-static steps let an object that nothing holds fall as slowly as their regularisation has it, and forget at every step
/// how fast it was. Has its own workspace: for one thread.
class Rehearsal {
 public:
  /// @param rest_time  of objects on joints [s], > 0 (Drag)
  Rehearsal(const std::shared_ptr<const world::Model>& model, double rest_time);

  /// The commands of a plan, from the end of its settling to a pause after the last one.
  /// @param share  wherever the commands rest the objects have to be within this share of the goal's tolerances of where the plan has them
  /// @param q      where it starts, at rest (n_q); null: where the plan does
  RehearsalResult run(const Plan& plan, double share, const Eigen::VectorXd* q = nullptr);

 private:
  /// One step of (E.10), of h seconds to the command u.
  core::Status step(const Eigen::VectorXd& u, double h);
  /// Worst displacement of an object from where it is in q_plan, in tolerances.
  double calc_offset(const Eigen::VectorXd& q_plan, const Goal& goal) const;

  std::shared_ptr<const world::Model> model_;
  SpeedLimits limits_;
  ObjectSpace space_;
  dynamics::StepWorkspace steps_;
  dynamics::StepOptions options_;
  dynamics::StepResult result_;
  Eigen::VectorXd q_, velocity_, u_;  // where the rehearsal is
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  Eigen::VectorXd damping_;  // (n_v) [N·s/m, N·m·s/rad]
};

}  // namespace stiction::planning
