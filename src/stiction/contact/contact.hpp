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

/// Body that carries the reference face of a patch. The contact normal turns with this body.
enum class PatchSide : unsigned char {
  None,  ///< not a point of a patch: the normal and the points come from the distance of the two surfaces
  A,
  B
};

/// How a point of a patch moves. R is the body with the reference face, I the other body. The point on R is the projection of the point on
/// I onto that face.
enum class PatchPoint : unsigned char {
  Vertex,    ///< the point of I is fixed in I
  Crossing,  ///< the point of I slides along an edge of I (direction edge_W) and stays on a side plane of R (normal side_W)
  Corner     ///< the point of R is fixed in R; the point of I slides on a face of I with outward normal edge_W
};

/// One contact candidate of a configuration.
struct Contact {
  int pair = -1;                          ///< index into Model::pairs()
  PatchSide reference = PatchSide::None;  ///< body with the reference face, if this is a point of a patch
  PatchPoint kind = PatchPoint::Vertex;   ///< how the point moves; used only in a patch
  std::uint64_t id = 0;                   ///< stable over time: pair · 256 + number of the features that meet in the point
  double phi = 0;                         ///< signed distance [m], negative = penetration
  Eigen::Vector3d p_WA, p_WB;             ///< witness points [m]
  Eigen::Vector3d nhat_BA_W, t1_W, t2_W;  ///< right-handed frame, n × t1 = t2; in planar models t1 = axis × n and t2 = axis
  double friction = 0;                    ///< μ of the pair
  /// Arm of a contact that resists turning about its normal [m] (S.26): row t2 of J_c belongs to the point p + spin t1, and λ_t2 has the
  /// moment spin λ_t2 about n. 0: a point without such a moment.
  double spin = 0;
  Eigen::Vector3d edge_W{0, 0, 0};  ///< unit vector, see PatchPoint; zero if unused
  Eigen::Vector3d side_W{0, 0, 0};  ///< unit vector, see PatchPoint; zero if unused
};

struct QueryOptions {
  double margin = 0.0;    ///< added to every pair's max_distance [m], ≥ 0
  double cutoff = 1e300;  ///< contacts farther than this are dropped even if the max_distance of their pair allows them [m]
  /// One distance per pair [m], or empty for no effect. A pair that is at least this far apart is left out, whatever its max_distance.
  /// A nearer pair keeps all its contacts, as if `near` were empty.
  std::span<const double> near{};
};

/// Scratch of a query; one per thread. It holds the shapes of the model in flat form. From earlier queries it keeps only separating
/// directions, which show sooner that a pair is out of reach. Equal configurations therefore give equal bits, whatever the earlier queries
/// were.
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

/// Finds all contacts at a configuration: every point with phi < min(max_distance + margin, cutoff). The contacts are sorted by id, that
/// is by pair index and then by features. A pair has one contact, or a patch of up to eight if one shape has a flat face that looks at the
/// other shape (docs/theory/contact.md §9). If scene.max_contacts is set, only that many of the nearest contacts are kept (ties by id).
///
/// The broad phase uses bounding spheres, phi ≥ ‖p_WCenter,A − p_WCenter,B‖ − r_A − r_B; it never drops a contact.
/// @param out  capacity is kept: no heap use after the first call with the same `out` and `work` up to 4096 contacts
/// @throws core::InvalidInput: margin negative or not finite, cutoff NaN, `work` or `kinematics` of another model
/// Tests: tests/contact/query_test.cpp
void query(const world::Model& model, const world::Kinematics& kinematics, const QueryOptions& options, Workspace& work,
           std::vector<Contact>& out);

/// Splits each contact of a pair that resists turning (world::Pair::torsional) into two with the arms ±torsional/μ. The second ones
/// follow after all others, with ids of their own. In planar models no contact is split.
void split_turning(const world::Model& model, std::vector<Contact>& contacts);

/// Finds the contacts of the given pairs with phi < cutoff [m], in the given order of pairs; max_distance and max_contacts do not apply.
void query_pairs(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double cutoff,
                 Workspace& work, std::vector<Contact>& out);

/// Smallest signed distance of the given pairs [m], +∞ if there are no pairs. The search stops at the first value < stop_below, so
/// the result r satisfies: r ≥ stop_below → r is the minimum; r < stop_below → the minimum is ≤ r. Pass −∞ for the minimum.
double calc_min_distance(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices,
                         double stop_below, Workspace& work);

/// Whether any of the given pairs is nearer than `distance` [m]. Same as calc_min_distance() < distance, but cheaper.
bool any_nearer(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double distance,
                Workspace& work);

/// Distance of one pair, at any range.
Distance pair_distance(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work);

/// Distances of single pairs at one configuration. Each geometry is placed once, at the first query of a pair that contains it.
class Gaps {
 public:
  /// @param kinematics  kept by reference, as is `work`
  Gaps(const world::Model& model, const world::Kinematics& kinematics, Workspace& work);
  /// Returns φ if φ < `enough` [m]. Otherwise it returns a lower bound of φ: the bound of the bounding spheres if that is at least
  /// `enough`, else `enough`. Earlier queries with the same workspace do not change the result.
  double calc(int pair, double enough);
  /// Call this after the kinematics changed.
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
/// the displacement of A at p_WA relative to B at p_WB. Row n is exactly the gradient of phi, phi(q ⊕ δ) = phi(q) + J_n δ + O(δ²),
/// wherever the witness points are unique, and for patch points that are fixed in the body without the reference face
/// (PatchPoint::Vertex). For PatchPoint::Crossing and Corner it is the gradient of the height of the material point.
/// @param J row-major, 3·k numbers, k = supports()[pair.support].size()
/// Source: docs/theory/contact.md §7. Tests: tests/contact/jacobian_test.cpp
void calc_jacobian(const world::Model& model, const world::Kinematics& kinematics, const Contact& contact, double* J);

/// Jacobians of many contacts: contact i has values[begin[i]] … values[begin[i + 1]), 3 × k row-major as above.
struct Jacobians {
  std::vector<double> values;
  std::vector<int> begin;  ///< n_c + 1 numbers
};

/// Same numbers as calc_jacobian() up to rounding, but several times faster for many contacts. No heap use once `out` has its size.
void calc_jacobians(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, Workspace& work,
                    Jacobians& out);

/// Signed distance between two shapes at given poses, the kernel of the query; for tests and tools (it allocates).
///
/// phi = min ‖p_A − p_B‖ over points of A and B if the shapes are apart, else −(length of the shortest translation that separates them).
/// Exact to rounding if one shape is a sphere or a half-space, or if both are polytopes or capsules. For a cylinder against any shape
/// other than a sphere or a half-space see docs/theory/contact.md §5.
/// @throws core::InvalidInput: two half-spaces, a mesh without a face
/// Tests: tests/contact/distance_test.cpp
Distance calc_distance(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b, const world::Pose& X_WB);

}  // namespace stiction::contact
