#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "stiction/simulation/simulation.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::app {

/// Of pieces, in the order of planning::SegmentKind.
inline constexpr std::string_view kKinds[] = {"settle", "contact", "regrasp"};

/// Poses of the bodies that a plan file shows, rounded as there.
class Poses {
 public:
  Poses(const world::Model& model, const tasks::PlanFile& plan);
  const world::Model& model() const { return model_; }
  nlohmann::ordered_json at(const Eigen::VectorXd& q);

 private:
  const world::Model& model_;
  world::KinematicsWorkspace work_;
  world::Kinematics kinematics_;
  std::vector<std::size_t> moving_;
};

/// One moment of a simulated run.
struct Frame {
  double t = 0;
  int piece = 0;
  Eigen::VectorXd q, q_plan;
  const std::vector<simulation::PairForce>& forces;
  Eigen::VectorXd torque;  ///< of the motors, of each the largest since the frame before (n_a)
};

/// An entry of `frames` in the file that the page of a simulation is made of.
nlohmann::ordered_json make_frame(Poses& poses, const Frame& frame);

/// Which of n samples the page shows: all, or an even choice of them with both ends.
std::vector<std::size_t> choose_frames(std::size_t n);

/// Of each row of `torque` the largest in magnitude, from one column to another, both among them.
Eigen::VectorXd peak_between(const Eigen::MatrixXd& torque, std::size_t first, std::size_t last);

/// Writes the file that the page of a simulation is made of. @param report  what --json prints
void write_simulation(const tasks::PlanFile& plan, const nlohmann::ordered_json& report, nlohmann::ordered_json frames,
                      const std::filesystem::path& file);

}  // namespace stiction::app
