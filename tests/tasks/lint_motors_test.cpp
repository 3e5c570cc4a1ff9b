#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <string>

#include "stiction/tasks/lint.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;

/// Lengths, masses and forces of a task in other units; time as it is.
struct Units {
  double length = 1, mass = 1;
  double force() const { return length * mass; }
};

/// A ball on three crossed slides that give 30 N each, beside a block of 8 cm on the ground.
class MotorLint : public testing::Test {
 protected:
  Task task(double mass, double goal_height, const Units& units = {}, const std::string& shape = "box: {size: [S, S, S]}",
            double effort = 30) const {
    const double s = units.length;
    std::string urdf = "<robot name='slides'><link name='l0'/>";
    for (int i = 0; i < 3; ++i) {
      const std::string ball = i < 2 ? "" : fmt::format("<collision><geometry><sphere radius='{}'/></geometry></collision>", 0.015 * s);
      urdf += fmt::format(
          "<link name='l{0}'>{1}</link><joint name='{2}' type='prismatic'><parent link='l{3}'/><child link='l{0}'/><axis xyz='{4}'/>"
          "<limit lower='{5}' upper='{6}' effort='{7}' velocity='{8}'/></joint>",
          i + 1, ball, "abc"[i], i,
          i == 0   ? "1 0 0"
          : i == 1 ? "0 1 0"
                   : "0 0 1",
          (i == 2 ? 0.016 : -0.4) * s, 0.4 * s, effort * units.force(), s);
    }
    std::ofstream(dir_ / "slides.urdf") << urdf << "</robot>";
    std::string object = shape;
    for (std::size_t at = 0; (at = object.find('S')) != std::string::npos;) object.replace(at, 1, fmt::format("{}", 0.08 * s));
    return parse_task(fmt::format(R"(
scene:
  gravity: [0, 0, {}]
  robots: [{{name: slides, urdf: slides.urdf, stiffness: {}, friction: 0.5}}]
  objects: [{{name: block, joint: free, mass: {}, shapes: [{{{}, friction: 0.5}}]}}]
  fixed: [{{name: ground, friction: 0.5, shapes: [{{half_space: {{}}}}]}}]
start: {{objects: {{block: {{position: [0, 0, {}]}}}}, joints: [{}, 0, {}]}}
goal: {{objects: {{block: {{position: [{}, 0, {}]}}}}}}
tolerance: {{position: {}, angle: 0.1}}
)",
                                  -9.81 * s, 800 * units.mass, mass * units.mass, object, 0.04 * s, -0.1 * s, 0.04 * s, 0.12 * s,
                                  goal_height * s, 0.01 * s),
                      dir_);
  }

  static std::optional<Finding> motors(const Task& task) {
    for (const auto& finding : lint(task)) {
      if (finding.kind == "motors") return finding;
    }
    return std::nullopt;
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

/// (needed, given) of a message [N].
std::pair<double, double> forces(const std::string& message) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(message, found, std::regex("takes ([-+.e0-9]+) N.* give ([-+.e0-9]+) N"))) << message;
  return {std::stod(found[1]), std::stod(found[2])};
}

TEST_F(MotorLint, BlockThatTheSlidesPush_IsNotNamed) {
  EXPECT_FALSE(motors(task(0.4, 0.04)));
  EXPECT_FALSE(motors(task(10, 0.04))) << "28 N are needed to tip it";
}

/// It slides at μW, and tips at a/D W with a = 4 cm and D the diagonal of 13.9 cm.
TEST_F(MotorLint, BlockTooHeavyToPush_SaysWhatIsNeededAndGiven) {
  const auto finding = motors(task(50, 0.04));
  ASSERT_TRUE(finding);
  EXPECT_NE(finding->message.find("to push or tip 'block' (50 kg)"), std::string::npos) << finding->message;
  const auto [needed, given] = forces(finding->message);
  EXPECT_NEAR(needed, 50 * 9.81 / (2 * std::sqrt(3.0)), 1);
  EXPECT_GE(given, 30 / std::sqrt(1.25)) << "a push along one slide";
  EXPECT_LE(given, 30 * std::sqrt(3.0)) << "three slides together";
  EXPECT_FALSE(motors(task(50, 0.04, {}, "box: {size: [S, S, S]}", 300))) << "ten times the effort";
}

TEST_F(MotorLint, BlockThatHangsAtTheGoal_NeedsItsWeight) {
  EXPECT_FALSE(motors(task(1, 0.24)));
  const auto finding = motors(task(12, 0.24));
  ASSERT_TRUE(finding);
  EXPECT_NE(finding->message.find("to carry 'block' (12 kg)"), std::string::npos) << finding->message;
  const auto [needed, given] = forces(finding->message);
  EXPECT_NEAR(needed, 12 * 9.81, 0.5);
  EXPECT_LE(given, 30 + 1e-9);
}

TEST_F(MotorLint, WhatRolls_IsNotNamed) { EXPECT_FALSE(motors(task(5000, 0.04, {}, "sphere: {radius: 0.04}"))); }

/// Efforts that are not known bound nothing.
TEST_F(MotorLint, MotorsWithoutLimits_AreNotNamed) { EXPECT_FALSE(motors(task(5000, 0.04, {}, "box: {size: [S, S, S]}", 1e300))); }

TEST_F(MotorLint, OtherUnits_SayTheSameOfBoth) {
  const auto one = motors(task(50, 0.04));
  ASSERT_TRUE(one);
  const auto [needed, given] = forces(one->message);
  for (const Units& units : {Units{1.0 / 32, 1.0 / 1024}, Units{32, 1024}}) {
    EXPECT_FALSE(motors(task(10, 0.04, units))) << units.length;
    const auto other = motors(task(50, 0.04, units));
    ASSERT_TRUE(other) << units.length;
    const auto [other_needed, other_given] = forces(other->message);
    EXPECT_NEAR(other_needed / units.force(), needed, 0.01 * needed);
    EXPECT_NEAR(other_given / units.force(), given, 0.01 * given);
  }
}

}  // namespace
}  // namespace stiction::tasks
