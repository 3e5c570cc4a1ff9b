#include "stiction/execution/open_loop/run_timing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/firm_grip.hpp"
#include "stiction/execution/open_loop/lag_allowance.hpp"
#include "stiction/execution/open_loop/longest_motion.hpp"
#include "stiction/execution/open_loop/push_travel.hpp"
#include "stiction/execution/open_loop/spring_load.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using planning::SegmentKind;
using world::Model;

/// Time between knots where the speed changes, at the full speed [s].
constexpr double kPart = 0.02;
constexpr int kMostParts = 100;

double infinite() { return std::numeric_limits<double>::infinity(); }

/// The way from one knot to the next, passed at a multiple f of the speed of pushes.
struct Stretch {
  double way = 0;           ///< duration at f = 1 [s]
  double most = 1;          ///< largest f
  double acceleration = 0;  ///< largest rate of f [1/s]
  bool carried = false;     ///< only robots hold an object
  bool free = false;        ///< regrasp, or a push in which no object moves and no spring of a moving joint is loaded
  Eigen::VectorXd room;     ///< clearance for the lag of each joint, in multiples of RunSpeeds::room (n_a)
  Eigen::VectorXd slope;    ///< du/dt at f = 1 (n_a)
  Eigen::VectorXd lead;     ///< lead (E.17) at f = 1 (n_a)
};

double least_ratio(const Eigen::VectorXd& numerators, const Eigen::VectorXd& denominators) {
  double least = infinite();
  for (Eigen::Index j = 0; j < numerators.size(); ++j) {
    if (denominators[j] != 0) least = std::min(least, numerators[j] / std::abs(denominators[j]));
  }
  return least;
}

Eigen::VectorXd strain_at(const Trajectory& t, Eigen::Index k) { return t.u.col(k) - t.q.col(k).tail(t.u.rows()); }

/// True if objects rest and no moving joint exerts a force from knot k to the next.
bool moves_freely(const Model& model, const Trajectory& t, Eigen::Index k) {
  Eigen::VectorXd delta(model.n_v());
  world::local(model, t.q.col(k), t.q.col(k + 1), delta);
  if (!dynamics::moves_nothing(model, delta)) return false;
  const Eigen::ArrayXd strain = strain_at(t, k).cwiseAbs().cwiseMax(strain_at(t, k + 1).cwiseAbs());
  const Eigen::ArrayXd force = strain * model.stiffness().array() / model.reach().array();
  const double least = world::share::kActive * model.scales().robots().force;
  return ((t.u.col(k + 1) - t.u.col(k)).array() == 0 || force < least).all();
}

/// @param free    nothing is pushed, as in every regrasp   @param carried  only robots hold an object
/// @param travel  travel of a push [m]   @param room  allowed lag of free motion [m]
Stretch stretch_between(const RunSpeeds& speeds, bool free, bool carried, double travel, double room, const Trajectory& t, Eigen::Index k) {
  const Eigen::VectorXd u0 = t.u.col(k), u1 = t.u.col(k + 1);
  Stretch out;
  out.free = free;
  out.carried = carried;
  out.room = speeds.most_room.cwiseMin(room).cwiseQuotient(speeds.most_room.cwiseMin(speeds.room));
  out.way = free ? calc_duration(u0, u1, speeds.push) : std::max(travel / speeds.object, calc_duration(u0, u1, speeds.most));
  out.way = std::max(out.way, kLeastInterval);
  out.slope = (u1 - u0) / out.way;
  if (free) {
    out.most = least_ratio(speeds.most, out.slope);
    out.acceleration = least_ratio(out.room.cwiseProduct(speeds.acceleration), out.slope);
  } else if (speeds.start_time > 0) {
    out.acceleration = 1 / speeds.start_time;
  } else {
    out.acceleration = carried ? least_ratio(speeds.carry_acceleration, out.slope) : infinite();
  }
  return out;
}

/// Number of parts into which a stretch is cut so that its speed can change.
/// @param whole  duration of its piece at f = 1 [s]  @param part  time between knots [s]
int count_parts(const Stretch& s, double whole, double part) {
  if (!std::isfinite(s.acceleration)) return 1;
  const double fastest = std::min(s.most, std::sqrt(1 + s.acceleration * whole));
  return static_cast<int>(std::clamp(std::ceil(s.way / fastest / part), 1.0, static_cast<double>(kMostParts)));
}

/// f at the knots between stretches, within the limits of both, and without jumps at corners of the path.
std::vector<double> calc_knot_speeds(const RunSpeeds& speeds, SegmentKind kind, const std::vector<Stretch>& stretches) {
  const std::size_t n = stretches.size();
  const double at_ends = kind == SegmentKind::Contact && speeds.start_time > 0 ? 0 : 1;
  std::vector<double> f(n + 1, at_ends);
  const auto carried = [&](const Eigen::VectorXd& change) { return std::min(1.0, least_ratio(speeds.carry_jump, change)); };
  for (std::size_t k = 1; k < n; ++k) {
    f[k] = 1;
    const Stretch &before = stretches[k - 1], &after = stretches[k];
    const Eigen::VectorXd change = after.slope - before.slope;
    if (before.free && after.free)
      f[k] = least_ratio(speeds.jump.cwiseProduct(after.room.cwiseMin(before.room)), change);
    else if (before.carried || after.carried)
      f[k] = carried(change);
  }
  if (n > 0 && stretches.front().carried) f[0] = std::min(f[0], carried(stretches.front().slope));
  if (n > 0 && stretches.back().carried) f[n] = std::min(f[n], carried(stretches.back().slope));
  for (std::size_t k = 0; k <= n; ++k) {
    if (k < n) f[k] = std::min(f[k], stretches[k].most);
    if (k > 0) f[k] = std::min(f[k], stretches[k - 1].most);
  }
  const auto reachable = [](double from, const Stretch& s) { return std::sqrt(from * from + 2 * s.acceleration * s.way); };
  for (std::size_t k = 0; k < n; ++k) f[k + 1] = std::min(f[k + 1], reachable(f[k], stretches[k]));
  for (std::size_t k = n; k > 0; --k) f[k - 1] = std::min(f[k - 1], reachable(f[k], stretches[k - 1]));
  return f;
}

/// Duration of a stretch: accelerate from f0, go at the largest f, decelerate to f1 [s].
double calc_time(const Stretch& s, double f0, double f1) {
  if (!std::isfinite(s.acceleration)) return s.way / s.most;
  const double a = s.acceleration, peak = std::min(s.most, std::sqrt(a * s.way + 0.5 * (f0 * f0 + f1 * f1)));
  const double ramps = (2 * peak * peak - f0 * f0 - f1 * f1) / (2 * a);
  return (2 * peak - f0 - f1) / a + std::max(0.0, s.way - ramps) / peak;
}

/// Assigns times and leads to the knots of a trajectory, and adds knots in between.
class Timer {
 public:
  Timer(const Model& model, const planning::Plan& plan, const RunSpeeds& speeds, DragFeedforward* lead, double pause)
      : model_(model),
        plan_(plan),
        speeds_(speeds),
        lead_(lead != nullptr && lead->acts() ? lead : nullptr),
        pause_(pause),
        travel_(model),
        room_(model, speeds.room),
        springs_(model, speeds) {}

  Trajectory run(Trajectory in) {
    carried_ = find_carried(model_, in);
    tighten_grips(model_, carried_, in);
    add(in.u.col(0), in.q.col(0), in.segments[0], in.knots[0], 0);
    for (const Piece& piece : in.pieces) add_piece(in, piece);
    return take();
  }

 private:
  void add_piece(const Trajectory& in, const Piece& piece) {
    std::vector<Stretch> given;
    double whole = 0;
    for (Eigen::Index k = piece.first_knot; k < piece.last_knot; ++k) {
      given.push_back(make_stretch(in, piece.kind, k));
      whole += given.back().way;
    }
    std::vector<Stretch> stretches;
    std::vector<std::size_t> ends;  // for each given knot, one past its last stretch
    for (std::size_t k = 0; k < given.size(); ++k) {
      const Eigen::Index from = piece.first_knot + static_cast<Eigen::Index>(k);
      add_parts(given[k], whole, strain_at(in, from), strain_at(in, from + 1), stretches);
      ends.push_back(stretches.size());
    }
    const std::vector<double> f = calc_knot_speeds(speeds_, piece.kind, stretches);
    if (!pieces_.empty() && pause_ > 0) {
      const Eigen::VectorXd u = u_.back(), q = q_.back();
      add(u, q, segments_.back(), knots_.back(), times_.back() + pause_);
    }
    Piece& out = pieces_.emplace_back(piece);
    out.first_knot = last();
    std::size_t i = 0;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      const Eigen::Index from = piece.first_knot + static_cast<Eigen::Index>(k), to = from + 1;
      const std::size_t begin = i;
      for (; i < ends[k]; ++i) {
        const double share = static_cast<double>(i + 1 - begin) / static_cast<double>(ends[k] - begin);
        Eigen::VectorXd u = (1 - share) * in.u.col(from) + share * in.u.col(to);
        if (lead_ != nullptr) add_lead(stretches, i, f[i + 1], u);
        const double time = std::max(calc_time(stretches[i], f[i], f[i + 1]), calc_duration(u_.back(), u, speeds_.most));
        add(u, blend(in.q.col(from), in.q.col(to), share), in.segments[to], in.knots[to], times_.back() + std::max(time, kLeastInterval));
      }
    }
    out.last_knot = last();
  }

  /// Cuts a stretch into parts, each no faster than its springs may be strained.                                              (E.24)
  void add_parts(Stretch s, double whole, const Eigen::VectorXd& strain, const Eigen::VectorXd& strain_next,
                 std::vector<Stretch>& out) const {
    const double part = kPart / std::min(speeds_.factor, 1.0);  // so that a slower run has the same knots
    const int parts = std::max(count_parts(s, whole, part), springs_.count_parts(strain, strain_next));
    const auto at = [&](int i) -> Eigen::VectorXd { return strain + static_cast<double>(i) / parts * (strain_next - strain); };
    s.way /= parts;
    for (int i = 0; i < parts; ++i) {
      out.push_back(s);
      if (const double load = springs_.calc_time(at(i), at(i + 1)); load > 0) out.back().most = std::min(s.most, s.way / load);
    }
  }

  Stretch make_stretch(const Trajectory& in, SegmentKind kind, Eigen::Index k) {
    const bool free = kind == SegmentKind::Regrasp || moves_freely(model_, in, k);
    const double travel = free ? 0.0 : travel_.calc(in.q.col(k), in.q.col(k + 1));
    const double room = free ? room_.calc(in.u.col(k), in.u.col(k + 1), in.q.col(k), in.q.col(k + 1)) : speeds_.room;
    const auto at = static_cast<std::size_t>(k);
    const bool carried = !free && speeds_.start_time == 0 && (carried_[at] != 0 || carried_[at + 1] != 0);
    Stretch out = stretch_between(speeds_, free, carried, travel, room, in, k);
    out.lead = Eigen::VectorXd::Zero(model_.n_a());
    if (lead_ != nullptr && !free) set_lead(in, k, out);
    return out;
  }

  void set_lead(const Trajectory& in, Eigen::Index k, Stretch& s) {
    auto lead = lead_->calc(plan_, in.q.col(k), in.u.col(k + 1), in.q.col(k + 1), s.way, speeds_.unled);
    s.lead = std::move(lead.strain);
    s.most = std::min(s.most, lead.speed);
  }

  /// Adds to the command after stretch i the mean of the leads before and after it.
  void add_lead(const std::vector<Stretch>& stretches, std::size_t i, double f, Eigen::VectorXd& u) const {
    Eigen::VectorXd lead = stretches[i].lead;
    if (i + 1 < stretches.size()) lead = 0.5 * (lead + stretches[i + 1].lead);
    u = (u + f * lead).cwiseMax(model_.command_lower()).cwiseMin(model_.command_upper());
  }

  Eigen::VectorXd blend(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, double share) const {
    if (share == 1) return q1;
    Eigen::VectorXd delta(model_.n_v()), q(model_.n_q());
    world::local(model_, q0, q1, delta);
    world::retract(model_, q0, share * delta, q);
    return q;
  }

  Eigen::Index last() const { return static_cast<Eigen::Index>(times_.size()) - 1; }
  void add(const Eigen::VectorXd& u, const Eigen::VectorXd& q, int segment, int knot, double time) {
    u_.push_back(u), q_.push_back(q), segments_.push_back(segment), knots_.push_back(knot), times_.push_back(time);
  }

  Trajectory take() const {
    const auto n = static_cast<Eigen::Index>(times_.size());
    Trajectory out;
    out.times = Eigen::Map<const Eigen::VectorXd>(times_.data(), n);
    out.segments = Eigen::Map<const Eigen::VectorXi>(segments_.data(), n);
    out.knots = Eigen::Map<const Eigen::VectorXi>(knots_.data(), n);
    out.u.resize(model_.n_a(), n), out.q.resize(model_.n_q(), n);
    for (Eigen::Index k = 0; k < n; ++k) {
      out.u.col(k) = u_[static_cast<std::size_t>(k)];
      out.q.col(k) = q_[static_cast<std::size_t>(k)];
    }
    out.pieces = pieces_;
    out.speed = speeds_.factor;
    return out;
  }

  const Model& model_;
  const planning::Plan& plan_;
  const RunSpeeds& speeds_;
  DragFeedforward* lead_;
  double pause_;
  std::vector<char> carried_;  // per given knot
  PushTravel travel_;
  LagAllowance room_;
  SpringLoad springs_;
  std::vector<Eigen::VectorXd> u_, q_;
  std::vector<int> segments_, knots_;
  std::vector<double> times_;
  std::vector<Piece> pieces_;
};

}  // namespace

Trajectory make_trajectory(const Model& model, const planning::Plan& plan, const RunSpeeds& speeds, DragFeedforward* lead, double pause) {
  speeds.validate(model);
  core::require_nonnegative("pause", pause);
  // One unit per second: only the knots are used, their times are set later.
  const Trajectory knots =
      make_trajectory(model, plan, {.revolute = 1, .prismatic = 1, .regrasp_factor = 1, .landing_factor = 1, .load_time = 0, .pause = 0});
  return require_duration(Timer(model, plan, speeds, lead, pause).run(knots));
}

Trajectory make_trajectory(const Model& model, const planning::Plan& plan, double speed, double pause) {
  // A non-owning pointer: the caller owns the model during this call.
  DragFeedforward lead(std::shared_ptr<const Model>(&model, [](const Model*) {}));
  return make_trajectory(model, plan, calc_run_speeds(model, plan.goal.object, speed), &lead, pause);
}

Eigen::VectorXd start_of(const Model& model, const planning::Plan& plan) { return make_trajectory(model, plan, SpeedLimits{}).q.col(0); }

}  // namespace stiction::execution
