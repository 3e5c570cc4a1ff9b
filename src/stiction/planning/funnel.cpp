#include "stiction/planning/funnel.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "stiction/core/random.hpp"
#include "stiction/planning/bounded_least_squares.hpp"
#include "stiction/planning/contact_sampler.hpp"
#include "stiction/planning/force_gap.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/planning/regrasp.hpp"
#include "stiction/planning/robot_chains.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;
using Posture = Eigen::VectorXd;  // of the robot, or a command (n_a)
using Place = Eigen::VectorXd;    // a configuration (n_q)

constexpr int kMostPushes = 16, kMostRounds = 60;
/// Pushes drawn in a round, and those of them that a way of the robot is looked for to.
constexpr int kDrawn = 24, kTried = 3;
/// A push leaves this share of (E.11) or less; more and more of it as rounds come to nothing.
constexpr double kGain = 0.75, kLeastGain = 0.92, kLessGain = 0.05;
/// An extension of a push leaves this share or less, by its local models and then by the dynamics; so many in a row.
constexpr double kProgress = 0.97;
constexpr int kLongestChain = 6;
/// A funnel leaves the farthest place at this share of the distance or less: a poor one does more harm to plans that hold than good to others.
constexpr double kBrought = 0.5;
/// Places nearer than this to each other, as a share of how far off they were put, are one.
constexpr double kApart = 0.3;
/// A posture that is deeper than this in the object at any of its places does not touch it from outside of all [m] …
constexpr double kDeep = 0.02;
/// … and gets out of it in so many steps of a retreat.
constexpr int kRetreat = 8;
/// A branch farther than this from everything goes as far in a step as in the plan [m].
constexpr double kClear = 0.01;
/// That a branch goes for another place than those before it.
constexpr double kOwnPlace = 0.5;
/// What touches and is tried to push [m].
constexpr double kTouch = 1e-3;
/// Of steps of the search [J·s]: an iteration or two less.
constexpr double kSearchComplementarity = 1e-7;
/// Keeps draws apart from those of other searches.
constexpr std::uint64_t kFunnelSeed = 0xf0ee1;

/// The robot goes to a posture that is clear of the object wherever that is, and on from there.
struct DrawnPush {
  ChainMask moving = 0;  ///< branches that go elsewhere
  Posture start;
  std::vector<Posture> way;                               ///< commands to `start`, steps of the search apart …
  std::size_t leaving = 0;                                ///< … of which so many let go of what was touched before
  std::vector<Posture> commands;                          ///< from `start`; none: it only goes there
  double left = std::numeric_limits<double>::infinity();  ///< (E.11) after it
};

/// The plan in its own steps, or in half of them, and the push that is tried.
struct Run {
  Place q;
  Posture u;
  bool half;
  Segment way{SegmentKind::Regrasp, {}}, push{SegmentKind::Contact, {}};
};

struct Worker {
  explicit Worker(const std::shared_ptr<const Model>& model) : steps(model), geometry(*model) {}
  dynamics::StepWorkspace steps;
  GeometryWorkspace geometry;
  dynamics::StepResult result;
  long done = 0, failed = 0;
};

class FunnelSearch {
 public:
  FunnelSearch(const std::shared_ptr<const Model>& model, const Eigen::VectorXd& q_fine, const PlannerOptions& options,
               const RefineOptions& refine_options, const core::RunControl& control, core::ThreadPool& pool, const Plan& plan)
      : model_(*model),
        options_(options),
        refine_(refine_options),
        control_(control),
        pool_(pool),
        goal_(plan.goal),
        space_(model_),
        chains_(model_),
        exact_(plan.step),
        rough_(options.step_options()),
        cuts_(std::max(1, static_cast<int>(std::lround(options.h / plan.step.h)))),
        weights_(inverse_tolerances(model_, goal_)) {
    for (int i = 0; i < pool.size(); ++i) workers_.emplace_back(model);
    exact_.smoothing = dynamics::Exact{};
    exact_.with_A = exact_.with_B = exact_.warm_start = false;
    rough_.friction_law = dynamics::FrictionLaw::Anitescu;  // half the time; what becomes of the plan is simulated by its own law
    rough_.warm_start = false;
    rough_.tol_complementarity = std::max(rough_.tol_complementarity, kSearchComplementarity);
    const dynamics::Knot& end = plan.segments.back().knots.back();
    runs_.push_back({.q = end.q, .u = end.u, .half = false});
    runs_.push_back({.q = q_fine, .u = end.u, .half = true});
    q_goal_ = at_goal(model_, end.q, goal_);
  }

  Funnel run(const Posture& home, Plan& plan) {
    Funnel out;
    if (scatter(home) && go_home()) {
      out.before = nearest_ = farthest();
      double gain = kGain;
      for (int round = 0; round < kMostRounds && count_pushes(segments_.size()) < kMostPushes &&
                          farthest() > options_.share_when_refined() && !control_.stop();
           ++round) {
        gain = push(round, gain) ? kGain : std::min(gain + kLessGain, kLeastGain);
      }
      out.after = nearest_;
      out.pushes = count_pushes(kept_);
    }
    for (const Worker& worker : workers_) {
      out.steps += worker.done;
      out.failed_steps += worker.failed;
    }
    if (out.pushes == 0 || out.after > kBrought * out.before) {
      out.pushes = 0;
      return out;
    }
    segments_.resize(kept_);
    std::move(segments_.begin(), segments_.end(), std::back_inserter(plan.segments));
    plan.error = goal_error(model_, plan.segments.back().knots.back().q, goal_);
    return out;
  }

 private:
  // ---- places -------------------------------------------------------------------------------------------------------------------

  static int count_pushes(std::size_t segments) { return static_cast<int>(segments / 2); }

  /// Distance of the object from the goal, in tolerances.
  double share(const Place& q) const { return goal_error(model_, q, goal_).share(goal_); }

  /// (E.11)
  double sum_of_squares(const std::vector<Place>& places) const {
    double sum = 0;
    for (const Place& q : places) sum += share(q) * share(q);
    return sum;
  }

  double farthest() const {
    double out = share(runs_.back().q);
    for (const Place& q : places_) out = std::max(out, share(q));
    return out;
  }

  /// Where the object may be: off by options.funnel tolerances along each of its coordinates, either way, and left to rest while the robot is clear of all that;
  /// first where the plan has it. @returns false: there is no other place, or it does not stay at the goal by itself
  bool scatter(const Posture& home) {
    const auto& object = model_.objects()[static_cast<std::size_t>(goal_.object)];
    const Place& q_end = runs_.front().q;
    std::vector<Place> scattered{q_end};
    for (int i = object.v_begin; i < object.v_begin + object.n_v; ++i) {
      for (const double sign : {1.0, -1.0}) {
        Eigen::VectorXd error = Eigen::VectorXd::Zero(model_.n_v());
        error[i] = sign * options_.funnel / weights_[i];
        world::retract(model_, q_end, error, scattered.emplace_back(q_end.size()));
      }
    }
    Worker& worker = workers_.front();
    const bool clear = std::any_of(refine_.clearances.begin(), refine_.clearances.end(), [&](double clearance) {
      std::vector<Posture> path;
      u_ = home;
      return retreat(model_, chains_, chains_.all(), clearance, scattered, u_, worker.geometry, path);
    });
    if (!clear) return false;
    Eigen::VectorXd e(model_.n_vu());
    const auto is_apart = [&](const Place& q, const Place& other) {
      space_.error(other.data(), q.data(), e.data());
      return largest_share(model_, e, goal_.tol_position, goal_.tol_angle) >= kApart * options_.funnel;
    };
    for (Place& q : scattered) {
      q.tail(model_.n_a()) = u_;
      const bool rests = settle(u_, worker, q) && share(q) <= (places_.empty() ? 1 : 2 * options_.funnel);
      if (places_.empty() && !rests) return false;
      if (rests && std::all_of(places_.begin(), places_.end(), [&](const Place& other) { return is_apart(q, other); }))
        places_.push_back(std::move(q));
    }
    return places_.size() > 1;
  }

  std::size_t draw_place(core::Random& random) const {
    double rest = random.uniform() * left_;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      rest -= share(places_[i]) * share(places_[i]);
      if (rest <= 0) return i;
    }
    return 0;
  }

  void set_posture(ChainMask moving, const Posture& q_a, Place& q) const {
    for (const int j : chains_.joints_of(moving)) q[model_.n_qu() + j] = q_a[j];
  }

  // ---- the dynamics of the search ---------------------------------------------------------------------------------------------------
  bool step(const Place& q, const Posture& u, const dynamics::StepOptions& options, Worker& worker) {
    ++worker.done;
    if (dynamics::step(model_, {q, u}, options, worker.steps, worker.result) == Status::Solved) return true;
    ++worker.failed;
    return false;
  }

  bool follow(std::span<const Posture> commands, Worker& worker, Place& q) {
    for (const Posture& u : commands) {
      if (!step(q, u, rough_, worker)) return false;
      q = worker.result.q_next;
    }
    return true;
  }

  /// Until the object rests, or for a while.
  bool settle(const Posture& u, Worker& worker, Place& q) {
    for (int k = 0; k < kMostHeld; ++k) {
      const Place before = q;
      if (!follow({&u, 1}, worker, q)) return false;
      if (objects_agree(model_, space_, before, q, kResting, kResting)) break;
    }
    return true;
  }

  /// The command goes to `to` in steps that keep the limits of the plan.
  void append(const Posture& to, Posture& u, std::vector<Posture>& commands) const {
    const int n = dynamics::count_substeps(model_, u, to, *options_.substep);
    const Posture from = u;
    for (int k = 1; k <= n; ++k) commands.push_back(from + static_cast<double>(k) / n * (to - from));
    u = to;
  }

  // ---- pushes ---------------------------------------------------------------------------------------------------------------------
  /// One more push, the best of some that were drawn for which there is a way.
  bool push(int round, double gain) {
    std::vector<DrawnPush> drawn(static_cast<std::size_t>(kDrawn));
    pool_.run(kDrawn, [&](int i, int worker) {
      core::Random random(refine_.seed ^ kFunnelSeed, static_cast<std::uint64_t>(1 + round * kDrawn + i));
      draw(random, workers_[static_cast<std::size_t>(worker)], drawn[static_cast<std::size_t>(i)]);
    });
    std::erase_if(drawn, [&](const DrawnPush& d) { return !(d.left <= gain * left_); });
    std::stable_sort(drawn.begin(), drawn.end(), [](const DrawnPush& a, const DrawnPush& b) { return a.left < b.left; });
    if (std::ssize(drawn) > kTried) drawn.resize(static_cast<std::size_t>(kTried));
    core::Random random(refine_.seed ^ ~kFunnelSeed, static_cast<std::uint64_t>(round));
    return std::any_of(drawn.begin(), drawn.end(), [&](DrawnPush& d) { return go(d, gain, random); });
  }

  /// Branches touch the object at one or more of its places, come there from where they are clear of it at all, and go on as (E.12) has it.
  void draw(core::Random& random, Worker& worker, DrawnPush& out) {
    const ChainMask branches = draw_grasp(chains_, options_.sampler, random).moved;
    std::optional<std::size_t> first;
    Posture contact = u_;
    for (int c = 0; c < chains_.size(); ++c) {
      const ChainMask branch = branches & ChainMask{1} << c;
      if (branch == 0) continue;
      const std::size_t place = !first || random.chance(kOwnPlace) ? draw_place(random) : *first;
      Place q = places_[place];
      set_posture(out.moving, contact, q);
      const auto sample = sample_contact(model_, chains_, options_.sampler, {branch, false}, q, random, worker.geometry);
      if (!sample || is_deep(sample->q_a, c, worker)) continue;
      set_posture(branch, sample->q_a, q);
      if (!pushes_home(q, c, worker)) continue;
      for (const int j : chains_.joints(c)) contact[j] = sample->q_a[j];
      out.moving |= branch;
      if (!first) first = place;
    }
    if (out.moving == 0) return;
    out.start = contact;
    std::vector<Posture> back;
    if (!retreat(model_, chains_, out.moving, refine_.clearances.back(), places_, out.start, worker.geometry, back, kRetreat)) return;
    Posture u = out.start;
    for (auto posture = back.rbegin(); posture != back.rend(); ++posture) append(*posture, u, out.commands);
    append(contact, u, out.commands);
    std::vector<Place> places = places_;
    for (Place& q : places) {
      set_posture(out.moving, out.start, q);
      if (!follow(out.commands, worker, q)) return;
    }
    double left = sum_of_squares(places);
    for (int k = 0; k < kLongestChain; ++k) {
      Posture delta, u_next = u;
      if (!extension(places, u, out.moving, worker, delta)) break;
      std::vector<Posture> more;
      append(u + delta, u_next, more);
      std::vector<Place> moved = places;
      if (!std::all_of(moved.begin(), moved.end(), [&](Place& q) { return follow(more, worker, q); })) break;
      const double now = sum_of_squares(moved);
      if (now > kProgress * left) break;
      left = now;
      places = std::move(moved);
      u = u_next;
      std::move(more.begin(), more.end(), std::back_inserter(out.commands));
    }
    out.left = left;
  }

  /// At some place a branch is too deep in the object.
  bool is_deep(const Posture& q_a, int branch, Worker& worker) {
    GeometryWorkspace& work = worker.geometry;
    return std::any_of(places_.begin(), places_.end(), [&](Place q) {
      set_posture(ChainMask{1} << branch, q_a, q);
      world::calc_kinematics(model_, q, work.kinematics_work, work.kinematics);
      return contact::any_nearer(model_, work.kinematics, chains_.object_pairs(branch), -kDeep, work.contact_work);
    });
  }

  /// A branch touches the object where that has to give way on its way to the goal.
  bool pushes_home(const Place& q, int branch, Worker& worker) {
    GeometryWorkspace& work = worker.geometry;
    const world::Pose X_GB = world::object_pose(model_, q_goal_, goal_.object) * world::object_pose(model_, q, goal_.object).inverse();
    world::calc_kinematics(model_, q, work.kinematics_work, work.kinematics);
    contact::query_pairs(model_, work.kinematics, chains_.object_pairs(branch), kTouch, work.contact_work, work.contacts);
    return std::any_of(work.contacts.begin(), work.contacts.end(), [&](const contact::Contact& c) {
      const auto& pair = model_.pairs()[static_cast<std::size_t>(c.pair)];
      const auto& a = model_.geometries()[static_cast<std::size_t>(pair.geometry_a)];
      const bool object_is_a = model_.bodies()[static_cast<std::size_t>(a.body)].kind == world::BodyKind::Object;
      const Eigen::Vector3d& p = object_is_a ? c.p_WA : c.p_WB;
      return c.phi <= kTouch && (object_is_a ? 1 : -1) * c.nhat_BA_W.dot(X_GB * p - p) > 0;
    });
  }

  /// (E.12): δu = argmin Σ ‖W (B δu − e)‖² + γ ‖δu‖² over the places, with the smoothed step at each, in the joints of some branches and no longer than an
  /// extension of the planner.
  bool extension(const std::vector<Place>& places, const Posture& u, ChainMask branches, Worker& worker, Posture& delta) {
    dynamics::StepOptions smoothed = rough_;
    dynamics::Analytic analytic = options_.smoothing;
    const double mean = std::sqrt(sum_of_squares(places) / static_cast<double>(places.size()));
    analytic.kappa *= std::clamp(options_.goal_sharpening / mean, 1.0, options_.goal_sharpening);
    smoothed.smoothing = analytic;
    smoothed.with_B = true;
    const Eigen::Index n = model_.n_vu();
    const Eigen::VectorXd w = goal_.tol_angle * weights_;  // as (P.2) of the planner, so that γ means the same
    Eigen::MatrixXd WB(n * std::ssize(places), model_.n_a());
    Eigen::VectorXd We(WB.rows()), e(n);
    for (Eigen::Index i = 0; const Place& q : places) {
      if (!step(q, u, smoothed, worker)) return false;
      space_.error(worker.result.q_next.data(), q_goal_.data(), e.data());
      WB.middleRows(i, n) = w.asDiagonal() * worker.result.B.topRows(n);
      We.segment(i, n) = w.cwiseProduct(e);
      i += n;
    }
    Posture lower = Posture::Zero(model_.n_a()), upper = lower;
    for (const int j : chains_.joints_of(branches)) {
      lower[j] = std::min(0.0, model_.lower()[j] - u[j]);
      upper[j] = std::max(0.0, model_.upper()[j] - u[j]);
    }
    solve_bounded_least_squares(WB, We, options_.gamma, lower, upper, delta);
    const double length = delta.norm();
    if (length < 1e-9 || (We - WB * delta).squaredNorm() > kProgress * We.squaredNorm()) return false;
    delta *= std::min(1.0, std::visit([](const auto& rule) { return rule.length; }, options_.length) / length);
    return true;
  }

  // ---- the robot on its way -----------------------------------------------------------------------------------------------------------
  /// From the end of the plan.
  bool go_home() {
    core::Random random(refine_.seed ^ ~kFunnelSeed, ~std::uint64_t{0});
    const Place& q_end = runs_.front().q;
    DrawnPush home;
    home.moving = chains_.all();
    home.start = u_;
    if (!find_way({&q_end, 1}, q_end.tail(model_.n_a()), runs_.front().u, random, home)) return false;
    if (!simulate(home)) return false;
    segments_.push_back(std::move(runs_.front().way));
    places_.front() = runs_.front().q;
    left_ = sum_of_squares(places_);
    return true;
  }

  /// @param places    where the object may be
  /// @param released  the command with the springs of branches that go elsewhere unloaded
  bool find_way(std::span<const Place> places, const Posture& released, const Posture& u, core::Random& random, DrawnPush& push) {
    std::vector<Posture> path;
    PathOptions path_options = refine_.path;
    const bool found = std::any_of(refine_.clearances.begin(), refine_.clearances.end(), [&](double clearance) {
      path_options.clearance = clearance;
      return find_path(model_, chains_, push.moving, places, released, push.start, path_options, random, workers_.front().geometry, path) ==
             PathOutcome::Found;
    });
    if (!found) return false;
    push.way.clear();
    Posture from = u;
    append(released, from, push.way);
    for (std::size_t k = 0; k < path.size(); ++k) {
      append(path[k], from, push.way);
      if (k <= 1) push.leaving = push.way.size();
    }
    return true;
  }

  /// The way of the robot to where a push starts, and the push, with the object at all of its places. Nothing changes where it does not hold.
  bool go(DrawnPush& drawn, double gain, core::Random& random) {
    Posture released = u_;
    for (const int j : chains_.joints_of(drawn.moving)) released[j] = runs_.front().q[model_.n_qu() + j];
    std::vector<Place> places = places_;
    for (Place& q : places) {
      if (!settle(released, workers_.front(), q)) return false;
    }
    places.push_back(runs_.back().q);
    const bool found = find_way(places, released, u_, random, drawn);
    places.pop_back();
    if (!found) return false;
    if (!follow_all(drawn, places) || sum_of_squares(places) > gain * left_) return false;
    const std::vector<Run> before = runs_;
    const bool held = simulate(drawn);
    places.front() = runs_.front().q;
    const double left = sum_of_squares(places);
    if (!held || left > gain * left_) {
      runs_ = before;
      return false;
    }
    places_ = std::move(places);
    left_ = left;
    u_ = drawn.commands.back();
    segments_.push_back(std::move(runs_.front().way));
    segments_.push_back(std::move(runs_.front().push));
    if (farthest() < nearest_) {
      nearest_ = farthest();
      kept_ = segments_.size();
    }
    return true;
  }

  /// The object at all places, from where the push starts.
  bool follow_all(const DrawnPush& push, std::vector<Place>& places) {
    std::vector<char> held(places.size(), 0);
    pool_.run(static_cast<int>(held.size()), [&](int item, int number) {
      const auto i = static_cast<std::size_t>(item);
      Worker& worker = workers_[static_cast<std::size_t>(number)];
      set_posture(push.moving, push.start, places[i]);
      held[i] = follow(push.commands, worker, places[i]) && settle(push.commands.back(), worker, places[i]);
    });
    return std::find(held.begin(), held.end(), 0) == held.end();
  }

  /// The plan in both of its steps, with the way of the robot. @returns false: it does not hold
  bool simulate(const DrawnPush& push) {
    std::vector<char> held(runs_.size(), 0);
    pool_.run(static_cast<int>(held.size()), [&](int item, int number) {
      const auto i = static_cast<std::size_t>(item);
      held[i] = simulate(push, workers_[static_cast<std::size_t>(number)], runs_[i]);
    });
    return std::find(held.begin(), held.end(), 0) == held.end();
  }

  bool simulate(const DrawnPush& push, Worker& worker, Run& run) {
    run.way.knots.clear();
    run.push.knots.clear();
    for (std::size_t k = 0; k < push.way.size(); ++k) {
      if (!advance(push.way[k], k < push.leaving ? cuts_ : 1, worker, run, run.way)) return false;
    }
    if (!run.half && !is_free_on_its_way(model_, chains_, run.way.knots, worker.geometry)) return false;
    bool was_clear = true;
    for (const Posture& u : push.commands) {
      const bool clear = is_clear(u, push.moving, run.q, worker.geometry);
      if (!advance(u, was_clear && clear ? 1 : cuts_, worker, run, run.push)) return false;
      was_clear = clear;
    }
    for (int k = 0; !push.commands.empty() && k < kMostHeld * cuts_; ++k) {
      const Place before = run.q;
      if (!advance(Posture(run.u), 1, worker, run, run.push)) return false;
      if (objects_agree(model_, space_, before, run.q, kResting, kResting)) break;
    }
    return true;
  }

  /// The branches in `moving` are away from everything.
  bool is_clear(const Posture& q_a, ChainMask moving, Place q, GeometryWorkspace& work) const {
    set_posture(moving, q_a, q);
    chains_.pairs_of(moving, work.pairs);
    world::calc_kinematics(model_, q, work.kinematics_work, work.kinematics);
    return !contact::any_nearer(model_, work.kinematics, work.pairs, kClear, work.contact_work);
  }

  /// A step of the search in so many of the plan.
  bool advance(const Posture& to, int parts, Worker& worker, Run& run, Segment& segment) {
    const Posture from = run.u;
    if (run.half) parts *= 2;
    for (int k = 1; k <= parts; ++k) {
      const Posture u = from + static_cast<double>(k) / parts * (to - from);
      if (!step(run.q, u, exact_, worker) || calc_penetration(worker.result) > kMostPenetration ||
          calc_force_gap(model_, worker.result, worker.geometry) > kMostForceGap)
        return false;
      run.q = worker.result.q_next;
      if (run.half) continue;
      dynamics::Knot& knot = segment.knots.emplace_back();
      knot.u = u;
      knot.q = run.q;
      std::copy_if(worker.result.contacts.begin(), worker.result.contacts.end(), std::back_inserter(knot.contacts),
                   [](const auto& c) { return c.active; });
    }
    run.u = to;
    return true;
  }

  const Model& model_;
  const PlannerOptions& options_;
  const RefineOptions& refine_;
  const core::RunControl& control_;
  core::ThreadPool& pool_;
  const Goal& goal_;
  ObjectSpace space_;
  RobotChains chains_;
  std::vector<Worker> workers_;
  dynamics::StepOptions exact_, rough_;  ///< of the plan, of the search
  int cuts_;                             ///< steps of the plan for each of the search
  Eigen::VectorXd weights_;              ///< 1/tolerance (n_vu)
  Place q_goal_;
  std::vector<Place> places_;      ///< where the object may be, with the robot as it then is; the first one is where the plan has it
  double left_ = 0;                ///< (E.11) of them
  Posture u_;                      ///< where the robot is
  std::vector<Run> runs_;          ///< the plan in its own steps, and in half of them
  std::vector<Segment> segments_;  ///< the way home, then the way to each push and the push
  std::size_t kept_ = 0;           ///< of them
  double nearest_ = 0;             ///< farthest place after those
};

}  // namespace

Funnel append_funnel(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q_fine, const PlannerOptions& options,
                     const RefineOptions& refine_options, const core::RunControl& control, core::ThreadPool& pool, Plan& plan) {
  if (plan.segments.empty()) return {};
  FunnelSearch search(model, q_fine, options, refine_options, control, pool, plan);
  return search.run(plan.u_start, plan);
}

}  // namespace stiction::planning
