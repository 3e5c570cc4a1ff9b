#include <algorithm>
#include <cstring>

#include "stiction/contact/relative_motion.hpp"
#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {

using Eigen::Vector3d;

namespace {

using Four = double __attribute__((vector_size(32)));

constexpr int kScrew = 8;  // doubles per coordinate: axis, moment about the origin, two unused

// Rows n, t1, t2 (and 0) of a contact as forces through a point p. For a coordinate with axis a and moment m about the origin, the entry of
// row r is a·(p × r) + m·r. Component k of the torques and forces of all rows is stored contiguously. docs/theory/contact.md §7.
struct Wrenches {
  Four torque[3], force[3];
};

inline Four all(double x) { return Four{x, x, x, x}; }

inline Wrenches make_wrenches(const Four force[3], const Vector3d& p, double sign) {
  const Four x = all(sign * p.x()), y = all(sign * p.y()), z = all(sign * p.z()), s = all(sign);
  return {{y * force[2] - z * force[1], z * force[0] - x * force[2], x * force[1] - y * force[0]},
          {s * force[0], s * force[1], s * force[2]}};
}

inline Four column(const Wrenches& w, const double* screw) {
  return (w.torque[0] * all(screw[0]) + w.torque[1] * all(screw[1]) + w.torque[2] * all(screw[2])) +
         (w.force[0] * all(screw[3]) + w.force[1] * all(screw[4]) + w.force[2] * all(screw[5]));
}

inline void store(double* to, const Four& x) { std::memcpy(to, &x, sizeof x); }

// Columns of `count` neighbouring coordinates; J and `stride` as in a row-major 3 × stride matrix.
inline void fill_columns(const Wrenches& w, const double* screw, int count, double* J, int stride) {
  int j = 0;
  for (; j + 4 <= count; j += 4, screw += 4 * kScrew) {
    const Four a = column(w, screw), b = column(w, screw + kScrew), c = column(w, screw + 2 * kScrew), d = column(w, screw + 3 * kScrew);
    const Four ab_02 = __builtin_shufflevector(a, b, 0, 4, 2, 6), cd_02 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Four ab_1 = __builtin_shufflevector(a, b, 1, 5, 3, 7), cd_1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    store(J + j, __builtin_shufflevector(ab_02, cd_02, 0, 1, 4, 5));
    store(J + j + stride, __builtin_shufflevector(ab_1, cd_1, 0, 1, 4, 5));
    store(J + j + 2 * stride, __builtin_shufflevector(ab_02, cd_02, 2, 3, 6, 7));
  }
  for (; j < count; ++j, screw += kScrew) {
    const Four a = column(w, screw);
    J[j] = a[0];
    J[j + stride] = a[1];
    J[j + 2 * stride] = a[2];
  }
}

}  // namespace

void calc_jacobian(const world::Model& model, const world::Kinematics& kinematics, const Contact& contact, double* J) {
  if (contact.pair < 0 || contact.pair >= static_cast<int>(model.pairs().size())) {
    core::throw_invalid("contact.pair", std::to_string(contact.pair), "an index of Model::pairs()");
  }
  const std::vector<int>& support = model.supports()[model.pairs()[contact.pair].support];
  const int k = static_cast<int>(support.size());
  std::fill_n(J, 3 * k, 0.0);
  visit_relative_motion(model, kinematics, contact, [&](const world::Axis& axis, const Vector3d& v, const Vector3d& w) {
    const auto c = std::lower_bound(support.begin(), support.end(), axis.dof) - support.begin();
    J[c] += axis.ratio * contact.nhat_BA_W.dot(v);
    J[k + c] += axis.ratio * contact.t1_W.dot(v);
    J[2 * k + c] += axis.ratio * (contact.t2_W.dot(v) + contact.spin * contact.nhat_BA_W.dot(w));
  });
}

/// Axis and moment about the origin of every axis of the kinematics.
void detail::fill_screws(Workspace::Impl& w, const world::Kinematics& kinematics) {
  for (std::size_t i = 0; i < w.axes.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Vector3d axis = kinematics.axis_W.col(column);
    double* to = w.screw.data() + kScrew * i;
    Eigen::Map<Vector3d>{to} = w.axes[i].revolute ? axis : Vector3d(0, 0, 0);
    Eigen::Map<Vector3d>{to + 3} = w.axes[i].revolute ? Vector3d(kinematics.origin_W.col(column).cross(axis)) : axis;
  }
}

void detail::fill_axis_columns(const Workspace::Impl& w, const Contact& contact, double* J) {
  const Workspace::Impl::PairData& pair = w.pairs[contact.pair];
  const Vector3d &n = contact.nhat_BA_W, &t1 = contact.t1_W, &t2 = contact.t2_W;
  const Four rows[3] = {{n.x(), t1.x(), t2.x(), 0}, {n.y(), t1.y(), t2.y(), 0}, {n.z(), t1.z(), t2.z(), 0}};
  for (int r = pair.run_begin; r < pair.run_end; ++r) {
    const Workspace::Impl::ColumnRun& run = w.column_runs[r];
    const double* from = w.screw.data() + kScrew * run.axis;
    double* to = J + run.column;
    if (run.moves_a && run.moves_b) {  // both bodies move together: only the vector between the two points counts
      Wrenches between = make_wrenches(rows, contact.p_WA - contact.p_WB, 1.0);
      between.force[0] = between.force[1] = between.force[2] = all(0.0);
      fill_columns(between, from, run.count, to, pair.n_axes);
    } else if (run.moves_a) {
      fill_columns(make_wrenches(rows, contact.p_WA, 1.0), from, run.count, to, pair.n_axes);
    } else {
      fill_columns(make_wrenches(rows, contact.p_WB, -1.0), from, run.count, to, pair.n_axes);
    }
  }
}

void detail::add_spin(const Workspace::Impl& w, const Contact& contact, double* J) {
  const Workspace::Impl::PairData& pair = w.pairs[contact.pair];
  const Vector3d moment = contact.spin * contact.nhat_BA_W;
  double* t2 = J + 2 * pair.n_axes;
  for (int r = pair.run_begin; r < pair.run_end; ++r) {
    const Workspace::Impl::ColumnRun& run = w.column_runs[r];
    if (run.moves_a == run.moves_b) continue;  // no relative rotation
    const Vector3d towards = run.moves_a ? moment : Vector3d(-moment);
    for (int i = 0; i < run.count; ++i) {
      t2[run.column + i] += towards.dot(Eigen::Map<const Vector3d>(w.screw.data() + kScrew * (run.axis + i)));
    }
  }
}

void detail::fold_columns(const Workspace::Impl& w, const Workspace::Impl::PairData& pair, int rows, const double* from, double* to) {
  std::fill_n(to, rows * pair.n_columns, 0.0);
  for (int r = 0; r < rows; ++r) {
    for (int a = 0; a < pair.n_axes; ++a) {
      const Workspace::Impl::Fold& fold = w.folds[pair.fold_begin + a];
      to[r * pair.n_columns + fold.column] += fold.ratio * from[r * pair.n_axes + a];
    }
  }
}

void calc_jacobians(const world::Model&, const world::Kinematics& kinematics, std::span<const Contact> contacts, Workspace& work,
                    Jacobians& out) {
  Workspace::Impl& w = work.impl();
  core::require_size("kinematics.axis_W", kinematics.axis_W.cols(), static_cast<long>(w.axes.size()));
  detail::fill_screws(w, kinematics);

  out.begin.resize(contacts.size() + 1);
  int size = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int pair = contacts[i].pair;
    if (pair < 0 || pair >= static_cast<int>(w.pairs.size())) {
      core::throw_invalid("contact.pair", std::to_string(pair), "an index of Model::pairs()");
    }
    out.begin[i] = size;
    size += 3 * w.pairs[pair].n_columns;
  }
  out.begin[contacts.size()] = size;
  out.values.resize(size);

  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Workspace::Impl::PairData& pair = w.pairs[contacts[i].pair];
    double* J = out.values.data() + out.begin[i];
    double* columns = pair.folded ? w.unfolded.data() : J;
    detail::fill_axis_columns(w, contacts[i], columns);
    if (contacts[i].spin != 0) detail::add_spin(w, contacts[i], columns);
    if (pair.folded) detail::fold_columns(w, pair, 3, w.unfolded.data(), J);
  }
}

}  // namespace stiction::contact
