// A = D_qnext_q, B and the derivatives of the impulses against central differences through retract.
#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <set>

#include "contact/features.hpp"
#include "dynamics/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::dynamics::test {
namespace {

using contact::test::Named;
using core::Status;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

constexpr int kStates = 100;
constexpr double kTolerance = 1e-6;  // of the largest entry
constexpr double kStep = 2e-5;       // of the differences: 1/100 of the smallest gap, around which sharp features turn [m, rad]
constexpr double kReach = 5e-4;      // features and the set of rows stay the same this far in every coordinate [m, rad]

/// What a step gives, as one vector in the tangent space at q_next followed by all impulses.
struct Outcome {
  bool solved = false;
  VectorXd q_next, impulses;
  std::vector<std::uint64_t> rows;  // contacts in the program
  std::vector<int> features;        // of their witness points
  std::vector<int> motions;         // of an exact step: 0 open, 1 sticking, 2 sliding; and joints
  std::vector<int> motors;          // which springs saturate, and to which side joints with friction slide
  bool clear = false, clear_motors = true;
  bool steady_frames = true;
};

class System {
 public:
  System(std::shared_ptr<const Model> m, const StepOptions& o) : model(std::move(m)), options(o), work(model) {}

  Outcome outcome(const VectorXd& q, const VectorXd& u, bool with_features = false) {
    Outcome out;
    work.forget();
    out.solved = step(*model, {q, u, nullptr, damping.size() > 0 ? &damping : nullptr}, options, work, result) == Status::Solved;
    if (!out.solved) return out;
    out.q_next = result.q_next;
    if (exact()) judge(u, out);
    for (int j = 0; j < model->n_a(); ++j) {
      const double share = std::abs(model->stiffness()[j] * (u[j] - result.q_next[model->n_qu() + j])) / model->effort()[j];
      out.motors.push_back(result.saturated[static_cast<std::size_t>(j)]);
      if (options.effort_limits && share > 0.9 && share < 1.1) out.clear_motors = false;
    }
    for (Eigen::Index v = 0; v < result.joint_friction.size(); ++v) {
      const double friction = model->dofs()[static_cast<std::size_t>(v)].friction, force = result.joint_friction[v];
      if (friction == 0) continue;
      const bool slides = std::abs(force) > (1 - 1e-4) * friction;
      out.motors.push_back(!slides ? 0 : force < 0 ? 1 : -1);
      if (!slides && std::abs(force) > 0.9 * friction) out.clear_motors = false;
    }
    out.impulses.resize(3 * static_cast<Eigen::Index>(result.contacts.size()));
    if (with_features) world::calc_kinematics(*model, q, kinematics_work, kinematics);
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      const ContactImpulse& c = result.contacts[i];
      out.impulses.segment<3>(3 * static_cast<Eigen::Index>(i)) = c.lambda;
      if (c.lambda.isZero(0)) continue;
      // The components of λ turn with the frame (4), which spins by up to 1/(1 + n_z) against the normal.
      if (!model->planar_axis() && c.contact.nhat_BA_W.z() < -0.9) out.steady_frames = false;
      out.rows.push_back(c.contact.id);
      if (with_features)
        out.features.insert(out.features.end(),
                            {feature(c.contact), static_cast<int>(c.contact.kind), static_cast<int>(c.contact.reference)});
    }
    return out;
  }

  int feature(const contact::Contact& c) const {
    const auto one = [&](int index, const Vector3d& p, const Vector3d& m) {
      const world::Geometry& g = model->geometries()[static_cast<std::size_t>(index)];
      return contact::test::find_feature(g.shape, kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.X_BG, p, m);
    };
    const world::Pair& pair = model->pairs()[static_cast<std::size_t>(c.pair)];
    return 10000 * one(pair.geometry_a, c.p_WA, -c.nhat_BA_W) + one(pair.geometry_b, c.p_WB, c.nhat_BA_W);
  }

  VectorXd moved(const VectorXd& q, Eigen::Index j, double by) const {
    VectorXd out(model->n_q());
    world::retract(*model, q, by * VectorXd::Unit(model->n_v(), j), out);
    return out;
  }

  /// The same rows act on the same features up to kReach away in every coordinate; an exact step also keeps what each contact does.
  bool smooth(const VectorXd& q, const VectorXd& u) {
    const Outcome here = outcome(q, u, true);
    if (!here.solved || !here.steady_frames || !here.clear_motors || (exact() && !here.clear)) return false;
    for (int j = 0; j < model->n_v(); ++j) {
      for (const double by : {-kReach, kReach}) {
        const Outcome there = outcome(moved(q, j, by), u, true);
        if (!there.solved || there.rows != here.rows || there.motors != here.motors || there.features != here.features) return false;
        if (exact() && (!there.clear || there.motions != here.motions)) return false;
      }
    }
    return true;
  }

  /// Derivatives of q_next and of the impulses by q (or by u) from differences of sixth order.
  bool differences(const VectorXd& q, const VectorXd& u, bool by_u, double step_size, MatrixXd& D, MatrixXd& D_impulse) {
    const Outcome here = outcome(q, u);
    const int n = by_u ? model->n_a() : model->n_v();
    D.setZero(model->n_v(), n);
    D_impulse.setZero(here.impulses.size(), n);
    VectorXd e(model->n_v());
    for (Eigen::Index j = 0; j < n; ++j) {
      for (const auto& [offset, weight] : {std::pair{-3, -1.0}, {-2, 9.0}, {-1, -45.0}, {1, 45.0}, {2, -9.0}, {3, 1.0}}) {
        const double by = offset * step_size;
        const Outcome there = by_u ? outcome(q, u + by * VectorXd::Unit(n, j)) : outcome(moved(q, j, by), u);
        if (!there.solved || there.impulses.size() != here.impulses.size()) return false;
        world::local(*model, here.q_next, there.q_next, e);
        D.col(j) += weight / (60 * step_size) * e;
        D_impulse.col(j) += weight / (60 * step_size) * there.impulses;
      }
    }
    return true;
  }

  bool exact() const { return std::holds_alternative<Exact>(options.smoothing); }

  /// What every contact and joint does, and whether that is clear: open, sticking or sliding by a margin, on its limit or not.
  void judge(const VectorXd& u, Outcome& out) const {
    out.clear = true;
    for (const auto& c : result.contacts) {
      const double force = c.lambda[0] / options.h;
      const double reserve = c.contact.friction * force - c.lambda.tail<2>().norm() / options.h;
      const bool open = force < 1e-3 && c.gap > 4e-4;
      const bool sticking = force > 0.3 && reserve > 0.3 && c.slide() < 1e-6;
      const bool sliding = force > 0.3 && reserve < 1e-3 && c.slide() > 4e-4;
      out.clear = out.clear && (open || sticking || sliding);
      out.motions.push_back(open ? 0 : sticking ? 1 : 2);
    }
    for (int j = 0; j < model->n_a(); ++j) {
      const double q = result.q_next[model->n_qu() + j];
      const bool pressed = u[j] < model->lower()[j] - 1e-3 || u[j] > model->upper()[j] + 1e-3;
      out.clear = out.clear && (pressed || std::min(q - model->lower()[j], model->upper()[j] - q) > 1e-3);
      out.motions.push_back(pressed);
    }
  }

  std::shared_ptr<const Model> model;
  StepOptions options;
  VectorXd damping;
  StepWorkspace work;
  StepResult result;
  world::KinematicsWorkspace kinematics_work{*model};
  world::Kinematics kinematics;
};

double largest(const MatrixXd& m) { return m.size() == 0 ? 0.0 : m.cwiseAbs().maxCoeff(); }

MatrixXd stack(const ImpulseDerivatives& D, Eigen::Index columns) {
  MatrixXd out(3 * static_cast<Eigen::Index>(D.size()), columns);
  for (std::size_t i = 0; i < D.size(); ++i) out.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = D[i];
  return out;
}

/// log2 of the error of a second-order difference along a direction over that at half its step; 0 where it is small: the solver's own
/// accuracy, about 1e-11 in q_next, decides there.
double calc_order(System& s, const VectorXd& q, const VectorXd& u, const VectorXd& direction) {
  const Outcome here = s.outcome(q, u);
  const VectorXd want = s.result.A * direction;
  double error[2];
  for (const int k : {0, 1}) {
    const double by = k ? 1.5e-4 : 3e-4;
    VectorXd q_moved(q.size()), above(want.size()), below(want.size());
    for (const double sign : {-1.0, 1.0}) {
      world::retract(*s.model, q, sign * by * direction, q_moved);
      world::local(*s.model, here.q_next, s.outcome(q_moved, u).q_next, sign < 0 ? below : above);
    }
    error[k] = ((above - below) / (2 * by) - want).norm();
  }
  return error[1] > 1e-6 * want.norm() ? std::log2(error[0] / error[1]) : 0;
}

struct Errors {
  double A = 0, B = 0, lambda_q = 0, lambda_u = 0;
};

/// Relative errors at q, u; nothing where a difference cannot be taken.
std::optional<Errors> compare(System& s, const VectorXd& q, const VectorXd& u, double step_size) {
  MatrixXd A_fd, B_fd, Lq_fd, Lu_fd;
  if (!s.differences(q, u, false, step_size, A_fd, Lq_fd) || !s.differences(q, u, true, step_size, B_fd, Lu_fd)) return std::nullopt;
  if (!s.outcome(q, u).solved) return std::nullopt;
  const StepResult& r = s.result;
  const auto error = [](const MatrixXd& got, const MatrixXd& want) { return largest(got - want) / std::max(largest(want), 0.1); };
  return Errors{error(r.A, A_fd), error(r.B, B_fd), error(stack(r.D_lambda_q, s.model->n_v()), Lq_fd),
                error(stack(r.D_lambda_u, s.model->n_a()), Lu_fd)};
}

void expect_small(const Errors& e, int attempt) {
  EXPECT_LE(e.A, kTolerance) << "#" << attempt;
  EXPECT_LE(e.B, kTolerance) << "#" << attempt;
  EXPECT_LE(e.lambda_q, kTolerance) << "#" << attempt;
  EXPECT_LE(e.lambda_u, kTolerance) << "#" << attempt;
}

/// A hand that carries a shape on three sliders and three hinges.
world::RobotSpec wrist(const std::string& name, const world::Shape& shape) {
  const std::filesystem::path& folder = stiction::test::folder_of_the_process();
  std::string geometry;
  const auto number = [](double x) { return std::to_string(x); };
  if (const auto* p = std::get_if<world::Sphere>(&shape)) geometry = "<sphere radius='" + number(p->radius) + "'/>";
  if (const auto* p = std::get_if<world::Box>(&shape)) {
    geometry = "<box size='" + number(2 * p->half_extents.x()) + " " + number(2 * p->half_extents.y()) + " " +
               number(2 * p->half_extents.z()) + "'/>";
  }
  const auto round = [&](const std::string& kind, double radius, double half) {
    geometry = "<" + kind + " radius='" + number(radius) + "' length='" + number(2 * half) + "'/>";
  };
  if (const auto* p = std::get_if<world::Capsule>(&shape)) round("capsule", p->radius, p->half_length);
  if (const auto* p = std::get_if<world::Cylinder>(&shape)) round("cylinder", p->radius, p->half_length);
  if (const auto* p = std::get_if<world::Mesh>(&shape)) {
    std::ofstream obj(folder / (name + ".obj"));
    for (Eigen::Index i = 0; i < p->mesh->vertices.cols(); ++i) obj << "v " << p->mesh->vertices.col(i).transpose() << "\n";
    for (Eigen::Index i = 0; i < p->mesh->triangles.cols(); ++i) obj << "f " << (p->mesh->triangles.col(i).array() + 1).transpose() << "\n";
    geometry = "<mesh filename='" + (folder / (name + ".obj")).string() + "'/>";
  }
  world::RobotSpec robot;
  robot.name = name;
  robot.urdf = folder / ("stiction_" + name + ".urdf");
  std::ofstream out(robot.urdf);
  out << "<robot name='" << name << "'><link name='l0'/>";
  const char* axes[] = {"1 0 0", "0 1 0", "0 0 1"};
  for (int j = 0; j < 6; ++j) {
    const std::string joint = "j" + std::to_string(j);
    out << "<link name='l" << j + 1 << "'>" << (j == 5 ? "<collision><geometry>" + geometry + "</geometry></collision>" : "") << "</link>"
        << "<joint name='" << joint << "' type='" << (j < 3 ? "prismatic" : "revolute") << "'><parent link='l" << j << "'/><child link='l"
        << j + 1 << "'/><axis xyz='" << axes[j % 3] << "'/><limit lower='-3' upper='3' effort='1' velocity='1'/></joint>";
    robot.stiffness.emplace_back(joint, j < 3 ? 200.0 : 5.0);
  }
  out << "</robot>";
  return robot;
}

world::ObjectSpec free_object(const world::Shape& shape) {
  world::ObjectSpec o;
  o.name = "object";
  o.mass = 0.5;
  o.inertia = Vector3d(4e-4, 5e-4, 6e-4).asDiagonal();
  o.geometries = {{"g", shape, {}, 0.6}};
  return o;
}

struct ShapePair {
  Named a, b;
};
void PrintTo(const ShapePair& p, std::ostream* os) { *os << p.a.name << "_" << p.b.name; }

std::vector<ShapePair> shape_pairs() {
  std::vector<ShapePair> out;
  for (const auto& a : contact::test::all_shapes()) {
    for (const auto& b : contact::test::all_shapes()) {
      if (!contact::test::is_half_space(a.shape)) out.push_back({a, b});
    }
  }
  return out;
}

/// Object a and hand b; or a hand with a ball, object a and the ground b.
std::shared_ptr<const Model> pair_model(const ShapePair& pair) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.05;
  scene.objects = {free_object(pair.a.shape)};
  const bool ground = contact::test::is_half_space(pair.b.shape);
  scene.robots = {wrist("hand_" + pair.a.name + "_" + pair.b.name, ground ? world::Shape(world::Sphere{0.03}) : pair.b.shape)};
  scene.robots[0].friction = 0.6;
  if (ground) {
    scene.fixed = {half_space({0, 0, 1}, {0, 0, 0}, 0.6)};
    scene.filters = {{"ground", scene.robots[0].name, std::nullopt}};
  }
  return Model::make(scene);
}

/// From the neutral state by delta, then onto gaps of 2 … 3 mm, open or penetrating: the radius at which vertices and edges turn around each other.
void place(const Model& model, const VectorXd& delta, core::Random& random, VectorXd& q, VectorXd& u) {
  world::retract(model, model.neutral(), delta, q = model.neutral());
  const double sign = random.uniform(0, 1) < 0.3 ? -1 : 1;
  const double wanted[2] = {sign * random.uniform(2e-3, 3e-3), sign * random.uniform(2e-3, 3e-3)};
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  contact::Workspace contact_work(model);
  // Moves A along n̂ onto the wanted gap: first the object against the ground, then the hand against the object.
  for (int k = static_cast<int>(model.pairs().size()) - 1; k >= 0; --k) {
    for (int round = 0; round < 20; ++round) {
      world::calc_kinematics(model, q, kinematics_work, kinematics);
      const contact::Distance d = contact::pair_distance(model, kinematics, k, contact_work);
      const double by = (round < 19 ? 0.9 : 1.0) * (d.phi - wanted[k]);
      const Eigen::Index at = k == 0 ? model.n_qu() : 0;
      q.segment<3>(at) += (k == 0 ? 1.0 : -1.0) * by * d.nhat_BA_W;
    }
  }
  u = q.tail(model.n_a());
  for (Eigen::Index j = 0; j < 3; ++j) u[j] += 0.02 * random.normal();
  for (Eigen::Index j = 3; j < 6; ++j) u[j] += 0.05 * random.normal();
}

void sample_pair(const Model& model, core::Random& random, VectorXd& q, VectorXd& u) {
  VectorXd delta(model.n_v());
  for (Eigen::Index i = 0; i < delta.size(); ++i) {
    delta[i] = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute ? random.uniform(-1.3, 1.3) : 0.0;
  }
  Vector3d towards(random.normal(), random.normal(), random.normal());
  if (model.pairs().size() > 1) towards.z() = std::abs(towards.z());
  delta.segment<3>(6) = 0.5 * towards.normalized();
  place(model, delta, random, q, u);
}

class EveryShapePair : public testing::TestWithParam<ShapePair> {
 protected:
  void run(const StepOptions& options) {
    System s(pair_model(GetParam()), options);
    const bool exact = std::holds_alternative<Exact>(options.smoothing);
    core::Random random(41, 0);
    VectorXd q, u;
    int states = 0, touching = 0, untouched = 0, attempts = 0, ordered = 0;
    double sum_of_orders = 0;
    for (; attempts < 30 * kStates && states < kStates; ++attempts) {
      sample_pair(*s.model, random, q, u);
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (exact && !here.clear)) continue;
      double force = 0;
      for (const auto& c : s.result.contacts) force = std::max(force, c.lambda[0] / options.h);
      if ((force < 0.3 && untouched >= kStates / 4) || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      touching += force > 0.3, untouched += force <= 0.3;
      expect_small(*e, attempts);
      if (exact) continue;
      VectorXd direction(s.model->n_v());
      for (double& d : direction) d = random.normal();
      const double order = calc_order(s, q, u, direction.normalized());
      if (order == 0) continue;
      ++ordered;
      sum_of_orders += order;
      EXPECT_NEAR(order, 2, 0.5) << "#" << attempts;  // around sharp features the next order shows
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(touching, 3 * kStates / 4 - 1);
    if (exact) return;
    EXPECT_GT(ordered, kStates / 5);
    EXPECT_NEAR(sum_of_orders / ordered, 2, 0.05);
  }
};

TEST_P(EveryShapePair, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryShapePair, Exact_MatchesCentralDifferences) {
  run({.regularisation = FixedEpsilon{50}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShapePair, testing::ValuesIn(shape_pairs()),
                         [](const auto& test) { return test.param.a.name + "_" + test.param.b.name; });

/// Object `above` lies almost flat on b: on the hand that carries it, or on the ground with the hand's ball beside it.
struct Patched {
  ShapePair pair;
  bool lying;  // the object's z axis is level
};
void PrintTo(const Patched& p, std::ostream* os) { PrintTo(p.pair, os); }

std::vector<Patched> patched() {
  const Named box{"box", world::Box{{0.05, 0.03, 0.08}}}, mesh{"mesh", contact::test::make_box_mesh({0.05, 0.03, 0.08})};
  const Named capsule{"capsule", world::Capsule{0.02, 0.05}}, rod{"rod", world::Cylinder{0.02, 0.07}},
      can{"can", world::Cylinder{0.05, 0.04}};
  const Named plate{"plate", world::Box{{0.04, 0.06, 0.02}}}, slab{"slab", contact::test::make_box_mesh({0.04, 0.06, 0.02})};
  const Named ground{"half_space", world::HalfSpace{}};
  return {{{box, plate}, false}, {{mesh, plate}, false}, {{mesh, slab}, false},   {{capsule, plate}, true},  {{rod, plate}, true},
          {{can, plate}, false}, {{box, ground}, false}, {{mesh, ground}, false}, {{capsule, ground}, true}, {{can, ground}, false}};
}

class EveryPatch : public testing::TestWithParam<Patched> {
 protected:
  /// Tilted beyond 1e-3 rad: the slack of the side planes, which is there below that, counts as constant (docs/theory/contact.md §9).
  void sample(const Model& model, core::Random& random, VectorXd& q, VectorXd& u) const {
    const bool ground = model.pairs().size() > 1;
    const Eigen::AngleAxisd rest(GetParam().lying ? M_PI / 2 : 0, Vector3d::UnitX());
    Eigen::AngleAxisd turn;
    do {
      const Vector3d tilt(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1), random.uniform(-1.5, 1.5));
      turn = rest * Eigen::AngleAxisd(tilt.norm(), tilt.normalized());
    } while (GetParam().lying && std::abs(turn.toRotationMatrix()(2, 2)) < 2e-3);
    VectorXd delta = VectorXd::Zero(model.n_v());
    delta.segment<3>(3) = turn.angle() * turn.axis();
    const double around = random.uniform(-M_PI, M_PI);
    delta.segment<3>(6) << random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), -0.5;
    if (ground) delta.segment<3>(6) << 0.4 * std::cos(around), 0.4 * std::sin(around), 0.1;
    place(model, delta, random, q, u);
  }

  void run(const StepOptions& options) {
    System s(pair_model(GetParam().pair), options);
    core::Random random(44, 0);
    VectorXd q, u;
    int states = 0, attempts = 0, several = 0;
    for (; attempts < 100 * kStates && states < kStates; ++attempts) {
      sample(*s.model, random, q, u);
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (s.exact() && !here.clear) || here.rows.size() < 2 || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      int pressing = 0;
      for (const auto& c : s.result.contacts) pressing += c.lambda[0] > 0.1 * options.h;
      several += pressing > 1;
      expect_small(*e, attempts);
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(several, kStates / 25) << "states in which more than one point pressed";
  }
};

TEST_P(EveryPatch, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryPatch, Exact_MatchesCentralDifferences) {
  run({.regularisation = FixedEpsilon{50}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

INSTANTIATE_TEST_SUITE_P(Patches, EveryPatch, testing::ValuesIn(patched()),
                         [](const auto& test) { return test.param.pair.a.name + "_" + test.param.pair.b.name; });

class EveryTask : public testing::TestWithParam<const char*> {
 protected:
  void run(const StepOptions& options) {
    const std::string task = GetParam();
    System s(load_task(task), options);
    core::Random random(42, 0);
    int states = 0, attempts = 0;
    double most = 0;
    for (; attempts < 400 * kStates && states < kStates; ++attempts) {
      const VectorXd q = sample_task(task, *s.model, random);
      VectorXd u = q.tail(s.model->n_a());
      for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.03 * random.normal();
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (s.exact() && !here.clear) || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      most = std::max(most, largest(s.result.A.topRightCorner(s.model->n_vu(), s.model->n_a())));
      expect_small(*e, attempts);
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(most, 0.01) << "the fingers never moved the object: the test would say nothing";
  }
};

TEST_P(EveryTask, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryTask, Exact_MatchesCentralDifferences) { run({.with_B = true, .with_A = true, .with_force_derivatives = true}); }

INSTANTIATE_TEST_SUITE_P(Tasks, EveryTask, testing::Values("planar_pushing", "planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

/// States near the neutral one of a scene made in code. @returns in how many a motor gave all it had
int run_scene(const world::Scene& scene, const StepOptions& options, double damping, int least, int* sliding = nullptr) {
  System s(Model::make(scene), options);
  s.damping = VectorXd::Constant(s.model->n_v(), damping);
  core::Random random(43, 0);
  int states = 0, attempts = 0, saturated = 0;
  for (; attempts < 50 * least && states < least; ++attempts) {
    VectorXd q = s.model->neutral(), delta(s.model->n_v());
    for (Eigen::Index i = 0; i < delta.size(); ++i) {
      delta[i] = (s.model->dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute ? 0.3 : 0.01) * random.normal();
    }
    world::retract(*s.model, q, delta, q);
    VectorXd u = q.tail(s.model->n_a());
    for (double& x : u) x += 0.02 * random.normal();
    if (!s.smooth(q, u)) continue;
    const auto e = compare(s, q, u, kStep);
    if (!e) continue;
    ++states;
    saturated += std::ranges::count(s.result.saturated, 1) > 0;
    expect_small(*e, attempts);
    for (Eigen::Index v = 0; sliding != nullptr && v < s.result.joint_friction.size(); ++v) {
      const double friction = s.model->dofs()[static_cast<std::size_t>(v)].friction;
      *sliding += friction > 0 && std::abs(s.result.joint_friction[v]) > (1 - 1e-4) * friction;
    }
  }
  EXPECT_EQ(states, least) << "of " << attempts;
  return saturated;
}

TEST(Linearisation, MotorsThatGiveAllTheyHave_MatchCentralDifferences) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.2;
  scene.gravity = {0, 0, -9};
  scene.objects = {free_object(world::Cylinder{0.04, 0.06})};
  scene.robots = {wrist("hand_motors", world::Capsule{0.03, 0.05})};
  for (const auto& [joint, stiffness] : scene.robots[0].stiffness) scene.robots[0].effort.emplace_back(joint, stiffness > 100 ? 1.0 : 0.03);
  scene.robots[0].X_WBase.p = {0.02, 0.07, 0.03};
  scene.fixed = {half_space({0, 0, 1}, {0, 0, -0.1}, 0.6)};
  StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true, .effort_limits = true};
  EXPECT_GT(run_scene(scene, options, 0.0, 40), 20);
  EXPECT_GT(run_scene(scene, options, 0.5, 20), 5);
  options.smoothing = Exact{};
  options.regularisation = FixedEpsilon{3};
  EXPECT_GT(run_scene(scene, options, 0.0, 20), 5);
}

TEST(Linearisation, ObjectsWithOffsetCentres_MatchCentralDifferences) {
  for (const auto joint : {world::ObjectJoint::Hinge, world::ObjectJoint::Slider, world::ObjectJoint::PlanarYZ, world::ObjectJoint::Free}) {
    SCOPED_TRACE(static_cast<int>(joint));
    world::Scene scene = empty_scene();
    scene.gravity = {0, 1, -9};
    scene.contact_distance = 0.3;
    world::ObjectSpec object = free_object(world::Capsule{0.05, 0.1});
    object.joint = joint;
    object.p_BCom = {0.01, 0.06, 0.02};
    object.axis = joint == world::ObjectJoint::Hinge ? Vector3d(1, 0, 0) : Vector3d(0, 0.6, 0.8);
    if (joint == world::ObjectJoint::Hinge || joint == world::ObjectJoint::Slider) object.limits = {-0.9, 1.0};
    scene.objects = {object};
    scene.robots = {wrist("hand_" + std::to_string(static_cast<int>(joint)), world::Box{{0.03, 0.04, 0.05}})};
    scene.robots[0].X_WBase.p = {0, 0.12, 0.03};
    (void)run_scene(scene, {.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 40);
    (void)run_scene(scene, {.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 10);
  }
}

/// A flap on a hinge, which carries a handle on a hinge, which carries a bolt that slides; `base` carries the flap, if it is not the world.
world::Scene make_chain(const std::string& base) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 1, -9};
  scene.contact_distance = 0.3;
  const auto add = [&](const std::string& name, const std::string& parent, world::ObjectJoint joint, const Vector3d& axis,
                       const Vector3d& at, const world::Shape& shape) {
    world::ObjectSpec o = free_object(shape);
    o.name = name;
    o.parent = parent;
    o.joint = joint;
    o.axis = axis;
    o.X_WP.p = at;
    o.p_BCom = {0.01, 0.03, 0.02};
    scene.objects.push_back(o);
  };
  if (!base.empty()) add(base, "", world::ObjectJoint::Free, Vector3d::UnitX(), Vector3d::Zero(), world::Sphere{0.02});
  add("flap", base, world::ObjectJoint::Hinge, {1, 0, 0}, {0, -0.06, 0.0}, world::Capsule{0.02, 0.04});
  add("handle", "flap", world::ObjectJoint::Hinge, {0, 0.6, 0.8}, {0, 0.05, 0.09}, world::Box{{0.02, 0.03, 0.02}});
  add("bolt", "handle", world::ObjectJoint::Slider, {0.8, 0, 0.6}, {0.02, 0.04, 0}, world::Sphere{0.015});
  return scene;
}

TEST(Linearisation, ObjectsThatHangOnOthers_MatchCentralDifferences) {
  for (const std::string base : {"", "base"}) {
    SCOPED_TRACE(base);
    world::Scene scene = make_chain(base);
    scene.robots = {wrist("hand_chain" + base, world::Box{{0.03, 0.04, 0.05}})};
    scene.robots[0].X_WBase.p = {0, 0.12, 0.13};
    (void)run_scene(scene, {.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 30);
    (void)run_scene(scene, {.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 5);
  }
}

TEST(Linearisation, JointsThatStickAndSlide_MatchCentralDifferences) {
  world::Scene scene = make_chain("");
  for (world::ObjectSpec& object : scene.objects) object.joint_friction = object.name == "flap" ? 0.6 : 0.3;
  scene.robots = {wrist("hand_rust", world::Box{{0.03, 0.04, 0.05}})};
  scene.robots[0].X_WBase.p = {0, 0.12, 0.13};
  for (const bool smoothed : {true, false}) {
    StepOptions options{.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true};
    if (smoothed) options.smoothing = Analytic{.kappa = 1e4};
    const int states = smoothed ? 30 : 10;
    int sliding = 0;
    (void)run_scene(scene, options, 0.0, states, &sliding);
    EXPECT_GT(sliding, states / 2);
    EXPECT_LT(sliding, 3 * states - states / 2);
  }
}

TEST(Linearisation, PyramidsDampingAndNoFriction_MatchCentralDifferences) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.2;
  scene.gravity = {0, 0, -9};
  scene.objects = {free_object(world::Cylinder{0.04, 0.06})};
  scene.robots = {wrist("hand_pyramid", world::Capsule{0.03, 0.05})};
  scene.robots[0].X_WBase.p = {0.02, 0.1, 0.03};
  scene.fixed = {half_space({0, 0, 1}, {0, 0, -0.1}, 0.6)};
  StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true};
  (void)run_scene(scene, options, 0.5, 20);
  options.friction_scale = 0;
  (void)run_scene(scene, options, 0.0, 20);
  options.friction_scale = 0.7;
  options.friction_cone = PolyhedralCone{5};
  (void)run_scene(scene, options, 0.5, 20);
}

TEST(Linearisation, NothingNear_ObjectStaysAndRobotForgets) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.01;
  scene.objects = {ball(world::ObjectJoint::Free, 1, 0.1, 1)};
  scene.robots = {wrist("hand_far", world::Sphere{0.03})};
  scene.robots[0].X_WBase.p = {1, 0, 0};
  System s(Model::make(scene), {.with_A = true});
  ASSERT_TRUE(s.outcome(s.model->neutral(), VectorXd::Constant(6, 0.01)).solved);
  MatrixXd want = MatrixXd::Zero(12, 12);
  want.topLeftCorner<6, 6>().setIdentity();  // u, not q, decides where the springs end
  EXPECT_LE(largest(s.result.A - want), 1e-9);
  EXPECT_EQ(s.result.B.size(), 0);
}

TEST(Linearisation, ForceDerivativesAlone_AreRefused) {
  const StepOptions options{.with_force_derivatives = true};
  EXPECT_THROW(options.validate(), core::InvalidInput);
}

}  // namespace
}  // namespace stiction::dynamics::test
