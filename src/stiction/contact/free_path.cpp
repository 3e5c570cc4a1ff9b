#include "stiction/contact/free_path.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "stiction/contact/clearance.hpp"
#include "stiction/contact/gap_gradient.hpp"
#include "stiction/world/axis.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {

using world::ChainMask;
using world::RobotChains;

namespace {

using Posture = Eigen::VectorXd;

/// Two postures that differ by less count as equal [joint units].
constexpr double kNoMove = 1e-12;
/// Lower limit of the clearance that sets how often gaps are checked: a gap need not be checked again before it may have shrunk by this
/// [L of the robots]. It matters for paths with little or no clearance.
constexpr double kLeastClearance = 1e-3;

/// Upper bounds of the motion of geometries while the robots' joints move along a straight line.
class Travel {
 public:
  explicit Travel(const world::Model& model) : model_(model) {
    for (const auto& geometry : model.geometries()) {
      begin_.push_back(rest_.size());
      rest_.resize(rest_.size() + body_of(geometry).axes.size() + 1);
    }
  }

  /// Computes the bounds for one line. A hinge moves a point by at most its turn times the distance of the point from the axis. This
  /// distance grows by at most the motion due to the later axes, and never exceeds the length of the path from axis to axis.
  /// @param kinematics  kinematics at one end of the line
  void set_line(const world::Kinematics& kinematics, const Posture& from, const Posture& to) {
    for (std::size_t g = 0; g < begin_.size(); ++g) {
      const world::Geometry& geometry = model_.geometries()[g];
      const std::vector<int>& axes = body_of(geometry).axes;
      double* const rest = &rest_[begin_[g]];
      if (axes.empty() || axes.front() < model_.n_vu()) continue;  // an object, which stays where it is
      const Eigen::Vector3d center = kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter;
      Eigen::Vector3d behind = center;
      double extent = geometry.bounding_radius;
      for (std::size_t k = axes.size(); k-- > 0;) {
        const int axis = axes[k];
        const auto [dof, kind, ratio] = world::axis_at(model_, axis);
        const int joint = dof - model_.n_vu();
        const double turn = std::abs(ratio * (to[joint] - from[joint]));
        const Eigen::Vector3d origin = kinematics.origin_W.col(axis);
        extent += (behind - origin).norm();
        behind = origin;
        if (kind == world::DofKind::Revolute) {
          const double lever = kinematics.axis_W.col(axis).cross(center - origin).norm() + geometry.bounding_radius;
          rest[k] = rest[k + 1] + turn * std::min(lever + rest[k + 1], extent);
        } else {
          rest[k] = rest[k + 1] + turn;
          extent += 2 * turn;  // on either side of the origin
        }
      }
    }
  }

  /// Largest motion of any point of a geometry due to its axes from number `first` on [m].
  double of(int geometry, std::size_t first) const { return rest_[begin_[static_cast<std::size_t>(geometry)] + first]; }

  const world::Body& body_of(const world::Geometry& geometry) const { return model_.bodies()[static_cast<std::size_t>(geometry.body)]; }

 private:
  const world::Model& model_;
  std::vector<std::size_t> begin_;  ///< per geometry: its first entry in rest_
  std::vector<double> rest_;        ///< per axis of its body: motion due to this axis and the later ones [m]; 0 at the end
};

/// Collision queries of the moving branches among objects at rest.
class FreeSpace {
 public:
  FreeSpace(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q, double clearance,
            GeometryWorkspace& work)
      : model_(model),
        work_(work),
        gaps_(model, work.kinematics, work.contact_work),
        q_(q),
        least_(std::max(clearance, kLeastClearance * model.scales().robots().length)),
        joints_(chains.joints_of(moving)),
        travel_(model) {
    std::vector<int> pairs;
    chains.pairs_of(moving, pairs);
    const PairClearances clearances = split_by_clearance(model, pairs, clearance, work.contact_work);
    for (const int pair : clearances.pairs) add(pair, clearance);
    for (const auto& [pair, own] : clearances.close) add(pair, own);
  }

  const std::vector<int>& joints() const { return joints_; }
  bool stop() const { return work_.stop(); }

  /// Largest motion of a joint between the two postures [joint units].
  double move(const Posture& from, const Posture& to) const {
    double longest = 0;
    for (const int j : joints_) longest = std::max(longest, std::abs(to[j] - from[j]) / model_.scales().joint(j));
    return longest;
  }

  /// Whether the straight line is free. A pair is checked again where its motion may have used up its last known gap, but not before the
  /// gap may have shrunk by the least clearance. Between two checked postures a gap is therefore never less than half of the clearance.
  bool line(const Posture& from, const Posture& to) {
    if (move(from, to) < kNoMove) return true;
    place(to);  // most blocked lines are blocked at their end
    const double longest = calc_travel(from, to);
    under_way_.clear();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      UnderWay whole{i, 0, 1};
      const double free = calc_free(whole, 1);
      if (free < 0) return block(i);
      whole.to -= free;
      if (free < 1) under_way_.push_back(whole);
    }
    std::ranges::make_heap(under_way_, std::greater(), &UnderWay::from);
    while (!under_way_.empty()) {
      const double t = under_way_.front().from;
      place((1 - t) * from + t * to);
      while (!under_way_.empty() && under_way_.front().from < t + least_ / longest) {
        std::ranges::pop_heap(under_way_, std::greater(), &UnderWay::from);
        UnderWay& pair = under_way_.back();
        const double free = calc_free(pair, pair.to - t);
        if (free < 0) return block(pair.index);
        pair.from = t + std::max(free, least_ / pairs_[pair.index].travel);
        if (pair.from < pair.to)
          std::ranges::push_heap(under_way_, std::greater(), &UnderWay::from);
        else
          under_way_.pop_back();
      }
    }
    return true;
  }

 private:
  struct WatchedPair {
    int pair;
    double clearance;   ///< [m]
    int a, b;           ///< geometries of the pair
    std::size_t apart;  ///< number of leading axes that both bodies share; these axes do not change the gap
    double travel = 0;  ///< by how much the gap may shrink on the current line [m]
  };
  /// A pair that may come too near on a part of the line; `from` and `to` are shares of the line in [0, 1].
  struct UnderWay {
    std::size_t index;
    double from, to;
    double room = std::numeric_limits<double>::infinity();  ///< gap minus clearance when the gap was last known [m]
  };

  void add(int index, double clearance) {
    const world::Pair& pair = model_.pairs()[static_cast<std::size_t>(index)];
    const auto axes_of = [&](int geometry) -> const std::vector<int>& {
      return travel_.body_of(model_.geometries()[static_cast<std::size_t>(geometry)]).axes;
    };
    const auto &a = axes_of(pair.geometry_a), &b = axes_of(pair.geometry_b);
    const auto first = std::ranges::mismatch(a, b).in1;
    pairs_.push_back({index, clearance, pair.geometry_a, pair.geometry_b, static_cast<std::size_t>(first - a.begin())});
  }

  void place(const Posture& q_a) {
    q_.tail(model_.n_a()) = q_a;
    world::calc_kinematics(model_, q_, work_.kinematics_work, work_.kinematics);
    gaps_.forget();
  }

  /// Computes how much the gap of each pair may shrink on the straight line, from the kinematics at the end of the line.
  /// @returns the largest of these values, but at least the least clearance [m]
  double calc_travel(const Posture& from, const Posture& to) {
    travel_.set_line(work_.kinematics, from, to);
    double most = least_;
    for (WatchedPair& pair : pairs_) {
      pair.travel = travel_.of(pair.a, pair.apart) + travel_.of(pair.b, pair.apart);
      most = std::max(most, pair.travel);
    }
    return most;
  }

  /// Share of the line on which a pair certainly keeps its clearance, starting at the current posture; < 0 if it is too near now. A lower
  /// bound of the gap is enough if it frees a good part of the remaining line, or of the share that the last gap freed.
  double calc_free(UnderWay& of, double left) {
    constexpr double kOfTheRest = 0.1, kOfTheLast = 0.5;
    const WatchedPair& pair = pairs_[of.index];
    const double enough = pair.clearance + std::min(kOfTheRest * left * pair.travel, kOfTheLast * of.room);
    const double gap = gaps_.calc(pair.pair, enough), room = gap - pair.clearance;
    if (gap < enough) of.room = room;
    return room < left * pair.travel ? room / pair.travel : left;
  }

  /// Moves a blocking pair to the front, because it is likely to block the next line too. @returns false
  bool block(std::size_t i) {
    std::rotate(pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>(i), pairs_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    return false;
  }

  const world::Model& model_;
  GeometryWorkspace& work_;
  Gaps gaps_;
  Eigen::VectorXd q_;
  double least_;  ///< least clearance: a gap is not checked again before it may have shrunk by this [m]
  std::vector<int> joints_;
  std::vector<WatchedPair> pairs_;
  Travel travel_;
  std::vector<UnderWay> under_way_;
};

struct PathTree {
  std::vector<Posture> postures;
  std::vector<int> parents;

  explicit PathTree(const Posture& root) : postures{root}, parents{-1} {}
  int nearest(const Posture& q_a) const {
    int best = 0;
    double best_distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < postures.size(); ++i) {
      const double d = (postures[i] - q_a).squaredNorm();
      if (d < best_distance) {
        best_distance = d;
        best = static_cast<int>(i);
      }
    }
    return best;
  }
  int add(const Posture& q_a, int parent) {
    postures.push_back(q_a);
    parents.push_back(parent);
    return static_cast<int>(postures.size()) - 1;
  }
  std::vector<Posture> to_root(int i) const {
    std::vector<Posture> path;
    for (; i >= 0; i = parents[static_cast<std::size_t>(i)]) path.push_back(postures[static_cast<std::size_t>(i)]);
    return path;
  }
};

/// Extends the tree towards the target by at most `step`. @returns the new node, or −1 if the line is blocked
int extend(PathTree& tree, const Posture& target, double step, FreeSpace& space) {
  const int near = tree.nearest(target);
  const Posture& from = tree.postures[static_cast<std::size_t>(near)];
  const double length = space.move(from, target);
  if (length < kNoMove) return near;
  const Posture to = from + std::min(1.0, step / length) * (target - from);
  return space.line(from, to) ? tree.add(to, near) : -1;
}

std::pair<double, double> search_range(const world::Model& model, int joint, double a, double b) {
  // Range for random postures: around the two ends, cut off at the joint limits.
  const double pad = 0.8 * model.scales().joint(joint);
  return {std::max(model.lower()[joint], std::min(a, b) - pad), std::min(model.upper()[joint], std::max(a, b) + pad)};
}

bool connect(const world::Model& model, const Posture& start, const Posture& goal, const PathOptions& options, core::Random& random,
             FreeSpace& space, std::vector<Posture>& path) {
  if (space.line(start, goal)) {
    path = {start, goal};
    return true;
  }
  PathTree trees[2] = {PathTree(start), PathTree(goal)};
  for (int k = 0, side = 0; k < options.max_extensions && !space.stop(); ++k, side = 1 - side) {
    Posture target = start;
    for (const int j : space.joints()) {
      const auto [low, high] = search_range(model, j, start[j], goal[j]);
      target[j] = random.uniform(low, high);
    }
    const int grown = extend(trees[side], target, options.step, space);
    if (grown < 0) continue;
    const Posture reached = trees[side].postures[static_cast<std::size_t>(grown)];
    for (;;) {  // the other tree grows greedily towards the new node
      const int other = extend(trees[1 - side], reached, options.step, space);
      if (other < 0) break;
      if (space.move(trees[1 - side].postures[static_cast<std::size_t>(other)], reached) > kNoMove) continue;
      const int at_start = side == 0 ? grown : other;
      const int at_goal = side == 0 ? other : grown;
      path = trees[0].to_root(at_start);
      std::reverse(path.begin(), path.end());
      const auto rest = trees[1].to_root(at_goal);
      path.insert(path.end(), rest.begin() + 1, rest.end());
      return true;
    }
  }
  return false;
}

void shortcut(const PathOptions& options, core::Random& random, FreeSpace& space, std::vector<Posture>& path) {
  for (int attempt = 0; attempt < options.shortcuts && path.size() > 2; ++attempt) {
    const int n = static_cast<int>(path.size());
    const int a = random.index(n - 2);
    const int b = a + 2 + random.index(n - 2 - a);
    if (space.line(path[static_cast<std::size_t>(a)], path[static_cast<std::size_t>(b)]))
      path.erase(path.begin() + a + 1, path.begin() + b);
  }
}

}  // namespace

PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path) {
  path.clear();
  const int n_a = model.n_a();
  Eigen::VectorXd start = q, goal = q;
  goal.tail(n_a) = q_a_goal;
  if (!retreat(model, chains, moving, options.clearance, start, work, path)) return PathOutcome::StartBlocked;
  std::vector<Posture> approach;
  if (!retreat(model, chains, moving, options.clearance, goal, work, approach)) return PathOutcome::GoalBlocked;

  FreeSpace space(model, chains, moving, q, options.clearance * (1 - 1e-6), work);
  std::vector<Posture> middle;
  if (!connect(model, start.tail(n_a), goal.tail(n_a), options, random, space, middle)) return PathOutcome::NotFound;
  shortcut(options, random, space, middle);
  path.insert(path.end(), middle.begin() + 1, middle.end());
  for (auto it = approach.rbegin(); it != approach.rend(); ++it) {
    if (it != approach.rbegin()) path.push_back(*it);
  }
  path.push_back(q_a_goal);
  return PathOutcome::Found;
}

bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path) {
  constexpr int kRounds = 30;
  constexpr double kStep = 0.04;  // largest motion per round and joint, small so that the straight line between rounds stays clear [rad, L]
  constexpr double kDamping = 1e-4;  // ρ [L²]
  const int n_a = model.n_a();
  const auto joints = joint_flags(model, chains.joints_of(moving));
  chains.pairs_of(moving, work.pairs);
  const PairClearances own = split_by_clearance(model, work.pairs, clearance, work.contact_work);
  const auto clearance_of = [&](const Contact& c) {
    const auto found = std::ranges::find(own.close, c.pair, &std::pair<int, double>::first);
    return found != own.close.end() ? found->second : clearance;
  };
  const double length = model.scales().robots().length;
  const Eigen::VectorXd unit = model.scales().joints();
  for (int round = 0; round < kRounds && !work.stop(); ++round) {
    // δ = argmin ‖δ‖², in joint units, with every short gap brought to 1.5 × clearance: δ = Gᵀ(GGᵀ + ρI)⁻¹r
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    query_pairs(model, work.kinematics, work.pairs, clearance, work.contact_work, work.contacts);
    std::erase_if(work.contacts, [&](const auto& c) { return c.phi >= clearance_of(c); });
    const auto m = static_cast<Eigen::Index>(work.contacts.size());
    if (m == 0) return true;
    Eigen::MatrixXd G(n_a, m);
    Eigen::VectorXd r(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Contact& contact = work.contacts[static_cast<std::size_t>(i)];
      calc_gap_gradient(model, contact, joints, work.kinematics, G.col(i));
      r[i] = 1.5 * clearance_of(contact) - contact.phi;
    }
    G = unit.asDiagonal() * G;
    Eigen::MatrixXd S = G.transpose() * G;
    S.diagonal().array() += kDamping * length * length;
    Eigen::VectorXd delta = G * S.ldlt().solve(r);
    const double largest = delta.cwiseAbs().maxCoeff();
    if (!(largest > 1e-9)) return false;
    delta *= std::min(1.0, kStep / largest);
    q.tail(n_a) = (q.tail(n_a) + delta.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
    path.push_back(q.tail(n_a));
  }
  return false;
}

}  // namespace stiction::contact
