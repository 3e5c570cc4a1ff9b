#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::contact {

/// Signed distance between two shapes and where it is attained.
struct Distance {
  double phi = 0;                    ///< signed distance [m], negative = penetration
  Eigen::Vector3d p_WA, p_WB;        ///< witness points on A and B [m]
  Eigen::Vector3d nhat_BA_W;         ///< unit normal from B to A: p_WA − p_WB = phi · nhat
};

/// One contact candidate of a configuration.
struct Contact {
  int pair = -1;                     ///< index into Model::pairs()
  std::uint64_t id = 0;              ///< stable over time: names the pair (and later the point of a patch)
  double phi = 0;
  Eigen::Vector3d p_WA, p_WB;
  Eigen::Vector3d nhat_BA_W, t1_W, t2_W;   ///< right-handed frame (n, t1, t2); in planar models t1 lies in the plane
  double friction = 0;
};

struct QueryOptions {
  double margin = 0.0;     ///< added to every pair's max_distance [m], ≥ 0
  double cutoff = 1e300;   ///< pairs farther than this are dropped even if their max_distance allows them [m]
};

/// Scratch and statistics of a query; one per thread. Holds Coal's shapes and its warm starts.
class Workspace {
 public:
  explicit Workspace(const world::Model& model);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// All contacts at a configuration: every pair nearer than its max_distance + margin, in order of pair index (with
/// scene.max_contacts, the nearest ones). Broad phase by bounding spheres.
void query(const world::Model& model, const world::Kinematics& kinematics, const QueryOptions& options, Workspace& work,
           std::vector<Contact>& out);

/// Distance of one pair, however far.
Distance pair_distance(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work);

/// Contact Jacobian J_c (3 × k, rows n, t1, t2) over the k coordinates of the pair's support, such that v_c = J_c δq is the
/// displacement of A relative to B at the contact. @param J row-major, 3·k numbers, k = supports()[pair.support].size()
void calc_jacobian(const world::Model& model, const world::Kinematics& kinematics, const Contact& contact, double* J);

/// Signed distance between two shapes at given poses (world::Shape), the kernel of the query; used by tests and tools.
Distance calc_distance(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b, const world::Pose& X_WB);

}  // namespace stiction::contact
