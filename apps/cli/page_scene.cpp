#include "page_scene.hpp"

#include <filesystem>

#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::app {

using Json = nlohmann::ordered_json;

PageScene::PageScene(const world::Model& model, const std::vector<int>& hidden)
    : model_(model), work_(model), place_(model.bodies().size(), -1), hidden_(model.bodies().size(), 0) {
  for (const int body : hidden) hidden_[static_cast<std::size_t>(body)] = 1;
  for (const auto& geometry : model.geometries()) place_[static_cast<std::size_t>(geometry.body)] = 0;
  for (std::size_t body = 0; body < place_.size(); ++body)
    if (model.bodies()[body].kind == world::BodyKind::Robot) place_[body] = 0;
  for (int body = 0; body < static_cast<int>(place_.size()); ++body) {
    if (place(body) < 0) continue;
    place_[static_cast<std::size_t>(body)] = static_cast<int>(shown_.size());
    shown_.push_back(body);
  }
}

void PageScene::write(Json& document) const {
  world::KinematicsWorkspace work(model_);
  world::Kinematics start;
  world::calc_kinematics(model_, model_.neutral(), work, start);
  if (const auto& file = model_.scene().file; !file.empty()) document["scene_file"] = std::filesystem::absolute(file).string();
  document["bodies"] = document["geometries"] = Json::array();
  for (const int b : shown_) {
    const auto& body = model_.bodies()[static_cast<std::size_t>(b)];
    tasks::StoredBody stored{.name = body.name, .kind = body.kind, .fixed_pose = {}};
    if (body.dofs.empty()) stored.fixed_pose = tasks::to_numbers(start.X_WB[static_cast<std::size_t>(b)]);
    document["bodies"].push_back(Json::parse(tasks::to_text(stored)));
  }
  for (const auto& geometry : model_.geometries()) {
    if (hidden_[static_cast<std::size_t>(geometry.body)]) continue;
    document["geometries"].push_back(Json::parse(tasks::to_text(
        tasks::StoredGeometry{geometry.name, place(geometry.body), geometry.shape, tasks::to_numbers(geometry.X_BG), geometry.friction})));
  }
}

Json PageScene::poses(const Eigen::VectorXd& q) {
  world::calc_kinematics(model_, q, work_, kinematics_);
  Json out = Json::array();
  for (const int b : shown_) {
    if (model_.bodies()[static_cast<std::size_t>(b)].dofs.empty()) continue;
    out.push_back(tasks::to_numbers(kinematics_.X_WB[static_cast<std::size_t>(b)]));
  }
  return out;
}

Json page_numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace stiction::app
