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
  std::vector<char> in_hand(out.size(), 0);
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  contact::Workspace work(model);
  for (std::size_t k = 0; k < out.size(); ++k) {
    world::calc_kinematics(model, trajectory.q.col(static_cast<Eigen::Index>(k)), kinematics_work, kinematics);
    out[k] = carried.any(kinematics, work) ? 1 : 0;
    in_hand[k] = carried.lies_in_hand(kinematics, work) ? 1 : 0;
  }
  for (const Piece& piece : trajectory.pieces) {
    const auto knots = [&](std::vector<char>& of) {
      return std::span(of).subspan(static_cast<std::size_t>(piece.first_knot),
                                   static_cast<std::size_t>(piece.last_knot - piece.first_knot + 1));
    };
    const auto any = [&](std::vector<char>& of) { return std::ranges::find(knots(of), char{1}) != knots(of).end(); };
    if (piece.kind == planning::SegmentKind::Contact && any(out) && !any(in_hand)) std::ranges::fill(knots(out), char{1});
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
