#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/version.hpp"

namespace {

using namespace stiction;

/// One clear message on stderr and, with --json, one object on stdout.
int fail(bool json, std::string_view status, std::string_view message) {
  fmt::print(stderr, "stiction: {}\n", message);
  if (json) {
    nlohmann::ordered_json out;
    out["status"] = status;
    out["message"] = message;
    fmt::print("{}\n", out.dump());
  }
  return app::kBadInput;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli("Plans robot motion through contact.", "stiction");
  cli.set_version_flag("--version", std::string("stiction ") + std::string(core::version()));
  cli.require_subcommand(1);
  cli.footer("Exit codes: 0 done, 1 a check failed, 2 bad input, 3 not solved within the budget (best plan kept), 130 interrupted (same).");

  bool tasks_json = false;
  auto* tasks = cli.add_subcommand("tasks", "Built-in tasks with their sizes");
  tasks->add_flag("--json", tasks_json, "One JSON object on stdout");

  const CLI::Validator whole_number(
      [](std::string& text) {
        const bool good = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        return good ? std::string() : fmt::format("got '{}', expected an integer ≥ 0", text);
      },
      "", "whole_number");

  app::PlanArguments plan_arguments;
  auto* plan = cli.add_subcommand("plan", "Plans a task and writes the plan file");
  plan->add_option("task", plan_arguments.task, "Name of a built-in task, or a task file (.yaml)")->required();
  auto* seed = plan->add_option("--seed", plan_arguments.seed, "Seed; the same seed gives the same plan")->check(whole_number);
  plan->add_option("--goal", plan_arguments.goal,
                   "Goal pose in place of that of the task: \"x y z roll pitch yaw\" [m, rad], or coordinates; ~ for any value")
      ->expected(1);
  plan->add_option("--timeout", plan_arguments.timeout_s, "Wall-clock budget [s]")->capture_default_str()->check(CLI::PositiveNumber);
  auto* threads = plan->add_option("--threads", plan_arguments.threads, "Threads, 0 = all cores; the plan does not depend on it")
                      ->check(CLI::Range(0, 1024));
  plan->add_option("--scheme", plan_arguments.scheme, "Local models: exact, analytic, randomized-first, randomized-zeroth");
  plan->add_option("-o,--out", plan_arguments.out_dir, "Folder for the results (default ./TASK-seedN)");
  plan->add_flag("--anytime", plan_arguments.anytime, "Go on after the first plan, for cheaper ones, until the budget is used up");
  plan->add_flag("--html", plan_arguments.html, "Also write a page to look at, plan.html");
  plan->add_flag("--json", plan_arguments.json, "One JSON object on stdout");

  app::OptimizeArguments optimize_arguments;
  auto* optimize = cli.add_subcommand("optimize", "Optimises a trajectory for a task (iMPC) and writes it as a plan");
  optimize->add_option("task", optimize_arguments.task, "Name of a built-in task, or a task file (.yaml), with a section 'optimize'")
      ->required();
  optimize->add_option("--scheme", optimize_arguments.scheme, "Local models: exact, analytic, randomized-first, randomized-zeroth");
  optimize->add_option("--solver", optimize_arguments.solver, "sweep (one QP per iteration) or receding (Alg. 1 as published)");
  optimize->add_flag("--forces", optimize_arguments.forces, "Contact trust region: linear contact forces stay in their cones");
  auto* optimize_seed = optimize->add_option("--seed", optimize_arguments.seed, "Seed of the randomised schemes")->check(whole_number);
  optimize->add_option("--iterations", optimize_arguments.iterations, "Iterations in place of those of the task")
      ->check(CLI::Range(1, 1000000));
  optimize->add_option("--timeout", optimize_arguments.timeout_s, "Wall-clock budget [s]")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  auto* optimize_threads =
      optimize->add_option("--threads", optimize_arguments.threads, "Threads, 0 = all cores; the result does not depend on it")
          ->check(CLI::Range(0, 1024));
  optimize->add_option("-o,--out", optimize_arguments.out_dir, "Folder for plan.json and optimize.json (default ./TASK)");
  optimize->add_flag("--json", optimize_arguments.json, "One JSON object on stdout");

  app::CheckArguments check_arguments;
  auto* check = cli.add_subcommand("check", "Re-simulates a plan at half its sub-step and judges it");
  check->add_option("plan", check_arguments.plan, "Plan file, or its folder")->required();
  check->add_flag("--json", check_arguments.json, "One JSON object on stdout");

  app::SimulateArguments simulate_arguments;
  auto* simulate = cli.add_subcommand("simulate", "Runs a plan open loop in MuJoCo and compares it with what the plan says");
  simulate->add_option("plan", simulate_arguments.plan, "Plan file, or its folder")->required();
  simulate->add_option("-o,--out", simulate_arguments.out_dir, "Folder for simulation.json and the page (default: that of the plan)");
  simulate->add_option("--speed", simulate_arguments.speed, "Joint speeds, times 0.1 rad/s and 0.0125 m/s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  simulate->add_option("--pause", simulate_arguments.pause_s, "Commands rest this long between pieces [s]")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  simulate
      ->add_option("--load-time", simulate_arguments.load_time_s,
                   "Time in which joint springs take up or let go the weight of the lightest object [s]; 0: as fast as comes")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  simulate
      ->add_option("--sub-steps", simulate_arguments.substeps,
                   "Predict every edge in this many steps before comparing; 1 as in the thesis (default: as the plan does)")
      ->check(CLI::Range(1, 10000));
  simulate->add_option("--rest-time", simulate_arguments.rest_time_s, "Time in which objects on joints come to rest [s]")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  simulate->add_option("--friction", simulate_arguments.friction_scale, "Multiplies every coefficient of friction of the simulation")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  simulate->add_flag(
      "!--no-velocity-reference", simulate_arguments.velocity_reference,
      "Damping acts on the velocity of a joint, not on what it differs by from that of its command: joints lag behind, as in the thesis");
  simulate->add_flag("--whole-only", simulate_arguments.whole_only, "Only the whole plan, not every push by itself");
  simulate->add_option("--threads", simulate_arguments.threads, "Threads, 0 = all cores; the result does not depend on it")
      ->check(CLI::Range(0, 1024));
  simulate->add_flag("--html", simulate_arguments.html, "Also write a page to look at, simulation.html");
  simulate->add_flag("--json", simulate_arguments.json, "One JSON object on stdout");

  app::RefineArguments refine_arguments;
  auto* refine = cli.add_subcommand("refine", "Shortens a plan and gives its regrasps room; writes a new plan and timed commands");
  refine->add_option("plan", refine_arguments.plan, "Plan file, or its folder")->required();
  refine->add_option("-o,--out", refine_arguments.out_dir,
                     "Folder for plan.json and trajectory.csv (default: the folder `refined` beside the plan)");
  refine->add_option("--timeout", refine_arguments.timeout_s, "Wall-clock budget [s]")->capture_default_str()->check(CLI::PositiveNumber);
  refine->add_option("--speed", refine_arguments.speed, "Joint speeds of trajectory.csv, times 0.1 rad/s and 0.0125 m/s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  refine->add_flag("--html", refine_arguments.html, "Also write a page to look at, plan.html");
  refine->add_flag("--json", refine_arguments.json, "One JSON object on stdout");

  app::SolveArguments solve_arguments;
  auto* solve = cli.add_subcommand("solve", "Plans, refines and simulates, seed after seed, until a plan reaches its goal in MuJoCo");
  solve->add_option("task", solve_arguments.task, "Name of a built-in task, or a task file (.yaml)")->required();
  auto* solve_seed = solve->add_option("--seed", solve_arguments.seed, "Seed of the first try")->check(whole_number);
  solve->add_option("--goal", solve_arguments.goal, "Goal pose in place of that of the task, as for `plan`")->expected(1);
  solve->add_option("--tries", solve_arguments.tries, "Seeds that are tried")->capture_default_str()->check(CLI::Range(1, 1000000));
  solve->add_option("--timeout", solve_arguments.timeout_s, "Wall-clock budget of all tries [s]")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  solve
      ->add_option("--friction", solve_arguments.friction,
                   "The goal has to be reached with every coefficient of friction times each of these numbers")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  solve->add_option("--speed", solve_arguments.speed, "Joint speeds, times 0.1 rad/s and 0.0125 m/s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  auto* solve_threads = solve->add_option("--threads", solve_arguments.threads, "Threads, 0 = all cores; the plan does not depend on it")
                            ->check(CLI::Range(0, 1024));
  solve->add_option("-o,--out", solve_arguments.out_dir, "Folder for plan.json and trajectory.csv (default ./TASK-solved)");
  solve->add_flag("--json", solve_arguments.json, "One JSON object on stdout");

  app::ViewArguments view_arguments;
  auto* view = cli.add_subcommand("view", "Shows a plan in the browser");
  view->add_option("plan", view_arguments.plan, "Plan file, or its folder")->required();
  view->add_option("--html", view_arguments.html, "Write one self-contained page instead of starting a server");

  app::BenchArguments bench_arguments;
  auto* bench = cli.add_subcommand("bench", "Figures of this machine beside the published ones");
  bench->add_flag("--json", bench_arguments.json, "One JSON object on stdout");
  bench->add_option("--filter", bench_arguments.filter, "Only the rows whose name contains this");
  bench->add_option("--repeat", bench_arguments.repeat, "Repetitions of each timing")->capture_default_str()->check(CLI::Range(1, 1000));

  std::string experiments;
  for (const auto& name : app::list_experiments()) experiments += (experiments.empty() ? "" : ", ") + name;
  app::ReproduceArguments reproduce_arguments;
  auto* reproduce = cli.add_subcommand("reproduce", "Computes figures and tables of the thesis, beside the published numbers");
  reproduce->add_option("name", reproduce_arguments.name, fmt::format("One of {}, or 'all'", experiments))->required();
  reproduce->add_option("-o,--out", reproduce_arguments.out_dir, "Folder for data, pictures and report.html")->capture_default_str();
  reproduce->add_flag("--quick", reproduce_arguments.quick, "Fewer and coarser points, in seconds");
  reproduce->add_option("--docs", reproduce_arguments.docs, "Also write this Markdown page, its pictures beside it");
  reproduce->add_flag("--json", reproduce_arguments.json, "One JSON object on stdout");

  try {
    if (argc > 1 && argv[1][0] != '-') {
      std::string names;
      bool known = false;
      for (const auto* command : cli.get_subcommands({})) {
        known = known || command->get_name() == argv[1];
        names += (names.empty() ? "" : ", ") + command->get_name();
      }
      if (!known) throw CLI::ValidationError("command", fmt::format("got '{}', expected one of {}", argv[1], names));
    }
    cli.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return cli.exit(e);
  } catch (const CLI::ParseError& e) {
    bool json = false;
    for (int i = 1; i < argc; ++i) json = json || std::string_view(argv[i]) == "--json";
    return fail(json, "InvalidInput", std::string(e.what()) + "; `stiction --help` and `stiction COMMAND --help` say what there is");
  }
  plan_arguments.seed_given = seed->count() > 0;
  plan_arguments.threads_given = threads->count() > 0;
  solve_arguments.seed_given = solve_seed->count() > 0;
  solve_arguments.threads_given = solve_threads->count() > 0;
  optimize_arguments.seed_given = optimize_seed->count() > 0;
  optimize_arguments.threads_given = optimize_threads->count() > 0;

  const bool json = tasks_json || plan_arguments.json || optimize_arguments.json || check_arguments.json || simulate_arguments.json ||
                    refine_arguments.json || solve_arguments.json || bench_arguments.json || reproduce_arguments.json;
  try {
    if (*tasks) return app::run_tasks(tasks_json);
    if (*plan) return app::run_plan(plan_arguments);
    if (*optimize) return app::run_optimize(optimize_arguments);
    if (*check) return app::run_check(check_arguments);
    if (*simulate) return app::run_simulate(simulate_arguments);
    if (*refine) return app::run_refine(refine_arguments);
    if (*solve) return app::run_solve(solve_arguments);
    if (*view) return app::run_view(view_arguments);
    if (*reproduce) return app::run_reproduce(reproduce_arguments);
    return app::run_bench(bench_arguments);
  } catch (const core::InvalidInput& e) {
    return fail(json, "InvalidInput", e.what());
  } catch (const std::exception& e) {
    return fail(json, "Error", e.what());
  }
}
