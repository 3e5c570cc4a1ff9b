#include <fmt/format.h>

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/trajopt/optimize.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

using core::Status;

/// Figures of others [s]. Published: T. Pang, PhD thesis, MIT 2023, Table 3.2, 1000 iterations on 16 cores. Peer: its research code (planning_through_contact
/// 74e4559, Drake 1.26 with Clarabel) measured on two cores of an AMD EPYC, medians.
struct TreeReference {
  const char* row;
  const char* task;
  Reference reference;
  planning::thesis::Scheme scheme = planning::thesis::Scheme::Analytic;
};
constexpr TreeReference kTrees[] = {
    {"rrt_1000/planar_pushing", "planar_pushing_table_3_2", {3.25, 0.60}},
    {"rrt_1000/planar_hand", "planar_hand_table_3_2", {10.32, 1.38}},
    {"rrt_1000/allegro_ball_table_3_2", "allegro_ball_table_3_2", {31.01, 3.9}},
    {"rrt_1000/allegro_plate_table_3_2", "allegro_plate_table_3_2", {117.16, {}}},
    {"rrt_1000/allegro_pen_table_3_2", "allegro_pen_table_3_2", {24.84, {}}},
    {"rrt_1000/allegro_door_table_3_2", "allegro_door_table_3_2", {12.42, {}}},
    {"rrt_1000/planar_pushing/randomized_first", "planar_pushing_table_3_2", {7.50, {}}, planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/planar_hand/randomized_first", "planar_hand_table_3_2", {21.34, {}}, planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_ball_table_3_2/randomized_first", "allegro_ball_table_3_2", {80.12, {}}, planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_plate_table_3_2/randomized_first",
     "allegro_plate_table_3_2",
     {161.64, {}},
     planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_pen_table_3_2/randomized_first", "allegro_pen_table_3_2", {86.12, {}}, planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/allegro_door_table_3_2/randomized_first", "allegro_door_table_3_2", {34.55, {}}, planning::thesis::Scheme::RandomizedFirst},
    {"rrt_1000/planar_pushing/randomized_zeroth", "planar_pushing_table_3_2", {7.40, {}}, planning::thesis::Scheme::RandomizedZeroth},
    {"rrt_1000/planar_hand/randomized_zeroth", "planar_hand_table_3_2", {21.00, {}}, planning::thesis::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_ball_table_3_2/randomized_zeroth",
     "allegro_ball_table_3_2",
     {82.00, {}},
     planning::thesis::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_plate_table_3_2/randomized_zeroth",
     "allegro_plate_table_3_2",
     {168.11, {}},
     planning::thesis::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_pen_table_3_2/randomized_zeroth", "allegro_pen_table_3_2", {81.23, {}}, planning::thesis::Scheme::RandomizedZeroth},
    {"rrt_1000/allegro_door_table_3_2/randomized_zeroth",
     "allegro_door_table_3_2",
     {33.80, {}},
     planning::thesis::Scheme::RandomizedZeroth},
};
/// Table 3.1: ten iterations with analytic smoothing, 16 cores.
constexpr TreeReference kTrajectories[] = {
    {"impc_10/planar_pushing", "impc_planar_pushing", {2.17, {}}},
    {"impc_10/planar_hand", "impc_planar_hand", {5.20, {}}},
    {"impc_10/allegro_ball", "impc_allegro_ball", {19.59, {}}},
};
constexpr int kTreeIterations = 1000;

void tree(BenchTable& table, const TreeReference& entry) {
  if (!table.wanted(entry.row)) return;
  const tasks::Task task = tasks::load_task(entry.task, table.task_dirs());
  std::vector<double> seconds;
  const int repeat = entry.scheme == planning::thesis::Scheme::Analytic ? table.repeat() : 1;  // the randomised ones take seconds each
  for (int r = 0; r < repeat && !interrupted(); ++r) {
    planning::PlannerOptions options = task.options;
    options.seed = static_cast<std::uint64_t>(r);
    options.thesis->scheme = entry.scheme;
    options.max_iterations = kTreeIterations;
    options.thesis->stop_at_goal = false;
    core::RunControl control = make_run_control();
    control.on_progress = [&](const core::Progress&) {
      table.line().show(fmt::format("growing {}, tree {} of {}", entry.row, r + 1, repeat));
    };
    planning::PlanResult result;
    const auto start = BenchClock::now();
    const Status status = planning::plan(task.problem, options, control, result);
    if (status == Status::Cancelled) break;
    seconds.push_back(seconds_since(start));
  }
  if (!seconds.empty()) table.add(make_row(entry.row, std::move(seconds), entry.reference, {}, 0));
}

void trajectory(BenchTable& table, const TreeReference& entry) {
  if (!table.wanted(entry.row)) return;
  table.line().show(fmt::format("timing {}", entry.row));
  const tasks::Task task = tasks::load_task(entry.task, table.task_dirs());
  const auto input = tasks::make_optimize_input(task);
  const core::RunControl control = make_run_control();
  std::vector<double> seconds;
  for (int r = 0; r < table.repeat() && !interrupted(); ++r) {
    trajopt::OptimizeWorkspace work(task.model);
    trajopt::OptimizeResult result;
    const auto start = BenchClock::now();
    if (trajopt::optimize(*task.model, input, task.optimize->options, control, work, result) != Status::Solved) break;
    seconds.push_back(seconds_since(start));
  }
  if (!seconds.empty()) table.add(make_row(entry.row, std::move(seconds), entry.reference, {}, 0));
}

}  // namespace

void add_plan_rows(BenchTable& table) {
  for (const auto& entry : kTrees) tree(table, entry);
  for (const auto& entry : kTrajectories) trajectory(table, entry);
}

}  // namespace stiction::app
