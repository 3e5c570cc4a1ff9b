#include "stiction/dynamics/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/dynamics/joint_friction.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics {
namespace {

using core::Overloaded;
using detail::at;
using world::Model;

/// Stiffness of the softest robot joint as a Cartesian spring, K_a / reach² [N/m]. Without robots: F / L of the scale, a spring that the
/// weight stretches by its length.
double softest_stiffness(const Model& model) {
  const world::Scales& scales = model.scales();
  return scales.softest_stiffness() > 0 ? scales.softest_stiffness() : scales.robots().force / scales.robots().length;
}

/// Nearest power of two. Units are powers of two so that scaling does not round.
double power_of_two(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  return std::ldexp(1.0, mantissa < std::numbers::sqrt2 / 2 ? exponent - 1 : exponent);
}

/// Unit of a row or variable for h = 1 s: length 5 L, and the work of F over that length.
cone::Unit unit_of(double length, double force) {
  const double unit = power_of_two(5 * length);
  return {unit, unit * power_of_two(force)};
}

/// Units of all variables. Objects use their scale; the work of a robot joint follows from its spring stiffness; angles are in radians.
std::vector<cone::Unit> variable_units(const Model& model) {
  std::vector<cone::Unit> units;
  for (int v = 0; v < model.n_v(); ++v) {
    const world::Dof& dof = model.dofs()[at(v)];
    const bool object = dof.owner_kind == world::BodyKind::Object;
    const world::Scale& scale = object ? model.scales().object(dof.owner) : model.scales().robots();
    cone::Unit unit = unit_of(scale.length, scale.force);
    if (dof.kind == world::DofKind::Revolute) unit.length = 1;
    if (!object) unit.work = power_of_two(0.1 * dof.stiffness) * unit.length * unit.length;
    units.push_back(unit);
  }
  return units;
}

/// Units of the rows of all pairs. The length follows from L of the pair's smaller object. All pairs share F of the heaviest object,
/// because forces pass from object to object, and the central path converges slowly if rows ask for very different complementarities.
std::vector<cone::Unit> pair_units(const Model& model) {
  double force = model.scales().robots().force;
  for (int o = 0; o < static_cast<int>(model.objects().size()); ++o) force = std::max(force, model.scales().object(o).force);
  std::vector<cone::Unit> units;
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) units.push_back(unit_of(model.scales().pair(i).length, force));
  return units;
}

/// Elimination order of the variables: robot branches first (they couple only through the objects they hold), objects last.
std::vector<std::vector<int>> elimination_groups(const Model& model) {
  std::vector<std::vector<int>> groups;
  for (const auto& robot : model.robots()) groups.insert(groups.end(), robot.chains.begin(), robot.chains.end());
  for (const auto& object : model.objects()) {
    auto& group = groups.emplace_back(static_cast<std::size_t>(object.n_v));
    for (int i = 0; i < object.n_v; ++i) group[static_cast<std::size_t>(i)] = object.v_begin + i;
  }
  return groups;
}

bool is_self_contact(const Model& model, const world::Pair& pair) {
  const auto& a = model.bodies()[at(model.geometries()[at(pair.geometry_a)].body)];
  const auto& b = model.bodies()[at(model.geometries()[at(pair.geometry_b)].body)];
  return a.kind != world::BodyKind::Object && b.kind != world::BodyKind::Object;
}

std::shared_ptr<const Model> require_motion(std::shared_ptr<const Model> model) {
  if (model->n_v() == 0) core::throw_invalid("model", "nothing that moves", "an object, or a robot with a joint that has a range");
  return model;
}

std::shared_ptr<cone::Layout> make_layout(const Model& model) {
  try {
    return std::make_shared<cone::Layout>(model.n_v(), elimination_groups(model));
  } catch (const core::InvalidInput&) {
    core::throw_invalid(
        "model", fmt::format("{} objects and {} joints that move, with {} coordinates", model.objects().size(), model.n_a(), model.n_v()),
        fmt::format("at most {} in groups of 4, of which a free object has two, for a step; let bodies stand still that need not "
                    "move (`objects` of a scene's `file`)",
                    4 * cone::kMaxTiles));
  }
}

}  // namespace

StepWorkspace::Impl::Impl(std::shared_ptr<const Model> m)
    : model(require_motion(std::move(m))),
      layout(make_layout(*model)),
      kinematics_work(*model),
      contact_work(*model),
      softest(softest_stiffness(*model)) {
  for (const auto& variables : model->supports()) supports.push_back(layout->add_support(variables));
  problem.emplace(layout, 64, 2 * model->n_a() + 64);
  solver.emplace(layout);
  for (const auto& pair : model->pairs()) self_contact.push_back(is_self_contact(*model, pair));
  tau_u.resize(model->n_vu());
  for (const auto& object : model->objects()) max_object_dofs = std::max(max_object_dofs, object.n_v);
  M_u.resize(max_object_dofs, max_object_dofs);
  variable_unit = variable_units(*model);
  pair_unit = pair_units(*model);
  b.resize(model->n_v());
  commanded.setZero(model->n_v());
  object_radius.assign(model->objects().size(), 0.0);
  for (const auto& geometry : model->geometries()) {
    const auto& body = model->bodies()[static_cast<std::size_t>(geometry.body)];
    if (body.kind != world::BodyKind::Object) continue;
    double& radius = object_radius[static_cast<std::size_t>(body.owner)];
    radius = std::max(radius, geometry.p_BCenter.norm() + geometry.bounding_radius);
  }
  limit_included.resize(static_cast<std::size_t>(2 * model->n_v()));
  motor.resize(at(model->n_a()));
  motor_bound.assign(at(model->n_a()), -1);
  friction_joints = detail::find_friction_joints(*model);
}

namespace detail {
namespace {

/// σ of a motor's row in smoothed steps, as a share of h·effort²/K. The corner of the spring law is rounded by about the square root of
/// this, relative to the effort. The row pushes no object, so it needs no real smoothing.
constexpr double kMotorSharpness = 1e-6;

std::uint64_t motor_id(const Model& model, int joint) { return static_cast<std::uint64_t>(2 * model.n_v() + joint); }

}  // namespace

cone::Unit during(cone::Unit unit, double h) { return {unit.length, unit.work * power_of_two(h)}; }

double calc_objective(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work,
                      Eigen::VectorXd& epsilon) {
  const double h = options.h;
  world::calc_gravity(model, work.kinematics, work.tau_u);
  if (in.tau_ext) work.tau_u += in.tau_ext->head(model.n_vu());

  const auto damping = [&](int i) { return in.damping ? (*in.damping)[i] : 0.0; };
  const auto objects = model.objects();
  epsilon.resize(static_cast<Eigen::Index>(objects.size()));
  work.Q.clear();
  double fall = 0;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const auto& object = objects[o];
    // ε m/h = ratio · h K_min. Every rotation is measured at the object's radius of gyration, where its inertia equals m. Translation and
    // rotation then get the same ε, and kg is never compared with kg m².
    const double eps = std::visit(Overloaded{[&](const ByRule& rule) { return rule.ratio * h * h * work.softest / object.carried_mass; },
                                             [](const FixedEpsilon& fixed) { return fixed.epsilon; }},
                                  options.regularisation);
    epsilon[static_cast<Eigen::Index>(o)] = eps;
    auto M_u = work.M_u.topLeftCorner(object.n_v, object.n_v);
    world::calc_object_mass(model, work.kinematics, static_cast<int>(o), M_u);
    double force2 = 0, spring = 0;
    for (int i = 0; i < object.n_v; ++i) {
      const world::Dof& dof = model.dofs()[at(object.v_begin + i)];
      if (dof.spring > 0) {  // implicit, like the robots' springs: evaluated at the end of the step
        spring = dof.spring;
        work.tau_u[object.v_begin + i] += dof.spring * (dof.spring_rest - in.q[object.q_begin + i]);
      }
      for (int j = 0; j <= i; ++j) {
        const double value = eps / h * M_u(i, j) + (i == j ? damping(object.v_begin + i) + h * dof.spring : 0.0);
        if (value != 0) work.Q.push_back({object.v_begin + i, object.v_begin + j, value});
      }
      const double tau = work.tau_u[object.v_begin + i];
      work.b[object.v_begin + i] = -h * tau;
      if (dof.kind == world::DofKind::Prismatic) force2 += tau * tau;
    }
    fall = std::max(fall, h * h * std::sqrt(force2) / (eps * object.carried_mass + h * h * spring));
  }

  for (FrictionJoint& joint : work.friction_joints) {
    const auto entry = std::ranges::find_if(work.Q, [&](const QEntry& e) { return e.row == joint.v && e.column == joint.v; });
    joint.entry = static_cast<std::size_t>(entry - work.Q.begin());
    joint.inertia = entry->value;
    joint.drive = work.b[joint.v];
  }
  work.springs = work.Q.size();
  for (int v = model.n_vu(); v < model.n_v(); ++v) work.Q.push_back({v, v, 0});
  return fall;
}

void set_springs(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work) {
  const double h = options.h;
  const int n_vu = model.n_vu();
  for (int j = 0; j < model.n_a(); ++j) {
    const double K = model.stiffness()[j], damping = in.damping ? (*in.damping)[n_vu + j] : 0.0;
    const double tau_a = in.tau_ext ? (*in.tau_ext)[n_vu + j] : 0.0;
    const int side = work.motor[at(j)];
    work.Q[work.springs + at(j)].value = side == 0 ? h * K + damping : damping;
    const double pull = side == 0 ? K * (in.u[j] - in.q[model.n_qu() + j]) : side * model.effort()[j];
    work.b[n_vu + j] = -h * (pull + tau_a);
  }
}

void add_motors(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work) {
  const double h = options.h;
  for (int j = 0; j < model.n_a(); ++j) {
    work.motor_bound[at(j)] = -1;
    const int side = work.motor[at(j)];
    if (side == 0) continue;
    const double K = model.stiffness()[j], effort = model.effort()[j];
    const int v = model.n_vu() + j;
    const double offset = side * (in.u[j] - in.q[model.n_qu() + j]) - effort / K;
    work.motor_bound[at(j)] = work.problem->add_bound(motor_id(model, j), v, -side, offset, kMotorSharpness * h * effort * effort / K,
                                                      during(work.variable_unit[at(v)], h), 1 / (h * K));
    work.bound_variables.push_back(v);
  }
}

void read_motors(const Model& model, const StepInput& in, const StepOptions& options, const StepWorkspace::Impl& work, StepResult& out) {
  out.torque.resize(model.n_a());
  out.saturated.resize(at(model.n_a()));
  for (int j = 0; j < model.n_a(); ++j) {
    const int side = work.motor[at(j)], bound = work.motor_bound[at(j)];
    const double K = model.stiffness()[j];
    if (side == 0) {
      out.torque[j] = K * (in.u[j] - in.q[model.n_qu() + j] - work.solution.x[model.n_vu() + j]);
    } else {
      out.torque[j] = side * (model.effort()[j] - work.solution.z_bound[bound] / options.h);
    }
    out.saturated[at(j)] = side != 0 && work.solution.w_bound[bound] * options.h * K > work.solution.z_bound[bound];
  }
}

void add_objective(const StepWorkspace::Impl& work, double h, cone::Problem& problem) {
  for (std::size_t i = 0; i < work.variable_unit.size(); ++i) problem.set_unit(static_cast<int>(i), during(work.variable_unit[i], h));
  for (const auto& [i, j, value] : work.Q) problem.set_Q(i, j, value);
  for (Eigen::Index i = 0; i < work.b.size(); ++i) problem.set_b(static_cast<int>(i), work.b[i]);
}

void set_rays(const Model& model, const StepOptions& options, std::vector<Eigen::Vector2d>& rays) {
  rays.clear();
  if (model.planar_axis()) {
    rays.assign({{1, 0}, {-1, 0}});
  } else if (const auto* pyramid = std::get_if<PolyhedralCone>(&options.friction_cone)) {
    for (int k = 0; k < pyramid->rays; ++k) {
      const double angle = 2 * std::numbers::pi * k / pyramid->rays;
      rays.emplace_back(std::cos(angle), std::sin(angle));
    }
  }
}

void add_contact(const Model& model, std::size_t i, double h, double mu, double sigma, StepWorkspace::Impl& work) {
  const contact::Contact& contact = work.contacts[i];
  const cone::Unit unit = during(work.pair_unit[at(contact.pair)], h);
  const auto support = static_cast<std::size_t>(model.pairs()[static_cast<std::size_t>(contact.pair)].support);
  const auto k = model.supports()[support].size();
  const int row_support = work.supports[support];
  cone::Problem& problem = *work.problem;
  const double* J = jacobian(work, i);
  work.G.resize(3 * k);
  if (!work.rays.empty()) {
    for (std::size_t r = 0; r < work.rays.size(); ++r) {
      const double m1 = mu * work.rays[r].x(), m2 = mu * work.rays[r].y();
      for (std::size_t c = 0; c < k; ++c) work.G[c] = J[c] + m1 * J[k + c] + m2 * J[2 * k + c];
      problem.add_half_line(kMostRays * contact.id + r, row_support, work.G.data(), row_gap(work, i), sigma, unit);
    }
  } else if (mu == 0) {
    problem.add_half_line(kMostRays * contact.id, row_support, J, row_gap(work, i), 2 * sigma,
                          unit);  // 2σ: limit of the cone for μ → 0, which has degree 2
  } else {
    std::copy_n(J, k, work.G.data());
    for (std::size_t c = k; c < 3 * k; ++c) work.G[c] = mu * J[c];
    const double g[3] = {row_gap(work, i), 0, 0};
    problem.add_cone(contact.id, row_support, work.G.data(), g, 2 * sigma, unit);
  }
}

}  // namespace detail
}  // namespace stiction::dynamics
