#include "stiction/planning/node_models.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// Of disturbed steps [J·s]: as sharp as a barrier weight of 1e5/J, far below what a mean of 100 samples resolves; a fifth faster.
constexpr double kSampleComplementarity = 1e-6;

/// Diagonal of Γ: γ for what moves, and for what turns that of the way that it makes at its length L. The thesis has one number.
Eigen::VectorXd calc_gamma(const Model& model, const PlannerOptions& options) {
  Eigen::VectorXd gamma = Eigen::VectorXd::Constant(model.n_vu(), options.gamma);
  if (options.thesis_edges()) return gamma;
  for (int v = 0; v < model.n_vu(); ++v) {
    const world::Dof& dof = model.dofs()[static_cast<std::size_t>(v)];
    if (dof.kind == world::DofKind::Revolute) gamma[v] /= std::pow(model.scales().object(dof.owner).length, 2);
  }
  return gamma;
}

}  // namespace

NodeModels::NodeModels(const Setting& setting)
    : setting_(setting),
      joint_units_(setting.options.thesis_edges() ? Eigen::VectorXd() : setting.model.scales().joints()),
      gamma_(calc_gamma(setting.model, setting.options)),
      smoothed_(setting.options.step_options()) {
  smoothed_.warm_start = false;
  const Scheme scheme = setting.options.scheme;
  if (scheme == Scheme::RandomizedFirst || scheme == Scheme::RandomizedZeroth) smoothed_.tol_complementarity = kSampleComplementarity;
}

bool NodeModels::linearise(Node& node, std::uint64_t stream, ThreadScratch& scratch, Totals& totals) const {
  const Eigen::VectorXd u = preloaded_command(node);
  const Status status =
      dynamics::calc_local_model(setting_.model, {node.q, u}, scheme_at(node, stream), smoothed_, false, scratch.locals, scratch.local);
  return take_model(status, scratch.local.c, scratch.local.B, node, totals);
}

bool NodeModels::linearise_with_forces(Node& node, ThreadScratch& scratch, Totals& totals) const {
  dynamics::StepOptions smoothed = smoothed_;
  smoothed.smoothing = std::get<dynamics::Analytic>(scheme_at(node, 0));
  smoothed.with_B = true;
  smoothed.with_force_derivatives = true;
  const Eigen::VectorXd u = preloaded_command(node);
  const Status status = dynamics::step(setting_.model, {node.q, u}, smoothed, scratch.steps, scratch.step_result);
  return take_model(status, scratch.step_result.q_next, scratch.step_result.B, node, totals);
}

Eigen::VectorXd NodeModels::preloaded_command(const Node& node) const {
  const Eigen::VectorXd u = node.q.tail(setting_.model.n_a());
  if (setting_.options.grip_force == 0) return u;
  const Eigen::ArrayXd strain = (node.u - u).array();
  const double force = (strain * setting_.model.stiffness().array() / setting_.model.reach().array()).abs().maxCoeff();
  return u + (force > setting_.options.grip_force ? setting_.options.grip_force / force : 1.0) * strain.matrix();
}

dynamics::LocalModelScheme NodeModels::scheme_at(const Node& node, std::uint64_t stream) const {
  return setting_.options.local_model_scheme(
      stream, std::clamp(setting_.options.goal_sharpening / setting_.goal.ratio(node.q), 1.0, setting_.options.goal_sharpening));
}

bool NodeModels::take_model(Status status, const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, Node& node, Totals& totals) const {
  ++totals.linearisations;
  if (status != Status::Solved) {
    ++totals.failed_steps;
    return false;
  }
  node.local.set(q_next, B, setting_.model.n_qu(), gamma_, joint_units_);
  return true;
}

}  // namespace stiction::planning
