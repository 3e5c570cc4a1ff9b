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

/// True if the branches touch nothing on their way, as the checker demands. A branch that moves by 0.1 rad or L must touch nothing between
/// the first and the last time that it is 0.01 L away from everything. A planned path keeps its clearance, but springs that give way do not
/// follow it exactly.
bool is_free_on_its_way(const world::Model& model, const world::RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        contact::GeometryWorkspace& work);

/// Parameters of a simulated regrasp. They differ between the tree and a refinement in smaller steps.
struct RegraspSizes {
  Pace pace;                                             ///< pace near contacts
  std::optional<dynamics::SubstepLimits> free_limits{};  ///< limits of sub-steps while the moving branches are clear of everything
  int cuts = 1;                                          ///< steps for each step of the search
  double clearance = 0;                                  ///< distance that moving branches keep from everything between their contacts [m]
  Worst most = kAnything;
  Place also{};  ///< second place where the objects may be
};

/// Simulates one regrasp from (q, u): branches release the objects and back off, the objects come to rest, and the branches go to another
/// posture and hold until the objects rest again. Objects must stay within thresholds.release of the start during the release, and from
/// then on within thresholds.regrasp of the place where they came to rest.
class RegraspSimulation {
 public:
  RegraspSimulation(const Setting& setting, const RegraspSizes& sizes, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                    SimulationScratch& scratch, Work& work);

  const Trace& at() const { return at_; }
  std::vector<dynamics::Knot>& knots() { return at_.knots; }

  /// Relaxes the springs of the branches in `unloaded`, with u_kept as command of the others, backs off with the branches in `moving`, and
  /// lets the objects settle. @param clear  false: the branches cannot back off
  Ending let_go(const Eigen::VectorXd& u_kept, world::ChainMask unloaded, world::ChainMask moving, bool& clear);
  /// True if the objects come to rest in place when gravity is tilted by kReleaseTilt, to each of four sides.
  bool is_stable();
  /// Plans a path of the branches in `moving` to a posture, free of contact between its ends. @returns false: there is none
  bool find_path(world::ChainMask moving, const Eigen::VectorXd& posture, core::Random& random, std::vector<Eigen::VectorXd>& path);
  /// Follows the path; its last command for the joints of `moving` is u_end. Then holds the command until the objects rest.
  Ending go(world::ChainMask moving, const std::vector<Eigen::VectorXd>& path, const Eigen::VectorXd& u_end);
  /// Holds the command until the objects rest. @returns Moved if they do not come to rest
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
  Eigen::VectorXd q_rest_;  // configuration in which the objects came to rest
  Trace at_;
};

/// Branches that release the objects.
struct Release {
  world::ChainMask moved = 0;    ///< branches that let go; 0: no branch of the robots can touch an object
  bool may_be_unstable = false;  ///< last resort: meanwhile the objects need not stay under tilted gravity
};

/// A simulated regrasp that holds.
struct Regrasp : Work {
  std::vector<dynamics::Knot> knots;  ///< sub-steps of the regrasp
  bool unstable = false;              ///< while branches were away, an object would have moved under tilted gravity
};

/// What a local model predicts for a drawn posture.
struct Promise {
  double distance = 0;      ///< distance of the objects from their subgoal after the extension; lower is better
  Eigen::VectorXd command;  ///< command of that extension (n_a)
};

/// How postures are drawn and compared. If the functions are empty, postures are taken in the order of drawing.
struct GraspJudge {
  std::function<Promise(const Eigen::VectorXd& q, const Eigen::VectorXd& u)> promise;  ///< prediction by a local model
  /// Distance from the subgoal after the command is simulated.
  std::function<double(const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& command)> simulated;
  contact::GenericSampler sampler{};
  bool choose = true;  ///< choose among kCandidates postures, else take the first one
};

/// Tries one regrasp of the tree at (q, u). The branches of `release` let go, the objects come to rest, and then a contact sample is drawn.
/// The other branches keep their grip. If the objects do not stay with that grip, all branches let go first.
/// @param judge   the best of kCandidates postures to which there is a path is taken
/// @param counts  counts the outcome by cause
bool try_regrasp(const Setting& setting, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Release& release,
                 const GraspJudge& judge, core::Random& random, SimulationScratch& scratch, Regrasp& out, RegraspCounts& counts);

}  // namespace stiction::planning
