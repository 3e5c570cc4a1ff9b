#pragma once

#include <gtest/gtest.h>

#include "planning/systems.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/planning/plan.hpp"

namespace stiction::planning::test {

/// A plan of planar_pushing made by moving the command along corners with the exact dynamics, one contact edge per corner.
inline Plan push_plan(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q_start,
                      const std::vector<Eigen::Vector2d>& corners) {
  Plan plan;
  plan.q_start = q_start;
  plan.u_start = q_start.tail(model->n_a());
  plan.substep = {.joint_angle = 0.03, .joint_travel = 0.02, .slide = 2e-3, .max_substeps = 400};
  dynamics::StepWorkspace work(model);
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (const auto& corner : corners) {
    dynamics::RolloutResult r;
    EXPECT_EQ(dynamics::rollout(*model, q, u, corner, plan.step, plan.substep, work, r), core::Status::Solved);
    plan.segments.push_back({SegmentKind::Contact, r.knots});
    q = r.knots.back().q;
    u = corner;
  }
  plan.goal.X_WG = world::object_pose(*model, q, 0);
  plan.goal.tol_position = 0.02;
  return plan;
}

/// The hand below the box pushes it up by 0.2 m.
inline Plan push_up(const std::shared_ptr<const world::Model>& model) {
  const Eigen::VectorXd q = (Eigen::VectorXd(5) << 0, 0.6, 0, 0, -0.02).finished();
  return push_plan(model, q, {Eigen::Vector2d(0, 0.1), Eigen::Vector2d(0, 0.2)});
}

}  // namespace stiction::planning::test
