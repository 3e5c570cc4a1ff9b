#include "stiction/contact/derivatives.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>

#include "stiction/contact/curvature.hpp"
#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {
namespace {

using detail::ShapeData;
using detail::Vector3d;
using Eigen::Vector2d;
using PairData = Workspace::Impl::PairData;
using Run = Workspace::Impl::ColumnRun;

/// The values of four coordinates, for SIMD.
using Four = double __attribute__((vector_size(32)));

inline Four all(double x) { return Four{x, x, x, x}; }

inline Four load(const double* from) {
  Four x;
  std::memcpy(&x, from, sizeof x);
  return x;
}

inline void store(double* to, const Four& x) { std::memcpy(to, &x, sizeof x); }

/// A vector in the contact frame (n, t1, t2) for each of four coordinates, or one vector for all of them.
struct Vec {
  Four n, t1, t2;
};

inline Vec all(const Vector3d& v) { return {all(v[0]), all(v[1]), all(v[2])}; }
inline Vec operator+(const Vec& a, const Vec& b) { return {a.n + b.n, a.t1 + b.t1, a.t2 + b.t2}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.n - b.n, a.t1 - b.t1, a.t2 - b.t2}; }
inline Vec operator*(const Four& s, const Vec& a) { return {s * a.n, s * a.t1, s * a.t2}; }
inline Vec cross(const Vec& a, const Vec& b) { return {a.t1 * b.t2 - a.t2 * b.t1, a.t2 * b.n - a.n * b.t2, a.n * b.t1 - a.t1 * b.n}; }

/// Rows of the table of inputs and intermediate results; each row has one number per coordinate of the support.
enum Row {
  kSpinA = 0,  // angular velocity of A, then of B, due to the coordinate; 0 if it does not move the body
  kMoveA = 3,  // linear velocity at the witness point
  kSpinB = 6,
  kMoveB = 9,
  kSumSpinA = 12,  // sums of δq over the coordinates whose axes it does not move, those before first_above
  kSumMoveA = 15,
  kSumSpinB = 18,
  kSumMoveB = 21,
  kSpin = 24,        // angular velocity, for either body
  kFirstAbove = 27,  // first coordinate whose axis it turns: itself in a chain, the first rotation in a free object
  kMovesA = 28,      // 0 or 1
  kMovesB = 29,
  kTurnFrame = 30,  // W × f
  kTurnAxes = 33,   // f × w_j
  kSlipA = 36,      // s × f for both bodies
  kSlipB = 39,
  kCarryA = 42,  // c_j × f
  kCarryB = 45,
  kTurnMoment = 48,  // W × (spin λ_t2 n)
  kRows = 51
};

/// The data of one contact during the computation.
struct Pass {
  const Workspace::Impl& work;
  const PairData& pair;
  const Contact& contact;
  const Vector3d& lambda;
  const double* J;
  detail::Rolling rolling;
  Vector2d spin;
  Vector3d edge, side;                // Contact::edge_W and side_W of a point of a patch, in the contact frame
  Eigen::Matrix2d roll;               // rolling of this point, see the function that computes it
  double* rows;                       // kRows × padded
  int padded = 0;                     // columns, a multiple of four
  Vector3d moment;                    // spin λ_t2 n, in the contact frame
  Vector3d sum_spin[2], sum_move[2];  // sums of δq over all coordinates, for A and B

  double* row(int r) const { return rows + r * padded; }
  Vec get(int r, int j) const { return {load(row(r) + j), load(row(r + 1) + j), load(row(r + 2) + j)}; }
  void set(int r, int j, const Vec& v) const {
    store(row(r) + j, v.n);
    store(row(r + 1) + j, v.t1);
    store(row(r + 2) + j, v.t2);
  }
};

detail::Rolling calc_rolling(const Workspace::Impl& w, const world::Kinematics& kinematics, const PairData& pair, const Contact& contact) {
  const auto surface = [&](int index, const Vector3d& p_W, const Vector3d& m_W) {
    const auto& g = w.geometries[static_cast<std::size_t>(index)];
    if (g.shape.kind == detail::Kind::Sphere) return detail::Surface{g.shape.radius, g.shape.radius, Vector3d::Zero()};
    const ShapeData& shape = pair.in_plane ? g.extruded : g.shape;
    return detail::calc_surface(shape, kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.X_BG, p_W, m_W);
  };
  const auto radius = [&](int index) { return w.geometries[static_cast<std::size_t>(index)].shape.bounding_radius; };
  return detail::calc_rolling(surface(pair.a, contact.p_WA, -contact.nhat_BA_W), surface(pair.b, contact.p_WB, contact.nhat_BA_W), contact,
                              std::min(radius(pair.a), radius(pair.b)));
}

/// How far a point of a patch rolls over body I as the normal turns, in (t1, t2). Points of a capsule roll by its radius; points of a
/// generator of a cylinder roll around the cylinder.
Eigen::Matrix2d calc_roll(const Workspace::Impl& w, const world::Kinematics& kinematics, const PairData& pair, const Contact& contact) {
  if (contact.reference == PatchSide::None) return Eigen::Matrix2d::Zero();
  const auto& g = w.geometries[static_cast<std::size_t>(contact.reference == PatchSide::A ? pair.b : pair.a)];
  if (g.shape.kind == detail::Kind::Capsule) return g.shape.radius * Eigen::Matrix2d::Identity();
  if (g.shape.kind != detail::Kind::Cylinder || contact.kind != PatchPoint::Crossing) return Eigen::Matrix2d::Zero();
  const Vector3d axis = kinematics.X_WB[static_cast<std::size_t>(g.body)].R * g.X_BG.R.col(2);
  if (std::abs(axis.dot(contact.edge_W)) < 0.5) return Eigen::Matrix2d::Zero();  // the edge connects points of the cap
  const Vector3d t = axis.cross(contact.nhat_BA_W);                              // its length is that of the radial part of the normal
  const Vector2d in_frame(contact.t1_W.dot(t), contact.t2_W.dot(t));
  return g.shape.radius / (t.norm() * t.squaredNorm()) * in_frame * in_frame.transpose();
}

/// First column whose axis the coordinate `dof` turns: its own column in a chain. The three rotation coordinates of a free object turn each
/// other's axes in any order, because δθ is in body axes, R exp(δθ); for these it is the first rotation.
int first_above(const world::Model& model, int dof, int column) {
  const world::Dof& d = model.dofs()[static_cast<std::size_t>(dof)];
  if (d.owner_kind != world::BodyKind::Object || d.kind != world::DofKind::Revolute) return column;
  const world::ObjectInfo& object = model.objects()[static_cast<std::size_t>(d.owner)];
  return object.n_v == 6 ? column - (dof - object.v_begin - 3) : column;
}

void put(const Pass& pass, int r, int column, const Vector3d& v) {
  for (int x = 0; x < 3; ++x) pass.row(r + x)[column] = v[x];
}

void fill_coordinates(const world::Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& delta, Pass& pass) {
  Eigen::Matrix3d F;  // rows n, t1, t2
  F << pass.contact.nhat_BA_W.transpose(), pass.contact.t1_W.transpose(), pass.contact.t2_W.transpose();
  const int k = pass.pair.n_axes;
  std::fill_n(pass.rows, kRows * pass.padded, 0.0);
  const Vector3d zero = Vector3d::Zero();
  Vector3d spin[2] = {zero, zero}, move[2] = {zero, zero}, below_spin[2], below_move[2];
  for (int r = pass.pair.run_begin; r < pass.pair.run_end; ++r) {
    const Run& run = pass.work.column_runs[static_cast<std::size_t>(r)];
    for (int i = run.column; i < run.column + run.count; ++i) {
      const int index = run.axis + i - run.column;
      const auto& [revolute, dof, ratio] = pass.work.axes[static_cast<std::size_t>(index)];
      const double d = ratio * delta[dof];
      const Vector3d relative(pass.J[i], pass.J[i + k], pass.J[i + 2 * k]), axis = kinematics.axis_W.col(index);
      const Vector3d w = revolute ? Vector3d(F * axis) : zero;
      Vector3d a = relative;  // velocity of A's point; that of B's point is this minus `relative`
      if (run.moves_a && run.moves_b) {
        a = F * (revolute ? Vector3d(axis.cross(pass.contact.p_WA - kinematics.origin_W.col(index))) : axis);
      } else if (!run.moves_a) {
        a = zero;
      }
      const bool moves[2] = {run.moves_a, run.moves_b};
      const Vector3d c[2] = {a, a - relative};
      const int above = index < pass.work.n_v ? first_above(model, index, i) : i;
      for (int side = 0; side < 2; ++side) {
        if (above == i) below_spin[side] = spin[side], below_move[side] = move[side];
        const int to = side * kSpinB;
        put(pass, kSumSpinA + to, i, below_spin[side]);
        put(pass, kSumMoveA + to, i, below_move[side]);
        if (!moves[side]) continue;
        put(pass, kSpinA + to, i, w);
        put(pass, kMoveA + to, i, c[side]);
        spin[side] += d * w;
        move[side] += d * c[side];
      }
      put(pass, kSpin, i, w);
      pass.row(kFirstAbove)[i] = above;
      pass.row(kMovesA)[i] = run.moves_a;
      pass.row(kMovesB)[i] = run.moves_b;
    }
  }
  for (int side = 0; side < 2; ++side) pass.sum_spin[side] = spin[side], pass.sum_move[side] = move[side];
}

/// Motion of the contact frame and of the witness points due to four coordinates.
struct Follow {
  Vec frame;         // angular velocity of the contact frame (D.5)
  Vec s_a, s_b;      // slip of the witness points over the bodies (D.3), (D.9)
  Four beyond = {};  // change of φ in addition to J_n
};

inline Four dot(const Vec& a, const Vec& b) { return a.n * b.n + a.t1 * b.t1 + a.t2 * b.t2; }

/// Motion of a point of a patch (D.9): the normal turns with the body R of the reference face; the other body is I.
inline Follow follow_patch(const Pass& pass, int j) {
  const bool b_is_reference = pass.contact.reference == PatchSide::B;
  const Vec w_r = pass.get(b_is_reference ? kSpinB : kSpinA, j), w = pass.get(b_is_reference ? kSpinA : kSpinB, j) - w_r,
            v = pass.get(kMoveA, j) - pass.get(kMoveB, j);
  const Four dn1 = w_r.t2, dn2 = -w_r.t1, zero = all(0.0), phi = all(pass.contact.phi);
  const Four outwards = all(b_is_reference ? 1.0 : -1.0);
  const Vec u = outwards * Vec{v.n, v.t1 - phi * dn1, v.t2 - phi * dn2};  // velocity of the material point of I relative to R
  // (ω_R − ω_I) × (the outward normal of I)
  const Four turn1 = outwards * w.t2, turn2 = -outwards * w.t1;
  const auto roll = [&](int r) { return all(pass.roll(r, 0)) * turn1 + all(pass.roll(r, 1)) * turn2; };
  Vec s_i{zero, roll(0), roll(1)};
  Vec s_r{zero, u.t1 + s_i.t1, u.t2 + s_i.t2};
  if (pass.contact.kind == PatchPoint::Crossing) {
    const Vec edge = all(pass.edge), side = all(pass.side);
    s_i = s_i + (-dot(side, u + s_i) / dot(side, edge)) * edge;
    s_r = {zero, u.t1 + s_i.t1, u.t2 + s_i.t2};
  } else if (pass.contact.kind == PatchPoint::Corner) {
    const Vec face = all(pass.edge);
    s_i = {dot(face, u) / face.n - u.n, -u.t1, -u.t2};
    s_r = {zero, zero, zero};
  }
  const Vec frame{all(pass.spin[0]) * dn1 + all(pass.spin[1]) * dn2, -dn2, dn1};
  const Four beyond = outwards * s_i.n;
  return b_is_reference ? Follow{frame, s_i, s_r, beyond} : Follow{frame, s_r, s_i, beyond};
}

inline Follow follow(const Pass& pass, int j) {
  const Vec w_a = pass.get(kSpinA, j), w_b = pass.get(kSpinB, j), v = pass.get(kMoveA, j) - pass.get(kMoveB, j);
  const Four phi = all(pass.contact.phi);
  // [ω × n]_t = (ω_t2, −ω_t1)
  const Four rates[4] = {w_a.t2 - w_b.t2, w_b.t1 - w_a.t1, phi * w_b.t2 - v.t1, -phi * w_b.t1 - v.t2};
  const auto row = [&](int r) {
    const detail::Rolling& D = pass.rolling;
    return all(D(r, 0)) * rates[0] + all(D(r, 1)) * rates[1] + all(D(r, 2)) * rates[2] + all(D(r, 3)) * rates[3];
  };
  const Four dn1 = w_b.t2 + row(0), dn2 = row(1) - w_b.t1, zero = all(0.0);
  return {{all(pass.spin[0]) * dn1 + all(pass.spin[1]) * dn2, -dn2, dn1}, {zero, row(2), row(3)}, {zero, row(4), row(5)}};
}

/// d/dq_j of the velocity V = Σ c_i δq_i of the witness point of one body (D.7).
inline Vec velocity_change(const Pass& pass, int side, int j, const Vec& slip) {
  const int from = side * kSpinB;
  return cross(pass.get(kSpinA + from, j), all(pass.sum_move[side]) - pass.get(kSumMoveA + from, j)) +
         cross(pass.get(kSumSpinA + from, j), pass.get(kMoveA + from, j)) + cross(all(pass.sum_spin[side]), slip);
}

/// Computes D_w_q, and the rows from kTurnFrame on.
void calc_gaps(const Pass& pass, double* D_w) {
  const int k = pass.pair.n_axes;
  const bool of_patch = pass.contact.reference != PatchSide::None;
  const Vec f = all(pass.lambda), relative = all(Vector3d(pass.sum_move[0] - pass.sum_move[1]));
  for (int j = 0; j < k; j += 4) {
    const Follow go = of_patch ? follow_patch(pass, j) : follow(pass, j);
    Vec dw = velocity_change(pass, 0, j, go.s_a) - velocity_change(pass, 1, j, go.s_b) - cross(go.frame, relative);
    if (pass.contact.spin != 0) {
      const Vec turned = cross(pass.get(kSpinA, j), all(pass.sum_spin[0]) - pass.get(kSumSpinA, j)) -
                         cross(pass.get(kSpinB, j), all(pass.sum_spin[1]) - pass.get(kSumSpinB, j)) -
                         cross(go.frame, all(Vector3d(pass.sum_spin[0] - pass.sum_spin[1])));
      dw.t2 += all(pass.contact.spin) * turned.n;
      pass.set(kTurnMoment, j, cross(go.frame, all(pass.moment)));
    }
    const int n = std::min(4, k - j);
    for (int x = 0; x < n; ++x) {
      D_w[j + x] = dw.n[x] + pass.J[j + x] + go.beyond[x];
      D_w[k + j + x] = dw.t1[x];
      D_w[2 * k + j + x] = dw.t2[x];
    }
    pass.set(kTurnFrame, j, cross(go.frame, f));
    pass.set(kTurnAxes, j, cross(f, pass.get(kSpin, j)));
    pass.set(kSlipA, j, cross(go.s_a, f));
    pass.set(kSlipB, j, cross(go.s_b, f));
    pass.set(kCarryA, j, cross(pass.get(kMoveA, j), f));
    pass.set(kCarryB, j, cross(pass.get(kMoveB, j), f));
  }
}

/// Computes D_tau_q. Entry (i, j) is J_i·force + w_i·torque; force and torque differ for i below first_above and from first_above on (D.8).
void calc_wrenches(const Pass& pass, double* D_tau) {
  const int k = pass.pair.n_axes;
  const Four zero = all(0.0), one = all(1.0);
  for (int r = pass.pair.run_begin; r < pass.pair.run_end; ++r) {
    const Run& run = pass.work.column_runs[static_cast<std::size_t>(r)];
    const Four a = all(run.moves_a), b = all(run.moves_b);
    for (int j = 0; j < k; j += 4) {
      // The axes of the run turn with j only if j moves every body that the run moves.
      const Four together = (one - a * (one - load(pass.row(kMovesA) + j))) * (one - b * (one - load(pass.row(kMovesB) + j)));
      const Vec force = pass.get(kTurnFrame, j), turn = together * pass.get(kTurnAxes, j);
      const Vec slip = a * pass.get(kSlipA, j) - b * pass.get(kSlipB, j), carry = a * pass.get(kCarryA, j) - b * pass.get(kCarryB, j);
      const Four first = load(pass.row(kFirstAbove) + j);
      Vec moment{zero, zero, zero}, moment_turn{zero, zero, zero};
      if (pass.contact.spin != 0) {
        moment = (a - b) * pass.get(kTurnMoment, j);
        moment_turn = (a - b) * together * cross(all(pass.moment), pass.get(kSpin, j));
      }
      const int n = std::min(4, k - j);
      for (int i = run.column; i < run.column + run.count; ++i) {
        const Four above = all(i) >= first ? one : zero;
        const Vec F = force + above * turn, M = slip + moment + above * moment_turn + (one - above) * carry;
        const Four value = all(pass.J[i]) * F.n + all(pass.J[k + i]) * F.t1 + all(pass.J[2 * k + i]) * F.t2 +
                           all(pass.row(kSpin)[i]) * M.n + all(pass.row(kSpin + 1)[i]) * M.t1 + all(pass.row(kSpin + 2)[i]) * M.t2;
        double* to = D_tau + i * k + j;
        if (n == 4) {
          store(to, value);
        } else {
          for (int x = 0; x < n; ++x) to[x] = value[x];
        }
      }
    }
  }
}

/// Size of the largest pair that has joints which follow others, or a moment about the normal.
int calc_unfolded_size(const Workspace::Impl& w, std::span<const Contact> contacts) {
  int size = 0;
  for (const Contact& c : contacts) {
    const PairData& pair = w.pairs[static_cast<std::size_t>(c.pair)];
    if (pair.folded || c.spin != 0) size = std::max(size, 6 * pair.n_axes + pair.n_axes * (pair.n_axes + pair.n_columns));
  }
  return size;
}

/// Turns rows per axis (n_axes × n_columns) into rows per coordinate that moves the axes.
void fold_rows(const Workspace::Impl& w, const PairData& pair, const double* from, double* to) {
  std::fill_n(to, pair.n_columns * pair.n_columns, 0.0);
  for (int a = 0; a < pair.n_axes; ++a) {
    const auto& [row, ratio] = w.folds[static_cast<std::size_t>(pair.fold_begin + a)];
    for (int c = 0; c < pair.n_columns; ++c) to[row * pair.n_columns + c] += ratio * from[a * pair.n_columns + c];
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
                      std::span<const Vector3d> lambda, const Eigen::VectorXd& delta, std::span<const char> wanted, Workspace& work,
                      ContactDerivatives& out) {
  Workspace::Impl& w = work.impl();
  require_sizes(model, contacts, J, lambda, delta, w);
  if (!wanted.empty()) core::require_size("wanted", static_cast<long>(wanted.size()), static_cast<long>(contacts.size()));
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
  const auto rows_size = static_cast<std::size_t>(kRows * ((static_cast<int>(w.axes.size()) + 3) / 4 * 4));
  // After the rows, for a pair with joints that follow others: J, D_w and D_tau over its axes, and D_tau with folded columns. For a contact
  // with a moment about its normal: J of its point.
  out.scratch.resize(rows_size + static_cast<std::size_t>(calc_unfolded_size(w, contacts)));
  if (out.scratch.size() > rows_size) detail::fill_screws(w, kinematics);

  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!wanted.empty() && !wanted[i]) continue;
    const Contact& contact = contacts[i];
    const PairData& pair = w.pairs[static_cast<std::size_t>(contact.pair)];
    const auto in_frame = [&](const Vector3d& v_W) {
      return Vector3d(contact.nhat_BA_W.dot(v_W), contact.t1_W.dot(v_W), contact.t2_W.dot(v_W));
    };
    const int n = pair.n_axes;
    double* own_J = out.scratch.data() + rows_size;
    double *own_D_w = own_J + 3 * n, *own_D_tau = own_D_w + 3 * n, *half_folded = own_D_tau + n * n;
    const bool own = pair.folded || contact.spin != 0;
    if (own) detail::fill_axis_columns(w, contact, own_J);
    Pass pass{w,
              pair,
              contact,
              lambda[i],
              own ? own_J : J.values.data() + J.begin[i],
              contact.reference != PatchSide::None ? detail::Rolling() : calc_rolling(w, kinematics, pair, contact),
              detail::calc_frame_spin(contact, w.planar_axis),
              in_frame(contact.edge_W),
              in_frame(contact.side_W),
              calc_roll(w, kinematics, pair, contact),
              out.scratch.data(),
              (pair.n_axes + 3) / 4 * 4,
              {contact.spin * lambda[i][2], 0, 0},
              {},
              {}};
    fill_coordinates(model, kinematics, delta, pass);
    double *D_w = out.D_w_q.data() + J.begin[i], *D_tau = out.D_tau_q.data() + out.begin[i];
    calc_gaps(pass, pair.folded ? own_D_w : D_w);
    calc_wrenches(pass, pair.folded ? own_D_tau : D_tau);
    if (!pair.folded) continue;
    detail::fold_columns(w, pair, 3, own_D_w, D_w);
    detail::fold_columns(w, pair, n, own_D_tau, half_folded);
    fold_rows(w, pair, half_folded, D_tau);
  }
}

}  // namespace stiction::contact
