#include "stiction/execution/closed_loop/plan_join.hpp"

#include <algorithm>
#include <limits>

#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::Plan;
using planning::Segment;
using planning::SegmentKind;

/// From where a plan can be gone on with.
struct Place {
  std::size_t segment;  ///< the first of what is left
  double off;           ///< of the object [tolerances]
  VectorXd q, u;
};

std::vector<Place> find_places(const world::Model& model, const Plan& plan, VectorRef q, const JoinOptions& options) {
  std::vector<Place> out;
  VectorXd q_place = plan.q_start, u_place = plan.u_start;
  for (std::size_t s = 0; s < plan.segments.size(); ++s) {
    const Segment& segment = plan.segments[s];
    if (segment.knots.empty()) continue;
    if (segment.kind != SegmentKind::Settle) {
      const double off = share_between(model, plan.goal.object, q_place, q, plan.goal);
      const VectorXd far = (q_place.tail(model.n_a()) - q.tail(model.n_a())).cwiseAbs().cwiseQuotient(model.scales().joints());
      if (off <= options.off && far.maxCoeff() <= options.joint_reach) out.push_back({s, off, q_place, u_place});
    }
    q_place = segment.knots.back().q, u_place = segment.knots.back().u;
  }
  std::stable_sort(out.begin(), out.end(), [](const Place& a, const Place& b) { return a.off < b.off; });
  return out;
}

/// Simulates commands one after the other, within a number of steps.
class Simulator {
 public:
  Simulator(const world::Model& model, const Plan& plan, dynamics::StepWorkspace& work, long max_steps)
      : model_(model), goal_(plan.goal), limits_(plan.substep), work_(work), left_(max_steps) {
    options_ = plan.step;
    options_.smoothing = dynamics::Exact{};
    options_.with_A = options_.with_B = options_.with_force_derivatives = false;
  }

  long steps() const { return steps_; }
  bool exhausted() const { return left_ <= 0; }

  /// @param parts  into which each command is cut
  bool move(VectorXd& q, VectorXd& u, const VectorXd& u_end, std::vector<dynamics::Knot>& knots, int parts = 1) {
    const VectorXd u_begin = u;
    for (int k = 1; k <= parts; ++k) {
      if (exhausted()) return false;
      const VectorXd to = k == parts ? u_end : VectorXd(u_begin + (u_end - u_begin) * (static_cast<double>(k) / parts));
      dynamics::RolloutResult r;
      const Status status = dynamics::rollout(model_, q, u, to, options_, limits_, work_, r);
      steps_ += r.steps, left_ -= r.steps;
      if (status != Status::Solved || r.knots.empty() || r.penetration > 1) return false;
      q = r.knots.back().q, u = r.knots.back().u;
      std::move(r.knots.begin(), r.knots.end(), std::back_inserter(knots));
    }
    return true;
  }

  double share(const VectorXd& q) const { return planning::goal_error(model_, q, goal_).share(goal_); }

 private:
  const world::Model& model_;
  const planning::Goal& goal_;
  dynamics::SubstepLimits limits_;
  dynamics::StepWorkspace& work_;
  dynamics::StepOptions options_;
  long steps_ = 0, left_;
};

/// The rest of the plan from q, u. False: something of it cannot be simulated.
bool go_on(Simulator& simulator, const Plan& plan, std::size_t first, VectorXd& q, VectorXd& u, double enough, int parts, Plan& out) {
  for (std::size_t s = first; s < plan.segments.size(); ++s) {
    const Segment& from = plan.segments[s];
    if (from.knots.empty()) continue;
    Segment& segment = out.segments.emplace_back();
    segment.kind = from.kind, segment.unstable = from.unstable;
    for (const dynamics::Knot& knot : from.knots) {
      if (!simulator.move(q, u, knot.u, segment.knots, parts)) return false;
    }
    if (simulator.share(q) <= enough) return true;
  }
  return true;
}

}  // namespace

Join join_plan(const world::Model& model, const Plan& plan, VectorRef q, VectorRef u, const JoinOptions& options,
               dynamics::StepWorkspace& work) {
  Join best;
  best.share = std::numeric_limits<double>::infinity();
  Simulator simulator(model, plan, work, options.max_steps);
  for (const Place& place : find_places(model, plan, q, options)) {
    if (simulator.exhausted()) break;
    Plan tried = plan;
    tried.q_start = q, tried.u_start = u;
    tried.segments.clear();
    VectorXd q_at = q, u_at = u;
    work.forget();
    if (!simulator.move(q_at, u_at, place.u, tried.segments.emplace_back(Segment{SegmentKind::Contact, {}}).knots)) continue;
    if (share_between(model, plan.goal.object, q, q_at, plan.goal) > options.transit) continue;
    const VectorXd q_joined = q_at, u_joined = u_at;
    if (!go_on(simulator, plan, place.segment, q_at, u_at, options.enough, 1, tried)) continue;
    const double share = simulator.share(q_at);
    if (share >= best.share) continue;
    tried.error = planning::goal_error(model, q_at, plan.goal);
    best.plan = std::move(tried), best.share = share, best.segment = static_cast<int>(place.segment);
    if (share > options.enough) continue;
    Plan halves;
    VectorXd q_half = q_joined, u_half = u_joined;
    work.forget();
    if (!go_on(simulator, plan, place.segment, q_half, u_half, options.enough, 2, halves)) continue;
    if (simulator.share(q_half) > options.enough) continue;
    best.status = Status::Solved;
    break;
  }
  best.steps = simulator.steps();
  return best;
}

}  // namespace stiction::execution
