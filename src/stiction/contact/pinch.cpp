#include "stiction/contact/pinch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "stiction/contact/gap_gradient.hpp"
#include "stiction/contact/touch.hpp"
#include "stiction/world/point_jacobian.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {
namespace {

constexpr int kJaws = 2;  // largest number of branches of a gripper
constexpr int kReachSteps = 20;
constexpr int kPatience = 4;         // steps in which the error must halve; a place that is out of reach fails this test
constexpr double kMaxStep = 0.5;     // largest motion of a hinge per step [rad]
constexpr double kThere = 0.1;       // tolerance of the middle between the jaws, as a share of the radius of the held geometry
constexpr double kStraight = 0.02;   // tolerance of the axis between the jaws [rad]
constexpr int kSwaps = 4;            // how often the touching geometry of a jaw may be replaced by one that protrudes farther
constexpr int kInTheWay = 3;         // largest number of blocking pairs that are moved apart
constexpr double kBlocked = 0.5;     // a pair that is nearer than this blocks the hand [contact tolerances of the robots]
constexpr double kDamping = 1e-4;    // damping of the least squares, whose rows are of order 1
constexpr double kOffCentre = 0.5;   // largest offset of a pinch from the centre of the held geometry, as a share of its radius
constexpr int kRounds = 3;           // closing attempts; before each but the first, the hand turns to the contact normal found
constexpr double kOfFragile = 0.5;   // share of the force limit of a fragile body for the jaws, since other contacts press on it too
constexpr double kNoStrain = 1e-9;   // strain below which a joint does not limit the force, as a share of a joint unit
constexpr double kOfFriction = 0.3;  // share of the friction that the line between the two parts may use

using world::Model;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

const world::Geometry& robot_side(const Model& model, int pair) { return model.geometries()[at(model.pairs()[at(pair)].geometry_b)]; }
const world::Geometry& object_side(const Model& model, int pair) { return model.geometries()[at(model.pairs()[at(pair)].geometry_a)]; }
/// Whether two pairs have the same part of the robot. Bodies that the robot file connects without a joint are one part.
bool same_part(const Model& model, int pair, int other) {
  return model.bodies()[at(robot_side(model, pair).body)].axes == model.bodies()[at(robot_side(model, other).body)].axes;
}
Eigen::Vector3d centre(const GeometryWorkspace& work, const world::Geometry& geometry) {
  return work.kinematics.X_WB[at(geometry.body)] * geometry.p_BCenter;
}

/// Velocity of the centre of a part per unit speed of each moving joint (3 × n_a), in joint units.
Eigen::Matrix3Xd centre_rates(const Model& model, const GeometryWorkspace& work, const world::Geometry& part,
                              const std::vector<char>& moving) {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J(6, model.n_a());
  world::calc_point_jacobian(model, work.kinematics, part.body, centre(work, part), J);
  Eigen::Matrix3Xd rates = J.topRows(3) * model.scales().joints().asDiagonal();
  for (int j = 0; j < model.n_a(); ++j) {
    if (!moving[at(j)]) rates.col(j).setZero();
  }
  return rates;
}

/// Moves the joints of the trunk, by damped least squares, until the midpoint of the two parts is at `place` and the line from one part to
/// the other lies along `axis`.
/// @param axis  nullptr: any direction
bool reach(const Model& model, const Pinch& pinch, const std::vector<char>& trunk, const Eigen::Vector3d& place,
           const Eigen::Vector3d* axis, Eigen::VectorXd& q, GeometryWorkspace& work) {
  const world::Geometry &a = robot_side(model, pinch.pair_a), &b = robot_side(model, pinch.pair_b);
  const double length = model.scales().robots().length, radius = object_side(model, pinch.pair_a).bounding_radius;
  const std::array bodies{a.body, b.body};
  work.links.select(model, trunk, bodies);
  Eigen::VectorXd turns(model.n_a());  // 1 per hinge, 0 per slider: a step of a slider is not limited
  for (int j = 0; j < model.n_a(); ++j) turns[j] = model.dofs()[at(model.n_vu() + j)].kind == world::DofKind::Revolute;
  double error_before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kReachSteps; ++step) {
    work.links.update(model, q, work.kinematics);
    const Eigen::Vector3d p_a = centre(work, a), p_b = centre(work, b), line = p_b - p_a;
    const double apart = line.norm();
    if (!(apart > 0)) return false;
    const Eigen::Vector3d along = line / apart, missing = place - 0.5 * (p_a + p_b);
    const double error_now = missing.norm() + (axis != nullptr ? radius * (along - *axis).norm() : 0.0);
    if (step % kPatience == 0 && error_now > 0.5 * std::exchange(error_before, error_now)) return false;
    if (missing.norm() < kThere * radius && (axis == nullptr || along.dot(*axis) > std::cos(kStraight))) return true;
    const Eigen::Matrix3Xd rates_a = centre_rates(model, work, a, trunk), rates_b = centre_rates(model, work, b, trunk);
    Eigen::MatrixXd rows(6, model.n_a());
    rows.topRows(3) = 0.5 / length * (rates_a + rates_b);
    rows.bottomRows(3).setZero();
    Eigen::VectorXd error = Eigen::VectorXd::Zero(6);
    error.head(3) = missing / length;
    if (axis != nullptr) {
      rows.bottomRows(3) = (Eigen::Matrix3d::Identity() - along * along.transpose()) / apart * (rates_b - rates_a);
      error.tail(3) = *axis - along;
    }
    Eigen::MatrixXd gram = rows * rows.transpose();
    gram.diagonal().array() += kDamping;
    Eigen::VectorXd delta = rows.transpose() * gram.ldlt().solve(error);
    delta *= std::min(1.0, kMaxStep / delta.cwiseProduct(turns).cwiseAbs().maxCoeff());
    q.tail(model.n_a()) =
        (q.tail(model.n_a()) + delta.cwiseProduct(model.scales().joints())).cwiseMax(model.lower()).cwiseMin(model.upper());
  }
  return false;
}

/// Closes the jaws on the object. If another geometry of a jaw's part penetrates the object, that geometry replaces the one in `pinch`.
bool close(const Model& model, const world::RobotChains& chains, int trunk, const std::vector<char>& closing, Pinch& pinch,
           Eigen::VectorXd& q, GeometryWorkspace& work) {
  const double touching = kTouch * world::share::kContact * model.scales().robots().length;
  for (int swap = 0; swap <= kSwaps; ++swap) {
    if (!touch(model, std::array{pinch.pair_a, pinch.pair_b}, closing, q, work)) return false;
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    Gaps gaps(model, work.kinematics, work.contact_work);
    bool whole = true;
    for (int* const of : {&pinch.pair_a, &pinch.pair_b}) {
      double deepest = -touching;
      const int before = *of;
      for (const int pair : chains.object_pairs(trunk)) {
        if (model.pairs()[at(pair)].geometry_a != model.pairs()[at(before)].geometry_a || !same_part(model, pair, before)) continue;
        const double phi = gaps.calc(pair, deepest);
        if (phi >= deepest) continue;
        deepest = phi;
        *of = pair;
        whole = false;
      }
    }
    if (whole) return true;
  }
  return false;
}

/// Deflection of the joint springs when the jaws press on each other with 1 N along the line between their centres (n_a).     (R.1)
Eigen::VectorXd calc_strain(const Model& model, const Pinch& pinch, const GeometryWorkspace& work) {
  const world::Geometry &a = robot_side(model, pinch.pair_a), &b = robot_side(model, pinch.pair_b);
  const std::vector<char> all(at(model.n_a()), 1);
  const Eigen::Vector3d f = (centre(work, b) - centre(work, a)).normalized();
  const Eigen::VectorXd torque = (centre_rates(model, work, a, all) - centre_rates(model, work, b, all)).transpose() * f;
  return torque.cwiseQuotient(model.scales().joints().cwiseProduct(model.stiffness()));
}

/// Largest force of the jaws that the command limits and efforts of these joints allow [N].
double calc_most_press(const Model& model, std::span<const int> joints, const Eigen::VectorXd& strain, const Eigen::VectorXd& q) {
  double most = std::numeric_limits<double>::infinity();
  for (const int j : joints) {
    const double by_1_n = std::abs(strain[j]), q_j = q[model.n_qu() + j];
    if (by_1_n * model.scales().robots().force < kNoStrain * model.scales().joint(j)) continue;
    const double room = strain[j] > 0 ? model.command_upper()[j] - q_j : q_j - model.command_lower()[j];
    most = std::min(most, std::min(room, model.effort()[j] / model.stiffness()[j]) / by_1_n);
  }
  return most;
}

/// Closes one jaw farther and opens the other until both can press equally hard; the trunk follows.
bool balance(const Model& model, const world::RobotChains& chains, const Pinch& pinch, int trunk, Eigen::VectorXd& q,
             GeometryWorkspace& work) {
  const Eigen::VectorXd strain = calc_strain(model, pinch, work);
  const auto fingers = chains.joints_of(pinch.moved & ~(world::ChainMask{1} << trunk));
  const auto of = [&](int pair) {
    std::vector<int> joints;
    std::ranges::copy_if(fingers, std::back_inserter(joints), [&](int j) {
      const auto& dofs = model.bodies()[at(robot_side(model, pair).body)].dofs;
      return std::ranges::find(dofs, model.n_vu() + j) != dofs.end();
    });
    return joints;
  };
  const std::vector<int> a = of(pinch.pair_a), b = of(pinch.pair_b);
  const double most_a = calc_most_press(model, a, strain, q), most_b = calc_most_press(model, b, strain, q);
  if (!std::isfinite(most_a) || !std::isfinite(most_b)) return true;
  const double shift = 0.5 * (most_a - most_b);
  for (const int j : a) q[model.n_qu() + j] += shift * strain[j];
  for (const int j : b) q[model.n_qu() + j] -= shift * strain[j];
  q.tail(model.n_a()) = q.tail(model.n_a()).cwiseMax(model.lower()).cwiseMin(model.upper()).eval();
  return touch(model, std::array{pinch.pair_a, pinch.pair_b}, joint_flags(model, chains.joints(trunk)), q, work);
}

/// Moves the hand away from bodies that block it, such as the table under the object, while both jaws stay on the object.
bool make_room(const Model& model, const world::RobotChains& chains, const Pinch& pinch, Eigen::VectorXd& q, GeometryWorkspace& work) {
  const double tolerance = world::share::kContact * model.scales().robots().length,
               room = world::share::kClearance * model.scales().robots().length;
  const std::vector<char> moving = joint_flags(model, chains.joints_of(pinch.moved));
  chains.pairs_of(pinch.moved, work.pairs);
  std::erase_if(work.pairs, [&](int i) {
    return model.pairs()[at(i)].geometry_a == model.pairs()[at(pinch.pair_a)].geometry_a &&
           (same_part(model, i, pinch.pair_a) || same_part(model, i, pinch.pair_b));
  });
  std::vector<int> pairs{pinch.pair_a, pinch.pair_b};
  std::vector<double> wanted{0, 0};
  for (int k = 0; k <= kInTheWay; ++k) {
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    Gaps gaps(model, work.kinematics, work.contact_work);
    double nearest = kBlocked * tolerance;
    int blocked = -1;
    for (const int i : work.pairs) {
      const double phi = gaps.calc(i, nearest);
      if (phi < nearest) nearest = phi, blocked = i;
    }
    if (blocked < 0) return true;
    if (k == kInTheWay) break;
    pairs.push_back(blocked);
    wanted.push_back(room);
    if (!touch(model, pairs, moving, q, work, wanted)) return false;
  }
  return false;
}

Eigen::Vector3d random_direction(core::Random& random) {
  Eigen::Vector3d v;
  do {
    for (double& x : v) x = random.normal();
  } while (v.norm() < 1e-6);
  return v.normalized();
}

/// Weight of the free object between the jaws [N]; 0 for objects on joints, and without gravity.
double calc_weight(const Model& model, const Pinch& pinch) {
  const int body = object_side(model, pinch.pair_a).body;
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    if (model.objects()[i].body == body && model.scene().objects[i].joint == world::ObjectJoint::Free)
      return model.objects()[i].carried_mass * model.scene().gravity.norm();
  }
  return 0;
}

}  // namespace

std::optional<Pinch> draw_pinch(const Model& model, const world::RobotChains& chains, int trunk, world::ChainMask draw,
                                std::span<const char> touch, core::Random& random, std::vector<int>& scratch) {
  const auto joints = chains.joints(trunk);
  const auto fingers = [&](int pair) {  // branches that move the pair, without the trunk and its carriers
    world::ChainMask mask = chains.mask_of_pair(pair);
    for (int c = 0; c < chains.size(); ++c) {
      if (chains.depth(c) <= chains.depth(trunk)) mask &= ~(world::ChainMask{1} << c);
    }
    return mask;
  };
  const auto carried = [&](int pair) {  // whether all joints of the trunk carry the pair
    const auto& dofs = model.bodies()[at(robot_side(model, pair).body)].dofs;
    return (touch.empty() || touch[at(pair)] != 0) && (fingers(pair) & ~draw) == 0 &&
           std::ranges::find(dofs, model.n_vu() + joints.back()) != dofs.end();
  };
  scratch.clear();
  world::ChainMask hand = 0;
  for (const int pair : chains.object_pairs(trunk)) {
    hand |= fingers(pair);
    if (carried(pair) && fingers(pair) != 0) scratch.push_back(pair);
  }
  if (scratch.empty() || std::popcount(hand) > kJaws) return std::nullopt;
  Pinch pinch;
  pinch.pair_a = scratch[at(random.index(static_cast<int>(scratch.size())))];
  scratch.clear();
  for (const int pair : chains.object_pairs(trunk)) {
    if (carried(pair) && model.pairs()[at(pair)].geometry_a == model.pairs()[at(pinch.pair_a)].geometry_a &&
        !same_part(model, pair, pinch.pair_a))
      scratch.push_back(pair);
  }
  if (scratch.empty()) return std::nullopt;
  pinch.pair_b = scratch[at(random.index(static_cast<int>(scratch.size())))];
  pinch.moved = world::ChainMask{1} << trunk | fingers(pinch.pair_a) | fingers(pinch.pair_b);
  return pinch;
}

bool close_pinch(const Model& model, const world::RobotChains& chains, Pinch pinch, int trunk, core::Random& random, Eigen::VectorXd& q,
                 GeometryWorkspace& work) {
  const auto reaching = joint_flags(model, chains.joints(trunk)), closing = joint_flags(model, chains.joints_of(pinch.moved));
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  const world::Geometry& held = object_side(model, pinch.pair_a);
  const double radius = std::min(held.bounding_radius, model.scales().robots().length);
  const Eigen::Vector3d place = centre(work, held) + kOffCentre * radius * random.uniform(0, 1) * random_direction(random);
  Eigen::Vector3d axis;
  for (int round = 0; round < kRounds; ++round) {
    if (!reach(model, pinch, reaching, place, round == 0 ? nullptr : &axis, q, work) ||
        !close(model, chains, trunk, closing, pinch, q, work) || !balance(model, chains, pinch, trunk, q, work) ||
        !make_room(model, chains, pinch, q, work))
      return false;
    const Distance a = pair_distance(model, work.kinematics, pinch.pair_a, work.contact_work),
                   b = pair_distance(model, work.kinematics, pinch.pair_b, work.contact_work);
    // Use the line between the centres of the parts: the nearest points of two touching faces are not unique.
    const Eigen::Vector3d line =
        (centre(work, robot_side(model, pinch.pair_b)) - centre(work, robot_side(model, pinch.pair_a))).normalized();
    const auto in_cone = [&](int pair, double cosine) {
      return cosine > std::cos(std::atan(kOfFriction * model.pairs()[at(pair)].friction));
    };
    if (in_cone(pinch.pair_a, a.nhat_BA_W.dot(line)) && in_cone(pinch.pair_b, -b.nhat_BA_W.dot(line))) return true;
    axis = a.nhat_BA_W;
  }
  return false;
}

std::optional<Eigen::VectorXd> hold_pinch(const Model& model, const Pinch& pinch, const Eigen::VectorXd& q, const GeometryWorkspace& work) {
  const world::Pair &a = model.pairs()[at(pinch.pair_a)], &b = model.pairs()[at(pinch.pair_b)];
  const double weight = calc_weight(model, pinch), friction = std::min(a.friction, b.friction);
  if (weight == 0 || friction == 0) return q.tail(model.n_a());
  std::vector<int> joints(at(model.n_a()));
  std::iota(joints.begin(), joints.end(), 0);
  const Eigen::VectorXd strain = calc_strain(model, pinch, work);
  const double fragile = kOfFragile * std::min(a.max_force, b.max_force);
  const double press = std::min({world::share::kPreload * weight, fragile, calc_most_press(model, joints, strain, q)});
  if (press < weight / (2 * friction)) return std::nullopt;
  return q.tail(model.n_a()) + press * strain;
}

}  // namespace stiction::contact
