#include "stiction/execution/open_loop/tube.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/core/random.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/execution/closed_loop/part_start.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using planning::GoalError;
using planning::SegmentKind;
using world::Model;
using world::Pose;

constexpr double kRounding = 1e-12;     // rounding error of poses [m, rad]
constexpr double kMostFriction = 0.99;  // largest relative error of friction, so that the factor stays above 0

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Rotation vector of R, of length ≤ π.
Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() *= -1;
  const double sine = q.vec().norm();
  return sine > 0 ? Vector3d(2 * std::atan2(sine, q.w()) / sine * q.vec()) : Vector3d::Zero();
}

GoalError distance(const Pose& a, const Pose& b) { return {(a.p - b.p).norm(), rotation_vector(a.R.transpose() * b.R).norm()}; }

/// Draws a point that is uniform in the ball of radius 1.
VectorXd draw_in_ball(core::Random& random, int n) {
  VectorXd x(n);
  for (double& entry : x) entry = random.normal();
  return std::pow(random.uniform(), 1.0 / n) * x.normalized();
}

/// Draws the error of a free object in its tangent.
VectorXd draw_free(const Vector3d& gravity, const Eigen::Matrix3d& R_WB, const ErrorSets& sets, core::Random& random) {
  Vector3d p, turn_W;
  if (gravity.isZero(0)) {
    p = draw_in_ball(random, 3);
    turn_W = draw_in_ball(random, 3);
  } else {
    const Vector3d up = -gravity.normalized(), aside = up.unitOrthogonal();
    const VectorXd flat = draw_in_ball(random, 2);
    p = flat[0] * aside + flat[1] * up.cross(aside);
    turn_W = draw_in_ball(random, 1)[0] * up;
  }
  VectorXd e(6);
  e << sets.position * p, sets.angle * (R_WB.transpose() * turn_W);
  return e;
}

/// Draws the error of the coordinates of an object on a joint.
VectorXd draw_joint(const Model& model, const world::ObjectInfo& object, const ErrorSets& sets, core::Random& random) {
  const auto turns = [&](int k) { return model.dofs()[at(object.v_begin + k)].kind == world::DofKind::Revolute; };
  int slides = 0;
  for (int k = 0; k < object.n_v; ++k) slides += turns(k) ? 0 : 1;
  const VectorXd moved = draw_in_ball(random, slides), turned = draw_in_ball(random, object.n_v - slides);
  VectorXd e(object.n_v);
  for (int k = 0, s = 0, t = 0; k < object.n_v; ++k) e[k] = turns(k) ? sets.angle * turned[t++] : sets.position * moved[s++];
  return e;
}

VectorXd displaced(const Model& model, dynamics::VectorRef q, const VectorXd& start) {
  VectorXd delta = VectorXd::Zero(model.n_v()), out(model.n_q());
  delta.head(model.n_vu()) = start;
  world::retract(model, q, delta, out);
  return out;
}

/// Factor by which object poses are farther off than their sets allow, ≥ 1: a hinge moves an object far from its axis a long way.
double calc_excess(const Model& model, dynamics::VectorRef q, const VectorXd& start, const ErrorSets& sets) {
  const VectorXd moved = displaced(model, q, start);
  double excess = 1;
  for (int i = 0; i < static_cast<int>(model.objects().size()); ++i) {
    const GoalError off = distance(world::object_pose(model, q, i), world::object_pose(model, moved, i));
    if (off.position > sets.position + kRounding) excess = std::max(excess, off.position / sets.position);
    if (off.angle > sets.angle + kRounding) excess = std::max(excess, off.angle / sets.angle);
  }
  return excess;
}

/// Commands of a run at the speed at which plans are shown to hold. The time matters only for damped objects; without them, the commands of the plan, which are
/// fewer, suffice.
Trajectory commands_of(const Model& model, const planning::Plan& plan) {
  if (!calc_object_damping(model).isZero(0)) return make_trajectory(model, plan);
  SpeedLimits any;
  any.regrasp_factor = any.landing_factor = 1;  // adds no knots to those of the plan
  return make_trajectory(model, plan, any);
}

/// Commands between two rests.
struct Stage {
  SegmentKind kind = SegmentKind::Contact;
  int last_segment = 0;
  Eigen::MatrixXd u;   ///< (n_a × steps)
  VectorXd durations;  ///< durations of the steps [s]
  Pose X_plan;         ///< planned pose of the object at its end
};

std::vector<Stage> make_stages(const Model& model, int object, const Trajectory& trajectory) {
  std::vector<Stage> out;
  for (const Piece& piece : trajectory.pieces) {
    Stage& stage = out.emplace_back();
    const Eigen::Index first = piece.first_knot, n = piece.last_knot - first;
    stage.kind = piece.kind;
    stage.last_segment = piece.last_segment;
    stage.u = trajectory.u.middleCols(first + 1, n);
    stage.durations = trajectory.times.segment(first + 1, n) - trajectory.times.segment(first, n);
    stage.X_plan = world::object_pose(model, trajectory.q.col(piece.last_knot), object);
  }
  return out;
}

/// Result of the rollout of one world.
struct Path {
  std::vector<Pose> poses;  ///< poses of the object at the ends of the stages
  GoalError error;          ///< error at the end of the last stage
};

/// Rolls out one world along all stages.
class Scenario {
 public:
  Scenario(const std::shared_ptr<const Model>& model, const planning::Plan& plan, dynamics::StepWorkspace& work)
      : model_(model),
        plan_(plan),
        options_(plan.step),
        work_(work),
        kinematics_work_(*model),
        drag_(calc_object_damping(*model)),
        damped_(!drag_.isZero(0)) {
    options_.smoothing = dynamics::Exact{};
    options_.with_A = options_.with_B = options_.with_force_derivatives = false;
  }

  /// @returns empty if a step was not solved, or the run was stopped
  std::optional<Path> run(const VectorXd& q_start, const WorldError& error, const std::vector<Stage>& stages,
                          const core::RunControl& control) {
    work_.forget();
    mass_ = error.mass;
    options_.friction_scale = plan_.step.friction_scale * error.friction;
    VectorXd q = error.start.isZero(0) ? q_start : part_start(model_, displaced(*model_, q_start, error.start), plan_.step).q;
    Path out;
    for (const Stage& stage : stages) {
      for (Eigen::Index k = 0; k < stage.u.cols(); ++k) {
        if (control.stop() || !step(q, stage.u.col(k), stage.durations[k])) return std::nullopt;
      }
      out.poses.push_back(world::object_pose(*model_, q, plan_.goal.object));
    }
    out.error = planning::goal_error(*model_, q, plan_.goal);
    return out;
  }
  long steps() const { return steps_; }

 private:
  bool step(VectorXd& q, const VectorXd& u, double duration) {
    ++steps_;
    if (mass_ != 1) set_weight(q);
    if (damped_) damping_ = mass_ * options_.h / duration * drag_;
    const dynamics::StepInput in{q, u, mass_ != 1 ? &weight_ : nullptr, damped_ ? &damping_ : nullptr};
    if (dynamics::step(*model_, in, options_, work_, result_) != Status::Solved) return false;
    q = result_.q_next;
    return true;
  }

  /// Sets the additional weight of a heavier object; inertia has no part in a quasi-static step.
  void set_weight(const VectorXd& q) {
    world::calc_kinematics(*model_, q, kinematics_work_, kinematics_);
    weight_.setZero(model_->n_v());
    world::calc_gravity(*model_, kinematics_, weight_.head(model_->n_vu()));
    weight_ *= mass_ - 1;
  }

  const std::shared_ptr<const Model>& model_;
  const planning::Plan& plan_;
  dynamics::StepOptions options_;
  dynamics::StepWorkspace& work_;
  dynamics::StepResult result_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_{};
  VectorXd drag_, damping_;  ///< damping (E.7) in time, and in the steps of the model
  bool damped_;
  VectorXd weight_;
  double mass_ = 1;
  long steps_ = 0;
};

/// Mean of poses that are close to the pose `near`, (B.2).
Pose mean_pose(const std::vector<Pose>& poses, const Pose& near) {
  Vector3d p = Vector3d::Zero(), turn = Vector3d::Zero();
  for (const Pose& pose : poses) {
    p += pose.p;
    turn += rotation_vector(near.R.transpose() * pose.R);
  }
  const double n = static_cast<double>(poses.size());
  const double angle = turn.norm() / n;
  return {angle > 0 ? Eigen::Matrix3d(near.R * Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix()) : near.R, p / n};
}

/// Centre and radii of a bundle, (B.2), (B.3).
void bound(const Stage& stage, const TubeOptions& options, double length, bool complete, TubeRest& rest) {
  rest.centre = rest.scenarios.empty() ? stage.X_plan : mean_pose(rest.scenarios, stage.X_plan);
  rest.offset = distance(stage.X_plan, rest.centre);
  GoalError farthest{0, 0};
  for (const Pose& pose : rest.scenarios) {
    const GoalError off = distance(rest.centre, pose);
    farthest = {std::max(farthest.position, off.position), std::max(farthest.angle, off.angle)};
  }
  const double lost = complete ? 0 : std::numeric_limits<double>::infinity();
  rest.position = options.factors.position * (farthest.position + options.errors.contact * length) + lost;
  rest.angle = options.factors.angle * (farthest.angle + 2 * options.errors.contact) + lost;
}

/// Distance of the last centre from the goal. If the goal is a region, an upper bound: the distance to a scenario plus that of the scenario from the goal.
GoalError bound_centre(const planning::Goal& goal, const std::vector<std::optional<Path>>& paths, const TubeRest& last) {
  if (!goal.region) return distance(goal.X_WG, last.centre);
  GoalError out{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const auto& path : paths) {
    if (!path) continue;
    const GoalError to_centre = distance(path->poses.back(), last.centre);
    out.position = std::min(out.position, path->error.position + to_centre.position);
    out.angle = std::min(out.angle, path->error.angle + to_centre.angle);
  }
  return out;
}

void require_share(std::string_view field, double value) {
  if (!(value >= 0 && value < 1)) core::throw_invalid(field, fmt::format("{:g}", value), "a number in [0, 1)");
}

}  // namespace

void ErrorSets::validate() const {
  core::require_nonnegative("errors.position", position);
  core::require_nonnegative("errors.angle", angle);
  require_share("errors.friction", friction);
  require_share("errors.mass", mass);
  core::require_nonnegative("errors.contact", contact);
}

void TubeOptions::validate() const {
  errors.validate();
  core::require_positive("factors.position", factors.position);
  core::require_positive("factors.angle", factors.angle);
  if (scenarios < 1) core::throw_invalid("scenarios", std::to_string(scenarios), "a number ≥ 1");
  if (threads < 0) core::throw_invalid("threads", std::to_string(threads), "0 (all cores) or more");
}

WorldError draw_world(const Model& model, dynamics::VectorRef q, const ErrorSets& sets, std::uint64_t seed, std::uint64_t index) {
  sets.validate();
  world::require_configuration(model, "q", q);
  core::Random random(seed, index);
  WorldError out;
  out.friction = random.uniform(1 - sets.friction, 1 + sets.friction);
  out.mass = random.uniform(1 - sets.mass, 1 + sets.mass);
  out.start.setZero(model.n_vu());
  for (int i = 0; i < static_cast<int>(model.objects().size()); ++i) {
    const world::ObjectInfo& object = model.objects()[at(i)];
    auto e = out.start.segment(object.v_begin, object.n_v);
    if (object.n_v == 6) {
      e = draw_free(model.scene().gravity, world::object_pose(model, q, i).R, sets, random);
    } else {
      e = draw_joint(model, object, sets, random);
    }
  }
  for (double excess = 2; excess > 1; out.start /= excess) excess = calc_excess(model, q, out.start, sets);  // arcs are not quite straight
  return out;
}

Status calc_tube(const std::shared_ptr<const Model>& model, const planning::Plan& plan, const TubeOptions& options,
                 const core::RunControl& control, TubeResult& out) {
  const auto begin = core::RunControl::Clock::now();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  options.validate();
  if (plan.goal.object < 0 || plan.goal.object >= static_cast<int>(model->objects().size()))
    core::throw_invalid("plan.goal.object", std::to_string(plan.goal.object), "the index of an object");
  const Trajectory trajectory = commands_of(*model, plan);
  const std::vector<Stage> stages = make_stages(*model, plan.goal.object, trajectory);
  const VectorXd q_start = trajectory.q.col(0);
  out = TubeResult{};
  const int n = options.scenarios + 1;
  ErrorSets sets = options.errors;
  sets.friction = std::min(kFrictionReserve * sets.friction, kMostFriction);
  core::ThreadPool pool(options.threads > 0 ? options.threads : core::hardware_threads());
  std::vector<dynamics::StepWorkspace> works;
  for (int i = 0; i < pool.size(); ++i) works.emplace_back(model);
  std::vector<long> steps(at(n), 0);
  std::vector<std::optional<Path>> paths(at(n));
  pool.run(n, [&](int i, int worker) {
    Scenario scenario(model, plan, works[at(worker)]);
    const WorldError known{.start = VectorXd::Zero(model->n_vu())};
    const WorldError error = i == 0 ? known : draw_world(*model, q_start, sets, options.seed, static_cast<std::uint64_t>(i));
    paths[at(i)] = scenario.run(q_start, error, stages, control);
    steps[at(i)] = scenario.steps();
  });
  for (const long k : steps) out.steps += k;
  out.wall_s = core::seconds_since(begin);
  if (control.stop()) return out.status = control.status_when_stopped();
  out.lost = static_cast<int>(std::ranges::count_if(paths, [](const auto& path) { return !path; }));
  const double length = model->scales().object(plan.goal.object).length;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    TubeRest& rest = out.rests.emplace_back();
    rest.kind = stages[k].kind;
    rest.last_segment = stages[k].last_segment;
    for (const auto& path : paths) {
      if (path) rest.scenarios.push_back(path->poses[k]);
    }
    bound(stages[k], options, length, out.lost == 0, rest);
  }
  const GoalError centre = bound_centre(plan.goal, paths, out.rests.back());
  out.goal = {centre.position + out.rests.back().position, centre.angle + out.rests.back().angle};
  out.calibrated = model->planar_axis().has_value();
  out.inside = out.calibrated && out.goal.within(plan.goal);
  return out.status = Status::Solved;
}

}  // namespace stiction::execution
