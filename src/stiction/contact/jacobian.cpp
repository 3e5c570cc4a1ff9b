#include <cstring>

#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {

using Eigen::Vector3d;

namespace {

using Four = double __attribute__((vector_size(32)));

constexpr int kScrew = 8;  // doubles per coordinate: axis, moment about the origin, two unused

// Rows n, t1, t2 (and 0) of a contact as forces through a point p. A coordinate with axis a and moment m about the origin gives
// row r the number a·(p × r) + m·r; component k of torque and force of the rows stand side by side. docs/theory/contact.md §7.
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
  const world::Pair& pair = model.pairs()[contact.pair];
  const std::vector<int>& support = model.supports()[pair.support];
  const std::vector<int>& dofs_a = model.bodies()[model.geometries()[pair.geometry_a].body].dofs;
  const std::vector<int>& dofs_b = model.bodies()[model.geometries()[pair.geometry_b].body].dofs;
  const int k = static_cast<int>(support.size());
  std::size_t a = 0, b = 0;
  for (int c = 0; c < k; ++c) {
    const int dof = support[c];
    const bool moves_a = a < dofs_a.size() && dofs_a[a] == dof, moves_b = b < dofs_b.size() && dofs_b[b] == dof;
    a += moves_a;
    b += moves_b;
    const Vector3d axis = kinematics.axis_W.col(dof);
    Vector3d v = Vector3d::Zero();
    if (model.dofs()[dof].kind == world::DofKind::Prismatic) {
      if (moves_a != moves_b) v = moves_a ? axis : Vector3d(-axis);
    } else if (moves_a && moves_b) {
      v = axis.cross(contact.p_WA - contact.p_WB);
    } else if (moves_a) {
      v = axis.cross(contact.p_WA - kinematics.origin_W.col(dof));
    } else {
      v = axis.cross(kinematics.origin_W.col(dof) - contact.p_WB);
    }
    J[c] = contact.nhat_BA_W.dot(v);
    J[k + c] = contact.t1_W.dot(v);
    J[2 * k + c] = contact.t2_W.dot(v);
  }
}

void calc_jacobians(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, Workspace& work,
                    Jacobians& out) {
  Workspace::Impl& w = work.impl();
  core::require_size("kinematics.axis_W", kinematics.axis_W.cols(), w.n_v);
  double* screw = w.screw.data();
  const auto dofs = model.dofs();
  for (int i = 0; i < w.n_v; ++i) {
    const Vector3d axis = kinematics.axis_W.col(i);
    const bool revolute = dofs[i].kind == world::DofKind::Revolute;
    double* to = screw + kScrew * i;
    Eigen::Map<Vector3d>{to} = revolute ? axis : Vector3d(0, 0, 0);
    Eigen::Map<Vector3d>{to + 3} = revolute ? Vector3d(kinematics.origin_W.col(i).cross(axis)) : axis;
  }

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
    const Contact& contact = contacts[i];
    const Workspace::Impl::PairData& pair = w.pairs[contact.pair];
    const Vector3d &n = contact.nhat_BA_W, &t1 = contact.t1_W, &t2 = contact.t2_W;
    const Four rows[3] = {{n.x(), t1.x(), t2.x(), 0}, {n.y(), t1.y(), t2.y(), 0}, {n.z(), t1.z(), t2.z(), 0}};
    double* J = out.values.data() + out.begin[i];
    for (int r = pair.run_begin; r < pair.run_end; ++r) {
      const Workspace::Impl::ColumnRun& run = w.column_runs[r];
      const double* from = screw + kScrew * run.dof;
      double* to = J + run.column;
      if (run.moves_a && run.moves_b) {  // moved together: only the gap between the two points counts
        Wrenches between = make_wrenches(rows, contact.p_WA - contact.p_WB, 1.0);
        between.force[0] = between.force[1] = between.force[2] = all(0.0);
        fill_columns(between, from, run.count, to, pair.n_columns);
      } else if (run.moves_a) {
        fill_columns(make_wrenches(rows, contact.p_WA, 1.0), from, run.count, to, pair.n_columns);
      } else {
        fill_columns(make_wrenches(rows, contact.p_WB, -1.0), from, run.count, to, pair.n_columns);
      }
    }
  }
}

}  // namespace stiction::contact
