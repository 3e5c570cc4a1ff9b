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

/// A simulated run, sample by sample.
struct Recording {
  const std::vector<double>& times;
  const std::vector<int>& piece;  ///< −1: before the first
  const Eigen::MatrixXd &q, &q_plan;
  const std::vector<std::vector<simulation::PairForce>>& forces;
  const Eigen::MatrixXd& torque;  ///< of the motors, of each the largest since the sample before (n_a × samples)
};

/// Writes the file that the page of a simulation is made of. @param report  what --json prints
void write_simulation(const world::Model& model, const tasks::PlanFile& plan, const nlohmann::ordered_json& report,
                      const Recording& recording, const std::filesystem::path& file);

}  // namespace stiction::app
