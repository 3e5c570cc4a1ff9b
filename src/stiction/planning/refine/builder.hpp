#pragma once

#include <optional>
#include <vector>

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// Builds the refined plan, push by push from the given one.
class Builder {
 public:
  Builder(Problem& problem, Scratch& scratch);

  bool build();

  RefineResult result();
  const Work& work() const { return work_; }

 private:
  /// State of the refined plan after a part of the pushes.
  struct Place {
    Cursor at;
    std::size_t segments;
    RefineResult counts;
  };
  Place here() const { return {at_, built_.segments.size(), out_}; }

  bool settle(const std::vector<Segment>& segments, SegmentKind as);
  bool regrasp(const Push& push, std::size_t number);
  std::vector<double> clearances_of(const Push& push) const;
  bool push(const Push& push, bool last);
  bool plan_anew(std::vector<Push>& pushes);
  void take(Run& run);
  bool agrees(const Cursor& at) const { return problem_.miss(at.q, at.fine.q) <= threshold::kAgree; }
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine) const;

  Problem& problem_;
  Scratch& scratch_;
  Plan built_;
  Cursor at_;
  std::vector<Place> sure_;  ///< ends of pushes and regrasps where whole and half sub-steps agree and no search has started
  int searches_ = 0;         ///< number of searches for the remaining way
  long extensions_ = 0;      ///< extensions of all these searches
  RefineResult out_;
  Work work_;
};

}  // namespace stiction::planning::refinement
