// The published stacking motion, open loop: 7 + 2 joints, ten boxes, 69 degrees of freedom, 20 s.
#include <fstream>
#include <sstream>

#include "simulation/scenes.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;

/// Columns of a table with a header line: time, then commands.
Eigen::MatrixXd read_table(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, cell;
  std::getline(in, line);
  std::vector<double> numbers;
  Eigen::Index rows = 0;
  for (; std::getline(in, line); ++rows) {
    for (std::stringstream cells(line); std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
  }
  return Eigen::Map<Eigen::MatrixXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()) / rows, rows);
}

TEST(Stacking, PublishedMotion_PutsTheBoxOnTheTowerAndLeavesTheOthers) {
  Rig rig(world::Model::make(world::load_scene(source_dir() / "models/stacking.yaml")));
  const Eigen::MatrixXd table = read_table(source_dir() / "models/stacking_commands.csv");
  const Eigen::VectorXd times = table.row(0);
  const Eigen::MatrixXd u = table.bottomRows(9);
  const Vector3d start[] = {{0.55, 0, 0.03},    {0.70, 0, 0.04},   {0.70, 0, 0.115},  {0.70, 0, 0.19},    {0.50, -0.2, 0.04},
                            {0.5, -0.2, 0.115}, {0.5, -0.2, 0.19}, {0.45, 0.2, 0.04}, {0.45, 0.2, 0.115}, {0.48, 0.3, 0.04}};
  Eigen::VectorXd q0 = rig.model->neutral();
  for (int i = 0; i < 10; ++i) q0.segment<3>(7 * i) = start[i];
  q0.tail(9) = u.col(0);
  rig.run.record_interval = 0.1;
  ASSERT_EQ(simulate(*rig.plant, {q0, times, u, nullptr}, rig.run, rig.work, rig.result), Status::Solved) << rig.result.message;
  EXPECT_LT(rig.result.max_depth, 1e-4);
  const Eigen::VectorXd q = rig.q_end();
  EXPECT_NEAR(q[2], 0.08 + 0.07 + 0.08 + 0.03, 1e-4) << "on top of the three";
  EXPECT_LT((q.head<2>() - Eigen::Vector2d(0.69, 0)).norm(), 0.02);
  for (int i = 1; i < 10; ++i) EXPECT_LT((q.segment<3>(7 * i) - start[i]).norm(), 2e-3) << "box_" << i;
  EXPECT_LT(rig.v_end().head(60).norm(), 1e-2);
}

}  // namespace
}  // namespace stiction::simulation::test
