#include <fmt/format.h>

#include <cmath>
#include <deque>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/touch/feeler.hpp"
#include "stiction/execution/touch/joint_path.hpp"
#include "stiction/execution/touch/move_parts.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::VectorXd;

namespace {

/// A finger, or another branch that feels on its own: the joints that move its link and no other of the links.
struct Side {
  enum class State {
    Going,
    Holding,
    Pressing,
    Measuring,
    Done
  };
  int link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< middle of the link's geometry
  std::vector<int> joints;
  Feeler feeler;
  VectorXd from{}, to{};  ///< postures of all joints; only joints of this side count
  double speed = 0;
  double asked = 0;  ///< speed of the move [m/s]
  State state = State::Going;
  long ticks = 0;  ///< ticks in this state
  double share = kStart;
  int measurements = 0;
  double alarm = 0, begin = 0;
  std::optional<FeltContact> felt{};

  void enter(State next) { state = next, ticks = 0; }
};

class Closing {
 public:
  Closing(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out)
      : scenario_(scenario),
        options_(options),
        out_(out),
        arm_(make_guarded_arm(scenario, out, options.seed)),
        model_(*arm_.model),
        loop_(arm_, out.world),
        kinematics_work_(model_),
        J_(6, model_.n_a()),
        q_(arm_.start),
        reference_(arm_.start) {
    out_.model = arm_.model;
  }

  Status go() {
    const auto carry = [this](const GuardedMove& move, MoveResult& result) {
      const VectorXd from = q_;
      move.until ? close(move, result) : follow(move, result);
      result.travelled = calc_travel(model_, from, q_);
    };
    return carry_out_moves(scenario_, arm_, options_.settle, loop_, go_on_, carry, out_);
  }

 private:
  void locate() {
    VectorXd q_full = model_.neutral();
    q_full.tail(q_.size()) = q_;
    world::calc_kinematics(model_, q_full, kinematics_work_, kinematics_);
  }

  bool tick() {
    if (!tick_arm(reference_, options_.control, loop_, out_.run.samples, q_, go_on_)) return false;
    locate();
    const VectorXd& external = out_.run.samples.back().external;
    for (Side& side : sides_)
      if (external.size() > 0) side.feeler.update(external, q_);
    return go_on_ == Status::Solved;
  }

  void rest(double seconds) {
    const long ticks = std::lround(seconds / arm_.period);
    for (long k = 0; k < ticks && tick(); ++k) {
    }
  }

  /// Moves to a posture without regard to contacts; the controller bounds their forces.
  void follow(const GuardedMove& move, MoveResult& result) {
    const JointPath path(model_, {reference_, move.posture}, move.speed);
    const auto ticks = static_cast<long>(std::ceil(path.duration() / arm_.period));
    for (long k = 1; k <= ticks; ++k) {
      reference_ = path.at(static_cast<double>(k) * arm_.period);
      if (!tick()) return;
    }
    rest(kRest);
    result.outcome = MoveOutcome::Arrived;
  }

  bool moves(int joint, int link) const { return moves_body(model_, joint, model_.bodies()[static_cast<std::size_t>(link)]); }

  Eigen::Vector3d find_middle(int link) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const world::Geometry& geometry : model_.geometries())
      if (geometry.body == link) sum += geometry.p_BCenter, ++count;
    return count > 0 ? Eigen::Vector3d(sum / count) : sum;
  }

  void make_sides(const GuardedMove& move) {
    sides_.clear();
    locate();
    for (const int link : move.until->links) {
      std::vector<int> joints;
      for (int j = 0; j < model_.n_a(); ++j) {
        const auto& all = move.until->links;
        if (moves(j, link) && std::none_of(all.begin(), all.end(), [&](int other) { return other != link && moves(j, other); }))
          joints.push_back(j);
      }
      if (joints.empty())
        core::throw_invalid("until.links", fmt::format("'{}'", model_.bodies()[static_cast<std::size_t>(link)].name),
                            "links that joints of their own move");
      sides_.push_back(
          Side{.link = link, .p_L = find_middle(link), .joints = joints, .feeler = Feeler(arm_, joints, found_friction(out_))});
    }
  }

  void close(const GuardedMove& move, MoveResult& result) {
    make_sides(move);
    rest(kRest);
    for (Side& side : sides_) side.feeler.listen();
    rest(kListen);
    if (go_on_ != Status::Solved) return;
    for (Side& side : sides_) {
      side.feeler.start();
      side.from = reference_, side.to = move.posture, side.speed = side.asked = move.speed;
    }
    while (go_on_ == Status::Solved && result.reason.empty()) {
      if (std::all_of(sides_.begin(), sides_.end(), [](const Side& s) { return s.state == Side::State::Done; })) {
        result.outcome = MoveOutcome::Felt;
        break;
      }
      for (Side& side : sides_) command(side, move.until->force);
      if (!tick()) break;
      for (Side& side : sides_)
        if (result.reason.empty()) advance(side, move.until->force, result);
    }
    for (const Side& side : sides_)
      if (side.felt) result.felt.push_back(*side.felt);
  }

  double calc_length(const Side& side) const {
    double out = 0;
    for (const int j : side.joints) out += model_.reach()[j] * std::abs(side.to[j] - side.from[j]);
    return out;
  }

  /// Sets the reference of the side's joints for the next tick.
  void command(Side& side, double force) {
    ++side.ticks;
    const double t = static_cast<double>(side.ticks) * arm_.period;
    if (side.state == Side::State::Going) {
      const double length = calc_length(side), along = length > 0 ? MoveProfile(length, side.speed).at(t) / length : 1;
      for (const int j : side.joints) reference_[j] = side.from[j] + along * (side.to[j] - side.from[j]);
      return;
    }
    const double ramp = side.state == Side::State::Pressing ? kStart + (1 - kStart) * std::min(1.0, t / kPress) : side.share;
    lead(side, (side.state == Side::State::Holding ? kStart : ramp) * force);
  }

  /// Velocity of the middle of its link for the joint step; sets J_ to the Jacobian of this point.
  Eigen::Vector3d calc_velocity(const Side& side, const VectorXd& step) {
    world::calc_point_jacobian(model_, kinematics_, side.link, kinematics_.X_WB[static_cast<std::size_t>(side.link)] * side.p_L, J_);
    return J_.topRows<3>() * step;
  }

  /// One or two joints cannot tell place and direction of a contact. Its force is then assumed to act on the middle of the link, against its motion.
  void take_direction_of_motion(Side& side) {
    constexpr std::size_t kEnough = 3;
    VectorXd step = VectorXd::Zero(q_.size());
    for (const int j : side.joints) step[j] = side.to[j] - side.from[j];
    const Eigen::Vector3d v = calc_velocity(side, step);
    if (side.joints.size() >= kEnough || !(v.norm() > 0)) return;
    const world::Pose& X_WL = kinematics_.X_WB[static_cast<std::size_t>(side.link)];
    side.felt->direction_W = -v.normalized();
    side.felt->p_W = X_WL * side.p_L;
    side.felt->force = side.feeler.calc_force(side.link, side.p_L, X_WL.R.transpose() * side.felt->direction_W);
  }

  /// Sets the commands of the side's joints ahead in the direction of the move, so that the middle of its link presses with `force`, as in (G.5) with the
  /// softness of all joints.
  void lead(const Side& side, double force) {
    VectorXd step = VectorXd::Zero(q_.size());
    for (const int j : side.joints) step[j] = side.to[j] - side.from[j];
    const Eigen::Vector3d v = calc_velocity(side, step);
    if (!(v.norm() > 0)) return;
    const double softness = (J_.topRows<3>().transpose() * v.normalized()).cwiseAbs2().cwiseQuotient(model_.stiffness()).sum();
    for (const int j : side.joints) reference_[j] = q_[j] + force * softness / v.norm() * step[j];
  }

  /// Sets the next state of a side after a tick.
  void advance(Side& side, double force, MoveResult& result) {
    const double t = static_cast<double>(side.ticks) * arm_.period;
    const bool touches = side.feeler.touches();
    switch (side.state) {
      case Side::State::Going:
        if (touches) {
          side.alarm = loop_.time(), side.begin = loop_.time() - side.feeler.age();
          side.enter(Side::State::Holding);
        } else if (t > MoveProfile(calc_length(side), side.speed).duration() + kRest) {
          result.outcome = MoveOutcome::NotFelt;
          result.reason = fmt::format("'{}' felt nothing", model_.bodies()[static_cast<std::size_t>(side.link)].name);
        }
        return;
      case Side::State::Holding:
        if (!touches) return go_again(side);
        if (t >= kHold) side.enter(Side::State::Pressing);
        return;
      case Side::State::Pressing:
        if (!touches) return go_again(side);
        if (t < kPress) return;
        side.share = 1, side.measurements = 0;
        side.feeler.settle();
        side.enter(Side::State::Measuring);
        return;
      case Side::State::Measuring:
        if (!touches) return go_again(side);
        if (t >= kMeasure) measure(side, force, result);
        return;
      case Side::State::Done:
        return;
    }
  }

  /// Continues the move more slowly after a false alarm.
  void go_again(Side& side) {
    side.from = q_;
    side.speed = std::max(kSlower * side.speed, kSlowest * side.asked);
    side.enter(Side::State::Going);
  }

  void measure(Side& side, double force, MoveResult& result) {
    side.felt = describe_touch(side.feeler, q_, {side.link}, loop_.time());
    if (side.felt) take_direction_of_motion(side);
    ++side.measurements;
    side.feeler.settle();
    side.enter(Side::State::Measuring);
    if (!side.felt) {
      if (side.measurements < kMeasurements) return;
      result.outcome = MoveOutcome::WrongLink;
      result.reason = fmt::format("the joints of '{}' feel a touch elsewhere", model_.bodies()[static_cast<std::size_t>(side.link)].name);
      return;
    }
    side.felt->alarm = side.alarm, side.felt->begin = side.begin;
    if (std::abs(side.felt->force - force) < kRight * force || side.measurements >= kMeasurements) return side.enter(Side::State::Done);
    side.share = follow_force(side.share, side.felt->force, force);
  }

  const TouchScenario& scenario_;
  const TouchRunOptions& options_;
  GuardedRunResult& out_;
  ControlScenario arm_;
  const world::Model& model_;
  ControlLoop loop_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  control::RowMatrix J_;
  VectorXd q_, reference_;  ///< measured joints; commanded joints (n_a)
  std::deque<Side> sides_;
  Status go_on_ = Status::Solved;
};

}  // namespace

Status run_closing(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out) {
  return Closing(scenario, options, out).go();
}

}  // namespace stiction::execution
