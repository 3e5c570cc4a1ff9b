#include "stiction/tasks/lint_motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using world::BodyKind;
using world::Model;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kPostures = 48;       // number of sampled postures
constexpr int kLeastPostures = 12;  // with fewer postures in contact, nothing is reported
constexpr int kDirections = 16;     // around a friction cone, and of the support of an object

/// Force required to move the object.
struct Need {
  double force = 0;              ///< [N]
  Vector3d along{0, 0, 0};       ///< direction in which it counts; zero: any
  const VectorXd* at = nullptr;  ///< configuration where the postures are drawn
};

class MotorLinter {
 public:
  MotorLinter(const Task& task, const core::RunControl& control)
      : task_(task), model_(*task.model), chains_(model_), work_(model_), q_goal_(task.problem.q_start), o_(task.problem.goal.object) {
    q_goal_.head(model_.n_qu()) = task.problem.q_goal;
    up_ = -model_.scene().gravity.normalized();
    work_.control = &control;
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      const bool a = is_object(pair(i).geometry_a), b = is_object(pair(i).geometry_b);
      if (a == b) continue;
      (moves_by_motor(a ? pair(i).geometry_b : pair(i).geometry_a) ? hands_ : supports_).push_back(i);
    }
  }

  void run(std::vector<Finding>& out) {
    if (hands_.empty() || task_.problem.goal.region || object().n_v == 1 || !has_weight()) return;
    const double tolerance = task_.problem.goal.tol_position;
    if (find_support(q_goal_, tolerance).empty()) return judge({weight(), up_, &q_goal_}, out);
    const VectorXd& q = task_.problem.q_start;
    if ((position(q) - position(q_goal_)).norm() > tolerance) judge({weight() * calc_push_share(q), Vector3d::Zero(), &q}, out);
  }

 private:
  const world::ObjectInfo& object() const { return model_.objects()[static_cast<std::size_t>(o_)]; }
  const world::Pair& pair(int i) const { return model_.pairs()[static_cast<std::size_t>(i)]; }
  const world::Body& body_of(int g) const {
    return model_.bodies()[static_cast<std::size_t>(model_.geometries()[static_cast<std::size_t>(g)].body)];
  }
  bool is_object(int g) const { return body_of(g).kind == BodyKind::Object && body_of(g).owner == o_; }
  bool moves_by_motor(int g) const { return body_of(g).kind == BodyKind::Robot && !body_of(g).dofs.empty(); }
  Vector3d position(const VectorXd& q) const { return world::object_pose(model_, q, o_).p; }
  double weight() const { return object().carried_mass * model_.scene().gravity.norm(); }

  /// True if gravity moves the object.
  bool has_weight() {
    if (!(weight() > 0)) return false;
    VectorXd tau(model_.n_vu());
    world::calc_kinematics(model_, task_.problem.q_start, work_.kinematics_work, work_.kinematics);
    world::calc_gravity(model_, work_.kinematics, tau);
    return tau.segment(object().v_begin, object().n_v).cwiseAbs().maxCoeff() > world::share::kForce * weight();
  }

  /// Contacts of the object with bodies that no motor moves, within a contact tolerance or `near` [m].
  std::vector<contact::Contact> find_support(const VectorXd& q, double near) {
    world::calc_kinematics(model_, q, work_.kinematics_work, work_.kinematics);
    near = std::max(near, world::share::kContact * model_.scales().object(o_).length);
    contact::query_pairs(model_, work_.kinematics, supports_, near, work_.contact_work, work_.contacts);
    return work_.contacts;
  }

  /// min(μ, a/D).
  double calc_push_share(const VectorXd& q) {
    const auto support = find_support(q, 0);
    if (support.empty()) return 0;
    double mu = kInfinity, reach = 0, a = kInfinity;
    for (const auto& c : support) mu = std::min(mu, c.friction * task_.options.friction);
    const auto& X_WB = work_.kinematics.X_WB[static_cast<std::size_t>(object().body)];
    const Vector3d p_com = X_WB * model_.inertias()[static_cast<std::size_t>(object().body)].p_BCom;
    for (int g = 0; g < static_cast<int>(model_.geometries().size()); ++g) {
      const auto& geometry = model_.geometries()[static_cast<std::size_t>(g)];
      if (is_object(g)) reach = std::max(reach, (X_WB * geometry.p_BCenter - p_com).norm() + geometry.bounding_radius);
    }
    for (const Vector3d& d : horizontal()) {
      double extent = -kInfinity;
      for (const auto& c : support) extent = std::max(extent, d.dot(c.p_WA - p_com));
      a = std::min(a, extent);
    }
    return std::clamp(a / (2 * reach), 0.0, mu);
  }

  /// Directions across gravity in which things move.
  std::vector<Vector3d> horizontal() const {
    if (model_.planar_axis()) {
      const Vector3d d = Vector3d::Unit(*model_.planar_axis()).cross(up_);
      return {d, -d};
    }
    const Vector3d e = up_.unitOrthogonal(), f = up_.cross(e);
    std::vector<Vector3d> out;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2 * std::numbers::pi * k / kDirections;
      out.emplace_back(std::cos(angle) * e + std::sin(angle) * f);
    }
    return out;
  }

  /// Force that the motors of a hand give in any direction, since |J_jᵀu| ≤ reach_j.
  double surely_given() const {
    double best = 0;
    for (const int i : hands_) {
      const world::Body& hand = body_of(is_object(pair(i).geometry_a) ? pair(i).geometry_b : pair(i).geometry_a);
      double least = kInfinity;
      for (const int v : hand.dofs) least = std::min(least, model_.effort()[v - model_.n_vu()] / model_.reach()[v - model_.n_vu()]);
      best = std::max(best, least);
    }
    return best;
  }

  void judge(const Need& need, std::vector<Finding>& out) {
    if (!(need.force > surely_given())) return;
    double given = 0;
    int postures = 0;
    for (int k = 0; k < kPostures && given < need.force && !work_.stop(); ++k) {
      core::Random random(0, static_cast<std::uint64_t>(k));
      const auto draw = contact::draw_grasp(chains_, contact::GenericSampler{}, random);
      const auto sample = contact::sample_contact(model_, chains_, contact::GenericSampler{}, draw, *need.at, random, work_);
      if (!sample) continue;
      VectorXd q = *need.at;
      q.tail(model_.n_a()) = sample->q_a;
      const double here = calc_given(q, need.along);
      postures += here > 0;
      given = std::max(given, here);
    }
    if (postures < kLeastPostures || given >= need.force) return;
    const std::string takes =
        need.along.isZero() ? fmt::format("to push or tip '{}' ({:g} kg) takes {:.3g} N", object().name, object().carried_mass, need.force)
                            : fmt::format("to carry '{}' ({:g} kg) takes {:.3g} N", object().name, object().carried_mass, need.force);
    out.push_back({"motors", fmt::format("{}, and the motors give {:.3g} N at most in {} postures that touch it; kilograms, N and N·m?",
                                         takes, given, postures)});
  }

  /// Largest force of the branches on the object at q, with the best contact of each branch.
  double calc_given(const VectorXd& q, const Vector3d& along) {
    world::calc_kinematics(model_, q, work_.kinematics_work, work_.kinematics);
    const double near = world::share::kContact * model_.scales().object(o_).length;
    contact::query_pairs(model_, work_.kinematics, hands_, near, work_.contact_work, work_.contacts);
    std::map<world::ChainMask, double> best;  // of every branch, or of every set that moves a link together
    for (const auto& c : work_.contacts) {
      double& force = best[chains_.mask_of_pair(c.pair)];
      force = std::max(force, calc_most(c, along));
    }
    double sum = 0;
    for (const auto& [mask, force] : best) sum += force;
    return sum;
  }

  /// Largest force of one contact within the efforts: over directions λ of its cone, s λ with the largest s that |J_jᵀλ| s ≤ effort_j
  /// allows.
  double calc_most(const contact::Contact& c, const Vector3d& along) {
    const auto& support = model_.supports()[static_cast<std::size_t>(pair(c.pair).support)];
    const auto n = static_cast<Eigen::Index>(support.size());
    std::vector<double> values(static_cast<std::size_t>(3 * n));
    contact::calc_jacobian(model_, work_.kinematics, c, values.data());
    const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> J(values.data(), 3, n);
    const double side = is_object(pair(c.pair).geometry_a) ? 1 : -1, mu = c.friction * task_.options.friction;
    double most = 0;
    for (int k = 0; k <= 2 * kDirections; ++k) {  // the normal, and two rings
      const double angle = 2 * std::numbers::pi * k / kDirections, tangent = k == 0 ? 0.0 : k <= kDirections ? mu : 0.5 * mu;
      const Vector3d lambda(1, tangent * std::cos(angle), tangent * std::sin(angle));
      const Vector3d f = side * (c.nhat_BA_W * lambda[0] + c.t1_W * lambda[1] + c.t2_W * lambda[2]);
      const double useful = along.isZero() ? f.norm() : f.dot(along);
      if (!(useful > 0)) continue;
      double scale = kInfinity;
      for (Eigen::Index i = 0; i < n; ++i) {
        const int j = support[static_cast<std::size_t>(i)] - model_.n_vu();
        const double torque = j < 0 ? 0.0 : std::abs(J.col(i).dot(lambda));
        if (torque > 0) scale = std::min(scale, model_.effort()[j] / torque);
      }
      most = std::max(most, scale * useful);
    }
    return most;
  }

  const Task& task_;
  const Model& model_;
  world::RobotChains chains_;
  contact::GeometryWorkspace work_;
  VectorXd q_goal_;
  int o_ = 0;
  Vector3d up_;
  std::vector<int> hands_, supports_;  // pairs of the object with what motors move, and with the rest
};

}  // namespace

void lint_motors(const Task& task, const core::RunControl& control, std::vector<Finding>& out) { MotorLinter(task, control).run(out); }

}  // namespace stiction::tasks
