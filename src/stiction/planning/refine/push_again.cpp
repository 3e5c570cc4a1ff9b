#include "stiction/planning/refine/push_again.hpp"

#include <utility>

namespace stiction::planning::refinement {
namespace {

/// Most steps of the plan's length in which a push must come to rest.
constexpr int kMostResting = 10;

}  // namespace

bool push_again(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run) {
  const world::Model& model = problem.model;
  Simulation simulation(problem, scratch, work);
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  Trace trace{.q = start.q, .u = start.u};
  run = Run{.end = start};
  for (const Segment& edge : push.edges) {
    for (const auto& knot : edge.knots) {
      const Eigen::VectorXd u = knot.u.cwiseMax(model.command_lower()).cwiseMin(model.command_upper());
      if (simulation.follow(u, problem.pace, watch, trace) != Ending::Reached) return false;
      if (problem.miss(knot.q, trace.q) > threshold::kStrayed) return false;
    }
    if (&edge == &push.edges.back()) {
      bool rests = false;
      const int most = kMostResting * problem.cuts;
      if (simulation.hold(most, problem.rest(), problem.pace, {}, watch, trace, rests) != Ending::Reached) return false;
    }
    run.segments.push_back({edge.kind, std::exchange(trace.knots, {}), false});
  }
  run.end.q = std::move(trace.q);
  run.end.u = std::move(trace.u);
  return true;
}

}  // namespace stiction::planning::refinement
