#include "stiction/planning/subgoal.hpp"

namespace stiction::planning {
namespace {

/// Share of the growths whose contact forces stay in their cones.
constexpr double kInCones = 0.5;
/// Share of the regrasps towards drawn subgoals that start from the node whose object is nearest, the others from the nearest one.
constexpr double kByPlace = 0.5;
/// Share of the pushes not yet taken to the goal that start from the front of the tree (Tree::take_for_push), half of them towards the goal:
/// by the metric alone, most start from the many postures around an object that has hardly moved.
constexpr double kFromFront = 0.5, kFrontToGoal = 0.5;

}  // namespace

Expansion SubgoalSampler::draw(Tree& tree, long iteration) const {
  Expansion x;
  x.stream = static_cast<std::uint64_t>(iteration) + 1;
  core::Random random(setting_.options.seed, x.stream << 1);
  x.grasp = random.chance(setting_.options.grasp_probability);
  x.in_cones = !setting_.options.thesis_edges() && setting_.options.scheme == Scheme::Analytic && random.chance(kInCones);
  x.by_place = x.grasp && !setting_.options.thesis_edges() && random.chance(kByPlace);
  x.subgoal = setting_.goal.q_goal();
  x.to_goal = random.chance(setting_.options.goal_bias);
  if (x.to_goal) x.near = x.grasp ? tree.take_for_regrasp() : tree.take_nearest_to_goal();
  if (x.near >= 0) return x;
  if (!x.grasp && !setting_.options.thesis_edges() && random.chance(kFromFront)) x.near = tree.take_for_push();
  x.to_goal = x.near >= 0 && random.chance(kFrontToGoal);
  if (x.to_goal) return x;
  setting_.goal.space().sample(setting_.options.sample_boxes, random, x.subgoal);
  return x;
}

}  // namespace stiction::planning
