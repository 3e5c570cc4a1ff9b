#include "guarded_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "app.hpp"
#include "page_scene.hpp"

namespace stiction::app {

using core::Status;
using execution::GuardedRunResult;
using execution::TouchScenario;
using json = nlohmann::ordered_json;

bool is_gentle(const TouchScenario& scenario, const GuardedRunResult& r, double tolerance) {
  for (std::size_t k = 0; k < r.moves.size(); ++k) {
    const execution::GuardedMove& move = scenario.moves[k];
    const double asked = move.until ? move.until->force : scenario.arm.controller.lambda_max;
    if (r.moves[k].late_peak > (1 + tolerance) * asked) return false;
  }
  return true;
}

TouchVerdict judge_moves(const GuardedRunResult& r, bool gentle) { return {r.status, r.reached, "GaveUp", r.reason, gentle}; }

void print_head(std::FILE* to, const TouchScenario& scenario, const TouchVerdict& verdict, std::string_view done) {
  say(to, "{}: {}\n", scenario.arm.name,
      verdict.status != Status::Solved ? std::string(core::to_string(verdict.status))
      : !verdict.reached               ? "gave up, " + verdict.reason
                                       : fmt::format("{}, forces {}", done, verdict.bounded ? "bounded" : "above their bound"));
}

json report_head(const TouchScenario& scenario, const TouchVerdict& verdict, const execution::ControlRunResult& run, std::uint64_t seed,
                 double wall_s) {
  return {{"status", verdict.status != Status::Solved ? std::string(core::to_string(verdict.status))
                     : !verdict.reached               ? verdict.given_up
                     : verdict.bounded                ? "Passed"
                                                      : "Failed"},
          {"scenario", scenario.arm.name},
          {"seed", seed},
          {"wall_s", wall_s},
          {"message", verdict.reason},
          {"duration_s", static_cast<double>(run.samples.size()) * scenario.arm.period},
          {"lambda_max", scenario.arm.controller.lambda_max}};
}

void print_moves(std::FILE* to, const TouchScenario& scenario, const GuardedRunResult& r, bool gentle) {
  print_head(to, scenario, judge_moves(r, gentle), "all moves done");
  if (r.friction) {
    const auto row = [to](std::string_view name, const Eigen::VectorXd& values, std::string_view unit) {
      print_row(to, name, fmt::format("{:.3f} {}", fmt::join(values, " "), unit));
    };
    row("dry friction", r.friction->coulomb, "N m (N)");
    row("viscous friction", r.friction->viscous, "N m s/rad (N s/m)");
  }
  for (const execution::MoveResult& move : r.moves) {
    print_row(to, move.name,
              fmt::format("{}, {:.1f} mm in {:.2f} s", to_string(move.outcome), 1e3 * move.travelled, move.end - move.begin));
    for (const execution::FeltContact& felt : move.felt) {
      say(to, "    contact on {} ({:.0f} %) at ({:.3f} {:.3f} {:.3f}) m, force on the arm {:.1f} N along ({:.2f} {:.2f} {:.2f})\n",
          scenario.arm.model->bodies()[static_cast<std::size_t>(felt.body)].name, 100 * felt.probability, felt.p_W.x(), felt.p_W.y(),
          felt.p_W.z(), felt.force, felt.direction_W.x(), felt.direction_W.y(), felt.direction_W.z());
      say(to, "    detected after {:.0f} ms, reported after {:.2f} s\n", 1e3 * (felt.alarm - move.contact), felt.time - move.contact);
    }
    if (move.peak > 0)
      say(to, "    largest force {:.1f} N, from 0.1 s after the contact on {:.1f} N, at the end {:.2f} N\n", move.peak, move.late_peak,
          move.last_force);
    if (move.correction)
      say(to, "    {} moved by {:.1f} mm in the model; remaining error {:.2f} mm\n",
          scenario.moves[static_cast<std::size_t>(&move - r.moves.data())].correct, 1e3 * *move.correction, 1e3 * *move.correction_error);
  }
  print_row(to, "duration", fmt::format("{:.1f} s simulated", static_cast<double>(r.run.samples.size()) * scenario.arm.period));
}

namespace {

json to_json(const TouchScenario& scenario, const execution::MoveResult& move) {
  json out{{"name", move.name},           {"outcome", to_string(move.outcome)}, {"message", move.reason},    {"begin_s", move.begin},
           {"end_s", move.end},           {"travelled", move.travelled},        {"contact_s", move.contact}, {"peak", move.peak},
           {"late_peak", move.late_peak}, {"last_force", move.last_force}};
  if (move.correction) out["correction"] = *move.correction, out["correction_error"] = *move.correction_error;
  out["felt"] = json::array();
  for (const execution::FeltContact& felt : move.felt)
    out["felt"].push_back({{"link", scenario.arm.model->bodies()[static_cast<std::size_t>(felt.body)].name},
                           {"probability", felt.probability},
                           {"p_W", page_numbers(felt.p_W)},
                           {"direction_W", page_numbers(felt.direction_W)},
                           {"force", felt.force},
                           {"time_s", felt.time},
                           {"begin_s", felt.begin},
                           {"alarm_s", felt.alarm}});
  return out;
}

}  // namespace

json report_moves(const TouchScenario& scenario, const GuardedRunResult& r, std::uint64_t seed, bool gentle, double wall_s) {
  json out = report_head(scenario, judge_moves(r, gentle), r.run, seed, wall_s);
  if (r.friction)
    out["friction"] = {{"coulomb", std::vector<double>(r.friction->coulomb.begin(), r.friction->coulomb.end())},
                       {"viscous", std::vector<double>(r.friction->viscous.begin(), r.friction->viscous.end())},
                       {"left", std::vector<double>(r.friction->left.begin(), r.friction->left.end())}};
  out["moves"] = json::array();
  for (const auto& move : r.moves) out["moves"].push_back(to_json(scenario, move));
  return out;
}

}  // namespace stiction::app
