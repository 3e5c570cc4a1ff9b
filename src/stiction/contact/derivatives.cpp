#include "stiction/contact/derivatives.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "stiction/contact/curvature.hpp"
#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {
namespace {

using detail::ShapeData;
using detail::Vector3d;
using Eigen::Vector2d;
using Column = detail::SupportColumn;
using Twist = detail::PointTwist;
using PairData = Workspace::Impl::PairData;
using Run = Workspace::Impl::ColumnRun;

/// One contact on its way through the computation.
struct Pass {
  const Workspace::Impl& work;
  const PairData& pair;
  const Contact& contact;
  const Vector3d& lambda;
  const double* J;
  detail::Rolling rolling;
  Vector2d spin;
  std::span<Column> columns;
  double* w[3];        // angular part of the columns, a row of k for each component
  Twist sum_a, sum_b;  // of δq over all coordinates
};

struct Surfaces {
  detail::Surface a, b;
  double length = 0;
};

Surfaces calc_surfaces(const Workspace::Impl& w, const world::Kinematics& kinematics, const PairData& pair, const Contact& contact) {
  const auto one = [&](int index, const Vector3d& p_W, const Vector3d& m_W) {
    const auto& g = w.geometries[static_cast<std::size_t>(index)];
    if (g.shape.kind == detail::Kind::Sphere) return detail::Surface{g.shape.radius, g.shape.radius, Vector3d::Zero()};
    const ShapeData& shape = pair.in_plane ? g.extruded : g.shape;
    return detail::calc_surface(shape, kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.X_BG, p_W, m_W);
  };
  const auto radius = [&](int index) { return w.geometries[static_cast<std::size_t>(index)].shape.bounding_radius; };
  return {one(pair.a, contact.p_WA, -contact.nhat_BA_W), one(pair.b, contact.p_WB, contact.nhat_BA_W),
          std::min(radius(pair.a), radius(pair.b))};
}

/// Coordinates of a free object's rotation turn each other's axes, whatever their order: δθ is in body axes, and R exp(δθ).
int first_above(const world::Model& model, int dof, int column) {
  const world::Dof& d = model.dofs()[static_cast<std::size_t>(dof)];
  if (d.owner_kind != world::BodyKind::Object || d.kind != world::DofKind::Revolute) return column;
  const world::ObjectInfo& object = model.objects()[static_cast<std::size_t>(d.owner)];
  return object.n_v == 6 ? column - (dof - object.v_begin - 3) : column;
}

void fill_columns(const world::Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& delta, Pass& pass) {
  Eigen::Matrix3d F;  // rows n, t1, t2
  F << pass.contact.nhat_BA_W.transpose(), pass.contact.t1_W.transpose(), pass.contact.t2_W.transpose();
  const int k = pass.pair.n_columns;
  for (int r = pass.pair.run_begin; r < pass.pair.run_end; ++r) {
    const Run& run = pass.work.column_runs[static_cast<std::size_t>(r)];
    for (int i = run.column; i < run.column + run.count; ++i) {
      const int dof = run.dof + i - run.column;
      const bool revolute = model.dofs()[static_cast<std::size_t>(dof)].kind == world::DofKind::Revolute;
      Twist move{Vector3d::Zero(), {pass.J[i], pass.J[i + k], pass.J[i + 2 * k]}};
      const Vector3d relative = move.v;
      if (revolute) move.w = F * kinematics.axis_W.col(dof);
      Column& c = pass.columns[static_cast<std::size_t>(i)];
      c = {};
      if (run.moves_a && run.moves_b) {
        const Vector3d axis = kinematics.axis_W.col(dof);
        move.v = F * (revolute ? Vector3d(axis.cross(pass.contact.p_WA - kinematics.origin_W.col(dof))) : axis);
        c.b = {move.w, move.v - relative};
      } else if (!run.moves_a) {
        c.b = {move.w, -relative};
      }
      if (run.moves_a) c.a = move;
      c.first_above = first_above(model, dof, i);
      c.sum_a = pass.sum_a;
      c.sum_b = pass.sum_b;
      pass.sum_a.w += delta[dof] * c.a.w, pass.sum_a.v += delta[dof] * c.a.v;
      pass.sum_b.w += delta[dof] * c.b.w, pass.sum_b.v += delta[dof] * c.b.v;
      for (int x = 0; x < 3; ++x) pass.w[x][i] = move.w[x];
    }
  }
}

/// How frame and points follow one coordinate.
struct Follow {
  Vector3d frame;     // angular velocity of the contact frame (D.5)
  Vector3d s_a, s_b;  // slip of the witness points over the bodies (D.3)
};

Follow follow(const Pass& pass, const Column& c) {
  const auto turn = [](const Twist& t) { return Vector2d(t.w[2], -t.w[1]); };  // [ω × n]_t
  const Vector2d turn_b = turn(c.b);
  Eigen::Vector4d rates;
  rates << turn(c.a) - turn_b, pass.contact.phi * turn_b - (c.a.v - c.b.v).tail<2>();
  const Eigen::Matrix<double, 6, 1> moved = pass.rolling * rates;
  const Vector2d dn = turn_b + moved.head<2>();
  return {{pass.spin.dot(dn), -dn[1], dn[0]}, {0, moved[2], moved[3]}, {0, moved[4], moved[5]}};
}

/// d/dq_j of the velocity V = Σ c_i δq_i of the witness point of one body (D.7).
/// @param below  the part of the sum over the coordinates whose axes j leaves alone
Vector3d velocity_change(const Twist& column, const Twist& sum, const Twist& below, const Vector3d& slip) {
  return column.w.cross(sum.v - below.v) + below.w.cross(column.v) + sum.w.cross(slip);
}

/// Row i of column j is J_i·force + w_i·torque, with its own force and torque below and from first_above on (D.8).
struct Wrench {
  Vector3d force, torque;
};

void fill(const Pass& pass, const Wrench& wrench, int begin, int end, double* column) {
  const int k = pass.pair.n_columns;
  const double *n = pass.J, *t1 = n + k, *t2 = t1 + k, *x = pass.w[0], *y = pass.w[1], *z = pass.w[2];
  const double f0 = wrench.force[0], f1 = wrench.force[1], f2 = wrench.force[2];
  const double m0 = wrench.torque[0], m1 = wrench.torque[1], m2 = wrench.torque[2];
  for (int i = begin; i < end; ++i) column[i] = (n[i] * f0 + t1[i] * f1 + t2[i] * f2) + (x[i] * m0 + y[i] * m1 + z[i] * m2);
}

void calc_column(const Pass& pass, int j, const Run& moved, double* D_tau, double* D_w) {
  const int k = pass.pair.n_columns;
  const Column& c = pass.columns[static_cast<std::size_t>(j)];
  const Column& above = pass.columns[static_cast<std::size_t>(c.first_above)];
  const Follow go = follow(pass, c);

  Vector3d dw = velocity_change(c.a, pass.sum_a, above.sum_a, go.s_a) - velocity_change(c.b, pass.sum_b, above.sum_b, go.s_b) -
                go.frame.cross(pass.sum_a.v - pass.sum_b.v);
  dw[0] += pass.J[j];
  for (int r = 0; r < 3; ++r) D_w[r * k + j] = dw[r];

  const Vector3d& f = pass.lambda;
  const Vector3d df = go.frame.cross(f);
  const Vector3d turned = f.cross(moved.moves_a ? c.a.w : c.b.w);  // f·(w_j × c_i) = c_i·(f × w_j)
  for (int r = pass.pair.run_begin; r < pass.pair.run_end; ++r) {
    const Run& run = pass.work.column_runs[static_cast<std::size_t>(r)];
    const bool together = (moved.moves_a || !run.moves_a) && (moved.moves_b || !run.moves_b);  // j moves all that i moves
    Vector3d below = Vector3d::Zero(), slip = Vector3d::Zero();
    if (run.moves_a) below += c.a.v, slip += go.s_a;
    if (run.moves_b) below -= c.b.v, slip -= go.s_b;
    const int end = run.column + run.count, split = std::clamp(c.first_above, run.column, end);
    fill(pass, {df, (below + slip).cross(f)}, run.column, split, D_tau);
    fill(pass, {together ? Vector3d(df + turned) : df, slip.cross(f)}, split, end, D_tau);
  }
}

void require_sizes(const world::Model& model, std::span<const Contact> contacts, const Jacobians& J, std::span<const Vector3d> lambda,
                   const Eigen::VectorXd& delta, const Workspace::Impl& w) {
  core::require_size("work.pairs", static_cast<long>(w.pairs.size()), static_cast<long>(model.pairs().size()));
  core::require_size("delta", delta.size(), model.n_v());
  core::require_size("lambda", static_cast<long>(lambda.size()), static_cast<long>(contacts.size()));
  core::require_size("J.begin", static_cast<long>(J.begin.size()), static_cast<long>(contacts.size()) + 1);
  for (const Contact& c : contacts) {
    if (c.pair >= 0 && c.pair < static_cast<int>(w.pairs.size())) continue;
    core::throw_invalid("contact.pair", std::to_string(c.pair), "an index of Model::pairs()");
  }
}

}  // namespace

void calc_derivatives(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, const Jacobians& J,
                      std::span<const Vector3d> lambda, const Eigen::VectorXd& delta, Workspace& work, ContactDerivatives& out) {
  const Workspace::Impl& w = work.impl();
  require_sizes(model, contacts, J, lambda, delta, w);
  out.begin.resize(contacts.size() + 1);
  int size = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int k = w.pairs[static_cast<std::size_t>(contacts[i].pair)].n_columns;
    out.begin[i] = size;
    size += k * k;
  }
  out.begin[contacts.size()] = size;
  out.D_tau_q.resize(static_cast<std::size_t>(size));
  out.D_w_q.resize(J.values.size());
  out.columns.resize(static_cast<std::size_t>(model.n_v()));
  out.angular.resize(3 * static_cast<std::size_t>(model.n_v()));

  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const PairData& pair = w.pairs[static_cast<std::size_t>(contact.pair)];
    const int k = pair.n_columns;
    const Surfaces surfaces = calc_surfaces(w, kinematics, pair, contact);
    double* angular = out.angular.data();
    Pass pass{w,
              pair,
              contact,
              lambda[i],
              J.values.data() + J.begin[i],
              detail::calc_rolling(surfaces.a, surfaces.b, contact, surfaces.length),
              detail::calc_frame_spin(contact, w.planar_axis),
              out.columns,
              {angular, angular + k, angular + 2 * k},
              {},
              {}};
    fill_columns(model, kinematics, delta, pass);
    for (int r = pair.run_begin; r < pair.run_end; ++r) {
      const Run& run = w.column_runs[static_cast<std::size_t>(r)];
      for (int j = run.column; j < run.column + run.count; ++j) {
        calc_column(pass, j, run, out.D_tau_q.data() + out.begin[i] + k * j, out.D_w_q.data() + J.begin[i]);
      }
    }
  }
}

}  // namespace stiction::contact
