#include "stiction/execution/touch/touch_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/touch/joint_path.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

void TouchRunOptions::validate() const { core::require_nonnegative("settle", settle); }

std::string_view to_string(TouchOutcome outcome) noexcept {
  switch (outcome) {
    case TouchOutcome::Reached:
      return "Reached";
    case TouchOutcome::NoRoute:
      return "NoRoute";
    case TouchOutcome::TooManyTouches:
      return "TooManyTouches";
    case TouchOutcome::Missed:
      return "Missed";
  }
  return "";
}

namespace {

constexpr std::uint64_t kRouteStream = 2;  ///< stream of random numbers
constexpr double kTrail = 0.02;            ///< spacing of the recorded postures, by the largest joint difference [rad, L]
/// A contact is reported after it was felt for this many time constants of the estimates, which have settled after half of this time.
constexpr double kPress = 10;
constexpr double kArrive = 1.0;  ///< longest wait for the springs to rest after a path [s]

/// Estimates of one contact over some ticks.
struct Estimate {
  int body = -1, ticks = 0, led = 0;
  Vector3d sum_p = Vector3d::Zero(), sum_f = Vector3d::Zero();
  double sum_pp = 0;

  void add(const control::ContactForce& c, bool leads) {
    body = c.body;
    ++ticks, led += leads;
    sum_p += c.p_WC, sum_f += c.force_W, sum_pp += c.p_WC.squaredNorm();
  }
  TouchedPlace place() const {
    const Vector3d p = sum_p / ticks;
    return {.p_W = p, .n_W = sum_f.normalized(), .spread = std::sqrt(std::max(0.0, sum_pp / ticks - p.squaredNorm()))};
  }
};

/// Collects contacts that were reported without a break until now.
class Feeling {
 public:
  /// @param lag  lag of the contact estimates [s]    @param period  of a tick [s]
  Feeling(double lag, double period) : needed_(static_cast<int>(std::ceil(kPress * lag / period))) {}

  void add(const ControlSample& sample) {
    if (sample.reported.empty()) {
      reset();
      return;
    }
    if (++ticks_ <= needed_ / 2) return;
    for (std::size_t i = 0; i < sample.reported.size(); ++i) estimates_[sample.reported[i].id].add(sample.reported[i], i == 0);
  }
  void reset() { ticks_ = 0, estimates_.clear(); }
  bool is_sure() const { return ticks_ >= needed_; }

  /// Contacts in the order in which they explain the torques: first the one that was the most likely most often.
  std::vector<Estimate> ranked() const {
    std::vector<Estimate> out;
    for (const auto& [id, estimate] : estimates_) out.push_back(estimate);
    std::stable_sort(out.begin(), out.end(), [](const Estimate& a, const Estimate& b) { return a.led > b.led; });
    return out;
  }

 private:
  int needed_, ticks_ = 0;
  std::map<int, Estimate> estimates_;  ///< by the number of the contact, ControlSample::reported
};

class TouchRun {
 public:
  TouchRun(const TouchScenario& scenario, const TouchRunOptions& options, TouchRunResult& out)
      : scenario_(scenario),
        model_(*scenario.arm.model),
        options_(options),
        out_(out),
        arm_(seeded(scenario.arm, options.seed)),
        loop_(arm_, out.world),
        map_(scenario.arm.model),
        feeling_(loop_.lag(), arm_.period),
        random_(options.seed, kRouteStream),
        reference_(arm_.start) {
    remember(arm_.start);
  }

  Status go() {
    while (go_on_ == Status::Solved) {
      if (!plan()) break;
      const Route& route = out_.routes.back().route;
      follow(joined(route.retreat), false);
      way_.resize(way_.size() - (route.retreat.size() - 1));
      bool touched = false;
      for (std::size_t k = 1; k < route.postures.size() && !touched; ++k) touched = follow({reference_, route.postures[k]}, true);
      touched = touched || wait();
      if (go_on_ != Status::Solved) break;
      if (!touched) {
        arrive();
        break;
      }
      tell();
      if (static_cast<int>(out_.touches.size()) >= scenario_.max_touches) {
        give_up(TouchOutcome::TooManyTouches, fmt::format("touched {} times", out_.touches.size()));
        break;
      }
    }
    out_.goal_error = calc_joint_distance(out_.run.samples.empty() ? arm_.start : out_.run.samples.back().q, scenario_.goal);
    summarise(arm_, loop_, options_.settle, out_.run);
    out_.map = map_.make_model(1);
    if (go_on_ == Status::NumericalFailure) out_.reason = loop_.message();
    return out_.run.status = go_on_;
  }

 private:
  static ControlScenario seeded(ControlScenario arm, std::uint64_t seed) {
    arm.observer.seed = seed;
    return arm;
  }

  double calc_joint_distance(const VectorXd& a, const VectorXd& b) const {
    return (a - b).cwiseAbs().cwiseQuotient(model_.scales().joints()).maxCoeff();
  }

  void remember(const VectorXd& q) {
    visited_.push_back(q);
    way_.push_back(q);
  }

  bool plan() {
    const auto started = core::RunControl::Clock::now();
    Route route = find_route(map_, way_, scenario_.goal, random_, options_.control);
    out_.routes.push_back({loop_.time(), std::move(route), core::seconds_since(started)});
    const Route& found = out_.routes.back().route;
    if (options_.control.cancelled()) go_on_ = Status::Cancelled;
    if (options_.control.expired()) go_on_ = Status::MaxIterations;
    if (found.outcome == contact::PathOutcome::Found) return true;
    give_up(TouchOutcome::NoRoute, describe(found.outcome));
    return false;
  }

  /// Prepends the reference to a retreat: the commands are at the reference, not at the measured posture.
  std::vector<VectorXd> joined(std::vector<VectorXd> retreat) const {
    retreat.insert(retreat.begin(), reference_);
    return retreat;
  }

  /// Follows postures. @param forward  the way is recorded, and a contact ends the path    @returns true if a contact ended it
  bool follow(std::vector<VectorXd> postures, bool forward) {
    const JointPath path(model_, std::move(postures), scenario_.speed);
    const auto ticks = static_cast<long>(std::ceil(path.duration() / arm_.period));
    for (long k = 1; k <= ticks; ++k)
      if (!tick(path.at(static_cast<double>(k) * arm_.period), forward) || (forward && feeling_.is_sure())) break;
    return forward && feeling_.is_sure();
  }

  /// Waits at the end of a path until the springs rest. @returns true if a contact was felt
  bool wait() {
    const auto ticks = static_cast<long>(std::ceil(kArrive / arm_.period));
    for (long k = 0; k < ticks && !feeling_.is_sure(); ++k)
      if (!tick(reference_, true)) break;
    return feeling_.is_sure();
  }

  bool tick(const VectorXd& reference, bool forward) {
    if (go_on_ == Status::Solved && options_.control.cancelled()) go_on_ = Status::Cancelled;
    if (go_on_ == Status::Solved && options_.control.expired()) go_on_ = Status::MaxIterations;
    if (go_on_ != Status::Solved) return false;
    reference_ = reference;
    ControlSample& sample = out_.run.samples.emplace_back();
    go_on_ = loop_.tick(reference, sample);
    if (forward) {
      feeling_.add(sample);
      if (calc_joint_distance(sample.q, way_.back()) >= kTrail) remember(sample.q);
    } else {
      feeling_.reset();
    }
    return go_on_ == Status::Solved;
  }

  /// Adds the most likely contact through which the arm has not passed to the map.
  void tell() {
    remember(out_.run.samples.back().q);
    const std::vector<Estimate> ranked = feeling_.ranked();
    Touch touch;
    touch.time = loop_.time(), touch.doubted = true;
    const Estimate* taken = &ranked.front();
    for (const Estimate& estimate : ranked) {
      touch.radius = map_.find_radius(estimate.place(), visited_);
      if (touch.radius == 0) continue;
      taken = &estimate, touch.doubted = false;
      break;
    }
    if (touch.doubted) touch.radius = std::ldexp(model_.scales().robots().length, -TouchMap::kHalves);
    touch.body = taken->body, touch.place = taken->place(), touch.force = taken->sum_f.norm() / taken->ticks;
    touch.error = std::numeric_limits<double>::infinity();
    for (const auto& f : out_.run.samples.back().forces) touch.error = std::min(touch.error, (f.p_WC - touch.place.p_W).norm());
    map_.add(touch.place, touch.radius);
    out_.touches.push_back(touch);
    feeling_.reset();
  }

  void arrive() {
    const double error = calc_joint_distance(out_.run.samples.back().q, scenario_.goal);
    if (error <= scenario_.tolerance) {
      out_.outcome = TouchOutcome::Reached;
      return;
    }
    give_up(TouchOutcome::Missed, fmt::format("a joint is {:.3g} from its goal and nothing is felt", error));
  }

  /// Ends the run; the arm holds its measured posture.
  void give_up(TouchOutcome outcome, std::string reason) {
    out_.outcome = outcome, out_.reason = std::move(reason);
    if (out_.run.samples.empty()) return;
    const VectorXd q = out_.run.samples.back().q;
    const auto ticks = static_cast<long>(std::ceil(kArrive / arm_.period));
    for (long k = 0; k < ticks; ++k)
      if (!tick(q, false)) break;
  }

  const TouchScenario& scenario_;
  const world::Model& model_;
  const TouchRunOptions& options_;
  TouchRunResult& out_;
  ControlScenario arm_;
  ControlLoop loop_;
  TouchMap map_;
  Feeling feeling_;
  core::Random random_;
  VectorXd reference_;
  std::vector<VectorXd> visited_;  ///< measured postures, in each of which no obstacle overlaps the arm
  std::vector<VectorXd> way_;      ///< those of the way from the start
  Status go_on_ = Status::Solved;
};

}  // namespace

Status run_touch(const TouchScenario& scenario, const TouchRunOptions& options, TouchRunResult& out) {
  options.validate();
  if (scenario.goal.size() == 0)
    core::throw_invalid("goal", "a scenario of moves", "one with a goal; `stiction touch` and guarded_moves() carry out moves");
  out = {};
  out.world = make_world(scenario, options.seed);
  out.status = TouchRun(scenario, options, out).go();
  return out.status;
}

}  // namespace stiction::execution
