#include "stiction/planning/rehearsal.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/planning/drag.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/planning/trajectory.hpp"

namespace stiction::planning {
namespace {

using core::Status;

constexpr double kStep = 0.1;     // at most [s]; half of it tells plans that hold from others as well
constexpr double kAtRest = 1e-5;  // what moves less in a step will not move in the rest of a pause [m or rad]
/// An object farther than this from its plan, in tolerances of the goal, does not come back.
constexpr double kLost = 5;

/// D = 2 √(K I): joint springs are critically damped with the inertia that their joint moves.
Eigen::VectorXd calc_joint_damping(const world::Model& model, const world::Kinematics& kinematics) {
  return 2 * model.stiffness().cwiseProduct(world::calc_joint_inertia(model, kinematics)).cwiseSqrt();
}

}  // namespace

Rehearsal::Rehearsal(const std::shared_ptr<const world::Model>& model, double rest_time)
    : model_(model),
      space_(*model),
      steps_(model),
      kinematics_work_(*model),
      damping_(Drag(*model, model->neutral(), rest_time).damping()) {
  world::calc_kinematics(*model, model->neutral(), kinematics_work_, kinematics_);
  damping_.tail(model->n_a()) = calc_joint_damping(*model, kinematics_);
}

core::Status Rehearsal::step(const Eigen::VectorXd& u, double h) {
  Eigen::VectorXd carried(model_->n_v());  // M q̇/h keeps the objects going; dampers move along with the commands: D u̇
  world::calc_kinematics(*model_, q_, kinematics_work_, kinematics_);
  for (std::size_t i = 0; i < model_->objects().size(); ++i) {
    const auto& object = model_->objects()[i];
    Eigen::MatrixXd M(object.n_v, object.n_v);
    world::calc_object_mass(*model_, kinematics_, static_cast<int>(i), M);
    carried.segment(object.v_begin, object.n_v) = M * velocity_.segment(object.v_begin, object.n_v) / h;
  }
  carried.tail(model_->n_a()) = damping_.tail(model_->n_a()).cwiseProduct(u - u_) / h;
  options_.h = h;
  const Status status = dynamics::step(*model_, {q_, u, &carried, &damping_}, options_, steps_, result_);
  q_ = result_.q_next;
  velocity_ = result_.delta / h;
  u_ = u;
  return status;
}

double Rehearsal::calc_offset(const Eigen::VectorXd& q_plan, const Goal& goal) const {
  Eigen::VectorXd error(model_->n_vu());
  space_.error(q_plan.data(), q_.data(), error.data());
  return largest_share(*model_, error, goal.tol_position, goal.tol_angle);
}

RehearsalResult Rehearsal::run(const Plan& plan, double share, const Eigen::VectorXd* q) {
  const Trajectory trajectory = make_trajectory(*model_, plan, limits_);
  options_ = plan.step;
  options_.regularisation = dynamics::FixedEpsilon{1.0};
  options_.smoothing = dynamics::Exact{};
  options_.with_A = options_.with_B = false;
  steps_.forget();
  q_ = q != nullptr ? *q : trajectory.q.col(0);
  velocity_.setZero(model_->n_v());
  u_ = trajectory.u.col(0);
  RehearsalResult out;
  int astray = -1;  // the segment since which the objects have been off
  Eigen::VectorXd u(model_->n_a()), planned(model_->n_q());
  /// False where it is over.
  const auto go_on = [&](double t, double h) {
    interpolate_command(trajectory, t, u);
    ++out.steps;
    const bool solved = step(u, h) == Status::Solved;
    out.failed_steps += !solved;
    interpolate(*model_, trajectory, t, planned);
    const double off = calc_offset(planned, plan.goal);
    if (solved && off <= share) {
      astray = -1;
    } else if (astray < 0) {
      astray = segment_at(trajectory, t);
    }
    return solved && off <= kLost;
  };
  bool goes_on = true;
  for (auto piece = trajectory.pieces.begin(); goes_on && piece != trajectory.pieces.end(); ++piece) {
    const double begin = trajectory.times[piece->first_knot], end = trajectory.times[piece->last_knot];
    const int n = static_cast<int>(std::ceil((end - begin) / kStep));
    for (int k = 1; goes_on && k <= n; ++k) goes_on = go_on(begin + (end - begin) * k / n, (end - begin) / n);
    bool moves = true;
    for (double t = end; goes_on && moves && t < end + limits_.pause; t += kStep) {
      goes_on = go_on(end, kStep);
      moves = result_.delta.cwiseAbs().maxCoeff() > kAtRest;
    }
    goes_on = goes_on && astray < 0;
  }
  out.holds = goes_on;
  out.lost = astray;
  out.q = q_;
  return out;
}

}  // namespace stiction::planning
