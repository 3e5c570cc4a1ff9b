#include "stiction/dynamics/step.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/dynamics/linearisation.hpp"
#include "stiction/dynamics/sample_step.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics {
namespace {

using core::Overloaded;
using core::Status;
using world::Model;

/// An exact step first looks at the rows that it may reach: contacts with objects nearer than this plus a share of the commanded motion, contacts among robot
/// parts that the command brings nearer than this (S.6), and joint limits likewise. Rows left out that the solution violates are added and the step is solved
/// again, so that the result is that of the full problem: a row that holds with room has no multiplier.
constexpr double kNearContact = 0.02;  // of L of the pair (world::Scales)
constexpr double kNearLimit = 0.02;    // of the unit of the joint
constexpr double kMotionShare = 0.25;
constexpr double kFallShare = 0.5;  // Coulomb's law: and by this share of what gravity can move an object by in the step
/// Where δq is known roughly, the rows are those that keep less room than this under it.
constexpr double kGuessContact = 0.01;  // of L
constexpr double kGuessLimit = 0.01;    // of the unit of the joint
constexpr int kMaxRounds = 12;          // the last one has all rows
constexpr int kMostRays = 64;
/// Coulomb's law: a solution that leaves a contact nearer to or farther from its obstacle than this is not its fixed point.
constexpr double kClosed = 3e-3;  // of L

/// Complementarity to which an exact step with A or B is centred [-]: sharper, the factor of H loses the digits that B needs, since its
/// entries grow with λ²/σ.
constexpr double kSensitivityComplementarity = 1e-8;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Softest robot joint seen as a Cartesian spring, K_a / reach² [N/m]; without robots one that an object's weight stretches by its length.
double softest_stiffness(const Model& model) {
  const world::Scales& scales = model.scales();
  return scales.softest_stiffness() > 0 ? scales.softest_stiffness() : scales.robots().force / scales.robots().length;
}

/// Nearest power of two: units that do not round what they measure.
double power_of_two(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  return std::ldexp(1.0, mantissa < std::numbers::sqrt2 / 2 ? exponent - 1 : exponent);
}

/// Units of rows and variables for h = 1 s: 5 L, and the work of F over it.
cone::Unit unit_of(double length, double force) {
  const double unit = power_of_two(5 * length);
  return {unit, unit * power_of_two(force)};
}

cone::Unit during(cone::Unit unit, double h) { return {unit.length, unit.work * power_of_two(h)}; }

/// Of every variable: objects by their scale, robot joints by what their spring gives over a tenth of the unit; angles are measured in radians.
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

/// Of the rows of every pair: L of its smaller object. F is that of the heaviest object for all of them, since forces pass on from object to object and the
/// central path converges slowly where rows are asked for very different complementarities.
std::vector<cone::Unit> pair_units(const Model& model) {
  double force = model.scales().robots().force;
  for (int o = 0; o < static_cast<int>(model.objects().size()); ++o) force = std::max(force, model.scales().object(o).force);
  std::vector<cone::Unit> units;
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) units.push_back(unit_of(model.scales().pair(i).length, force));
  return units;
}

/// Elimination order of the variables: robot branches first (they only meet in what they hold), objects last.
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

}  // namespace

Eigen::Matrix<double, 6, 1> calc_wrench(const ContactImpulse& c, double h) {
  const contact::Contact& geometry = c.contact;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench.head<3>() = (geometry.nhat_BA_W * c.lambda[0] + geometry.t1_W * c.lambda[1] + geometry.t2_W * c.lambda[2]) / h;
  wrench.tail<3>() = geometry.p_WA.cross(wrench.head<3>());
  return wrench;
}

void StepOptions::validate() const {
  core::require_positive("h", h);
  core::require_nonnegative("friction_scale", friction_scale);
  core::require_nonnegative("contact_margin", contact_margin);
  core::require_positive("tol_complementarity", tol_complementarity);
  if (with_force_derivatives && !with_A && !with_B) core::throw_invalid("with_force_derivatives", "true", "with_A or with_B as well");
  std::visit(Overloaded{[](const Exact&) {},
                        [](const Analytic& a) {
                          core::require_positive("smoothing.kappa", a.kappa);
                          core::require_positive("smoothing.self_sharpness", a.self_sharpness);
                          core::require_positive("smoothing.limit_sharpness", a.limit_sharpness);
                        }},
             smoothing);
  std::visit(Overloaded{[](const ByRule& r) { core::require_positive("regularisation.ratio", r.ratio); },
                        [](const FixedEpsilon& f) { core::require_positive("regularisation.epsilon", f.epsilon); }},
             regularisation);
  const auto* pyramid = std::get_if<PolyhedralCone>(&friction_cone);
  if (pyramid != nullptr && (pyramid->rays < 3 || pyramid->rays > kMostRays)) {
    core::throw_invalid("friction_cone.rays", std::to_string(pyramid->rays), "a number in [3, " + std::to_string(kMostRays) + "]");
  }
}

struct StepWorkspace::Impl {
  explicit Impl(std::shared_ptr<const Model> m)
      : model(std::move(m)),
        layout(std::make_shared<cone::Layout>(model->n_v(), elimination_groups(*model))),
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
  }

  std::shared_ptr<const Model> model;
  std::shared_ptr<cone::Layout> layout;
  std::vector<int> supports;       // Model::supports() → Layout support
  std::vector<char> self_contact;  // per pair
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  contact::Workspace contact_work;
  std::vector<contact::Contact> contacts;
  Eigen::VectorXd q_seen;   // of kinematics, contacts and J: a step from the same q, as the samples of a local model are, takes them over
  double margin_seen = -1;  // of contacts and J [m]; < 0: there are none at q_seen
  std::optional<cone::Problem> problem;
  std::optional<cone::Workspace> solver;
  cone::Result solution;
  double softest = 1.0;                   // [N/m]
  std::vector<cone::Unit> variable_unit;  // for h = 1 s
  std::vector<cone::Unit> pair_unit;      // for h = 1 s
  std::vector<double> object_radius;      // of the sphere about the body origin that holds the object [m]
  int max_object_dofs = 0;
  Eigen::VectorXd tau_u;
  Eigen::MatrixXd M_u;
  contact::Jacobians J;
  std::vector<double> G;
  std::vector<Eigen::Vector2d> rays;  // of the friction cone in (t1, t2); none: second order
  std::vector<detail::QEntry> Q;      // lower triangle
  Eigen::VectorXd b;
  Eigen::VectorXd commanded;           // (0; u − qᵃ)
  std::vector<char> included;          // per contact: its rows are in the problem
  std::vector<Eigen::Vector3d> moved;  // per contact that is not: J_c δq
  std::vector<char> limit_included;    // per limit_id
  std::vector<int> bound_variables;    // of the limits in the problem, in order of adding
  detail::LinearisationWorkspace linearisation;
};

StepWorkspace::StepWorkspace(std::shared_ptr<const Model> model) : impl_(std::make_unique<Impl>(std::move(model))) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;
void StepWorkspace::forget() {
  impl_->solver->forget();
  impl_->q_seen.resize(0);
}
const Model& StepWorkspace::model() const { return *impl_->model; }

namespace {

/// Objective of (2.6): Q = blkdiag(ε M_u/h, h K_a), b = −h (τ_u; K_a(u − qᵃ) + τ_a), into the workspace. Returns how far gravity
/// can move an object in one step when nothing holds it, h²‖τ_u‖/(ε m) [m].
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
    // ε m/h = ratio · h K_min, with every rotation measured at the object's radius of gyration, where its inertia is m again:
    // translation and rotation get the same ε and no kilogram meets a kg m².
    const double eps = std::visit(Overloaded{[&](const ByRule& rule) { return rule.ratio * h * h * work.softest / object.carried_mass; },
                                             [](const FixedEpsilon& fixed) { return fixed.epsilon; }},
                                  options.regularisation);
    epsilon[static_cast<Eigen::Index>(o)] = eps;
    auto M_u = work.M_u.topLeftCorner(object.n_v, object.n_v);
    world::calc_object_mass(model, work.kinematics, static_cast<int>(o), M_u);
    double force2 = 0;
    for (int i = 0; i < object.n_v; ++i) {
      for (int j = 0; j <= i; ++j) {
        const double value = eps / h * M_u(i, j) + (i == j ? damping(object.v_begin + i) : 0.0);
        if (value != 0) work.Q.push_back({object.v_begin + i, object.v_begin + j, value});
      }
      const double tau = work.tau_u[object.v_begin + i];
      work.b[object.v_begin + i] = -h * tau;
      if (model.dofs()[static_cast<std::size_t>(object.v_begin + i)].kind == world::DofKind::Prismatic) force2 += tau * tau;
    }
    fall = std::max(fall, h * h * std::sqrt(force2) / (eps * object.carried_mass));
  }

  const int n_vu = model.n_vu();
  const int n_qu = model.n_qu();
  for (int j = 0; j < model.n_a(); ++j) {
    const double K = model.stiffness()[j];
    const double tau_a = in.tau_ext ? (*in.tau_ext)[n_vu + j] : 0.0;
    work.Q.push_back({n_vu + j, n_vu + j, h * K + damping(n_vu + j)});
    work.b[n_vu + j] = -h * (K * (in.u[j] - in.q[n_qu + j]) + tau_a);
  }
  return fall;
}

void add_objective(const StepWorkspace::Impl& work, double h, cone::Problem& problem) {
  for (std::size_t i = 0; i < work.variable_unit.size(); ++i) problem.set_unit(static_cast<int>(i), during(work.variable_unit[i], h));
  for (const auto& [i, j, value] : work.Q) problem.set_Q(i, j, value);
  for (Eigen::Index i = 0; i < work.b.size(); ++i) problem.set_b(static_cast<int>(i), work.b[i]);
}

/// Calls visit(variable, sign, offset) for every joint limit sign·δq_variable + offset ≥ 0.
template <class Visit>
void for_each_limit(const Model& model, const StepInput& in, Visit&& visit) {
  const auto both = [&](int variable, double q, double lower, double upper) {
    if (std::isfinite(lower)) visit(variable, 1.0, q - lower);
    if (std::isfinite(upper)) visit(variable, -1.0, upper - q);
  };
  for (int j = 0; j < model.n_a(); ++j) both(model.n_vu() + j, in.q[model.n_qu() + j], model.lower()[j], model.upper()[j]);
  for (const auto& object : model.objects()) {
    if (object.n_q != 1) continue;  // hinges and sliders are the objects with limits
    const auto& dof = model.dofs()[static_cast<std::size_t>(object.v_begin)];
    both(object.v_begin, in.q[object.q_begin], dof.lower, dof.upper);
  }
}

std::uint64_t limit_id(int variable, double sign) { return static_cast<std::uint64_t>(2 * variable + (sign > 0 ? 0 : 1)); }

/// Largest Σ_j reach_j |u_j − q_j| over the branches of the robots: how far a finger may be commanded to travel [m].
double commanded_motion(const Model& model, const StepInput& in) {
  double motion = 0;
  for (const auto& robot : model.robots()) {
    for (const auto& chain : robot.chains) {
      double sum = 0;
      for (const int v : chain) {
        const int j = v - model.n_vu();
        sum += model.reach()[j] * std::abs(in.u[j] - in.q[model.n_qu() + j]);
      }
      motion = std::max(motion, sum);
    }
  }
  return motion;
}

const double* jacobian(const StepWorkspace::Impl& work, std::size_t contact) { return work.J.values.data() + work.J.begin[contact]; }

/// Rays of (2.10): ±t1 in the plane, n_d around the cone of a polyhedral model, none for the second-order cone.
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

/// Rows of contact i: a Lorentz cone (J_n δq + φ, μJ_t δq), or half-lines (J_n + μ dᵀJ_t) δq + φ for every ray d (2.10).
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
      problem.add_half_line(kMostRays * contact.id + r, row_support, work.G.data(), contact.phi, sigma, unit);
    }
  } else if (mu == 0) {
    problem.add_half_line(kMostRays * contact.id, row_support, J, contact.phi, 2 * sigma, unit);  // limit of the cone, which has degree 2
  } else {
    std::copy_n(J, k, work.G.data());
    for (std::size_t c = k; c < 3 * k; ++c) work.G[c] = mu * J[c];
    const double g[3] = {contact.phi, 0, 0};
    problem.add_cone(contact.id, row_support, work.G.data(), g, 2 * sigma, unit);
  }
}

/// Slack of the rows of a contact that is displaced by v, J_c δq.
double slack(const StepWorkspace::Impl& work, double phi, double mu, const Eigen::Vector3d& v) {
  if (work.rays.empty()) return phi + v[0] - mu * v.tail<2>().norm();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& d : work.rays) least = std::min(least, phi + v[0] + mu * d.dot(v.tail<2>()));
  return least;
}

/// J_c δq [m].
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

/// Gap of a self-contact now or after the motion that the command asks for, whichever is less, first order [m].
double least_commanded_gap(const Model& model, const StepOptions& options, std::size_t i, const StepWorkspace::Impl& work) {
  const contact::Contact& contact = work.contacts[i];
  const Eigen::Vector3d v = displacement(model, i, work.commanded, work);
  return contact.phi + std::min(0.0, v[0] - contact.friction * options.friction_scale * v.tail<2>().norm());
}

/// No point of any body travels farther than this under δq, first order [m].
double motion_bound(const Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta) {
  double bound = 0;
  for (const auto& robot : model.robots()) {
    double sum = 0;  // a branch may carry another one: their sum bounds all
    for (const auto& chain : robot.chains) {
      for (const int v : chain) sum += model.reach()[v - model.n_vu()] * std::abs(delta[v]);
    }
    bound = std::max(bound, sum);
  }
  const auto objects = model.objects();
  for (std::size_t o = 0; o < objects.size(); ++o) {
    double translation = 0, rotation = 0;
    for (int i = objects[o].v_begin; i < objects[o].v_begin + objects[o].n_v; ++i) {
      const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
      (revolute ? rotation : translation) += std::abs(delta[i]);
    }
    double sum = translation + rotation * work.object_radius[o];
    for (int p = objects[o].parent; p >= 0; p = objects[at(p)].parent) {  // what it hangs on carries it along
      const double arm = (work.kinematics.X_WB[at(objects[o].body)].p - work.kinematics.X_WB[at(objects[at(p)].body)].p).norm();
      for (int i = objects[at(p)].v_begin; i < objects[at(p)].v_begin + objects[at(p)].n_v; ++i) {
        const bool revolute = model.dofs()[at(i)].kind == world::DofKind::Revolute;
        sum += std::abs(delta[i]) * (revolute ? arm + work.object_radius[o] : 1.0);
      }
    }
    bound = std::max(bound, sum);
  }
  return bound;
}

/// Rows of a smoothed step: self-contacts enter where they push as hard as a contact with an object does where it enters, σ/φ is the same.
void include_smoothed(const Model& model, const StepInput& in, const StepOptions& options, double self_sharpness,
                      StepWorkspace::Impl& work) {
  const double near_self = (model.scene().contact_distance + options.contact_margin) / self_sharpness;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const bool self = work.self_contact[at(work.contacts[i].pair)] != 0;
    work.included[i] = !self || least_commanded_gap(model, options, i, work) < near_self;
  }
  for_each_limit(model, in,
                 [&](int variable, double sign, double) { work.limit_included[limit_id(variable, sign)] = options.joint_limits; });
}

/// Rows that an exact step looks at first. Coulomb's law may have several solutions, and which one is found depends on the rows: with contacts of objects that a fall
/// may reach it is one by which more plans hold (docs/decisions/0017-shifts-that-look-ahead.md).
/// @param fall  what gravity can move an object by in the step when nothing holds it [m]
void include_within_reach(const Model& model, const StepInput& in, const StepOptions& options, bool coulomb, double fall,
                          StepWorkspace::Impl& work) {
  const double motion = (coulomb ? kFallShare * fall : 0) + kMotionShare * commanded_motion(model, in);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const int pair = work.contacts[i].pair;
    const double near = kNearContact * model.scales().pair(pair).length;
    work.included[i] =
        work.self_contact[at(pair)] != 0 ? least_commanded_gap(model, options, i, work) < near : work.contacts[i].phi < near + motion;
  }
  for_each_limit(model, in, [&](int variable, double sign, double offset) {
    const int j = variable - model.n_vu();
    const double commanded = j < 0 ? 0.0 : std::abs(in.u[j] - in.q[model.n_qu() + j]);
    const double near = kNearLimit * work.variable_unit[at(variable)].length;
    work.limit_included[limit_id(variable, sign)] = options.joint_limits && offset < near + commanded;
  });
}

/// The same where δq is known roughly.
void include_near(const Model& model, const StepInput& in, const StepOptions& options, const Eigen::VectorXd& guess,
                  StepWorkspace::Impl& work) {
  const double motion = 2 * motion_bound(model, work, guess);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const double phi = work.contacts[i].phi, mu = work.contacts[i].friction * options.friction_scale;
    const double near = kGuessContact * model.scales().pair(work.contacts[i].pair).length;
    work.included[i] = phi < near + (1 + mu) * motion && slack(work, phi, mu, displacement(model, i, guess, work)) < near;
  }
  for_each_limit(model, in, [&](int variable, double sign, double offset) {
    const double near = kGuessLimit * work.variable_unit[at(variable)].length;
    work.limit_included[limit_id(variable, sign)] = options.joint_limits && sign * guess[variable] + offset < near;
  });
}

void include_all(const StepOptions& options, StepWorkspace::Impl& work) {
  std::ranges::fill(work.included, char{1});
  if (options.joint_limits) std::ranges::fill(work.limit_included, char{1});
}

bool is_coulomb(const StepOptions& options) {
  return options.friction_law == FrictionLaw::Coulomb && std::holds_alternative<Exact>(options.smoothing);
}

/// Coulomb's law is not found: a row in the problem penetrates, or carries a force across a gap, by more than kClosed L.
bool misses_contact(const Model& model, const StepOptions& options, const StepWorkspace::Impl& work) {
  const cone::Result& s = work.solution;
  Eigen::Index cone = 0;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (!work.included[i] || work.contacts[i].friction * options.friction_scale == 0) continue;
    const double gap = s.w_cone(0, cone) - s.shift_cone[cone];
    const world::Scale& scale = model.scales().pair(work.contacts[i].pair);
    const bool active = s.z_cone(0, cone) > options.h * world::share::kActive * scale.force;
    if (gap < -kClosed * scale.length || (active && gap > kClosed * scale.length)) return true;
    ++cone;
  }
  return false;
}

/// Puts rows that the solution violates into the problem of the next round; true when there are any.
/// @param closed  they may slide without opening (Coulomb)
bool add_violated(const Model& model, const StepInput& in, const StepOptions& options, bool closed, StepWorkspace::Impl& work) {
  bool any = false;
  const double motion = 2 * motion_bound(model, work, work.solution.x);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (work.included[i]) continue;
    const double phi = work.contacts[i].phi, mu = work.contacts[i].friction * options.friction_scale;
    work.moved[i].setZero();
    if (phi > (1 + mu) * motion) continue;
    work.moved[i] = displacement(model, i, work.solution.x, work);
    if (slack(work, phi, closed ? 0.0 : mu, work.moved[i]) < 0) work.included[i] = 1, any = true;
  }
  if (!options.joint_limits) return any;
  for_each_limit(model, in, [&](int variable, double sign, double offset) {
    auto& included = work.limit_included[limit_id(variable, sign)];
    if (!included && sign * work.solution.x[variable] + offset < 0) included = 1, any = true;
  });
  return any;
}

void read_contacts(const Model& model, const StepOptions& options, StepWorkspace::Impl& work, std::vector<ContactImpulse>& out) {
  const cone::Result& s = work.solution;
  out.resize(work.contacts.size());
  Eigen::Index cone = 0;
  Eigen::Index half = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    ContactImpulse& c = out[i];
    c.contact = work.contacts[i];
    const double mu = c.contact.friction * options.friction_scale;
    if (!work.included[i]) {
      c.lambda.setZero();
      c.displacement = work.moved[i];
      c.gap = slack(work, c.contact.phi, mu, c.displacement);
    } else if (!work.rays.empty()) {
      c.lambda.setZero();
      c.displacement = displacement(model, i, s.x, work);
      c.gap = std::numeric_limits<double>::infinity();
      for (const auto& d : work.rays) {
        c.lambda += s.z_half_line[half] * Eigen::Vector3d(1, mu * d.x(), mu * d.y());
        c.gap = std::min(c.gap, s.w_half_line[half++]);
      }
    } else if (mu == 0) {
      c.lambda = {s.z_half_line[half], 0, 0};
      c.displacement = displacement(model, i, s.x, work);
      c.gap = s.w_half_line[half++];
    } else {
      const auto w = s.w_cone.col(cone), z = s.z_cone.col(cone);
      const double shift = s.shift_cone[cone++];
      c.lambda = {z[0], mu * z[1], mu * z[2]};
      c.displacement = {w[0] - shift - c.contact.phi, w[1] / mu, w[2] / mu};
      c.gap = w[0] - std::hypot(w[1], w[2]);
    }
    c.active = c.lambda[0] > options.h * world::share::kActive * model.scales().pair(c.contact.pair).force;
  }
}

/// step() and sample_step(): `guess` may be null.
Status solve_step(const Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options,
                  StepWorkspace& workspace, StepResult& out) {
  options.validate();
  core::require_size("q", in.q.size(), model.n_q());
  core::require_size("u", in.u.size(), model.n_a());
  if (!in.q.allFinite()) core::throw_invalid("q", "a number that is not finite", "finite numbers");
  if (!in.u.allFinite()) core::throw_invalid("u", "a number that is not finite", "finite numbers");
  if (in.tau_ext) core::require_size("tau_ext", in.tau_ext->size(), model.n_v());
  if (in.damping) {
    core::require_size("damping", in.damping->size(), model.n_v());
    for (const double d : *in.damping) core::require_nonnegative("damping", d);
  }
  if (in.friction) {
    core::require_size("friction", in.friction->size(), static_cast<Eigen::Index>(model.pairs().size()));
    if (!(in.friction->array() >= 0 && in.friction->array().isFinite()).all()) {  // there are hundreds
      for (const double factor : *in.friction) core::require_nonnegative("friction", factor);
    }
  }

  StepWorkspace::Impl& work = workspace.impl();
  const auto* analytic = std::get_if<Analytic>(&options.smoothing);

  set_rays(model, options, work.rays);
  if (is_coulomb(options) && !work.rays.empty())
    core::throw_invalid("friction_law", "coulomb", "anitescu for a planar model or a polyhedral cone");
  if (work.q_seen.size() == 0 || work.q_seen != in.q) {
    world::calc_kinematics(model, in.q, work.kinematics_work, work.kinematics);
    work.q_seen = in.q;
    work.margin_seen = -1;
  }
  const double fall = calc_objective(model, in, options, work, out.epsilon);

  // An unsupported object must not fall through what it would have met: look as far as it can fall.
  const double margin = options.contact_margin + std::max(0.0, fall - model.scene().contact_distance);
  if (work.margin_seen != margin) {
    contact::query(model, work.kinematics, {.margin = margin}, work.contact_work, work.contacts);
    contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
    work.margin_seen = margin;
  }
  if (in.friction) {
    for (auto& contact : work.contacts) contact.friction *= (*in.friction)[contact.pair];
    work.margin_seen = -1;  // no other step takes these over
  }

  const bool exact = analytic == nullptr;
  const bool derivatives = options.with_A || options.with_B;
  const double sigma = exact ? 0.0 : options.h / analytic->kappa;
  const double sigma_self = exact ? 0.0 : sigma / analytic->self_sharpness;
  const double sigma_limit = exact ? 0.0 : sigma / analytic->limit_sharpness;
  work.commanded.tail(model.n_a()) = in.u - in.q.tail(model.n_a());
  work.included.resize(work.contacts.size());
  work.moved.resize(work.contacts.size());

  cone::Options solver_options;
  solver_options.mode = exact ? cone::Mode::Exact : cone::Mode::Smoothed;
  solver_options.tol_complementarity =
      exact && derivatives ? std::max(options.tol_complementarity, kSensitivityComplementarity) : options.tol_complementarity;
  const bool coulomb = is_coulomb(options);
  solver_options.shift_by_tangent = coulomb;
  solver_options.warm_start = options.warm_start && !coulomb;  // where the shifts end depends on where they start
  solver_options.sensitivities = derivatives;
  out.iterations = 0;
  const int growths = work.problem->growths();
  const auto solve_rounds = [&] {
    if (!exact)
      include_smoothed(model, in, options, analytic->self_sharpness, work);
    else if (guess == nullptr)
      include_within_reach(model, in, options, solver_options.shift_by_tangent, fall, work);
    else
      include_near(model, in, options, *guess, work);
    for (int round = 0; round < kMaxRounds; ++round) {
      cone::Problem& problem = *work.problem;
      problem.clear();
      work.bound_variables.clear();
      add_objective(work, options.h, problem);
      for (std::size_t i = 0; i < work.contacts.size(); ++i) {
        if (!work.included[i]) continue;
        const contact::Contact& contact = work.contacts[i];
        const bool self = work.self_contact[static_cast<std::size_t>(contact.pair)] != 0;
        add_contact(model, i, options.h, contact.friction * options.friction_scale, self ? sigma_self : sigma, work);
      }
      for_each_limit(model, in, [&](int variable, double sign, double offset) {
        const std::uint64_t id = limit_id(variable, sign);
        if (!work.limit_included[id]) return;
        problem.add_bound(id, variable, sign, offset, sigma_limit, during(work.variable_unit[at(variable)], options.h));
        work.bound_variables.push_back(variable);
      });
      out.status = cone::solve(problem, solver_options, *work.solver, work.solution);
      out.iterations += work.solution.iterations;
      if (out.status != Status::Solved || !add_violated(model, in, options, solver_options.shift_by_tangent, work)) break;
      if (round == kMaxRounds - 2) include_all(options, work);
    }
  };
  solve_rounds();
  if (coulomb && (out.status != Status::Solved || misses_contact(model, options, work))) {
    solver_options.shift_by_tangent = false;
    solve_rounds();  // from the rows it would start with by itself: Anitescu's step to the last digit
  }
  out.residuals = work.solution.residuals;
  out.growths = work.problem->growths() - growths;
  if (out.status != Status::Solved) {
    out.q_next = in.q;
    out.delta.setZero(model.n_v());
    out.contacts.clear();
    if (options.with_A) out.A.setZero(model.n_v(), model.n_v());
    if (options.with_B) out.B.setZero(model.n_v(), model.n_a());
    out.D_lambda_q.resize(0, 0);
    out.D_lambda_u.resize(0, 0);
    return out.status;
  }
  out.delta = work.solution.x;
  out.q_next.resize(model.n_q());
  world::retract(model, in.q, out.delta, out.q_next);
  if (guess == nullptr || options.with_A) read_contacts(model, options, work, out.contacts);
  if (derivatives) {
    const detail::SolvedStep solved{model,  options,     work.kinematics, work.J, work.included, work.rays, work.bound_variables,
                                    work.Q, *work.solver};
    detail::linearise(solved, work.contact_work, work.linearisation, out);
  }
  return out.status;
}

}  // namespace

Status step(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace& workspace, StepResult& out) {
  if (&model != &workspace.model()) core::throw_invalid("work", "the workspace of another model", "one made for this model");
  return solve_step(model, in, nullptr, options, workspace, out);
}

Status detail::sample_step(const Model& model, const StepInput& in, const Eigen::VectorXd& guess, const StepOptions& options,
                           StepWorkspace& workspace, StepResult& out) {
  return solve_step(model, in, &guess, options, workspace, out);
}

}  // namespace stiction::dynamics
