#include "frames.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "stiction/core/version.hpp"
#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::app {
namespace {

using json = nlohmann::ordered_json;

constexpr std::size_t kMaxFrames = 700;  // of the page

double rounded(double x) { return std::round(x * 1e6) / 1e6 + 0.0; }

json numbers(const Eigen::VectorXd& v) {
  json out = json::array();
  for (const double x : v) out.push_back(rounded(x));
  return out;
}

}  // namespace

Poses::Poses(const world::Model& model, const tasks::PlanFile& plan) : model_(model), work_(model) {
  std::size_t shown = 0;
  for (std::size_t b = 0; b < model.bodies().size() && shown < plan.bodies.size(); ++b) {
    if (model.bodies()[b].name != plan.bodies[shown].name) continue;
    if (!plan.bodies[shown++].fixed_pose) moving_.push_back(b);
  }
}

json Poses::at(const Eigen::VectorXd& q) {
  world::calc_kinematics(model_, q, work_, kinematics_);
  json out = json::array();
  for (const std::size_t b : moving_) {
    json pose = json::array();
    for (const double x : tasks::to_numbers(kinematics_.X_WB[b])) pose.push_back(rounded(x));
    out.push_back(std::move(pose));
  }
  return out;
}

json make_frame(Poses& poses, const Frame& frame) {
  json forces = json::array();
  for (const auto& f : frame.forces) {
    const auto& pair = poses.model().pairs()[static_cast<std::size_t>(f.pair)];
    forces.push_back({{"a", pair.geometry_a},
                      {"b", pair.geometry_b},
                      {"point", numbers(f.p_WC)},
                      {"force", numbers(f.force_W)},
                      {"normal", rounded(f.normal)}});
  }
  return {{"t", frame.t},
          {"piece", frame.piece},
          {"bodies", poses.at(frame.q)},
          {"planned", poses.at(frame.q_plan)},
          {"forces", std::move(forces)},
          {"torque", numbers(frame.torque)}};
}

std::vector<std::size_t> choose_frames(std::size_t n) {
  std::vector<std::size_t> out(std::min(n, kMaxFrames));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = out.size() == 1 ? 0 : i * (n - 1) / (out.size() - 1);
  return out;
}

Eigen::VectorXd peak_between(const Eigen::MatrixXd& torque, std::size_t first, std::size_t last) {
  const auto columns = torque.middleCols(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(last - first + 1));
  const Eigen::VectorXd high = columns.rowwise().maxCoeff(), low = columns.rowwise().minCoeff();
  return (high.array() > -low.array()).select(high, low);
}

void write_simulation(const tasks::PlanFile& plan, const json& report, json frames, const std::filesystem::path& file) {
  json document;
  document["format"] = "stiction-simulation";
  document["format_version"] = 2;
  document["code_version"] = core::version();
  document["scene_sha256"] = plan.scene_sha256;
  document["report"] = report;
  document["frames"] = std::move(frames);
  tasks::write_text(document.dump() + "\n", file);
}

}  // namespace stiction::app
