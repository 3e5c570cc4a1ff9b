#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using world::ObjectJoint;

constexpr double kTurn = 2 * std::numbers::pi;

/// The number in [lower, upper] that is nearest to x; for an angle, modulo 2π.
double nearest(double x, double lower, double upper, bool angle) {
  if (!angle) return std::clamp(x, lower, upper);
  if (!std::isfinite(lower) || !std::isfinite(upper)) return x;               // x plus some turns lies in any half-line
  const double beyond = x - lower - kTurn * std::floor((x - lower) / kTurn);  // how far above the lower end, in [0, 2π)
  const double width = upper - lower;
  if (beyond <= width) return x;
  return beyond - width <= kTurn - beyond ? upper : lower;
}

Eigen::Quaterniond rotation_of(const Eigen::Vector3d& rpy) {
  return Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX());
}

Eigen::Quaterniond project_rotation(const Eigen::Quaterniond& q, const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
  const Eigen::Vector3d first = roll_pitch_yaw(q.toRotationMatrix());
  const Eigen::Vector3d second(first[0] + std::numbers::pi, std::numbers::pi - first[1], first[2] + std::numbers::pi);
  Eigen::Quaterniond best = q;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& rpy : {first, second}) {
    Eigen::Vector3d inside;
    for (int i = 0; i < 3; ++i) inside[i] = nearest(rpy[i], lower[i], upper[i], true);
    if (inside == rpy) return q;
    const Eigen::Quaterniond candidate = rotation_of(inside);
    const double turn = candidate.angularDistance(q);
    if (turn < least) least = turn, best = candidate;
  }
  return best;
}

/// True if the object looks the same however it is turned about its centre of mass.
bool is_ball(const world::ObjectSpec& object) {
  return object.joint == ObjectJoint::Free && !object.geometries.empty() &&
         std::ranges::all_of(object.geometries, [&](const auto& geometry) {
           const auto* ball = std::get_if<world::Sphere>(&geometry.shape);
           return ball != nullptr && (geometry.X_BG.p - object.p_BCom).norm() <= 1e-6 * ball->radius;
         });
}

}  // namespace

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))), std::atan2(R(1, 0), R(0, 0))};
}

void project(const world::Model& model, const GoalRegion& region, Eigen::Ref<Eigen::VectorXd> q_u) {
  const auto objects = model.objects();
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const auto& object = objects[o];
    const bool free = model.scene().objects[o].joint == ObjectJoint::Free;
    const auto lower = region.lower.segment(object.v_begin, object.n_v), upper = region.upper.segment(object.v_begin, object.n_v);
    for (int i = 0; i < (free ? 3 : object.n_v); ++i) {
      const bool revolute = model.dofs()[static_cast<std::size_t>(object.v_begin + i)].kind == world::DofKind::Revolute;
      const bool wraps = revolute && object.n_v > 1;  // hinges count their turns
      q_u[object.q_begin + i] = nearest(q_u[object.q_begin + i], lower[i], upper[i], wraps);
    }
    if (!free) continue;
    auto rotation = q_u.segment<4>(object.q_begin + 3);
    const Eigen::Quaterniond q(rotation[3], rotation[0], rotation[1], rotation[2]);
    rotation = project_rotation(q, lower.tail<3>(), upper.tail<3>()).coeffs();
  }
}

std::vector<int> chain_of(const world::Model& model, int object) {
  std::vector<int> chain;
  for (int o = object; o >= 0; o = model.objects()[static_cast<std::size_t>(o)].parent) chain.insert(chain.begin(), o);
  return chain;
}

std::vector<int> goal_objects(const world::Model& model, const Goal& goal) {
  std::vector<int> out{goal.object};
  if (!goal.region) return out;
  const auto carries = [&](int o, int other) {
    const auto chain = chain_of(model, other);
    return std::find(chain.begin(), chain.end(), o) != chain.end();
  };
  for (int o = static_cast<int>(model.objects().size()) - 1; o >= 0; --o) {  // backwards: objects before their carriers
    const auto& object = model.objects()[static_cast<std::size_t>(o)];
    const auto lower = goal.region->lower.segment(object.v_begin, object.n_v),
               upper = goal.region->upper.segment(object.v_begin, object.n_v);
    const bool bounded = lower.array().isFinite().any() || upper.array().isFinite().any();
    if (bounded && std::none_of(out.begin(), out.end(), [&](int other) { return carries(o, other); })) out.push_back(o);
  }
  std::sort(out.begin(), out.end());
  return out;
}

BystanderMotion calc_motion(const world::Model& model, const Bystanders& bystanders, int object, dynamics::VectorRef q) {
  const Eigen::Vector3d& gravity = model.scene().gravity;
  const Eigen::Vector3d up = gravity.norm() > 0 ? Eigen::Vector3d(-gravity.normalized()) : Eigen::Vector3d::Zero();
  Eigen::VectorXd q_stood = q;
  q_stood.head(model.n_qu()) = bystanders.q_u;
  const world::Pose stood = world::object_pose(model, q_stood, object), now = world::object_pose(model, q, object);
  const Eigen::Vector3d tipped = now.R * (stood.R.transpose() * up);
  return {(now.p - stood.p).norm(), std::atan2(tipped.cross(up).norm(), tipped.dot(up))};
}

double bystander_share(const world::Model& model, const Goal& goal, dynamics::VectorRef q) {
  double share = 0;
  if (!goal.bystanders) return share;
  for (const int o : goal.bystanders->objects) {
    const BystanderMotion motion = calc_motion(model, *goal.bystanders, o, q);
    share = std::max({share, motion.move / goal.bystanders->may_move, motion.tip / goal.bystanders->may_tip});
  }
  return share;
}

GoalError goal_error(const world::Model& model, dynamics::VectorRef q, const Goal& goal) {
  Eigen::VectorXd nearest = q;
  if (goal.region) project(model, *goal.region, nearest.head(model.n_qu()));
  GoalError error;
  for (const int o : goal_objects(model, goal)) {
    const world::Pose X_WB = world::object_pose(model, q, o);
    const world::Pose X_WG = goal.region ? world::object_pose(model, nearest, o) : goal.X_WG;
    double angle = Eigen::Quaterniond(X_WB.R).angularDistance(Eigen::Quaterniond(X_WG.R));
    if (model.scene().objects[static_cast<std::size_t>(o)].joint == ObjectJoint::Hinge) {
      const int at = model.objects()[static_cast<std::size_t>(o)].q_begin;
      const double turn = std::abs(q[at] - nearest[at]);  // a pose does not show whole turns
      if (turn > std::numbers::pi) angle = turn;
    }
    error.position = std::max(error.position, (X_WB.p - X_WG.p).norm());
    error.angle = std::max(error.angle, angle);
  }
  return error;
}

PathTolerances path_tolerances(const world::Model& model, const Goal& goal) {
  constexpr double kMostTurn = 0.3;  // [rad]; an object that turns farther is grasped differently than planned
  PathTolerances out{goal.tol_position, goal.tol_angle};
  if (!goal.region) return out;
  double turn = std::numeric_limits<double>::infinity();
  for (const int o : goal_objects(model, goal)) {
    const auto& object = model.objects()[static_cast<std::size_t>(o)];
    for (int i = object.v_begin; i < object.v_begin + object.n_v; ++i) {
      if (model.dofs()[static_cast<std::size_t>(i)].kind != world::DofKind::Revolute) continue;
      if (std::isfinite(goal.region->lower[i]) || std::isfinite(goal.region->upper[i])) return out;
      const bool ball = is_ball(model.scene().objects[static_cast<std::size_t>(o)]);
      turn = std::min(turn, ball ? std::numbers::pi : std::min(kMostTurn, goal.tol_position / model.scales().object(o).length));
    }
  }
  if (std::isfinite(turn)) out.angle = std::max(out.angle, turn);
  return out;
}

Eigen::VectorXd inverse_tolerances(const world::Model& model, const Goal& goal) {
  const PathTolerances tolerances = path_tolerances(model, goal);
  Eigen::VectorXd out(model.n_vu());
  for (int i = 0; i < model.n_vu(); ++i) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
    out[i] = 1 / (revolute ? tolerances.angle : tolerances.position);
  }
  return out;
}

void PathCost::validate() const {
  core::require_positive("planner.cost.joint_speed", joint_speed);
  core::require_positive("planner.cost.travel_speed", travel_speed);
  core::require_nonnegative("planner.cost.regrasp", regrasp);
}

double path_cost(const world::Model& model, const Plan& plan, const PathCost& cost) {
  double sum = 0;
  const Eigen::VectorXd* u = &plan.u_start;
  for (const Segment& segment : plan.segments) {
    if (segment.kind == SegmentKind::Regrasp) sum += cost.regrasp;
    for (const auto& knot : segment.knots) {
      sum += command_time(model, *u, knot.u, cost);
      u = &knot.u;
    }
  }
  return sum;
}

double command_time(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to, const PathCost& cost) {
  double time = 0;
  for (int j = 0; j < model.n_a(); ++j) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == world::DofKind::Revolute;
    time = std::max(time, std::abs(to[j] - from[j]) / (revolute ? cost.joint_speed : cost.travel_speed));
  }
  return time;
}

}  // namespace stiction::planning
