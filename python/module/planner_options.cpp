#include "planner_options.hpp"

#include <fmt/format.h>

#include "stiction/tasks/options.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

nb::dict to_dict(const PlannerOptions& options) {
  const nb::object loads = nb::module_::import_("json").attr("loads");
  return nb::cast<nb::dict>(loads(tasks::planner_options_json(options.value, *options.model, tasks::WhichOptions::All)));
}

}  // namespace

void warn_of_options(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) {
    if (PyErr_WarnEx(PyExc_DeprecationWarning, note.c_str(), 2) != 0) throw nb::python_error();
  }
}

namespace {

PlannerOptions from_dict(const ModelPtr& model, const nb::dict& values) {
  const auto node = world::YamlNode::parse(yaml_text(values), std::filesystem::path());
  std::vector<std::string> notes;
  PlannerOptions out{model, tasks::read_planner_options(node, *model, {}, &notes)};
  warn_of_options(notes);
  return out;
}

PlannerOptions replace(const PlannerOptions& options, const nb::dict& changes) {
  nb::dict values = to_dict(options);
  values.update(changes);
  return from_dict(options.model, values);
}

std::string repr(const PlannerOptions& options) {
  std::string out = "PlannerOptions(";
  for (const auto& [key, value] : to_dict(options)) {
    if (out.back() != '(') out += ", ";
    out += fmt::format("{}={}", nb::cast<std::string>(key), nb::repr(value).c_str());
  }
  return out + ")";
}

}  // namespace

planning::PlannerOptions options_of(const PlannerOptions& base, const OptionsLike& options) {
  if (const auto* changes = std::get_if<nb::dict>(&options)) return replace(base, *changes).value;
  const auto& whole = std::get<PlannerOptions>(options);
  if (whole.model != base.model) core::throw_invalid("options", "those of another model", "options of the model of the task");
  return whole.value;
}

void bind_planner_options(nb::module_& m) {
  nb::class_<PlannerOptions>(m, "PlannerOptions",
                             "Options of the planner. The attributes have the names and values of the section `planner` of a task file "
                             "(tasks/schema/task.schema.json). dir() lists them, and planner_schema() explains them.")
      .def(
          "__init__",
          [](PlannerOptions* self, const ModelPtr& model, const nb::kwargs& values) {
            new (self) PlannerOptions(from_dict(model, nb::borrow<nb::dict>(values)));
          },
          "model"_a, "values"_a, nb::sig("def __init__(self, model: Model, **values: object) -> None"),
          "Options for a model: the defaults, changed by the keyword arguments. Raises InvalidInput: an unknown name, or a value out of "
          "range.")
      .def(
          "replace", [](const PlannerOptions& self, const nb::kwargs& changes) { return replace(self, nb::borrow<nb::dict>(changes)); },
          "changes"_a, nb::sig("def replace(self, **changes: object) -> PlannerOptions"),
          "Returns a copy of these options with the given changes. A change replaces the whole value of an option; None restores its "
          "default. "
          "Raises InvalidInput."
          R"(

    >>> options = st.load_task("planar_pushing").options
    >>> options.replace(goal_bias=0.25).goal_bias
    0.25)")
      .def("to_dict", &to_dict, "Returns all options as a dict from name to value.", nb::sig("def to_dict(self) -> dict[str, object]"))
      .def(
          "__getattr__",
          [](const PlannerOptions& self, const std::string& name) -> nb::object {
            const nb::dict values = to_dict(self);
            if (!values.contains(name.c_str()))
              throw nb::attribute_error(fmt::format("PlannerOptions has no option '{}' that is set", name).c_str());
            return values[name.c_str()];
          },
          nb::sig("def __getattr__(self, name: str, /) -> typing.Any"))
      .def(
          "__dir__",
          [](const PlannerOptions& self) {
            nb::list out = to_dict(self).keys();
            out.append("replace");
            out.append("to_dict");
            return out;
          },
          nb::sig("def __dir__(self) -> list[str]"))
      .def(
          "__eq__", [](const PlannerOptions& a, const PlannerOptions& b) { return to_dict(a).equal(to_dict(b)); }, nb::is_operator(),
          nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def("__repr__", &repr);
  m.def(
      "planner_schema", [] { return nb::module_::import_("json").attr("loads")(tasks::planner_schema_json()); },
      nb::sig("def planner_schema() -> dict[str, object]"),
      "Returns the JSON schema of the section `planner` of a task file. It gives the meaning, unit and range of every option."
      R"(

    >>> "goal_bias" in st.planner_schema()["properties"]
    True)");
}

}  // namespace stiction::python
