#pragma once

#include <variant>

#include "bindings.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::python {

/// Options of the planner for one model. Names and values are those of the section `planner` of a task file, by the same reader and writer.
struct PlannerOptions {
  ModelPtr model;
  planning::PlannerOptions value;
};

/// Options, or those that differ from others.
using OptionsLike = std::variant<PlannerOptions, nb::dict>;

/// @throws core::InvalidInput: unknown names, values that cannot be, options of another model
planning::PlannerOptions options_of(const PlannerOptions& base, const OptionsLike& options);

/// A DeprecationWarning for each option that is none any more. Needs the GIL.
void warn_of_options(const std::vector<std::string>& notes);

void bind_planner_options(nb::module_& m);

}  // namespace stiction::python
