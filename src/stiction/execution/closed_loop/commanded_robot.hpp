#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/execution/closed_loop/active_hold.hpp"
#include "stiction/execution/closed_loop/driver_link.hpp"
#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/execution/closed_loop/run.hpp"

namespace stiction::execution {

/// A piece that ends this near to its plan goes on at once, and a plan begins this near to its start [tolerances of the goal].
constexpr double kThere = 0.3;

/// Commands that are chosen now and then, and gone to in equal parts, one in each tick.
class ChosenCommands {
 public:
  explicit ChosenCommands(double tick);
  /// The next choice is made at this time.
  void begin(double now) { next_ = now; }
  /// @param u       in force (n_a)
  /// @param choose  (period [s], u) replaces u by where it is to be after the period
  template <class Choose>
  Eigen::VectorXd next(double now, const Eigen::VectorXd& u, const Choose& choose) {
    if (now >= next_ - 0.5 * tick_) {
      next_ = now + period_;
      Eigen::VectorXd wanted = u;
      choose(period_, wanted);
      step_ = (wanted - u) * (tick_ / period_);
    }
    return u + step_;
  }

 private:
  double tick_, period_;
  double next_ = 0;       ///< choice [s]
  Eigen::VectorXd step_;  ///< of the commands in a tick (n_a)
};

/// The robot of a run: a command in every tick, a look at the objects now and then, and the record of both. It notices what ends a run whatever its plans are: a
/// budget that is used up, an object that falls, a plant that does not answer. What returns a bool is false once the run is over.
class CommandedRobot {
 public:
  /// @param goals  of one model, at least one
  CommandedRobot(Driver& plant, std::span<const planning::PlanningProblem> goals, const RunOptions& how, const core::RunControl& control,
                 RunResult& out);
  CommandedRobot(const CommandedRobot&) = delete;  // problem() and speed() stay where they are
  CommandedRobot& operator=(const CommandedRobot&) = delete;

  /// The first measurement, from which the time of the run counts.
  bool begin();
  /// The goal is reached: from now on the next one counts. After the last one the run is over.
  bool next_goal();
  const planning::PlanningProblem& problem() const { return problem_; }  ///< the goal that counts
  const RunSpeeds& speed() const { return speed_; }                      ///< for its object
  double follow_time() const { return follow_time_; }                    ///< … for which it lags behind its plan (E.14) [s]
  /// The run is over, and why. @returns false
  bool end(RunEnd what, std::string message = {});
  bool is_over() const { return over_; }
  void finish();  ///< the record goes to the result

  double now() const { return measured_.time - start_; }    ///< since the start of the run [s]
  const Eigen::VectorXd& q() const { return measured_.q; }  ///< measured (n_q)
  const Eigen::VectorXd& u() const { return u_; }           ///< in force (n_a)
  /// With the objects where they were in the last looks (n_q).
  Eigen::VectorXd rest() const { return watch_.mean(); }
  double goal_share(const Eigen::VectorXd& q) const;  ///< how far the object is from the goal, in its tolerances
  /// … or was, where it need not be held.
  bool is_at_goal() const { return touch_ || goal_share(rest()) <= 1; }
  bool has_touched() const { return touch_.has_value(); }  ///< the object was seen at the goal, which need not be held
  /// The object is within so many tolerances of q, the joints as near as a push moves in a look: a plan from q can begin.
  bool is_at(const Eigen::VectorXd& q, double near) const;
  bool looked() const { return looked_; }  ///< in the last tick
  bool caught() const { return caught_; }  ///< fingers moved to keep the object since the last command of a plan
  /// The objects are away, or were put elsewhere since the motion began.
  bool is_displaced() { return displaced_ = displaced_ || !link_.sees_objects(); }

  void enter(RunState state) { state_ = state; }
  /// Something new is carried out. @param planned  objects may be as deep as these configurations have them (n_q × any number)
  void begin_motion(const Eigen::MatrixXd& planned);
  /// One command, and a look at the objects where it is time for one.
  bool tick(const Eigen::VectorXd& wanted);
  /// The same of a command that is planned. @param q_plan  where it has everything (n_q)
  bool tick(const Eigen::VectorXd& wanted, const Eigen::VectorXd& q_plan);
  /// A command of a robot that has nothing to carry out: it rests as long as the object does.
  bool hold_tick();
  /// Commands rest until the objects do, or until `there` says at a look that it is near enough.
  bool settle(const std::function<bool()>& there);
  bool settle();
  bool hold_goal();  ///< for as long as it has to hold. False: the object left it, or the run is over
  /// Commands go straight to u at the speed of pushes.
  bool move_to(const Eigen::VectorXd& u);
  /// The springs of the robot are let go.
  bool let_go() { return move_to(q().tail(model_.n_a())) && settle(); }
  /// The robot leaves what stands by itself.
  bool step_back();
  /// From now on fingers catch what moves while nothing is carried out, where they can.
  void catch_what_moves();

  /// Time passes without commands, until the next measurement.
  void pause() { link_.pause(); }
  bool read();

 private:
  Eigen::VectorXd within_motors(const Eigen::VectorXd& u) const;
  void look();
  void record();
  double depth(const Eigen::VectorXd& q, int object) const;
  void set_floor(const Eigen::MatrixXd& planned);
  void check_fall();
  double thinking_time() const;
  bool is_last_goal() const { return goal_ + 1 == goals_.size(); }
  void leave_goal(bool reached);
  void look_back(double since);
  void aim();

  std::span<const planning::PlanningProblem> goals_;
  std::size_t goal_ = 0;               ///< of them, the one that counts …
  planning::PlanningProblem problem_;  ///< … which is this
  struct Touch {
    double time;
    Eigen::VectorXd q;
  };
  std::optional<Touch> touch_;  ///< when it was first seen to be reached, and where things were, if it need not be held
  const world::Model& model_;
  const RunOptions& how_;
  const core::RunControl& control_;
  RunResult& out_;
  DriverLink link_;
  RunSpeeds speed_;
  double follow_time_ = 0, window_ = 0;  ///< the latter of looks, that has to show no motion [s]
  ObjectWatch watch_;
  Eigen::VectorXd strain_;  ///< that a motor bears at most (n_a)

  Measurement measured_;
  double start_ = 0;  ///< of the run, by the clock of the plant
  double next_look_ = 0;
  double seen_time_ = -std::numeric_limits<double>::infinity();  ///< of the objects at the last look, by the clock of the plant
  bool looked_ = false;
  bool over_ = false;
  bool displaced_ = false;  ///< since a motion began
  RunState state_ = RunState::Hold;
  Eigen::VectorXd u_, q_plan_;
  std::vector<double> floor_;  ///< per object: how deep it may be

  std::optional<ActiveHold> hold_;
  ChosenCommands held_;
  bool holds_ = false;  ///< since the last command of a plan
  bool calm_ = true;    ///< the object did not move since
  bool caught_ = false;
  Eigen::VectorXd q_held_;

  std::vector<Eigen::VectorXd> q_, planned_, commands_;
};

}  // namespace stiction::execution
