#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/planning/object_space.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using Posture = Eigen::VectorXd;

/// Collision queries of the moving branches at a fixed object.
class FreeSpace {
 public:
  FreeSpace(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q, double clearance,
            GeometryWorkspace& work)
      : model_(model), work_(work), q_(q), clearance_(clearance), joints_(chains.joints_of(moving)) {
    chains.pairs_of(moving, pairs_);
  }

  const std::vector<int>& joints() const { return joints_; }

  /// Smallest gap minus the clearance.
  double room(const Posture& q_a) {
    q_.tail(model_.n_a()) = q_a;
    world::calc_kinematics(model_, q_, work_.kinematics_work, work_.kinematics);
    return contact::calc_min_distance(model_, work_.kinematics, pairs_, clearance_, work_.contact_work) - clearance_;
  }

  /// The straight line is free. Advances by what the room at each posture allows: no point of the moving branches travels farther
  /// than Σ reach_j |Δq_j|, and both sides of a pair may move.
  bool line(const Posture& from, const Posture& to) {
    double speed = 0;
    double joint_move = 0;
    for (const int j : joints_) {
      speed += model_.reach()[j] * std::abs(to[j] - from[j]);
      joint_move = std::max(joint_move, std::abs(to[j] - from[j]));
    }
    if (speed < 1e-12) return true;
    const double shortest = std::min(1.0, 0.02 / joint_move);  // below this resolution the clearance itself is the guard
    for (double t = 0; t < 1.0;) {
      const double r = room((1 - t) * from + t * to);
      if (r < 0) return false;
      t += std::max(shortest, r / (2 * speed));
    }
    return room(to) >= 0;
  }

 private:
  const world::Model& model_;
  GeometryWorkspace& work_;
  Eigen::VectorXd q_;
  double clearance_;
  std::vector<int> joints_;
  std::vector<int> pairs_;
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

/// One extension towards the target by at most `step`; the new node, or −1 when the line is blocked.
int extend(PathTree& tree, const Posture& target, double step, FreeSpace& space) {
  const int near = tree.nearest(target);
  const Posture& from = tree.postures[static_cast<std::size_t>(near)];
  const double length = (target - from).cwiseAbs().maxCoeff();
  if (length < 1e-12) return near;
  const Posture to = from + std::min(1.0, step / length) * (target - from);
  return space.line(from, to) ? tree.add(to, near) : -1;
}

std::pair<double, double> search_range(const world::Model& model, int joint, double a, double b) {
  // The surroundings of the two ends; the limits where those are nearer.
  const double pad = 0.8;
  return {std::max(model.lower()[joint], std::min(a, b) - pad), std::min(model.upper()[joint], std::max(a, b) + pad)};
}

bool connect(const world::Model& model, const Posture& start, const Posture& goal, const PathOptions& options, core::Random& random,
             FreeSpace& space, std::vector<Posture>& path) {
  if (space.line(start, goal)) {
    path = {start, goal};
    return true;
  }
  PathTree trees[2] = {PathTree(start), PathTree(goal)};
  for (int k = 0, side = 0; k < options.max_extensions; ++k, side = 1 - side) {
    Posture target = start;
    for (const int j : space.joints()) {
      const auto [low, high] = search_range(model, j, start[j], goal[j]);
      target[j] = random.uniform(low, high);
    }
    const int grown = extend(trees[side], target, options.step, space);
    if (grown < 0) continue;
    const Posture reached = trees[side].postures[static_cast<std::size_t>(grown)];
    for (;;) {  // the other tree goes for it greedily
      const int other = extend(trees[1 - side], reached, options.step, space);
      if (other < 0) break;
      if ((trees[1 - side].postures[static_cast<std::size_t>(other)] - reached).cwiseAbs().maxCoeff() > 1e-12) continue;
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
  Eigen::VectorXd q_start = q;
  if (!retreat(model, chains, moving, options.clearance, q_start, work, path)) return PathOutcome::StartBlocked;
  Eigen::VectorXd q_goal = q;
  q_goal.tail(model.n_a()) = q_a_goal;
  std::vector<Posture> approach;
  if (!retreat(model, chains, moving, options.clearance, q_goal, work, approach)) return PathOutcome::GoalBlocked;

  FreeSpace space(model, chains, moving, q, options.clearance * (1 - 1e-6), work);
  std::vector<Posture> middle;
  if (!connect(model, q_start.tail(model.n_a()), q_goal.tail(model.n_a()), options, random, space, middle)) return PathOutcome::NotFound;
  shortcut(options, random, space, middle);
  path.insert(path.end(), middle.begin() + 1, middle.end());
  for (auto it = approach.rbegin(); it != approach.rend(); ++it) {
    if (it != approach.rbegin()) path.push_back(*it);
  }
  path.push_back(q_a_goal);
  return PathOutcome::Found;
}

namespace {

enum class Outcome {
  Held,
  Moved,
  Failed
};

/// Simulates the commands of a regrasp and watches the object.
class RegraspRun {
 public:
  RegraspRun(const world::Model& model, const PlannerOptions& options, const Eigen::VectorXd& q0, dynamics::StepWorkspace& steps,
             Regrasp& out)
      : model_(model), options_(options), steps_(steps), space_(model), q0_(q0), out_(out) {
    step_.h = options.h;
    step_.regularisation = options.regularisation;
  }

  /// Moves the command from u to u_next at full friction and appends the knots.
  Outcome follow(Eigen::VectorXd& q, Eigen::VectorXd& u, const Eigen::VectorXd& u_next) {
    const Status status = dynamics::rollout(model_, q, u, u_next, step_, *options_.substep, steps_, result_);
    out_.steps += result_.steps;
    if (status != Status::Solved) {
      ++out_.failed_steps;
      return Outcome::Failed;
    }
    for (const auto& knot : result_.knots) {
      if (!at_rest(knot.q)) return Outcome::Moved;
    }
    if (result_.max_slide > options_.substep->slide) return Outcome::Moved;
    q = result_.knots.back().q;
    u = u_next;
    out_.knots.insert(out_.knots.end(), std::make_move_iterator(result_.knots.begin()), std::make_move_iterator(result_.knots.end()));
    return Outcome::Held;
  }

  /// The object rests with less friction as well. A step whose forces lie in the smaller cones already is the solution of the step
  /// with less friction (it stays feasible, since v_n ≥ μ‖v_t‖ only gets weaker, and complementary), so the simulation starts at the
  /// first knot whose forces do not.
  Outcome follow_slippery() {
    std::size_t k = 0;
    while (k < out_.knots.size() && fits_reduced_cones(out_.knots[k])) ++k;
    Eigen::VectorXd q = k == 0 ? q0_ : out_.knots[k - 1].q;
    dynamics::StepOptions slippery = step_;
    slippery.friction_scale = options_.regrasp_friction;
    steps_.forget();
    for (; k < out_.knots.size(); ++k) {
      ++out_.steps;
      if (dynamics::step(model_, {q, out_.knots[k].u}, slippery, steps_, step_result_) != Status::Solved) {
        ++out_.failed_steps;
        return Outcome::Failed;
      }
      q = step_result_.q_next;
      if (!at_rest(q)) return Outcome::Moved;
    }
    return Outcome::Held;
  }

 private:
  bool at_rest(const Eigen::VectorXd& q) const {
    return objects_agree(model_, space_, q0_, q, options_.regrasp_tol_position, options_.regrasp_tol_angle);
  }

  bool fits_reduced_cones(const dynamics::Knot& knot) const {
    return std::all_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
      return c.lambda.tail<2>().norm() <= options_.regrasp_friction * c.contact.friction * c.lambda[0];
    });
  }

  const world::Model& model_;
  const PlannerOptions& options_;
  dynamics::StepWorkspace& steps_;
  ObjectSpace space_;
  const Eigen::VectorXd& q0_;
  Regrasp& out_;
  dynamics::StepOptions step_;
  dynamics::RolloutResult result_;
  dynamics::StepResult step_result_;
};

/// Command with which the branches in `relaxed` stop pushing: their springs are unloaded, the others keep their squeeze.
Eigen::VectorXd relaxed_command(const world::Model& model, const RobotChains& chains, ChainMask relaxed, const Eigen::VectorXd& q,
                                Eigen::VectorXd u) {
  for (const int j : chains.joints_of(relaxed)) u[j] = q[model.n_qu() + j];
  return u;
}

}  // namespace

bool try_regrasp(const world::Model& model, const RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q,
                 const Eigen::VectorXd& u, core::Random& random, GeometryWorkspace& geometry, dynamics::StepWorkspace& steps, Regrasp& out,
                 RegraspCounts& counts) {
  out.knots.clear();
  out.steps = 0;
  out.failed_steps = 0;
  out.unsupported = false;
  ++counts.tried;
  const auto sample = sample_contact(model, chains, options.sampler, q, random, geometry);
  if (!sample) {
    ++counts.no_sample;
    return false;
  }

  // First with the squeeze of the branches that hold, then with everything let go.
  Outcome outcome = Outcome::Moved;
  for (const ChainMask relaxed : {sample->moved, chains.all()}) {
    steps.forget();
    out.knots.clear();
    RegraspRun run(model, options, q, steps, out);
    Eigen::VectorXd q_now = q;
    Eigen::VectorXd u_now = u;
    const Eigen::VectorXd u_relaxed = relaxed_command(model, chains, relaxed, q, u);
    outcome = run.follow(q_now, u_now, u_relaxed);
    if (outcome == Outcome::Held) {
      std::vector<Eigen::VectorXd> path;
      if (find_path(model, chains, sample->moved, q_now, sample->q_a, PathOptions{}, random, geometry, path) != PathOutcome::Found) {
        ++counts.no_path;
        return false;
      }
      const auto joints = chains.joints_of(sample->moved);
      for (const auto& posture : path) {  // commands: the moving joints follow the path, the others hold
        Eigen::VectorXd command = u_relaxed;
        for (const int j : joints) command[j] = posture[j];
        outcome = run.follow(q_now, u_now, command);
        if (outcome != Outcome::Held) break;
      }
      if (outcome == Outcome::Held) outcome = run.follow_slippery();
    } else if (relaxed == chains.all()) {
      out.unsupported = true;
    }
    if (outcome == Outcome::Held) {
      ++counts.accepted;
      return true;
    }
    if (relaxed == chains.all()) break;
  }
  ++(outcome == Outcome::Failed ? counts.failed_step : counts.object_moved);
  return false;
}

}  // namespace stiction::planning
