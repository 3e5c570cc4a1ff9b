#include "stiction/planning/node_models.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// Diagonal of Γ: γ for coordinates that move, γ/L² for coordinates that turn, with L of their object.
Eigen::VectorXd calc_gamma(const Model& model, double gamma) {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(model.n_vu(), gamma);
  for (int v = 0; v < model.n_vu(); ++v) {
    const world::Dof& dof = model.dofs()[static_cast<std::size_t>(v)];
    if (dof.kind == world::DofKind::Revolute) out[v] /= std::pow(model.scales().object(dof.owner).length, 2);
  }
  return out;
}

}  // namespace

NodeModels::NodeModels(const Setting& setting)
    : setting_(setting), gamma_(calc_gamma(setting.model, setting.thresholds.gamma)), smoothed_(setting.exact) {
  smoothed_.warm_start = false;
  smoothed_.friction_law = dynamics::FrictionLaw::Anitescu;  // the central path has no shift of Coulomb's law
}

bool NodeModels::linearise(Node& node, bool with_forces, ThreadScratch& scratch, Totals& totals) const {
  dynamics::StepOptions smoothed = smoothed_;
  smoothed.smoothing = smoothing_at(node);
  smoothed.with_B = true;
  smoothed.with_force_derivatives = with_forces;
  const Eigen::VectorXd u = preloaded_command(node);
  ++totals.linearisations;
  if (dynamics::step(setting_.model, {node.q, u}, smoothed, scratch.steps, scratch.step_result) != Status::Solved) {
    ++totals.failed_steps;
    return false;
  }
  node.local.set(scratch.step_result.q_next, scratch.step_result.B, setting_.model.n_qu(), gamma_, setting_.model.scales().joints());
  return true;
}

Eigen::VectorXd NodeModels::preloaded_command(const Node& node) const {
  const Eigen::VectorXd u = node.q.tail(setting_.model.n_a());
  if (!setting_.options.uses(Mechanism::Preload)) return u;
  const Eigen::ArrayXd strain = (node.u - u).array();
  const double force = (strain * setting_.model.stiffness().array() / setting_.model.reach().array()).abs().maxCoeff();
  return u + (force > setting_.thresholds.preload ? setting_.thresholds.preload / force : 1.0) * strain.matrix();
}

dynamics::Analytic NodeModels::smoothing_at(const Node& node) const {
  dynamics::Analytic smoothing = setting_.thresholds.smoothing;
  if (setting_.options.uses(Mechanism::Sharpening))
    smoothing.kappa *= std::clamp(threshold::kSharpening / setting_.goal.ratio(node.q), 1.0, threshold::kSharpening);
  return smoothing;
}

}  // namespace stiction::planning
