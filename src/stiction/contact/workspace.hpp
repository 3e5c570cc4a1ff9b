#pragma once

#include <vector>

#include "stiction/contact/clearance.hpp"
#include "stiction/contact/patch.hpp"

// Internal to the layer: what a Workspace holds. docs/theory/contact.md §6.

namespace stiction::contact {

struct Workspace::Impl {
  /// Number of contacts for which room is kept from the first query on, in addition to one per pair.
  static constexpr std::size_t kReservedContacts = 4096;

  explicit Impl(const world::Model& model);

  struct GeometryData {
    int body = -1;
    Eigen::Vector3d p_BCenter;  // centre of its bounding sphere
    world::Pose X_BG;
    detail::ShapeData shape;
    detail::ShapeData extruded;  // planar models: the shape extended across the plane, if it is straight in that direction
  };

  struct PairData {
    detail::Kernel kernel = nullptr;    // nullptr: two spheres
    int a = -1, b = -1;                 // geometries
    int first = -1, second = -1;        // the geometries in the order of the kernel
    double radius_a = 0, radius_b = 0;  // radii, if both are spheres
    double friction = 0;
    bool patch = false;              // may touch in several points
    bool boxes = false;              // two boxes, not in a planar model
    bool in_plane = false;           // planar models: both centres lie in one plane, so only motion in this plane separates the shapes
    bool hulls = false;              // measured by core_distance(): `parting` bounds phi from below
    bool in_slabs = false;           // the second is a box, not in a planar model: its slabs bound phi from below
    int half_space = -1;             // 0 none, else the other geometry's distance to the plane bounds phi from below
    int run_begin = 0, run_end = 0;  // columns of its Jacobian in column_runs
    int n_columns = 0;
    int n_axes = 0;      // number of axes that move the pair; equals n_columns if no joint follows another
    int fold_begin = 0;  // first entry in `folds`
    bool folded = false;
  };

  /// Pairs [begin, begin + count) of the geometry `fixed` with the geometries other, other + 1, …
  struct BroadRun {
    int begin = 0, count = 0, fixed = -1, other = -1;
  };

  /// Columns [column, column + count) of a pair's Jacobian. They belong to the axes axis, axis + 1, … of Kinematics, which move A, B or
  /// both.
  struct ColumnRun {
    int column = 0, axis = 0, count = 0;
    bool moves_a = false, moves_b = false;
  };

  /// An axis of Kinematics. It belongs to a coordinate, or to a joint that follows this coordinate.
  struct Axis {
    bool revolute = false;
    int dof = -1;
    double ratio = 1;
  };
  /// Column of a pair's Jacobian to which an axis adds `ratio` times its own column.
  struct Fold {
    int column = 0;
    double ratio = 1;
  };

  void add_columns(const world::Model& model, const world::Pair& p, PairData& data);
  void find_planes(const world::Model& model);
  void set_kinematics(const world::Kinematics& kinematics);
  void set_kinematics(const world::Kinematics& kinematics, std::span<const int> pair_indices);  // at least for these pairs
  void place(int geometry, const world::Kinematics& kinematics);
  double distance2(int pair) const;                                  // squared distance of the bounding centres [m²]
  double lower_bound(int pair) const;                                // lower bound of phi [m]
  bool is_beyond(int pair, double limit) const;                      // phi ≥ limit, by a better bound than the bounding spheres
  double parted_by(int pair) const;                                  // separation along `parting`, a lower bound of phi for hulls
  int guess_nearest_hulls(std::span<const int> pair_indices) const;  // pair with the smallest lower bound; −1 without hulls
  void narrow(int pair, double limit, Distance& out);                // if phi ≥ limit, phi may be a lower bound only
  void flatten(const PairData& pair, Distance& out) const;
  void reserve_scratch();
  const detail::ShapeData& shape_of(const PairData& pair, int geometry) const;
  const world::Pose& pose_of(int geometry);
  /// Writes the contacts of a pair with phi < limit and returns their number, at most slots(pair). It is 0 if the pair is at least `near`
  /// apart. near ≤ limit.
  int fill(int pair, double limit, double near, Contact* out);
  int fill_patch(int pair, double limit, double near, Contact* out);
  int slots(int pair) const { return pairs[pair].patch ? detail::Patch::kMost : 1; }
  bool fill_spheres(int pair, double limit, double length, double inverse_length, Contact& out);

  std::vector<GeometryData> geometries;
  std::vector<PairData> pairs;
  std::vector<BroadRun> broad_runs;
  std::vector<ColumnRun> column_runs;
  std::vector<Axis> axes;
  std::vector<Fold> folds;
  std::vector<int> posed;                        // geometries whose orientation is needed
  std::vector<double> radius_sum, max_distance;  // per pair
  std::size_t n_patch_points = 0;                // most points of all patches together, beyond one per pair
  int n_v = 0;
  std::vector<double> unfolded;  // Jacobian of a folded pair over its axes, 3 rows
  std::optional<int> planar_axis;
  detail::KernelContext context;
  Eigen::Vector3d coincident_normal;

  // Per pair: a unit vector in the frame of `first` that separated the two shapes in an earlier query. Every direction gives a valid lower
  // bound, so this vector changes the time of a query but never its result.
  std::vector<Eigen::Vector3d> parting;

  std::vector<ClosePair> close_pairs;
  bool close_pairs_known = false;

  // Data of the current configuration.
  std::vector<double> center_x, center_y, center_z;  // per geometry, padded
  std::vector<world::Pose> X_WG;                     // only for `posed`
  std::uint64_t stamp = 1;                           // counts configurations; 0 in Gaps and `placed`: none yet
  std::vector<std::uint64_t> placed;                 // per geometry: stamp of the configuration in which Gaps placed it
  std::vector<double> center_distance2;              // per pair
  std::vector<double> excess;    // per pair: squared centre distance minus the squared distance beyond which the pair is out of reach
  std::vector<double> left_out;  // per pair: distance from which the pair is left out
  std::vector<int> candidates;
  std::vector<double> center_distance, center_inverse;    // per candidate: ‖p_A − p_B‖ of the centres and 1 over it
  std::vector<std::pair<double, std::uint64_t>> nearest;  // for max_contacts
  std::vector<double> screw;                              // 8 per coordinate, see jacobian.cpp
  detail::PatchScratch patch_scratch;
  detail::Patch patch;
};

namespace detail {

/// Rows n, t1, t2 of the point of a contact over the axes of its pair (3 × n_axes), with the kinematics of the last calc_jacobians().
void fill_axis_columns(const Workspace::Impl& w, const Contact& contact, double* J);
/// Adds spin n·(ω_A − ω_B) to row t2.
void add_spin(const Workspace::Impl& w, const Contact& contact, double* J);
/// Turns columns per axis (rows × n_axes) into columns per coordinate that moves the axes (rows × n_columns).
void fold_columns(const Workspace::Impl& w, const Workspace::Impl::PairData& pair, int rows, const double* from, double* to);
void fill_screws(Workspace::Impl& w, const world::Kinematics& kinematics);

/// Right-handed frame (n, t1, t2), n × t1 = t2. docs/theory/contact.md §1.
inline void set_frame(const Eigen::Vector3d& n, const std::optional<int>& planar_axis, Contact& out) {
  if (planar_axis) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(*planar_axis);
    Eigen::Vector3d t1 = axis.cross(n);
    const double length = t1.norm();
    t1 = length > 1e-9 ? Eigen::Vector3d(t1 / length) : Eigen::Vector3d::Unit((*planar_axis + 1) % 3);
    out.nhat_BA_W = n;
    out.t1_W = t1;
    out.t2_W = n.cross(t1);
    return;
  }
  // Frisvad 2012 in the form of Duff et al. 2017. The second chart covers only a cap of 8° around −z, so the frame is continuous
  // everywhere except on the rim of that cap.
  const double sign = n.z() > -0.99 ? 1.0 : -1.0;
  const double a = -1.0 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  out.nhat_BA_W = n;
  out.t1_W = Eigen::Vector3d(1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  out.t2_W = Eigen::Vector3d(b, sign + n.y() * n.y() * a, -n.y());
}

}  // namespace detail
}  // namespace stiction::contact
