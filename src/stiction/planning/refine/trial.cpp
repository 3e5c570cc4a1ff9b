#include "stiction/planning/refine/trial.hpp"

namespace stiction::planning::refinement {

StepSizes::StepSizes(const Problem& problem, int parts)
    : cuts(parts), exact(problem.plan.step), substep(problem.plan.substep), limits(problem.model.n_a()) {
  exact.smoothing = dynamics::Exact{};
  exact.with_A = exact.with_B = false;
  exact.warm_start = false;
  exact.h = problem.plan.step.h / cuts;
  coarse = exact.h > problem.refine.h * (1 + 1e-9);
  substep.joint_angle /= cuts;
  substep.joint_travel /= cuts;
  substep.slide /= cuts;
  substep.max_substeps *= cuts;
  free_substep = substep;
  free_substep.joint_angle = problem.plan.substep.joint_angle;
  free_substep.joint_travel = problem.plan.substep.joint_travel;
  const world::Model& model = problem.model;
  for (int j = 0; j < model.n_a(); ++j) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == world::DofKind::Revolute;
    limits[j] = revolute ? substep.joint_angle : substep.joint_travel;
  }
}

}  // namespace stiction::planning::refinement
