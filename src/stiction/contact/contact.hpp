#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

// Distance queries, contacts and their Jacobians. Equations, frames, selections and limits: docs/theory/contact.md.

namespace stiction::contact {

/// Signed distance between two shapes and where it is attained.
struct Distance {
  double phi = 0;              ///< signed distance [m], negative = penetration
  Eigen::Vector3d p_WA, p_WB;  ///< witness points on A and B [m]
  Eigen::Vector3d nhat_BA_W;   ///< unit normal from B to A: p_WA − p_WB = phi · nhat
};

/// Body that carries the reference face of a patch: the normal of the point turns with it.
enum class PatchSide : unsigned char {
  None,  ///< not a point of a patch: normal and points are those of the nearest surfaces
  A,
  B
};

/// What holds a point of a patch, with I the body that is not the reference R. Its point on R is the foot of its point on I.
enum class PatchPoint : unsigned char {
  Vertex,    ///< the point of I is fixed in I
  Crossing,  ///< the point of I slides along an edge of I, direction edge_W, so as to stay on a side plane of R, normal side_W
  Corner     ///< the point of R is fixed in R; that of I slides on a face of I, outward normal edge_W
};

/// One contact candidate of a configuration.
struct Contact {
  int pair = -1;                          ///< index into Model::pairs()
  PatchSide reference = PatchSide::None;  ///< of a point of a patch
  PatchPoint kind = PatchPoint::Vertex;   ///< of a point of a patch
  std::uint64_t id = 0;                   ///< stable over time: pair · 256 + number of the features that meet in the point
  double phi = 0;                         ///< [m]
  Eigen::Vector3d p_WA, p_WB;             ///< witness points [m]
  Eigen::Vector3d nhat_BA_W, t1_W, t2_W;  ///< right-handed frame, n × t1 = t2; in planar models t1 = axis × n and t2 = axis
  double friction = 0;                    ///< μ of the pair
  Eigen::Vector3d edge_W{0, 0, 0};        ///< unit, see PatchPoint; zero where it has no use
  Eigen::Vector3d side_W{0, 0, 0};        ///< unit, see PatchPoint; zero where it has no use
};

struct QueryOptions {
  double margin = 0.0;    ///< added to every pair's max_distance [m], ≥ 0
  double cutoff = 1e300;  ///< pairs farther than this are dropped even if their max_distance allows them [m]
  /// Per pair [m], or empty: a pair that is at least this far apart is left out, whatever its max_distance; one that is nearer has the same contacts as without.
  std::span<const double> near{};
};

/// Scratch of a query; one per thread. Holds the shapes of the model in flat form, and, of earlier answers, only directions
/// that tell sooner that a pair is out of reach: equal configurations give equal bits, whatever was asked before.
class Workspace {
 public:
  /// @throws core::InvalidInput: a pair of two half-spaces, a mesh without a face
  explicit Workspace(const world::Model& model);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// All contacts at a configuration: every point with phi < min(max_distance + margin, cutoff), in order of id, that is of pair index
/// and then of features. A pair touches in one point, or, where one of the two has a flat face that looks at the other, in a patch of
/// up to eight (docs/theory/contact.md §9). With scene.max_contacts only the nearest so many, ties by id, still in order of id.
///
/// Broad phase by bounding spheres, phi ≥ ‖p_WCenter,A − p_WCenter,B‖ − r_A − r_B; it never drops a contact.
/// @param out  capacity is kept: no heap use after the first call with the same `out` and `work` up to 4096 contacts
/// @throws core::InvalidInput: margin negative or not finite, cutoff NaN, `work` or `kinematics` of another model
/// Tests: tests/contact/query_test.cpp
void query(const world::Model& model, const world::Kinematics& kinematics, const QueryOptions& options, Workspace& work,
           std::vector<Contact>& out);

/// Contacts of the given pairs with phi < cutoff [m], pairs in the given order; max_distance and max_contacts do not apply.
void query_pairs(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double cutoff,
                 Workspace& work, std::vector<Contact>& out);

/// Smallest signed distance of the given pairs [m], +∞ for none. Stops early with the first value < stop_below it meets, so that
/// the result r satisfies: r ≥ stop_below → r is the minimum; r < stop_below → the minimum is ≤ r. Pass −∞ for the minimum.
double calc_min_distance(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices,
                         double stop_below, Workspace& work);

/// One of the given pairs is nearer than `distance` [m]: calc_min_distance() < distance, for less.
bool any_nearer(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double distance,
                Workspace& work);

/// Distance of one pair, however far.
Distance pair_distance(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work);

/// Distances of single pairs at one configuration. A geometry is placed once, when a pair of it is first asked for.
class Gaps {
 public:
  /// @param kinematics  kept by reference, as is `work`
  Gaps(const world::Model& model, const world::Kinematics& kinematics, Workspace& work);
  /// φ where that is less than `enough`, else a lower bound of φ that is at least `enough`: that of the bounding spheres, or `enough` [m]. What other
  /// queries leave in the workspace does not change it.
  double calc(int pair, double enough);
  /// To be called when the kinematics changed.
  void forget() { stamp_ = 0; }

 private:
  void place(int geometry);

  const world::Kinematics& kinematics_;
  Workspace::Impl& work_;
  std::uint64_t stamp_ = 0;
};

/// Lower bound of the distance of one pair from its bounding spheres (or sphere and plane) [m]; exact for two spheres.
double calc_pair_lower_bound(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work);

/// Contact Jacobian J_c (3 × k, rows n, t1, t2) over the k coordinates of the pair's support, such that
///
///     v_c = J_c δq = [n t1 t2]ᵀ (v_A(p_WA) − v_B(p_WB)) ,
///
/// the displacement of A at its witness point relative to B at its own. Row n is the gradient of phi, exactly:
/// phi(q ⊕ δ) = phi(q) + J_n δ + O(δ²) wherever the witness points are unique, and in points of a patch that are fixed in the body
/// opposite its reference. In the others (PatchPoint::Crossing, Corner) it is the gradient of the height of the material point.
/// @param J row-major, 3·k numbers, k = supports()[pair.support].size()
/// Source: docs/theory/contact.md §7. Tests: tests/contact/jacobian_test.cpp
void calc_jacobian(const world::Model& model, const world::Kinematics& kinematics, const Contact& contact, double* J);

/// Jacobians of many contacts: contact i has values[begin[i]] … values[begin[i + 1]), 3 × k row-major as above.
struct Jacobians {
  std::vector<double> values;
  std::vector<int> begin;  ///< n_c + 1 numbers
};

/// The same numbers as calc_jacobian to rounding, several times faster for many contacts. No heap use once `out` has its size.
void calc_jacobians(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, Workspace& work,
                    Jacobians& out);

/// Signed distance between two shapes at given poses, the kernel of the query; for tests and tools (it allocates).
///
/// phi = min ‖p_A − p_B‖ over points of A and B where they are apart, else −(length of the shortest translation that parts them).
/// Exact to rounding when one of the two is a sphere or a half-space, when both are capsules and when both are polytopes or
/// capsules; a cylinder against anything but those: docs/theory/contact.md §5.
/// @throws core::InvalidInput: two half-spaces, a mesh without a face
/// Tests: tests/contact/distance_test.cpp
Distance calc_distance(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b, const world::Pose& X_WB);

}  // namespace stiction::contact
