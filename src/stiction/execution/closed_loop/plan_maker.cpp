#include "stiction/execution/closed_loop/plan_maker.hpp"

#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <thread>
#include <utility>

#include "stiction/execution/closed_loop/step_back.hpp"

namespace stiction::execution {
namespace {

/// A run waits so long for objects that creep from where no rest is possible [s], and twice as long each further time, because they may creep slowly.
constexpr double kFirstWait = 1;

}  // namespace

std::optional<Trajectory> PlanMaker::make(std::string& cause, bool counts) {
  if (counts && !count()) return std::nullopt;
  const auto can_step_back = [&] { return !find_step_back(model_, robot_.q()).empty(); };
  PlanRequest request = first_request(cause, source_.found() > 0 && can_step_back());
  double wait = kFirstWait;
  for (int refused = 0; refused < how_.refusals; ++refused) {
    Answer answer;
    if (!prepare(request.preparation) || !ask(request, answer)) return std::nullopt;
    if (answer.late) {
      cause = "the object moved while the planner worked";
      robot_.settle();
      return std::nullopt;
    }
    if (answer.trajectory) return std::move(answer.trajectory);
    if (refused + 1 < how_.refusals && answer.slips && (request.with_scene_friction || how_.friction == 1)) {
      if (!wait_for_rest(wait)) return std::nullopt;
      wait *= 2;
    }
    request = next_request(request, answer.slips && how_.friction < 1, can_step_back());
  }
  const std::string& reason = out_.plans.back().reason;
  robot_.end(RunEnd::NoPlan, fmt::format("{} plans in a row failed{}", how_.refusals, reason.empty() ? "" : ": " + reason));
  return std::nullopt;
}

/// Counts a plan after the first one of a goal, whatever its cause. @returns false if there were too many
bool PlanMaker::count() {
  int& replans = out_.goals.back().replans;
  if (replans == how_.replans) return robot_.end(RunEnd::Replans, fmt::format("the goal was not reached with {} replans", replans));
  ++replans, ++out_.replans;
  return true;
}

/// Holds for some time [s], and until the objects rest. @returns false if no plan is needed any more
bool PlanMaker::wait_for_rest(double time) {
  const double end = robot_.now() + time;
  while (robot_.now() < end) {
    if (!robot_.hold_tick()) return false;
  }
  return robot_.settle() && !robot_.is_at_goal();
}

/// Prepares the robot for the request. @returns false if no plan is needed any more
bool PlanMaker::prepare(Preparation preparation) {
  switch (preparation) {
    case Preparation::None:
      return true;
    case Preparation::StepBack:
      return robot_.step_back() && !robot_.is_at_goal();
    case Preparation::LetGo:
      return robot_.let_go() && !robot_.is_at_goal();
  }
  return true;
}

/// Asks the planner. @returns false if the run is over
bool PlanMaker::ask(const PlanRequest& request, Answer& answer) {
  robot_.enter(RunState::Replan);
  const double begin = robot_.now(), arrival = begin + robot_.thinking_time() + robot_.approach_time();
  Question question{.q = robot_.expected(arrival - begin),
                    .u = robot_.u(),
                    .number = out_.plans.size(),
                    .friction = request.with_scene_friction ? 1 : how_.friction,
                    .is_short = request.is_short};
  if (!real_time_) question.time_left = how_.duration - robot_.now();
  const auto work = [&](const core::RunControl& control) { answer = source_.ask(question, control); };
  const bool goes_on = real_time_ ? think_beside(work) : think_first(work, answer);
  planning::PlanResult& result = answer.result;
  out_.plans.push_back(
      {begin, result.wall_s, answer.processor_s, robot_.now() - begin, result.status, request.cause, result.reason, answer.joined});
  out_.planning_s += result.wall_s;
  if (!goes_on) return false;
  if (answer.trajectory && !meet(question, arrival, answer)) return false;
  if (!out_.first_plan && !answer.joined) out_.first_plan = std::move(result);
  return true;
}

/// Waits until the objects are about to come to the start of the plan, if they roll or slide there. @returns false if the run is over
bool PlanMaker::meet(const Question& question, double arrival, Answer& answer) {
  const Trajectory& trajectory = *answer.trajectory;
  const bool regrasps = !trajectory.pieces.empty() && trajectory.pieces[0].kind == planning::SegmentKind::Regrasp;
  const double approach = regrasps ? trajectory.times[trajectory.pieces[0].last_knot] : 0;
  const auto off = [&] { return share_between(model_, robot_.expected(approach), question.q, robot_.problem().goal); };
  while (off() > how_.off_at_the_end && robot_.now() < arrival - approach) {
    if (!robot_.hold_tick()) return false;
  }
  answer.late = off() > how_.off_at_the_end;
  return true;
}

/// For a plant that waits for its commands: the planner works first, and then the clock goes on by the time that is charged for it.
template <class Work>
bool PlanMaker::think_first(const Work& work, const Answer& answer) {
  const double begin = robot_.now();
  work(control_);
  if (control_.stop())
    return robot_.end(control_.cancelled() ? RunEnd::Cancelled : RunEnd::Deadline, "stopped while planning; the robot holds");
  robot_.pause();
  if (!robot_.read()) return false;
  while (robot_.now() - begin < answer.charge_s - 0.5 * how_.tick) {
    if (!robot_.hold_tick()) return false;
  }
  return true;
}

/// For a plant with its own clock: the run commands it while the planner works on another thread.
template <class Work>
bool PlanMaker::think_beside(const Work& work) {
  std::atomic<bool> done{false}, unwanted{false};
  std::exception_ptr error;
  core::RunControl control = control_;
  control.on_progress = nullptr;  // only the thread of the run reports progress
  control.abandoned = [&unwanted] { return unwanted.load(std::memory_order_relaxed); };
  std::jthread planner([&] {
    try {
      work(control);
    } catch (...) {
      error = std::current_exception();
    }
    done.store(true);
  });
  try {
    do {
      (void)robot_.hold_tick();
    } while (!robot_.is_over() && !done.load());
  } catch (...) {
    unwanted.store(true);
    throw;
  }
  unwanted.store(true);
  planner.join();
  if (error) std::rethrow_exception(error);
  return !robot_.is_over();
}

}  // namespace stiction::execution
