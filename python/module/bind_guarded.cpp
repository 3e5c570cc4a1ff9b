#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/unique_ptr.h>

#include "bind_touch.hpp"
#include "pickles.hpp"
#include "scenario_file.hpp"
#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

using execution::GuardedRunResult;
using execution::MoveOutcome;
using execution::TouchScenario;

std::unique_ptr<GuardedResult> run(const TouchScenario& scenario, std::optional<std::uint64_t> seed, double settle,
                                   std::optional<double> timeout_s) {
  auto out = std::make_unique<GuardedResult>();
  execution::TouchRunOptions options = touch_options(scenario, seed, settle);
  Interrupt interrupt;
  options.control = interrupt.control(timeout_s);
  {
    const nb::gil_scoped_release unlocked;
    (void)execution::run_guarded(scenario, options, out->result);
  }
  interrupt.rethrow();
  name_moves(scenario, *out);
  return out;
}

std::unique_ptr<GuardedResult> run_file(const ScenarioFile& scenario, std::optional<std::uint64_t> seed, double settle,
                                        std::optional<double> timeout_s) {
  return run(load_touch_scenario(scenario), seed, settle, timeout_s);
}

/// Where the bodies that were felt are by now, as far as the arm knows.
std::map<std::string, world::Pose> calc_places(const GuardedResult& r) {
  std::map<std::string, world::Pose> out;
  if (!r.result.model) return out;
  for (const GuardedMoveResult& move : r.moves)
    for (const auto& body : r.result.model->scene().fixed)
      if (body.name == move.corrected) out[body.name] = body.X_WB;
  return out;
}

void bind_parts(nb::module_& m) {
  nb::enum_<MoveOutcome>(m, "MoveOutcome", "How a move ended.")
      .value("Arrived", MoveOutcome::Arrived, "at the end of its way")
      .value("Felt", MoveOutcome::Felt, "what its end asks for was felt, and is pressed with its force")
      .value("Lost", MoveOutcome::Lost, "what it pressed on is no longer there: an edge")
      .value("NotFelt", MoveOutcome::NotFelt, "at the end of its way, and nothing was felt")
      .value("WrongLink", MoveOutcome::WrongLink, "something was felt, on none of the links of its end")
      .value("StillThere", MoveOutcome::StillThere, "at the end of its way, and what it presses on goes on");
  const auto of = [](auto member) { return [member](const FeltContact& f) { return f.values.*member; }; };
  using Felt = execution::FeltContact;
  nb::class_<FeltContact>(m, "FeltContact", "A contact that ended a move, as torques tell. Times are those of the run.")
      .def_ro("link", &FeltContact::link, "as robot/link")
      .def_prop_ro("probability", of(&Felt::probability), "of that link")
      .def_prop_ro("p_W", of(&Felt::p_W), "place [m] (3)")
      .def_prop_ro("direction_W", of(&Felt::direction_W), "of the force on the arm, unit (3)")
      .def_prop_ro("force", of(&Felt::force), "[N]")
      .def_prop_ro("begin", of(&Felt::begin), "when it began [s]")
      .def_prop_ro("alarm", of(&Felt::alarm), "when that was noticed, and the arm stopped [s]")
      .def_prop_ro("time", of(&Felt::time), "when it was told, pressed with the force of its move [s]")
      .def("__repr__", [](const FeltContact& f) { return fmt::format("<stiction.FeltContact: {}, {:.3g} N>", f.link, f.values.force); });
}

void bind_move(nb::module_& m) {
  const auto of = [](auto member) { return [member](const GuardedMoveResult& r) { return r.values.*member; }; };
  using Move = execution::MoveResult;
  nb::class_<GuardedMoveResult>(m, "GuardedMoveResult", "What became of a move, and, from the simulation, how hard it pressed.")
      .def_prop_ro("name", of(&Move::name))
      .def_prop_ro("outcome", of(&Move::outcome))
      .def_prop_ro("reason", of(&Move::reason), "where it is not as wanted")
      .def_prop_ro("begin", of(&Move::begin), "[s]")
      .def_prop_ro("end", of(&Move::end), "[s]")
      .def_prop_ro("travelled", of(&Move::travelled), "of the tool along its direction, as measured [m]")
      .def_ro("felt", &GuardedMoveResult::felt, "one contact; of a hand one of each side")
      .def_ro("corrected", &GuardedMoveResult::corrected, "fixed body that was moved in the model; empty: none")
      .def_prop_ro("correction", of(&Move::correction), "by which it was moved along the direction [m]; None: it was not")
      .def_prop_ro("correction_error", of(&Move::correction_error), "where it then is less where it is in the simulation [m]")
      .def_prop_ro("contact", of(&Move::contact), "when the first contact was made; the end where there was none [s]")
      .def_prop_ro("peak", of(&Move::peak), "largest force [N]")
      .def_prop_ro("late_peak", of(&Move::late_peak), "the same from 0.1 s after the contact on [N]")
      .def_prop_ro("last_force", of(&Move::last_force), "mean over the last 0.1 s [N]")
      .def("__repr__", [](const GuardedMoveResult& r) {
        return fmt::format("<stiction.GuardedMoveResult: {}, {}>", r.values.name, execution::to_string(r.values.outcome));
      });
}

}  // namespace

void name_moves(const TouchScenario& scenario, GuardedResult& out) {
  for (std::size_t k = 0; k < out.result.moves.size(); ++k) {
    GuardedMoveResult& move = out.moves.emplace_back();
    move.values = out.result.moves[k];
    for (const auto& felt : move.values.felt)
      move.felt.push_back({scenario.arm.model->bodies()[static_cast<std::size_t>(felt.body)].name, felt});
    if (move.values.correction) move.corrected = scenario.moves[k].correct;
  }
}

void bind_guarded(nb::module_& m) {
  bind_parts(m);
  bind_move(m);
  const auto of = [](auto member) { return [member](const GuardedResult& r) { return r.result.*member; }; };
  nb::class_<GuardedResult>(m, "GuardedResult", "What came of the moves of a scenario.")
      .def_prop_ro("status", of(&GuardedRunResult::status))
      .def_prop_ro("reached", of(&GuardedRunResult::reached), "all moves ended as they should")
      .def_prop_ro("reason", of(&GuardedRunResult::reason), "why not, or what the simulation said")
      .def_ro("moves", &GuardedResult::moves, "those that were begun")
      .def_prop_ro("places", &calc_places, "of fixed bodies that were felt, where the arm now knows them to be: name, pose in W")
      .def_prop_ro("friction", of(&GuardedRunResult::friction),
                   "of the joints, as a motion before the moves showed it; None: not asked for")
      .def_prop_ro("run", of(&GuardedRunResult::run), "series and forces of the whole run")
      .def_prop_ro("world", of(&GuardedRunResult::world), "what was simulated")
      .def_prop_ro("model", of(&GuardedRunResult::model), "what the arm knows at the end")
      .def("__repr__", [](const GuardedResult& r) {
        return fmt::format("<stiction.GuardedResult: {}, {} moves>", r.result.reached ? "reached" : r.result.reason, r.moves.size());
      });
  const auto def = [&m](auto function, const char* doc) {
    m.def("guarded_moves", function, "scenario"_a, nb::kw_only(), "seed"_a = nb::none(), "settle"_a = execution::TouchRunOptions{}.settle,
          "timeout_s"_a = nb::none(), doc);
  };
  def(&run, R"(Carries out the moves of a scenario one after the other, each until it arrives or feels something (docs/guarded_moves.md).

  scenario: one of load_touch_scenario() that has moves, or its name or file.
  seed: of torque noise and of where the misplaced is; None: the scenario's.
  settle: forces are called steady this long after their contact was made [s], >= 0.
  timeout_s: [s] > 0; None: as long as it takes.

status: Solved: `reached` says whether all moves ended as they should; MaxIterations (time used up); NumericalFailure (`reason`). Raises InvalidInput.

    >>> done = st.guarded_moves("lower_until_touch", seed=1)
    >>> done.reached, done.moves[0].outcome, done.moves[0].felt[0].link, sorted(done.places)
    (True, MoveOutcome.Felt, 'arm/link_7', ['table']))");
  def(&run_file, "The same of load_touch_scenario(scenario).");
  def_pickle<FeltContact, GuardedMoveResult, GuardedResult>();
}

}  // namespace stiction::python
