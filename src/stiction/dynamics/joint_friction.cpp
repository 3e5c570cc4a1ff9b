#include "stiction/dynamics/joint_friction.hpp"

#include <algorithm>

#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// Largest creep of a sticking joint per step at a load of τ_f, as a share of L of a sliding object or of 1 rad. A thousand steps then move
/// the joint by less than the motionless threshold. One step moves it by no more than the gap that a contact keeps at the smallest force
/// that counts (1e-10 · 5 L / 3e-4).
constexpr double kCreep = 1e-3 * world::share::kMotionless;

/// σ of a friction row in smoothed steps, as a share of h·τ_f²/k. Motors use the same rule.
constexpr double kCornerSharpness = 1e-6;

std::uint64_t friction_id(const StepWorkspace::Impl& work, int v) {
  return static_cast<std::uint64_t>(2 * work.model->n_v() + work.model->n_a() + v);
}

double pull(const StepWorkspace::Impl& work, const FrictionJoint& joint) { return -joint.stiction * work.solution.x[joint.v]; }

}  // namespace

std::vector<FrictionJoint> find_friction_joints(const Model& model) {
  std::vector<FrictionJoint> out;
  for (int v = 0; v < model.n_vu(); ++v) {
    if (const double friction = model.dofs()[at(v)].friction; friction > 0) out.push_back({.v = v, .friction = friction});
  }
  return out;
}

void set_stiction(const Model& model, const StepOptions& options, StepWorkspace::Impl& work) {
  const auto* analytic = std::get_if<Analytic>(&options.smoothing);
  for (FrictionJoint& joint : work.friction_joints) {
    const world::Dof& dof = model.dofs()[at(joint.v)];
    const double unit = dof.kind == world::DofKind::Revolute ? 1.0 : model.scales().object(dof.owner).length;
    joint.stiction = joint.friction / (kCreep * unit);
    // Barriers with σ = h/κ that keep a multiplier λ within ±hτ_f move the joint by σ/(hτ_f − λ) − σ/(hτ_f + λ), or 2σλ/(hτ_f)² for small
    // λ.
    if (analytic != nullptr) joint.stiction = std::min(joint.stiction, analytic->kappa * joint.friction * joint.friction / 2);
  }
}

void set_friction(const StepOptions& options, StepWorkspace::Impl& work) {
  for (const FrictionJoint& joint : work.friction_joints) {
    work.Q[joint.entry].value = joint.inertia + (joint.side == 0 ? options.h * joint.stiction : 0.0);
    work.b[joint.v] = joint.drive - options.h * joint.side * joint.friction;
  }
}

void add_friction(const StepOptions& options, StepWorkspace::Impl& work) {
  const double h = options.h;
  for (FrictionJoint& joint : work.friction_joints) {
    joint.bound = -1;
    if (joint.side == 0) continue;
    const double corner = joint.friction / joint.stiction;
    joint.bound =
        work.problem->add_bound(friction_id(work, joint.v), joint.v, -joint.side, -corner, kCornerSharpness * h * joint.friction * corner,
                                during(work.variable_unit[at(joint.v)], h), 1 / (h * joint.stiction));
    work.bound_variables.push_back(joint.v);
  }
}

bool slide_joints(StepWorkspace::Impl& work) {
  bool any = false;
  for (FrictionJoint& joint : work.friction_joints) {
    if (joint.side <= 0 && pull(work, joint) > joint.friction) joint.side = 1, any = true;
    if (joint.side >= 0 && pull(work, joint) < -joint.friction) joint.side = -1, any = true;
  }
  return any;
}

void read_friction(const Model& model, const StepOptions& options, const StepWorkspace::Impl& work, StepResult& out) {
  if (work.friction_joints.empty()) {
    out.joint_friction.resize(0);
    return;
  }
  out.joint_friction.setZero(model.n_vu());
  for (const FrictionJoint& joint : work.friction_joints) {
    out.joint_friction[joint.v] =
        joint.side == 0 ? pull(work, joint) : joint.side * (joint.friction - work.solution.z_bound[joint.bound] / options.h);
  }
}

}  // namespace stiction::dynamics::detail
