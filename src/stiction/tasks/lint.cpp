#include "stiction/tasks/lint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "stiction/contact/clearance.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/lint_motors.hpp"
#include "stiction/tasks/lint_numbers.hpp"
#include "stiction/tasks/lint_robots.hpp"
#include "stiction/tasks/reach.hpp"
#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using world::BodyKind;
using world::Model;

/// A length as text, in mm below 0.1 m and otherwise in m.
std::string length(double x) { return std::abs(x) < 0.1 ? fmt::format("{:.3g} mm", 1e3 * x) : fmt::format("{:.3g} m", x); }

class Linter {
 public:
  explicit Linter(const Task& task)
      : task_(task), model_(*task.model), reach_(model_), kinematics_work_(model_), contact_work_(model_), q_goal_(task.problem.q_start) {
    q_goal_.head(model_.n_qu()) = task.problem.q_goal;
  }

  std::vector<Finding> run(const core::RunControl& control) {
    overlaps("start", task_.problem.q_start, [](int) { return true; });
    if (!goal().region)
      overlaps("goal", q_goal_, [this](int i) { return is_of(pair(i).geometry_a, goal().object) && stays(pair(i).geometry_b); });
    close_links();
    stuck();
    for (int i = 0; i < n_objects(); ++i) support(i);
    hold();
    reach_at("start", task_.problem.q_start);
    reach_at("goal", q_goal_);
    weight();
    lint_motors(task_, control, out_);
    gravity();
    for (int i = 0; i < n_objects(); ++i) size(i);
    lint_robots(task_, out_);
    lint_numbers(task_, out_);
    for (const auto& box : task_.options.sample_boxes) sample_box(box);
    goal_at_start();
    return std::move(out_);
  }

 private:
  const planning::Goal& goal() const { return task_.problem.goal; }
  int n_objects() const { return static_cast<int>(model_.objects().size()); }
  const world::ObjectInfo& object(int i) const { return model_.objects()[static_cast<std::size_t>(i)]; }
  const world::Geometry& geometry(int i) const { return model_.geometries()[static_cast<std::size_t>(i)]; }
  const world::Body& body_of(int g) const { return model_.bodies()[static_cast<std::size_t>(geometry(g).body)]; }
  const world::Pair& pair(int i) const { return model_.pairs()[static_cast<std::size_t>(i)]; }
  double near(int i) const { return world::share::kContact * model_.scales().pair(i).length; }

  template <class... Args>
  void say(const char* kind, fmt::format_string<Args...> text, Args&&... args) {
    out_.push_back({kind, fmt::format(text, std::forward<Args>(args)...)});
  }

  void place(const Eigen::VectorXd& q) { world::calc_kinematics(model_, q, kinematics_work_, kinematics_); }
  double distance(int i) { return contact::pair_distance(model_, kinematics_, i, contact_work_).phi; }

  /// Adds to the last finding its place under the current kinematics. @param p  pair of an overlap or a gap
  void place_finding(const char* where, int p) {
    const contact::Distance d = contact::pair_distance(model_, kinematics_, p, contact_work_);
    Finding& said = out_.back();
    said.where = where;
    said.names = {geometry(pair(p).geometry_a).name, geometry(pair(p).geometry_b).name};
    said.p_W = 0.5 * (d.p_WA + d.p_WB);
    said.amount = std::abs(d.phi);
  }
  void place_finding(const char* where, const std::string& name, std::optional<double> amount = {}) {
    out_.back().where = where;
    out_.back().names = {name};
    out_.back().amount = amount;
  }

  /// The nearest body that an object may touch. @param pair −1: there is none
  struct Nearest {
    int pair = -1;
    double phi = std::numeric_limits<double>::infinity();
  };
  Nearest nearest(int o, bool robots) {
    Nearest out;
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      const bool a = is_of(pair(i).geometry_a, o), b = is_of(pair(i).geometry_b, o);
      if (a == b) continue;
      if (!robots && body_of(a ? pair(i).geometry_b : pair(i).geometry_a).kind == BodyKind::Robot) continue;
      if (const double phi = distance(i); phi < out.phi) out = {i, phi};
    }
    return out;
  }
  bool is_of(int g, int o) const { return body_of(g).kind == BodyKind::Object && body_of(g).owner == o; }
  const std::string& other(int p, int o) const {
    return geometry(is_of(pair(p).geometry_a, o) ? pair(p).geometry_b : pair(p).geometry_a).name;
  }

  /// True for a fixed body, neither robot nor object: it has the same pose at the start and at the goal.
  bool stays(int g) const { return body_of(g).dofs.empty(); }

  template <class Wanted>
  void overlaps(const char* where, const Eigen::VectorXd& q, const Wanted& wanted) {
    place(q);
    std::map<std::pair<int, int>, std::pair<double, int>> deepest;  // per two bodies
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      const double phi = wanted(i) ? distance(i) : 0;
      if (phi >= -near(i)) continue;
      auto& worst = deepest.try_emplace({geometry(pair(i).geometry_a).body, geometry(pair(i).geometry_b).body}, 0.0, i).first->second;
      if (phi < worst.first) worst = {phi, i};
    }
    for (const auto& [bodies, worst] : deepest) {
      say("overlap", "{}: '{}' and '{}' overlap by {}", where, geometry(pair(worst.second).geometry_a).name,
          geometry(pair(worst.second).geometry_b).name, length(-worst.first));
      place_finding(where, worst.second);
    }
  }

  /// Links that nearly touch at rest: paths of the robot keep a smaller distance there. One line per pair of bodies.
  void close_links() {
    place(task_.problem.q_start);
    const double usual = world::share::kClearance * model_.scales().robots().length;
    std::map<std::pair<int, int>, contact::ClosePair> nearest;
    for (const contact::ClosePair& close : contact::find_close_pairs(model_, contact_work_)) {
      if (close.clearance() >= usual) continue;
      const auto bodies = std::pair(geometry(pair(close.pair).geometry_a).body, geometry(pair(close.pair).geometry_b).body);
      const auto [found, added] = nearest.try_emplace(bodies, close);
      if (!added && close.gap < found->second.gap) found->second = close;
    }
    for (const auto& [bodies, close] : nearest) {
      say("near",
          "start: '{}' and '{}' are {} apart where the robot rests: its paths keep {} between them there, elsewhere {}; exclude the "
          "pair in `filters` if these never meet",
          geometry(pair(close.pair).geometry_a).name, geometry(pair(close.pair).geometry_b).name, length(close.gap),
          length(close.clearance()), length(usual));
      place_finding("start", close.pair);
    }
  }

  /// The first step of the plan, from the start with the joints commanded where they are.
  void stuck() {
    dynamics::StepWorkspace work(task_.model);
    dynamics::StepResult result;
    const Eigen::VectorXd& q = task_.problem.q_start;
    const core::Status status = dynamics::step(model_, {q, q.tail(model_.n_a())}, task_.options.step_options(model_), work, result);
    if (status == core::Status::Solved) return press(result, task_.options.step_options(model_).h);
    place(q);
    int worst = -1;
    double depth = 0;
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      if (const double phi = distance(i); phi < -depth) worst = i, depth = -phi;
    }
    if (worst < 0) return say("stuck", "start: no step can be made from here ({})", core::to_string(status));
    say("stuck",
        "start: no step can be made from here ({}): nothing can undo that '{}' and '{}' overlap by {}; exclude the pair in `filters` if "
        "that is meant",
        core::to_string(status), geometry(pair(worst).geometry_a).name, geometry(pair(worst).geometry_b).name, length(depth));
    place_finding("start", worst);
  }

  /// Checks that a step that holds the start presses fragile bodies by no more than they bear.
  void press(const dynamics::StepResult& step, double h) {
    std::map<int, double> forces;
    for (const auto& c : step.contacts) forces[c.contact.pair] += c.lambda[0] / h;
    for (const auto& [i, force] : forces) {
      if (force <= pair(i).max_force) continue;
      place(task_.problem.q_start);
      say("force", "start: '{}' and '{}' press on each other with {:.3g} N, of which they bear {:.3g} N (max_force)",
          geometry(pair(i).geometry_a).name, geometry(pair(i).geometry_b).name, force, pair(i).max_force);
      place_finding("start", i);
    }
  }

  /// Gravity moves the object, which is not on a hinge, along a coordinate.
  bool has_weight(int o) {
    Eigen::VectorXd tau(model_.n_vu());
    world::calc_gravity(model_, kinematics_, tau);
    const auto& info = object(o);
    const double weight = info.carried_mass * model_.scene().gravity.norm();
    return tau.segment(info.v_begin, info.n_v).cwiseAbs().maxCoeff() > world::share::kForce * weight;
  }
  bool hangs(int o) const { return object(o).n_v == 1; }  // on a hinge or a slider, whose end stops carry it

  void support(int o) {
    place(task_.problem.q_start);
    if (hangs(o) || !has_weight(o)) return;
    const Nearest n = nearest(o, true);
    if (n.pair < 0) {
      say("unsupported", "start: nothing can touch '{}': it falls without end", object(o).name);
      place_finding("start", object(o).name);
    } else if (n.phi > near(n.pair)) {
      say("unsupported", "start: '{}' touches nothing, '{}' is {} away: it falls first; move it there, or put something fixed under it",
          object(o).name, other(n.pair, o), length(n.phi));
      place_finding("start", n.pair);
    }
  }

  void hold() {
    const int o = goal().object;
    place(q_goal_);
    if (hangs(o) || goal().region || !has_weight(o)) return;
    const Nearest n = nearest(o, false);
    if (n.pair >= 0 && n.phi <= std::max(near(n.pair), goal().tol_position)) return;
    std::set<int> hands;
    bool flat = false;
    for (const auto& p : model_.pairs()) {
      if (!is_of(p.geometry_a, o) && !is_of(p.geometry_b, o)) continue;
      const int g = is_of(p.geometry_a, o) ? p.geometry_b : p.geometry_a;
      if (body_of(g).kind != BodyKind::Robot) continue;
      hands.insert(geometry(g).body);
      flat |= std::holds_alternative<world::Box>(geometry(g).shape) || std::holds_alternative<world::Mesh>(geometry(g).shape);
    }
    if (hands.size() > 1 || flat) return;
    say("hold", "goal: '{}' is in the air, {} from the nearest support, and nothing can hold it there: the robots touch it with {}",
        object(o).name, n.pair < 0 ? "far" : length(n.phi), hands.empty() ? "nothing" : "one round body");
    place_finding("goal", object(o).name);
  }

  /// Bodies that hang on the object, and bodies that the object hangs on, move it as well.
  bool moves_with(int g, int o) const {
    const auto& body = body_of(g);
    if (body.kind != BodyKind::Object) return false;
    for (int i = body.owner; i >= 0; i = object(i).parent) {
      if (i == o) return true;
    }
    for (int i = o; i >= 0; i = object(i).parent) {
      if (i == body.owner) return true;
    }
    return false;
  }

  void reach_at(const char* where, const Eigen::VectorXd& q) {
    if (model_.n_a() == 0) return;
    for (const int o : planning::goal_objects(model_, goal())) {
      if (is_touched(o)) reach_of(o, where, q);
    }
  }

  /// True if a robot may touch the object or a body that moves with it. If no robot may, a tool has to.
  bool is_touched(int o) const {
    return std::any_of(model_.pairs().begin(), model_.pairs().end(),
                       [&](const world::Pair& p) { return moves_with(p.geometry_a, o) && body_of(p.geometry_b).kind == BodyKind::Robot; });
  }

  void reach_of(int o, const char* where, const Eigen::VectorXd& q) {
    place(q);
    double least = std::numeric_limits<double>::infinity();
    for (int g = 0; g < static_cast<int>(model_.geometries().size()); ++g) {
      if (!moves_with(g, o)) continue;
      const Eigen::Vector3d centre = kinematics_.X_WB[static_cast<std::size_t>(geometry(g).body)] * geometry(g).p_BCenter;
      least = std::min(least, reach_.distance(centre, geometry(g).bounding_radius));
    }
    if (!(least > 0 && std::isfinite(least))) return;
    say("reach", "{}: no robot reaches '{}': it is at least {} too far away", where, object(o).name, length(least));
    place_finding(where, object(o).name, least);
  }

  void weight() {
    if (model_.n_a() == 0 || model_.scene().gravity.norm() == 0) return;
    const int o = goal().object;
    const world::Scale& scale = model_.scales().object(o);
    const double stiffest = (model_.stiffness().array() / model_.reach().array().square()).maxCoeff();
    const double give = scale.force / stiffest;
    if (give > scale.length)
      say("weight",
          "'{}' weighs {:.3g} N ({:g} kg): even the stiffest joint gives way by {} under it, the object is {} large; kilograms, and N/m or "
          "N·m/rad?",
          object(o).name, scale.force, object(o).carried_mass, length(give), length(scale.length));
  }

  void gravity() {
    const Eigen::Vector3d& g = model_.scene().gravity;
    if (g.z() > 0 && g.z() >= g.cwiseAbs().maxCoeff())
      say("gravity", "scene.gravity: [{:g}, {:g}, {:g}] points upwards; z is up, and gravity [0, 0, -9.81]", g.x(), g.y(), g.z());
  }

  void size(int o) {
    const double reach = reach_.radius();
    if (reach == 0 || !std::isfinite(reach)) return;
    double width = 0;
    for (int g = 0; g < static_cast<int>(model_.geometries().size()); ++g) {
      if (is_of(g, o) && std::isfinite(geometry(g).bounding_radius)) width = std::max(width, 2 * geometry(g).bounding_radius);
    }
    if (width > 10 * reach)
      say("size", "'{}' is {} across and the robots reach {}; lengths are in metres, is it in millimetres?", object(o).name, length(width),
          length(reach));
    if (width > 0 && width < 1e-3 * reach)
      say("size", "'{}' is {} across and the robots reach {}; lengths are in metres", object(o).name, length(width), length(reach));
  }

  /// The goal, and the nearest place in the box that subgoals are drawn from.
  void sample_box(const world::SampleBox& box) {
    if (goal().region) return;
    const auto& info = object(box.object);
    planning::GoalRegion region{Eigen::VectorXd::Constant(model_.n_vu(), -std::numeric_limits<double>::infinity()),
                                Eigen::VectorXd::Constant(model_.n_vu(), std::numeric_limits<double>::infinity())};
    region.lower.segment(info.v_begin, info.n_v) = box.lower;
    region.upper.segment(info.v_begin, info.n_v) = box.upper;
    Eigen::VectorXd inside = q_goal_;
    planning::project(model_, region, inside.head(model_.n_qu()));
    const world::Pose X_goal = world::object_pose(model_, q_goal_, box.object), X_box = world::object_pose(model_, inside, box.object);
    const double angle = Eigen::Quaterniond(X_goal.R).angularDistance(Eigen::Quaterniond(X_box.R));
    const double position = (X_goal.p - X_box.p).norm();
    if (position > goal().tol_position || angle > goal().tol_angle)
      say("sample_box", "planner.sample_box.{}: leaves out the goal, by {} and {:.3g} rad", info.name, length(position), angle);
  }

  void goal_at_start() {
    if (planning::goal_error(model_, task_.problem.q_start, goal()).within(goal())) {
      say("goal", "goal: '{}' is there at the start already", object(goal().object).name);
      place_finding("goal", object(goal().object).name);
    }
  }

  const Task& task_;
  const Model& model_;
  Reach reach_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  contact::Workspace contact_work_;
  Eigen::VectorXd q_goal_;
  std::vector<Finding> out_;
};

}  // namespace

std::vector<Finding> lint(const Task& task, const core::RunControl& control) { return Linter(task).run(control); }

}  // namespace stiction::tasks
