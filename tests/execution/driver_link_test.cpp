#include "stiction/execution/closed_loop/driver_link.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "planning/push_plan.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;

constexpr double kTick = 1e-3, kSilence = 0.5;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinite = std::numeric_limits<double>::infinity();

/// Says what a test tells it to say; commands do nothing but count.
class ToldPlant final : public Driver {
 public:
  bool read(Measurement& out) override {
    out = next;
    return true;
  }
  bool command(VectorRef, double) override { return ++commands > 0; }
  Measurement next;
  int commands = 0;
};

/// A link that has read one good measurement, at 1 s.
struct Rig {
  std::shared_ptr<const world::Model> model = planning::test::load_model("planar_pushing");
  ToldPlant plant;
  DriverLink link{plant, *model, kTick, kSilence};

  Rig() {
    const VectorXd q = model->neutral();
    plant.next = {1, 1, q, q.tail(model->n_a())};
    EXPECT_TRUE(link.read()) << link.reason();
  }
  bool read_at(double time) {
    plant.next.time = plant.next.object_time = time;
    return link.read();
  }
};

TEST(DriverLink, MeasurementThatCannotBe_IsRefusedByItsField) {
  using Change = std::function<void(Measurement&)>;
  const std::pair<Change, std::string> cases[] = {
      {[](Measurement& m) { m.q[0] = kNaN; }, "q"},
      {[](Measurement& m) { m.q[m.q.size() - 1] = kInfinite; }, "q"},
      {[](Measurement& m) { m.q.conservativeResize(m.q.size() - 1); }, "q: got"},
      {[](Measurement& m) { m.q.resize(0); }, "q: got"},
      {[](Measurement& m) { m.u[0] = kNaN; }, "u"},
      {[](Measurement& m) { m.u.conservativeResize(m.u.size() + 1); }, "u: got"},
      {[](Measurement& m) { m.time = kNaN; }, "time"},
      {[](Measurement& m) { m.object_time = kNaN; }, "object_time"},
      {[](Measurement& m) { m.object_time = m.time + 1e6; }, "object_time"},
  };
  for (const auto& [change, field] : cases) {
    Rig rig;
    rig.plant.next.time = rig.plant.next.object_time = 1 + kTick;
    change(rig.plant.next);
    EXPECT_FALSE(rig.link.read()) << field;
    EXPECT_NE(rig.link.reason().find("the plant gave a measurement that cannot be: "), std::string::npos) << rig.link.reason();
    EXPECT_NE(rig.link.reason().find(field), std::string::npos) << rig.link.reason();
    EXPECT_EQ(rig.link.measured().time, 1) << "what is known stays";
  }
}

TEST(DriverLink, ClockThatJumps_IsNamed) {
  for (const double time : {-99.0, 0.4, 1.6, 1e9}) {
    Rig rig;
    EXPECT_FALSE(rig.read_at(time)) << time;
    EXPECT_NE(rig.link.reason().find("clock of the plant went from 1.000 s to"), std::string::npos) << rig.link.reason();
  }
}

TEST(DriverLink, TimeThatPassesWhileThePlannerWorks_IsNoJump) {
  Rig rig;
  rig.link.pause();
  EXPECT_TRUE(rig.read_at(31)) << rig.link.reason();
  EXPECT_TRUE(rig.read_at(31 + kTick)) << rig.link.reason();
  EXPECT_FALSE(rig.read_at(62)) << "a pause counts once";
}

TEST(DriverLink, LateMessage_IsLeftOut) {
  Rig rig;
  ASSERT_TRUE(rig.read_at(1.01));
  const VectorXd q = rig.plant.next.q;
  rig.plant.next.q[0] += 0.01;
  EXPECT_TRUE(rig.read_at(1.005)) << rig.link.reason();
  EXPECT_EQ(rig.link.measured().time, 1.01);
  EXPECT_EQ(rig.link.measured().q, q);
  EXPECT_TRUE(rig.read_at(1.011));
  EXPECT_EQ(rig.link.measured().q, rig.plant.next.q);
}

TEST(DriverLink, ClockThatStandsStillOrFallsBackAgainAndAgain_EndsAfterTheSilence) {
  for (const double time : {1.0, 0.9}) {
    Rig rig;
    int reads = 0;
    while (rig.read_at(time) && reads < 10000) ++reads;
    EXPECT_NEAR(reads * kTick, kSilence, 2 * kTick);
    EXPECT_NE(rig.link.reason().find("clock of the plant stands still at 1.000 s"), std::string::npos) << rig.link.reason();
  }
}

}  // namespace
}  // namespace stiction::execution::test
