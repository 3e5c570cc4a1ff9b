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
  nb::enum_<MoveOutcome>(m, "MoveOutcome", "How a guarded move ended.")
      .value("Arrived", MoveOutcome::Arrived, "the tool reached the end of the path")
      .value("Felt", MoveOutcome::Felt, "the arm felt the expected contact, and presses with the force of the move")
      .value("Lost", MoveOutcome::Lost, "the arm lost the contact that it pressed on: an edge")
      .value("NotFelt", MoveOutcome::NotFelt, "the tool reached the end of the path without the expected contact")
      .value("WrongLink", MoveOutcome::WrongLink, "the arm felt a contact on a link that the move does not name")
      .value("StillThere", MoveOutcome::StillThere, "the tool reached the end of the path without losing the contact that it pressed on");
  const auto of = [](auto member) { return [member](const FeltContact& f) { return f.values.*member; }; };
  using Felt = execution::FeltContact;
  nb::class_<FeltContact>(m, "FeltContact", "Contact that ended a move, as estimated from joint torques. Times are times of the run.")
      .def_ro("link", &FeltContact::link, "link in contact, as robot/link")
      .def_prop_ro("probability", of(&Felt::probability), "probability that the contact is on this link")
      .def_prop_ro("p_W", of(&Felt::p_W), "contact point in W [m] (3)")
      .def_prop_ro("direction_W", of(&Felt::direction_W), "unit direction of the force on the arm in W (3)")
      .def_prop_ro("force", of(&Felt::force), "contact force [N]")
      .def_prop_ro("begin", of(&Felt::begin), "time at which the contact began [s]")
      .def_prop_ro("alarm", of(&Felt::alarm), "time at which the contact was detected and the arm stopped [s]")
      .def_prop_ro("time", of(&Felt::time), "time at which the contact was located, while the arm pressed with the force of the move [s]")
      .def("__repr__", [](const FeltContact& f) { return fmt::format("<stiction.FeltContact: {}, {:.3g} N>", f.link, f.values.force); });
}

void bind_move(nb::module_& m) {
  const auto of = [](auto member) { return [member](const GuardedMoveResult& r) { return r.values.*member; }; };
  using Move = execution::MoveResult;
  nb::class_<GuardedMoveResult>(m, "GuardedMoveResult", "Result of one guarded move, with the true contact forces of the simulation.")
      .def_prop_ro("name", of(&Move::name), "name of the move")
      .def_prop_ro("outcome", of(&Move::outcome), "how the move ended")
      .def_prop_ro("reason", of(&Move::reason), "explanation if the outcome is not the expected one")
      .def_prop_ro("begin", of(&Move::begin), "time at which the move began [s]")
      .def_prop_ro("end", of(&Move::end), "time at which the move ended [s]")
      .def_prop_ro("travelled", of(&Move::travelled), "measured distance that the tool moved along its direction [m]")
      .def_ro("felt", &GuardedMoveResult::felt, "contacts that were felt: one, or one for each side of a hand")
      .def_ro("corrected", &GuardedMoveResult::corrected, "name of the fixed body whose place was corrected in the model; empty: none")
      .def_prop_ro("correction", of(&Move::correction),
                   "distance by which this body was moved along the direction of the move [m]; None: no correction")
      .def_prop_ro("correction_error", of(&Move::correction_error),
                   "error of the corrected place: its position minus the true position [m]")
      .def_prop_ro("contact", of(&Move::contact), "time of the first contact in the simulation; the end of the move if there was none [s]")
      .def_prop_ro("peak", of(&Move::peak), "largest contact force [N]")
      .def_prop_ro("late_peak", of(&Move::late_peak), "largest contact force later than 0.1 s after the first contact [N]")
      .def_prop_ro("last_force", of(&Move::last_force), "mean contact force over the last 0.1 s [N]")
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
  nb::class_<GuardedResult>(m, "GuardedResult", "Result of guarded_moves().")
      .def_prop_ro("status", of(&GuardedRunResult::status), "see guarded_moves()")
      .def_prop_ro("reached", of(&GuardedRunResult::reached), "True: all moves ended as expected")
      .def_prop_ro("reason", of(&GuardedRunResult::reason), "why a move did not end as expected, or the error of the simulation")
      .def_ro("moves", &GuardedResult::moves, "results of the moves that were begun")
      .def_prop_ro("places", &calc_places, "corrected poses of the fixed bodies that the arm felt: {name: pose in W}")
      .def_prop_ro("friction", of(&GuardedRunResult::friction),
                   "joint friction that was identified by a motion before the moves; None: not asked for")
      .def_prop_ro("run", of(&GuardedRunResult::run), "samples and forces of the whole run")
      .def_prop_ro("world", of(&GuardedRunResult::world), "model that was simulated")
      .def_prop_ro("model", of(&GuardedRunResult::model), "model that the arm knows at the end, with corrected places")
      .def("__repr__", [](const GuardedResult& r) {
        return fmt::format("<stiction.GuardedResult: {}, {} moves>", r.result.reached ? "reached" : r.result.reason, r.moves.size());
      });
  const auto def = [&m](auto function, const char* doc) {
    m.def("guarded_moves", function, "scenario"_a, nb::kw_only(), "seed"_a = nb::none(), "settle"_a = execution::TouchRunOptions{}.settle,
          "timeout_s"_a = nb::none(), doc);
  };
  def(&run,
      R"(Simulates guarded moves: the arm moves in a straight line until it arrives or feels a contact in its joint torques (docs/guarded_moves.md).

Use guarded moves to find a table, a wall or an edge whose place in the model is wrong. The moves of a scenario are carried out one after
the other.

  scenario: TouchScenario of load_touch_scenario() that has moves, or its name or file.
  seed: of the torque noise and of the true places of misplaced bodies. None: the seed of the scenario.
  settle: time after the start of a contact from which its force counts as steady [s], >= 0.
  timeout_s: largest wall time [s], > 0. None: no limit.

Returns a GuardedResult. Its status is Solved if the simulation came to its end; `reached` tells whether all moves ended as expected.
Otherwise it is MaxIterations: the time was used up; or NumericalFailure: see `reason`. Raises InvalidInput.

    >>> done = st.guarded_moves("lower_until_touch", seed=1)
    >>> done.reached, done.moves[0].outcome, done.moves[0].felt[0].link, sorted(done.places)
    (True, MoveOutcome.Felt, 'arm/link_7', ['table']))");
  def(&run_file, "The same for load_touch_scenario(scenario): give the name or file of a scenario.");
  def_pickle<FeltContact, GuardedMoveResult, GuardedResult>();
}

}  // namespace stiction::python
