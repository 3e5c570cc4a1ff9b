#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/execution/closed_loop/part_start.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::SegmentKind;
using world::Model;

struct Distance {
  double position, angle;
};

double angle_between(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  const Eigen::Quaterniond q(R0.transpose() * R1);
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

Distance distance(const Model& model, int object, VectorRef q0, VectorRef q1) {
  const world::Pose X0 = world::object_pose(model, q0, object), X1 = world::object_pose(model, q1, object);
  return {(X0.p - X1.p).norm(), angle_between(X0.R, X1.R)};
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

Eigen::MatrixXd plan_at(const Model& model, const Trajectory& trajectory, double offset, const std::vector<double>& times) {
  Eigen::MatrixXd q(model.n_q(), static_cast<Eigen::Index>(times.size()));
  for (Eigen::Index k = 0; k < q.cols(); ++k) interpolate(model, trajectory, offset + times[static_cast<std::size_t>(k)], q.col(k));
  return q;
}

/// Samples [first, first + count) of a run within a time span, ends included.
struct Span {
  Eigen::Index first = 0, count = 0;
};
Span samples_between(const std::vector<double>& times, double begin, double end) {
  constexpr double slack = 1e-9;
  const auto from = std::lower_bound(times.begin(), times.end(), begin - slack);
  const auto to = std::upper_bound(times.begin(), times.end(), end + slack);
  return {from - times.begin(), std::max<std::ptrdiff_t>(0, to - from)};
}

class Transfer {
 public:
  Transfer(const std::shared_ptr<const simulation::Plant>& plant, const planning::Plan& plan, const TransferOptions& options,
           const core::RunControl& control, TransferResult& out, const planning::Plan* predicted)
      : plant_(plant), model_(plant->model()), plan_(plan), options_(options), control_(control), out_(out) {
    trajectory_ = in_time(plan);
    compared_ = predicted != nullptr ? retime(in_time(*predicted), trajectory_) : trajectory_;
  }

  Status run() {
    Status status = options_.whole ? run_whole() : Status::Solved;
    report_pieces();
    if (options_.whole) judge(status);
    if (options_.alone && !control_.stop()) run_alone();
    if (status == Status::Solved && control_.cancelled()) status = Status::Cancelled;
    if (status == Status::Solved && control_.expired()) status = Status::MaxIterations;
    return status;
  }

 private:
  simulation::SimulationOptions run_options() const {
    return {.record_interval = options_.record_interval, .control = &control_, .stop = {}};
  }
  Trajectory in_time(const planning::Plan& plan) const {
    if (options_.uniform) return make_trajectory(model_, plan, *options_.uniform);
    return make_trajectory(model_, plan, options_.speed, options_.pause);
  }
  double time_of(Eigen::Index knot) const { return trajectory_.times[knot]; }

  /// Simulates the trajectory, then holds its last command.
  Status run_whole() {
    const Eigen::Index n = trajectory_.times.size();
    Eigen::VectorXd times(n + 1);
    Eigen::MatrixXd u(model_.n_a(), n + 1);
    times << trajectory_.times, trajectory_.duration() + std::max(options_.hold, 1e-6);
    u << trajectory_.u, trajectory_.u.col(n - 1);
    simulation::Workspace work(plant_);
    simulation::SimulationResult r;
    simulation::SimulationOptions options = run_options();
    options.stop = [this](double t, VectorRef q) { return is_off(t, q); };
    const Status status = simulation::simulate(*plant_, {start(), times, u, nullptr}, options, work, r);
    out_.message = r.message;
    out_.max_depth = r.max_depth;
    out_.steps = r.steps;
    out_.duration_s = r.times.empty() ? 0.0 : r.times.back();
    out_.times = std::move(r.times);
    out_.q = std::move(r.q);
    out_.forces = std::move(r.forces);
    out_.torque = std::move(r.torque);
    out_.q_plan = plan_at(model_, compared_, 0, out_.times);
    return status;
  }

  Eigen::VectorXd start() const {
    Eigen::VectorXd q = trajectory_.q.col(0);
    if (options_.start_error.size() == 0) return q;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(model_.n_v());
    delta.head(model_.n_vu()) = options_.start_error;
    world::retract(model_, Eigen::VectorXd(q), delta, q);
    // A non-owning pointer: the plant owns the model during this call.
    return part_start(std::shared_ptr<const Model>(&model_, [](const Model*) {}), q, plan_.step).q;
  }

  void report_pieces() {
    out_.piece.assign(out_.times.size(), static_cast<int>(trajectory_.pieces.size()) - 1);
    for (std::size_t i = trajectory_.pieces.size(); i-- > 0;) {
      const double end = time_of(trajectory_.pieces[i].last_knot);
      for (std::size_t k = 0; k < out_.times.size() && out_.times[k] <= end; ++k) out_.piece[k] = static_cast<int>(i);
    }
    for (std::size_t i = 0; i < trajectory_.pieces.size(); ++i) {
      const Piece& piece = trajectory_.pieces[i];
      const double begin = time_of(piece.first_knot), end = time_of(piece.last_knot);
      PieceReport& report = out_.pieces.emplace_back();
      report.kind = piece.kind;
      report.first_segment = piece.first_segment;
      report.last_segment = piece.last_segment;
      report.begin_s = begin;
      report.end_s = end;
      if (!options_.whole || out_.times.empty() || out_.times.back() < end) continue;  // the run stopped before the end of this piece
      const Span span = samples_between(out_.times, begin, end);
      report.in_plan = measure_samples(i, span, as_vector(out_.times), out_.q_plan, out_.q);
    }
  }

  PieceError measure_samples(std::size_t i, Span span, VectorRef times, const Eigen::MatrixXd& q_plan, const Eigen::MatrixXd& q) const {
    const Piece& piece = compared_.pieces[i];
    return measure(model_, plan_.goal.object, times.segment(span.first, span.count), q_plan.middleCols(span.first, span.count),
                   q.middleCols(span.first, span.count), compared_.q.middleCols(piece.first_knot, piece.last_knot - piece.first_knot + 1));
  }

  void judge(Status status) {
    if (out_.times.empty()) return;
    out_.error = planning::goal_error(model_, out_.q.col(out_.q.cols() - 1), plan_.goal);
    out_.reached = status == Status::Solved && !out_.dropped && !out_.lost && out_.error.within(plan_.goal);
  }

  /// True if an object is lost or dropped, so that the plan can no longer succeed.
  bool is_off(double t, VectorRef q) {
    const Eigen::Vector3d gravity = model_.scene().gravity;
    const bool looks_for_lost = std::isfinite(options_.lost_factor);
    if (gravity.norm() == 0 && !looks_for_lost) return false;
    Eigen::VectorXd planned(model_.n_q());
    interpolate(model_, trajectory_, t, planned);
    if (looks_for_lost) {
      const Distance error = distance(model_, plan_.goal.object, planned, q);
      out_.lost = planning::GoalError{error.position, error.angle}.share(plan_.goal) > options_.lost_factor;
    }
    return out_.lost || (gravity.norm() > 0 && falls(t, planned, q, gravity.normalized()));
  }

  /// True if a free object is far below its planned place, now and later in the same piece. An object that only comes down early is not dropped.
  bool falls(double t, const Eigen::VectorXd& planned, VectorRef q, const Eigen::Vector3d& down) {
    for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
      if (model_.scene().objects[static_cast<std::size_t>(i)].joint != world::ObjectJoint::Free) continue;
      const double depth = world::object_pose(model_, q, i).p.dot(down) - options_.fall * model_.scales().object(i).length;
      if (depth < world::object_pose(model_, planned, i).p.dot(down) || comes_down_to(depth, i, t, down)) continue;
      out_.dropped = i;
      out_.dropped_s = t;
      return true;
    }
    return false;
  }

  /// True if the plan has an object deeper than depth [m] between t and the end of the piece; false in a pause.
  bool comes_down_to(double depth, int object, double t, const Eigen::Vector3d& down) const {
    const auto piece =
        std::find_if(trajectory_.pieces.begin(), trajectory_.pieces.end(), [&](const Piece& p) { return t < time_of(p.last_knot); });
    if (piece == trajectory_.pieces.end() || t < time_of(piece->first_knot)) return false;
    for (Eigen::Index k = piece->last_knot; time_of(k) > t; --k) {
      if (world::object_pose(model_, trajectory_.q.col(k), object).p.dot(down) > depth) return true;
    }
    return false;
  }

  /// Simulates each pushing piece alone, from rest in its planned start.
  void run_alone() {
    std::vector<std::size_t> pushes;
    for (std::size_t i = 0; i < out_.pieces.size(); ++i) {
      if (out_.pieces[i].kind == SegmentKind::Contact) pushes.push_back(i);
    }
    core::ThreadPool pool(options_.threads > 0 ? options_.threads : core::hardware_threads());
    std::vector<simulation::Workspace> workspaces;
    for (int i = 0; i < pool.size(); ++i) workspaces.emplace_back(plant_);
    std::vector<long> steps(pushes.size(), 0);
    pool.run(static_cast<int>(pushes.size()), [&](int item, int worker) {
      const std::size_t i = pushes[static_cast<std::size_t>(item)];
      const Piece& piece = trajectory_.pieces[i];
      const Eigen::Index first = piece.first_knot, n = piece.last_knot - first + 1;
      const Eigen::VectorXd times = trajectory_.times.segment(first, n).array() - time_of(first);
      simulation::SimulationResult r;
      const Status status = simulation::simulate(*plant_, {trajectory_.q.col(first), times, trajectory_.u.middleCols(first, n), nullptr},
                                                 run_options(), workspaces[static_cast<std::size_t>(worker)], r);
      steps[static_cast<std::size_t>(item)] = r.steps;
      if (status != Status::Solved) return;  // `alone` stays empty
      const Eigen::MatrixXd q_plan = plan_at(model_, compared_, time_of(first), r.times);
      out_.pieces[i].alone = measure_samples(i, {0, r.q.cols()}, as_vector(r.times), q_plan, r.q);
    });
    for (const long n : steps) out_.steps += n;
  }

  const std::shared_ptr<const simulation::Plant>& plant_;
  const Model& model_;
  const planning::Plan& plan_;
  const TransferOptions& options_;
  const core::RunControl& control_;
  TransferResult& out_;
  Trajectory trajectory_;  ///< commands of the run
  Trajectory compared_;    ///< states with which the run is compared
};

std::optional<double> ratio(double mean, double length, double least) {
  if (length < least) return std::nullopt;
  return mean / length;
}

}  // namespace

void TransferOptions::validate() const {
  core::require_positive("speed", speed);
  core::require_nonnegative("pause", pause);
  if (uniform) uniform->validate();
  core::require_nonnegative("hold", hold);
  core::require_positive("fall", fall);
  if (!(lost_factor > 0)) core::throw_invalid("lost_factor", fmt::format("{:g}", lost_factor), "a number > 0");
  core::require_positive("record_interval", record_interval);
  if (threads < 0) core::throw_invalid("threads", std::to_string(threads), "0 (all cores) or more");
}

std::optional<double> PieceError::normalised_position() const { return ratio(mean_position, length_position, least_position); }
std::optional<double> PieceError::normalised_angle() const { return ratio(mean_angle, length_angle, kLeastAngle); }

PieceError measure(const Model& model, int object, VectorRef times, Eigen::Ref<const Eigen::MatrixXd> q_plan,
                   Eigen::Ref<const Eigen::MatrixXd> q_sim, Eigen::Ref<const Eigen::MatrixXd> path) {
  core::require_size("q_plan.cols", q_plan.cols(), times.size());
  core::require_size("q_sim.cols", q_sim.cols(), times.size());
  PieceError out;
  out.least_position = world::share::kMotionless * model.scales().object(object).length;
  const Eigen::Index n = times.size();
  if (n == 0) return out;
  Distance before{0, 0};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Distance d = distance(model, object, q_plan.col(k), q_sim.col(k));
    if (k == 0) {
      out.start_position = d.position;
      out.start_angle = d.angle;
    } else {
      const double dt = times[k] - times[k - 1];
      out.mean_position += 0.5 * dt * (before.position + d.position);
      out.mean_angle += 0.5 * dt * (before.angle + d.angle);
    }
    before = d;
  }
  out.end_position = before.position;
  out.end_angle = before.angle;
  const double duration = times[n - 1] - times[0];
  out.mean_position = duration > 0 ? out.mean_position / duration : before.position;
  out.mean_angle = duration > 0 ? out.mean_angle / duration : before.angle;
  for (Eigen::Index k = 1; k < path.cols(); ++k) {
    const Distance d = distance(model, object, path.col(k - 1), path.col(k));
    out.length_position += d.position;
    out.length_angle += d.angle;
  }
  return out;
}

Status transfer(const std::shared_ptr<const simulation::Plant>& plant, const planning::Plan& plan, const TransferOptions& options,
                const core::RunControl& control, TransferResult& out, const planning::Plan* predicted) {
  const auto start = core::RunControl::Clock::now();
  if (!plant) core::throw_invalid("plant", "nothing", "a plant");
  options.validate();
  if (options.start_error.size() > 0) {
    core::require_size("start_error", options.start_error.size(), plant->model().n_vu());
    core::require_finite("start_error", std::span(options.start_error.data(), static_cast<std::size_t>(options.start_error.size())));
  }
  if (plan.goal.object < 0 || plan.goal.object >= static_cast<int>(plant->model().objects().size()))
    core::throw_invalid("plan.goal.object", std::to_string(plan.goal.object), "the index of an object");
  out = TransferResult{};
  out.status = Transfer(plant, plan, options, control, out, predicted).run();
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::execution
