#include "stiction/contact/contact_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "stiction/contact/gap_gradient.hpp"
#include "stiction/contact/pinch.hpp"
#include "stiction/contact/touch.hpp"
#include "stiction/contact/within_reach.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {
namespace {

constexpr double kSelfClearance = 0.5;  // least gap between robot parts, and to fixed bodies [contact tolerance of the robots]

void update_kinematics(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
}

/// Range of a slider's position in which a geometry that it carries may lie beside an object. Bounding spheres along the slider axis
/// give the range. Uses the kinematics of the workspace, in which the slider is at `value`.
std::pair<double, double> slider_range(const world::Model& model, std::span<const int> object_pairs, int joint, double value,
                                       const GeometryWorkspace& work) {
  const Eigen::Vector3d axis = work.kinematics.axis_W.col(model.n_vu() + joint);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const int i : object_pairs) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(i)];
    double place[2] = {0, 0}, radius = 0;  // centres along the axis: the object's geometry, the robot's geometry
    for (const int g : {pair.geometry_a, pair.geometry_b}) {
      const auto& geometry = model.geometries()[static_cast<std::size_t>(g)];
      const bool robot = model.bodies()[static_cast<std::size_t>(geometry.body)].kind == world::BodyKind::Robot;
      place[robot] = axis.dot(work.kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter);
      radius += geometry.bounding_radius;
    }
    low = std::min(low, value + place[0] - place[1] - radius);
    high = std::max(high, value + place[0] - place[1] + radius);
  }
  return {low, high};
}

/// Range from which a joint position is drawn: the joint limits, or the surroundings of the objects for an unlimited slider.
std::pair<double, double> draw_range(const world::Model& model, std::span<const int> object_pairs, int joint, double value,
                                     const GeometryWorkspace& work) {
  const double lower = model.lower()[joint], upper = model.upper()[joint];
  if (std::isfinite(lower) && std::isfinite(upper)) return {lower, upper};
  if (model.dofs()[static_cast<std::size_t>(model.n_vu() + joint)].kind == world::DofKind::Revolute)
    return {-std::numbers::pi, std::numbers::pi};
  const auto [low, high] = slider_range(model, object_pairs, joint, value, work);
  if (!(std::isfinite(low) && std::isfinite(high))) return {std::max(-1.0, lower), std::min(1.0, upper)};
  return {std::clamp(low, lower, upper), std::clamp(high, lower, upper)};
}

/// The pairs that the branches move: pairs with an object, which may be touched, and all others.
struct Surroundings {
  std::vector<int> objects, others;

  Surroundings(const world::RobotChains& chains, world::ChainMask moved) {
    std::vector<int> pairs;
    chains.pairs_of(moved, pairs);
    for (const int i : pairs) (chains.touches_object(i) ? objects : others).push_back(i);
  }

  /// Whether every pair has its least gap: −kTouch with objects, kSelfClearance for the others [contact tolerance of the robots].
  bool are_clear(const world::Model& model, GeometryWorkspace& work) const {
    const double tolerance = world::share::kContact * model.scales().robots().length;
    return !any_nearer(model, work.kinematics, others, kSelfClearance * tolerance, work.contact_work) &&
           !any_nearer(model, work.kinematics, objects, -kTouch * tolerance, work.contact_work);
  }
};

/// Draws postures of some joints, near the present posture or anywhere in their ranges.
class Draw {
 public:
  /// @param object_pairs  pairs of an object and a geometry that the branch moves
  Draw(const world::Model& model, const GenericSampler& options, std::span<const int> joints, std::span<const int> object_pairs,
       const Eigen::VectorXd& q, const GeometryWorkspace& work)
      : model_(model), options_(options), joints_(joints) {
    for (const int j : joints) ranges_.push_back(draw_range(model, object_pairs, j, q[model.n_qu() + j], work));
  }

  void draw(core::Random& random, Eigen::VectorXd& q) const {
    const bool near = random.chance(options_.near_probability);
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      double& value = q[model_.n_qu() + joints_[k]];
      const auto [low, high] = ranges_[k];
      const double spread = options_.near_std * model_.scales().joint(joints_[k]);
      value = near ? std::clamp(value + spread * random.normal(), low, high) : random.uniform(low, high);
    }
  }

 private:
  const world::Model& model_;
  const GenericSampler& options_;
  std::span<const int> joints_;
  std::vector<std::pair<double, double>> ranges_;
};

bool sample_chain(const world::Model& model, const world::RobotChains& chains, const GenericSampler& options, int chain,
                  core::Random& random, Eigen::VectorXd& q, GeometryWorkspace& work) {
  const auto joints = chains.joints(chain);
  std::vector<int> pairs;
  std::ranges::copy_if(chains.object_pairs(chain), std::back_inserter(pairs),
                       [&](int pair) { return options.touch.empty() || options.touch[static_cast<std::size_t>(pair)] != 0; });
  if (pairs.empty()) return false;
  const auto moving = joint_flags(model, joints);
  const Surroundings around(chains, world::ChainMask{1} << chain);
  const Eigen::VectorXd q_before = q;
  update_kinematics(model, q, work);
  std::vector<char> reachable;
  for (const int pair : pairs) reachable.push_back(may_touch(model, work.kinematics, q, moving, pair));
  const Draw posture(model, options, joints, pairs, q, work);
  for (int attempt = 0; attempt < options.tries && !work.stop(); ++attempt) {
    q = q_before;
    posture.draw(random, q);
    const auto drawn = static_cast<std::size_t>(random.index(static_cast<int>(pairs.size())));
    if (!reachable[drawn] || !touch(model, std::span(pairs).subspan(drawn, 1), moving, q, work)) continue;
    update_kinematics(model, q, work);
    if (around.are_clear(model, work)) return true;
  }
  q = q_before;
  return false;
}

/// Draws a pinch: two parts of the hand that `trunk` carries touch opposite sides of an object.
/// @param press  the offset of the command from the posture is added to it (n_a)
/// @returns the moved branches; 0 if the hand has no such parts or the draws were used up
world::ChainMask sample_pinch(const world::Model& model, const world::RobotChains& chains, const GenericSampler& options, int trunk,
                              world::ChainMask draw, core::Random& random, Eigen::VectorXd& q, Eigen::VectorXd& press,
                              GeometryWorkspace& work) {
  const Eigen::VectorXd q_before = q;
  for (int attempt = 0; attempt < options.pinch_tries && !work.stop(); ++attempt) {
    const auto pinch = draw_pinch(model, chains, trunk, draw, options.touch, random, work.pairs);
    if (!pinch || (attempt == 0 && !random.chance(options.pinch_probability))) return 0;
    q = q_before;
    update_kinematics(model, q, work);
    const std::vector<int> joints = chains.joints_of(pinch->moved);
    Draw(model, options, joints, chains.object_pairs(trunk), q, work).draw(random, q);
    if (!close_pinch(model, chains, *pinch, trunk, random, q, work)) continue;
    update_kinematics(model, q, work);
    if (!Surroundings(chains, pinch->moved).are_clear(model, work)) continue;
    const auto u = hold_pinch(model, *pinch, q, work);
    if (!u) continue;
    press += *u - q.tail(model.n_a());
    return pinch->moved;
  }
  q = q_before;
  return 0;
}

/// Branches that can touch an object.
std::vector<int> touching_chains(const world::RobotChains& chains) {
  std::vector<int> out;
  for (int c = 0; c < chains.size(); ++c) {
    if (!chains.object_pairs(c).empty()) out.push_back(c);
  }
  return out;
}

void shuffle(std::vector<int>& values, core::Random& random) {
  for (std::size_t i = values.size(); i > 1; --i)
    std::swap(values[i - 1], values[static_cast<std::size_t>(random.index(static_cast<int>(i)))]);
}

}  // namespace

world::ChainMask draw_grasp(const world::RobotChains& chains, const GenericSampler& sampler, core::Random& random) {
  std::vector<int> order = touching_chains(chains);
  shuffle(order, random);
  if (!random.chance(sampler.whole_probability)) order.resize(std::min(order.size(), static_cast<std::size_t>(1 + random.index(2))));
  world::ChainMask draw = 0;
  for (const int c : order) draw |= world::ChainMask{1} << c;
  return draw;
}

std::optional<ContactSample> sample_contact(const world::Model& model, const world::RobotChains& chains, const GenericSampler& sampler,
                                            world::ChainMask draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work) {
  std::vector<int> order = touching_chains(chains);
  std::erase_if(order, [&](int c) { return !(draw >> c & 1); });
  shuffle(order, random);
  // A trunk is placed before the branches it carries; otherwise it would take their fingers off the object again.
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return chains.depth(a) < chains.depth(b); });

  ContactSample sample;
  Eigen::VectorXd press = Eigen::VectorXd::Zero(model.n_a());
  for (const int chain : order) {
    if (sample.moved >> chain & 1) continue;
    sample.moved |= sample_pinch(model, chains, sampler, chain, draw, random, q, press, work);
    if (sample.moved >> chain & 1) continue;
    if (sample_chain(model, chains, sampler, chain, random, q, work)) sample.moved |= world::ChainMask{1} << chain;
  }
  if (sample.moved == 0) return std::nullopt;
  sample.q_a = q.tail(model.n_a());
  sample.u = sample.q_a + press;
  return sample;
}

}  // namespace stiction::contact
