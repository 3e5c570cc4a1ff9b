#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "cone_allocations.hpp"
#include "scenes.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/core/quantile.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/thresholds.hpp"
#include "stiction/tasks/task.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;

/// Figures of others [s]. Published: T. Pang, PhD thesis, MIT 2023, section 2.3 (69 coordinates with a commercial cone solver: below 10 ms). Peer: the thesis's
/// research code (quasistatic_simulator c917755, Drake 1.26 with Clarabel) measured on two cores of an AMD EPYC, medians.
struct TaskReference {
  std::string task;  ///< name or file
  Reference exact_B, smoothed_B, smoothed_AB;
};
const TaskReference kSteps[] = {
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
constexpr int kSamples = 100;          // of the randomised local model
constexpr int kStates = 100;           // contact-rich states per task
constexpr double kPlanTimeout_s = 20;  // of the plans they are taken from
constexpr double kShortPlan_s = 2;     // of those for kOtherSteps

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
      const auto start = BenchClock::now();
      const Status status = dynamics::step(model, {s.q, s.u}, options, work, result);
      const double elapsed = seconds_since(start);
      allocations = std::max(allocations, bench::allocations() - before);
      if (r == 0 && status != Status::Solved) ++failures;
      if (r == 0) contacts.push_back(static_cast<double>(result.contacts.size()));
      seconds.push_back(elapsed);
    }
  }
  Row row = make_row(name, std::move(seconds), reference, allocations, failures);
  row.contacts = core::quantile(contacts, 0.5);
  return row;
}

void steps(BenchTable& table, const TaskReference& entry, bool main_rows_only) {
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
      const std::string name = kind.prefix + fs::path(entry.task).stem().string() + (warm ? "/warm" : "");
      if (!table.wanted(name) || (main_rows_only && (warm || !kind.main_row)) || (kind.coulomb && warm)) continue;
      if (!task) task = tasks::load_task(entry.task, table.task_dirs());
      const dynamics::StepOptions of_plan = task->options.step_options(*task->model);
      if (kind.coulomb && of_plan.friction_law != dynamics::FrictionLaw::Coulomb) continue;
      if (!scenario.model) {
        step_options.h = of_plan.h;
        step_options.regularisation = of_plan.regularisation;
        step_options.contacts_within_reach = true;  // as the planner's steps
        scenario = {task->model, contact_rich_states(*task, step_options, main_rows_only ? kShortPlan_s : kPlanTimeout_s, table.line())};
      }
      if (scenario.states.empty()) {
        if (interrupted()) return;
        core::throw_invalid("bench", fmt::format("no state in contact on a plan of '{}'", entry.task), "at least one");
      }
      table.line().show("timing " + name);
      dynamics::StepOptions options = kind.coulomb ? of_plan : step_options;
      options.with_A = kind.with_A;
      options.with_B = kind.with_B;
      if (kind.smoothed)
        options.smoothing = task->options.thesis ? task->options.thesis->smoothing
                                                 : planning::SceneThresholds(*task->model, task->problem.goal.object).smoothing;
      table.add(time_steps(name, scenario, options, warm, *kind.reference, table.repeat()));
    }
  }
}

void stacking(BenchTable& table) {
  std::optional<Scenario> scenario;
  for (const bool warm : {false, true}) {
    const std::string name = std::string("stacking_69dof/step") + (warm ? "/warm" : "");
    if (!table.wanted(name)) continue;
    table.line().show("timing " + name);
    if (!scenario) scenario = make_stacking(table.models_dir(), kStackingStep_s);
    table.add(time_steps(name, *scenario, {.h = kStackingStep_s}, warm, kStacking, table.repeat()));
  }
}

template <class Make>
void scaling(BenchTable& table, const std::string& base, Make&& make) {
  for (const bool warm : {false, true}) {
    const std::string name = base + (warm ? "/warm" : "");
    if (!table.wanted(name)) continue;
    table.line().show("timing " + name);
    // True mass: the rule for ε needs a robot. The body falls 4 mm in a step, less than the contact distance.
    const dynamics::StepOptions options{.h = 0.02, .regularisation = dynamics::FixedEpsilon{1}};
    table.add(time_steps(name, make(), options, warm, {}, table.repeat()));
  }
}

/// (2.22) with kSamples samples on all threads, without A, as a tree extension needs it.
void randomized(BenchTable& table, const std::string& name) {
  const std::string row = fmt::format("randomized_{}/{}", kSamples, name);
  if (!table.wanted(row)) return;
  const tasks::Task task = tasks::load_task(name, table.task_dirs());
  dynamics::StepOptions options;
  options.h = task.options.step_options(*task.model).h;
  options.regularisation = task.options.step_options(*task.model).regularisation;
  const auto states = contact_rich_states(task, options, kPlanTimeout_s, table.line());
  table.line().show("timing " + row);
  dynamics::LocalModelWorkspace work(task.model, core::hardware_threads());
  dynamics::LocalModel local;
  std::vector<double> seconds;
  int failures = 0;
  for (int r = 0; r < table.repeat() && !interrupted(); ++r) {
    for (const auto& s : states) {
      dynamics::RandomizedFirstOrder scheme;
      scheme.samples = kSamples;
      const auto start = BenchClock::now();
      const Status status = dynamics::calc_local_model(*task.model, {s.q, s.u}, scheme, options, false, work, local);
      seconds.push_back(seconds_since(start));
      if (status != Status::Solved) ++failures;
    }
  }
  if (!seconds.empty()) table.add(make_row(row, std::move(seconds), {}, {}, failures));
}

}  // namespace

void add_task_rows(BenchTable& table) {
  for (const auto& task : table.tasks()) steps(table, {task, {}, {}, {}}, false);
}

void add_step_rows(BenchTable& table) {
  for (const auto& entry : kSteps) steps(table, entry, false);
  for (const char* task : kOtherSteps) steps(table, {task, {}, {}, {}}, true);
  stacking(table);
  randomized(table, "allegro_ball");
  for (const int n : kFeet) scaling(table, fmt::format("scaling_contacts/{}", n), [n] { return make_feet(n); });
  for (const int n : kTower) scaling(table, fmt::format("scaling_bodies/{}", n), [n] { return make_tower(n); });
}

}  // namespace stiction::app
