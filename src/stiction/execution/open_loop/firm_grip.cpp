#include "stiction/execution/open_loop/firm_grip.hpp"

#include <algorithm>

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
  for (std::size_t k = 0; k < out.size(); ++k) {
    world::calc_kinematics(model, trajectory.q.col(static_cast<Eigen::Index>(k)), kinematics_work, kinematics);
    out[k] = carried.any(kinematics, work) ? 1 : 0;
  }
  for (const Piece& piece : trajectory.pieces) {
    const auto begin = out.begin() + piece.first_knot, end = out.begin() + piece.last_knot + 1;
    if (piece.kind == planning::SegmentKind::Contact && std::find(begin, end, char{1}) != end) std::fill(begin, end, char{1});
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
