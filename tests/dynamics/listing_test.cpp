// Which contacts a step has: those of pairs nearer than their contact distance, and what the motion meets beyond it.
#include <map>

#include "dynamics/systems.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

/// A body of 1 kg above a floor at height 0. Without robots one that gravity accelerates for a whole step falls by h²g/ε, 98 mm in 0.1 s.
std::shared_ptr<const Model> above_floor(const world::Shape& shape) {
  world::Scene scene;
  scene.name = "above_floor";
  world::ObjectSpec object = ball(world::ObjectJoint::Free, 1.0, 0.05, 0.5);
  object.geometries.front().shape = shape;
  scene.objects.push_back(object);
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), 0.5));
  return Model::make(scene);
}

StepResult drop(const std::shared_ptr<const Model>& model, const VectorXd& q, const Smoothing& smoothing = Exact{}) {
  StepWorkspace work(model);
  StepResult out;
  const StepOptions options{.h = 0.1, .smoothing = smoothing, .regularisation = FixedEpsilon{1}, .joint_limits = false};
  EXPECT_EQ(step(*model, {q, VectorXd(0)}, options, work, out), Status::Solved);
  return out;
}

TEST(Listing, FloorWithinFallButBeyondContactDistance_BodyLandsOnIt) {
  const auto model = above_floor(world::Sphere{0.05});
  VectorXd q = model->neutral();
  q[2] = 0.05 + 0.06;
  EXPECT_NEAR(drop(model, q).q_next[2], 0.05, 1e-6);
  EXPECT_GT(drop(model, q, Analytic{.kappa = 1000}).q_next[2], 0.05);
}

TEST(Listing, FloorBeyondFall_NoContactAndFreeFall) {
  const auto model = above_floor(world::Sphere{0.05});
  VectorXd q = model->neutral();
  q[2] = 0.05 + 0.2;
  const StepResult out = drop(model, q);
  EXPECT_TRUE(out.contacts.empty());
  EXPECT_NEAR(out.q_next[2], 0.25 - 0.01 * 9.81, 1e-9);
}

TEST(Listing, BoxOnAnEdge_CornersThatItTipsOntoAreListed) {
  // Its low edge is 1 mm above the floor, the other one of the face farther than the contact distance: it must not tip through the floor.
  const auto model = above_floor(world::Box{{0.1, 0.05, 0.02}});
  const double tilt = 0.2;
  VectorXd q = model->neutral();
  q.segment<4>(3) = Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Vector3d::UnitY())).coeffs();
  q[2] = 0.1 * std::sin(tilt) + 0.02 * std::cos(tilt) + 0.001;
  ASSERT_GT(0.2 * std::sin(tilt), model->scene().contact_distance);
  const StepResult out = drop(model, q);
  const Eigen::Matrix3d R = Eigen::Quaterniond(out.q_next.segment<4>(3)).toRotationMatrix();
  for (const double x : {-0.1, 0.1}) EXPECT_GT(out.q_next[2] + (R * Vector3d(x, 0, -0.02)).z(), -0.005);  // rows are linear
  EXPECT_EQ(out.contacts.size(), 4U);
}

class ListingOfTask : public testing::TestWithParam<const char*> {};

TEST_P(ListingOfTask, PairsBeyondTheirDistance_ListedOnlyIfTheStepMeetsThem) {
  const auto model = load_task(GetParam());
  core::Random random(11, 0);
  StepWorkspace work(model);
  StepResult out;
  for (int attempt = 0; attempt < 20; ++attempt) {
    const VectorXd q = sample_task(GetParam(), *model, random);
    for (const Smoothing& smoothing : {Smoothing(Exact{}), Smoothing(Analytic{})}) {
      const StepOptions options{.smoothing = smoothing};
      if (step(*model, {q, q.tail(model->n_a())}, options, work, out) != Status::Solved) continue;
      std::map<int, double> nearest;
      for (const auto& c : out.contacts) {
        double& phi = nearest.try_emplace(c.contact.pair, c.contact.phi).first->second;
        phi = std::min(phi, c.contact.phi);
      }
      for (const auto& [pair, phi] : nearest) {
        const world::Pair& p = model->pairs()[static_cast<std::size_t>(pair)];
        const auto owner = [&](int g) {
          return model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(g)].body)].kind;
        };
        const bool object = owner(p.geometry_a) == world::BodyKind::Object || owner(p.geometry_b) == world::BodyKind::Object;
        EXPECT_TRUE(phi < p.max_distance || object) << "a pair of the robot alone that stands still: " << pair << ", " << phi << " m apart";
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Tasks, ListingOfTask, testing::Values("planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stiction::dynamics::test
