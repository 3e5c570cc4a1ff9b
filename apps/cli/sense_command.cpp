#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "python_start.hpp"
#include "sense_page.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/contact_control/poke.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/sensing_scenario_file.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

using Json = nlohmann::ordered_json;

struct SenseArguments {
  std::string scenario;
  std::string html;
  std::vector<double> rest;     ///< from when to when nothing touches the robot [s]
  std::optional<double> noise;  ///< [N·m]
  bool turn = false;            ///< the sign is the other one
  std::optional<double> force;  ///< of the contact whose detectability is drawn [N]; nothing: as the scenario has it
  bool json = false;
  bool live = false;
  std::string host = "127.0.0.1";
  int port = 8080;
};

Json to_json(const sensing::Scenario& scenario, const sensing::Candidate& c) {
  Json out;
  out["link"] = scenario.sensor->link_name(c.best.link);
  out["explains"] = c.explains;
  out["residual"] = c.best.residual;
  out["objective"] = c.objective;
  out["p_L"] = page_numbers(c.best.p_L);
  out["n_L"] = page_numbers(c.best.n_L);
  out["f_L"] = page_numbers(c.best.f_L);
  out["p_W"] = page_numbers(c.p_W);
  out["n_W"] = page_numbers(c.n_W);
  out["f_W"] = page_numbers(c.f_W);
  if (scenario.options.posterior) out["probability"] = c.probability;
  out["rank"] = c.rank;
  out["extent"] = c.extent;
  out["force_spread"] = c.force_spread;
  out["points"] = c.count;
  return out;
}

void print_candidate(std::FILE* to, const sensing::Scenario& scenario, const sensing::Candidate& c) {
  const std::string share = scenario.options.posterior ? fmt::format("  {:3.0f} %", 100 * c.probability) : "";
  say(to, "  {:24} {}{}  ({:6.3f} {:6.3f} {:6.3f}) m  {:5.1f} N  left over {:.2g} N·m  extent {:.1f} cm\n",
      scenario.sensor->link_name(c.best.link), c.explains ? "explains" : "        ", share, c.p_W.x(), c.p_W.y(), c.p_W.z(), c.f_W.norm(),
      std::sqrt(c.best.residual), 100 * c.extent);
}

const std::string& joint_name(const sensing::Scenario& scenario, int joint) {
  const world::Model& model = scenario.sensor->model();
  return model.dofs()[static_cast<std::size_t>(model.n_vu() + joint)].name;
}

/// What torques show at most, against what they would have to show.
Json report_largest(std::FILE* to, const sensing::Scenario& scenario, const sensing::SenseResult& result) {
  const std::string& joint = joint_name(scenario, result.largest.joint);
  if (result.verdict == sensing::Verdict::BelowThreshold)
    say(to, "  the largest torque against its noise is {:.3g} N·m of {}, which shows a contact from {:.3g} N·m on\n", result.largest.torque,
        joint, result.threshold);
  return {{"joint", joint}, {"torque", result.largest.torque}, {"noise", result.largest.noise}, {"threshold", result.threshold}};
}

/// The links that may be touched, and whether any is.
Json report_posterior(std::FILE* to, const sensing::Scenario& scenario, const sensing::Posterior& posterior) {
  Json out{{"nothing", posterior.nothing}, {"links", Json::object()}, {"credible", Json::array()}};
  for (std::size_t i = 0; i < posterior.links.size(); ++i)
    out["links"][scenario.sensor->link_name(static_cast<int>(i))] = posterior.links[i];
  std::string text;
  for (const int link : posterior.credible) {
    out["credible"].push_back(scenario.sensor->link_name(link));
    text += fmt::format(", {} {:.0f} %", scenario.sensor->link_name(link), 100 * posterior.links[static_cast<std::size_t>(link)]);
  }
  if (posterior.nothing > 0.5) text.clear();
  say(to, "  probably: nothing {:.0f} %{}\n", 100 * posterior.nothing, text);
  return out;
}

Json to_json(const sensing::Scenario& scenario, const sensing::ContactSetResult& result) {
  Json out{{"verdict", sensing::to_string(result.verdict)}, {"contacts", result.contacts}, {"ambiguous", result.ambiguous}};
  out["groups"] = Json::array();
  for (const sensing::ContactGroup& group : result.groups) {
    const sensing::ContactSet& best = result.sets[static_cast<std::size_t>(group.first)];
    Json entry{{"sets", group.count}, {"residual", best.residual}, {"freedom", best.freedom}, {"contacts", Json::array()}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(best.count); ++i) {
      const sensing::ContactPoint& point = best.contacts[i];
      entry["contacts"].push_back({{"link", scenario.sensor->link_name(point.link)},
                                   {"p_L", page_numbers(point.p_L)},
                                   {"n_L", page_numbers(point.n_L)},
                                   {"f_L", page_numbers(point.f_L)},
                                   {"deviation", best.deviation[i]},
                                   {"point_is_unique", best.point_is_unique[i]},
                                   {"extent", group.extent[i]}});
    }
    out["groups"].push_back(std::move(entry));
  }
  return out;
}

void print_sets(std::FILE* to, const sensing::Scenario& scenario, const sensing::ContactSetResult& result) {
  say(to, "  {} contact{} at the same time: {}{}\n", result.contacts, result.contacts == 1 ? "" : "s", sensing::to_string(result.verdict),
      result.ambiguous ? ", ambiguous" : "");
  for (const sensing::ContactGroup& group : result.groups) {
    const sensing::ContactSet& best = result.sets[static_cast<std::size_t>(group.first)];
    for (std::size_t i = 0; i < static_cast<std::size_t>(best.count); ++i) {
      const sensing::ContactPoint& point = best.contacts[i];
      say(to, "  {} {:24} {:5.1f} N  point {} {:.1f} cm\n", i == 0 ? "set" : "  &", scenario.sensor->link_name(point.link),
          point.f_L.norm(), best.point_is_unique[i] ? "±" : "not unique, ±", 100 * best.deviation[i]);
    }
  }
}

using KnownContacts = std::span<const sensing::ContactPoint>;

/// Distance of known contacts from the nearest answer: a candidate where there is one contact, a set where there are several; infinite: none.
double calc_distance(KnownContacts contacts, const sensing::SenseResult& single, const sensing::ContactSetResult& sets) {
  double out = std::numeric_limits<double>::infinity();
  if (contacts.size() == 1)
    for (const sensing::Candidate& candidate : single.candidates)
      if (candidate.explains) out = std::min(out, sensing::calc_distance(single, candidate, contacts[0]));
  if (sets.verdict == sensing::Verdict::Explained)
    for (const sensing::ContactSet& set : sets.sets) out = std::min(out, sensing::calc_distance(set, contacts));
  return out;
}

void report_distance(std::FILE* to, const sensing::Scenario& scenario, KnownContacts contacts, double distance, Json& moment) {
  if (contacts.empty()) return;
  const bool found = std::isfinite(distance);
  std::string links;
  for (const sensing::ContactPoint& contact : contacts) links += (links.empty() ? "" : " and ") + scenario.sensor->link_name(contact.link);
  say(to, "  the known contact on {} is {}\n", links,
      found ? fmt::format("{:.1f} cm from the nearest candidate", 100 * distance) : "not among the candidates");
  moment["distance"] = found ? Json(distance) : Json();
}

/// One scenario, moment by moment.
class SenseRun {
 public:
  SenseRun(const sensing::Scenario& scenario, std::FILE* to, SensePage* page)
      : scenario_(scenario), to_(to), page_(page), work_(scenario.sensor), set_work_(scenario.sensor) {}

  Json run(std::size_t i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double time = scenario_.series.times[i];
    const Eigen::VectorXd q = sensing::place_robots(scenario_.sensor->model(), scenario_.series.q.col(column)),
                          tau = scenario_.series.tau.col(column);
    const bool is_after_gap = std::binary_search(scenario_.series.gaps.begin(), scenario_.series.gaps.end(), static_cast<int>(i));
    if (is_after_gap) last_.clear(), last_sets_.clear();
    const auto begin = std::chrono::steady_clock::now();
    sensing::sense(*scenario_.sensor, {q, tau, &last_}, scenario_.options, work_, result_);
    if (scenario_.asks_for_sets())
      sensing::sense_contacts(*scenario_.sensor, {q, tau, scenario_.base_at(i), &last_sets_}, scenario_.set_options(), set_work_, sets_);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    last_ = result_.best_points();
    last_sets_ = sets_.sets;
    if (page_ != nullptr) page_->add(i, q, tau, result_, sets_);
    explained_ += result_.verdict == sensing::Verdict::Explained || sets_.verdict == sensing::Verdict::Explained;
    say(to_, "{} t = {:.3f} s: {}, {} of {} samples accepted, {} descents, {:.2f} ms{}\n", scenario_.name, time,
        sensing::to_string(result_.verdict), result_.accepted, result_.samples, result_.descents, 1e3 * seconds, say_friction());
    Json moment{{"t", time}, {"verdict", sensing::to_string(result_.verdict)}, {"friction", result_.friction}, {"seconds", seconds}};
    moment["largest"] = report_largest(to_, scenario_, result_);
    if (scenario_.options.posterior) moment["posterior"] = report_posterior(to_, scenario_, result_.posterior);
    moment["candidates"] = Json::array();
    for (const auto& candidate : result_.candidates) {
      print_candidate(to_, scenario_, candidate);
      moment["candidates"].push_back(to_json(scenario_, candidate));
    }
    if (scenario_.asks_for_sets()) {
      print_sets(to_, scenario_, sets_);
      moment["contact_sets"] = to_json(scenario_, sets_);
    }
    const std::vector<sensing::ContactPoint> contacts = scenario_.contacts_at(i);
    report_distance(to_, scenario_, contacts, calc_distance(contacts, result_, sets_), moment);
    return moment;
  }

  bool explained() const { return explained_; }

 private:
  std::string say_friction() const {
    return result_.friction > scenario_.options.cone.friction() ? fmt::format(", with μ = {:.2f}", result_.friction) : "";
  }

  const sensing::Scenario& scenario_;
  std::FILE* to_;
  SensePage* page_;
  sensing::SenseWorkspace work_;
  sensing::ContactSetWorkspace set_work_;
  sensing::SenseResult result_;
  sensing::ContactSetResult sets_;
  std::vector<sensing::ContactPoint> last_;
  std::vector<sensing::ContactSet> last_sets_;
  bool explained_ = false;
};

/// What the command line says of torques, over the scenario.
void override_torques(const SenseArguments& arguments, sensing::Scenario& scenario) {
  if (scenario.is_computed() && (arguments.turn || !arguments.rest.empty()))
    core::throw_invalid(arguments.turn ? "--turn" : "--rest", "a scenario whose torques are computed from contacts",
                        "one of measured torques, from 'torques' or 'series'");
  if (arguments.turn && scenario.options.torques.sign < 0)
    say(stderr, "stiction: warning: --turn reverses sensing.sign: -1 of the scenario, so the torques count as they are in the log\n");
  if (arguments.turn) scenario.options.torques.sign *= -1;
  if (arguments.noise) {
    core::require_positive("--noise", *arguments.noise);
    scenario.options.noise = *arguments.noise;
    scenario.options.torques.covariance.resize(0, 0);
    scenario.options.torques.deviations.resize(0);
  }
  if (arguments.rest.empty()) return;
  std::vector<Eigen::Index> moments;
  const auto& times = scenario.series.times;
  for (std::size_t i = 0; i < times.size(); ++i)
    if (times[i] >= arguments.rest[0] && times[i] <= arguments.rest[1]) moments.push_back(static_cast<Eigen::Index>(i));
  if (moments.empty())
    core::throw_invalid("--rest", fmt::format("{} {}", arguments.rest[0], arguments.rest[1]),
                        fmt::format("seconds of the record, which has {} to {}", times.front(), times.back()));
  sensing::set_rest(scenario, moments, !arguments.noise);
}

int run_sense(const SenseArguments& arguments) {
  if (arguments.live)
    become_python(
        "sense", Packages::ViewerAndModule,
        {"stiction_view.studio.sense_live", "--host", arguments.host, "--port", std::to_string(arguments.port), "--", arguments.scenario});
  require_page(arguments.html);
  sensing::Scenario scenario =
      tasks::load_sensing_scenario(tasks::find_scenario(arguments.scenario, data_dirs()), tasks::default_package_dirs());
  override_torques(arguments, scenario);
  for (const std::string& note : scenario.sensor->notes()) say(stderr, "note: {}\n", note);
  for (const std::string& note : scenario.series.notes) say(stderr, "note: {}\n", note);
  for (const int gap : scenario.series.gaps)
    say(stderr, "note: no line for {:.3g} s before t = {:.3f} s; the search at this time does not start from earlier candidates\n",
        scenario.series.times[static_cast<std::size_t>(gap)] - scenario.series.times[static_cast<std::size_t>(gap) - 1],
        scenario.series.times[static_cast<std::size_t>(gap)]);
  if (std::string message; execution::simulate_poke(scenario, message) != core::Status::Solved) {
    say(stderr, "stiction: {}: poke: the simulation failed: {}\n", scenario.name, message);
    return kInternalError;
  }
  std::FILE* const to = people(arguments.json);
  std::optional<SensePage> page;
  if (!arguments.html.empty()) page.emplace(scenario);
  SenseRun run(scenario, to, page ? &*page : nullptr);
  Json moments = Json::array();
  for (std::size_t i = 0; i < scenario.series.times.size(); ++i) moments.push_back(run.run(i));
  const bool page_failed = page && !write_page(page->document(arguments.force.value_or(0)), arguments.html, to);
  if (arguments.json) {
    Json out{{"status", run.explained() ? "Explained" : "NotExplained"}, {"scenario", scenario.name}, {"moments", std::move(moments)}};
    if (page && !page_failed) out["page"] = arguments.html;
    say(stdout, "{}\n", out.dump());
  }
  return page_failed ? kInternalError : kDone;
}

}  // namespace

Run declare_sense(CLI::App& command) {
  const auto arguments = std::make_shared<SenseArguments>();
  SenseArguments& a = *arguments;
  command.add_option("scenario", a.scenario, "Name of a built-in scenario, or a scenario file (.yaml)")->required();
  command.add_option("--html", a.html,
                     "HTML page to write, with residuals and detectability on the robot, and candidate contacts with their forces");
  command
      .add_option("--rest", a.rest,
                  "Interval of the record in which nothing touches the robot [s]; offset and noise of the joint torques are taken from it")
      ->expected(2)
      ->type_name("FROM TO");
  add_number(command, "--noise", a.noise, "Standard deviation of every joint torque [N m] (default: from --rest, or as in the scenario)",
             Bound::Positive);
  command.add_flag(
      "--turn", a.turn,
      "Reverse the sign of the torques of the scenario. Use it for libfranka, whose torques are those that the robot exerts on its "
      "surroundings");
  add_number(
      command, "--force", a.force,
      "Size of the contact force for which the page shows the detectability [N] (default: force of the known contact, or of the first "
      "candidate)",
      Bound::Positive);
  add_json(command, a.json);
  const auto live =
      command.add_flag("--live", a.live, "Serve a page that plays the record in real time, and on which a click pushes the robot")
          ->excludes("--json")
          ->excludes("--html");
  for (const char* option : {"--rest", "--noise", "--turn", "--force"}) live->excludes(option);  // the page takes them from the scenario
  command.add_option("--host", a.host, "Address of the server; with 0.0.0.0, everyone who has the token can connect from any machine")
      ->capture_default_str()
      ->needs(live);
  add_integer(command, "--port", a.port, "Port of the server; 0 selects a free port", {0, 65535})->needs(live);
  return [arguments] { return run_sense(*arguments); };
}

}  // namespace stiction::app
