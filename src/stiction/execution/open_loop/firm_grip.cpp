#include "stiction/execution/open_loop/firm_grip.hpp"

#include <algorithm>
#include <span>

#include "stiction/contact/carried.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {

std::vector<char> find_carried(const world::Model& model, const Trajectory& trajectory) {
  const contact::Carried carried(model);
  std::vector<char> out(static_cast<std::size_t>(trajectory.q.cols()), 0);
  if (!carried.possible()) return out;
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  contact::Workspace work(model);
  const auto go_to = [&](Eigen::Index k) { world::calc_kinematics(model, trajectory.q.col(k), kinematics_work, kinematics); };
  for (Eigen::Index k = 0; k < trajectory.q.cols(); ++k) {
    go_to(k);
    out[static_cast<std::size_t>(k)] = carried.any(kinematics, work) ? 1 : 0;
  }
  const auto lies_in_hand = [&](const Piece& push) {
    for (Eigen::Index k = push.first_knot; k <= push.last_knot; ++k) {
      go_to(k);
      if (carried.lies_in_hand(kinematics, work)) return true;
    }
    return false;
  };
  for (const Piece& piece : trajectory.pieces) {
    const auto knots = std::span(out).subspan(static_cast<std::size_t>(piece.first_knot),
                                              static_cast<std::size_t>(piece.last_knot - piece.first_knot + 1));
    const auto count = static_cast<std::size_t>(std::ranges::count(knots, char{1}));
    const bool lifts = piece.kind == planning::SegmentKind::Contact && count > 0 && count < knots.size();
    if (lifts && !lies_in_hand(piece)) std::ranges::fill(knots, char{1});
  }
  return out;
}

void tighten_grips(const world::Model& model, const std::vector<char>& carried, Trajectory& trajectory) {
  const double preload = world::share::kPreload * model.scales().robots().force;
  for (Eigen::Index k = 0; k < trajectory.u.cols(); ++k) {
    if (carried[static_cast<std::size_t>(k)] == 0) continue;
    const Eigen::VectorXd q_a = trajectory.q.col(k).tail(model.n_a()), strain = trajectory.u.col(k) - q_a;
    const double force = strain.cwiseProduct(model.stiffness()).cwiseQuotient(model.reach()).cwiseAbs().maxCoeff();
    if (force <= 0 || force >= preload) continue;
    trajectory.u.col(k) = (q_a + preload / force * strain).cwiseMax(model.command_lower()).cwiseMin(model.command_upper());
  }
}

}  // namespace stiction::execution
