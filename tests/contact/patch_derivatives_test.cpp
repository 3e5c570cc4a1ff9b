// Derivatives at the points in which flat faces touch, against central differences of fourth order.
#include <algorithm>
#include <optional>

#include "contact/contact_derivatives.hpp"
#include "contact/shapes.hpp"

namespace stiction::contact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::calc_full;
using test::Fixture;
using test::kTolerance;
using test::largest;
using test::Random;
using test::Values;
using test::Vector3d;

/// τ_c and w_c of the contact with this id over all coordinates; nothing where it is not there or not of that kind.
std::optional<Values> patch_values(Fixture& s, const Contact& want, const Vector3d& lambda, const VectorXd& delta) {
  std::vector<Contact> contacts;
  query_pairs(*s.model, s.kinematics, std::array{0}, 10.0, s.work, contacts);
  for (const Contact& c : contacts) {
    if (c.id != want.id || c.reference != want.reference || c.kind != want.kind) continue;
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, s.model->n_v());
    calc_jacobian(*s.model, s.kinematics, c, J.data());
    return Values{J.transpose() * lambda, Vector3d(c.phi, 0, 0) + J * delta};
  }
  return std::nullopt;
}

/// Largest relative error over the points of the patch; counts them by kind.
double compare_patch(Fixture& s, Random& random, int counts[3]) {
  std::vector<Contact> contacts;
  query_pairs(*s.model, s.kinematics, std::array{0}, 10.0, s.work, contacts);
  const VectorXd q = s.q;
  const Eigen::Index n = s.model->n_v();
  double worst = 0;
  for (const Contact& c : contacts) {
    if (c.id % 256 == 255) continue;  // the witness of the pair
    const Vector3d lambda = random.in_cube(1.0);
    VectorXd delta(n);
    for (double& d : delta) d = random.uniform(-0.1, 0.1);
    MatrixXd D_tau, D_w, D_tau_fd(n, n), D_w_fd(3, n);
    calc_full(s, c, lambda, delta, D_tau, D_w);
    bool there = true;
    for (Eigen::Index j = 0; j < n && there; ++j) {
      std::optional<Values> v[4];
      const double offset[] = {-2e-4, -1e-4, 1e-4, 2e-4};
      for (int k = 0; k < 4 && there; ++k) {
        s.move_by(offset[k] * VectorXd::Unit(n, j));
        v[k] = patch_values(s, c, lambda, delta);
        there = v[k].has_value();
        s.move_to(q);
      }
      if (!there) break;
      D_tau_fd.col(j) = (v[0]->tau - 8 * v[1]->tau + 8 * v[2]->tau - v[3]->tau) / 1.2e-3;
      D_w_fd.col(j) = (v[0]->w - 8 * v[1]->w + 8 * v[2]->w - v[3]->w) / 1.2e-3;
    }
    if (!there) continue;
    ++counts[static_cast<int>(c.kind)];
    worst = std::max({worst, largest(D_tau - D_tau_fd) / largest(D_tau), largest(D_w - D_w_fd) / largest(D_w)});
  }
  return worst;
}

struct Patched {
  std::string name;
  world::Shape above, below;
  double height;  // of the upper one's centre, lying
  bool lying;     // its z axis level
  int least[3];   // points of each kind to be compared
};
void PrintTo(const Patched& p, std::ostream* os) { *os << p.name; }

class EveryPatch : public ::testing::TestWithParam<Patched> {};
INSTANTIATE_TEST_SUITE_P(
    Shapes, EveryPatch,
    ::testing::Values(Patched{"box_box", world::Box{{0.05, 0.03, 0.08}}, world::Box{{0.04, 0.06, 0.02}}, 0.103, false, {30, 40, 10}},
                      Patched{"plate_box", world::Box{{0.04, 0.06, 0.02}}, world::Box{{0.05, 0.03, 0.08}}, 0.103, false, {30, 40, 10}},
                      Patched{
                          "mesh_box", test::make_box_mesh({0.05, 0.03, 0.08}), world::Box{{0.04, 0.06, 0.02}}, 0.103, false, {30, 40, 10}},
                      Patched{"capsule_box", world::Capsule{0.02, 0.05}, world::Box{{0.04, 0.06, 0.02}}, 0.043, true, {20, 20, 0}},
                      Patched{"cylinder_box", world::Cylinder{0.02, 0.07}, world::Box{{0.04, 0.06, 0.02}}, 0.043, true, {0, 20, 0}},
                      Patched{"can_box", world::Cylinder{0.05, 0.04}, world::Box{{0.04, 0.06, 0.02}}, 0.064, false, {20, 40, 5}},
                      Patched{"box_half_space", world::Box{{0.05, 0.03, 0.08}}, world::HalfSpace{}, 0.083, false, {40, 0, 0}},
                      Patched{"capsule_half_space", world::Capsule{0.02, 0.05}, world::HalfSpace{}, 0.023, true, {40, 0, 0}},
                      Patched{"cylinder_half_space", world::Cylinder{0.02, 0.05}, world::HalfSpace{}, 0.023, true, {40, 0, 0}},
                      Patched{"can_half_space", world::Cylinder{0.05, 0.04}, world::HalfSpace{}, 0.043, false, {100, 0, 0}}),
    [](const auto& test) { return test.param.name; });

TEST_P(EveryPatch, Derivatives_MatchCentralDifferences) {
  const Patched& p = GetParam();
  world::Scene scene;
  scene.contact_distance = 10;
  scene.objects = {test::make_object("above", p.above)};
  if (test::is_half_space(p.below)) {
    scene.fixed = {{"below", {}, {{"g", p.below, {}, 1.0}}}};
  } else {
    scene.objects.push_back(test::make_object("below", p.below));
  }
  int counts[3] = {0, 0, 0};
  Fixture s(scene);
  Random random(37);
  const Eigen::Matrix3d rest = Eigen::AngleAxisd(p.lying ? M_PI / 2 : 0, Vector3d::UnitX()).toRotationMatrix();
  for (int i = 0; i < 50; ++i) {
    // Tilted beyond 1e-3 rad: the slack of the side planes, which is there below that, counts as constant (docs/theory/contact.md §8).
    const Vector3d tilt(random.uniform(0.01, 0.15), random.uniform(0.01, 0.15), random.uniform(-1.5, 1.5));
    const Eigen::AngleAxisd turn(rest * Eigen::AngleAxisd(tilt.norm(), tilt.normalized()).toRotationMatrix());
    VectorXd delta = VectorXd::Zero(s.model->n_v());
    delta.head<3>() << random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), p.height;
    delta.segment<3>(3) = turn.angle() * turn.axis();
    VectorXd q(s.model->n_q());
    world::retract(*s.model, s.model->neutral(), delta, q);
    s.move_to(q);
    if (p.lying && std::abs(s.X_WG(0).R(2, 2)) < 2e-3) continue;
    EXPECT_LE(compare_patch(s, random, counts), kTolerance) << "#" << i;
  }
  for (int kind = 0; kind < 3; ++kind) EXPECT_GE(counts[kind], p.least[kind]) << "kind " << kind;
}

}  // namespace
}  // namespace stiction::contact
