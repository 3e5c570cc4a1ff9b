// Plans in other units: the same task, smaller or larger, has the same plan.
#include <array>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <regex>
#include <sstream>

#include "planning/systems.hpp"
#include "stiction/planning/sample_boxes.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

/// models/planar_pusher.urdf with a ball of another radius.
std::filesystem::path pusher_of(double radius) {
  std::ifstream in(stiction::test::source_dir() / "models" / "planar_pusher.urdf");
  std::stringstream text;
  text << in.rdbuf();
  const auto file = stiction::test::folder_of_the_process() / ("pusher_" + std::to_string(radius) + ".urdf");
  std::ostringstream exact;  // six digits would be another radius, and another plan
  exact << std::setprecision(17) << "radius=\"" << radius << "\"";
  std::ofstream(file) << std::regex_replace(text.str(), std::regex("radius=\"0.1\""), exact.str());
  return file;
}

/// tasks/planar_pushing.yaml with every length times s: there is no gravity, the mass plays no part, and the stiffness stays.
PlanningProblem pushing(double s) {
  world::Scene scene = world::load_scene(stiction::test::source_dir() / "tasks" / "planar_pushing.yaml");
  scene.contact_distance *= s;
  auto& hand = scene.robots[0];
  hand.urdf = pusher_of(0.1 * s);
  hand.effort = {{"y", std::numeric_limits<double>::infinity()}, {"z", std::numeric_limits<double>::infinity()}};
  auto& box = scene.objects[0];
  box.inertia *= s * s;
  std::get<world::Box>(box.geometries[0].shape).half_extents *= s;
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start.resize(5);
  problem.q_start << 0, 0.5 * s, 0, 0, -0.1 * s;
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  problem.goal.X_WG.p.z() = -0.5 * s;
  problem.goal.tol_position = 0.02 * s;
  return problem;
}

/// What is commanded once the start has settled, one column each.
Eigen::MatrixXd commands_of(const Plan& plan) {
  std::vector<Eigen::VectorXd> all;
  for (const Segment& segment : plan.segments) {
    for (const auto& knot : segment.kind == SegmentKind::Settle ? std::vector<dynamics::Knot>{} : segment.knots) all.push_back(knot.u);
  }
  Eigen::MatrixXd out(plan.u_start.size(), static_cast<Eigen::Index>(all.size()));
  for (std::size_t k = 0; k < all.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = all[k];
  return out;
}

TEST(Scaling, TaskOfAnotherSize_GetsTheSamePlan) {
  Eigen::MatrixXd first;
  for (const double s : {1.0, 1.0 / 64, 1.0 / 8, 8.0, 128.0}) {
    const PlanningProblem problem = pushing(s);
    PlannerOptions options;
    options.max_iterations = 20000;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved) << s;
    const Eigen::MatrixXd commands = commands_of(result.plan) / s;
    if (first.size() == 0) first = commands;
    ASSERT_EQ(commands.cols(), first.cols()) << s;
    EXPECT_LT((commands - first).cwiseAbs().maxCoeff(), 1e-3) << s;  // the joints are sliders, the box is a metre wide
  }
}

/// A ball on three sliders beside a box that lies on the ground, to be pushed over it. Every mass, stiffness and effort is m times what it was.
PlanningProblem pushing_over_ground(double m) {
  std::string urdf = "<robot name='slides'><link name='l0'/>";
  const std::array<std::string, 3> axes{"1 0 0", "0 1 0", "0 0 1"};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string link = "l" + std::to_string(i + 1), ball = "<collision><geometry><sphere radius='0.02'/></geometry></collision>";
    urdf += "<link name='" + link + "'>" + (i == 2 ? ball : "") + "</link><joint name='j" + std::to_string(i) +
            "' type='prismatic'><parent link='l" + std::to_string(i) + "'/><child link='" + link + "'/><axis xyz='" + axes[i] +
            "'/><limit lower='-0.5' upper='0.5' velocity='1' effort='" + std::to_string(30 * m) + "'/></joint>";
  }
  world::Scene scene;
  world::RobotSpec& robot = scene.robots.emplace_back();
  robot.name = "slides";
  robot.text = urdf + "</robot>";
  robot.stiffness = {{"j0", 1000 * m}, {"j1", 1000 * m}, {"j2", 1000 * m}};
  world::ObjectSpec& box = scene.objects.emplace_back();
  box.name = "box";
  box.mass = m;
  box.inertia = 1e-3 * m * Eigen::Matrix3d::Identity();
  box.geometries = {{"box", world::Box{Eigen::Vector3d::Constant(0.04)}, {}, 0.5}};
  scene.fixed.push_back(
      {"ground", {}, {{"ground", world::Box{Eigen::Vector3d(1, 1, 0.05)}, {Eigen::Matrix3d::Identity(), {0, 0, -0.05}}, 0.5}}});
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start.resize(10);
  problem.q_start << 0.1, 0, 0.04, 0, 0, 0, 1, 0, 0, 0.03;
  problem.goal.X_WG.p = Eigen::Vector3d(0.2, 0.05, 0.04);
  problem.goal.tol_position = 0.01;
  problem.goal.tol_angle = 0.1;
  return problem;
}

TEST(Scaling, TaskOfAnotherWeight_GetsTheSamePlan) {
  Eigen::MatrixXd first;
  for (const double m : {1.0, 0x1p-20, 0x1p-7, 0x1p7, 0x1p13}) {  // 10⁻⁶ to 10⁴
    const PlanningProblem problem = pushing_over_ground(m);
    PlannerOptions options;
    options.max_iterations = 20000;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved) << m;
    const Eigen::MatrixXd commands = commands_of(result.plan);
    if (first.size() == 0) first = commands;
    ASSERT_EQ(commands.cols(), first.cols()) << m;
    EXPECT_LT((commands - first).cwiseAbs().maxCoeff(), 0.1 * problem.goal.tol_position) << m;  // at 2⁻²⁰ a sub-step less, else 10⁻¹²
  }
}

}  // namespace
}  // namespace stiction::planning::test
