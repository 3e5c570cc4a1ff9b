#pragma once

#include <gtest/gtest.h>

#include "stiction/planning/planner.hpp"

namespace stiction::planning::test {

/// Commands of a plan simulated from its start, each sub-step in `parts`.
inline Eigen::VectorXd simulate(const PlanningProblem& problem, const Plan& plan, int parts) {
  dynamics::StepWorkspace work(problem.model);
  dynamics::StepResult result;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) {
      for (int k = 1; k <= parts; ++k) {
        const double s = static_cast<double>(k) / parts;
        const Eigen::VectorXd command = (1 - s) * u + s * knot.u;
        EXPECT_EQ(dynamics::step(*problem.model, {q, command}, plan.step, work, result), core::Status::Solved);
        q = result.q_next;
      }
      u = knot.u;
    }
  }
  return q;
}

}  // namespace stiction::planning::test
