#include "stiction/planning/contact_sampler.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
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

/// Row of dφ/dq_a over all joints for one contact (A relative to B along n), zero for joints that are not `moving`. The first row of
/// contact::calc_jacobian() where it is asked for.
void gap_gradient(const world::Model& model, const contact::Contact& contact, const std::vector<char>& moving,
                  const GeometryWorkspace& work, Eigen::Ref<Eigen::VectorXd> gradient) {
  const auto& pair = model.pairs()[static_cast<std::size_t>(contact.pair)];
  const auto axes_of = [&](int geometry) -> const std::vector<int>& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)].axes;
  };
  const auto &axes_a = axes_of(pair.geometry_a), &axes_b = axes_of(pair.geometry_b);
  const auto has = [](const std::vector<int>& axes, int axis) { return std::find(axes.begin(), axes.end(), axis) != axes.end(); };
  const auto is_moving = [&](int dof) { return dof >= model.n_vu() && moving[static_cast<std::size_t>(dof - model.n_vu())]; };
  gradient.setZero();
  const auto add = [&](int index, bool moves_a, bool moves_b) {
    const world::Follower* follower = index < model.n_v() ? nullptr : &model.followers()[static_cast<std::size_t>(index - model.n_v())];
    const int dof = follower ? follower->dof : index;
    if (!is_moving(dof)) return;
    const Eigen::Vector3d axis = work.kinematics.axis_W.col(index);
    const bool slides = (follower ? follower->kind : model.dofs()[static_cast<std::size_t>(dof)].kind) == world::DofKind::Prismatic;
    const auto rate = [&](const Eigen::Vector3d& p_W, const Eigen::Vector3d& origin_W) {
      return contact.nhat_BA_W.dot(slides ? axis : Eigen::Vector3d(axis.cross(p_W - origin_W)));
    };
    const Eigen::Vector3d origin = work.kinematics.origin_W.col(index);
    double phi_rate = 0;
    if (!moves_b)
      phi_rate = rate(contact.p_WA, origin);
    else if (!moves_a)
      phi_rate = -rate(contact.p_WB, origin);
    else if (!slides)
      phi_rate = rate(contact.p_WA, contact.p_WB);  // moved together: only the gap between the two points counts
    gradient[dof - model.n_vu()] += follower ? follower->ratio * phi_rate : phi_rate;
  };
  for (const int axis : axes_a) add(axis, true, has(axes_b, axis));
  for (const int axis : axes_b) {
    if (!has(axes_a, axis)) add(axis, false, true);
  }
}

std::vector<char> joint_flags(const world::Model& model, const std::vector<int>& joints) {
  std::vector<char> flags(static_cast<std::size_t>(model.n_a()), 0);
  for (const int j : joints) flags[static_cast<std::size_t>(j)] = 1;
  return flags;
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

  Surroundings(const RobotChains& chains, int chain) {
    std::vector<int> pairs;
    chains.pairs_of(ChainMask{1} << chain, pairs);
    for (const int i : pairs) (chains.touches_object(i) ? objects : others).push_back(i);
  }

  /// No pair is deeper than allowed: −kTouch with objects, kSelfClearance elsewhere.
  bool are_clear(const world::Model& model, GeometryWorkspace& work) const {
    const double tolerance = world::share::kContact * model.scales().robots().length;
    return !contact::any_nearer(model, work.kinematics, others, kSelfClearance * tolerance, work.contact_work) &&
           !contact::any_nearer(model, work.kinematics, objects, -kTouch * tolerance, work.contact_work);
  }
};

/// Brings one pair into contact by Newton steps on its gap in the branch's joints; q is changed in place. Only what moves the pair is
/// computed: the rest of the kinematics in `work` is out of date after it.
bool touch(const world::Model& model, int pair, const std::vector<char>& moving, Eigen::VectorXd& q, GeometryWorkspace& work) {
  Eigen::VectorXd gradient(model.n_a());
  const int pairs[1] = {pair};
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
    contact::query_pairs(model, work.kinematics, pairs, std::numeric_limits<double>::infinity(), work.contact_work, work.contacts);
    if (work.contacts.empty()) return false;
    const auto& c =
        *std::min_element(work.contacts.begin(), work.contacts.end(), [](const auto& a, const auto& b) { return a.phi < b.phi; });
    if (std::abs(c.phi) < close_enough) return true;
    if (iteration % kPatience == 0 && std::abs(c.phi) > 0.5 * std::exchange(gap, std::abs(c.phi))) return false;
    gap_gradient(model, c, moving, work, gradient);
    const Eigen::VectorXd slope = gradient.cwiseProduct(unit);  // dφ/d(q/unit)
    const double slope2 = slope.squaredNorm();
    if (!(slope2 > std::pow(kFlat * length, 2))) return false;
    double scale = -c.phi / slope2;
    scale *= std::min(1.0, kMaxStep / (std::abs(scale) * slope.cwiseAbs().maxCoeff()));
    q.tail(model.n_a()) = (q.tail(model.n_a()) + scale * slope.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
  }
  return false;
}

bool sample_chain(const world::Model& model, const RobotChains& chains, const GenericSampler& options, int chain, core::Random& random,
                  Eigen::VectorXd& q, GeometryWorkspace& work) {
  const auto joints = chains.joints(chain);
  const auto pairs = chains.object_pairs(chain);
  if (pairs.empty()) return false;
  const auto moving = joint_flags(model, {joints.begin(), joints.end()});
  const Surroundings around(chains, chain);
  const Eigen::VectorXd q_before = q;
  update_kinematics(model, q, work);
  std::vector<std::pair<double, double>> ranges;
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
    const int pair = pairs[static_cast<std::size_t>(random.index(static_cast<int>(pairs.size())))];
    if (!touch(model, pair, moving, q, work)) continue;
    update_kinematics(model, q, work);
    if (around.are_clear(model, work)) return true;
  }
  q = q_before;
  return false;
}

/// Branches that can touch an object.
std::vector<int> touching_chains(const RobotChains& chains) {
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

GraspDraw draw_grasp(const RobotChains& chains, const GenericSampler& sampler, core::Random& random) {
  std::vector<int> order = touching_chains(chains);
  shuffle(order, random);
  if (!random.chance(sampler.whole_probability)) order.resize(std::min(order.size(), static_cast<std::size_t>(1 + random.index(2))));
  GraspDraw draw;
  for (const int c : order) draw.moved |= ChainMask{1} << c;
  return draw;
}

std::optional<ContactSample> sample_contact(const world::Model& model, const RobotChains& chains, const GenericSampler& sampler,
                                            const GraspDraw& draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work) {
  std::vector<int> order = touching_chains(chains);
  std::erase_if(order, [&](int c) { return !(draw.moved >> c & 1); });
  shuffle(order, random);
  // What carries others goes first: a trunk would take fingers off the object again.
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return chains.depth(a) < chains.depth(b); });

  ContactSample sample;
  for (const int chain : order) {
    if (sample_chain(model, chains, sampler, chain, random, q, work)) sample.moved |= ChainMask{1} << chain;
  }
  if (sample.moved == 0) return std::nullopt;
  sample.q_a = q.tail(model.n_a());
  return sample;
}

Eigen::VectorXd gap_gradient(const world::Model& model, const contact::Contact& contact, std::span<const int> joints,
                             GeometryWorkspace& work) {
  Eigen::VectorXd out(model.n_a());
  gap_gradient(model, contact, joint_flags(model, {joints.begin(), joints.end()}), work, out);
  return out;
}

bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance,
             std::span<const Eigen::VectorXd> places, Eigen::VectorXd& q_a, GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path,
             int rounds) {
  const int n_a = model.n_a();
  const auto joints = joint_flags(model, chains.joints_of(moving));
  chains.pairs_of(moving, work.pairs);
  const std::vector<int> all = work.pairs;
  std::vector<int> objects;  // what does not change from place to place is looked at once
  std::copy_if(all.begin(), all.end(), std::back_inserter(objects), [&](int pair) { return chains.touches_object(pair); });
  constexpr double kStep = 0.04;     // per round and joint, so that the straight line between rounds stays clear [rad, L]
  constexpr double kDamping = 1e-4;  // ρ [L²]
  const double length = model.scales().robots().length;
  Eigen::VectorXd unit(n_a);
  for (int j = 0; j < n_a; ++j) unit[j] = model.scales().joint(j);
  for (int round = 0; round < rounds && !work.stop(); ++round) {
    // δ = argmin ‖δ‖², in joint units, with every short gap brought to 1.5 × clearance: δ = Gᵀ(GGᵀ + ρI)⁻¹r
    Eigen::MatrixXd G(n_a, 0);
    Eigen::VectorXd r;
    for (std::size_t k = 0; k < places.size(); ++k) {
      Eigen::VectorXd q = places[k];
      q.tail(n_a) = q_a;
      update_kinematics(model, q, work);
      contact::query_pairs(model, work.kinematics, k == 0 ? all : objects, clearance, work.contact_work, work.contacts);
      std::erase_if(work.contacts, [&](const auto& c) { return c.phi >= clearance; });
      const Eigen::Index before = r.size(), m = static_cast<Eigen::Index>(work.contacts.size());
      G.conservativeResize(Eigen::NoChange, before + m);
      r.conservativeResize(before + m);
      for (Eigen::Index i = 0; i < m; ++i) {
        const auto contact = work.contacts[static_cast<std::size_t>(i)];
        gap_gradient(model, contact, joints, work, G.col(before + i));
        r[before + i] = 1.5 * clearance - contact.phi;
      }
    }
    if (r.size() == 0) return true;
    G = unit.asDiagonal() * G;
    Eigen::MatrixXd S = G.transpose() * G;
    S.diagonal().array() += kDamping * length * length;
    Eigen::VectorXd delta = G * S.ldlt().solve(r);
    const double largest = delta.cwiseAbs().maxCoeff();
    if (!(largest > 1e-9)) return false;
    delta *= std::min(1.0, kStep / largest);
    q_a = (q_a + delta.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
    path.push_back(q_a);
  }
  return false;
}

bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path) {
  Eigen::VectorXd q_a = q.tail(model.n_a());
  const bool clear = retreat(model, chains, moving, clearance, {&q, 1}, q_a, work, path);
  q.tail(model.n_a()) = q_a;
  return clear;
}

}  // namespace stiction::planning
