#include "stiction/contact/contact_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "stiction/contact/gap_gradient.hpp"
#include "stiction/contact/within_reach.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {
namespace {

constexpr double kTouch = 0.1;          // a gap this small counts as contact [contact tolerance of the pair]
constexpr double kSelfClearance = 0.5;  // between robot parts, and of the robot to fixed bodies [the same of the robots]
constexpr double kFlat = 1e-3;          // a gap that changes by less with every joint is not closed [L per joint unit]
constexpr int kNewtonSteps = 15;
constexpr int kPatience = 4;      // Newton steps in which a gap has to become half as wide: what is out of reach never does
constexpr double kMaxStep = 0.3;  // per Newton step and joint [rad, L]

void update_kinematics(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
}

/// Values of a slider at which something that it carries may be beside an object: the objects' extent along the axis, seen from what
/// lies farthest and nearest along it. Uses the kinematics of the workspace, in which the slider is at `value`.
std::pair<double, double> slider_range(const world::Model& model, std::span<const int> object_pairs, int joint, double value,
                                       const GeometryWorkspace& work) {
  const Eigen::Vector3d axis = work.kinematics.axis_W.col(model.n_vu() + joint);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const int i : object_pairs) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(i)];
    double place[2] = {0, 0}, radius = 0;  // along the axis: of the object's geometry, of the robot's
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

/// Range from which a joint is drawn: its limits, or for an unlimited slider the surroundings of the objects.
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

/// The pairs that a branch moves, apart by what may be touched.
struct Surroundings {
  std::vector<int> objects, others;

  Surroundings(const world::RobotChains& chains, int chain) {
    std::vector<int> pairs;
    chains.pairs_of(world::ChainMask{1} << chain, pairs);
    for (const int i : pairs) (chains.touches_object(i) ? objects : others).push_back(i);
  }

  /// No pair is deeper than allowed: −kTouch with objects, kSelfClearance elsewhere.
  bool are_clear(const world::Model& model, GeometryWorkspace& work) const {
    const double tolerance = world::share::kContact * model.scales().robots().length;
    return !any_nearer(model, work.kinematics, others, kSelfClearance * tolerance, work.contact_work) &&
           !any_nearer(model, work.kinematics, objects, -kTouch * tolerance, work.contact_work);
  }
};

/// Brings one pair into contact by Newton steps on its gap in the branch's joints; q is changed in place. Only what moves the pair is
/// computed: the rest of the kinematics in `work` is out of date after it.
bool touch(const world::Model& model, int pair, const std::vector<char>& moving, Eigen::VectorXd& q, GeometryWorkspace& work) {
  Eigen::VectorXd gradient(model.n_a());
  Contact c;
  c.pair = pair;
  const auto body = [&](int geometry) { return model.geometries()[static_cast<std::size_t>(geometry)].body; };
  const world::Pair& of = model.pairs()[static_cast<std::size_t>(pair)];
  const int bodies[2] = {body(of.geometry_a), body(of.geometry_b)};
  work.links.select(model, moving, bodies);
  const double length = model.scales().robots().length, close_enough = 0.5 * kTouch * world::share::kContact * length;
  Eigen::VectorXd unit(model.n_a());  // of the joints, in which steps are short
  for (int j = 0; j < model.n_a(); ++j) unit[j] = model.scales().joint(j);
  double gap = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kNewtonSteps; ++iteration) {
    work.links.update(model, q, work.kinematics);
    const Distance d = pair_distance(model, work.kinematics, pair, work.contact_work);
    if (std::abs(d.phi) < close_enough) return true;
    c.phi = d.phi;
    c.p_WA = d.p_WA;
    c.p_WB = d.p_WB;
    c.nhat_BA_W = d.nhat_BA_W;
    if (iteration % kPatience == 0 && std::abs(c.phi) > 0.5 * std::exchange(gap, std::abs(c.phi))) return false;
    calc_gap_gradient(model, c, moving, work.kinematics, gradient);
    const Eigen::VectorXd slope = gradient.cwiseProduct(unit);  // dφ/d(q/unit)
    const double slope2 = slope.squaredNorm();
    if (!(slope2 > std::pow(kFlat * length, 2))) return false;
    double scale = -c.phi / slope2;
    scale *= std::min(1.0, kMaxStep / (std::abs(scale) * slope.cwiseAbs().maxCoeff()));
    q.tail(model.n_a()) = (q.tail(model.n_a()) + scale * slope.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
  }
  return false;
}

bool sample_chain(const world::Model& model, const world::RobotChains& chains, const GenericSampler& options, int chain,
                  core::Random& random, Eigen::VectorXd& q, GeometryWorkspace& work) {
  const auto joints = chains.joints(chain);
  std::vector<int> pairs;
  std::ranges::copy_if(chains.object_pairs(chain), std::back_inserter(pairs),
                       [&](int pair) { return options.touch.empty() || options.touch[static_cast<std::size_t>(pair)] != 0; });
  if (pairs.empty()) return false;
  const auto moving = joint_flags(model, joints);
  const Surroundings around(chains, chain);
  const Eigen::VectorXd q_before = q;
  update_kinematics(model, q, work);
  std::vector<std::pair<double, double>> ranges;
  std::vector<char> reachable;
  for (const int pair : pairs) reachable.push_back(may_touch(model, work.kinematics, q, moving, pair));
  for (const int j : joints) ranges.push_back(draw_range(model, pairs, j, q[model.n_qu() + j], work));
  for (int attempt = 0; attempt < options.tries && !work.stop(); ++attempt) {
    q = q_before;
    const bool near = random.chance(options.near_probability);
    for (std::size_t k = 0; k < joints.size(); ++k) {
      double& value = q[model.n_qu() + joints[k]];
      const auto [low, high] = ranges[k];
      const double spread = options.near_std * model.scales().joint(joints[k]);
      value = near ? std::clamp(value + spread * random.normal(), low, high) : random.uniform(low, high);
    }
    const auto drawn = static_cast<std::size_t>(random.index(static_cast<int>(pairs.size())));
    if (!reachable[drawn] || !touch(model, pairs[drawn], moving, q, work)) continue;
    update_kinematics(model, q, work);
    if (around.are_clear(model, work)) return true;
  }
  q = q_before;
  return false;
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
  // What carries others goes first: a trunk would take fingers off the object again.
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return chains.depth(a) < chains.depth(b); });

  ContactSample sample;
  for (const int chain : order) {
    if (sample_chain(model, chains, sampler, chain, random, q, work)) sample.moved |= world::ChainMask{1} << chain;
  }
  if (sample.moved == 0) return std::nullopt;
  sample.q_a = q.tail(model.n_a());
  return sample;
}

}  // namespace stiction::contact
