#include "stiction/execution/closed_loop/handling.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::execution {
namespace {

/// An object may be as fast as it was planned to be at any time within this time before now [s].
constexpr double kTrail = 0.1;

bool is_free(const world::Model& model, std::size_t object) { return model.scene().objects[object].joint == world::ObjectJoint::Free; }

/// Speed of the centre of mass of a free object [m/s].
double speed_of(const world::Model& model, const Eigen::VectorXd& q, const Eigen::VectorXd& v, std::size_t i) {
  const world::ObjectInfo& object = model.objects()[i];
  const Eigen::Vector3d turn = v.segment<3>(object.v_begin + 3), lever = model.scene().objects[i].p_BCom;
  return (v.segment<3>(object.v_begin) + world::object_pose(model, q, static_cast<int>(i)).R * turn.cross(lever)).norm();
}

}  // namespace

double Handling::slip_speed() const { return slip_speeds.empty() ? 0 : *std::max_element(slip_speeds.begin(), slip_speeds.end()); }

/// Largest planned speed of a free object in the last kTrail seconds [m/s].
double HandlingWatch::planned_speed(const RunSample& sample) {
  double speed = 0;
  if (!planned_.empty() && sample.time > planned_.back().time) {
    for (std::size_t i = 0; i < model_.objects().size(); ++i) {
      if (!is_free(model_, i)) continue;
      const auto at = [&](const Eigen::VectorXd& q) -> Eigen::Vector3d {
        const world::Pose X_WB = world::object_pose(model_, q, static_cast<int>(i));
        return X_WB.p + X_WB.R * model_.scene().objects[i].p_BCom;
      };
      speed = std::max(speed, (at(sample.q_plan) - at(planned_.back().q)).norm() / (sample.time - planned_.back().time));
    }
  }
  const bool moves = sample.state == RunState::Push || sample.state == RunState::Regrasp;
  planned_.push_back({sample.time, moves ? speed : 0, sample.q_plan});
  while (planned_.front().time < sample.time - kTrail) planned_.pop_front();
  speed = 0;
  for (const Planned& planned : planned_) speed = std::max(speed, planned.speed);
  return speed;
}

void HandlingWatch::take(const RunSample& sample) {
  const double planned = planned_speed(sample);
  if (sample.piece < 0) return;
  slip_speeds_.resize(static_cast<std::size_t>(sample.piece) + 1, 0);
  for (std::size_t i = 0; i < model_.objects().size(); ++i) {
    if (!is_free(model_, i)) continue;
    const double speed = speed_of(model_, plant_.world().q(), plant_.world().v(), i);
    slip_speeds_.back() = std::max(slip_speeds_.back(), speed - planned);
  }
}

Handling HandlingWatch::result() const { return {plant_.largest_press(), slip_speeds_}; }

}  // namespace stiction::execution
