// Commands in contact: random ticks as the tests make them, judged from raw data, and the time of a tick of a 7-joint arm.
// control_bench [TICKS]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "control/random_tick.hpp"

using namespace stiction;
using control::test::RandomTick;

namespace {

struct Judgement {
  int failed = 0, at_bound = 0, conflicts = 0, most_iterations = 0;
  double worst_kkt = 0, worst_bound = 0;
};

/// Bounds, multipliers and cost of every tick, recomputed.
Judgement judge(int ticks) {
  core::Random random(2026, 0);
  control::ContactQpWorkspace work;
  control::ContactQpResult out;
  Judgement all;
  for (int k = 0; k < ticks; ++k) {
    const RandomTick t = control::test::random_tick(random);
    control::ContactQpOptions options;
    options.cost = k % 3 == 0 ? control::TrackingCost::Equilibrium : control::TrackingCost::Command;
    options.unilateral = !t.of_task;  // the residual knows (5.30) of joint references
    if (control::solve_contact_qp(t.robot, t.input(), options, work, out) != core::Status::Solved) ++all.failed;
    all.worst_kkt = std::max(all.worst_kkt, control::test::kkt_residual(t, options, out, work.solution));
    all.most_iterations = std::max(all.most_iterations, out.iterations);
    if (t.J_u.rows() == 0) continue;
    all.at_bound += (out.lambda - t.lambda_max).maxCoeff() > -1e-6 * t.lambda_max.maxCoeff();
    all.conflicts += out.slack.maxCoeff() > 1e-3 * t.lambda_max.maxCoeff();
    all.worst_bound = std::max(all.worst_bound, ((out.lambda - t.lambda_max - out.slack).array() / t.lambda_max.array()).maxCoeff());
  }
  return all;
}

/// Median and 99th percentile of a solve with 7 joints and m contacts whose bounds are felt [s].
void time_solves(int m) {
  core::Random random(7, static_cast<std::uint64_t>(m));
  std::vector<RandomTick> ticks;
  while (ticks.size() < 200) {
    RandomTick t = control::test::random_tick(random);
    if (t.q.size() == 7 && t.J_u.rows() == m && !t.of_task) ticks.push_back(std::move(t));
  }
  control::ContactQpWorkspace work;
  work.reserve(7, m);
  control::ContactQpResult out;
  std::vector<double> seconds;
  for (int repeat = 0; repeat < 100; ++repeat)
    for (const RandomTick& t : ticks) {
      const control::ContactQpInput in = t.input();
      control::ContactQpOptions options;
      options.unilateral = m != 1;  // one row: the closed form
      const auto start = std::chrono::steady_clock::now();
      if (control::solve_contact_qp(t.robot, in, options, work, out) != core::Status::Solved) std::abort();
      seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
  std::sort(seconds.begin(), seconds.end());
  std::printf("7 joints, %d contact%s: median %.2f us, p99 %.2f us\n", m, m == 1 ? " " : "s", 1e6 * seconds[seconds.size() / 2],
              1e6 * seconds[seconds.size() * 99 / 100]);
}

}  // namespace

int main(int argc, char** argv) {
  const int ticks = argc > 1 ? std::atoi(argv[1]) : 100000;
  const Judgement all = judge(ticks);
  std::printf("%d random ticks: %d failed, KKT residual at most %.1e, force above bound and slack at most %.1e of the bound\n", ticks,
              all.failed, all.worst_kkt, all.worst_bound);
  std::printf("at a bound %d, bound given up %d, at most %d changes of the active set\n", all.at_bound, all.conflicts, all.most_iterations);
  for (const int m : {1, 3}) time_solves(m);
  return all.failed == 0 && all.worst_kkt <= 1e-8 ? 0 : 1;
}
