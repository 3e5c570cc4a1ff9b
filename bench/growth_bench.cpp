// Cost of an iteration of the planner against the size of its tree, and the memory of that tree: growth_bench TASK… [--nodes N]
#include <fmt/format.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "stiction/tasks/task.hpp"

int main(int argc, char** argv) {
  using namespace stiction;
  using Clock = std::chrono::steady_clock;
  long nodes = 100000;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--nodes" && i + 1 < argc)
      nodes = std::atol(argv[++i]);
    else
      names.emplace_back(argv[i]);
  }
  for (const std::string& name : names) {
    tasks::Task task = tasks::load_task(name);
    task.options.thesis.emplace().stop_at_goal = false;
    task.options.max_iterations = 100 * static_cast<int>(nodes);
    task.options.threads = 1;
    core::RunControl control;
    std::atomic<bool> enough = false;
    control.cancel = &enough;
    bool three = false;  // thresholds 100, 300, 1000, 3000, …
    auto last = Clock::now();
    long last_iteration = 0, next = 100, last_nodes = 0;
    control.on_progress = [&](const core::Progress& p) {
      if (p.size < next) return;
      const auto now = Clock::now();
      const double us = std::chrono::duration<double, std::micro>(now - last).count();
      rusage usage{};
      getrusage(RUSAGE_SELF, &usage);
      fmt::print("{:<28} {:>7} … {:>7} nodes  {:8.1f} us per iteration  {:5} MB\n", name, last_nodes, p.size,
                 us / static_cast<double>(p.iteration - last_iteration), usage.ru_maxrss / 1024);
      std::fflush(stdout);
      last = now;
      last_iteration = p.iteration;
      last_nodes = p.size;
      next = three ? next / 3 * 10 : next * 3;
      three = !three;
      if (p.size >= nodes) enough = true;
    };
    planning::PlanResult result;
    (void)planning::plan(task.problem, task.options, control, result);
  }
  return 0;
}
