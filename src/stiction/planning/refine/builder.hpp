#pragma once

#include <optional>
#include <vector>

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// A plan as far as it was built anew, push by push, and where that leads.
class Builder {
 public:
  Builder(Problem& problem, Scratch& scratch);

  bool build();

  RefineResult result();
  const Work& work() const { return work_; }

 private:
  /// As far as the plan was built.
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
  std::vector<Place> sure_;  ///< ends of pushes and regrasps at which whole and half sub-steps agree, from where no search has begun
  int searches_ = 0;         ///< for what is left …
  long extensions_ = 0;      ///< … and theirs
  RefineResult out_;
  Work work_;
};

}  // namespace stiction::planning::refinement
