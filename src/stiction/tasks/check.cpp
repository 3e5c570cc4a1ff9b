#include "stiction/tasks/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "stiction/contact/contact.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::tasks {
namespace {

using core::Status;
using world::Model;

/// The worst of a figure so far and where it was met.
struct Worst {
  double value = 0;
  std::string where;
  bool nan = false;

  /// `describe` is called only when x is the worst so far.
  template <class Describe>
  void see(double x, Describe&& describe) {
    if (std::isnan(x)) nan = true;
    if (x > value) {
      value = x;
      where = describe();
    }
  }
};

double angle_between(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  const Eigen::Quaterniond q(R0.transpose() * R1);
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

struct PoseError {
  double position, angle;
};

class Checker {
 public:
  Checker(const Task& task, const PlanFile& plan, const CheckOptions& options)
      : task_(task),
        plan_(plan),
        limits_(options),
        model_(*task.model),
        step_work_(task.model),
        kinematics_work_(model_),
        contact_work_(model_),
        step_options_(plan.step) {
    step_options_.smoothing = dynamics::Exact{};
    step_options_.with_B = false;
    step_options_.warm_start = false;  // every step depends on its input alone
    reference_force_ = reference_force();
    threshold_ = limits_.force_threshold * reference_force_;
  }

  Status run(const core::RunControl& control, CheckReport& out) {
    goal_object_ = model_.object_index(plan_.goal_object);
    for (const auto& segment : plan_.segments) n_knots_ += static_cast<long>(segment.knots.size());
    check_file();
    find_branches();
    start_penetration_ = deepest(plan_.q_start).first;

    Eigen::VectorXd q = plan_.q_start;
    const Eigen::VectorXd* q_before = &plan_.q_start;
    const Eigen::VectorXd* u_before = &plan_.u_start;
    for (std::size_t s = 0; s < plan_.segments.size(); ++s) {
      for (std::size_t k = 0; k < plan_.segments[s].knots.size(); ++k) {
        if (control.stop()) return control.cancelled() ? Status::Cancelled : Status::MaxIterations;
        const StoredKnot& knot = plan_.segments[s].knots[k];
        place_ = {static_cast<int>(s), static_cast<int>(k)};
        check_command(*u_before, knot.u);
        check_stored(*q_before, knot);
        half_step(0.5 * (*u_before + knot.u), q);
        half_step(knot.u, q);
        compare_with_path(q, knot.q);
        q_before = &knot.q;
        u_before = &knot.u;
        ++out.knots;
      }
      if (plan_.segments[s].kind == planning::SegmentKind::Regrasp && plan_.substep) check_regrasp(s);
    }
    const PoseError stored_end = goal_error(*q_before);
    error_.see(std::max(std::abs(stored_end.position - plan_.error.position), std::abs(stored_end.angle - plan_.error.angle)),
               [] { return std::string("stored error against the last knot"); });
    end_ = goal_error(q);
    out.steps = steps_;
    return Status::Solved;
  }

  void report(CheckReport& out) const {
    out.threshold_N = threshold_;
    add(out, "goal_position", end_.position, plan_.tol_position, "m");
    add(out, "goal_angle", end_.angle, plan_.tol_angle, "rad");
    add(out, "penetration", penetration_, std::max(0.0, start_penetration_) + limits_.penetration, "m");
    add(out, "joint_limits", joint_limits_, limits_.joint_limit, "rad or m");
    add(out, "command_limits", command_limits_, limits_.joint_limit, "rad or m");
    if (plan_.substep) {
      add(out, "command_step", command_step_, 1 + 1e-6, "of the limit");
    } else {
      add(out, "command_step", command_step_, std::nullopt, "rad or m");
    }
    add(out, "force_cone", force_cone_, limits_.cone_excess, "of the normal force");
    add(out, "force_gap", force_gap_, limits_.force_gap, "m");
    add(out, "regrasp_contact", regrasp_contact_, 0.0, "rad or m");
    add(out, "failed_steps", static_cast<double>(failed_steps_), 0.0, "");
    add(out, "quaternion_norm", quaternion_norm_, limits_.quaternion_norm, "");
    add(out, "start", start_, 1e-9, "rad or m");
    add(out, "goal", goal_, 1e-9, "rad or m");
    add(out, "dynamics", dynamics_, 0.0, "");
    add(out, "error", error_, 1e-9, "m or rad");
    add(out, "stored_position", stored_position_, limits_.stored_position, "m");
    add(out, "stored_angle", stored_angle_, limits_.stored_angle, "rad");
    add(out, "stored_force", stored_force_, limits_.stored_force, "of the largest force");
    add(out, "stored_cone", stored_cone_, 2e-5, "of the force");  // six decimals of force and normal
    add(out, "display_poses", display_, limits_.display, "");
    add(out, "path_position", path_position_, std::nullopt, "m");
    add(out, "path_angle", path_angle_, std::nullopt, "rad");
    add(out, "slide", slide_, std::nullopt, "m");
    out.pass =
        out.status == Status::Solved && std::all_of(out.items.begin(), out.items.end(), [](const CheckItem& item) { return item.pass; });
  }

 private:
  struct Place {
    int segment = -1, knot = -1;
  };

  static void add(CheckReport& out, std::string name, const Worst& worst, std::optional<double> limit, std::string unit) {
    out.items.push_back({.name = std::move(name),
                         .value = worst.nan ? std::numeric_limits<double>::max() : worst.value,
                         .limit = limit,
                         .unit = std::move(unit),
                         .pass = !worst.nan && (!limit || worst.value <= *limit),
                         .where = worst.where});
  }
  static void add(CheckReport& out, std::string name, double value, std::optional<double> limit, std::string unit) {
    Worst worst;
    worst.value = value;
    worst.nan = std::isnan(value);
    add(out, std::move(name), worst, limit, std::move(unit));
  }

  std::string here() const { return fmt::format("segment {}, knot {}", place_.segment, place_.knot); }
  std::string here(std::string_view what) const { return fmt::format("{} at {}", what, here()); }
  const std::string& joint_name(int j) const { return plan_.joints[static_cast<std::size_t>(j)]; }
  std::string pair_name(int pair) const {
    const auto& p = model_.pairs()[static_cast<std::size_t>(pair)];
    return model_.geometries()[static_cast<std::size_t>(p.geometry_a)].name + " – " +
           model_.geometries()[static_cast<std::size_t>(p.geometry_b)].name;
  }

  /// The scale of forces: the heaviest object's weight, or what moves the softest joint's farthest point by 1 mm, whichever is larger.
  double reference_force() const {
    double force = 0;
    for (const auto& object : model_.objects()) force = std::max(force, object.mass * model_.scene().gravity.norm());
    double softest = std::numeric_limits<double>::infinity();
    for (int j = 0; j < model_.n_a(); ++j) {
      const bool revolute = model_.dofs()[static_cast<std::size_t>(model_.n_vu() + j)].kind == world::DofKind::Revolute;
      const double arm = revolute ? model_.reach()[j] : 1.0;
      softest = std::min(softest, model_.stiffness()[j] / (arm * arm));
    }
    if (std::isfinite(softest)) force = std::max(force, softest * 1e-3);
    return force;
  }

  PoseError goal_error(const Eigen::VectorXd& q) const {
    const world::Pose X_WO = world::object_pose(model_, q, goal_object_);
    world::Pose X_WG = to_pose(plan_.goal_pose);
    if (plan_.region) {  // what the region means is part of the problem, not of how it was solved
      Eigen::VectorXd nearest = q;
      planning::project(model_, *plan_.region, nearest.head(model_.n_qu()));
      X_WG = world::object_pose(model_, nearest, goal_object_);
    }
    return {(X_WO.p - X_WG.p).norm(), angle_between(X_WO.R, X_WG.R)};
  }

  /// What does not need the dynamics: start, goal and settings are those of the task.
  void check_file() {
    const auto& problem = task_.problem;
    start_.see((plan_.q_start - problem.q_start).cwiseAbs().maxCoeff(), [] { return std::string("start of the plan against the task"); });
    start_.see((plan_.u_start - problem.q_start.tail(model_.n_a())).cwiseAbs().maxCoeff(),
               [] { return std::string("command at the start against the joints of the task"); });
    see_quaternions(plan_.q_start);

    if (goal_object_ != problem.goal.object) goal_.see(1, [] { return std::string("another object than that of the task"); });
    goal_.see(std::max(std::abs(plan_.tol_position - problem.goal.tol_position), std::abs(plan_.tol_angle - problem.goal.tol_angle)),
              [] { return std::string("tolerances against the task"); });
    if (!plan_.goal_from_command_line) {
      const world::Pose X_WG = to_pose(plan_.goal_pose);
      if (!plan_.region)
        goal_.see((X_WG.p - problem.goal.X_WG.p).norm() + angle_between(X_WG.R, problem.goal.X_WG.R),
                  [] { return std::string("goal pose against the task"); });
      const auto& region = problem.goal.region;
      const bool same = plan_.region.has_value() == region.has_value() &&
                        (!region || (plan_.region->lower == region->lower && plan_.region->upper == region->upper));
      if (!same) goal_.see(1, [] { return std::string("goal region against the task"); });
    }

    const auto differs = [this](std::string what) { dynamics_.see(1, [&] { return what; }); };
    const dynamics::StepOptions& step = plan_.step;
    if (step.h > task_.options.h) differs("step.h above that of the task");
    if (step.friction_law != task_.options.friction_law) differs("step.friction_law is not that of the task");
    if (step.friction_scale > 1) differs("step.friction_scale above 1");
    if (!step.joint_limits) differs("step.joint_limits is off");
    if (step.tol_complementarity > 1e-8) differs("step.tol_complementarity above 1e-8");
    if (step.regularisation.index() != task_.options.regularisation.index() ||
        regularisation_value(step.regularisation) != regularisation_value(task_.options.regularisation)) {
      differs("step.regularisation is not that of the task");
    }
    if (plan_.substep.has_value() != task_.options.substep.has_value()) {
      differs("substep is not that of the task");
    } else if (plan_.substep) {
      const auto& mine = *plan_.substep;
      const auto& wanted = *task_.options.substep;
      if (mine.joint_angle > wanted.joint_angle || mine.joint_travel > wanted.joint_travel || mine.slide > wanted.slide) {
        differs("substep allows more than the task");
      }
    }
  }

  static double regularisation_value(const dynamics::Regularisation& r) {
    if (const auto* rule = std::get_if<dynamics::ByRule>(&r)) return rule->ratio;
    return std::get<dynamics::FixedEpsilon>(r).epsilon;
  }

  void see_quaternions(const Eigen::VectorXd& q) {
    for (std::size_t i = 0; i < plan_.objects.size(); ++i) {
      if (plan_.objects[i].joint != world::ObjectJoint::Free) continue;
      const int at = model_.objects()[i].q_begin + 3;
      quaternion_norm_.see(std::abs(q.segment(at, 4).norm() - 1), [&] { return here(plan_.objects[i].name); });
    }
  }

  /// The same state with unit quaternions, so that an edited file can be simulated on and is judged by quaternion_norm.
  Eigen::VectorXd normalised(const Eigen::VectorXd& q) const {
    Eigen::VectorXd out = q;
    for (std::size_t i = 0; i < plan_.objects.size(); ++i) {
      if (plan_.objects[i].joint != world::ObjectJoint::Free) continue;
      auto c = out.segment(model_.objects()[i].q_begin + 3, 4);
      if (c.norm() > 0) {
        c.normalize();
      } else {
        c << 0, 0, 0, 1;
      }
    }
    return out;
  }

  void check_command(const Eigen::VectorXd& before, const Eigen::VectorXd& u) {
    for (int j = 0; j < model_.n_a(); ++j) {
      command_limits_.see(std::max(model_.lower()[j] - u[j], u[j] - model_.upper()[j]), [&] { return here(joint_name(j)); });
      double unit = 1;
      if (plan_.substep) {
        const bool revolute = model_.dofs()[static_cast<std::size_t>(model_.n_vu() + j)].kind == world::DofKind::Revolute;
        unit = revolute ? plan_.substep->joint_angle : plan_.substep->joint_travel;
      }
      command_step_.see(std::abs(u[j] - before[j]) / unit, [&] { return here(joint_name(j)); });
    }
  }

  void see_joint_limits(const Eigen::VectorXd& q) {
    const auto q_a = q.tail(model_.n_a());
    for (int j = 0; j < model_.n_a(); ++j) {
      joint_limits_.see(std::max(model_.lower()[j] - q_a[j], q_a[j] - model_.upper()[j]), [&] { return here(joint_name(j)); });
    }
  }

  /// Deepest penetration at q [m], ≥ 0, and its pair (−1: none).
  std::pair<double, int> deepest(const Eigen::VectorXd& q) {
    world::calc_kinematics(model_, q, kinematics_work_, kinematics_);
    contact::query(model_, kinematics_, {.margin = 0, .cutoff = 0}, contact_work_, contacts_);
    std::pair<double, int> worst{0, -1};
    for (const auto& contact : contacts_) {
      if (-contact.phi > worst.first) worst = {-contact.phi, contact.pair};
    }
    return worst;
  }

  /// A branch of a robot (finger, arm, trunk): its joints, and the pairs that change with it.
  struct Branch {
    std::vector<int> joints;  ///< indices of q
    std::vector<int> pairs;
  };

  void find_branches() {
    const auto body = [&](int geometry) -> const world::Body& {
      return model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(geometry)].body)];
    };
    for (const auto& robot : model_.robots()) {
      for (const auto& chain : robot.chains) {
        Branch& branch = branches_.emplace_back();
        for (const int v : chain) branch.joints.push_back(model_.n_q() - model_.n_v() + v);
        const auto moves = [&](int geometry) {
          const auto& dofs = body(geometry).dofs;
          return std::any_of(dofs.begin(), dofs.end(), [&](int v) { return std::find(chain.begin(), chain.end(), v) != chain.end(); });
        };
        for (std::size_t i = 0; i < model_.pairs().size(); ++i) {
          const auto& pair = model_.pairs()[i];
          if (moves(pair.geometry_a) != moves(pair.geometry_b)) branch.pairs.push_back(static_cast<int>(i));
        }
      }
    }
  }

  /// A branch that goes elsewhere in a regrasp touches nothing from when it was first free, 1 mm from everything, to when it was last.
  void check_regrasp(std::size_t segment) {
    constexpr double kFree = 1e-3, kGoesElsewhere = 0.1;  // [m], [rad or m]: a finger that only stops pushing stays where it is
    constexpr double kTouching = 1e-4;                    // [m]: what is pushed away keeps a gap of some micrometres
    const auto& knots = plan_.segments[segment].knots;
    for (const Branch& branch : branches_) {
      std::vector<double> gap(knots.size()), travel(knots.size(), 0.0);
      double all = 0, excursion = 0;
      for (std::size_t k = 1; k < knots.size(); ++k) {
        for (const int j : branch.joints) {
          travel[k] = std::max(travel[k], std::abs(knots[k].q[j] - knots[k - 1].q[j]));
          excursion = std::max(excursion, std::abs(knots[k].q[j] - knots[0].q[j]));
        }
        all += travel[k];
      }
      if (excursion < kGoesElsewhere) continue;
      for (std::size_t k = 0; k < knots.size(); ++k) {
        world::calc_kinematics(model_, normalised(knots[k].q), kinematics_work_, kinematics_);
        gap[k] = contact::calc_min_distance(model_, kinematics_, branch.pairs, -std::numeric_limits<double>::infinity(), contact_work_);
      }
      const auto is_free = [](double x) { return x >= kFree; };
      const auto first = std::find_if(gap.begin(), gap.end(), is_free);
      const auto last = std::find_if(gap.rbegin(), gap.rend(), is_free).base();
      double touching = first == gap.end() ? all : 0.0;
      for (auto it = first; it < last; ++it) touching += *it <= kTouching ? travel[static_cast<std::size_t>(it - gap.begin())] : 0.0;
      regrasp_contact_.see(touching, [&] {
        return fmt::format("{} in segment {}", joint_name(branch.joints.front() - (model_.n_q() - model_.n_a())), segment);
      });
    }
  }

  bool step(const Eigen::VectorXd& q, const Eigen::VectorXd& u) {
    ++steps_;
    const Status status = dynamics::step(model_, {q, u}, step_options_, step_work_, result_);
    if (status == Status::Solved) return true;
    ++failed_steps_;
    return false;
  }

  /// One step of the re-simulation from q, judged; q becomes the state after it.
  void half_step(const Eigen::VectorXd& u, Eigen::VectorXd& q) {
    if (!step(q, u)) return;
    q = result_.q_next;
    see_joint_limits(q);
    const auto [depth, pair] = deepest(q);  // leaves the kinematics at q
    penetration_.see(depth, [&] { return here(pair_name(pair)); });
    for (const auto& c : result_.contacts) {
      const Eigen::Vector3d force = c.lambda / step_options_.h;
      if (force.norm() <= threshold_) continue;
      force_cone_.see((force.tail<2>().norm() - friction(c.contact.pair) * force[0]) / std::max(std::abs(force[0]), threshold_),
                      [&] { return here(pair_name(c.contact.pair)); });
      const double phi = contact::pair_distance(model_, kinematics_, c.contact.pair, contact_work_).phi;
      force_gap_.see(phi, [&] { return here(fmt::format("{} ({:.3g} N)", pair_name(c.contact.pair), force.norm())); });
      slide_.see(c.displacement.tail<2>().norm(), [&] { return here(pair_name(c.contact.pair)); });
    }
  }

  double friction(int pair) const { return step_options_.friction_scale * model_.pairs()[static_cast<std::size_t>(pair)].friction; }

  /// A stored knot against one full sub-step from the knot before it, and against itself.
  void check_stored(const Eigen::VectorXd& q_before, const StoredKnot& knot) {
    see_quaternions(knot.q);
    see_joint_limits(knot.q);
    const Eigen::VectorXd q = normalised(knot.q);
    const auto [depth, pair] = deepest(q);  // leaves the kinematics at q
    penetration_.see(depth, [&] { return here("stored " + pair_name(pair)); });
    check_display(knot);
    check_stored_cones(knot);
    const Eigen::VectorXd q_from = normalised(q_before);
    if (!step(q_from, knot.u)) return;
    compare_states(result_.q_next, q, stored_position_, stored_angle_);
    check_stored_forces(q_from, knot);
  }

  void compare_states(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Worst& position, Worst& angle) {
    for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
      const world::Pose X_a = world::object_pose(model_, a, i);
      const world::Pose X_b = world::object_pose(model_, b, i);
      const auto name = [&] { return here(model_.objects()[static_cast<std::size_t>(i)].name); };
      position.see((X_a.p - X_b.p).norm(), name);
      angle.see(angle_between(X_a.R, X_b.R), name);
    }
    for (int j = 0; j < model_.n_a(); ++j) {
      const bool revolute = model_.dofs()[static_cast<std::size_t>(model_.n_vu() + j)].kind == world::DofKind::Revolute;
      (revolute ? angle : position).see(std::abs(a.tail(model_.n_a())[j] - b.tail(model_.n_a())[j]), [&] { return here(joint_name(j)); });
    }
  }

  void check_stored_cones(const StoredKnot& knot) {
    for (const auto& c : knot.contacts) {
      const double f_n = c.force_W.dot(c.normal_W);
      const double f_t = (c.force_W - f_n * c.normal_W).norm();
      const auto name = [&] { return here(plan_.geometries[static_cast<std::size_t>(c.a)].name); };
      stored_cone_.see(std::abs(c.normal_W.norm() - 1), name);
      stored_cone_.see((f_t - step_options_.friction_scale * friction_of(c) * f_n) / std::max(c.force_W.norm(), reference_force_), name);
    }
  }

  double friction_of(const StoredContact& c) const {
    const double a = model_.geometries()[static_cast<std::size_t>(c.a)].friction;
    const double b = model_.geometries()[static_cast<std::size_t>(c.b)].friction;
    return a + b > 0 ? 2 * a * b / (a + b) : 0;
  }

  /// Redundant contacts may share a load in many ways, and a hinge takes whatever does not turn it: what is compared is the sum over the
  /// contacts along every coordinate that an object slides along or, where it is held by a joint, turns about (as a force at the longest lever).
  void check_stored_forces(const Eigen::VectorXd& q_before, const StoredKnot& knot) {
    struct Force {
      int a, b;  // geometries
      Eigen::Vector3d point_W, force_W;
    };
    std::vector<Force> stored, simulated;
    for (const auto& c : knot.contacts) stored.push_back({c.a, c.b, c.point_W, c.force_W});
    for (const auto& c : result_.contacts) {
      const auto& pair = model_.pairs()[static_cast<std::size_t>(c.contact.pair)];
      simulated.push_back({pair.geometry_a, pair.geometry_b, c.contact.p_WB, dynamics::calc_wrench(c, step_options_.h).head<3>()});
    }
    double largest = reference_force_;
    for (const auto* forces : {&stored, &simulated}) {
      for (const Force& f : *forces) largest = std::max(largest, f.force_W.norm());
    }
    world::calc_kinematics(model_, q_before, kinematics_work_, kinematics_);
    for (const auto& object : model_.objects()) {
      for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) {
        const bool revolute = model_.dofs()[static_cast<std::size_t>(v)].kind == world::DofKind::Revolute;
        if (revolute && object.n_v == 6) continue;
        const Eigen::Vector3d axis = kinematics_.axis_W.col(v), origin = kinematics_.origin_W.col(v);
        const auto direction = [&](const Eigen::Vector3d& point) { return revolute ? Eigen::Vector3d(axis.cross(point - origin)) : axis; };
        const auto moves = [&](int geometry) {
          const auto& dofs = model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(geometry)].body)].dofs;
          return std::find(dofs.begin(), dofs.end(), v) != dofs.end();
        };
        double lever = revolute ? 1e-3 : 1.0;
        const auto along = [&](const std::vector<Force>& forces) {
          double sum = 0;
          for (const Force& f : forces) {
            const double sign = static_cast<double>(moves(f.a)) - static_cast<double>(moves(f.b));
            sum += sign * direction(f.point_W).dot(f.force_W);
            if (sign != 0) lever = std::max(lever, direction(f.point_W).norm());
          }
          return sum;
        };
        const double difference = along(stored) - along(simulated);
        stored_force_.see(std::abs(difference) / lever / largest, [&] { return here(object.name); });
      }
    }
  }

  void check_display(const StoredKnot& knot) {
    std::size_t shown = 0;
    std::vector<char> has_geometry(model_.bodies().size(), 0);
    for (const auto& geometry : model_.geometries()) has_geometry[static_cast<std::size_t>(geometry.body)] = 1;
    for (std::size_t b = 0; b < has_geometry.size(); ++b) {
      if (!has_geometry[b] || model_.bodies()[b].dofs.empty()) continue;
      const PoseNumbers actual = to_numbers(kinematics_.X_WB[b]);
      const PoseNumbers& stored = knot.bodies[shown++];
      double same = 0, opposite = 0;  // both signs of a quaternion are the same rotation
      for (std::size_t i = 0; i < 7; ++i) {
        const double sign = i < 3 ? 1.0 : -1.0;
        same = std::max(same, std::abs(stored[i] - actual[i]));
        opposite = std::max(opposite, std::abs(stored[i] - sign * actual[i]));
      }
      display_.see(std::min(same, opposite), [&] { return here(model_.bodies()[b].name); });
    }
  }

  void compare_with_path(const Eigen::VectorXd& q, const Eigen::VectorXd& q_stored) {
    const world::Pose X = world::object_pose(model_, q, goal_object_);
    const world::Pose X_stored = world::object_pose(model_, normalised(q_stored), goal_object_);
    path_position_.see((X.p - X_stored.p).norm(), [&] { return here(); });
    path_angle_.see(angle_between(X.R, X_stored.R), [&] { return here(); });
  }

  const Task& task_;
  const PlanFile& plan_;
  const CheckOptions& limits_;
  const Model& model_;
  dynamics::StepWorkspace step_work_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  contact::Workspace contact_work_;
  std::vector<contact::Contact> contacts_;
  dynamics::StepOptions step_options_;
  dynamics::StepResult result_;
  int goal_object_ = 0;
  std::vector<Branch> branches_;
  double reference_force_ = 0;
  double threshold_ = 0;
  double start_penetration_ = 0;
  long n_knots_ = 0;
  long steps_ = 0;
  long failed_steps_ = 0;
  Place place_;
  PoseError end_{0, 0};
  Worst penetration_, joint_limits_, command_limits_, command_step_, force_cone_, force_gap_, quaternion_norm_, start_, goal_, dynamics_,
      error_, regrasp_contact_, stored_position_, stored_angle_, stored_force_, stored_cone_, display_, path_position_, path_angle_, slide_;
};

}  // namespace

const CheckItem& CheckReport::at(std::string_view name) const {
  for (const auto& item : items) {
    if (item.name == name) return item;
  }
  core::throw_invalid("check", fmt::format("'{}'", name), "the name of a check");
}

Status check_plan(const Task& task, const PlanFile& plan, const CheckOptions& options, const core::RunControl& control, CheckReport& out) {
  const auto start = core::RunControl::Clock::now();
  out = {};
  Checker checker(task, plan, options);
  out.status = checker.run(control, out);
  checker.report(out);
  out.wall_s = std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
  return out.status;
}

}  // namespace stiction::tasks
