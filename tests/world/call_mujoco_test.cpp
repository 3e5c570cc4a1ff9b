#include "stiction/world/call_mujoco.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <filesystem>
#include <stdexcept>
#include <thread>

namespace stiction::world::test {
namespace {

TEST(CallMujoco, ErrorsAndWarnings_ComeBackAsText) {
  const auto good = call_mujoco([] {});
  EXPECT_FALSE(good.failed);
  EXPECT_TRUE(good.warnings.empty());
  bool after = false;
  const auto bad = call_mujoco([&] {
    mju_warning("careful with %d", 3);
    mju_error("no such %s", "thing");
    after = true;
  });
  EXPECT_TRUE(bad.failed);
  EXPECT_FALSE(after);
  EXPECT_NE(bad.error.find("no such thing"), std::string::npos) << bad.error;
  ASSERT_EQ(bad.warnings.size(), 1u);
  EXPECT_NE(bad.warnings[0].find("careful with 3"), std::string::npos) << bad.warnings[0];
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

TEST(CallMujoco, Threads_GetTheirOwnReports) {
  std::thread threads[4];
  MujocoReport reports[4];
  for (int i = 0; i < 4; ++i) {
    threads[i] = std::thread([&, i] { reports[i] = call_mujoco([&] { mju_error("number %d", i); }); });
  }
  for (auto& thread : threads) thread.join();
  for (int i = 0; i < 4; ++i) EXPECT_NE(reports[i].error.find("number " + std::to_string(i)), std::string::npos);
}

TEST(CallMujoco, ExceptionOfTheCaller_PassesAndLeavesNothingBehind) {
  EXPECT_THROW(call_mujoco([] { throw std::runtime_error("mine"); }), std::runtime_error);
  EXPECT_TRUE(call_mujoco([] { mju_error("again"); }).failed);
}

}  // namespace
}  // namespace stiction::world::test
