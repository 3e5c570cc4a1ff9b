#pragma once

#include <array>
#include <string_view>

#include "stiction/core/processor_time.hpp"

namespace stiction::planning {

/// Activities that take processor time in a search (`stiction plan --profile`).
enum class Activity : unsigned {
  Selection,     ///< subgoals, nearest nodes, and insertion of new nodes
  Extensions,    ///< least squares (P.2), (P.7)
  Pushes,        ///< sub-steps of extensions
  LocalModels,   ///< smoothed steps with B at new nodes
  HalfSteps,     ///< replay of edges at half sub-steps
  Disturbances,  ///< pushes with displaced objects, tilted gravity and less friction (margins)
  LettingGo,     ///< branches let go and back off
  Stability,     ///< objects under tilted gravity while branches are away
  GraspSamples,  ///< draws of postures in contact
  GraspModels,   ///< local models of these postures
  GraspTrials,   ///< pushes from the most promising postures
  Paths,         ///< paths of branches to a new posture
  Grasping,      ///< motion along these paths, until objects rest
  Ends,          ///< settling the start, writing the plan
};
inline constexpr std::array<std::string_view, 14> kActivityNames = {
    "selection", "extensions",    "pushes",       "local_models", "half_steps", "disturbances", "letting_go",
    "stability", "grasp_samples", "grasp_models", "grasp_trials", "paths",      "grasping",     "ends"};

/// Processor time by activity, of one thread or of several.
struct Profile {
  struct Entry {
    double processor_s = 0;
    long calls = 0;
  };
  std::array<Entry, kActivityNames.size()> entries{};

  Profile& operator+=(const Profile& o) {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      entries[i].processor_s += o.entries[i].processor_s;
      entries[i].calls += o.entries[i].calls;
    }
    return *this;
  }
};

/// The clock of one thread. Time counts for the innermost activity that is under way.
class ProfileClock {
 public:
  const Profile& profile() const { return profile_; }

  /// Marks an activity as under way while this object lives. It must end on the thread on which it began.
  class Scope {
   public:
    Scope(ProfileClock& clock, Activity activity) : clock_(clock), outer_(clock.current_) {
      clock_.charge();
      clock_.current_ = &clock_.profile_.entries[static_cast<unsigned>(activity)];
      ++clock_.current_->calls;
    }
    ~Scope() {
      clock_.charge();
      clock_.current_ = outer_;
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    ProfileClock& clock_;
    Profile::Entry* outer_;
  };

 private:
  void charge() {
    const double now = core::processor_time(CLOCK_THREAD_CPUTIME_ID);
    if (current_ != nullptr) current_->processor_s += now - since_;
    since_ = now;
  }

  Profile profile_;
  Profile::Entry* current_ = nullptr;
  double since_ = 0;
};

}  // namespace stiction::planning
