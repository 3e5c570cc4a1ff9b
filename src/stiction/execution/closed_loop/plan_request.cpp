#include "stiction/execution/closed_loop/plan_request.hpp"

#include <utility>

namespace stiction::execution {

PlanRequest first_request(std::string cause, bool can_step_back) { return {.cause = std::move(cause), .is_short = can_step_back}; }

PlanRequest next_request(const PlanRequest& refused, bool slipped, bool can_step_back) {
  if (refused.is_short || (refused.with_scene_friction && can_step_back))
    return {"no plan from where the robot touched", Preparation::StepBack, refused.with_scene_friction};
  if (slipped && !refused.with_scene_friction) return {"no rest at the start with the friction of plans", Preparation::None, true};
  return {"no plan from where springs were strained", Preparation::LetGo, true};
}

}  // namespace stiction::execution
