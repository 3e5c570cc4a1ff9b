#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {

namespace {

int run_tasks(bool json) {
  std::FILE* const to = people(json);
  const auto dirs = data_dirs();
  nlohmann::ordered_json out;
  out["status"] = "Done";
  out["tasks"] = nlohmann::ordered_json::array();
  say(to, "{:28} {:>7} {:>7} {:>5} {:>6}  {}\n", "task", "objects", "joints", "n_v", "pairs", "");
  for (const auto& name : tasks::list_tasks(dirs)) {
    const tasks::Task task = tasks::load_task(name, dirs);
    const world::Model& model = *task.model;
    say(to, "{:28} {:7} {:7} {:5} {:6}  {}\n", name, model.objects().size(), model.n_a(), model.n_v(), model.pairs().size(),
        task.description);
    nlohmann::ordered_json entry;
    entry["name"] = name;
    entry["description"] = task.description;
    entry["objects"] = model.objects().size();
    entry["joints"] = model.n_a();
    entry["n_q"] = model.n_q();
    entry["n_v"] = model.n_v();
    entry["geometries"] = model.geometries().size();
    entry["pairs"] = model.pairs().size();
    entry["tolerance"] = {{"position", task.problem.goal.tol_position}, {"angle", task.problem.goal.tol_angle}};
    entry["scene_sha256"] = task.scene_sha256;
    out["tasks"].push_back(std::move(entry));
  }
  if (json) say(stdout, "{}\n", out.dump());
  return kDone;
}

}  // namespace

Run declare_tasks(CLI::App& command) {
  const auto json = std::make_shared<bool>(false);
  add_json(command, *json);
  return [json] { return run_tasks(*json); };
}

}  // namespace stiction::app
