#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "stiction/cone/solver.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/dynamics/linearisation.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/world/scales.hpp"

// Internal to the layer: the program (2.6) of a step, its matrices and rows.

namespace stiction::dynamics {

namespace detail {

/// Scratch of add_met() (sweep.hpp). It is made when a step first moves far enough to need it.
struct Sweep {
  explicit Sweep(const world::Model& model);

  /// An axis of Kinematics, linked to the axis before it on the way from the root. Index 0 stands for the root, which is no axis.
  struct Axis {
    std::size_t before = 0;
    int axis = -1, dof = -1;
    double ratio = 1;      // motion of the axis per unit of its coordinate; differs from 1 only for joints that follow another joint
    bool turns = false;    // revolute; otherwise prismatic
    bool reaches = false;  // reach() bounds its motion: false for objects and for a joint that follows the joint before
  };
  /// Motion summed over an axis and all axes before it, or over all joints of a body.
  struct Sums {
    double turned = 0, moved = 0;  // Σ |angle| [rad], and a bound on the motion of any point [m]
  };
  struct Twist {
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = v;  // twist under δq, at the origin of W
  };
  /// Bounding sphere of a geometry.
  struct Ball {
    Eigen::Vector3d center, v;  // centre and its first-order motion [m]
    double radius = 0;
    double travel = 0;  // bound on the motion of any point of the geometry [m]
  };
  struct Pair {
    std::size_t a = 0, b = 0;            // geometries
    std::size_t body_a = 0, body_b = 0;  // bodies of these geometries
    std::size_t shared = 0;              // the last axis that moves both sides
    double radii = 0;                    // sum of the radii of both bounding spheres
    double touching = 0;                 // the pair has met if it is nearer than this [m]
    double seen = 0;                     // contacts are known if the pair is nearer than this plus the margin [m]
  };
  /// A configuration on the path of the step, q ⊕ s δq.
  struct Place {
    double s = 0;
    world::Kinematics kinematics;
    std::vector<Twist> twists;  // per axis: twist by this axis and all axes before it
  };

  std::vector<Axis> axes;
  std::vector<std::size_t> last;  // per body: its last axis
  std::vector<Pair> pairs;
  std::vector<Sums> sums;     // per axis
  std::vector<Sums> motion;   // per body
  std::vector<Ball> balls;    // per geometry
  std::vector<Place> places;  // the first n_places belong to the current δq; q comes first
  std::size_t n_places = 0;
  std::vector<int> far;  // pairs that may meet
  std::vector<int> met;  // pairs met in this step, ascending
  std::vector<int> added;
  std::vector<contact::Contact> contacts;
  world::KinematicsWorkspace kinematics_work;
  contact::Workspace contact_work;
  Eigen::VectorXd q, part;
};

/// The pairs whose contacts an exact step lists (reach.hpp).
struct Reach {
  explicit Reach(const world::Model& model);

  std::vector<int> pairs;               // pairs with meshes or flat faces: finding contacts costs more than ruling them out
  std::vector<int> close;               // those of `pairs` whose bounding spheres are within the contact distance
  std::vector<double> near;             // per pair: distance within which contacts are listed [m]
  std::vector<Eigen::Vector3d> v, w;    // twists per body, at the origin of W
  std::vector<Eigen::Vector3d> center;  // per geometry: centre of the bounding sphere, in W
  double margin = 0;                    // margin on max_distance of the query for all contacts [m]
};

/// A hinge or slider with dry friction (S.19).
struct FrictionJoint {
  int v = -1;                     // velocity index
  double friction = 0;            // τ_f [N·m or N]
  double stiction = 0;            // stiffness k of the spring that holds it while it sticks [N·m/rad or N/m]
  std::size_t entry = 0;          // index in Q of its diagonal entry
  double inertia = 0, drive = 0;  // Q and b without the joint's friction
  int side = 0;                   // ±1: friction saturates on this side and the joint slides to the other; 0: it sticks
  int bound = -1;                 // index of its bound in the problem, −1: none
};

}  // namespace detail

struct StepWorkspace::Impl {
  explicit Impl(std::shared_ptr<const world::Model> m);

  std::shared_ptr<const world::Model> model;
  std::shared_ptr<cone::Layout> layout;
  std::vector<int> supports;       // Model::supports() → Layout support
  std::vector<char> self_contact;  // per pair
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  contact::Workspace contact_work;
  std::vector<contact::Contact> contacts;
  std::size_t near_contacts = 0;  // the first near_contacts were found by distance at q, the others along δq
  std::optional<detail::Sweep> sweep;
  detail::Reach reach{*model};
  Eigen::VectorXd q_seen;    // q of kinematics, contacts and J; a step from the same q (samples of a local model) reuses them
  double margin_seen = -1;   // margin of contacts and J [m]; < 0: not computed at q_seen
  double fall_seen = 0;      // `fall` of contacts and J [m]
  std::vector<double> near;  // per pair: distance within which contacts are listed by the query [m]
  std::optional<cone::Problem> problem;
  std::optional<cone::Workspace> solver;
  cone::Result solution;
  double softest = 1.0;                   // [N/m]
  std::vector<cone::Unit> variable_unit;  // for h = 1 s
  std::vector<cone::Unit> pair_unit;      // for h = 1 s
  std::vector<double> object_radius;      // radius of the sphere about the body origin that encloses the object [m]
  int max_object_dofs = 0;
  Eigen::VectorXd tau_u;
  Eigen::MatrixXd M_u;
  contact::Jacobians J;
  std::vector<double> G;
  std::vector<Eigen::Vector2d> rays;  // rays of the friction cone in (t1, t2); empty: second-order cone
  std::vector<detail::QEntry> Q;      // lower triangle
  std::size_t springs = 0;            // index in Q of the first robot joint's diagonal entry
  Eigen::VectorXd b;
  Eigen::VectorXd commanded;           // (0; u − qᵃ)
  std::vector<char> included;          // per contact: its rows are in the problem
  std::vector<Eigen::Vector3d> moved;  // per contact that is not included: J_c δq
  std::vector<char> limit_included;    // per limit_id
  std::vector<int> bound_variables;    // variables of the bounds, in order of adding: joint limits, motors, friction_joints
  std::size_t moving_bounds = 0;       // number of bounds whose offsets move with q: limits and motors
  std::vector<signed char> motor;      // per robot joint: side ±1 on which its spring saturates (S.15); 0: not saturated
  std::vector<int> motor_bound;        // per robot joint: index of its bound in the problem, −1: none
  // Gap in the rows of overlaps that may stay; −∞: none may. See keep_overlaps().
  double kept_gap = -std::numeric_limits<double>::infinity();
  std::vector<detail::FrictionJoint> friction_joints;
  detail::LinearisationWorkspace linearisation;
};

namespace detail {

constexpr int kMostRays = 64;  // largest number of rays of a polyhedral cone

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Converts a unit for steps of 1 s to steps of h [s].
cone::Unit during(cone::Unit unit, double h);

/// Writes the objective of (2.6) to the workspace: Q = blkdiag(ε M_u/h, h K_a), b = −h (τ_u; K_a(u − qᵃ) + τ_a).
/// @returns how far gravity can move an object in one step if nothing holds it, h²‖τ_u‖/(ε m) [m]
double calc_objective(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work,
                      Eigen::VectorXd& epsilon);

/// Writes the robots' part of the objective, with stiffness K_a if `motor` is 0. If `motor` is ±1, b = −h(±effort + τ_a) and add_motors()
/// adds the quadratic part (S.15).
void set_springs(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

void add_objective(const StepWorkspace::Impl& work, double h, cone::Problem& problem);

/// Adds the rows ±(u − qᵃ − δqᵃ) − effort/K_a + z/(hK_a) ≥ 0 of the joints whose `motor` is ±1.
void add_motors(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

/// Reads the torques of the joint springs, and which motors are saturated.
void read_motors(const world::Model& model, const StepInput& in, const StepOptions& options, const StepWorkspace::Impl& work,
                 StepResult& out);

/// Rays of (2.10): ±t1 in the plane, n_d around the cone of a polyhedral model, none for the second-order cone.
void set_rays(const world::Model& model, const StepOptions& options, std::vector<Eigen::Vector2d>& rays);

/// Adds the rows of contact i: a Lorentz cone (J_n δq + φ, μJ_t δq), or a half-line (J_n + μ dᵀJ_t) δq + φ for every ray d (2.10).
void add_contact(const world::Model& model, std::size_t i, double h, double mu, double sigma, StepWorkspace::Impl& work);

/// Gap in the row of a contact or limit: phi, or that of an overlap that may stay, which is within the tolerance. Both in [rad or m].
inline double row_gap(const StepWorkspace::Impl& work, double phi, double tolerance) {
  return phi < -tolerance ? phi : std::max(phi, work.kept_gap);
}
inline double row_gap(const StepWorkspace::Impl& work, std::size_t contact) {
  const contact::Contact& c = work.contacts[contact];
  return row_gap(work, c.phi, work.model->scales().contact_tolerance(c.pair));
}

/// True if a contact counts as active. What a solver of finite accuracy leaves on a contact that keeps its distance is no force: it may
/// exceed kActive F of a light object beside a heavy one.
/// @param impulse  normal impulse λ_n [N·s]
/// @param slack    slack of the row [m]
inline bool is_active(const world::Model& model, const StepOptions& options, int pair, double impulse, double slack) {
  const bool touches = slack < model.scales().contact_tolerance(pair) || !std::holds_alternative<Exact>(options.smoothing);
  return touches && impulse > options.h * world::share::kActive * model.scales().pair(pair).force;
}

/// Calls visit(variable, sign, offset) for every joint limit sign·δq_variable + offset ≥ 0.
template <class Visit>
void for_each_limit(const world::Model& model, const StepInput& in, const StepWorkspace::Impl& work, Visit&& visit) {
  const auto both = [&](int variable, double q, double lower, double upper) {
    const double tolerance = world::share::kContact * work.variable_unit[static_cast<std::size_t>(variable)].length;
    if (std::isfinite(lower)) visit(variable, 1.0, row_gap(work, q - lower, tolerance));
    if (std::isfinite(upper)) visit(variable, -1.0, row_gap(work, upper - q, tolerance));
  };
  for (int j = 0; j < model.n_a(); ++j) both(model.n_vu() + j, in.q[model.n_qu() + j], model.lower()[j], model.upper()[j]);
  for (const auto& object : model.objects()) {
    if (object.n_q != 1) continue;  // hinges and sliders are the objects with limits
    const auto& dof = model.dofs()[static_cast<std::size_t>(object.v_begin)];
    both(object.v_begin, in.q[object.q_begin], dof.lower, dof.upper);
  }
}

inline std::uint64_t limit_id(int variable, double sign) { return static_cast<std::uint64_t>(2 * variable + (sign > 0 ? 0 : 1)); }

/// Rows (n, t1, t2) of J_c over the variables of the contact's support.
inline const double* jacobian(const StepWorkspace::Impl& work, std::size_t contact) { return work.J.values.data() + work.J.begin[contact]; }

}  // namespace detail
}  // namespace stiction::dynamics
