#include "stiction/dynamics/working_set.hpp"

#include <algorithm>
#include <limits>

#include "stiction/dynamics/rim.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// An exact step starts with the rows that it may reach: contacts with objects nearer than this, contacts among robot parts that the
/// command brings nearer than this (S.6), and joint limits likewise. If the solution violates other rows, they are added and the step is
/// solved again. The result is that of the full problem, because a row with slack has a zero multiplier.
/// Coulomb's law uses a larger distance: a row that is added late moves the fixed point, and each shift costs a solve
/// (docs/lab/coulomb_rows.md).
constexpr double kNearContact = 0.02, kNearContactCoulomb = 0.05;  // share of L of the pair (world::Scales)
constexpr double kNearLimit = 0.02;                                // share of the unit of the joint
/// If an approximate δq is known, the first rows are those with less slack than this under it.
constexpr double kGuessContact = 0.01;  // share of L
constexpr double kGuessLimit = 0.01;    // share of the unit of the joint

}  // namespace

double object_travel(const Model& model, const StepWorkspace::Impl& work, std::size_t o, const Eigen::VectorXd& delta) {
  const auto objects = model.objects();
  double translation = 0, rotation = 0;
  for (int i = objects[o].v_begin; i < objects[o].v_begin + objects[o].n_v; ++i) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
    (revolute ? rotation : translation) += std::abs(delta[i]);
  }
  double sum = translation + rotation * work.object_radius[o];
  for (int p = objects[o].parent; p >= 0; p = objects[at(p)].parent) {  // its parents carry the object along
    const double arm = (work.kinematics.X_WB[at(objects[o].body)].p - work.kinematics.X_WB[at(objects[at(p)].body)].p).norm();
    for (int i = objects[at(p)].v_begin; i < objects[at(p)].v_begin + objects[at(p)].n_v; ++i) {
      const bool revolute = model.dofs()[at(i)].kind == world::DofKind::Revolute;
      sum += std::abs(delta[i]) * (revolute ? arm + work.object_radius[o] : 1.0);
    }
  }
  return sum;
}

double motion_bound(const Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta) {
  double bound = 0;
  for (const auto& robot : model.robots()) {
    double sum = 0;  // one branch may carry another, so the sum over branches bounds every motion
    for (const auto& chain : robot.chains) {
      for (const int v : chain) sum += model.reach()[v - model.n_vu()] * std::abs(delta[v]);
    }
    bound = std::max(bound, sum);
  }
  for (std::size_t o = 0; o < model.objects().size(); ++o) bound = std::max(bound, object_travel(model, work, o, delta));
  return bound;
}

Eigen::Vector3d displacement(const Model& model, std::size_t i, const Eigen::VectorXd& delta, const StepWorkspace::Impl& work) {
  const auto pair = static_cast<std::size_t>(work.contacts[i].pair);
  const auto& variables = model.supports()[static_cast<std::size_t>(model.pairs()[pair].support)];
  const std::size_t k = variables.size();
  const double* J = jacobian(work, i);
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < k; ++c) {
    const double x = delta[variables[c]];
    for (std::size_t r = 0; r < 3; ++r) v[static_cast<Eigen::Index>(r)] += J[r * k + c] * x;
  }
  return v;
}

double slack(const StepWorkspace::Impl& work, double phi, double mu, const Eigen::Vector3d& v) {
  if (work.rays.empty()) return phi + v[0] - mu * v.tail<2>().norm();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& d : work.rays) least = std::min(least, phi + v[0] + mu * d.dot(v.tail<2>()));
  return least;
}

namespace {

/// Smaller one of the gap of a self-contact now and its first-order gap after the commanded motion (S.6) [m].
double least_commanded_gap(const Model& model, const StepOptions& options, std::size_t i, const StepWorkspace::Impl& work) {
  const contact::Contact& contact = work.contacts[i];
  const Eigen::Vector3d v = displacement(model, i, work.commanded, work);
  return row_gap(work, i) + std::min(0.0, v[0] - contact.friction * options.friction_scale * v.tail<2>().norm());
}

}  // namespace

void include_smoothed(const Model& model, const StepInput& in, const StepOptions& options, double self_sharpness, double least_share,
                      StepWorkspace::Impl& work) {
  const double near_self = (model.scene().contact_distance + options.contact_margin) / self_sharpness;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const bool self = work.self_contact[at(work.contacts[i].pair)] != 0;
    work.included[i] = (!self || least_commanded_gap(model, options, i, work) < near_self) &&
                       std::max(barrier_share(model, work.kinematics, work.contacts[i]), least_share) > kLeastShare;
  }
  for_each_limit(model, in, work,
                 [&](int variable, double sign, double) { work.limit_included[limit_id(variable, sign)] = options.joint_limits; });
}

void include_within_reach(const Model& model, const StepInput& in, const StepOptions& options, bool closed, StepWorkspace::Impl& work) {
  const double reach = closed ? kNearContactCoulomb : kNearContact;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const int pair = work.contacts[i].pair;
    const double gap = work.self_contact[at(pair)] != 0 ? least_commanded_gap(model, options, i, work) : row_gap(work, i);
    work.included[i] = gap < reach * model.scales().pair(pair).length;
  }
  for_each_limit(model, in, work, [&](int variable, double sign, double offset) {
    const int j = variable - model.n_vu();
    const double commanded = j < 0 ? 0.0 : std::abs(in.u[j] - in.q[model.n_qu() + j]);
    const double near = kNearLimit * work.variable_unit[at(variable)].length;
    work.limit_included[limit_id(variable, sign)] = options.joint_limits && offset < near + commanded;
  });
}

void include_near(const Model& model, const StepInput& in, const StepOptions& options, const Eigen::VectorXd& guess,
                  StepWorkspace::Impl& work) {
  const double motion = 2 * motion_bound(model, work, guess);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const double phi = row_gap(work, i), mu = work.contacts[i].friction * options.friction_scale;
    const double near = kGuessContact * model.scales().pair(work.contacts[i].pair).length;
    work.included[i] = phi < near + (1 + mu) * motion && slack(work, phi, mu, displacement(model, i, guess, work)) < near;
  }
  for_each_limit(model, in, work, [&](int variable, double sign, double offset) {
    const double near = kGuessLimit * work.variable_unit[at(variable)].length;
    work.limit_included[limit_id(variable, sign)] = options.joint_limits && sign * guess[variable] + offset < near;
  });
}

void include_met(StepWorkspace::Impl& work) {
  std::fill(work.included.begin() + static_cast<std::ptrdiff_t>(work.near_contacts), work.included.end(), char{1});
}

void include_all(const StepOptions& options, StepWorkspace::Impl& work) {
  std::ranges::fill(work.included, char{1});
  if (options.joint_limits) std::ranges::fill(work.limit_included, char{1});
}

bool saturate_motors(const Model& model, const StepInput& in, StepWorkspace::Impl& work) {
  bool any = false;
  for (int j = 0; j < model.n_a(); ++j) {
    const double pull = model.stiffness()[j] * (in.u[j] - in.q[model.n_qu() + j] - work.solution.x[model.n_vu() + j]);
    auto& side = work.motor[at(j)];
    if (side <= 0 && pull > model.effort()[j]) side = 1, any = true;
    if (side >= 0 && pull < -model.effort()[j]) side = -1, any = true;
  }
  return any;
}

bool add_violated(const Model& model, const StepInput& in, const StepOptions& options, bool closed, StepWorkspace::Impl& work) {
  bool any = false;
  const double motion = 2 * motion_bound(model, work, work.solution.x);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (work.included[i]) continue;
    const double phi = row_gap(work, i), mu = work.contacts[i].friction * options.friction_scale;
    work.moved[i].setZero();
    if (phi > (1 + mu) * motion) continue;
    work.moved[i] = displacement(model, i, work.solution.x, work);
    if (slack(work, phi, closed ? 0.0 : mu, work.moved[i]) < 0) work.included[i] = 1, any = true;
  }
  if (!options.joint_limits) return any;
  for_each_limit(model, in, work, [&](int variable, double sign, double offset) {
    auto& included = work.limit_included[limit_id(variable, sign)];
    if (!included && sign * work.solution.x[variable] + offset < 0) included = 1, any = true;
  });
  return any;
}

}  // namespace stiction::dynamics::detail
