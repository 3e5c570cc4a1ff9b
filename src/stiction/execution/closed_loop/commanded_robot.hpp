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

/// A piece that ends within this distance of its plan is followed at once by the next one, and a plan can begin within this distance of its start
/// [tolerances of the goal].
constexpr double kThere = 0.3;

/// Commands that are chosen at intervals and interpolated in equal parts, one in each tick.
class ChosenCommands {
 public:
  explicit ChosenCommands(double tick);
  /// Makes the next choice at the time `now` [s].
  void begin(double now) { next_ = now; }
  /// @param u       commands in force (n_a)
  /// @param choose  choose(period [s], u) replaces u by the commands wanted after the period
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
  double next_ = 0;       ///< time of the next choice [s]
  Eigen::VectorXd step_;  ///< change of the commands in a tick (n_a)
};

/// Robot of a run: sends a command in every tick, looks at the objects at intervals, and records both. It detects the events that end a run under any plan: a
/// used-up budget, a falling object, a plant that does not answer. Functions that return a bool return false once the run is over, unless stated otherwise.
class CommandedRobot {
 public:
  /// @param goals  problems of one model, at least one
  CommandedRobot(Driver& plant, std::span<const planning::PlanningProblem> goals, const RunOptions& how, const core::RunControl& control,
                 RunResult& out);
  CommandedRobot(const CommandedRobot&) = delete;  // references to problem() and speed() must stay valid
  CommandedRobot& operator=(const CommandedRobot&) = delete;

  /// Takes the first measurement, at which the time of the run begins.
  bool begin();
  /// Records the current goal as reached and makes the next one current. After the last goal the run is over.
  bool next_goal();
  const planning::PlanningProblem& problem() const { return problem_; }  ///< problem with the current goal
  const RunSpeeds& speed() const { return speed_; }                      ///< speed limits for its object
  double follow_time() const { return follow_time_; }  ///< T_f, the time by which this object lags behind its plan (E.14) [s]
  /// Ends the run. @param what, message  why  @returns false
  bool end(RunEnd what, std::string message = {});
  bool is_over() const { return over_; }
  void finish();  ///< writes the record to the result

  double now() const { return measured_.time - start_; }    ///< time since the start of the run [s]
  const Eigen::VectorXd& q() const { return measured_.q; }  ///< measured configuration (n_q)
  const Eigen::VectorXd& u() const { return u_; }           ///< commands in force (n_a)
  /// Configuration with the mean object poses of the last looks (n_q).
  Eigen::VectorXd rest() const { return watch_.mean(); }
  /// The same after some time [s]: objects that the robot does not touch, and that do not rest, go on moving as they
  /// do, up to what is in their way.
  Eigen::VectorXd expected(double time) const;
  double goal_share(const Eigen::VectorXd& q) const;  ///< distance of the object from the goal [tolerances]
  /// The object is at the goal. If the goal need not be held, it suffices that the object was there.
  bool is_at_goal() const { return touch_ || goal_share(rest()) <= 1; }
  bool has_touched() const { return touch_.has_value(); }  ///< the object was seen at a goal that need not be held
  /// True if a plan from q can begin: the object is within `near` tolerances of q, and the joints are as near as a push moves them between two looks.
  bool is_at(const Eigen::VectorXd& q, double near) const;
  double thinking_time() const;
  double approach_time() const;
  bool looked() const { return looked_; }  ///< the last tick took a look at the objects
  bool caught() const { return caught_; }  ///< fingers moved to catch the object since the last command of a plan
  /// True if the objects are away, or were put elsewhere since the motion began.
  bool is_displaced() { return displaced_ = displaced_ || !link_.sees_objects(); }

  void enter(RunState state) { state_ = state; }
  /// Announces a new motion. @param planned  its planned configurations (n_q × any number), which bound how deep objects may be
  void begin_motion(const Eigen::MatrixXd& planned);
  /// Sends one command (n_a), and looks at the objects if a look is due.
  bool tick(const Eigen::VectorXd& wanted);
  /// The same for a command of a plan. @param q_plan  planned configuration (n_q)
  bool tick(const Eigen::VectorXd& wanted, const Eigen::VectorXd& q_plan);
  /// Sends a command while no plan is carried out: commands rest, or fingers catch an object that moves.
  bool hold_tick();
  /// Holds until the objects rest, or until `there`, asked at every look, returns true.
  bool settle(const std::function<bool()>& there);
  bool settle();
  bool hold_goal();  ///< holds for RunOptions::hold. False: the object left the goal, or the run is over
  /// Moves the commands straight to u (n_a) at the speed of pushes.
  bool move_to(const Eigen::VectorXd& u);
  /// Relaxes the springs of the robot and waits until the objects rest.
  bool let_go() { return move_to(q().tail(model_.n_a())) && settle(); }
  /// Moves the robot off objects that stand by themselves (find_step_back) and waits until the objects rest.
  bool step_back();
  /// From now on fingers, if there are any, catch an object that moves while no plan is carried out.
  void catch_what_moves();

  /// Announces a time without commands, until the next measurement.
  void pause() { link_.pause(); }
  bool read();

 private:
  Eigen::VectorXd within_motors(const Eigen::VectorXd& u) const;
  void look();
  void record();
  double depth(const Eigen::VectorXd& q, int object) const;
  void set_floor(const Eigen::MatrixXd& planned);
  void check_fall();
  bool is_last_goal() const { return goal_ + 1 == goals_.size(); }
  void leave_goal(bool reached);
  void look_back(double since);
  void aim();

  std::span<const planning::PlanningProblem> goals_;
  std::size_t goal_ = 0;               ///< index of the current goal
  planning::PlanningProblem problem_;  ///< problem with the current goal
  struct Touch {
    double time;
    Eigen::VectorXd q;
  };
  std::optional<Touch> touch_;  ///< first look at which a goal that need not be held was reached
  const world::Model& model_;
  const RunOptions& how_;
  const core::RunControl& control_;
  RunResult& out_;
  DriverLink link_;
  RunSpeeds speed_;
  double follow_time_ = 0, window_ = 0;  ///< window_: length of the window of looks in which nothing may move [s]
  ObjectWatch watch_;
  Eigen::VectorXd strain_;  ///< largest strain that each motor bears (n_a) [rad or m]

  Measurement measured_;
  double start_ = 0;  ///< start of the run, by the clock of the plant
  double next_look_ = 0;
  double seen_time_ = -std::numeric_limits<double>::infinity();  ///< time of the object poses at the last look, by the clock of the plant
  bool looked_ = false;
  bool over_ = false;
  bool displaced_ = false;  ///< objects were put elsewhere since the motion began
  RunState state_ = RunState::Hold;
  Eigen::VectorXd u_, q_plan_;
  std::vector<double> floor_;  ///< per object: depth at which it counts as fallen [m]

  std::optional<ActiveHold> hold_;
  ChosenCommands held_;
  bool holds_ = false;  ///< the object is held since the last command of a plan
  bool calm_ = true;    ///< the object has not moved since it is held
  bool caught_ = false;
  Eigen::VectorXd q_held_;

  std::vector<Eigen::VectorXd> q_, planned_, commands_;
};

}  // namespace stiction::execution
