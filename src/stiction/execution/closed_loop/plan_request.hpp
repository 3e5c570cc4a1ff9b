#pragma once

#include <string>

namespace stiction::execution {

/// What the robot does before the planner is asked.
enum class Preparation {
  None,
  StepBack,  ///< it leaves objects that stand by themselves: what it wedges, or what leans on it, makes a bad start
  LetGo      ///< its springs are let go
};

/// One of the questions by which a run comes to a plan from where things are: with the friction of plans (RunOptions::friction) or that of the scene.
struct PlanRequest {
  std::string cause;  ///< why it is asked
  Preparation preparation = Preparation::None;
  bool with_scene_friction = false;
  bool is_short = false;  ///< the search ends soon (PlanSource)
};

/// The first question: from here, with the friction of plans. A robot that can step back asks for a short search alone.
PlanRequest first_request(std::string cause, bool can_step_back);

/// The question after a refusal. A robot that can step back does so after the short search. Then the friction is that of the scene, since a place may be left by no
/// push that holds with less: at once where the object slipped at the start with the friction of plans, else from where the springs were let go. From then on the
/// robot steps back every time, and where it cannot, as with an object in its fingers, the springs are let go.
/// @param slipped  the object did not rest at the start with the friction of plans, and rests with more
/// Tests: tests/execution/plan_request_test.cpp
PlanRequest next_request(const PlanRequest& refused, bool slipped, bool can_step_back);

}  // namespace stiction::execution
