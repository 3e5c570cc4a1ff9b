#include "stiction/execution/touch/guarded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/touch/approach.hpp"
#include "stiction/execution/touch/feeler.hpp"
#include "stiction/execution/touch/friction_motion.hpp"
#include "stiction/execution/touch/move_parts.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::string_view to_string(MoveOutcome outcome) noexcept {
  switch (outcome) {
    case MoveOutcome::Arrived:
      return "Arrived";
    case MoveOutcome::Felt:
      return "Felt";
    case MoveOutcome::Lost:
      return "Lost";
    case MoveOutcome::NotFelt:
      return "NotFelt";
    case MoveOutcome::WrongLink:
      return "WrongLink";
    case MoveOutcome::StillThere:
      return "StillThere";
  }
  return "";
}

namespace {

// An edge is detected if the tool drops by kEdgeDepth within kEdgeAlong; kBeyond past the edge, a link is clear of the body [m].
constexpr double kEdgeAlong = 0.01, kEdgeDepth = 0.002, kBeyond = 0.2;
constexpr double kFollow = 0.5;    ///< time constant for catching up with a command that stays behind [s]
constexpr double kMostBehind = 5;  ///< largest lead for a command that stays behind, in asked forces
constexpr double kAgile = 3;       ///< speed limit of commands in a guarded move, in the joint speeds that the move needs
constexpr double kLeastShare = 1e-3;
constexpr double kGlance = 0.02;  ///< duration of the torque means that end a growing lead [s]
constexpr double kMost = 1.05;    ///< largest share of the asked force with which springs press

class GuardedRun {
 public:
  GuardedRun(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out)
      : scenario_(scenario),
        options_(options),
        out_(out),
        arm_(make_guarded_arm(scenario, out, options.seed)),
        loop_(arm_, out.world),
        feeler_(arm_, {}, found_friction(out)),
        kinematics_work_(*arm_.model),
        J_(6, arm_.model->n_a()),
        q_(arm_.start) {
    out_.model = arm_.model;
    locate();
    start_W_ = tool_W_;
  }

  Status go() {
    const auto carry = [this](const GuardedMove& move, MoveResult& result) {
      const Vector3d from_W = tool_W_;
      carry_out(move, result);
      result.travelled = move.direction_W.dot(tool_W_ - from_W);
    };
    return carry_out_moves(scenario_, arm_, options_.settle, loop_, go_on_, carry, out_);
  }

 private:
  /// Computes the place of the tool and its Jacobian.
  void locate() {
    VectorXd q_full = arm_.model->neutral();
    q_full.tail(q_.size()) = q_;
    world::calc_kinematics(*arm_.model, q_full, kinematics_work_, kinematics_);
    tool_W_ = kinematics_.X_WB[static_cast<std::size_t>(arm_.tool)] * arm_.X_BT.p;
    world::calc_point_jacobian(*arm_.model, kinematics_, arm_.tool, tool_W_, J_);
  }

  double calc_softness(const Vector3d& direction) const {
    return (J_.topRows<3>().transpose() * direction).cwiseAbs2().cwiseQuotient(arm_.model->stiffness()).sum();
  }

  bool tick() {
    VectorXd reference = VectorXd::Zero(6);
    reference.head<3>() = reference_;
    if (!tick_arm(reference, options_.control, loop_, out_.run.samples, q_, go_on_)) return false;
    locate();
    if (const VectorXd& external = out_.run.samples.back().external; external.size() > 0) feeler_.update(external, q_);
    return go_on_ == Status::Solved;
  }

  void rest(double seconds) {
    const long ticks = std::lround(seconds / arm_.period);
    for (long k = 0; k < ticks && tick(); ++k) {
    }
  }

  double calc_ahead(const Vector3d& direction) const { return direction.dot(reference_ - (tool_W_ - start_W_)); }

  /// Force with which the reference presses along a direction, from its lead over the arm [N].
  double calc_lead(const Vector3d& direction) const { return calc_ahead(direction) / calc_softness(direction); }

  /// Sets the lead of the reference along a direction so that it presses with `force` (G.5).
  void lead(const Vector3d& direction, double force) {
    reference_ += (force * calc_softness(direction) - calc_ahead(direction)) * direction;
  }

  /// Force with which springs press along a direction with the command in force, including the part that friction bears [N].
  double calc_commanded(const Vector3d& direction) const {
    return direction.dot(J_.topRows<3>() * (out_.run.samples.back().q_cmd - q_)) / calc_softness(direction);
  }

  /// lead() with a limit: once the command presses with kMost of the asked force, the lead grows no further. The cause that holds the arm back may vanish.
  void lead_within(const Vector3d& direction, double force, double asked) {
    lead(direction, calc_commanded(direction) > kMost * asked ? std::min(force, kMost * asked) : force);
  }

  /// lead() during a motion, which the command follows with a lag: the reference leads by this lag as well.
  /// @param behind  force that the command lacks so far [N]
  void lead_moving(const Vector3d& direction, double force, double& behind) {
    behind = std::clamp(behind + arm_.period / kFollow * (force - calc_commanded(direction)), 0.0, kMostBehind * force);
    lead(direction, force + behind);
  }

  /// If joints stick, limits commands of a guarded move to kAgile times the speed that it needs, so that the bound of a false contact causes no jerk.
  void limit_speed(const GuardedMove& move) {
    double share = 1;
    if (move.until && out_.friction) {
      const Eigen::Matrix3d G = J_.topRows<3>() * J_.topRows<3>().transpose();
      const VectorXd needed = J_.topRows<3>().transpose() * G.ldlt().solve(move.speed * move.direction_W);
      share = std::min(1.0, kAgile * needed.cwiseAbs().maxCoeff() / arm_.controller.revolute_speed);
    }
    loop_.limit_speed(std::max(share, kLeastShare));
  }

  void carry_out(const GuardedMove& move, MoveResult& result) {
    limit_speed(move);
    const std::optional<double> length = calc_length(move);
    if (!length) {
      result.reason = fmt::format("its direction does not lead to '{}'", move.gap->body);
      return;
    }
    if (move.until) listen();
    const Vector3d from_W = tool_W_;
    double left = *length, speed = move.speed;
    while (go_on_ == Status::Solved) {
      if (move.press ? !slide(move, left) : !go_along(move, left, speed)) break;
      if (move.press) {
        result.outcome = MoveOutcome::Lost;
        if (!move.correct.empty()) correct(move, arm_.tool, -move.direction_W, -kBeyond, result);
        return;
      }
      if (press(move, result)) return;
      speed = std::max(kSlower * speed, kSlowest * move.speed);
      left = *length - move.direction_W.dot(tool_W_ - from_W);  // it was a false alarm
    }
    if (go_on_ != Status::Solved) return;
    if (move.press) {
      result.outcome = MoveOutcome::StillThere;
      result.reason = fmt::format("after {} m there is still something to press on", move.travel);
      return;
    }
    rest(kRest);
    result.outcome = move.until ? MoveOutcome::NotFelt : MoveOutcome::Arrived;
    if (move.until) result.reason = fmt::format("nothing was felt within {} m", move.travel);
  }

  void listen() {
    rest(kRest);
    feeler_.listen();
    rest(kListen);
    if (go_on_ == Status::Solved) feeler_.start();
  }

  /// Length of the move [m]. Empty: the body of the gap is not in its direction.
  std::optional<double> calc_length(const GuardedMove& move) const {
    if (!move.gap) return move.travel;
    const auto length = calc_approach(*out_.model, full(q_), arm_.tool, find_body(move.gap->body), move.direction_W, move.gap->distance);
    if (!length) return std::nullopt;
    return std::clamp(*length, 0.0, move.travel);
  }

  VectorXd full(const VectorXd& q) const {
    VectorXd out = out_.model->neutral();
    out.tail(q.size()) = q;
    return out;
  }

  int find_body(const std::string& name) const {
    const auto bodies = out_.model->bodies();
    return static_cast<int>(std::find_if(bodies.begin(), bodies.end(), [&](const auto& b) { return b.name == name; }) - bodies.begin());
  }

  /// Moves along the direction. @returns true if a touch ended the motion; false at its end
  bool go_along(const GuardedMove& move, double length, double speed) {
    const MoveProfile profile(std::max(0.0, length), speed);
    const Vector3d from = reference_;
    const long ticks = static_cast<long>(std::ceil(profile.duration() / arm_.period));
    for (long k = 1; k <= ticks; ++k) {
      reference_ = from + profile.at(static_cast<double>(k) * arm_.period) * move.direction_W;
      if (!tick()) return false;
      if (move.until && feeler_.touches()) return true;
    }
    return false;
  }

  /// Moves along a surface while pressing on it. Friction of joints may hide the contact from the torques, so with friction only the way of the tool shows an edge.
  /// @returns true if it came to an edge
  bool slide(const GuardedMove& move, double length) {
    feeler_.keep_touch(out_.friction.has_value());
    const bool edge = slide_kept(move, length);
    feeler_.keep_touch(false);
    return edge;
  }

  bool slide_kept(const GuardedMove& move, double length) {
    const MoveProfile profile(length, move.speed);
    const Vector3d from = reference_;
    std::deque<std::pair<double, double>> way;  // place along the move, and in the direction of the force [m]
    const long ticks = static_cast<long>(std::ceil(profile.duration() / arm_.period)), window = std::lround(kMeasure / arm_.period);
    double behind = (share_ - 1) * move.press->force;
    share_ = 1;
    feeler_.settle();
    for (long k = 1; k <= ticks; ++k) {
      reference_ = from + profile.at(static_cast<double>(k) * arm_.period) * move.direction_W;
      lead_moving(move.press->direction_W, share_ * move.press->force, behind);
      if (!tick()) return false;
      if (is_over_an_edge(move, way)) {
        reference_ = tool_W_ - start_W_;
        return true;
      }
      if (k % window != 0) continue;
      if (const auto felt = describe({})) share_ = follow_force(share_, felt->force, move.press->force);
      feeler_.settle();
    }
    return false;
  }

  /// True if nothing touches any more, or if the surface recedes faster than a tilted surface would.
  bool is_over_an_edge(const GuardedMove& move, std::deque<std::pair<double, double>>& way) const {
    way.emplace_back(move.direction_W.dot(tool_W_), move.press->direction_W.dot(tool_W_));
    while (way.back().first - way.front().first > kEdgeAlong) way.pop_front();
    return !feeler_.touches() || way.back().second - way.front().second > kEdgeDepth;
  }

  /// True if the controller limited the command in most of the last measurement: a missing force is then no reason for a larger lead.
  bool is_held_back() const {
    const auto& samples = out_.run.samples;
    const auto window = std::min(static_cast<std::ptrdiff_t>(std::lround(kMeasure / arm_.period)), std::ssize(samples));
    return 2 * std::count_if(samples.end() - window, samples.end(), [](const ControlSample& s) { return s.bounded; }) > window;
  }

  /// Waits with a part of the force until the impact is over, then presses with all of it and measures.
  /// @returns true if this ended the move; false after a false alarm
  bool press(const GuardedMove& move, MoveResult& result) {
    const double alarm = loop_.time(), begin = alarm - feeler_.age(), force = move.until->force;
    const auto press_for = [&](double seconds, double from, double to) {
      const long ticks = std::lround(seconds / arm_.period);
      feeler_.settle();
      for (long k = 1; k <= ticks && feeler_.touches(); ++k) {
        share_ = from + (to - from) * static_cast<double>(k) / static_cast<double>(ticks);
        lead_within(move.direction_W, share_ * force, force);
        if (!tick() || (to > from && presses(move))) break;
      }
      return feeler_.touches() && go_on_ == Status::Solved;
    };
    if (!approach_force(move, press_for)) return false;
    int wrong = 0;
    for (int k = 0; k < kMeasurements && wrong < kSure; ++k) {
      feeler_.settle();
      if (!press_for(kMeasure, share_, share_)) return false;
      const auto felt = describe(move.until->links);
      wrong = felt ? 0 : wrong + 1;
      if (!felt) continue;
      result.felt = {*felt};
      if (std::abs(felt->force - force) < kRight * force) break;
      const double next = follow_force(share_, felt->force, force);
      share_ = is_held_back() ? std::min(share_, next) : next;
    }
    if (wrong > 0) {
      result.felt.clear();
      result.outcome = MoveOutcome::WrongLink;
      result.reason = name_touched();
      return true;
    }
    result.outcome = MoveOutcome::Felt, result.reason.clear();
    result.felt[0].alarm = alarm, result.felt[0].begin = begin;
    if (!move.correct.empty()) correct(move, result.felt[0].body, move.direction_W, 0, result);
    return true;
  }

  /// True if joints stick and the torques of the last kGlance show the force of a move. Its lead is then no measure of the force, since friction loads the
  /// springs as well.
  bool presses(const GuardedMove& move) {
    if (!out_.friction || feeler_.rows() * arm_.period < kGlance) return false;
    const double force = feeler_.calc_force(-J_.topRows<3>().transpose() * move.direction_W);
    feeler_.settle();
    return force >= move.until->force;
  }

  /// Leads with half of the force of a move, then with all of it. If joints stick, the lead grows from what it is until the torques show the force, because a jump
  /// jerks joints that stick. The command then has at most kSlower of the speed of the move. Joints may hide a small force, so the touch is kept until the lead has grown.
  /// @returns false if nothing touches
  bool approach_force(const GuardedMove& move, const std::function<bool(double, double, double)>& press_for) {
    if (!out_.friction) return press_for(kHold, kStart, kStart) && press_for(kPress, kStart, 1);
    const double force = move.until->force, led = std::clamp(calc_lead(move.direction_W) / force, 0.0, kStart);
    const double whole = force * calc_softness(move.direction_W) / (kSlower * move.speed);  // until springs yield to the force [s]
    feeler_.keep_touch(true);
    const bool pressed = press_for(std::max(kHold + kPress, (1 - led) * whole), led, 1);
    feeler_.keep_touch(false);
    return pressed;
  }

  std::string name_touched() {
    const auto& likely = feeler_.identify(q_).posterior.credible;
    return likely.empty() ? "what touches is on no link that is sensed"
                          : fmt::format("touched at '{}'", feeler_.sensor().link_name(likely.front()));
  }

  std::optional<FeltContact> describe(const std::vector<int>& links) { return describe_touch(feeler_, q_, links, loop_.time()); }

  /// Moves the body named by `correct` in the model until it touches the link.
  /// @param direction  in which the link approaches it  @param start  as in calc_approach() [m]
  void correct(const GuardedMove& move, int link, const Vector3d& direction, double start, MoveResult& result) {
    const auto further = calc_approach(*out_.model, full(q_), link, find_body(move.correct), direction, 0, start);
    if (!further) {
      result.reason =
          fmt::format("'{}' was felt where '{}' cannot be", arm_.model->bodies()[static_cast<std::size_t>(link)].name, move.correct);
      return;
    }
    const Vector3d shift = -*further * direction;
    world::Scene scene = out_.model->scene();
    for (std::size_t i = 0; i < scene.fixed.size(); ++i) {
      if (scene.fixed[i].name != move.correct) continue;
      scene.fixed[i].X_WB.p += shift;
      result.correction = move.direction_W.dot(shift);
      result.correction_error = move.direction_W.dot(scene.fixed[i].X_WB.p - out_.world->scene().fixed[i].X_WB.p);
    }
    out_.model = world::Model::make(scene);
  }

  const TouchScenario& scenario_;
  const TouchRunOptions& options_;
  GuardedRunResult& out_;
  ControlScenario arm_;
  ControlLoop loop_;
  Feeler feeler_;
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics kinematics_;
  control::RowMatrix J_;
  VectorXd q_;                             ///< measured joints (n_a)
  Vector3d tool_W_, start_W_;              ///< position of the tool now and at the start [m]
  Vector3d reference_ = Vector3d::Zero();  ///< reference displacement of the tool from its start [m]
  double share_ = 1;                       ///< factor of the lead (G.5)
  Status go_on_ = Status::Solved;
};

}  // namespace

Status run_guarded(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out) {
  options.validate();
  if (scenario.moves.empty()) core::throw_invalid("moves", "none", "at least one");
  out = {};
  out.world = make_world(scenario, options.seed);
  out.model = scenario.arm.model;
  if (scenario.friction_motion > 0 && (find_friction(scenario, options, out) != Status::Solved || !out.reason.empty())) return out.status;
  out.status = scenario.arm.tool >= 0 ? GuardedRun(scenario, options, out).go() : run_closing(scenario, options, out);
  return out.status;
}

}  // namespace stiction::execution
