#pragma once

#include <string>

namespace stiction::execution {

/// Action of the robot before the planner is asked.
enum class Preparation {
  None,
  StepBack,  ///< leave objects that stand by themselves: an object that the robot wedges, or that leans on it, makes a bad start
  LetGo      ///< relax the springs of the robot
};

/// Request of a run for a plan from the measured state, with the friction of plans (RunOptions::friction) or that of the scene.
struct PlanRequest {
  std::string cause;  ///< why a plan is needed
  Preparation preparation = Preparation::None;
  bool with_scene_friction = false;
  bool is_short = false;  ///< the search has a short limit (Question::is_short)
};

/// First request: from the measured state, with the friction of plans. If the robot can step back, the search is short.
PlanRequest first_request(std::string cause, bool can_step_back);

/// Request after a refused one. If the robot can step back, it does so after the short search. Later requests use the friction of the scene, because no push
/// with less friction may lead out of some states. If the object slipped at the start with the friction of plans, the next request does so at once, otherwise
/// the springs are relaxed first. From then on the robot steps back before every request. A robot that cannot step back, for instance with an object in its
/// fingers, relaxes its springs.
/// @param slipped  the object did not rest at the start with the friction of plans, but does with more friction
/// Tests: tests/execution/plan_request_test.cpp
PlanRequest next_request(const PlanRequest& refused, bool slipped, bool can_step_back);

}  // namespace stiction::execution
