#include "stiction/execution/open_loop/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/execution/open_loop/longest_motion.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::Plan;
using planning::SegmentKind;

constexpr double kPartOfRamp = 0.2;  // share of the ramp in which the speed of a regrasp is constant

void require_plan(const world::Model& model, const Plan& plan) {
  world::require_configuration(model, "plan.q_start", plan.q_start);
  core::require_size("plan.u_start", plan.u_start.size(), model.n_a());
  for (std::size_t s = 0; s < plan.segments.size(); ++s) {
    const auto& knots = plan.segments[s].knots;
    for (std::size_t k = 0; k < knots.size(); ++k) {
      const auto field = [&](std::string_view name) { return fmt::format("plan.segments[{}].knots[{}].{}", s, k, name); };
      if (knots[k].u.size() != model.n_a() || !knots[k].u.allFinite())
        core::throw_invalid(field("u"), fmt::format("{} numbers", knots[k].u.size()), fmt::format("{} finite numbers", model.n_a()));
      world::require_configuration(model, field("q"), knots[k].q);
    }
  }
}

/// Interpolates linearly for positions and joints, and along the shortest rotation for orientations.
void blend(const world::Model& model, const VectorRef& q0, const VectorRef& q1, double s, Eigen::Ref<Eigen::VectorXd> q) {
  Eigen::VectorXd delta(model.n_v());
  world::local(model, q0, q1, delta);
  world::retract(model, q0, s * delta, q);
}

/// A time between two knots: a share s of their interval after the first. Outside the trajectory both are its first or last knot.
struct Place {
  Eigen::Index before, after;
  double s;
};

Place place_at(const Trajectory& trajectory, double t) {
  const double* begin = trajectory.times.data();
  const double* end = begin + trajectory.times.size();
  const Eigen::Index after = std::upper_bound(begin, end, t) - begin;
  if (after == 0) return {0, 0, 0.0};
  if (after == trajectory.times.size()) return {after - 1, after - 1, 0.0};
  return {after - 1, after, (t - begin[after - 1]) / (begin[after] - begin[after - 1])};
}

/// Builds a trajectory knot by knot.
class Builder {
 public:
  Builder(const world::Model& model, const SpeedLimits& limits)
      : model_(model), limits_(limits), speed_(limits.of_joints(model)), spring_speed_(limits.of_springs(model)) {}

  /// @param knot  knot of the plan, see Trajectory::knots
  void start(const Eigen::VectorXd& u, const Eigen::VectorXd& q, int knot) {
    knot_ = knot;
    add(0, u, q);
  }

  void begin_piece(SegmentKind kind, int segment) {
    if (!out_.pieces.empty() && limits_.pause > 0) {
      const Eigen::VectorXd u = u_.back(), q = q_.back();
      add(times_.back() + limits_.pause, u, q);
    }
    out_.pieces.push_back({kind, segment, segment, last(), last()});
  }

  void push(const Eigen::VectorXd& u, const Eigen::VectorXd& q) {
    ++knot_;
    move(u, q, calc_duration(u_.back(), u, speed_));
  }

  /// Adds a regrasp, which is slow at its ends (E.8).
  void regrasp(const std::vector<dynamics::Knot>& knots) {
    const double fast = limits_.regrasp_factor, slow = std::min(limits_.landing_factor, fast);
    double whole = 0;  // duration at the speed of pushes [s]
    for (std::size_t k = 0; k < knots.size(); ++k) whole += calc_duration(k == 0 ? u_.back() : knots[k - 1].u, knots[k].u, speed_);
    double begin = 0;
    for (const auto& knot : knots) {
      ++knot_;
      const Eigen::VectorXd u = u_.back(), q = q_.back();
      const double duration = calc_duration(u, knot.u, speed_);
      const bool constant = fast <= slow || std::min(begin, whole - begin - duration) >= fast * limits_.ramp;
      const int parts = constant ? 1 : std::max(1, static_cast<int>(std::ceil(duration / (kPartOfRamp * limits_.ramp))));
      for (int i = 1; i <= parts; ++i) {
        const double s = static_cast<double>(i) / parts, middle = begin + (s - 0.5 / parts) * duration;
        const double factor = std::clamp(std::min(middle, whole - middle) / limits_.ramp, slow, fast);
        Eigen::VectorXd q_s = knot.q;
        if (i < parts) blend(model_, q, knot.q, s, q_s);
        move((1 - s) * u + s * knot.u, q_s, duration / parts / factor);
      }
      begin += duration;
    }
  }

  Piece& piece() { return out_.pieces.back(); }
  bool empty() const { return out_.pieces.empty(); }

  Trajectory take() {
    const auto n = static_cast<Eigen::Index>(times_.size());
    out_.times = Eigen::Map<const Eigen::VectorXd>(times_.data(), n);
    out_.segments = Eigen::Map<const Eigen::VectorXi>(segments_.data(), n);
    out_.knots = Eigen::Map<const Eigen::VectorXi>(knots_.data(), n);
    out_.u.resize(u_.front().size(), n);
    out_.q.resize(q_.front().size(), n);
    for (Eigen::Index k = 0; k < n; ++k) {
      out_.u.col(k) = u_[static_cast<std::size_t>(k)];
      out_.q.col(k) = q_[static_cast<std::size_t>(k)];
    }
    return std::move(out_);
  }

 private:
  /// Adds a knot after dt, or later by (E.9): an object squeezed between two arms would fly off if released at once.
  void move(const Eigen::VectorXd& u, const Eigen::VectorXd& q, double dt) {
    const auto strain = [n_a = u.size()](const Eigen::VectorXd& u_k, const Eigen::VectorXd& q_k) { return u_k - q_k.tail(n_a); };
    dt = std::max(dt, calc_duration(strain(u_.back(), q_.back()), strain(u, q), spring_speed_));
    Piece& piece = out_.pieces.back();
    if (dt >= kLeastInterval) {
      add(times_.back() + dt, u, q);
    } else if (last() > piece.first_knot) {
      q_.back() = q;  // the state changed, the command did not
      knots_.back() = knot_;
    } else {
      add(times_.back() + kLeastInterval, u, q);
    }
    piece.last_knot = last();
  }

  Eigen::Index last() const { return static_cast<Eigen::Index>(times_.size()) - 1; }
  void add(double t, const Eigen::VectorXd& u, const Eigen::VectorXd& q) {
    times_.push_back(t);
    u_.push_back(u);
    q_.push_back(q);
    segments_.push_back(out_.pieces.empty() ? 0 : out_.pieces.back().last_segment);
    knots_.push_back(knot_);
  }

  const world::Model& model_;
  const SpeedLimits& limits_;
  Eigen::VectorXd speed_, spring_speed_;
  Trajectory out_;
  std::vector<double> times_;
  std::vector<int> segments_, knots_;
  int knot_ = 0;  ///< present knot of the plan
  std::vector<Eigen::VectorXd> u_, q_;
};

}  // namespace

Trajectory make_trajectory(const world::Model& model, const Plan& plan, const SpeedLimits& limits) {
  limits.validate();
  require_plan(model, plan);
  Builder builder(model, limits);
  std::size_t s = 0;
  int settled = 0;  // knots
  Eigen::VectorXd u = plan.u_start, q = plan.q_start;
  for (; s < plan.segments.size() && plan.segments[s].kind == SegmentKind::Settle; ++s) {
    if (plan.segments[s].knots.empty()) continue;
    u = plan.segments[s].knots.back().u;
    q = plan.segments[s].knots.back().q;
    settled += static_cast<int>(plan.segments[s].knots.size());
  }
  builder.start(u, q, settled);
  for (; s < plan.segments.size(); ++s) {
    const auto& segment = plan.segments[s];
    if (segment.knots.empty()) continue;
    const bool goes_on = !builder.empty() && segment.kind == SegmentKind::Contact && builder.piece().kind == SegmentKind::Contact;
    if (!goes_on) builder.begin_piece(segment.kind, static_cast<int>(s));
    builder.piece().last_segment = static_cast<int>(s);
    if (segment.kind == SegmentKind::Regrasp) {
      builder.regrasp(segment.knots);
    } else {
      for (const auto& knot : segment.knots) builder.push(knot.u, knot.q);
    }
  }
  if (builder.empty()) core::throw_invalid("plan.segments", "nothing that moves", "at least one segment with knots");
  return require_duration(builder.take());
}

Trajectory require_duration(Trajectory trajectory) {
  constexpr double kLongest = 1e9;
  if (const double end = trajectory.times.tail(1)[0]; !(end <= kLongest))
    core::throw_invalid("speed, pause", fmt::format("a motion of {:.3g} s", end), fmt::format("at most {:g} s", kLongest));
  return trajectory;
}

int segment_at(const Trajectory& trajectory, double t) { return trajectory.segments[place_at(trajectory, t).after]; }

void interpolate_command(const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> u) {
  const Place at = place_at(trajectory, t);
  u = (1 - at.s) * trajectory.u.col(at.before) + at.s * trajectory.u.col(at.after);
}

void interpolate(const world::Model& model, const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> q) {
  const Place at = place_at(trajectory, t);
  if (at.before == at.after) {
    q = trajectory.q.col(at.after);
  } else {
    blend(model, trajectory.q.col(at.before), trajectory.q.col(at.after), at.s, q);
  }
}

Status predict(const world::Model& model, const Plan& plan, int substeps, Plan& out) {
  if (substeps < 1) core::throw_invalid("substeps", std::to_string(substeps), "at least 1");
  require_plan(model, plan);
  out = plan;
  dynamics::StepOptions options = plan.step;
  options.smoothing = dynamics::Exact{};
  options.with_B = options.with_A = false;
  // A non-owning pointer: the caller owns the model during this call.
  dynamics::StepWorkspace work(std::shared_ptr<const world::Model>(&model, [](const world::Model*) {}));
  dynamics::StepResult result;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (std::size_t s = 0; s < plan.segments.size(); ++s) {
    const auto& from = plan.segments[s];
    if (from.knots.empty()) continue;
    const Eigen::VectorXd u_end = from.knots.back().u;
    if (from.kind == SegmentKind::Contact) {
      auto& knots = out.segments[s].knots;
      knots.assign(static_cast<std::size_t>(substeps), {});
      for (int k = 1; k <= substeps; ++k) {
        auto& knot = knots[static_cast<std::size_t>(k - 1)];
        const double part = static_cast<double>(k) / substeps;
        knot.u = k == substeps ? u_end : Eigen::VectorXd((1 - part) * u + part * u_end);
        if (const Status status = dynamics::step(model, {q, knot.u}, options, work, result); status != Status::Solved) {
          out.segments.resize(s);
          return status;
        }
        knot.q = q = result.q_next;
      }
    } else {
      work.forget();
      q = from.knots.back().q;
    }
    u = u_end;
  }
  return Status::Solved;
}

Trajectory retime(Trajectory trajectory, const Trajectory& timing) {
  if (trajectory.pieces.size() != timing.pieces.size())
    core::throw_invalid("timing.pieces", std::to_string(timing.pieces.size()),
                        fmt::format("{} pieces, as in trajectory", trajectory.pieces.size()));
  // Last knot of a segment, from a knot k before it.
  const auto end_of = [](const Trajectory& t, const Piece& piece, Eigen::Index k, int segment) {
    while (k < piece.last_knot && t.segments[k + 1] <= segment) ++k;
    return k;
  };
  const Eigen::VectorXd times = trajectory.times;
  for (std::size_t i = 0; i < timing.pieces.size(); ++i) {
    const Piece &piece = trajectory.pieces[i], &as = timing.pieces[i];
    trajectory.times[piece.first_knot] = timing.times[as.first_knot];
    for (Eigen::Index k = piece.first_knot, j = as.first_knot; k < piece.last_knot;) {  // segment by segment
      const int segment = trajectory.segments[k + 1];
      const Eigen::Index k_end = end_of(trajectory, piece, k, segment), j_end = end_of(timing, as, j, segment);
      const double stretch = (timing.times[j_end] - timing.times[j]) / (times[k_end] - times[k]);
      trajectory.times.segment(k + 1, k_end - k) = timing.times[j] + stretch * (times.segment(k + 1, k_end - k).array() - times[k]);
      k = k_end;
      j = j_end;
    }
  }
  return trajectory;
}

}  // namespace stiction::execution
