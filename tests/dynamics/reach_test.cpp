// Steps that list the contacts within reach alone (S.22) are those that list all.
#include <algorithm>
#include <set>

#include "dynamics/optimality.hpp"
#include "dynamics/systems.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using world::Model;

/// Ten boxes on the ground around a box that pushes them.
std::shared_ptr<const Model> make_boxes(core::Random& random) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.contact_distance = 0.05;
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), 0.5));
  scene.robots.push_back(pusher(0.6));
  for (int i = 0; i < 10; ++i) {
    world::ObjectSpec object;
    object.name = "box_" + std::to_string(i);
    object.mass = 0.2;
    const Vector3d half(random.uniform(0.01, 0.04), random.uniform(0.01, 0.04), random.uniform(0.01, 0.04));
    object.inertia =
        object.mass / 3 * (half.squaredNorm() * Eigen::Matrix3d::Identity() - half.cwiseProduct(half).asDiagonal().toDenseMatrix());
    object.geometries.push_back({.name = "shape", .shape = world::Box{half}, .X_BG = {}, .friction = 0.5});
    scene.objects.push_back(std::move(object));
  }
  return Model::make(scene);
}

struct Count {
  long steps = 0, fewer = 0, left_out = 0, all = 0;
};

/// φ + J_n δq − μ‖J_t δq‖ of a contact at q, without μ for Coulomb's law [m].
double calc_slack(const Model& model, const world::Kinematics& kinematics, const contact::Contact& contact, const StepOptions& options,
                  const Eigen::VectorXd& delta) {
  const auto& variables = model.supports()[static_cast<std::size_t>(model.pairs()[static_cast<std::size_t>(contact.pair)].support)];
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, static_cast<Eigen::Index>(variables.size()));
  contact::calc_jacobian(model, kinematics, contact, J.data());
  Eigen::VectorXd moved(J.cols());
  for (Eigen::Index i = 0; i < moved.size(); ++i) moved[i] = delta[variables[static_cast<std::size_t>(i)]];
  const Eigen::Vector3d v = J * moved;
  const double mu = options.friction_law == FrictionLaw::Coulomb ? 0 : contact.friction;
  return contact.phi + v[0] - mu * v.tail<2>().norm();
}

/// Both kinds of step from q. A full one may have had rows that its solution does not need, so that the two are equal to the tolerance of a solution.
Eigen::VectorXd compare(const std::shared_ptr<const Model>& model, const Eigen::VectorXd& q, const Eigen::VectorXd& u, StepOptions options,
                        Count& count) {
  StepWorkspace work(model), work_near(model);
  StepResult full, near;
  const Status status = step(*model, {q, u}, options, work, full);
  options.contacts_within_reach = true;
  EXPECT_EQ(step(*model, {q, u}, options, work_near, near), status);
  if (status != Status::Solved) return q;
  EXPECT_LT((near.delta - full.delta).cwiseAbs().maxCoeff(), 1e-5);
  if (options.friction_law == FrictionLaw::Anitescu) {
    const Optimality o = recompute(*model, q, u, options, near);
    EXPECT_LT(std::max({o.stationarity, o.primal, o.dual, o.complementarity}), 2e-8);
  }
  world::KinematicsWorkspace kinematics_work(*model);
  world::Kinematics kinematics;
  world::calc_kinematics(*model, q, kinematics_work, kinematics);
  std::set<std::uint64_t> listed;
  for (const ContactImpulse& c : near.contacts) listed.insert(c.contact.id);
  for (const ContactImpulse& c : full.contacts) {
    const bool is_listed = listed.erase(c.contact.id) > 0;
    EXPECT_TRUE(is_listed || !c.active);
    EXPECT_GT(calc_slack(*model, kinematics, c.contact, options, near.delta), is_listed ? -1e-4 : -1e-12) << c.contact.phi;
  }
  EXPECT_TRUE(listed.empty()) << "contacts that are none";
  ++count.steps;
  count.fewer += near.contacts.size() < full.contacts.size();
  count.left_out += static_cast<long>(full.contacts.size() - near.contacts.size());
  count.all += static_cast<long>(full.contacts.size());
  return full.q_next;
}

TEST(Reach, BoxesThatPushEachOther_StepsAreThoseOfAllContacts) {
  core::Random random(3, 0);
  Count count;
  for (int scene = 0; scene < 20; ++scene) {
    const auto model = make_boxes(random);
    Eigen::VectorXd q = model->neutral();
    q.tail(2) << -0.05, 0.11;
    for (int i = 0; i < 10; ++i) {
      const double height = std::get<world::Box>(model->geometries()[static_cast<std::size_t>(i)].shape).half_extents[2];
      q.segment<3>(7 * i) = Vector3d(0.1 * (i % 4) - 0.15, 0.1 + 0.1 * (i / 4), height);
      const Eigen::AngleAxisd yaw(random.uniform(-M_PI, M_PI), Vector3d::UnitZ());
      q.segment<4>(7 * i + 3) = Eigen::Quaterniond(yaw).coeffs();
    }
    const double reach = std::pow(10, random.uniform(-3, -1));
    for (int k = 0; k < 6; ++k) {
      Eigen::VectorXd u = q.tail(model->n_a());
      for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += reach * random.uniform(-1, 1);
      u[0] += reach;
      q = compare(model, q, u, {.friction_law = k % 2 ? FrictionLaw::Coulomb : FrictionLaw::Anitescu, .effort_limits = true}, count);
    }
  }
  EXPECT_GT(count.fewer, count.steps / 2);
  EXPECT_LT(count.fewer, count.steps) << "some steps go farther than their command says, and look at all pairs";
  EXPECT_GT(count.left_out, count.all / 5);
}

TEST(Reach, ArmOfMeshes_StepsAreThoseOfAllContacts) {
  world::Scene scene = load_task("ur5_mesh_push")->scene();
  scene.contact_distance = 0.1;
  for (auto& filter : scene.filters) {
    if (filter.max_distance) filter.max_distance = 0.1;
  }
  const auto model = Model::make(scene);
  core::Random random(5, 0);
  Count count;
  Eigen::VectorXd q = model->neutral();
  q.head<3>() << 0.5, 0.1, 0.0483;
  q.tail<6>() << 0, -1.2, 1.6, -1.97, -1.57, 0;
  for (int k = 0; k < 60; ++k) {
    Eigen::VectorXd u = q.tail(model->n_a());
    for (Eigen::Index j = 0; j < u.size(); ++j)
      u[j] = std::clamp(u[j] + 0.01 * random.uniform(-1, 1), model->lower()[j], model->upper()[j]);
    q = compare(model, q, u, {.effort_limits = true}, count);
  }
  EXPECT_GT(count.left_out, 0) << "of " << count.all;
}

}  // namespace
}  // namespace stiction::dynamics::test
