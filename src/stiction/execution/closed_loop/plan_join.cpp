#include "stiction/execution/closed_loop/plan_join.hpp"

#include <algorithm>
#include <limits>

#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/execution/closed_loop/pose_tracker.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::Plan;
using planning::Segment;
using planning::SegmentKind;

/// A regrasp moves a joint if it commands it farther than this [rad, or L of a joint that slides].
constexpr double kMoves = 0.02;

/// A place from which a plan can be continued.
struct Place {
  std::size_t segment, knot;  ///< first segment and knot of the rest of the plan
  double off;                 ///< distance of the object from this place [tolerances]
  VectorXd q, u;
};

/// Finds the place of each segment that is nearest to q, and sorts them by distance.
std::vector<Place> find_places(const world::Model& model, const Plan& plan, VectorRef q, const JoinOptions& options) {
  std::vector<Place> out;
  VectorXd q_place = plan.q_start, u_place = plan.u_start;
  for (std::size_t s = 0; s < plan.segments.size(); ++s) {
    const Segment& segment = plan.segments[s];
    Place nearest{s, 0, std::numeric_limits<double>::infinity(), {}, {}};
    for (std::size_t k = 0; k < segment.knots.size(); ++k) {
      const double off = share_between(model, q_place, q, plan.goal);
      const VectorXd far = (q_place.tail(model.n_a()) - q.tail(model.n_a())).cwiseAbs().cwiseQuotient(model.scales().joints());
      if (off < nearest.off && off <= options.off && far.maxCoeff() <= options.joint_reach) nearest = {s, k, off, q_place, u_place};
      q_place = segment.knots[k].q, u_place = segment.knots[k].u;
      if (segment.kind == SegmentKind::Regrasp) {  // a regrasp can only begin at its start: later its fingers are on their way
        q_place = segment.knots.back().q, u_place = segment.knots.back().u;
        break;
      }
    }
    if (segment.kind != SegmentKind::Settle && nearest.q.size() > 0) out.push_back(nearest);
  }
  std::stable_sort(out.begin(), out.end(), [](const Place& a, const Place& b) { return a.off < b.off; });
  return out;
}

/// Simulates commands one after the other, within a limited number of steps.
class Simulator {
 public:
  Simulator(const world::Model& model, const Plan& plan, dynamics::StepWorkspace& work, long max_steps)
      : model_(model), goal_(plan.goal), limits_(plan.substep), work_(work), most_(max_steps) {
    options_ = plan.step;
    options_.smoothing = dynamics::Exact{};
    options_.with_A = options_.with_B = options_.with_force_derivatives = false;
  }

  long steps() const { return steps_; }
  void count(long steps) { steps_ += steps; }
  bool exhausted() const { return steps_ >= most_; }

  /// @param parts  number of parts into which each command is cut
  bool move(VectorXd& q, VectorXd& u, const VectorXd& u_end, std::vector<dynamics::Knot>& knots, int parts = 1) {
    const VectorXd u_begin = u;
    for (int k = 1; k <= parts; ++k) {
      if (exhausted()) return false;
      const VectorXd to = k == parts ? u_end : VectorXd(u_begin + (u_end - u_begin) * (static_cast<double>(k) / parts));
      dynamics::RolloutResult r;
      const Status status = dynamics::rollout(model_, q, u, to, options_, limits_, work_, r);
      steps_ += r.steps;
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
  long steps_ = 0, most_;
};

/// The joints that a regrasp moves: 1 for these, else 0 (n_a).
VectorXd find_moving(const world::Model& model, const Segment& segment, const VectorXd& u_before) {
  VectorXd range = VectorXd::Zero(model.n_a());
  for (const dynamics::Knot& knot : segment.knots) range = range.cwiseMax((knot.u - u_before).cwiseAbs());
  return (range.cwiseQuotient(model.scales().joints()).array() > kMoves).cast<double>();
}

/// Simulates the rest of the plan from a place, with tracking. @returns false if a part of it cannot be simulated
bool go_on(const world::Model& model, Simulator& simulator, PoseTracker& tracker, const Plan& plan, const Place& from, double enough,
           VectorXd& q, VectorXd& u, Plan& out) {
  VectorXd u_before = from.u;
  for (std::size_t s = from.segment; s < plan.segments.size(); ++s) {
    const Segment& segment = plan.segments[s];
    if (segment.knots.empty()) continue;
    Segment& tracked = out.segments.emplace_back();
    tracked.kind = segment.kind, tracked.unstable = segment.unstable;
    const bool regrasps = segment.kind == SegmentKind::Regrasp;
    const VectorXd moving = regrasps ? find_moving(model, segment, u_before) : VectorXd();
    for (std::size_t k = s == from.segment ? from.knot : 0; k < segment.knots.size(); ++k) {
      const dynamics::Knot& knot = segment.knots[k];
      if (regrasps) {
        tracker.fade(moving, 1.0 / static_cast<double>(segment.knots.size() - k));
      } else {
        (void)tracker.update(q, knot.q, knot.u);  // a failed update keeps the correction before
        simulator.count(PoseTracker::kSteps);
      }
      if (!simulator.move(q, u, knot.u + tracker.delta(), tracked.knots)) return false;
    }
    u_before = segment.knots.back().u;
    if (simulator.share(q) <= enough) return true;
  }
  return true;
}

/// Simulates the commands of a plan in half steps. @returns distance of its end from the goal [tolerances]
double share_in_halves(Simulator& simulator, const Plan& plan) {
  VectorXd q = plan.q_start, u = plan.u_start;
  std::vector<dynamics::Knot> knots;
  for (const Segment& segment : plan.segments) {
    for (const dynamics::Knot& knot : segment.knots) {
      if (!simulator.move(q, u, knot.u, knots, 2)) return std::numeric_limits<double>::infinity();
    }
  }
  return simulator.share(q);
}

}  // namespace

Join join_plan(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan, VectorRef q, VectorRef u,
               const JoinOptions& options) {
  Join best;
  best.share = std::numeric_limits<double>::infinity();
  dynamics::StepWorkspace work(model);
  Simulator simulator(*model, plan, work, options.max_steps);
  PoseTracker tracker(model, plan.goal, plan.step);
  for (const Place& place : find_places(*model, plan, q, options)) {
    if (simulator.exhausted()) break;
    Plan tried = plan;
    tried.q_start = q, tried.u_start = u;
    tried.segments.clear();
    VectorXd q_at = q, u_at = u;
    work.forget();
    tracker.reset();
    if (!simulator.move(q_at, u_at, place.u, tried.segments.emplace_back(Segment{SegmentKind::Contact, {}}).knots)) continue;
    if (share_between(*model, q, q_at, plan.goal) > options.transit) continue;
    if (!go_on(*model, simulator, tracker, plan, place, options.enough, q_at, u_at, tried)) continue;
    const double share = simulator.share(q_at);
    if (share >= best.share) continue;
    tried.error = planning::goal_error(*model, q_at, plan.goal);
    best.plan = std::move(tried), best.share = share, best.segment = static_cast<int>(place.segment);
    if (share > options.enough) continue;
    work.forget();
    if (share_in_halves(simulator, best.plan) > 1) continue;
    best.status = Status::Solved;
    break;
  }
  best.steps = simulator.steps();
  return best;
}

}  // namespace stiction::execution
