#include "stiction/planning/refine.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/bounded_least_squares.hpp"
#include "stiction/planning/drag.hpp"
#include "stiction/planning/force_gap.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/planning/pushes.hpp"
#include "stiction/trajopt/optimize.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// A push that ends farther than this from where it did in the plan, in tolerances of the goal, is not made good by those after it.
constexpr double kLost = 2;
/// On its way it is given up farther away than this.
constexpr double kStrayed = 4;
/// Weights γ of (E.6) that a push is tried with until it ends near enough, from none to firm feedback.
constexpr double kNoFeedback = std::numeric_limits<double>::infinity();
constexpr std::initializer_list<double> kFeedback = {kNoFeedback, 1e-1, 3e-2, 1e-2, 3e-3};
/// What feedback may add to a command at a knot of the plan, as a share of what a sub-step may.
constexpr double kMostFeedback = 0.3;
/// Knots of the plan's length after a push in which feedback may still take the objects to their target.
constexpr int kMostLeading = 10;
/// What takes more work than this, in the unit of RefineOptions::mpc_work, is not tried where there is little hope: some tenths of a second.
constexpr double kLittleHope = 5e8;
/// Rows of a matrix whose products take as long as what else is done for it.
constexpr double kOverhead = 20;
/// Places of the objects that differ by less than this, in tolerances of the goal, are one: of a regrasp, or of ways through a push that miss.
constexpr double kSamePlace = 0.05;
/// A branch whose posture differs by more than this between two pushes has moved [rad or m].
constexpr double kMoved = 5e-3;

/// One way to refine a plan.
struct Trial {
  const char* name;
  const std::vector<Push>* pushes;
  bool rest;  ///< pushes end at rest; those in small steps where that does
  int cuts;   ///< sub-steps for each of the plan's
  bool after_break =
      false;  ///< only where the one before ended with a push that does not hold, and took little: one that is lost is lost again
};

struct Work {
  long steps = 0, failed_steps = 0;
  Work& operator+=(const Work& more) {
    steps += more.steps;
    failed_steps += more.failed_steps;
    return *this;
  }
};

/// Where the commands lead at half the sub-step, and the worst that was met on the way.
struct Halves {
  Eigen::VectorXd q, u;
  double penetration = 0, force_gap = 0;  ///< in contact tolerances of their pairs
  bool started = false;                   ///< what is given may penetrate
};

class Refiner;

/// Trials and, within them, ways through a push or a regrasp are tried side by side.
struct Crew {
  explicit Crew(int threads) : pool(threads) {}
  core::ThreadPool pool;
  std::vector<std::unique_ptr<Refiner>> refiners;  ///< one per thread
};

class Refiner {
 public:
  Refiner(const std::shared_ptr<const Model>& model, const Plan& plan, const PlannerOptions& options, const RefineOptions& refine_options,
          const core::RunControl& control, Crew& crew)
      : model_(*model),
        plan_(plan),
        options_(options),
        refine_(refine_options),
        control_(control),
        space_(model_),
        motion_(model_, refine_options.motionless_position, refine_options.motionless_angle),
        chains_(model_),
        drag_(model_, plan.q_start, options.rest_time),
        steps_(model),
        geometry_(model_),
        half_steps_(model),
        smooth_steps_(model),
        shared_model_(model),
        crew_(crew) {
    exact_ = plan.step;
    exact_.smoothing = dynamics::Exact{};
    exact_.with_A = exact_.with_B = false;
    exact_.warm_start = false;  // every knot follows from the one before it alone
  }

  /// How the given plan does at half the sub-step. @returns false: it does not reach its goal
  bool look_at_plan(Work& done) {
    given_ = {plan_.q_start, plan_.u_start};
    if (!go_on(plan_.segments, exact_of_plan(), given_)) given_.q = plan_.q_start;
    done += std::exchange(work_, {});
    return reaches_goal(plan_, given_, 1.0);
  }

  /// A refined plan may be as bad as the given one.
  void take_look_of(const Refiner& other) { given_ = other.given_; }

  /// The given plan, with forces: one that was read from a file comes without.
  void keep_plan(RefineResult& out, Work& done) {
    out.plan = with_forces();
    out.variant = "unchanged";
    out.fine_error = goal_error(model_, given_.q, plan_.goal);
    out.q_fine = given_.q;
    done += std::exchange(work_, {});
  }

  /// After the look at the plan. @returns true: `out` is a refined plan
  bool attempt(const Trial& trial, const core::ThreadPool::Turn& turn, RefineResult& out, Work& done) {
    out_ = {};
    out_.rests = trial.rest;
    turn_ = &turn;
    set_up(trial);
    broke_soon_ = false;
    least_clearance_ = std::numeric_limits<double>::infinity();
    Plan built;
    came_through_ = build(*trial.pushes, built);
    const bool good = came_through_ && reaches_goal(built, halves_, options_.share_when_refined());
    turn_ = nullptr;
    broke_soon_ = broke_soon_ && cost(work_.steps) <= kLittleHope;
    done += std::exchange(work_, {});
    if (!good) return false;
    built.error = goal_error(model_, end_of(built), plan_.goal);
    out_.plan = std::move(built);
    out_.fine_error = goal_error(model_, halves_.q, plan_.goal);
    out_.q_fine = halves_.q;
    out_.variant = trial.name;
    out_.least_clearance = out_.reconnected > 0 ? least_clearance_ : 0.0;
    out = std::move(out_);
    return true;
  }

  /// The last trial soon ended with a push that comes to nothing, penetrates or pulls across a gap whatever the feedback.
  bool broke_soon() const { return broke_soon_; }

  /// The last trial came to the end of the plan, at its goal or elsewhere.
  bool came_through() const { return came_through_; }

  /// Of so many steps.
  double cost(long steps) const { return static_cast<double>(steps) * std::pow(model_.n_v() + model_.n_a() + kOverhead, 3); }

 private:
  // ---- at half the sub-step ------------------------------------------------------------------------------------------------------
  bool holds(const Halves& at) const {
    return at.penetration <= std::max(kMostPenetration, given_.penetration) && at.force_gap <= std::max(kMostForceGap, given_.force_gap);
  }

  /// @returns false: a step was not solved, or it does not hold (the given plan always does)
  bool go_on(std::span<const Segment> segments, const dynamics::StepOptions& options, Halves& at) {
    half_steps_.forget();
    for (const Segment& segment : segments) {
      for (const auto& knot : segment.knots) {
        for (const Eigen::VectorXd& u : {Eigen::VectorXd(0.5 * (at.u + knot.u)), knot.u}) {
          ++work_.steps;
          if (dynamics::step(model_, {at.q, u}, options, half_steps_, half_result_) != Status::Solved) {
            ++work_.failed_steps;
            return false;
          }
          if (at.started) at.penetration = std::max(at.penetration, calc_penetration(model_, half_result_));
          at.force_gap = std::max(at.force_gap, calc_force_gap(model_, half_result_, geometry_));
          at.started = true;
          at.q = half_result_.q_next;
          if (!holds(at)) return false;
        }
        at.u = knot.u;
      }
    }
    return true;
  }

  /// The commands of a push with feedback, up to where it rests or not.
  struct Way {
    std::vector<Segment> segments;
    Eigen::VectorXd q, u;
    bool known = false, good = false;  ///< simulated; it came to something
    bool counted = false;              ///< its work is in that of the trial
    Work work;
  };

  /// A push or a regrasp as it was simulated, and where that left everything.
  struct Run {
    std::vector<Segment> segments;
    Eigen::VectorXd q, u;
    Halves halves;
    bool done = false;     ///< it came to something
    bool holds = false;    ///< at half sub-steps as well
    double whole = 0;      ///< missed at its end, in tolerances of the goal, at whole sub-steps
    double missed = 0;     ///< the worse of whole and half sub-steps, once finished
    double gamma = 0;      ///< of the feedback on a push
    Way* way = nullptr;    ///< of a push: shared by the runs that end at rest and those that do not
    bool rests = false;    ///< a push ends at rest
    double clearance = 0;  ///< of a regrasp that was planned anew [m]
    Work work;
  };

  /// Where runs start.
  struct Place {
    const Trial* trial;
    Eigen::VectorXd q, u;
    Halves halves;
  };

  /// From where the simulation is: the first run in a list that ends near enough to q_target, else the one that ends nearest. Half sub-steps are looked at
  /// only of what may be it. Threads that are free try the next ones; what comes out, and the work that counts, are those of one thread.
  /// @param enough    what is near enough, in tolerances of the goal
  /// @param simulate  (Refiner&, Run&) → bool: from its q_, u_ to q_, u_; false where it comes to nothing
  template <class Simulate>
  std::optional<Run> best_of(std::vector<Run> runs, const Eigen::VectorXd& q_target, double enough, Simulate&& simulate) {
    const auto near_enough = [enough](const Run& run) { return run.holds && run.missed <= enough; };
    std::optional<Run> best;
    std::vector<Run*> later;
    const int tried = side_by_side(static_cast<int>(runs.size()), [&](Refiner& refiner, int k) {
      Run& run = runs[static_cast<std::size_t>(k)];
      refiner.try_run(q_target, enough, simulate, run);
      return near_enough(run) ? k + 1 : static_cast<int>(runs.size());
    });
    if (stop()) return best;
    const auto look_at = [&](Run& run) {
      count(run);
      if (run.holds && (!best || run.missed < best->missed)) best = std::move(run);
    };
    for (Run& run : std::span(runs).first(static_cast<std::size_t>(tried))) {
      if (run.done && run.whole > enough) later.push_back(&run);
      look_at(run);
    }
    if (best && best->missed <= enough) return best;
    std::stable_sort(later.begin(), later.end(), [](const Run* a, const Run* b) { return a->whole < b->whole; });
    // At half sub-steps a run ends no nearer than at whole ones.
    const auto needed = [&later](double missed) {
      const auto farther = std::find_if(later.begin(), later.end(), [&](const Run* run) { return missed <= run->whole + kSamePlace; });
      return static_cast<int>(farther - later.begin());
    };
    const int finished = side_by_side(best ? needed(best->missed) : static_cast<int>(later.size()), [&](Refiner& refiner, int k) {
      Run& run = *later[static_cast<std::size_t>(k)];
      refiner.finish(q_target, run);
      return run.holds ? std::max(k + 1, needed(run.missed)) : static_cast<int>(later.size());
    });
    if (stop()) return best;
    for (Run* run : std::span(later).first(static_cast<std::size_t>(finished))) look_at(*run);
    return best;
  }

  /// @param body  (Refiner&, int item) → int, as ThreadPool::run_until asks for
  template <class Body>
  int side_by_side(int n, const Body& body) {
    const Place here{trial_, q_, u_, halves_};
    return crew_.pool.run_until(
        n,
        [&](int item, int worker, const core::ThreadPool::Turn& turn) {
          Refiner& refiner = *crew_.refiners[static_cast<std::size_t>(worker)];
          if (&refiner != this) refiner.start_from(here);
          const auto* outer = std::exchange(refiner.turn_, &turn);
          const int needed = body(refiner, item);
          refiner.turn_ = outer;
          return needed;
        },
        turn_);
  }

  void start_from(const Place& place) {
    set_up(*place.trial);
    q_ = place.q;
    u_ = place.u;
    halves_ = place.halves;
  }

  void count(const Run& run) {
    work_ += run.work;
    if (run.way != nullptr && !std::exchange(run.way->counted, true)) work_ += run.way->work;
  }

  /// A run from where the simulation is, which stays there. Finished at once where it ends near enough.
  template <class Simulate>
  void try_run(const Eigen::VectorXd& q_target, double enough, const Simulate& simulate, Run& run) {
    if (stop()) return;
    const Eigen::VectorXd q_before = q_, u_before = u_;
    const Work before = std::exchange(work_, {});
    run.done = simulate(*this, run);
    run.q = std::exchange(q_, q_before);
    run.u = std::exchange(u_, u_before);
    run.work = std::exchange(work_, before);
    run.whole = miss(q_target, run.q);
    if (run.done && run.whole <= enough) finish(q_target, run);
  }

  /// Half sub-steps: `holds` is false where it penetrates there, pulls across a gap, or is a push that needs all of its friction. The work counts as the run's.
  void finish(const Eigen::VectorXd& q_target, Run& run) {
    const Work before = std::exchange(work_, {});
    run.halves = halves_;
    run.holds = go_on(run.segments, exact_, run.halves) && (run.gamma == 0 || has_margin(run));
    run.missed = std::max(run.whole, miss(q_target, run.halves.q));
    run.work += std::exchange(work_, before);
  }

  /// Of a plan with a margin of friction: a push does the same with every μ at regrasp_friction of it, against what objects on joints rest on.
  bool has_margin(const Run& run) {
    if (options_.edge_friction == 1) return true;
    Eigen::Index n = 0;
    for (const Segment& segment : run.segments) n += static_cast<Eigen::Index>(segment.knots.size());
    Eigen::MatrixXd commands(model_.n_a(), n);
    for (Eigen::Index k = 0; const Segment& segment : run.segments) {
      for (const auto& knot : segment.knots) commands.col(k++) = knot.u;
    }
    dynamics::StepOptions slippery = exact_;
    slippery.friction_scale = exact_.friction_scale * options_.regrasp_friction;
    Eigen::VectorXd q = q_, u = u_;
    if (drag_.push(commands, slippery, steps_, result_, q, u, work_.steps) != Status::Solved) {
      ++work_.failed_steps;
      return false;
    }
    return miss(run.q, q) <= refine_.mpc_miss;
  }

  void take(Run& run, Plan& built) {
    q_ = run.q;
    u_ = run.u;
    halves_ = std::move(run.halves);
    std::move(run.segments.begin(), run.segments.end(), std::back_inserter(built.segments));
  }

  // ---- simulated anew ------------------------------------------------------------------------------------------------------------

  /// Asked to, or nothing depends on what is tried any more.
  bool stop() const { return control_.stop() || (turn_ != nullptr && turn_->over()); }

  bool build(const std::vector<Push>& pushes, Plan& built) {
    built = plan_;
    built.step.h = exact_.h;
    built.substep = free_substep_;
    built.segments.clear();
    q_ = plan_.q_start;
    u_ = plan_.u_start;
    steps_.forget();
    mpc_work_ = 0;
    halves_ = {plan_.q_start, plan_.u_start};
    for (const Segment& segment : plan_.segments) {
      if (segment.kind == SegmentKind::Settle && !replay(segment, built.segments.emplace_back(Segment{segment.kind, {}}))) return false;
    }
    if (!go_on(built.segments, exact_, halves_)) return false;
    for (std::size_t i = 0; i < pushes.size(); ++i) {
      if (stop()) return false;
      if (!reach_and_push(pushes[i], i, i + 1 == pushes.size(), built)) return false;
    }
    return true;
  }

  /// The regrasp before a push, where there is one, and the push. At the steps of the plan another clearance is tried where it comes to nothing.
  bool reach_and_push(const Push& push, std::size_t number, bool last, Plan& built) {
    if (!push.regrasp && !push.merged) return coarse() ? replay(push, built) : follow(push, last, built);
    const Eigen::VectorXd q_before = q_, u_before = u_;
    const Halves halves_before = halves_;
    const std::size_t segments = built.segments.size();
    const int reconnected = out_.reconnected;
    const double least_clearance = least_clearance_;
    std::vector<double> clearances;
    if (refine_.reconnect) clearances = refine_.clearances;
    if (!push.merged && push.regrasp) clearances.push_back(0);
    while (!clearances.empty()) {
      const std::optional<double> clearance = regrasp(push, number, clearances, built);
      if (!clearance) return false;
      if (coarse() ? replay(push, built) : follow(push, last, built)) return true;
      if (!coarse()) return false;
      std::erase(clearances, *clearance);
      q_ = q_before;
      u_ = u_before;
      halves_ = halves_before;
      built.segments.resize(segments);
      out_.reconnected = reconnected;
      least_clearance_ = least_clearance;
    }
    return false;
  }

  /// Every sub-step of the plan in so many of the same length.
  void set_up(const Trial& trial) {
    trial_ = &trial;
    const int cuts = trial.cuts;
    cuts_ = cuts;
    exact_.h = plan_.step.h / cuts;
    substep_ = plan_.substep;
    substep_.joint_angle /= cuts;
    substep_.joint_travel /= cuts;
    substep_.slide /= cuts;
    substep_.max_substeps *= cuts;
    free_substep_ = substep_;
    free_substep_.joint_angle = plan_.substep.joint_angle;
    free_substep_.joint_travel = plan_.substep.joint_travel;
    prepare_mpc();
  }

  /// At steps of the plan that are longer than asked for: the last resort, where pushes end as planned and iMPC only makes things worse.
  bool coarse() const { return exact_.h > refine_.h * (1 + 1e-9); }

  bool step(const Eigen::VectorXd& u, const dynamics::StepOptions& options) {
    ++work_.steps;
    if (dynamics::step(model_, {q_, u}, options, steps_, result_) == Status::Solved) return true;
    ++work_.failed_steps;
    return false;
  }

  bool step_within_efforts(Eigen::VectorXd& u) {
    int steps = 0;
    const Status status = dynamics::step_within_efforts(model_, q_, u, exact_, steps_, result_, steps);
    work_.steps += steps;
    if (status == Status::Solved) return true;
    ++work_.failed_steps;
    return false;
  }

  dynamics::StepOptions exact_of_plan() const {
    dynamics::StepOptions options = exact_;
    options.h = plan_.step.h;
    return options;
  }

  /// One sub-step of the exact dynamics, stored. False where it is not solved or starts deeper inside something than is allowed at half sub-steps.
  bool advance(const Eigen::VectorXd& command, Segment& segment) {
    const Eigen::VectorXd wanted = within_limits(command);  // rounding
    Eigen::VectorXd u = wanted;
    if (stop() || !step_within_efforts(u)) return false;
    const bool recoils = u != wanted && dynamics::count_substeps(model_, u_, u, substep_) > 1;
    if (recoils) return false;
    const bool own = q_ != plan_.q_start;  // what penetrates at the start is not its doing
    if (own && calc_penetration(model_, result_) > std::max(kMostPenetration, given_.penetration)) return false;
    q_ = result_.q_next;
    u_ = u;
    dynamics::Knot& knot = segment.knots.emplace_back();
    knot.u = u;
    knot.q = q_;
    keep_forces(knot);
    return true;
  }

  void keep_forces(dynamics::Knot& knot) const {
    std::copy_if(result_.contacts.begin(), result_.contacts.end(), std::back_inserter(knot.contacts),
                 [](const auto& c) { return c.active; });
  }

  /// The given plan; a plan that was read from a file comes without forces.
  Plan with_forces() {
    Plan out = plan_;
    q_ = plan_.q_start;
    const dynamics::StepOptions options = exact_of_plan();
    for (Segment& segment : out.segments) {
      for (dynamics::Knot& knot : segment.knots) {
        knot.contacts.clear();
        if (step(knot.u, options)) keep_forces(knot);
        q_ = knot.q;
      }
    }
    return out;
  }

  Eigen::VectorXd within_limits(const Eigen::VectorXd& u) const { return u.cwiseMax(model_.lower()).cwiseMin(model_.upper()); }

  /// In so many sub-steps or more, which keep the limits of the plan.
  bool advance_in_parts(const Eigen::VectorXd& u, Segment& segment, int least = 1) {
    return ramp(u, std::max(least, dynamics::count_substeps(model_, u_, u, substep_)), segment);
  }

  /// Moves the command in equal parts.
  bool ramp(const Eigen::VectorXd& u, int parts, Segment& segment) {
    const Eigen::VectorXd u_before = u_;
    for (int k = 1; k <= parts; ++k) {
      const double s = static_cast<double>(k) / parts;
      if (!advance(k == parts ? u : Eigen::VectorXd((1 - s) * u_before + s * u), segment)) return false;
    }
    return true;
  }

  /// The commands of a segment, in steps that are cuts_ times as short.
  bool replay(const Segment& from, Segment& segment) {
    return std::all_of(from.knots.begin(), from.knots.end(), [&](const auto& knot) { return ramp(knot.u, cuts_, segment); });
  }

  bool replay(const Push& push, Plan& built) {
    steps_.forget();
    const std::size_t first = built.segments.size();
    for (const Segment& edge : push.edges) {
      if (!replay(edge, built.segments.emplace_back(Segment{edge.kind, {}}))) return false;
    }
    if (trial_->rest && !come_to_rest(built.segments.back())) return false;
    return go_on(std::span(built.segments).subspan(first), exact_, halves_);
  }

  // ---- feedback -------------------------------------------------------------------------------------------------------------------
  /// A push in small steps ends elsewhere than it did in the plan: feedback on the objects, as little as brings it near enough, then iMPC. It ends at rest
  /// where that does not take it too far away.
  bool follow(const Push& push, bool last, Plan& built) {
    const Eigen::VectorXd q_before = q_, u_before = u_;
    const Eigen::VectorXd& q_planned = push.edges.back().knots.back().q;
    const Eigen::VectorXd& q_target = last ? q_goal_ : q_planned;
    const auto will_do = [&](const Run& run) {
      return last ? reaches_goal(run.q, run.halves, options_.share_when_refined()) : run.missed <= kLost;
    };
    std::vector<Way> ways(kFeedback.size());
    for (const bool rests : {true, false}) {
      if (rests && !trial_->rest) continue;
      std::vector<Run> runs(kFeedback.size());
      for (std::size_t k = 0; k < runs.size(); ++k) {
        runs[k].gamma = kFeedback.begin()[k];
        runs[k].way = &ways[k];
        runs[k].rests = rests;
      }
      std::optional<Run> best =
          best_of(std::move(runs), q_target, refine_.miss, [&](Refiner& refiner, Run& run) { return refiner.follow(push, q_target, run); });
      if (best && best->missed > refine_.mpc_miss) correct(q_before, u_before, q_target, *best);
      if (best && will_do(*best)) {
        out_.led += best->gamma != kNoFeedback;
        out_.rests = out_.rests && best->rests;
        take(*best, built);
        return true;
      }
      broke_soon_ = !best;
      q_ = q_before;
      u_ = u_before;
    }
    return false;
  }

  /// A push with feedback, its end at rest or not, and what feedback does after it.
  bool follow(const Push& push, const Eigen::VectorXd& q_target, Run& run) {
    Way& way = *run.way;
    if (!way.known) {
      const Work before = std::exchange(work_, {});
      way.segments.clear();
      way.good = go_along(push, q_target, run.gamma, way);
      way.known = !stop();
      way.q = q_;
      way.u = u_;
      way.work = std::exchange(work_, before);
    }
    if (!way.good) return false;
    run.segments = way.segments;
    q_ = way.q;
    u_ = way.u;
    steps_.forget();
    if (run.rests && !come_to_rest(run.segments.back())) return false;
    return run.gamma == kNoFeedback || lead(q_target, run, run.segments.back());
  }

  /// The commands of a push, moved along with feedback on where its objects are against where the plan has them on the way to q_target.
  bool go_along(const Push& push, const Eigen::VectorXd& q_target, double gamma, Way& way) {
    steps_.forget();
    const Eigen::VectorXd& q_planned = push.edges.back().knots.back().q;
    Eigen::VectorXd shift(model_.n_vu()), e(model_.n_vu()), added = Eigen::VectorXd::Zero(model_.n_a()), delta;
    space_.error(q_planned.data(), q_target.data(), shift.data());
    std::size_t n = 0, k = 0;
    for (const Segment& edge : push.edges) n += edge.knots.size();
    for (const Segment& edge : push.edges) {
      Segment& segment = way.segments.emplace_back(Segment{edge.kind, {}});
      for (const auto& knot : edge.knots) {
        if (!advance_in_parts(within_limits(knot.u + added), segment, cuts_)) return false;
        space_.error(q_.data(), knot.q.data(), e.data());
        if (miss(knot.q, q_) > kStrayed) return false;
        e += static_cast<double>(++k) / static_cast<double>(n) * shift;
        if (gamma != kNoFeedback && calc_feedback(e, gamma, delta)) added += delta;
      }
    }
    return true;
  }

  /// On from the end of a push, for as long as that brings the objects nearer.
  bool lead(const Eigen::VectorXd& q_target, const Run& run, Segment& segment) {
    Eigen::VectorXd e(model_.n_vu()), delta;
    double missed = miss(q_target, q_);
    for (int k = 0; k < kMostLeading && missed > refine_.miss; ++k) {
      space_.error(q_.data(), q_target.data(), e.data());
      if (!calc_feedback(e, run.gamma, delta)) return true;
      const Eigen::VectorXd q = q_, u = u_;
      const std::size_t size = segment.knots.size();
      if (!advance_in_parts(within_limits(u_ + delta), segment, cuts_)) return false;
      if (run.rests && !come_to_rest(segment)) return false;
      const double now = miss(q_target, q_);
      if (now < missed) {
        missed = now;
      } else {
        segment.knots.resize(size);
        q_ = q;
        u_ = u;
        steps_.forget();
        return true;
      }
    }
    return true;
  }

  /// The change of the command that moves the objects by e in the smoothed local model where they are, (E.6).
  bool calc_feedback(const Eigen::VectorXd& e, double gamma, Eigen::VectorXd& delta) {
    dynamics::StepOptions smooth = exact_;
    smooth.smoothing = options_.smoothing;
    smooth.with_B = true;
    smooth_steps_.forget();
    ++work_.steps;
    if (dynamics::step(model_, {q_, u_}, smooth, smooth_steps_, smooth_result_) != Status::Solved) return false;
    const Eigen::MatrixXd WB = weights_.asDiagonal() * smooth_result_.B.topRows(model_.n_vu()) * limits_.asDiagonal();
    const Eigen::VectorXd lower = (model_.lower() - u_).cwiseMin(0.0).cwiseQuotient(limits_).cwiseMax(-kMostFeedback);
    const Eigen::VectorXd upper = (model_.upper() - u_).cwiseMax(0.0).cwiseQuotient(limits_).cwiseMin(kMostFeedback);
    solve_bounded_least_squares(WB, weights_.cwiseProduct(e), gamma, lower, upper, delta);
    delta = delta.cwiseProduct(limits_).eval();
    return true;
  }

  // ---- iMPC -----------------------------------------------------------------------------------------------------------------------
  /// Distance of the object of the goal from where it should be, in tolerances of the goal.
  double miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const {
    Eigen::VectorXd e(model_.n_vu());
    space_.error(q_target.data(), q.data(), e.data());
    return largest_share(model_, e, plan_.goal.tol_position, plan_.goal.tol_angle);
  }

  /// iMPC (Alg. 1) starts from the commands of a push that ends away from its target. What comes out replaces them if it ends nearer.
  void correct(const Eigen::VectorXd& q_before, const Eigen::VectorXd& u_before, const Eigen::VectorXd& q_target, Run& run) {
    if (refine_.mpc_iterations == 0) return;
    std::vector<Eigen::VectorXd> u, reference{q_before};
    for (const Segment& segment : run.segments) {
      for (const auto& knot : segment.knots) {
        u.push_back(knot.u);
        reference.push_back(knot.q);
      }
    }
    reference.back().head(model_.n_qu()) = q_target.head(model_.n_qu());
    const double more = cost(static_cast<long>(u.size()));
    if (mpc_work_ + more > refine_.mpc_work) return;
    mpc_work_ += more;
    mpc_.iterations = refine_.mpc_iterations;
    if (!optimizer_) optimizer_.emplace(shared_model_, crew_.pool.size());
    if (trajopt::optimize(model_, {q_before, u, reference, &u_before}, mpc_, control_, *optimizer_, optimized_) != Status::Solved) return;
    work_.steps += optimized_.steps;
    Run corrected;
    corrected.gamma = run.gamma;
    corrected.rests = run.rests;
    q_ = q_before;
    u_ = u_before;
    std::size_t t = 0;
    for (const Segment& from : run.segments) {
      Segment& segment = corrected.segments.emplace_back(Segment{SegmentKind::Contact, {}});
      for (std::size_t k = 0; k < from.knots.size(); ++k) {
        if (!advance_in_parts(optimized_.u[t++], segment)) return;
      }
    }
    corrected.q = q_;
    corrected.u = u_;
    corrected.whole = miss(q_target, q_);
    if (corrected.whole >= run.missed) return;
    q_ = q_before;
    u_ = u_before;
    finish(q_target, corrected);
    count(corrected);
    if (!corrected.holds || corrected.missed >= run.missed) return;
    run = std::move(corrected);
    ++out_.corrected;
  }

  bool revolute(int dof) const { return model_.dofs()[static_cast<std::size_t>(dof)].kind == world::DofKind::Revolute; }

  /// The object in tolerances of the goal, at the end fully and on its way a little; changes of the command in limits of a sub-step.
  void prepare_mpc() {
    constexpr double kWay = 1e-2, kChange = 1e-2;
    mpc_.step = exact_;
    mpc_.scheme = options_.smoothing;
    mpc_.threads = crew_.pool.size();
    mpc_.qp_tolerance = 1e-3;  // the step is judged by the dynamics
    mpc_.weights.Qd = Eigen::VectorXd::Zero(model_.n_v());
    weights_ = inverse_tolerances(model_, plan_.goal);
    mpc_.weights.Qd.head(model_.n_vu()) = weights_.cwiseAbs2();
    mpc_.weights.Q = kWay * mpc_.weights.Qd;
    limits_.resize(model_.n_a());
    for (int j = 0; j < model_.n_a(); ++j) limits_[j] = revolute(model_.n_vu() + j) ? substep_.joint_angle : substep_.joint_travel;
    mpc_.weights.R = kChange * limits_.cwiseAbs2().cwiseInverse();
    q_goal_ = at_goal(model_, end_of(plan_), plan_.goal);
  }

  /// The regularisation holds objects back in every sub-step (S.3); in the world nothing does for long.
  bool come_to_rest(Segment& push) {
    constexpr int kMostKnots = 10;
    for (int k = 0; k < kMostKnots * cuts_; ++k) {
      const Eigen::VectorXd before = q_;
      if (!advance(u_, push)) return false;
      if (motion_.share(before, q_) <= 0.01 / cuts_) {
        push.knots.pop_back();
        q_ = before;
        break;
      }
    }
    return true;
  }

  /// The commands of the plan's own regrasp, after a way back to where they start: a tail may have been cut.
  bool regrasp_as_planned(const Push& push, Run& run) {
    Segment back{SegmentKind::Regrasp, {}};
    q_rest_ = q_;
    steps_.forget();
    if (!roll_to(push.u_regrasp, substep_, options_.release_tol_position, options_.release_tol_angle, push.q_entry, back)) return false;
    if (!is_free_on_its_way(back)) return false;
    if (!back.knots.empty()) run.segments.push_back(std::move(back));
    Segment& segment = run.segments.emplace_back(Segment{SegmentKind::Regrasp, {}});
    return replay(*push.regrasp, segment) && is_free_on_its_way(segment);
  }

  // ---- regrasps -------------------------------------------------------------------------------------------------------------------
  struct Moves {
    ChainMask moving = 0;   ///< branches that go to another posture
    ChainMask relaxed = 0;  ///< branches that stay and only change how they push
  };
  Moves moves_to(const Push& push) const {
    Moves out;
    for (int c = 0; c < chains_.size(); ++c) {
      double posture = 0, command = 0;
      for (const int j : chains_.joints(c)) {
        posture = std::max(posture, std::abs(push.q_entry[model_.n_qu() + j] - q_[model_.n_qu() + j]));
        command = std::max(command, std::abs(push.u_entry[j] - u_[j]));
      }
      if (posture > kMoved) {
        out.moving |= ChainMask{1} << c;
      } else if (command > 0) {
        out.relaxed |= ChainMask{1} << c;
      }
    }
    return out;
  }

  /// From where the robot is to where the push starts: with the largest clearance that leaves the objects where the push wants them, or where they are; else
  /// with what leaves them nearest to it, the commands of the plan among it.
  /// @param clearances  that may count, 0: the commands of the plan   @returns that which was taken
  std::optional<double> regrasp(const Push& push, std::size_t number, const std::vector<double>& clearances, Plan& built) {
    const Moves moves = moves_to(push);
    std::vector<Run> runs(clearances.size());
    for (std::size_t k = 0; k < runs.size(); ++k) runs[k].clearance = clearances[k];
    const double missed = std::max(miss(push.q_entry, q_), miss(push.q_entry, halves_.q));
    std::optional<Run> best =
        best_of(std::move(runs), push.q_entry, std::max(refine_.miss, missed + kSamePlace), [&](Refiner& refiner, Run& run) {
          return run.clearance > 0 ? refiner.connect(push, number, moves, run) : refiner.regrasp_as_planned(push, run);
        });
    if (!best) return {};
    const double clearance = best->clearance;
    if (clearance > 0) {
      least_clearance_ = std::min(least_clearance_, clearance);
      ++out_.reconnected;
    }
    take(*best, built);
    return clearance;
  }

  bool connect(const Push& push, std::size_t number, const Moves& moves, Run& run) {
    const Eigen::VectorXd q_before = q_;
    Segment segment{SegmentKind::Regrasp, {}};
    core::Random random(refine_.seed, number);
    if (!go(push, moves, run.clearance, random, segment) || !is_free_on_its_way(segment) || !holds_slippery(q_before, segment))
      return false;
    if (!segment.knots.empty()) run.segments.push_back(std::move(segment));
    return true;
  }

  bool go(const Push& push, const Moves& moves, double clearance, core::Random& random, Segment& segment) {
    q_rest_ = q_;
    steps_.forget();
    Eigen::VectorXd u = u_;  // springs of moving branches are unloaded where they are
    for (const int j : chains_.joints_of(moves.moving)) u[j] = q_[model_.n_qu() + j];
    for (const int j : chains_.joints_of(moves.relaxed)) u[j] = push.u_entry[j];
    if (!roll_to(u, substep_, options_.release_tol_position, options_.release_tol_angle, push.q_entry, segment)) return false;
    q_rest_ = q_;
    if (moves.moving == 0) return hold(push.q_entry, segment);

    Eigen::VectorXd goal = q_.tail(model_.n_a());
    const auto joints = chains_.joints_of(moves.moving);
    for (const int j : joints) goal[j] = push.q_entry[model_.n_qu() + j];
    PathOptions path_options = refine_.path;
    path_options.clearance = clearance;
    std::vector<Eigen::VectorXd> path;
    if (find_path(model_, chains_, moves.moving, q_, goal, path_options, random, geometry_, path) != PathOutcome::Found) return false;
    bool was_clear = false;
    for (std::size_t k = 0; k < path.size(); ++k) {
      u = u_;
      for (const int j : joints) u[j] = k + 1 == path.size() ? push.u_entry[j] : path[k][j];
      const bool clear = is_clear(moves.moving, path[k], 0.5 * clearance);
      const dynamics::SubstepLimits& limits = was_clear && clear ? free_substep_ : substep_;
      if (!roll_to(u, limits, options_.regrasp_tol_position, options_.regrasp_tol_angle, push.q_entry, segment)) return false;
      was_clear = clear;
    }
    return hold(push.q_entry, segment);
  }

  /// Holds the command until the objects rest in the new grip. @returns false where they slide out of it
  bool hold(const Eigen::VectorXd& q_wanted, Segment& segment) {
    for (int k = 0; k < kMostHeld * cuts_; ++k) {
      const Eigen::VectorXd before = q_;
      if (!advance(u_, segment) || !stays(q_, options_.regrasp_tol_position, options_.regrasp_tol_angle, q_wanted)) return false;
      if (objects_agree(model_, space_, before, q_, kRestingMove * model_.scales().robots().length / cuts_, kRestingTurn / cuts_))
        return true;
    }
    return false;
  }

  /// The objects are where they rested before, or where they are wanted.
  bool stays(const Eigen::VectorXd& q, double position, double angle, const Eigen::VectorXd& q_wanted) const {
    return objects_agree(model_, space_, q_rest_, q, position, angle) || miss(q_wanted, q) <= refine_.mpc_miss;
  }

  /// Nothing is nearer than so much to the branches in `moving` at a posture.
  bool is_clear(ChainMask moving, const Eigen::VectorXd& q_a, double clearance) {
    Eigen::VectorXd q = q_;
    q.tail(model_.n_a()) = q_a;
    chains_.pairs_of(moving, geometry_.pairs);
    world::calc_kinematics(model_, q, geometry_.kinematics_work, geometry_.kinematics);
    return !contact::any_nearer(model_, geometry_.kinematics, geometry_.pairs, clearance, geometry_.contact_work);
  }

  /// @returns false where the objects neither stay nor are where they are wanted
  bool roll_to(const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, double position, double angle,
               const Eigen::VectorXd& q_wanted, Segment& segment) {
    if ((u - u_).cwiseAbs().maxCoeff() == 0) return true;
    const Status status = dynamics::rollout(model_, q_, u_, u, exact_, limits, steps_, rollout_);
    work_.steps += rollout_.steps;
    if (status != Status::Solved) {
      ++work_.failed_steps;
      return false;
    }
    for (const auto& knot : rollout_.knots) {
      if (!stays(knot.q, position, angle, q_wanted)) return false;
    }
    q_ = rollout_.knots.back().q;
    u_ = rollout_.knots.back().u;
    segment.knots.insert(segment.knots.end(), std::make_move_iterator(rollout_.knots.begin()),
                         std::make_move_iterator(rollout_.knots.end()));
    return true;
  }

  bool is_free_on_its_way(const Segment& segment) { return planning::is_free_on_its_way(model_, chains_, segment.knots, geometry_); }

  /// The objects do the same with every μ at regrasp_friction of it. Steps whose forces lie in those cones are the same, so that the first ones that do are
  /// not simulated again.
  bool holds_slippery(const Eigen::VectorXd& q_before, const Segment& segment) {
    dynamics::StepOptions slippery = exact_;
    slippery.friction_scale = exact_.friction_scale * options_.regrasp_friction;
    const auto& knots = segment.knots;
    std::size_t k = 0;
    while (k < knots.size() && fits_cones(knots[k], slippery.friction_scale)) ++k;
    const Eigen::VectorXd q_end = q_;
    q_ = k == 0 ? q_before : knots[k - 1].q;
    steps_.forget();
    bool held = true;
    for (; held && k < knots.size(); ++k) {
      held = step(knots[k].u, slippery);
      if (held) q_ = result_.q_next;
      held = held && objects_agree(model_, space_, knots[k].q, q_, options_.regrasp_tol_position, options_.regrasp_tol_angle);
    }
    q_ = q_end;
    steps_.forget();
    return held;
  }

  // ---- verdict ------------------------------------------------------------------------------------------------------------------
  const Eigen::VectorXd& end_of(const Plan& plan) const {
    return plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q;
  }

  /// Within a fraction of the tolerances.
  bool within(const GoalError& error, double fraction) const {
    return error.position <= fraction * plan_.goal.tol_position && error.angle <= fraction * plan_.goal.tol_angle;
  }

  /// At the sub-step and at half of it.
  bool reaches_goal(const Plan& plan, const Halves& halves, double fraction) const {
    return !plan.segments.empty() && reaches_goal(end_of(plan), halves, fraction);
  }
  bool reaches_goal(const Eigen::VectorXd& q, const Halves& halves, double fraction) const {
    return within(goal_error(model_, q, plan_.goal), fraction) && within(goal_error(model_, halves.q, plan_.goal), fraction);
  }

  const Model& model_;
  const Plan& plan_;
  const PlannerOptions& options_;
  const RefineOptions& refine_;
  const core::RunControl& control_;
  RefineResult out_;  ///< of the trial under way
  Work work_;         ///< of it as well, of a run while that is tried
  ObjectSpace space_;
  Motion motion_;
  RobotChains chains_;
  Drag drag_;
  dynamics::StepWorkspace steps_;
  GeometryWorkspace geometry_;
  dynamics::StepOptions exact_;
  dynamics::StepResult result_;
  dynamics::RolloutResult rollout_;
  dynamics::StepWorkspace half_steps_, smooth_steps_;
  dynamics::StepResult half_result_, smooth_result_;
  Halves given_, halves_;             ///< of the plan, and where the simulation is
  Eigen::VectorXd weights_, limits_;  ///< 1/tolerance of the goal (n_vu); limits of a sub-step (n_a)
  const Trial* trial_ = nullptr;
  int cuts_ = 1;                                    ///< parts of a step of the plan
  double mpc_work_ = 0;                             ///< of the trial so far, as in RefineOptions
  dynamics::SubstepLimits substep_, free_substep_;  ///< … and where the branches that move touch nothing, in commands as far as in the plan
  trajopt::OptimizeOptions mpc_;
  std::optional<trajopt::OptimizeWorkspace> optimizer_;  ///< made when first needed
  trajopt::OptimizeResult optimized_;
  Eigen::VectorXd q_goal_;  ///< the objects at the goal, in a whole configuration
  Eigen::VectorXd q_, u_;   ///< where the simulation is
  Eigen::VectorXd q_rest_;
  double least_clearance_ = 0;
  bool broke_soon_ = false, came_through_ = false;
  std::shared_ptr<const Model> shared_model_;
  Crew& crew_;
  const core::ThreadPool::Turn* turn_ = nullptr;  ///< of the trial or run under way
};

std::size_t count_knots(const std::vector<Push>& pushes) {
  std::size_t n = 0;
  for (const Push& push : pushes) {
    for (const Segment& edge : push.edges) n += edge.knots.size();
  }
  return n;
}

/// Trials one after the other, up to the first that works.
struct Attempts {
  std::vector<Trial> trials;
  bool worked = false, came_through = false;
  RefineResult result = {};
  Work done = {};
};

/// In the order in which they are wanted. What waits for how another one ended is tried after that.
std::vector<Attempts> list_attempts(const std::vector<Trial>& trials, bool rest) {
  std::vector<Attempts> list;
  for (const Trial& trial : trials) {
    if (trial.rest && !rest) continue;
    if (!trial.after_break) list.emplace_back();
    list.back().trials.push_back(trial);
  }
  return list;
}

/// Small steps are wanted most, and take most of the time. What comes to nothing at the steps of the plan seldom works at small ones, so that those come last,
/// and only where the plan was followed to its end, from which feedback leads to the goal, or where they take little.
Status run(const std::shared_ptr<const Model>& model, const Plan& plan, const PlannerOptions& options, const RefineOptions& refine_options,
           const core::RunControl& control, RefineResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far a refinement has come
  quiet.on_progress = nullptr;
  Crew crew(options.threads > 0 ? options.threads : core::hardware_threads());
  for (int i = 0; i < crew.pool.size(); ++i)
    crew.refiners.push_back(std::make_unique<Refiner>(model, plan, options, refine_options, quiet, crew));
  Refiner& first = *crew.refiners.front();
  Work done;
  const auto finish = [&](Status status, const RefineResult* refined) {
    if (refined != nullptr) {
      out = *refined;
    } else {
      first.keep_plan(out, done);
    }
    out.steps = done.steps;
    out.failed_steps = done.failed_steps;
    return status;
  };
  if (!first.look_at_plan(done)) return finish(Status::NumericalFailure, nullptr);
  for (const auto& refiner : crew.refiners) refiner->take_look_of(first);

  const Motion motion(*model, refine_options.motionless_position, refine_options.motionless_angle);
  const std::vector<Push> pushes = split_at_regrasps(plan);
  std::vector<Push> shorter = pushes;
  if (refine_options.cut_tails) cut_tails(motion, shorter);
  if (refine_options.drop_pushes) drop_pushes(motion, shorter);

  bool came_through = false;  // a trial that counts
  const auto first_that_works = [&](std::vector<Attempts> list) -> std::optional<RefineResult> {
    const int n = static_cast<int>(list.size());
    const int tried = crew.pool.run_until(n, [&](int item, int worker, const core::ThreadPool::Turn& turn) {
      Refiner& refiner = *crew.refiners[static_cast<std::size_t>(worker)];
      Attempts& attempts = list[static_cast<std::size_t>(item)];
      for (const Trial& trial : attempts.trials) {
        if (trial.after_break && !refiner.broke_soon()) continue;
        attempts.worked = refiner.attempt(trial, turn, attempts.result, attempts.done);
        attempts.came_through = attempts.came_through || refiner.came_through();
        if (attempts.worked) return item + 1;
      }
      return n;
    });
    for (const Attempts& attempts : std::span(list).first(static_cast<std::size_t>(tried))) {
      done += attempts.done;
      came_through = came_through || attempts.came_through;
    }
    Attempts& last = list[static_cast<std::size_t>(tried) - 1];
    return last.worked ? std::optional(std::move(last.result)) : std::nullopt;
  };

  const int cuts = std::max(1, static_cast<int>(std::ceil(plan.step.h / refine_options.h * (1 - 1e-12))));
  const std::vector<Trial> small{{"shortened", &shorter, true, cuts}, {"shortened", &shorter, false, cuts, refine_options.rest}};
  std::vector<Trial> planned = small;
  if (cuts > 1) planned = {{"shortened", &shorter, true, 1}, {"shortened", &shorter, false, 1}};
  if (count_knots(shorter) != count_knots(pushes)) {  // else it is the same again
    for (const bool rest : {true, false}) planned.push_back({"reconnected", &pushes, rest, 1});
  }
  std::optional<RefineResult> refined = first_that_works(list_attempts(planned, refine_options.rest));
  bool as_wanted = refined.has_value();
  const long least = (1L + 2L) * cuts * static_cast<long>(count_knots(shorter));  // steps of a small trial, at whole and half sub-steps
  if (cuts > 1 && (came_through || first.cost(least) <= kLittleHope)) {
    std::optional<RefineResult> in_small_steps = first_that_works(list_attempts(small, refine_options.rest));
    as_wanted = in_small_steps.has_value();
    if (as_wanted) refined = std::move(in_small_steps);
  }
  const Status status = as_wanted || !control.stop() ? Status::Solved : control.cancelled() ? Status::Cancelled : Status::MaxIterations;
  return finish(status, refined ? &*refined : nullptr);
}

void count(const Plan& plan, int& pushes, int& regrasps, long& knots) {
  SegmentKind before = SegmentKind::Settle;
  for (const Segment& segment : plan.segments) {
    knots += static_cast<long>(segment.knots.size());
    regrasps += segment.kind == SegmentKind::Regrasp && before != SegmentKind::Regrasp;
    pushes += segment.kind == SegmentKind::Contact && before != SegmentKind::Contact;
    before = segment.kind;
  }
}

}  // namespace

void RefineOptions::validate() const {
  if (clearances.empty()) core::throw_invalid("refine.clearances", "none", "at least one");
  for (const double clearance : clearances) core::require_positive("refine.clearances", clearance);
  core::require_positive("refine.h", h);
  if (mpc_iterations < 0) core::throw_invalid("refine.mpc_iterations", std::to_string(mpc_iterations), "0 or more");
  core::require_positive("refine.miss", miss);
  core::require_positive("refine.mpc_miss", mpc_miss);
  core::require_nonnegative("refine.mpc_work", mpc_work);
  core::require_positive("refine.motionless_position", motionless_position);
  core::require_positive("refine.motionless_angle", motionless_angle);
}

Status refine(const std::shared_ptr<const Model>& model, const Plan& plan, const PlannerOptions& options,
              const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  const auto start = core::RunControl::Clock::now();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  refine_options.validate();
  if (!options.substep) core::throw_invalid("options.substep", "single steps", "a plan in sub-steps");
  if (!options.real_regrasps) core::throw_invalid("options.real_regrasps", "false", "true: jumps cannot be executed");
  world::require_configuration(*model, "plan.q_start", plan.q_start);
  core::require_size("plan.u_start", plan.u_start.size(), model->n_a());
  if (plan.goal.object < 0 || plan.goal.object >= static_cast<int>(model->objects().size()))
    core::throw_invalid("plan.goal.object", std::to_string(plan.goal.object), "the index of an object");
  out.status = run(model, plan, options, refine_options, control, out);
  count(plan, out.pushes_before, out.regrasps_before, out.knots_before);
  count(out.plan, out.pushes, out.regrasps, out.knots);
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::planning
