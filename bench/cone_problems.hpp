#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "stiction/cone/problem.hpp"
#include "stiction/cone/solver.hpp"

namespace stiction::bench {

/// Two families of random but physical instances of (C): one quasi-static step, h = 0.1 s, SI units.
/// Hand22: four 4-joint fingers around a free ball (22 variables), 20 contacts (16 link–ball, 4 palm–ball), 38 joint limits.
/// Boxes69: ten boxes in stacks of two and a 9-joint arm (69 variables), 56 contacts, 18 joint limits.
enum class ConeFamily {
  Hand22,
  Boxes69
};

/// One seeded instance and its continuation: follow() moves the gaps, springs and limits by a solution, as a rollout would.
class ConeInstance {
 public:
  ConeInstance(ConeFamily family, std::uint64_t seed);
  const cone::Problem& problem() const { return *problem_; }
  /// Applies the step x of `solution`, moves the commands by up to 5 mrad and rebuilds the problem (same rows, same ids).
  void follow(const cone::Result& solution);

 private:
  struct Contact {
    int support = 0;
    std::vector<double> G;  // 3×k, friction rows scaled by μ
    double gap = 0;
  };
  void make_hand();
  void make_boxes();
  void fill();

  ConeFamily family_;
  std::uint64_t seed_;
  std::uint64_t step_ = 0;
  std::shared_ptr<const cone::Layout> layout_;
  std::unique_ptr<cone::Problem> problem_;
  int first_actuated_ = 0;         // actuated variables are first_actuated_ … first_actuated_ + stiffness_.size() − 1
  std::vector<double> stiffness_;  // h·K
  std::vector<double> stretch_;    // u − q
  std::vector<double> object_Q_;   // diagonal, by object variable
  std::vector<double> object_b_;
  int first_object_ = 0;
  std::vector<double> lower_, upper_;  // q − q_min, q_max − q by actuated variable
  std::vector<Contact> contacts_;
  double sigma_ = 2e-3;  // 2h/κ with κ = 100
};

struct ConeTiming {
  std::vector<double> seconds;  // of each solve
  std::vector<int> iterations;
  long allocations = 0;  // inside solve(), after the first call; −1 when nobody counts
  int failures = 0;      // solves that were not Solved
};

/// Times `n` instances, each once and from a cold start, after one untimed pass over all of them. The problem is filled just before
/// each solve; filling is not timed. @param allocations  running total of heap allocations, or empty
ConeTiming time_cone_cold(ConeFamily family, int n, std::uint64_t seed, cone::Options options,
                          const std::function<long()>& allocations = {});
/// Times rollouts of 10 warm steps, until `n` solves are timed (the first step of each rollout is not).
ConeTiming time_cone_warm(ConeFamily family, int n, std::uint64_t seed, cone::Options options,
                          const std::function<long()>& allocations = {});

}  // namespace stiction::bench
