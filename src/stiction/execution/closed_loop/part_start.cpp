#include "stiction/execution/closed_loop/part_start.hpp"

#include <algorithm>

#include "stiction/contact/contact.hpp"
#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using world::Model;

/// Finds the deepest overlap among the pairs that overlap by more than a share of the contact tolerance.
class OverlapFinder {
 public:
  explicit OverlapFinder(const Model& model) : model_(model), work_(model), contact_work_(model) {}

  struct Overlap {
    int pair = -1;
    double depth = 0;  ///< depth of the overlap [m]
  };
  Overlap find(const Eigen::VectorXd& q, double share) {
    world::calc_kinematics(model_, q, work_, kinematics_);
    Overlap out;
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      const double least = share * world::share::kContact * model_.scales().pair(i).length;
      if (contact::calc_pair_lower_bound(model_, kinematics_, i, contact_work_) > -least) continue;
      const double depth = -contact::pair_distance(model_, kinematics_, i, contact_work_).phi;
      if (depth > least && depth > out.depth) out = {i, depth};
    }
    return out;
  }

 private:
  const Model& model_;
  world::KinematicsWorkspace work_;
  contact::Workspace contact_work_;
  world::Kinematics kinematics_{};
};

}  // namespace

PartedStart part_start(const std::shared_ptr<const Model>& model, const Eigen::VectorXd& q, dynamics::StepOptions options) {
  constexpr int kSteps = 30;
  constexpr double kApart = 0.1;
  PartedStart out{.q = q};
  OverlapFinder overlaps(*model);
  const OverlapFinder::Overlap given = overlaps.find(q, 1);
  if (given.pair < 0) return out;
  options.smoothing = dynamics::Exact{};
  options.with_A = options.with_B = options.with_force_derivatives = options.effort_limits = false;
  dynamics::StepWorkspace work(model);
  dynamics::StepResult step;
  const auto joints = [&](const Eigen::VectorXd& at) {
    return at.tail(model->n_a()).cwiseMax(model->lower()).cwiseMin(model->upper()).eval();
  };
  for (int k = 0; k < kSteps && overlaps.find(out.q, kApart).pair >= 0; ++k) {
    if (dynamics::step(*model, {out.q, joints(out.q)}, options, work, step) != Status::Solved) break;
    out.q = step.q_next;
  }
  out.overlap = given.depth;
  out.pair = given.pair;
  Eigen::VectorXd e(model->n_vu());
  world::ObjectSpace(*model).error(q.data(), out.q.data(), e.data());
  out.moved = world::largest_share(*model, e, 1, 1);
  return out;
}

}  // namespace stiction::execution
