#include "stiction/tasks/plan_slice.hpp"

#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"

namespace stiction::tasks {

PlanFile slice(const Task& task, const PlanFile& plan, std::size_t first, std::size_t last) {
  const std::size_t count = plan.segments.size();
  if (first >= last || last > count)
    core::throw_invalid("segments", fmt::format("[{}, {})", first, last), fmt::format("some of the {} that there are", count));
  PlanFile out = plan;
  const auto at = [&plan](std::size_t i) { return plan.segments.begin() + static_cast<std::ptrdiff_t>(i); };
  out.segments.assign(at(first), at(last));
  if (first > 0) {
    const StoredKnot& before = plan.segments[first - 1].knots.back();
    out.q_start = before.q;
    out.u_start = before.u;
    out.start_from_command_line = true;
    out.start_penetration = 0;
    out.start_projected = false;
    out.tree.clear();
  }
  if (last < count) {
    out.error = planning::goal_error(*task.model, out.segments.back().knots.back().q, task.problem.goal);
    const bool reached = out.error.position <= plan.tol_position && out.error.angle <= plan.tol_angle;
    out.status = reached ? core::Status::Solved : core::Status::MaxIterations;
  }
  if (plan.sha256 == content_sha256(plan)) out.sha256 = content_sha256(out);  // an edited plan stays marked as edited
  return out;
}

}  // namespace stiction::tasks
