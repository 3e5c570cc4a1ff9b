#include "stiction/tasks/check_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/status.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/pose_numbers.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using world::Model;

double value_of(const dynamics::Regularisation& r) {
  if (const auto* rule = std::get_if<dynamics::ByRule>(&r)) return rule->ratio;
  return std::get<dynamics::FixedEpsilon>(r).epsilon;
}

/// Options as a search with this seed, threads, scheme and anytime writes them.
std::string spell_as_searched(planning::PlannerOptions options, const planning::PlannerOptions& searched, const Model& model) {
  options.seed = searched.seed;
  options.threads = searched.threads;
  if (options.thesis && searched.thesis) options.thesis->scheme = searched.thesis->scheme;
  options.anytime = searched.anytime;
  return planner_options_json(options, model);
}

}  // namespace

FileCheck::FileCheck(const Task& task, const PlanFile& plan, const CheckOptions& options)
    : task_(task),
      plan_(plan),
      limits_(options),
      searched_(options_of_plan(*task.model, plan, "options")),
      wanted_(plan.options_from_command_line ? searched_ : task.options),
      model_(*task.model),
      work_(model_) {
  for (const world::Pair& pair : model_.pairs()) pairs_[std::minmax(pair.geometry_a, pair.geometry_b)] = &pair;
}

void FileCheck::run() {
  if (plan_.sha256 != content_sha256(plan_)) edited_.see(1, [] { return std::string("sha256 is not that of what the file says"); });
  if (plan_.status != core::Status::Solved) status_.see(1, [&] { return std::string(core::to_string(plan_.status)); });
  check_start();
  check_goal();
  check_settings();
  check_dynamics();
  const Eigen::VectorXd *q = &plan_.q_start, *u = &plan_.u_start;
  for (std::size_t s = 0; s < plan_.segments.size(); ++s) {
    for (std::size_t k = 0; k < plan_.segments[s].knots.size(); ++k) {
      const StoredKnot& knot = plan_.segments[s].knots[k];
      place_ = {static_cast<int>(s), static_cast<int>(k)};
      check_command(*u, knot.u);
      check_state(knot.q);
      check_cones(knot);
      check_display(knot);
      q = &knot.q;
      u = &knot.u;
    }
  }
  const PoseError end = goal_error(model_, plan_, *q);
  error_.see(std::max(std::abs(end.position - plan_.error.position), std::abs(end.angle - plan_.error.angle)),
             [] { return std::string("stored error against the last knot"); });
}

void FileCheck::report(CheckReport& out) const {
  add(out, "edited", edited_, 0.0, "");
  add(out, "status", status_, 0.0, "");
  add(out, "start", start_, 1e-9, "rad or m");
  add(out, "goal", goal_, 1e-9, "rad or m");
  add(out, "settings", settings_, 0.0, "");
  add(out, "dynamics", dynamics_, 0.0, "");
  add(out, "error", error_, 1e-9, "m or rad");
  add(out, "quaternion_norm", quaternion_norm_, limits_.quaternion_norm, "");
  add(out, "joint_limits", joint_limits_, limits_.joint_limit, "rad or m");
  add(out, "command_limits", command_limits_, limits_.joint_limit, "rad or m");
  add(out, "command_step", command_step_, plan_.substep ? std::optional(1 + 1e-6) : std::nullopt,
      plan_.substep ? "of the limit" : "rad or m");
  add(out, "stored_cone", stored_cone_, 2e-5, "of the force");  // six decimals of force and normal
  add(out, "display_poses", display_, limits_.display, "");
}

std::string FileCheck::here(std::string_view what) const {
  return place_.segment < 0 ? fmt::format("{} at the start", what)
                            : fmt::format("{} at segment {}, knot {}", what, place_.segment, place_.knot);
}

bool FileCheck::revolute(int joint) const {
  return model_.dofs()[static_cast<std::size_t>(model_.n_vu() + joint)].kind == world::DofKind::Revolute;
}

void FileCheck::see_outside(Worst& figure, double lower, double upper, int joint, double x) {
  figure.see(std::max(lower - x, x - upper), [&] { return here(plan_.joints[static_cast<std::size_t>(joint)]); });
}

void FileCheck::check_start() {
  const auto& q = plan_.start_from_command_line ? plan_.q_start : task_.problem.q_start;
  start_.see((plan_.q_start - q).cwiseAbs().maxCoeff(), [] { return std::string("start of the plan against the task"); });
  start_.see((plan_.u_start - q.tail(model_.n_a())).cwiseAbs().maxCoeff(),
             [] { return std::string("command at the start against its joints"); });
  check_state(plan_.q_start);
}

void FileCheck::check_goal() {
  const planning::Goal& goal = task_.problem.goal;
  const auto differs = [this](const char* what) { goal_.see(1, [&] { return std::string(what); }); };
  if (model_.object_index(plan_.goal_object) != goal.object) differs("another object than that of the task");
  goal_.see(std::max(std::abs(plan_.tol_position - goal.tol_position), std::abs(plan_.tol_angle - goal.tol_angle)),
            [] { return std::string("tolerances against the task"); });
  const auto &of_plan = plan_.bystanders, &of_task = goal.bystanders;
  if (of_plan.has_value() != of_task.has_value() ||
      (of_plan && (of_plan->objects != of_task->objects || of_plan->may_move != of_task->may_move || of_plan->may_tip != of_task->may_tip)))
    differs("bystanders against the task");
  if (plan_.goal_from_command_line) return;
  const world::Pose X_WG = to_pose(plan_.goal_pose);
  if (!plan_.region)
    goal_.see((X_WG.p - goal.X_WG.p).norm() + angle_between(X_WG.R, goal.X_WG.R), [] { return std::string("goal pose against the task"); });
  const bool same = plan_.region.has_value() == goal.region.has_value() &&
                    (!goal.region || (plan_.region->lower == goal.region->lower && plan_.region->upper == goal.region->upper));
  if (!same) differs("goal region against the task");
}

/// `optimize` plans with its own time step and regularisation, and in single steps.
void FileCheck::check_settings() {
  const std::string searched = planner_options_json(searched_, model_);
  if (searched == spell_as_searched(wanted_, searched_, model_)) return;
  if (task_.optimize && !plan_.substep) {
    planning::PlannerOptions optimised = task_.options;
    if (!optimised.thesis) optimised.thesis.emplace();
    optimised.thesis->h = task_.optimize->options.step.h;
    optimised.thesis->regularisation = task_.optimize->options.step.regularisation;
    if (searched == spell_as_searched(optimised, searched_, model_)) return;
  }
  settings_.see(1, [] { return std::string("options of the plan against the task"); });
}

void FileCheck::check_dynamics() {
  const auto differs = [this](const char* what) { dynamics_.see(1, [&] { return std::string(what); }); };
  const dynamics::StepOptions& step = plan_.step;
  const dynamics::StepOptions of_task = wanted_.step_options(model_);
  if (step.h > of_task.h) differs("step.h above that of the task");
  if (step.friction_law != of_task.friction_law) differs("step.friction_law is not that of the task");
  if (step.friction_scale > 1) differs("step.friction_scale above 1");
  if (step.contact_margin != 0) differs("step.contact_margin is not 0");
  if (!step.joint_limits) differs("step.joint_limits is off");
  if (!step.effort_limits) differs("step.effort_limits is off");
  if (step.tol_complementarity > 1e-8) differs("step.tol_complementarity above 1e-8");
  if (step.regularisation.index() != of_task.regularisation.index() || value_of(step.regularisation) != value_of(of_task.regularisation))
    differs("step.regularisation is not that of the task");
  if (plan_.substep.has_value() == wanted_.thesis.has_value()) return differs("substep is not that of the task");
  if (!plan_.substep) return;
  const double length = model_.scales().object(task_.problem.goal.object).length;
  const dynamics::SubstepLimits wanted{.joint_travel = world::share::kTravel * length, .slide = world::share::kSlide * length},
      &mine = *plan_.substep;
  if (mine.joint_angle > wanted.joint_angle || mine.joint_travel > wanted.joint_travel || mine.slide > wanted.slide)
    differs("substep allows more than the task");
}

void FileCheck::check_state(const Eigen::VectorXd& q) {
  for (std::size_t i = 0; i < plan_.objects.size(); ++i) {
    if (plan_.objects[i].joint != world::ObjectJoint::Free) continue;
    const int at = model_.objects()[i].q_begin + 3;
    quaternion_norm_.see(std::abs(q.segment(at, 4).norm() - 1), [&] { return here(plan_.objects[i].name); });
  }
  const auto q_a = q.tail(model_.n_a());
  for (int j = 0; j < model_.n_a(); ++j) see_outside(joint_limits_, model_.lower()[j], model_.upper()[j], j, q_a[j]);
}

void FileCheck::check_command(const Eigen::VectorXd& before, const Eigen::VectorXd& u) {
  for (int j = 0; j < model_.n_a(); ++j) {
    see_outside(command_limits_, model_.command_lower()[j], model_.command_upper()[j], j, u[j]);
    const double unit = !plan_.substep ? 1 : revolute(j) ? plan_.substep->joint_angle : plan_.substep->joint_travel;
    command_step_.see(std::abs(u[j] - before[j]) / unit, [&] { return here(plan_.joints[static_cast<std::size_t>(j)]); });
  }
}

/// Checks ‖f_t‖ ≤ μ f_n and |τ_n| ≤ μ_t f_n with the friction of the scene, and that the file states the same friction. Geometries that form
/// no pair have no force.
void FileCheck::check_cones(const StoredKnot& knot) {
  for (const auto& c : knot.contacts) {
    const auto name = [&] { return here(plan_.geometries[static_cast<std::size_t>(c.a)].name); };
    const auto pair = pairs_.find({std::min(c.a, c.b), std::max(c.a, c.b)});
    const double mu = pair != pairs_.end() ? pair->second->friction : 0, torsional = pair != pairs_.end() ? pair->second->torsional : 0;
    const double f_n = c.force_W.dot(c.normal_W);
    const double f_t = (c.force_W - f_n * c.normal_W).norm();
    const double smallest = model_.scales().robots().force, rounding = 1e-6 * (1 + mu);  // six decimals of a force [N]
    stored_cone_.see(std::abs(c.normal_W.norm() - 1), name);
    const double scale = plan_.step.friction_scale, largest = std::max(c.force_W.norm(), smallest);
    stored_cone_.see((f_t - scale * mu * f_n - rounding) / largest, name);
    const double length = std::max(torsional, world::share::kContact * model_.scales().robots().length);
    stored_cone_.see((std::abs(c.moment) - scale * torsional * f_n - rounding) / (length * largest), name);
    stored_cone_.see(pair != pairs_.end() ? std::abs(c.friction - mu) : 1, name);
  }
}

void FileCheck::check_display(const StoredKnot& knot) {
  world::calc_kinematics(model_, normalised(model_, knot.q), work_, kinematics_);
  std::vector<char> has_geometry(model_.bodies().size(), 0);
  for (const auto& geometry : model_.geometries()) has_geometry[static_cast<std::size_t>(geometry.body)] = 1;
  std::size_t shown = 0;
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

}  // namespace stiction::tasks
