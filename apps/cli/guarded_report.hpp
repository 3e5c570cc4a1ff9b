#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "stiction/execution/touch/guarded_run.hpp"

namespace stiction::app {

/// Forces from 0.1 s after contact on, against the one that a move asks for in the end, of all others against the bound of the controller.
bool is_gentle(const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, double tolerance);

/// What became of an arm that feels its way.
struct TouchVerdict {
  core::Status status = core::Status::NumericalFailure;
  bool reached = false;  ///< what it was to do is done
  std::string given_up;  ///< else how it ended, in one word …
  std::string reason;    ///< … and why, or what the simulation said
  bool bounded = false;  ///< no force was larger than it may be

  bool passes() const { return status == core::Status::Solved && bounded; }
};
TouchVerdict judge_moves(const execution::GuardedRunResult& r, bool gentle);

/// Its first line, and the head of its object. @param done  what is done where it is
void print_head(std::FILE* to, const execution::TouchScenario& scenario, const TouchVerdict& verdict, std::string_view done);
nlohmann::ordered_json report_head(const execution::TouchScenario& scenario, const TouchVerdict& verdict,
                                   const execution::ControlRunResult& run, std::uint64_t seed, double wall_s);

/// What became of guarded moves, in words and as an object.
void print_moves(std::FILE* to, const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, bool gentle);
nlohmann::ordered_json report_moves(const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, std::uint64_t seed,
                                    bool gentle, double wall_s);

}  // namespace stiction::app
