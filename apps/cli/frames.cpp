#include "frames.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

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

/// Poses of the bodies that a plan file shows, rounded as there.
class Poses {
 public:
  Poses(const world::Model& model, const tasks::PlanFile& plan) : model_(model), work_(model) {
    std::size_t shown = 0;
    for (std::size_t b = 0; b < model.bodies().size() && shown < plan.bodies.size(); ++b) {
      if (model.bodies()[b].name != plan.bodies[shown].name) continue;
      if (!plan.bodies[shown++].fixed_pose) moving_.push_back(b);
    }
  }

  json at(const Eigen::VectorXd& q) {
    world::calc_kinematics(model_, q, work_, kinematics_);
    json out = json::array();
    for (const std::size_t b : moving_) {
      json pose = json::array();
      for (const double x : tasks::to_numbers(kinematics_.X_WB[b])) pose.push_back(rounded(x));
      out.push_back(std::move(pose));
    }
    return out;
  }

 private:
  const world::Model& model_;
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  std::vector<std::size_t> moving_;
};

json to_json(const world::Model& model, const std::vector<simulation::PairForce>& forces) {
  json out = json::array();
  for (const auto& f : forces) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(f.pair)];
    out.push_back({{"a", pair.geometry_a},
                   {"b", pair.geometry_b},
                   {"point", numbers(f.p_WC)},
                   {"force", numbers(f.force_W)},
                   {"normal", rounded(f.normal)}});
  }
  return out;
}

/// Which of n samples the page shows: all, or an even choice of them with both ends.
std::vector<std::size_t> choose_frames(std::size_t n) {
  std::vector<std::size_t> out(std::min(n, kMaxFrames));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = out.size() == 1 ? 0 : i * (n - 1) / (out.size() - 1);
  return out;
}

/// Of each row of `torque` the largest in magnitude, from one column to another, both among them.
Eigen::VectorXd peak_between(const Eigen::MatrixXd& torque, std::size_t first, std::size_t last) {
  const auto columns = torque.middleCols(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(last - first + 1));
  const Eigen::VectorXd high = columns.rowwise().maxCoeff(), low = columns.rowwise().minCoeff();
  return (high.array() > -low.array()).select(high, low);
}

json make_frames(const world::Model& model, const tasks::PlanFile& plan, const Recording& r) {
  json out = json::array();
  Poses poses(model, plan);
  std::size_t first = 0;  // after the frame before
  for (const std::size_t k : choose_frames(r.times.size())) {
    const auto column = static_cast<Eigen::Index>(k);
    out.push_back({{"t", r.times[k]},
                   {"piece", std::max(0, r.piece[k])},
                   {"bodies", poses.at(r.q.col(column))},
                   {"planned", poses.at(r.q_plan.col(column))},
                   {"forces", to_json(model, r.forces[k])},
                   {"torque", numbers(peak_between(r.torque, std::exchange(first, k + 1), k))}});
  }
  return out;
}

}  // namespace

void write_simulation(const world::Model& model, const tasks::PlanFile& plan, const json& report, const Recording& recording,
                      const std::filesystem::path& file) {
  json document;
  document["format"] = "stiction-simulation";
  document["format_version"] = 2;
  document["code_version"] = core::version();
  document["scene_sha256"] = plan.scene_sha256;
  document["report"] = report;
  document["frames"] = make_frames(model, plan, recording);
  tasks::write_text(document.dump() + "\n", file);
}

}  // namespace stiction::app
