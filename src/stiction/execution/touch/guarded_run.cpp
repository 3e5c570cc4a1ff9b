#include "stiction/execution/touch/guarded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "stiction/control/point_jacobian.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/touch/approach.hpp"
#include "stiction/execution/touch/feeler.hpp"

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

// Times of a guarded move [s].
constexpr double kRest = 0.3;     ///< until springs rest after a move
constexpr double kListen = 0.5;   ///< of torques while nothing touches
constexpr double kRamp = 0.2;     ///< in which a move gets to its speed
constexpr double kHold = 0.2;     ///< at half of the force after an alarm
constexpr double kPress = 0.3;    ///< from one force to the next
constexpr double kMeasure = 0.3;  ///< of torques at that force
constexpr double kImpact = 0.1;   ///< after which forces are judged

constexpr double kFollow = 0.5;    ///< time in which a command that stays behind is made up for [s]
constexpr double kMostBehind = 5;  ///< in leads
constexpr double kStart = 0.5;     ///< share of the force with which the arm waits after an alarm
// An edge, and how far beyond it a link is clear of the body [m].
constexpr double kEdgeAlong = 0.01, kEdgeDepth = 0.002, kBeyond = 0.2;
constexpr double kSlower = 0.5;  ///< of the speed, after an alarm with nothing behind it, which a rebound may be
constexpr double kRight = 0.05;  ///< of the force, by which what is felt may be off
constexpr double kGain = 0.5;    ///< of the lead, by what of the force is missing in a measurement
constexpr int kMeasurements = 12;
constexpr int kSure = 2;  ///< measurements in a row that say that another link is touched

/// Way of a straight move from rest to rest: constant acceleration for kRamp, its speed, and the same back to rest.
class Profile {
 public:
  Profile(double length, double speed) : length_(length), speed_(std::min(speed, length / kRamp)) {}
  double duration() const { return speed_ > 0 ? length_ / speed_ + kRamp : 0; }
  double at(double t) const {
    const double T = duration();
    if (t >= T) return length_;
    if (t < kRamp) return 0.5 * speed_ * t * t / kRamp;
    if (t > T - kRamp) return length_ - 0.5 * speed_ * (T - t) * (T - t) / kRamp;
    return speed_ * (t - 0.5 * kRamp);
  }

 private:
  double length_, speed_;
};

class GuardedRun {
 public:
  GuardedRun(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out)
      : scenario_(scenario),
        options_(options),
        out_(out),
        arm_(seeded(scenario.arm, options.seed)),
        loop_(arm_, out.world),
        feeler_(arm_),
        kinematics_work_(*arm_.model),
        J_(6, arm_.model->n_a()),
        q_(arm_.start) {
    out_.model = arm_.model;
    locate();
    start_W_ = tool_W_;
  }

  Status go() {
    out_.reached = true;
    for (const GuardedMove& move : scenario_.moves) {
      MoveResult& result = out_.moves.emplace_back();
      const std::size_t first = out_.run.samples.size();
      result.name = move.name, result.begin = loop_.time();
      const Vector3d from_W = tool_W_;
      carry_out(move, result);
      result.end = loop_.time();
      result.travelled = move.direction_W.dot(tool_W_ - from_W);
      judge(first, result);
      if (go_on_ != Status::Solved || !result.reason.empty()) {
        out_.reached = false;
        out_.reason = go_on_ == Status::NumericalFailure ? loop_.message() : fmt::format("{}: {}", move.name, result.reason);
        break;
      }
    }
    summarise(arm_, loop_, options_.settle, out_.run);
    return out_.status = out_.run.status = go_on_;
  }

 private:
  static ControlScenario seeded(ControlScenario arm, std::uint64_t seed) {
    arm.observer.seed = seed;
    arm.demand = 0.125;  // the lead (G.5) asks for no more than its force: damping within the lag of what is felt is enough
    return arm;
  }

  /// Where the tool is, and the softness of the arm there.
  void locate() {
    VectorXd q_full = arm_.model->neutral();
    q_full.tail(q_.size()) = q_;
    world::calc_kinematics(*arm_.model, q_full, kinematics_work_, kinematics_);
    tool_W_ = kinematics_.X_WB[static_cast<std::size_t>(arm_.tool)] * arm_.X_BT.p;
    control::calc_point_jacobian(*arm_.model, kinematics_, arm_.tool, tool_W_, J_);
  }

  double calc_softness(const Vector3d& direction) const {
    return (J_.topRows<3>().transpose() * direction).cwiseAbs2().cwiseQuotient(arm_.model->stiffness()).sum();
  }

  bool tick() {
    if (options_.control.cancelled()) go_on_ = Status::Cancelled;
    if (options_.control.expired()) go_on_ = Status::MaxIterations;
    if (go_on_ != Status::Solved) return false;
    ControlSample& sample = out_.run.samples.emplace_back();
    VectorXd reference = VectorXd::Zero(6);
    reference.head<3>() = reference_;
    go_on_ = loop_.tick(reference, sample);
    q_ = sample.q;
    locate();
    if (sample.external.size() > 0) feeler_.update(sample.external);
    return go_on_ == Status::Solved;
  }

  void rest(double seconds) {
    const long ticks = std::lround(seconds / arm_.period);
    for (long k = 0; k < ticks && tick(); ++k) {
    }
  }

  /// The command leads the arm along a direction by what presses with `force` (G.5).
  void lead(const Vector3d& direction, double force) {
    const double ahead = direction.dot(reference_ - (tool_W_ - start_W_));
    reference_ += (force * calc_softness(direction) - ahead) * direction;
  }

  /// The same beside a motion, which the command follows with a lag: the reference goes ahead by so much more as the command stays behind. @param behind  that, so far [N]
  void lead_moving(const Vector3d& direction, double force, double& behind) {
    const double commanded = direction.dot(J_.topRows<3>() * (out_.run.samples.back().q_cmd - q_)) / calc_softness(direction);
    behind = std::clamp(behind + arm_.period / kFollow * (force - commanded), 0.0, kMostBehind * force);
    lead(direction, force + behind);
  }

  void carry_out(const GuardedMove& move, MoveResult& result) {
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
      speed *= kSlower;
      left = *length - move.direction_W.dot(tool_W_ - from_W);  // the alarm was a false one
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

  /// How far to go. nullopt: the body of the gap is not in that direction.
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

  /// @returns whether what is felt ends the way, or begins anew after a false alarm; false at its end, or where the contact that is pressed is lost
  bool go_along(const GuardedMove& move, double length, double speed) {
    const Profile profile(std::max(0.0, length), speed);
    const Vector3d from = reference_;
    const long ticks = static_cast<long>(std::ceil(profile.duration() / arm_.period));
    for (long k = 1; k <= ticks; ++k) {
      reference_ = from + profile.at(static_cast<double>(k) * arm_.period) * move.direction_W;
      if (!tick()) return false;
      if (move.until && feeler_.touches()) return true;
    }
    return false;
  }

  /// A move that presses. @returns whether it came to an edge
  bool slide(const GuardedMove& move, double length) {
    const Profile profile(length, move.speed);
    const Vector3d from = reference_;
    std::deque<std::pair<double, double>> way;  // along the move, and in the direction of the force
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
      if (const auto felt = describe({})) follow_force(felt->force, move.press->force);
      feeler_.settle();
    }
    return false;
  }

  /// The controller damps the command while forces are not as predicted, and friction bears a part of what springs press with: the lead follows the force that is felt.
  void follow_force(double felt, double asked) { share_ = std::clamp(share_ + kGain * (1 - felt / asked), kStart, 1 / kStart); }

  /// Nothing touches any more, or what is pressed on gives way faster than a surface leans.
  bool is_over_an_edge(const GuardedMove& move, std::deque<std::pair<double, double>>& way) const {
    way.emplace_back(move.direction_W.dot(tool_W_), move.press->direction_W.dot(tool_W_));
    while (way.back().first - way.front().first > kEdgeAlong) way.pop_front();
    return !feeler_.touches() || way.back().second - way.front().second > kEdgeDepth;
  }

  /// Waits with a part of the force until the impact is over, presses with all of it, and measures.
  /// @returns whether that ended the move; false: nothing touches after all
  bool press(const GuardedMove& move, MoveResult& result) {
    const double alarm = loop_.time(), begin = alarm - feeler_.age(), force = move.until->force;
    const auto press_for = [&](double seconds, double from, double to) {
      const long ticks = std::lround(seconds / arm_.period);
      for (long k = 1; k <= ticks && feeler_.touches(); ++k) {
        lead(move.direction_W, force * (from + (to - from) * static_cast<double>(k) / static_cast<double>(ticks)));
        if (!tick()) break;
      }
      return feeler_.touches() && go_on_ == Status::Solved;
    };
    if (!press_for(kHold, kStart, kStart)) return false;
    if (!press_for(kPress, kStart, 1)) return false;
    share_ = 1;
    int wrong = 0;
    for (int k = 0; k < kMeasurements && wrong < kSure; ++k) {
      feeler_.settle();
      if (!press_for(kMeasure, share_, share_)) return false;
      const auto felt = describe(move.until->links);
      wrong = felt ? 0 : wrong + 1;
      if (!felt) continue;
      result.felt = felt;
      if (std::abs(felt->force - force) < kRight * force) break;
      follow_force(felt->force, force);
    }
    if (wrong > 0) {
      result.felt.reset();
      result.outcome = MoveOutcome::WrongLink;
      result.reason = name_touched();
      return true;
    }
    result.outcome = MoveOutcome::Felt, result.reason.clear();
    result.felt->alarm = alarm, result.felt->begin = begin;
    if (!move.correct.empty()) correct(move, result.felt->body, move.direction_W, 0, result);
    return true;
  }

  /// Of the wanted links the likeliest, of links as sensed; −1: what touches is on none of them, with 95 %.
  int choose_link(const std::vector<int>& wanted, const sensing::Posterior& posterior) const {
    for (const int link : posterior.credible) {
      const int body = feeler_.sensor().links()[static_cast<std::size_t>(link)].surface.body;
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), body) != wanted.end()) return link;
    }
    return -1;
  }

  std::string name_touched() {
    const auto& likely = feeler_.identify(q_).posterior.credible;
    return likely.empty() ? "what touches is on no link that is sensed"
                          : fmt::format("touched at '{}'", feeler_.sensor().link_name(likely.front()));
  }

  /// What touches one of the links, from the torques since the last measurement began; nullopt: none of them is touched.
  std::optional<FeltContact> describe(const std::vector<int>& links) {
    const sensing::SenseResult& sensed = feeler_.identify(q_);
    const int link = choose_link(links, sensed.posterior);
    if (link < 0) return std::nullopt;
    FeltContact out;
    out.time = loop_.time();
    out.body = feeler_.sensor().links()[static_cast<std::size_t>(link)].surface.body;
    out.probability = sensed.posterior.links[static_cast<std::size_t>(link)];
    out.p_W = tool_W_;
    for (const sensing::Candidate& candidate : sensed.candidates) {
      if (candidate.best.link != link) continue;
      out.p_W = candidate.p_W, out.direction_W = candidate.f_W.normalized(), out.force = candidate.f_W.norm();
      break;
    }
    return out;
  }

  /// The body goes where the link says that it is. @param direction  in which the link comes to it  @param start  as of calc_approach() [m]
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

  /// Forces of the simulation over the samples of a move.
  void judge(std::size_t first, MoveResult& result) const {
    const auto& samples = out_.run.samples;
    result.contact = result.end;
    double sum = 0;
    int late = 0;
    for (std::size_t k = first; k < samples.size(); ++k) {
      const double force = samples[k].largest_force;
      if (force > 0) result.contact = std::min(result.contact, samples[k].time);
      result.peak = std::max(result.peak, force);
      if (samples[k].time >= result.contact + kImpact) result.late_peak = std::max(result.late_peak, force);
      if (samples[k].time >= result.end - kImpact) sum += force, ++late;
    }
    result.last_force = late > 0 ? sum / late : 0;
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
  VectorXd q_;                             ///< as measured
  Vector3d tool_W_, start_W_;              ///< the tool now and at the start
  Vector3d reference_ = Vector3d::Zero();  ///< of the tool, from its start [m]
  double share_ = 1;                       ///< of the lead (G.5)
  Status go_on_ = Status::Solved;
};

}  // namespace

Status run_guarded(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out) {
  options.validate();
  if (scenario.moves.empty()) core::throw_invalid("moves", "none", "at least one");
  out = {};
  out.world = make_world(scenario, options.seed);
  out.status = GuardedRun(scenario, options, out).go();
  return out.status;
}

}  // namespace stiction::execution
