#pragma once

#include <vector>

#include "stiction/contact/coal_distance.hpp"

// Internal to the layer: what a Workspace holds. docs/theory/contact.md §6.

namespace stiction::contact {

struct Workspace::Impl {
  explicit Impl(const world::Model& model);

  struct GeometryData {
    int body = -1;
    Eigen::Vector3d p_BCenter;   // of its bounding sphere
    world::Pose X_BG;
    detail::ShapeData shape;
  };

  struct PairData {
    detail::Kernel kernel = nullptr;   // nullptr: two spheres
    int a = -1, b = -1;                // geometries
    int first = -1, second = -1;       // the same in the order of the kernel
    double radius_a = 0, radius_b = 0; // of two spheres
    double friction = 0;
    int half_space = -1;               // 0 none, else the other geometry's distance to the plane bounds phi from below
    int run_begin = 0, run_end = 0;    // columns of its Jacobian in column_runs
    int n_columns = 0;
  };

  /// Pairs [begin, begin + count) of one geometry with the neighbours other, other + 1, …
  struct BroadRun {
    int begin = 0, count = 0, fixed = -1, other = -1;
  };

  /// Columns [column, column + count) of a pair's Jacobian, coordinates dof, dof + 1, …, that move A, B or both.
  struct ColumnRun {
    int column = 0, dof = 0, count = 0;
    bool moves_a = false, moves_b = false;
  };

  void set_kinematics(const world::Kinematics& kinematics);
  double distance2(int pair) const;                    // of the bounding centres [m²]
  double lower_bound(int pair) const;                  // of phi [m]
  void narrow(int pair, Distance& out);
  void push(int pair, double limit, std::vector<Contact>& out);

  std::vector<GeometryData> geometries;
  std::vector<PairData> pairs;
  std::vector<BroadRun> broad_runs;
  std::vector<ColumnRun> column_runs;
  std::vector<int> posed;                              // geometries whose orientation matters
  std::vector<double> radius_sum, max_distance;        // per pair
  int n_v = 0;
  std::optional<int> planar_axis;
  detail::KernelContext context;
  Eigen::Vector3d coincident_normal;

  // Of the configuration in hand.
  std::vector<double> center_x, center_y, center_z;    // per geometry, padded
  std::vector<world::Pose> X_WG;                       // of `posed` only
  std::vector<double> center_distance2;                // per pair
  std::vector<int> candidates;
  std::vector<std::pair<double, int>> nearest;         // for max_contacts
  std::vector<double> screw;                           // 6 × n_v, a row per component: axis, moment about the origin
  detail::CoalScratch coal;
};

namespace detail {

/// Right-handed frame (n, t1, t2), n × t1 = t2. docs/theory/contact.md §1.
void set_frame(const Eigen::Vector3d& n, const std::optional<int>& planar_axis, Contact& out);

}  // namespace detail
}  // namespace stiction::contact
