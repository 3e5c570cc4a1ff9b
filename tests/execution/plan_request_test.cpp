#include "stiction/execution/closed_loop/plan_request.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace stiction::execution::test {
namespace {

/// What is done before each of some questions, 's' for a short one, and whether it is with the friction of the scene.
struct Asked {
  Preparation preparation;
  bool with_scene_friction, is_short;
  bool operator==(const Asked&) const = default;
};

/// @param slipped  what is said after each refusal
std::vector<Asked> ask(bool can_step_back, const std::vector<bool>& slipped) {
  PlanRequest request = first_request("start", can_step_back);
  EXPECT_EQ(request.cause, "start");
  std::vector<Asked> out{{request.preparation, request.with_scene_friction, request.is_short}};
  for (const bool slips : slipped) {
    request = next_request(request, slips, can_step_back);
    EXPECT_NE(request.cause, "start") << "a refusal is the cause from then on";
    out.push_back({request.preparation, request.with_scene_friction, request.is_short});
  }
  return out;
}

using enum Preparation;
constexpr bool kOfPlans = false, kOfScene = true;

TEST(PlanRequest, RefusedPlans_AreAskedForFromSpringsLetGo) {
  EXPECT_EQ(ask(false, {false, false, false}),
            (std::vector<Asked>{{None, kOfPlans, false}, {LetGo, kOfScene, false}, {LetGo, kOfScene, false}, {LetGo, kOfScene, false}}))
      << "it cannot step back";
}

TEST(PlanRequest, RobotThatCanStepBack_DoesSoAfterAShortSearch) {
  EXPECT_EQ(
      ask(true, {false, false, false}),
      (std::vector<Asked>{{None, kOfPlans, true}, {StepBack, kOfPlans, false}, {LetGo, kOfScene, false}, {StepBack, kOfScene, false}}));
}

TEST(PlanRequest, ObjectThatSlips_IsAskedForWithTheFrictionOfTheSceneFromWhereItIs) {
  EXPECT_EQ(ask(false, {true, false}), (std::vector<Asked>{{None, kOfPlans, false}, {None, kOfScene, false}, {LetGo, kOfScene, false}}));
  EXPECT_EQ(ask(true, {true, true, false}),
            (std::vector<Asked>{{None, kOfPlans, true}, {StepBack, kOfPlans, false}, {None, kOfScene, false}, {StepBack, kOfScene, false}}))
      << "a short search tells nothing of that";
}

}  // namespace
}  // namespace stiction::execution::test
