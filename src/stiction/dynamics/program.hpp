#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "stiction/cone/solver.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/dynamics/linearisation.hpp"
#include "stiction/dynamics/step.hpp"

// Internal to the layer: the program (2.6) of a step, its matrices and rows.

namespace stiction::dynamics {

namespace detail {

/// Scratch of add_met() (sweep.hpp): made when a step first moves that far.
struct Sweep {
  explicit Sweep(const world::Model& model);

  /// An axis of Kinematics after the one before it on the way from the root, which has the index 0 and is none.
  struct Axis {
    std::size_t before = 0;
    int axis = -1, dof = -1;
    double ratio = 1;      // how far it goes for one of the coordinate: 1 but for joints that follow another
    bool turns = false;    // else it slides
    bool reaches = false;  // reach() bounds what it moves: not an object, nor by a joint that follows the one before
  };
  /// Of an axis and all before it, or of all joints of a body.
  struct Sums {
    double turned = 0, moved = 0;  // Σ |angle| [rad], and a bound of what they move any point [m]
  };
  struct Twist {
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = v;  // of δq, at the origin of W
  };
  /// Of a geometry: its bounding sphere.
  struct Ball {
    Eigen::Vector3d center, v;  // [m], and its motion to first order
    double radius = 0;
    double travel = 0;  // no point of the geometry goes farther [m]
  };
  struct Pair {
    std::size_t a = 0, b = 0;            // geometries,
    std::size_t body_a = 0, body_b = 0;  // and what they belong to
    std::size_t shared = 0;              // the last axis that moves both sides
    double radii = 0;                    // sum of those of the bounding spheres
    double touching = 0;                 // nearer than this they have met [m]
    double seen = 0;                     // nearer than this, and the margin, their contacts are known [m]
  };
  /// A place on the way, q ⊕ s δq.
  struct Place {
    double s = 0;
    world::Kinematics kinematics;
    std::vector<Twist> twists;  // per axis: of it and all before it
  };

  std::vector<Axis> axes;
  std::vector<std::size_t> last;  // per body: its last axis
  std::vector<Pair> pairs;
  std::vector<Sums> sums;     // per axis
  std::vector<Sums> motion;   // per body
  std::vector<Ball> balls;    // per geometry
  std::vector<Place> places;  // of this δq the first n_places, q at the front
  std::size_t n_places = 0;
  std::vector<int> far;  // pairs that may meet
  std::vector<int> met;  // of this step, ascending
  std::vector<int> added;
  std::vector<contact::Contact> contacts;
  world::KinematicsWorkspace kinematics_work;
  contact::Workspace contact_work;
  Eigen::VectorXd q, part;
};

/// Which pairs an exact step looks at (reach.hpp).
struct Reach {
  explicit Reach(const world::Model& model);

  std::vector<int> pairs;               // whose contacts cost more than to tell that there are none: of meshes, and of flat sides
  std::vector<int> close;               // those of them whose bounding spheres are within the contact distance
  std::vector<double> near;             // per pair: nearer ones have their contacts [m]
  std::vector<Eigen::Vector3d> v, w;    // twists per body, at the origin of W
  std::vector<Eigen::Vector3d> center;  // of the bounding sphere per geometry, in W
  double margin = 0;                    // beyond max_distance, within which all contacts would be looked for [m]
};

/// A hinge or slider with dry friction (S.19).
struct FrictionJoint {
  int v = -1;                     // velocity index
  double friction = 0;            // τ_f [N·m or N]
  double stiction = 0;            // k, of the spring with which it sticks [N·m/rad or N/m]
  std::size_t entry = 0;          // of Q, on the diagonal
  double inertia = 0, drive = 0;  // Q and b without the joint's friction
  int side = 0;                   // ±1: its friction saturates on this side, and it slides to the other; 0: it sticks
  int bound = -1;                 // index of its bound in the problem, −1 where there is none
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
  std::size_t near_contacts = 0;  // the first of them, found by their distance at q; the others by what δq meets
  std::optional<detail::Sweep> sweep;
  detail::Reach reach{*model};
  Eigen::VectorXd q_seen;    // of kinematics, contacts and J: a step from the same q, as the samples of a local model are, takes them over
  double margin_seen = -1;   // of contacts and J [m]; < 0: there are none at q_seen
  double fall_seen = 0;      // likewise
  std::vector<double> near;  // per pair: nearer ones are listed [m]
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
  std::size_t springs = 0;            // index of the first robot joint's entry, which is on the diagonal
  Eigen::VectorXd b;
  Eigen::VectorXd commanded;           // (0; u − qᵃ)
  std::vector<char> included;          // per contact: its rows are in the problem
  std::vector<Eigen::Vector3d> moved;  // per contact that is not: J_c δq
  std::vector<char> limit_included;    // per limit_id
  std::vector<int> bound_variables;    // of the limits in the problem, in order of adding, of the motors and of friction_joints after them
  std::size_t moving_bounds = 0;       // how many of them: limits and motors, whose offsets move with q
  std::vector<signed char> motor;      // per robot joint: the side, ±1, on which its spring saturates (S.15); 0: on none
  std::vector<int> motor_bound;        // per robot joint: index of its bound in the problem, −1 where there is none
  std::vector<detail::FrictionJoint> friction_joints;
  detail::LinearisationWorkspace linearisation;
};

namespace detail {

constexpr int kMostRays = 64;  // of a polyhedral cone

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Unit for steps of h, from that for 1 s.
cone::Unit during(cone::Unit unit, double h);

/// Objective of (2.6): Q = blkdiag(ε M_u/h, h K_a), b = −h (τ_u; K_a(u − qᵃ) + τ_a), into the workspace. Returns how far gravity
/// can move an object in one step when nothing holds it, h²‖τ_u‖/(ε m) [m].
double calc_objective(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work,
                      Eigen::VectorXd& epsilon);

/// The robots' part of it, K_a where `motor` is 0. Where it is ±1: b = −h(±effort + τ_a), and the quadratic part is that of add_motors (S.15).
void set_springs(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

void add_objective(const StepWorkspace::Impl& work, double h, cone::Problem& problem);

/// Rows ±(u − qᵃ − δqᵃ) − effort/K_a + z/(hK_a) ≥ 0 of the joints whose `motor` is ±1.
void add_motors(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

/// Torques of the springs, and which of them give all they have.
void read_motors(const world::Model& model, const StepInput& in, const StepOptions& options, const StepWorkspace::Impl& work,
                 StepResult& out);

/// Rays of (2.10): ±t1 in the plane, n_d around the cone of a polyhedral model, none for the second-order cone.
void set_rays(const world::Model& model, const StepOptions& options, std::vector<Eigen::Vector2d>& rays);

/// Rows of contact i: a Lorentz cone (J_n δq + φ, μJ_t δq), or half-lines (J_n + μ dᵀJ_t) δq + φ for every ray d (2.10).
void add_contact(const world::Model& model, std::size_t i, double h, double mu, double sigma, StepWorkspace::Impl& work);

/// Calls visit(variable, sign, offset) for every joint limit sign·δq_variable + offset ≥ 0.
template <class Visit>
void for_each_limit(const world::Model& model, const StepInput& in, Visit&& visit) {
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

inline std::uint64_t limit_id(int variable, double sign) { return static_cast<std::uint64_t>(2 * variable + (sign > 0 ? 0 : 1)); }

/// Rows (n, t1, t2) of J_c over the variables of its support.
inline const double* jacobian(const StepWorkspace::Impl& work, std::size_t contact) { return work.J.values.data() + work.J.begin[contact]; }

}  // namespace detail
}  // namespace stiction::dynamics
