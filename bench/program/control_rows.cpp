#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cone_allocations.hpp"
#include "contact_ticks.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/core/random.hpp"
#include "stiction/execution/contact_control/contact_estimator.hpp"
#include "stiction/sensing/known_contacts.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/read.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

constexpr int kTicks = 200;
constexpr int kLoops = 20;           // over all of them, per repetition
constexpr double kPeriod_s = 0.005;  // of the controller, thesis section 5.6
constexpr double kSpeed = 1.5;       // of commands [rad/s]
constexpr int kTouchTicks = 400;     // of a touch: the second and third quarter in contact
constexpr int kTouches = 8;          // places
constexpr double kForce = 15;        // [N]
constexpr double kNoise = 0.05;      // of torques [N m]

/// An iiwa 7 with the stiffness of section 5.6.
std::shared_ptr<const world::Model> make_arm(const std::filesystem::path& models_dir) {
  return world::Model::make(world::parse_scene(R"(
robots:
  - name: arm
    urdf: iiwa_primitives.urdf
    stiffness: {joint_1: 800, joint_2: 600, joint_3: 600, joint_4: 600, joint_5: 400, joint_6: 200, joint_7: 200}
)",
                                               models_dir, tasks::default_package_dirs()));
}

control::RobotLimits make_limits(const world::Model& model) {
  const Eigen::Index n = model.n_a();
  control::RobotLimits out;
  out.stiffness = model.stiffness();
  out.rate.setConstant(n, kPeriod_s * kSpeed);
  out.lower = model.lower();
  out.upper = model.upper();
  out.torque.setConstant(n, std::numeric_limits<double>::infinity());
  return out;
}

/// A solve of (C.10) of 7 joints. Peers: general solvers, the same program with hard bounds, in the same run; the first of them stands beside ours.
void contact_qp(BenchTable& table, int contacts) {
  const std::string name = fmt::format("contact_qp/{}_contact{}", contacts, contacts == 1 ? "" : "s");
  if (!table.wanted(name)) return;
  const auto model = make_arm(table.models_dir());
  const control::RobotLimits robot = make_limits(*model);
  const auto ticks = bench::make_contact_ticks(*model, robot, contacts, kTicks, 0);
  const control::ContactQpOptions options;
  control::ContactQpWorkspace work;
  work.reserve(model->n_a(), contacts);
  control::ContactQpResult out;
  std::vector<double> seconds;
  const int loops = kLoops * table.repeat();
  seconds.reserve(static_cast<std::size_t>(loops * kTicks));
  int failures = 0;
  long allocations = 0;
  for (int r = 0; r < loops && !interrupted(); ++r)
    for (const bench::ContactTick& tick : ticks) {
      const control::ContactQpInput in = tick.input();
      const long before = bench::allocations();
      const auto start = BenchClock::now();
      const core::Status status = control::solve_contact_qp(robot, in, options, work, out);
      seconds.push_back(seconds_since(start));
      if (r > 0) allocations = std::max(allocations, bench::allocations() - before);
      if (r == 0) failures += status != core::Status::Solved;
    }
  if (seconds.empty()) return;
  auto peers = bench::time_general_qps(robot, ticks, options, table.repeat());
  std::optional<double> peer_s;
  if (!peers.empty()) peer_s = core::quantile(peers.front().seconds, 0.5);
  Row row = make_row(name, std::move(seconds), {{}, peer_s}, allocations, failures);
  row.contacts = contacts;
  table.add(std::move(row));
  for (bench::GeneralQp& peer : peers) table.add(make_row(name + "/" + peer.name, std::move(peer.seconds), {}, {}, peer.unsolved));
}

/// Joints and external torques of an arm that moves while it is touched now and then, in `contacts` places at once.
struct Touches {
  std::shared_ptr<const world::Model> model;
  std::vector<Eigen::VectorXd> q, tau;
};

Touches make_touches(const std::filesystem::path& models_dir, int contacts) {
  Touches out;
  out.model = make_arm(models_dir);
  const auto sensor = sensing::Sensor::make(out.model);
  core::Random random(0, 0);
  const Eigen::VectorXd middle{{0, 0.6, 0, -1.4, 0, 1.1, 0}};
  for (int touch = 0; touch < kTouches; ++touch) {
    const auto links = static_cast<int>(sensor->links().size());
    std::vector<sensing::ContactPoint> places;
    for (int c = 0; c < contacts; ++c) {
      const int index = links - 1 - (touch + 2 * c) % (contacts == 1 ? 3 : 4);
      const sensing::SensedLink& link = sensor->links()[static_cast<std::size_t>(index)];
      const sensing::SurfacePoint& point = link.samples[static_cast<std::size_t>(random.index(static_cast<int>(link.samples.size())))];
      places.push_back(
          {.link = index, .p_L = point.p_L, .f_L = -kForce * link.surface.normal(point.triangle, point.p_L, sensing::Normals::Flat)});
    }
    for (int k = 0; k < kTouchTicks; ++k) {
      const double turn = 2 * std::numbers::pi * k / kTouchTicks;
      Eigen::VectorXd q = middle;
      for (Eigen::Index j = 0; j < q.size(); ++j) q[j] += 0.1 * std::sin(turn + static_cast<double>(j));
      const bool touched = k >= kTouchTicks / 4 && k < 3 * kTouchTicks / 4;
      Eigen::VectorXd tau = Eigen::VectorXd::Zero(q.size());
      for (const sensing::ContactPoint& place : places)
        if (touched)
          tau += sensing::calc_contact_torque(*out.model, sensing::place_robots(*out.model, q),
                                              sensor->links()[static_cast<std::size_t>(place.link)].surface.body, place.p_L, place.f_L);
      for (double& t : tau) t += kNoise * random.normal();
      out.q.push_back(q), out.tau.push_back(tau);
    }
  }
  return out;
}

/// An update of the contacts of a control loop, of ticks in contact; their 99th percentile has those in which a touch begins.
void contact_estimates(BenchTable& table, int contacts) {
  const std::string name = contacts == 1 ? "contact_estimate/7_joints" : fmt::format("contact_estimate/7_joints/{}_contacts", contacts);
  if (!table.wanted(name)) return;
  const Touches touches = make_touches(table.models_dir(), contacts);
  execution::ContactEstimatorOptions options;
  options.noise = kNoise;
  execution::ContactEstimator estimator(touches.model, options);
  std::vector<double> seconds;
  long allocations = 0;
  for (int r = 0; r < table.repeat() && !interrupted(); ++r)
    for (std::size_t k = 0; k < touches.q.size(); ++k) {
      const long before = bench::allocations();
      const auto start = BenchClock::now();
      const auto told = estimator.update(touches.q[k], touches.tau[k], touches.q[k], kPeriod_s);
      const double elapsed = seconds_since(start);
      if (told.empty()) continue;
      seconds.push_back(elapsed);
      if (r > 0) allocations = std::max(allocations, bench::allocations() - before);
    }
  if (!seconds.empty()) table.add(make_row(name, std::move(seconds), {}, allocations, 0));
}

}  // namespace

void add_control_rows(BenchTable& table) {
  contact_qp(table, 1);
  contact_qp(table, 3);
  contact_estimates(table, 1);
  contact_estimates(table, 2);
}

}  // namespace stiction::app
