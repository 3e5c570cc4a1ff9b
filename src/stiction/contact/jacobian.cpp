#include <algorithm>
#include <array>

#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {

using Eigen::Vector3d;

namespace {

// Rows n, t1, t2 of a contact as forces through a point p: row r · velocity at p of a coordinate with axis a and moment m about
// the origin is a·(p × r) + m·r. docs/theory/contact.md §7.
struct Wrench {
  double torque[3], force[3];
};

std::array<Wrench, 3> make_wrenches(const Contact& c, const Vector3d& p, double force_scale) {
  std::array<Wrench, 3> out;
  const Vector3d* rows[3] = {&c.nhat_BA_W, &c.t1_W, &c.t2_W};
  for (int r = 0; r < 3; ++r) {
    const Vector3d torque = p.cross(*rows[r]);
    for (int k = 0; k < 3; ++k) {
      out[r].torque[k] = torque[k];
      out[r].force[k] = force_scale * (*rows[r])[k];
    }
  }
  return out;
}

template <int N>
void fill_columns(const std::array<Wrench, 3>& wrenches, double sign, const double* screw, int n_v, double* J, int stride) {
  double column[6][N];
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < N; ++j) column[k][j] = screw[k * n_v + j];
  }
  for (int r = 0; r < 3; ++r) {
    const Wrench& w = wrenches[r];
    for (int j = 0; j < N; ++j) {
      J[r * stride + j] = sign * (w.torque[0] * column[0][j] + w.torque[1] * column[1][j] + w.torque[2] * column[2][j] +
                                  w.force[0] * column[3][j] + w.force[1] * column[4][j] + w.force[2] * column[5][j]);
    }
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
  const int n_v = w.n_v;
  double* screw = w.screw.data();
  const auto dofs = model.dofs();
  for (int i = 0; i < n_v; ++i) {
    const Vector3d axis = kinematics.axis_W.col(i);
    const bool revolute = dofs[i].kind == world::DofKind::Revolute;
    const Vector3d moment = revolute ? Vector3d(kinematics.origin_W.col(i).cross(axis)) : axis;
    for (int k = 0; k < 3; ++k) {
      screw[k * n_v + i] = revolute ? axis[k] : 0.0;
      screw[(3 + k) * n_v + i] = moment[k];
    }
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
    const auto at_a = make_wrenches(contact, contact.p_WA, 1.0), at_b = make_wrenches(contact, contact.p_WB, 1.0);
    double* J = out.values.data() + out.begin[i];
    for (int r = pair.run_begin; r < pair.run_end; ++r) {
      const Workspace::Impl::ColumnRun& run = w.column_runs[r];
      const bool both = run.moves_a && run.moves_b;
      const auto between = both ? make_wrenches(contact, contact.p_WA - contact.p_WB, 0.0) : at_a;
      const auto& wrenches = both ? between : run.moves_a ? at_a : at_b;
      const double sign = run.moves_a ? 1.0 : -1.0;
      int j = 0;
      for (; j + 4 <= run.count; j += 4) fill_columns<4>(wrenches, sign, screw + run.dof + j, n_v, J + run.column + j, pair.n_columns);
      for (; j + 2 <= run.count; j += 2) fill_columns<2>(wrenches, sign, screw + run.dof + j, n_v, J + run.column + j, pair.n_columns);
      for (; j < run.count; ++j) fill_columns<1>(wrenches, sign, screw + run.dof + j, n_v, J + run.column + j, pair.n_columns);
    }
  }
}

}  // namespace stiction::contact
