#include "touch_page.hpp"

#include <fmt/format.h>

#include "control_page.hpp"
#include "page_scene.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::app {
namespace {

using Json = nlohmann::ordered_json;

/// Where the last link of the robot is along postures: what of a route can be drawn.
class TipPath {
 public:
  explicit TipPath(const world::Model& model) : model_(model), work_(model), q_(model.neutral()) {
    for (int b = 0; b < static_cast<int>(model.geometries().size()); ++b) {
      const auto& geometry = model.geometries()[static_cast<std::size_t>(b)];
      if (model.bodies()[static_cast<std::size_t>(geometry.body)].kind == world::BodyKind::Robot) tip_ = b;
    }
  }

  Json operator()(const std::vector<Eigen::VectorXd>& postures) {
    constexpr int kPoints = 20;  // between two postures
    Json out = Json::array();
    for (std::size_t k = 0; k + 1 < postures.size(); ++k)
      for (int i = k == 0 ? 0 : 1; i <= kPoints; ++i) {
        const double s = static_cast<double>(i) / kPoints;
        q_.tail(model_.n_a()) = (1 - s) * postures[k] + s * postures[k + 1];
        world::calc_kinematics(model_, q_, work_, kinematics_);
        const auto& geometry = model_.geometries()[static_cast<std::size_t>(tip_)];
        out.push_back(page_numbers(kinematics_.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter));
      }
    return out;
  }

 private:
  const world::Model& model_;
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  Eigen::VectorXd q_;
  int tip_ = 0;
};

Json to_json(const world::Model& model, const execution::Touch& touch) {
  return {{"t", touch.time},
          {"link", model.bodies()[static_cast<std::size_t>(touch.body)].name},
          {"point", page_numbers(touch.place.p_W)},
          {"normal", page_numbers(touch.place.n_W)},
          {"spread", touch.place.spread},
          {"radius", touch.radius},
          {"force", touch.force},
          {"error", std::isfinite(touch.error) ? Json(touch.error) : Json()}};
}

}  // namespace

std::string touch_document(const execution::TouchScenario& scenario, const execution::TouchRunResult& result) {
  execution::ControlScenario arm = scenario.arm;
  arm.model = result.world;
  Json out = Json::parse(control_document(arm, result.run, "contact_aware"));
  out["format"] = "stiction-touch";
  out["outcome"] = execution::to_string(result.outcome);
  out["reason"] = result.reason;
  out["unknown"] = Json::array();
  for (const auto& unknown : scenario.unknown) out["unknown"].push_back(unknown.body.name);
  const auto& joints = scenario.arm.model->scales().joints();
  for (std::size_t k = 0; k < result.run.samples.size(); ++k) {
    const execution::ControlSample& s = result.run.samples[k];
    out["ticks"][k]["to_goal"] = (s.q - scenario.goal).cwiseAbs().cwiseQuotient(joints).maxCoeff();
    if (s.reported.empty()) continue;  // the likeliest
    out["ticks"][k]["told"] = {{"point", page_numbers(s.reported.front().p_WC)}, {"force", page_numbers(s.reported.front().force_W)}};
  }
  out["touches"] = out["routes"] = Json::array();
  for (const auto& touch : result.touches) out["touches"].push_back(to_json(*scenario.arm.model, touch));
  TipPath path(*scenario.arm.model);
  for (const auto& planned : result.routes)
    out["routes"].push_back({{"t", planned.time}, {"share", planned.route.share}, {"points", path(planned.route.postures)}});
  return out.dump();
}

}  // namespace stiction::app
