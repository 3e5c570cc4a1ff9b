#pragma once

#include "bindings.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::python {

/// A plan in memory: what its file holds, and its task.
struct Plan {
  tasks::Task task;
  tasks::PlanFile file;

  Plan(const tasks::Task& task, const planning::PlannerOptions& options, const planning::PlanResult& result);
  explicit Plan(tasks::PlanFile file, const std::filesystem::path& path);

  const world::Model& model() const { return *task.model; }
  /// The file as it stands at `path`, from where the task is found.
  tasks::PlanFile at(const std::filesystem::path& path) const;
};

void bind_plan(nb::module_& m);

}  // namespace stiction::python
