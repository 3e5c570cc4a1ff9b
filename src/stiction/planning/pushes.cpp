#include "stiction/planning/pushes.hpp"

#include <algorithm>
#include <utility>

namespace stiction::planning {

std::vector<Push> split_at_regrasps(const Plan& plan) {
  std::vector<Push> pushes;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  Eigen::VectorXd u_regrasp = u;
  std::optional<Segment> regrasp;
  bool open = false;  // the next contact edge belongs to the last push
  for (const Segment& segment : plan.segments) {
    if (segment.knots.empty()) continue;
    if (segment.kind == SegmentKind::Regrasp) {
      if (regrasp) {  // two regrasps in a row
        regrasp->knots.insert(regrasp->knots.end(), segment.knots.begin(), segment.knots.end());
      } else {
        regrasp = segment;
        u_regrasp = u;
      }
      open = false;
    } else if (segment.kind == SegmentKind::Contact) {
      if (!open) pushes.push_back({q, u, {}, std::move(regrasp), u_regrasp, false});
      regrasp.reset();
      pushes.back().edges.push_back(segment);
      open = true;
    }
    q = segment.knots.back().q;
    u = segment.knots.back().u;
  }
  return pushes;
}

void cut_tails(const Motion& motion, std::vector<Push>& pushes) {
  constexpr double kStill = 0.1;
  for (Push& push : pushes) {
    const Eigen::VectorXd q_end = push.edges.back().knots.back().q;
    while (!push.edges.empty()) {
      auto& knots = push.edges.back().knots;
      while (knots.size() > 1 && motion.share(knots[knots.size() - 2].q, q_end) <= kStill) knots.pop_back();
      const bool whole = knots.size() == 1 && push.edges.size() > 1;
      if (!whole || motion.share(push.edges[push.edges.size() - 2].knots.back().q, q_end) > kStill) break;
      push.edges.pop_back();
    }
  }
}

void drop_pushes(const Motion& motion, std::vector<Push>& pushes) {
  const auto moves_something = [&](const Push& push) {
    return std::any_of(push.edges.begin(), push.edges.end(), [&](const Segment& edge) {
      return std::any_of(edge.knots.begin(), edge.knots.end(), [&](const auto& knot) { return motion.share(push.q_entry, knot.q) > 1; });
    });
  };
  std::vector<Push> kept;
  bool dropped = false;
  for (const Push& push : pushes) {
    const bool keep = moves_something(push);
    if (keep) kept.push_back(push), kept.back().merged = dropped;
    dropped = !keep;
  }
  if (!kept.empty()) pushes = std::move(kept);
}

}  // namespace stiction::planning
