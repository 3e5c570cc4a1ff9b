#include "control_page.hpp"

#include <algorithm>
#include <cmath>

#include "page_scene.hpp"

namespace stiction::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxFrames = 600;  // of the page

/// @param hand  link that a hand presses on
Json to_json(const world::Model& model, const simulation::PairForce& f, int hand) {
  Json out{{"pair", f.pair}};
  if (f.pair < 0) {
    out["a"] = model.bodies()[static_cast<std::size_t>(hand)].name, out["b"] = "hand";
  } else {
    const auto& pair = model.pairs()[static_cast<std::size_t>(f.pair)];
    for (const auto& [key, geometry] : {std::pair{"a", pair.geometry_a}, {"b", pair.geometry_b}})
      out[key] = model.geometries()[static_cast<std::size_t>(geometry)].name;
  }
  out["point"] = page_numbers(f.p_WC);
  out["force"] = page_numbers(f.force_W);
  return out;
}

/// Units of hinges and of sliders, as far as a robot has them.
std::string units_of_joints(const world::Model& model, const std::string& hinge, const std::string& slider) {
  const auto joints = model.dofs().last(static_cast<std::size_t>(model.n_a()));
  const auto sliders = std::ranges::count(joints, world::DofKind::Prismatic, &world::Dof::kind);
  return sliders == 0 ? hinge : sliders == model.n_a() ? slider : hinge + ", " + slider;
}

}  // namespace

std::string error_unit(const execution::ControlScenario& scenario) {
  return scenario.tool >= 0 ? "mm" : units_of_joints(*scenario.model, "mrad", "mm");
}

std::string control_document(const execution::ControlScenario& scenario, const execution::ControlRunResult& result, std::string_view law) {
  const world::Model& model = *scenario.model;
  Json out{{"format", "stiction-control"}, {"format_version", 1}, {"scenario", scenario.name}, {"description", scenario.description}};
  out["law"] = law;
  out["lambda_max"] = scenario.controller.lambda_max;
  out["error_unit"] = error_unit(scenario);
  out["torque_unit"] = units_of_joints(model, "N·m", "N");
  out["joints"] = out["effort"] = Json::array();
  for (int j = 0; j < model.n_a(); ++j) {
    out["joints"].push_back(model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name);
    const double most = model.effort()[j];
    out["effort"].push_back(std::isfinite(most) ? Json(most) : Json());
  }
  PageScene scene(model);
  scene.write(out);
  out["ticks"] = out["frames"] = Json::array();
  for (const execution::ControlSample& s : result.samples) {
    Json forces = Json::array();
    for (const auto& f : s.forces) forces.push_back(to_json(model, f, scenario.hand.body));
    out["ticks"].push_back({{"t", s.time},
                            {"error", s.error},
                            {"slack", s.slack},
                            {"bounded", s.bounded},
                            {"torque", std::vector<double>(s.torque.begin(), s.torque.end())},
                            {"forces", std::move(forces)}});
  }
  Eigen::VectorXd q = model.neutral();
  const std::size_t n = result.samples.size(), shown = std::min(n, kMaxFrames);
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t k = shown == 1 ? 0 : i * (n - 1) / (shown - 1);
    q.tail(model.n_a()) = result.samples[k].q;
    out["frames"].push_back({{"tick", k}, {"bodies", scene.poses(q)}});
  }
  return out.dump();
}

}  // namespace stiction::app
