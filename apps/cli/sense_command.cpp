#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "sense_page.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

using Json = nlohmann::ordered_json;

struct SenseArguments {
  std::string scenario;
  std::string html;
  double force = 0;  ///< of the contact whose detectability is drawn [N]; 0: as the scenario has it
  bool json = false;
};

Json to_json(const sensing::Scenario& scenario, const sensing::Candidate& c) {
  Json out;
  out["link"] = scenario.sensor->link_name(c.best.link);
  out["explains"] = c.explains;
  out["residual"] = c.best.residual;
  out["p_L"] = page_numbers(c.best.p_L);
  out["n_L"] = page_numbers(c.best.n_L);
  out["f_L"] = page_numbers(c.best.f_L);
  out["p_W"] = page_numbers(c.p_W);
  out["n_W"] = page_numbers(c.n_W);
  out["f_W"] = page_numbers(c.f_W);
  out["rank"] = c.rank;
  out["extent"] = c.extent;
  out["force_spread"] = c.force_spread;
  out["points"] = c.count;
  return out;
}

void print_candidate(std::FILE* to, const sensing::Scenario& scenario, const sensing::Candidate& c) {
  fmt::print(to, "  {:24} {}  ({:6.3f} {:6.3f} {:6.3f}) m  {:5.1f} N  left over {:.2g} N·m  extent {:.1f} cm\n",
             scenario.sensor->link_name(c.best.link), c.explains ? "explains" : "        ", c.p_W.x(), c.p_W.y(), c.p_W.z(), c.f_W.norm(),
             std::sqrt(c.best.residual), 100 * c.extent);
}

int run_sense(const SenseArguments& arguments) {
  require_page(arguments.html);
  const sensing::Scenario scenario =
      sensing::load_scenario(tasks::find_scenario(arguments.scenario, data_dirs()), tasks::default_package_dirs());
  for (const std::string& note : scenario.sensor->notes()) fmt::print(stderr, "note: {}\n", note);
  std::FILE* const to = people(arguments.json);
  sensing::SenseWorkspace work(scenario.sensor);
  sensing::SenseResult result;
  std::vector<sensing::ContactPoint> last;
  Json moments = Json::array();
  std::optional<SensePage> page;
  if (!arguments.html.empty()) page.emplace(scenario);
  int explained = 0;
  for (std::size_t i = 0; i < scenario.series.times.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd q = sensing::place_robots(scenario.sensor->model(), scenario.series.q.col(column));
    const auto begin = std::chrono::steady_clock::now();
    sensing::sense(*scenario.sensor, {q, scenario.series.tau.col(column), &last}, scenario.options, work, result);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    last = result.best_points();
    if (page) page->add(scenario.series.times[i], q, scenario.series.tau.col(column), result);
    explained += result.verdict == sensing::Verdict::Explained;
    fmt::print(to, "{} t = {:.3f} s: {}, {} of {} samples accepted, {} descents, {:.2f} ms\n", scenario.name, scenario.series.times[i],
               sensing::to_string(result.verdict), result.accepted, result.samples, result.descents, 1e3 * seconds);
    Json moment{{"t", scenario.series.times[i]}, {"verdict", sensing::to_string(result.verdict)}, {"seconds", seconds}};
    moment["candidates"] = Json::array();
    double distance = std::numeric_limits<double>::infinity();
    for (const auto& candidate : result.candidates) {
      print_candidate(to, scenario, candidate);
      moment["candidates"].push_back(to_json(scenario, candidate));
      if (scenario.contact && candidate.explains)
        distance = std::min(distance, sensing::calc_distance(result, candidate, *scenario.contact));
    }
    if (scenario.contact) {
      const bool found = std::isfinite(distance);
      fmt::print(to, "  the contact on {} is {}\n", scenario.sensor->link_name(scenario.contact->link),
                 found ? fmt::format("{:.1f} cm from the nearest candidate", 100 * distance) : "not among them");
      moment["distance"] = found ? Json(distance) : Json();
    }
    moments.push_back(std::move(moment));
  }
  const bool page_failed = page && !write_page(page->document(arguments.force), arguments.html, to);
  if (arguments.json) {
    Json out{{"status", explained > 0 ? "Explained" : "NotExplained"}, {"scenario", scenario.name}, {"moments", std::move(moments)}};
    if (page && !page_failed) out["page"] = arguments.html;
    fmt::print("{}\n", out.dump());
  }
  return page_failed ? kInternalError : kDone;
}

}  // namespace

Run declare_sense(CLI::App& command) {
  const auto arguments = std::make_shared<SenseArguments>();
  SenseArguments& a = *arguments;
  command.add_option("scenario", a.scenario, "Name of a built-in scenario, or a scenario file (.yaml)")->required();
  command.add_option("--html", a.html, "Write a page to look at: residuals and detectability on the robot, candidates with their forces");
  command
      .add_option(
          "--force", a.force,
          "Detectability on the page is that of a force of this size [N] (default: that of the known contact, or of the first candidate)")
      ->check(CLI::PositiveNumber);
  add_json(command, a.json);
  return [arguments] { return run_sense(*arguments); };
}

}  // namespace stiction::app
