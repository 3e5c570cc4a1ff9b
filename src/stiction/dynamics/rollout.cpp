#include "stiction/dynamics/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics {
namespace {

using core::Status;

/// Largest number of times that a sub-step is repeated with half the command. An object that slides because a spring relaxes or gravity
/// pulls slides even with a tiny command.
constexpr int kMaxHalvings = 4;
/// Largest number of times that a command is cut. With Coulomb's law a cut command may lead to another solution, in which another motor
/// saturates.
constexpr int kMostCuts = 8;
/// Share of the effort by which a cut command stays below it, equal to the accuracy of a step. The step from the cut command is then within
/// the effort and needs no further change. With Coulomb's law even a tiny change of the command after its step may lead to another
/// solution.
constexpr double kCutShort = 5e-4;

/// Largest μ·slip of an active contact. The factor μ lets an object on a slippery floor move far in a sub-step.
double largest_slide(const StepResult& result) {
  double slide = 0;
  for (const auto& c : result.contacts) {
    if (c.active) slide = std::max(slide, c.contact.friction * c.slide());
  }
  return slide;
}

/// True if a force acts across a gap. With Coulomb's law this happens only if its solution was not found.
bool has_gap(const world::Model& model, const StepResult& result) {
  return std::ranges::any_of(
      result.contacts, [&](const auto& c) { return c.active && c.anitescu_gap() > model.scales().contact_tolerance(c.contact.pair); });
}

double largest_move(const world::Model& model, int joint, const SubstepLimits& limits) {
  const auto& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + joint)];
  return dof.kind == world::DofKind::Revolute ? limits.joint_angle : limits.joint_travel;
}

void clear(RolloutResult& out) {
  out.knots.clear();
  out.steps = 0;
  out.max_slide = 0;
  out.penetration = 0;
  out.min_phi = 0;
  out.status = Status::Solved;
}

/// Moves each joint of u back towards u_now until no joint goes farther than a sub-step may.
void clamp_to_substep(const world::Model& model, const Eigen::VectorXd& u_now, const SubstepLimits& limits, Eigen::VectorXd& u) {
  for (int j = 0; j < model.n_a(); ++j) {
    const double most = largest_move(model, j, limits);
    u[j] = u_now[j] + std::clamp(u[j] - u_now[j], -most, most);
  }
}

/// Stores the sub-step as the next knot.
void add_knot(const world::Model& model, const Eigen::VectorXd& u, const StepResult& step, RolloutResult& out) {
  if (!out.knots.empty()) {
    for (const auto& c : step.contacts) {
      out.min_phi = std::min(out.min_phi, c.contact.phi);
      out.penetration = std::max(out.penetration, -c.contact.phi / model.scales().contact_tolerance(c.contact.pair));
    }
  }
  Knot& knot = out.knots.emplace_back();
  knot.u = u;
  knot.q = step.q_next;
  for (const auto& c : step.contacts) {
    if (c.active) knot.contacts.push_back(c);
  }
}

}  // namespace

void SubstepLimits::validate() const {
  core::require_positive("substep.joint_angle", joint_angle);
  core::require_positive("substep.joint_travel", joint_travel);
  core::require_positive("substep.slide", slide);
  if (max_substeps < 1) core::throw_invalid("substep.max_substeps", std::to_string(max_substeps), "at least 1");
}

Status step_within_efforts(const world::Model& model, VectorRef q, Eigen::VectorXd& u, const StepOptions& options, StepWorkspace& work,
                           StepResult& out, int& steps) {
  for (int round = 0;; ++round) {
    ++steps;
    const Status status = step(model, {q, u}, options, work, out);
    if (status != Status::Solved) return status;
    bool cut = false;
    for (int j = 0; j < model.n_a(); ++j) {
      if (!out.saturated[static_cast<std::size_t>(j)]) continue;
      const double strain = out.torque[j] / model.stiffness()[j], q_j = out.q_next[model.n_qu() + j];
      if (std::abs(u[j] - q_j) <= std::abs(strain)) continue;
      u[j] = q_j + (1 - kCutShort) * strain;
      cut = true;
    }
    if (!cut) return status;
    if (round == kMostCuts) return Status::NumericalFailure;
  }
}

int count_substeps(const world::Model& model, VectorRef u_start, VectorRef u_end, const SubstepLimits& limits) {
  double n = 1;
  for (int j = 0; j < model.n_a(); ++j) {
    n = std::max(n, std::ceil(std::abs(u_end[j] - u_start[j]) / largest_move(model, j, limits) * (1 - 1e-12)));
  }
  return static_cast<int>(n);
}

Status rollout(const world::Model& model, VectorRef q, VectorRef u_start, VectorRef u_end, const StepOptions& options,
               const SubstepLimits& limits, StepWorkspace& work, RolloutResult& out, Overrun overrun, const core::RunControl* control) {
  limits.validate();
  core::require_size("u_start", u_start.size(), model.n_a());
  core::require_size("u_end", u_end.size(), model.n_a());
  clear(out);
  const double ds_max = 1.0 / count_substeps(model, u_start, u_end, limits);
  const double ds_min = ds_max / (1 << kMaxHalvings);
  Eigen::VectorXd q_now = q;
  Eigen::VectorXd u(model.n_a()), u_next(model.n_a()), u_now = u_start;
  bool behind = false;  // u_now is not on the line from u_start to u_end
  StepResult step_result;
  double s = 0;
  double ds = ds_max;
  while (s < 1.0) {
    if (control != nullptr && control->stop()) return out.status = control->status_when_stopped();
    const bool last = s + ds >= 1.0 - 1e-9;
    const double s_next = last ? 1.0 : s + ds;
    u = (1 - s_next) * u_start + s_next * u_end;
    if (behind) clamp_to_substep(model, u_now, limits, u);
    u_next = u;
    out.status = step_within_efforts(model, q_now, u_next, options, work, step_result, out.steps);
    if (out.status != Status::Solved) return out.status;
    const double slide = largest_slide(step_result);
    const bool far = slide > limits.slide || (options.friction_law == FrictionLaw::Coulomb && has_gap(model, step_result));
    // A joint that its motor cannot hold drags its command along, possibly farther than a sub-step allows.
    const bool recoils = u_next != u && count_substeps(model, u_now, u_next, limits) > 1;
    if ((far || recoils) && ds > ds_min * (1 + 1e-9)) {
      ds = std::max(ds_min, 0.5 * ds);
      continue;
    }
    if (recoils || (far && overrun == Overrun::Stop)) return out.status = Status::MaxIterations;
    out.max_slide = std::max(out.max_slide, slide);
    add_knot(model, u_next, step_result, out);
    q_now = step_result.q_next;
    behind = behind || u_next != u;
    u_now = u_next;
    s = s_next;
    if (slide < 0.4 * limits.slide) ds = std::min(ds_max, 2 * ds);
    if (static_cast<int>(out.knots.size()) >= limits.max_substeps && s < 1.0) return out.status = Status::MaxIterations;
  }
  return out.status;
}

}  // namespace stiction::dynamics
