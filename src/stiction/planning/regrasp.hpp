#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// Every branch that goes elsewhere in a regrasp, 0.1 rad or L, touches nothing from when it first is 0.01 L away from everything to when it last is, as the
/// checker demands. A path keeps its clearance; springs that give way do not follow it exactly.
bool is_free_on_its_way(const world::Model& model, const world::RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        contact::GeometryWorkspace& work);

/// How a regrasp is simulated: as it differs between the tree and a refinement in smaller steps.
struct RegraspSizes {
  Pace pace;                                             ///< near contacts
  std::optional<dynamics::SubstepLimits> free_limits{};  ///< where the branches that move are clear of everything
  int cuts = 1;                                          ///< steps for each of the search's
  double clearance = 0;                                  ///< that moving branches keep to everything between their contacts [m]
  Worst most = kAnything;
  Place also{};  ///< where the objects may be as well
};

/// One regrasp, simulated from (q, u): branches let go and back off, the objects come to rest, the branches go to another posture and hold until the objects
/// rest in the new grip. Objects must stay within thresholds.release of the start while branches let go, and within thresholds.regrasp of where they came
/// to rest from then on.
class RegraspSimulation {
 public:
  RegraspSimulation(const Setting& setting, const RegraspSizes& sizes, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                    SimulationScratch& scratch, Work& work);

  const Trace& at() const { return at_; }
  std::vector<dynamics::Knot>& knots() { return at_.knots; }

  /// The command goes to u_kept with the springs of the branches in `unloaded` unloaded, those in `moving` back off, and the objects settle.
  /// @param clear  false: they cannot back off
  Ending let_go(const Eigen::VectorXd& u_kept, world::ChainMask unloaded, world::ChainMask moving, bool& clear);
  /// The objects come to rest where they are with gravity kReleaseTilt aside, from each of four sides.
  bool is_stable();
  /// A path of the branches in `moving` to a posture, free of contact between its ends. @returns false where there is none
  bool find_path(world::ChainMask moving, const Eigen::VectorXd& posture, core::Random& random, std::vector<Eigen::VectorXd>& path);
  /// Along the path; its last command is u_end for the joints of `moving`. Then the command is held until the objects rest.
  Ending go(world::ChainMask moving, const std::vector<Eigen::VectorXd>& path, const Eigen::VectorXd& u_end);
  /// Held until the objects rest. @returns Moved where they do not come to rest
  Ending hold();
  bool is_free_on_its_way() { return planning::is_free_on_its_way(setting_.model, setting_.chains, at_.knots, scratch_.geometry); }

 private:
  Ending move(const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, const Allowance& allowance);
  Watch watch(const Allowance& allowance) const;
  bool is_clear(world::ChainMask moving, const Eigen::VectorXd& q_a);
  Allowance rest() const;

  const Setting& setting_;
  const RegraspSizes& sizes_;
  SimulationScratch& scratch_;
  Simulation simulation_;
  Eigen::VectorXd q_rest_;  // where the objects rest
  Trace at_;
};

/// Branches that let go of the objects.
struct Release {
  world::ChainMask moved = 0;    ///< 0: no branch of the robots can touch an object
  bool may_be_unstable = false;  ///< the objects need not stay with gravity aside meanwhile: the last resort
};

/// A regrasp that was simulated and holds.
struct Regrasp : Work {
  std::vector<dynamics::Knot> knots;  ///< at full friction
  bool unstable = false;              ///< meanwhile an object would not stay with gravity aside
};

/// What a posture that was drawn is good for.
struct Promise {
  double distance = 0;      ///< of the objects from their subgoal after the extension, lower is better
  Eigen::VectorXd command;  ///< of that extension (n_a)
};

/// How postures are drawn, and told apart. Empty functions: they are taken as they come.
struct GraspJudge {
  std::function<Promise(const Eigen::VectorXd& q, const Eigen::VectorXd& u)> promise;  ///< by a local model
  std::function<double(const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& command)>
      simulated;  ///< what comes of it
  contact::GenericSampler sampler{};
  bool choose = true;  ///< among kCandidates postures; else the first one is taken
};

/// Tries one regrasp of the tree at (q, u): a contact sample is drawn where the objects came to rest after the branches of `release` let go. Branches that do
/// not move keep their grip; where the objects do not stay with that, everything lets go first.
/// @param judge   of kCandidates postures the best that has a path is taken
/// @param counts  the outcome is counted by cause
bool try_regrasp(const Setting& setting, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Release& release,
                 const GraspJudge& judge, core::Random& random, SimulationScratch& scratch, Regrasp& out, RegraspCounts& counts);

}  // namespace stiction::planning
