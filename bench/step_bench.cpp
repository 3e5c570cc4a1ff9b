// Cost of a step and of its derivatives: Allegro hand and ball at the grasp of Table 3.2, warm, commands that change from step to step.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>

#include "stiction/core/random.hpp"
#include "stiction/dynamics/step.hpp"

namespace {

using namespace stiction;
using dynamics::StepOptions;

/// @param effort  of every motor, as a share of its stiffness [rad]
void run(benchmark::State& state, const StepOptions& options, double effort = 1e6) {
  world::Scene scene = world::load_scene(std::string(STICTION_SOURCE_DIR) + "/tasks/allegro_ball_table_3_2.yaml");
  const auto plain = world::Model::make(scene);
  scene.robots[0].effort.clear();
  for (int j = 0; j < plain->n_a(); ++j) {
    const world::Dof& dof = plain->dofs()[static_cast<std::size_t>(plain->n_vu() + j)];
    scene.robots[0].effort.emplace_back(dof.name.substr(dof.name.find('/') + 1), effort * dof.stiffness);
  }
  const auto model = world::Model::make(scene);
  Eigen::VectorXd q = model->neutral();
  q.head<3>() << -0.081, 0.001, 0.071;
  q.tail<16>() << 0.03501504, 0.75276565, 0.74146232, 0.83261002, -0.1438725, 0.74696812, 0.61908827, 0.70064279, -0.06922541, 0.78533142,
      0.82942863, 0.90415436, 0.63256269, 1.02378254, 0.64089555, 0.82444782;
  core::Random random(1, 0);
  std::vector<Eigen::VectorXd> commands(64, q.tail<16>());
  for (Eigen::VectorXd& u : commands) {
    for (double& x : u) x += 0.05 * random.normal();
  }
  dynamics::StepWorkspace work(model);
  dynamics::StepResult result;
  std::size_t i = 0, solved = 0, steps = 0, saturated = 0;
  for (auto _ : state) {
    solved += dynamics::step(*model, {q, commands[i]}, options, work, result) == core::Status::Solved;
    ++steps;
    saturated += std::ranges::count(result.saturated, 1) > 0;
    i = (i + 1) % commands.size();
  }
  state.counters["contacts"] = static_cast<double>(result.contacts.size());
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(steps);
  state.counters["saturated"] = static_cast<double>(saturated) / static_cast<double>(steps);
}

const dynamics::Smoothing kSmoothed = dynamics::Analytic{}, kExact = dynamics::Exact{};

BENCHMARK_CAPTURE(run, smoothed, StepOptions{.smoothing = kSmoothed})->Name("step/smoothed/allegro_ball")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, smoothed_B, StepOptions{.smoothing = kSmoothed, .with_B = true})
    ->Name("step/smoothed_B/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, smoothed_A_B, StepOptions{.smoothing = kSmoothed, .with_B = true, .with_A = true})
    ->Name("step/smoothed_A_B/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, smoothed_A_B_forces,
                  StepOptions{.smoothing = kSmoothed, .with_B = true, .with_A = true, .with_force_derivatives = true})
    ->Name("step/smoothed_A_B_forces/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact, StepOptions{.smoothing = kExact})->Name("step/exact/allegro_ball")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact_B, StepOptions{.smoothing = kExact, .with_B = true})
    ->Name("step/exact_B/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact_A_B, StepOptions{.smoothing = kExact, .with_B = true, .with_A = true})
    ->Name("step/exact_A_B/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact_A_B_forces, StepOptions{.smoothing = kExact, .with_B = true, .with_A = true, .with_force_derivatives = true})
    ->Name("step/exact_A_B_forces/allegro_ball")
    ->Unit(benchmark::kMicrosecond);

// Motors: efforts that are never reached, and those that bear 0.01 rad of their spring.
BENCHMARK_CAPTURE(run, smoothed_strong, StepOptions{.smoothing = kSmoothed, .effort_limits = true})
    ->Name("step/smoothed_efforts/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact_strong, StepOptions{.smoothing = kExact, .effort_limits = true})
    ->Name("step/exact_efforts/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, smoothed_weak, StepOptions{.smoothing = kSmoothed, .effort_limits = true}, 0.01)
    ->Name("step/smoothed_saturated/allegro_ball")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(run, exact_weak, StepOptions{.smoothing = kExact, .effort_limits = true}, 0.01)
    ->Name("step/exact_saturated/allegro_ball")
    ->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
