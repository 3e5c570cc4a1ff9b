#include "stiction/planning/extend.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/cone/bounded_least_squares.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

/// An extension must turn the robot or an object at least this far [rad], or move it by this share of L, to be worth a node.
constexpr double kLeastTurn = 1e-4, kLeastMove = 1e-3;
/// Shorter extensions count as none [joint units].
constexpr double kNoMove = 1e-9;

}  // namespace

Extend::Extend(const Setting& setting, const NodeModels& models)
    : setting_(setting),
      models_(models),
      units_(setting.model.scales().joints()),
      weights_(setting.goal.lengths()),
      damping_(std::pow(threshold::kWorth * setting.model.scales().object(setting.goal.object()).length, 2)) {}

bool Extend::try_edge(const Node& near, Expansion& x, ThreadScratch& scratch, Eigen::VectorXd& u, Node& out) const {
  const ProfileClock::Scope scope(scratch.profile, Activity::Extensions);
  const Eigen::VectorXd q_a = models_.preloaded_command(near);
  const Eigen::VectorXd e = setting_.goal.difference(near.local.c_u, x.target(setting_.goal, near.local.c_u));
  if (x.in_cones) {  // the tree stores no forces
    const ProfileClock::Scope again(scratch.profile, Activity::LocalModels);
    scratch.candidate.q = near.q;
    scratch.candidate.u = near.u;
    if (!models_.linearise(scratch.candidate, true, scratch, x.totals)) return false;
  }
  const Eigen::VectorXd delta_u =
      extension(near.local, q_a, e, x.counted, x.in_cones ? &scratch.step_result : nullptr, scratch.least_squares);
  if (delta_u.cwiseQuotient(units_).norm() < kNoMove) return false;
  const Eigen::VectorXd wanted = (q_a + delta_u).cwiseMax(setting_.model.command_lower()).cwiseMin(setting_.model.command_upper());
  const double same = threshold::kSameCommand * (wanted - q_a).norm();
  if (std::any_of(near.tried.begin(), near.tried.end(), [&](const auto& tried) { return (tried - wanted).norm() < same; })) return false;
  u = wanted;
  const ProfileClock::Scope pushing(scratch.profile, Activity::Pushes);
  return push(near, wanted, scratch, x.totals, out) && moves(near, out);
}

bool Extend::push(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const {
  const bool long_slips = setting_.exact.friction_law == dynamics::FrictionLaw::Coulomb;  // on long slips, round surfaces separate
  const Watch watch{.most = {kMostEdgePenetration, long_slips ? kMostForceGap : kUnlimited, kMostPress}, .brace = true};
  Trace trace{.q = from.q, .u = from.u};
  scratch.steps.forget();
  const Ending ending = Simulation(setting_, scratch, totals).follow(u, substeps(setting_), watch, trace);
  if (ending == Ending::Unsolved || ending == Ending::Stopped || trace.knots.empty()) return false;
  if (calc_penetration(setting_.model, trace.q, scratch.geometry) > kMostFinePenetration) return false;  // no step has checked this state
  to.edge = SegmentKind::Contact;
  set_edge(trace.knots, setting_.model, to);
  return true;
}

bool Extend::moves(const Node& from, const Node& to) const {
  Eigen::VectorXd moved(setting_.model.n_v());
  moved << setting_.goal.difference(from.q, to.q), (to.q - from.q).tail(setting_.model.n_a());
  for (int v = 0; v < setting_.model.n_v(); ++v) {
    const world::Dof& dof = setting_.model.dofs()[static_cast<std::size_t>(v)];
    const world::Scale& scale = v < setting_.model.n_vu() ? setting_.model.scales().object(dof.owner) : setting_.model.scales().robots();
    if (std::abs(moved[v]) > (dof.kind == world::DofKind::Revolute ? kLeastTurn : kLeastMove * scale.length)) return true;
  }
  return false;
}

Eigen::VectorXd Extend::extension(const LocalModel& local, const Eigen::VectorXd& q_a, const Eigen::VectorXd& e,
                                  const Eigen::VectorXd& counted, const dynamics::StepResult* forces,
                                  cone::ConeLeastSquares& least_squares) const {
  // Only the preload of a grip goes beyond the joint limits: farther pushes would press with hundreds of times the weight of an object.
  const Eigen::VectorXd lower = (setting_.model.lower() - q_a).cwiseMin(0.0).cwiseQuotient(units_),
                        upper = (setting_.model.upper() - q_a).cwiseMax(0.0).cwiseQuotient(units_);
  Eigen::VectorXd y;  // δu in joint units, in which lengths mean the same for sliders and hinges
  const Eigen::VectorXd w = weights_.cwiseProduct(counted);
  const Eigen::MatrixXd B = w.asDiagonal() * local.B_u * units_.asDiagonal();
  const Eigen::VectorXd we = w.cwiseProduct(e);
  if (forces != nullptr) add_force_cones(*forces, least_squares);
  if (forces == nullptr || !least_squares.solve(B, we, damping_, lower, upper, y))
    cone::solve_bounded_least_squares(B, we, damping_, lower, upper, y);
  const double length = y.norm();
  if (length > threshold::kLength) y *= threshold::kLength / length;
  return units_.cwiseProduct(y);
}

void Extend::add_force_cones(const dynamics::StepResult& step, cone::ConeLeastSquares& least_squares) const {
  least_squares.clear_cones();
  Eigen::MatrixXd G(3, setting_.model.n_a());
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    const auto& c = step.contacts[i];
    const double mu = c.contact.friction * setting_.exact.friction_scale;
    if (c.contact.phi > threshold::kForceReach * setting_.model.scales().pair(c.contact.pair).length || mu <= 0 ||
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
