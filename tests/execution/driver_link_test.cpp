#include "stiction/execution/closed_loop/driver_link.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "planning/push_plan.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;

constexpr double kTick = 1e-3, kSilence = 0.5, kAbsence = 2;
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
  DriverLink link{plant, *model, kTick, kSilence, kAbsence};

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

/// Of poses that arrive out of order the newest stays.
TEST(DriverLink, PoseThatIsOlderThanOneBefore_IsLeftOut) {
  Rig rig;
  ASSERT_TRUE(rig.read_at(1.02));
  const VectorXd newest = rig.plant.next.q;
  rig.plant.next.time = 1.03, rig.plant.next.object_time = 1.01;
  rig.plant.next.q[0] += 0.01;
  rig.plant.next.q.tail(2).setConstant(0.02);
  ASSERT_TRUE(rig.link.read()) << rig.link.reason();
  EXPECT_EQ(rig.link.measured().time, 1.03);
  EXPECT_EQ(rig.link.measured().object_time, 1.02);
  EXPECT_EQ(rig.link.measured().q.head(3), newest.head(3));
  EXPECT_EQ(rig.link.measured().q.tail(2), rig.plant.next.q.tail(2)) << "joints are those that were measured";
  ASSERT_TRUE(rig.read_at(1.04));
  EXPECT_EQ(rig.link.measured().q, rig.plant.next.q);
}

/// A box that is reported 5 m aside is there once it was seen there for the silence, and not where a tracker has it elsewhere in every look.
TEST(DriverLink, ObjectThatIsSeenElsewhereForTheSilence_IsThere) {
  for (const bool wanders : {false, true}) {
    Rig rig;
    const VectorXd before = rig.plant.next.q;
    rig.plant.next.q[0] += 5;
    double time = 1.01, seen = 0;
    for (; time < 1 + kAbsence - 0.1 && seen == 0; time += 0.01) {
      if (wanders) rig.plant.next.q[0] += 5;
      ASSERT_TRUE(rig.read_at(time)) << rig.link.reason();
      if (rig.link.measured().q[0] != before[0]) seen = time;
    }
    EXPECT_EQ(rig.link.take_displaced(), !wanders);
    EXPECT_FALSE(rig.link.take_displaced()) << "told once";
    EXPECT_NEAR(seen, wanders ? 0 : 1.01 + kSilence, 0.011);
    EXPECT_EQ(rig.link.sees_objects(), !wanders);
  }
}

TEST(DriverLink, ObjectThatWasAway_IsToldWhenItIsBack) {
  Rig rig;
  const auto read = [&](double time, double object_time) {
    rig.plant.next.time = time, rig.plant.next.object_time = object_time;
    return rig.link.read();
  };
  ASSERT_TRUE(read(1.4, 1));
  EXPECT_TRUE(rig.link.sees_objects());
  ASSERT_TRUE(read(1.8, 1)) << rig.link.reason();
  EXPECT_FALSE(rig.link.sees_objects());
  ASSERT_TRUE(read(1.9, 1.9));
  EXPECT_TRUE(rig.link.sees_objects() && rig.link.take_displaced());
  for (const double time : {2.3, 2.7, 3.1, 3.5, 3.85}) ASSERT_TRUE(read(time, 1.9)) << time;
  EXPECT_FALSE(read(4, 1.9));
  EXPECT_EQ(rig.link.reason(), "the objects were last seen 2.100 s ago");
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
