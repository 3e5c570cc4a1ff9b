#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "bench_table.hpp"
#include "cone_allocations.hpp"
#include "contact_ticks.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/read.hpp"

namespace stiction::app {
namespace {

constexpr int kTicks = 200;
constexpr int kLoops = 20;           // over all of them, per repetition
constexpr double kPeriod_s = 0.005;  // of the controller, thesis section 5.6
constexpr double kSpeed = 1.5;       // of commands [rad/s]

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

/// A solve of (C.10) of 7 joints. Peer: ProxQP, the same program with hard bounds, in the same run.
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
  auto peer = bench::time_general_qp(robot, ticks, options, table.repeat());
  std::optional<double> peer_s;
  if (peer) peer_s = core::quantile(peer->seconds, 0.5);
  Row row = make_row(name, std::move(seconds), {{}, peer_s}, allocations, failures);
  row.contacts = contacts;
  table.add(std::move(row));
  if (peer) table.add(make_row(name + "/proxqp", std::move(peer->seconds), {}, {}, peer->unsolved));
}

}  // namespace

void add_control_rows(BenchTable& table) {
  contact_qp(table, 1);
  contact_qp(table, 3);
}

}  // namespace stiction::app
