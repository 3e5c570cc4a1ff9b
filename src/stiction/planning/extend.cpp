#include "stiction/planning/extend.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/cone/bounded_least_squares.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

/// Contacts farther apart than this do not bound an extension by their forces: those are tiny, and their linear models of no use [L].
constexpr double kForceReach = 0.1;
/// Where a local model knows one direction only, all subgoals give the same command: another one nearer than this share of its length
/// is not tried again from the same node.
constexpr double kSameCommand = 0.1;
/// What a command of a joint unit counts for, beside the error that it leaves of the objects [L].
constexpr double kWorth = 0.02;
/// A shorter extension is none [joint units].
constexpr double kNoMove = 1e-9;

}  // namespace

Extend::Extend(const Setting& setting, const NodeModels& models, const EdgeSimulator& simulator)
    : setting_(setting), models_(models), simulator_(simulator) {
  const world::Model& model = setting.model;
  const bool thesis = setting.options.thesis_edges();
  units_ = thesis ? Eigen::VectorXd::Ones(model.n_a()) : model.scales().joints();
  weights_ = thesis ? Eigen::VectorXd::Ones(model.n_vu()) : setting.goal.lengths();
  damping_ = thesis ? setting.options.gamma : std::pow(kWorth * model.scales().object(setting.goal.object()).length, 2);
}

bool Extend::try_edge(const Node& near, Expansion& x, ThreadScratch& scratch, Eigen::VectorXd& u, Node& out) const {
  const Eigen::VectorXd q_a = models_.preloaded_command(near);
  Eigen::VectorXd e = setting_.goal.difference(near.local.c_u, x.target(setting_.goal, near.local.c_u));
  // Aim with the mean of the two resolutions. A node that is new to the second has only the first: its next command is another one then.
  if (!near.replay.empty()) e -= 0.5 * setting_.goal.difference(near.q, near.replay.q_fine);
  if (x.in_cones) {  // the tree keeps no forces
    scratch.candidate.q = near.q;
    scratch.candidate.u = near.u;
    if (!models_.linearise_with_forces(scratch.candidate, scratch, x.totals)) return false;
  }
  const Eigen::VectorXd delta_u =
      extension(near.local, q_a, e, x.to_goal, x.in_cones ? &scratch.step_result : nullptr, scratch.least_squares);
  if (delta_u.cwiseQuotient(units_).norm() < kNoMove) return false;
  const Eigen::VectorXd wanted = (q_a + delta_u).cwiseMax(setting_.model.lower()).cwiseMin(setting_.model.upper());
  const double same = kSameCommand * (wanted - q_a).norm();
  if (std::any_of(near.tried.begin(), near.tried.end(), [&](const auto& tried) { return (tried - wanted).norm() < same; })) return false;
  if (!setting_.options.thesis_edges()) u = wanted;
  if (!simulator_.move(near, wanted, scratch, x.totals, out)) return false;
  out.edge = SegmentKind::Contact;
  return simulator_.moves(near, out);
}

Eigen::VectorXd Extend::extension(const LocalModel& local, const Eigen::VectorXd& q_a, const Eigen::VectorXd& e, bool to_goal,
                                  const dynamics::StepResult* forces, cone::ConeLeastSquares& least_squares) const {
  const Eigen::VectorXd lower = (setting_.model.lower() - q_a).cwiseMin(0.0).cwiseQuotient(units_),
                        upper = (setting_.model.upper() - q_a).cwiseMax(0.0).cwiseQuotient(units_);
  Eigen::VectorXd y, w = weights_;  // δu in joint units, with which lengths mean the same to sliders and to hinges
  if (to_goal) w = w.cwiseProduct(setting_.goal.bounded()).eval();
  const Eigen::MatrixXd B = w.asDiagonal() * local.B_u * units_.asDiagonal();
  const Eigen::VectorXd we = w.cwiseProduct(e);
  if (forces != nullptr) add_force_cones(*forces, least_squares);
  if (forces == nullptr || !least_squares.solve(B, we, damping_, lower, upper, y))
    cone::solve_bounded_least_squares(B, we, damping_, lower, upper, y);
  const double length = y.norm();
  if (length >= kNoMove) {
    if (const auto* fixed = std::get_if<FixedLength>(&setting_.options.length)) {
      y *= fixed->length / length;
    } else {
      y *= std::min(1.0, std::get<CappedLength>(setting_.options.length).length / length);
    }
  }
  return units_.cwiseProduct(y);
}

void Extend::add_force_cones(const dynamics::StepResult& step, cone::ConeLeastSquares& least_squares) const {
  least_squares.clear_cones();
  Eigen::MatrixXd G(3, setting_.model.n_a());
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    const auto& c = step.contacts[i];
    const double mu = c.contact.friction * simulator_.exact().friction_scale;
    if (c.contact.phi > kForceReach * setting_.model.scales().pair(c.contact.pair).length || mu <= 0 ||
        !setting_.chains.touches_object(c.contact.pair) || setting_.chains.mask_of_pair(c.contact.pair) == 0)
      continue;
    const auto D = step.D_lambda_u[i];
    G.row(0) = mu * D.row(0);
    G.bottomRows(2) = D.bottomRows(2);
    G *= units_.asDiagonal();
    const double scale = G.cwiseAbs().maxCoeff();
    if (!(scale > 0)) continue;
    G /= scale;
    least_squares.add_cone(G, Eigen::Vector3d(mu * c.lambda[0], c.lambda[1], c.lambda[2]) / scale);
  }
}

}  // namespace stiction::planning
