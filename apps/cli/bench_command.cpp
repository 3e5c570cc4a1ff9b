#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "app.hpp"
#include "bench_scenes.hpp"
#include "commit.hpp"
#include "cone_allocations.hpp"
#include "cone_problems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/trajopt/optimize.hpp"

namespace stiction::app {
namespace {

using core::Status;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// Figures of others [s]. Published: T. Pang, PhD thesis, MIT 2023, Table 3.1 (10 iterations) and Table 3.2 (1000 iterations, analytic smoothing, 16 cores) and
/// section 2.3 (69 coordinates with a commercial cone solver: below 10 ms). Peer: the thesis's research code (quasistatic_simulator
/// c917755, planning_through_contact 74e4559, Drake 1.26 with Clarabel) measured on two cores of an AMD EPYC, medians.
struct Reference {
  std::optional<double> published, peer;
};
struct TaskReference {
  const char* task;
  Reference exact_B, smoothed_B, smoothed_AB;
};
constexpr TaskReference kSteps[] = {
    {"planar_pushing", {{}, 0.15e-3}, {{}, 0.18e-3}, {}},
    {"planar_hand", {{}, 0.64e-3}, {{}, 0.75e-3}, {}},
    {"allegro_ball", {{}, 0.90e-3}, {{}, 1.38e-3}, {{}, 4.2e-3}},
    {"allegro_ball_table_3_2", {{}, 0.90e-3}, {{}, 1.38e-3}, {{}, 4.2e-3}},
};
/// The other tasks: cold steps, exact and with all derivatives.
constexpr const char* kOtherSteps[] = {"planar_hand_fixed_y", "box_grazing",  "allegro_cube",         "allegro_pen",
                                       "allegro_plate",       "allegro_door", "iiwa_bimanual_planar", "iiwa_bimanual",
                                       "iiwa_bimanual_box",   "ur5_mesh_push"};
constexpr Reference kStacking = {10e-3, 6.3e-3};
constexpr double kStackingStep_s = 0.1;
constexpr int kFeet[] = {1, 2, 5, 10, 20, 50, 100, 200};
constexpr int kTower[] = {1, 2, 5, 10, 20, 50};
constexpr int kSamples = 100;                   // of the randomised local model
constexpr Reference kCone22 = {{}, 0.90e-3};    // peer: exact step of the same hand, contacts and B included
constexpr Reference kCone69 = {10e-3, 6.3e-3};  // peer: exact step of ten boxes and an arm, contacts and B included
struct TreeReference {
  const char* row;
  const char* task;
  Reference reference;
  planning::Scheme scheme = planning::Scheme::Analytic;
};
constexpr TreeReference kTrees[] = {
    {"rrt_1000/planar_pushing", "planar_pushing_table_3_2", {3.25, 0.60}},
    {"rrt_1000/planar_hand", "planar_hand_table_3_2", {10.32, 1.38}},
    {"rrt_1000/allegro_ball_table_3_2", "allegro_ball_table_3_2", {31.01, 3.9}},
    {"rrt_1000/allegro_plate_table_3_2", "allegro_plate_table_3_2", {117.16, {}}},
    {"rrt_1000/allegro_pen_table_3_2", "allegro_pen_table_3_2", {24.84, {}}},
    {"rrt_1000/allegro_door_table_3_2", "allegro_door_table_3_2", {12.42, {}}},
    {"rrt_1000/planar_pushing/randomized_first", "planar_pushing_table_3_2", {7.50, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/planar_hand/randomized_first", "planar_hand_table_3_2", {21.34, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_ball_table_3_2/randomized_first", "allegro_ball_table_3_2", {80.12, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_plate_table_3_2/randomized_first", "allegro_plate_table_3_2", {161.64, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_pen_table_3_2/randomized_first", "allegro_pen_table_3_2", {86.12, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_door_table_3_2/randomized_first", "allegro_door_table_3_2", {34.55, {}}, planning::Scheme::RandomizedFirst},
    {"rrt_1000/planar_pushing/randomized_zeroth", "planar_pushing_table_3_2", {7.40, {}}, planning::Scheme::RandomizedZeroth},
    {"rrt_1000/planar_hand/randomized_zeroth", "planar_hand_table_3_2", {21.00, {}}, planning::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_ball_table_3_2/randomized_zeroth", "allegro_ball_table_3_2", {82.00, {}}, planning::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_plate_table_3_2/randomized_zeroth", "allegro_plate_table_3_2", {168.11, {}}, planning::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_pen_table_3_2/randomized_zeroth", "allegro_pen_table_3_2", {81.23, {}}, planning::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_door_table_3_2/randomized_zeroth", "allegro_door_table_3_2", {33.80, {}}, planning::Scheme::RandomizedZeroth},
};
/// Table 3.1: ten iterations with analytic smoothing, 16 cores.
constexpr TreeReference kTrajectories[] = {
    {"impc_10/planar_pushing", "impc_planar_pushing", {2.17, {}}},
    {"impc_10/planar_hand", "impc_planar_hand", {5.20, {}}},
    {"impc_10/allegro_ball", "impc_allegro_ball", {19.59, {}}},
};
constexpr int kTreeIterations = 1000;
constexpr int kStates = 100;           // contact-rich states per task
constexpr double kPlanTimeout_s = 20;  // of the plans they are taken from
constexpr double kShortPlan_s = 2;     // of those for kOtherSteps
constexpr int kConeInstances = 2000;

struct Row {
  std::string name;
  double median_s = 0, p95_s = 0, p99_s = 0;
  Reference reference;
  std::optional<long> allocations;
  int failures = 0;
  std::optional<double> contacts;  // median number of a step
};

/// The folder of robots and scenes beside that of the tasks.
std::filesystem::path models_dir(const std::vector<std::filesystem::path>& task_dirs) {
  for (const auto& dir : task_dirs) {
    const auto models = dir.parent_path() / "models";
    if (std::filesystem::exists(models / "stacking.yaml")) return models;
  }
  core::throw_invalid("stacking.yaml", "not found", "a folder models/ beside that of the tasks");
}

double quantile(std::vector<double>& values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5)];
}

Row make_row(std::string name, std::vector<double> seconds, const Reference& reference, std::optional<long> allocations, int failures) {
  Row row;
  row.name = std::move(name);
  row.reference = reference;
  row.allocations = allocations;
  row.failures = failures;
  row.median_s = quantile(seconds, 0.5);
  row.p95_s = quantile(seconds, 0.95);
  row.p99_s = quantile(seconds, 0.99);
  return row;
}

std::vector<State> contact_rich_states(const tasks::Task& task, const dynamics::StepOptions& step_options, double timeout_s,
                                       ProgressLine& line) {
  dynamics::StepWorkspace work(task.model);
  dynamics::StepResult step;
  std::vector<State> all;
  for (std::uint64_t seed = 0; seed < 3 && static_cast<int>(all.size()) < kStates; ++seed) {
    if (interrupted()) break;
    planning::PlannerOptions options = task.options;
    options.seed = seed;
    core::RunControl control = make_run_control(timeout_s);
    control.on_progress = [&](const core::Progress&) { line.show(fmt::format("planning {}, seed {}, for its states", task.name, seed)); };
    planning::PlanResult result;
    (void)planning::plan(task.problem, options, control, result);  // states of an unfinished plan are as good
    Eigen::VectorXd q = result.plan.q_start, u = result.plan.u_start;
    for (const auto& segment : result.plan.segments) {
      Eigen::VectorXd q_before = q, u_before = u;
      for (const auto& knot : segment.knots) {
        work.forget();
        (void)dynamics::step(*task.model, {q, knot.u}, step_options, work, step);
        const bool touches = std::any_of(step.contacts.begin(), step.contacts.end(), [](const auto& c) { return c.active; });
        if (touches) all.push_back({q_before, u_before, q, knot.u});
        q_before = q, u_before = u;
        q = knot.q, u = knot.u;
      }
    }
  }
  std::vector<State> out;  // evenly over the plans
  const int n = static_cast<int>(std::min<std::size_t>(all.size(), kStates));
  for (int i = 0; i < n; ++i) out.push_back(all[all.size() * static_cast<std::size_t>(i) / static_cast<std::size_t>(n)]);
  return out;
}

/// Times step() over the states: kinematics, contacts, solve and, when asked for, A and B.
Row time_steps(const std::string& name, const Scenario& scenario, const dynamics::StepOptions& options, bool warm,
               const Reference& reference, int repeat) {
  const world::Model& model = *scenario.model;
  const std::vector<State>& states = scenario.states;
  dynamics::StepWorkspace work(scenario.model);
  dynamics::StepResult result;
  for (const auto& s : states) (void)dynamics::step(model, {s.q, s.u}, options, work, result);  // sizes the workspace
  std::vector<double> seconds;
  seconds.reserve(states.size() * static_cast<std::size_t>(repeat));
  std::vector<double> contacts;
  long allocations = 0;
  int failures = 0;
  for (int r = 0; r < repeat; ++r) {
    for (const auto& s : states) {
      work.forget();
      if (warm) (void)dynamics::step(model, {s.q_before, s.u_before}, options, work, result);
      const long before = bench::allocations();
      const auto start = Clock::now();
      const Status status = dynamics::step(model, {s.q, s.u}, options, work, result);
      const auto end = Clock::now();
      allocations = std::max(allocations, bench::allocations() - before);
      if (r == 0 && status != Status::Solved) ++failures;
      if (r == 0) contacts.push_back(static_cast<double>(result.contacts.size()));
      seconds.push_back(Seconds(end - start).count());
    }
  }
  Row row = make_row(name, std::move(seconds), reference, allocations, failures);
  row.contacts = quantile(contacts, 0.5);
  return row;
}

struct BenchArguments {
  std::string filter;
  int repeat = 5;
  bool json = false;
};

class Bench {
 public:
  explicit Bench(const BenchArguments& arguments) : arguments_(arguments), dirs_(data_dirs()) {}

  const std::vector<Row>& run() {
    for (const auto& entry : kSteps) steps(entry, false);
    for (const char* task : kOtherSteps) steps({task, {}, {}, {}}, true);
    stacking();
    randomized("allegro_ball");
    for (const int n : kFeet) scaling(fmt::format("scaling_contacts/{}", n), [n] { return make_feet(n); });
    for (const int n : kTower) scaling(fmt::format("scaling_bodies/{}", n), [n] { return make_tower(n); });
    cone("cone/22dof_20contacts", bench::ConeFamily::Hand22, kCone22);
    cone("cone/69dof_56contacts", bench::ConeFamily::Boxes69, kCone69);
    for (const auto& entry : kTrees) tree(entry);
    for (const auto& entry : kTrajectories) trajectory(entry);
    line_.clear();
    return rows_;
  }

 private:
  bool wanted(std::string_view name) const { return name.find(arguments_.filter) != std::string_view::npos && !interrupted(); }

  void steps(const TaskReference& entry, bool main_rows_only) {
    struct Kind {
      const char* prefix;
      bool main_row, smoothed, with_A, with_B;
      const Reference* reference;
      bool coulomb = false;
    };
    const Reference none;
    const Kind kinds[] = {{"step_exact/", true, false, false, false, &none},
                          {"step_coulomb/", true, false, false, false, &none, true},
                          {"step_exact_B/", false, false, false, true, &entry.exact_B},
                          {"step_smoothed/", false, true, false, false, &none},
                          {"step_smoothed_B/", false, true, false, true, &entry.smoothed_B},
                          {"step_smoothed_AB/", true, true, true, true, &entry.smoothed_AB}};
    std::optional<tasks::Task> task;
    dynamics::StepOptions step_options;
    Scenario scenario;
    for (const auto& kind : kinds) {
      for (const bool warm : {false, true}) {
        const std::string name = std::string(kind.prefix) + entry.task + (warm ? "/warm" : "");
        if (!wanted(name) || (main_rows_only && (warm || !kind.main_row)) || (kind.coulomb && warm)) continue;
        if (!task) task = tasks::load_task(entry.task, dirs_);
        if (kind.coulomb && task->options.friction_law != dynamics::FrictionLaw::Coulomb) continue;
        if (!scenario.model) {
          step_options.h = task->options.h;
          step_options.regularisation = task->options.regularisation;
          scenario = {task->model, contact_rich_states(*task, step_options, main_rows_only ? kShortPlan_s : kPlanTimeout_s, line_)};
        }
        if (scenario.states.empty()) {
          if (interrupted()) return;
          core::throw_invalid("bench", fmt::format("no state in contact on a plan of '{}'", entry.task), "at least one");
        }
        line_.show("timing " + name);
        dynamics::StepOptions options = kind.coulomb ? task->options.step_options() : step_options;
        options.with_A = kind.with_A;
        options.with_B = kind.with_B;
        if (kind.smoothed) options.smoothing = task->options.smoothing;
        add(time_steps(name, scenario, options, warm, *kind.reference, arguments_.repeat));
      }
    }
  }

  void stacking() {
    std::optional<Scenario> scenario;
    for (const bool warm : {false, true}) {
      const std::string name = std::string("stacking_69dof/step") + (warm ? "/warm" : "");
      if (!wanted(name)) continue;
      line_.show("timing " + name);
      if (!scenario) scenario = make_stacking(models_dir(dirs_), kStackingStep_s);
      add(time_steps(name, *scenario, {.h = kStackingStep_s}, warm, kStacking, arguments_.repeat));
    }
  }

  template <class Make>
  void scaling(const std::string& base, Make&& make) {
    for (const bool warm : {false, true}) {
      const std::string name = base + (warm ? "/warm" : "");
      if (!wanted(name)) continue;
      line_.show("timing " + name);
      // True mass: the rule for ε needs a robot. The body falls 4 mm in a step, less than the contact distance.
      const dynamics::StepOptions options{.h = 0.02, .regularisation = dynamics::FixedEpsilon{1}};
      add(time_steps(name, make(), options, warm, {}, arguments_.repeat));
    }
  }

  /// (2.22) with kSamples samples on all threads, without A, as a tree extension needs it.
  void randomized(const std::string& name) {
    const std::string row = fmt::format("randomized_{}/{}", kSamples, name);
    if (!wanted(row)) return;
    const tasks::Task task = tasks::load_task(name, dirs_);
    dynamics::StepOptions options;
    options.h = task.options.h;
    options.regularisation = task.options.regularisation;
    const auto states = contact_rich_states(task, options, kPlanTimeout_s, line_);
    line_.show("timing " + row);
    dynamics::LocalModelWorkspace work(task.model, core::hardware_threads());
    dynamics::LocalModel local;
    std::vector<double> seconds;
    int failures = 0;
    for (int r = 0; r < arguments_.repeat && !interrupted(); ++r) {
      for (const auto& s : states) {
        dynamics::RandomizedFirstOrder scheme;
        scheme.samples = kSamples;
        const auto start = Clock::now();
        const Status status = dynamics::calc_local_model(*task.model, {s.q, s.u}, scheme, options, false, work, local);
        seconds.push_back(Seconds(Clock::now() - start).count());
        if (status != Status::Solved) ++failures;
      }
    }
    if (!seconds.empty()) add(make_row(row, std::move(seconds), {}, {}, failures));
  }

  void cone(const std::string& base, bench::ConeFamily family, const Reference& reference) {
    for (const bool warm : {false, true}) {
      const std::string name = base + (warm ? "/warm" : "");
      if (!wanted(name)) continue;
      line_.show("timing " + name);
      cone::Options options;
      options.sensitivities = false;  // as in a step without B
      const auto timing = warm ? bench::time_cone_warm(family, kConeInstances, 0, options, bench::allocations)
                               : bench::time_cone_cold(family, kConeInstances, 0, options, bench::allocations);
      add(make_row(name, timing.seconds, reference, timing.allocations, timing.failures));
    }
  }

  void tree(const TreeReference& entry) {
    if (!wanted(entry.row)) return;
    const tasks::Task task = tasks::load_task(entry.task, dirs_);
    std::vector<double> seconds;
    const int repeat = entry.scheme == planning::Scheme::Analytic ? arguments_.repeat : 1;  // the randomised ones take seconds each
    for (int r = 0; r < repeat && !interrupted(); ++r) {
      planning::PlannerOptions options = task.options;
      options.seed = static_cast<std::uint64_t>(r);
      options.scheme = entry.scheme;
      options.max_iterations = kTreeIterations;
      options.stop_at_goal = false;
      core::RunControl control = make_run_control();
      control.on_progress = [&](const core::Progress&) { line_.show(fmt::format("growing {}, tree {} of {}", entry.row, r + 1, repeat)); };
      planning::PlanResult result;
      const auto start = Clock::now();
      const Status status = planning::plan(task.problem, options, control, result);
      if (status == Status::Cancelled) break;
      seconds.push_back(Seconds(Clock::now() - start).count());
    }
    if (!seconds.empty()) add(make_row(entry.row, std::move(seconds), entry.reference, {}, 0));
  }

  void trajectory(const TreeReference& entry) {
    if (!wanted(entry.row)) return;
    line_.show(fmt::format("timing {}", entry.row));
    const tasks::Task task = tasks::load_task(entry.task, dirs_);
    const auto input = tasks::make_optimize_input(task);
    const core::RunControl control = make_run_control();
    std::vector<double> seconds;
    for (int r = 0; r < arguments_.repeat && !interrupted(); ++r) {
      trajopt::OptimizeWorkspace work(task.model);
      trajopt::OptimizeResult result;
      const auto start = Clock::now();
      if (trajopt::optimize(*task.model, input, task.optimize->options, control, work, result) != Status::Solved) break;
      seconds.push_back(Seconds(Clock::now() - start).count());
    }
    if (!seconds.empty()) add(make_row(entry.row, std::move(seconds), entry.reference, {}, 0));
  }

  void add(Row row) {
    line_.clear();
    const auto milliseconds = [](std::optional<double> s) { return s ? fmt::format("{:.4g}", 1e3 * *s) : std::string("–"); };
    if (rows_.empty())
      fmt::print(people(arguments_.json), "{:42} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9}  allocations\n", "[ms]", "contacts",
                 "median", "p95", "p99", "published", "peer", "published/ours");
    const std::string ratio = row.reference.published ? fmt::format("{:.0f}", *row.reference.published / row.median_s) : "–";
    fmt::print(people(arguments_.json), "{:42} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9}  {}{}\n", row.name,
               row.contacts ? fmt::format("{:.0f}", *row.contacts) : "–", milliseconds(row.median_s), milliseconds(row.p95_s),
               milliseconds(row.p99_s), milliseconds(row.reference.published), milliseconds(row.reference.peer), ratio,
               row.allocations ? std::to_string(*row.allocations) : "–", row.failures ? fmt::format("  {} not solved", row.failures) : "");
    rows_.push_back(std::move(row));
  }

  BenchArguments arguments_;
  std::vector<std::filesystem::path> dirs_;
  ProgressLine line_;
  std::vector<Row> rows_;
};

std::string machine() {
  std::ifstream in("/proc/cpuinfo");
  std::string text;
  std::string name = "unknown processor";
  int threads = 0;
  while (std::getline(in, text)) {
    if (text.starts_with("processor")) ++threads;
    if (text.starts_with("model name") || text.starts_with("Model")) name = text.substr(std::min(text.find(':') + 2, text.size()));
  }
  return fmt::format("{}, {} threads", name, threads);
}

nlohmann::ordered_json number(std::optional<double> value) { return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(); }

int run_bench(const BenchArguments& arguments) {
  catch_signals();
  Bench bench(arguments);
  const auto& rows = bench.run();
  if (rows.empty() && !interrupted()) core::throw_invalid("--filter", fmt::format("'{}'", arguments.filter), "part of the name of a row");
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["machine"] = machine();
    out["commit"] = kCommit;
    out["results"] = nlohmann::ordered_json::array();
    for (const auto& row : rows) {
      nlohmann::ordered_json entry;
      entry["name"] = row.name;
      entry["median_s"] = row.median_s;
      entry["p95_s"] = row.p95_s;
      entry["p99_s"] = row.p99_s;
      entry["published_s"] = number(row.reference.published);
      entry["peer_s"] = number(row.reference.peer);
      entry["ratio"] = number(row.reference.published ? std::optional(row.median_s / *row.reference.published) : std::nullopt);
      entry["allocations"] = row.allocations ? nlohmann::ordered_json(*row.allocations) : nlohmann::ordered_json();
      entry["contacts"] = number(row.contacts);
      out["results"].push_back(std::move(entry));
    }
    fmt::print("{}\n", out.dump());
  }
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

Run declare_bench(CLI::App& command) {
  const auto arguments = std::make_shared<BenchArguments>();
  BenchArguments& a = *arguments;
  add_json(command, a.json);
  command.add_option("--filter", a.filter, "Only the rows whose name contains this");
  command.add_option("--repeat", a.repeat, "Repetitions of each timing")->capture_default_str()->check(CLI::Range(1, 1000));
  return [arguments] { return run_bench(*arguments); };
}

}  // namespace stiction::app
