// Loads a built-in task of the installation by its name and takes one exact step: `consumer TASK`.
#include <array>
#include <cstdio>
#include <filesystem>

#include "stiction/core/version.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/task.hpp"

int main(int argc, char** argv) {
  using namespace stiction;
  if (argc != 2) return 2;
  const std::array<std::filesystem::path, 1> dirs{std::filesystem::path(DATA_DIR) / "tasks"};
  const tasks::Task task = tasks::load_task(argv[1], dirs);
  const auto scenario = tasks::find_scenario("ur5_forearm", dirs);

  const Eigen::VectorXd& q = task.problem.q_start;
  const Eigen::VectorXd u = q.tail(task.model->n_a());
  dynamics::StepWorkspace work(task.model);
  dynamics::StepResult result;
  const core::Status status = dynamics::step(*task.model, {q, u}, {}, work, result);
  std::printf("%.*s\n%s\n%s\n%.*s\n", static_cast<int>(core::version().size()), core::version().data(), task.file.c_str(), scenario.c_str(),
              static_cast<int>(core::to_string(status).size()), core::to_string(status).data());
  std::printf("%.17g\n", (result.q_next - q).cwiseAbs().maxCoeff());
  return status == core::Status::Solved ? 0 : 1;
}
