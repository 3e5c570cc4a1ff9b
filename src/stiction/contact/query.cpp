#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stiction/contact/workspace.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {

using detail::Kind;
using Eigen::Vector3d;

namespace {

void require_match(const Workspace::Impl& w, const world::Model& model, const world::Kinematics& kinematics) {
  core::require_size("work.pairs", static_cast<long>(w.pairs.size()), static_cast<long>(model.pairs().size()));
  core::require_size("kinematics.X_WB", static_cast<long>(kinematics.X_WB.size()), static_cast<long>(model.bodies().size()));
}

void require_pair(const Workspace::Impl& w, int pair) {
  if (pair < 0 || pair >= static_cast<int>(w.pairs.size())) {
    core::throw_invalid("pair", std::to_string(pair), fmt::format("an index of one of the {} pairs", w.pairs.size()));
  }
}

constexpr std::uint64_t make_id(int pair, int point = 0) { return (static_cast<std::uint64_t>(pair) << 8) + static_cast<unsigned>(point); }

/// Safety margin above the largest error of a polytope distance [m]: a pair whose separation exceeds its limit by this is out of reach.
constexpr double kPartedBy = 1e-8;

/// Clears the patch fields that an earlier contact left in this element. Only points of a patch use these fields.
inline void forget_patch(Contact& c) {
  c.spin = 0;
  if (c.reference == PatchSide::None) return;
  c.reference = PatchSide::None;
  c.kind = PatchPoint::Vertex;
  c.edge_W.setZero();
  c.side_W.setZero();
}

void require_length(std::string_view field, double value) {
  if (std::isnan(value)) core::throw_invalid(field, "nan", "a length [m]");
}

}  // namespace

void Workspace::Impl::place(int geometry, const world::Kinematics& kinematics) {
  const GeometryData& g = geometries[geometry];
  const world::Pose& X_WB = kinematics.X_WB[g.body];
  const Vector3d center = X_WB * g.p_BCenter;
  center_x[geometry] = center.x();
  center_y[geometry] = center.y();
  center_z[geometry] = center.z();
  if (g.shape.kind != Kind::Sphere) X_WG[geometry] = X_WB * g.X_BG;
}

void Workspace::Impl::set_kinematics(const world::Kinematics& kinematics) {
  ++stamp;
  for (int i = 0; i < static_cast<int>(geometries.size()); ++i) place(i, kinematics);
}

void Workspace::Impl::set_kinematics(const world::Kinematics& kinematics, std::span<const int> pair_indices) {
  if (2 * pair_indices.size() >= geometries.size()) return set_kinematics(kinematics);
  ++stamp;
  for (const int i : pair_indices) {
    place(pairs[i].a, kinematics);
    place(pairs[i].b, kinematics);
  }
}

double Workspace::Impl::distance2(int pair) const {
  const PairData& p = pairs[pair];
  const double x = center_x[p.a] - center_x[p.b], y = center_y[p.a] - center_y[p.b], z = center_z[p.a] - center_z[p.b];
  return x * x + y * y + z * z;
}

double Workspace::Impl::lower_bound(int pair) const {
  const PairData& p = pairs[pair];
  if (p.half_space < 0 && !p.in_slabs) return std::sqrt(distance2(pair)) - radius_sum[pair];
  const world::Pose& X = X_WG[p.second];
  const Vector3d center(center_x[p.first], center_y[p.first], center_z[p.first]);
  const double radius = geometries[p.first].shape.bounding_radius;
  if (p.half_space >= 0) return X.R.col(2).dot(center - X.p) - radius;
  return ((X.R.transpose() * (center - X.p)).cwiseAbs() - geometries[p.second].shape.half).maxCoeff() - radius;
}

bool Workspace::Impl::is_beyond(int pair, double limit) const {
  const PairData& p = pairs[pair];
  if ((p.half_space >= 0 || p.in_slabs) && lower_bound(pair) >= limit) return true;
  return p.hulls && parted_by(pair) >= limit + kPartedBy;
}

double Workspace::Impl::parted_by(int pair) const {
  const PairData& p = pairs[pair];
  const world::Pose &X_WA = X_WG[p.first], &X_WB = X_WG[p.second];
  const Vector3d n = X_WA.R * parting[pair];
  return -support(shape_of(p, p.first), X_WA, -n) - support(shape_of(p, p.second), X_WB, n);
}

int Workspace::Impl::guess_nearest_hulls(std::span<const int> pair_indices) const {
  int out = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const int i : pair_indices) {
    const double bound = pairs[i].hulls ? std::max(parted_by(i), lower_bound(i)) : least;
    if (bound < least) least = bound, out = i;
  }
  return out;
}

// Removes the out-of-plane part of an answer, which comes from rounding or from an arbitrary choice along extruded edges.
void Workspace::Impl::flatten(const PairData& p, Distance& out) const {
  const int k = *planar_axis;
  if (std::abs(out.nhat_BA_W[k]) > 1e-5) return;  // a mesh whose sides are not perpendicular to the plane
  const double height = k == 0 ? center_x[p.a] : k == 1 ? center_y[p.a] : center_z[p.a];
  out.nhat_BA_W[k] = 0;
  out.nhat_BA_W.normalize();
  Vector3d middle = 0.5 * (out.p_WA + out.p_WB);
  middle[k] = height;
  out.p_WA = middle + 0.5 * out.phi * out.nhat_BA_W;
  out.p_WB = middle - 0.5 * out.phi * out.nhat_BA_W;
}

const detail::ShapeData& Workspace::Impl::shape_of(const PairData& p, int geometry) const {
  const GeometryData& g = geometries[geometry];
  return p.in_plane && g.shape.kind != Kind::Sphere ? g.extruded : g.shape;
}

const world::Pose& Workspace::Impl::pose_of(int g) {
  if (geometries[g].shape.kind == Kind::Sphere) X_WG[g].p = {center_x[g], center_y[g], center_z[g]};
  return X_WG[g];
}

void Workspace::Impl::narrow(int pair, double limit, Distance& out) {
  context.limit = limit;
  const PairData& p = pairs[pair];
  if (!p.kernel) {
    detail::sphere_sphere({center_x[p.a], center_y[p.a], center_z[p.a]}, p.radius_a, {center_x[p.b], center_y[p.b], center_z[p.b]},
                          p.radius_b, coincident_normal, out);
    return;
  }
  p.kernel(shape_of(p, p.first), pose_of(p.first), shape_of(p, p.second), pose_of(p.second), context, out);
  if (p.hulls) parting[pair] = X_WG[p.first].R.transpose() * out.nhat_BA_W;
  if (p.first != p.a) detail::swap_roles(out);
  if (p.in_plane) flatten(p, out);
}

int Workspace::Impl::fill_patch(int pair, double limit, double near, Contact* out) {
  const PairData& p = pairs[pair];
  const detail::Placed first{shape_of(p, p.first), X_WG[p.first], geometries[p.first].shape};
  const detail::Placed second{shape_of(p, p.second), X_WG[p.second], geometries[p.second].shape};
  detail::PatchOptions options{.limit = limit};
  if (planar_axis) {
    options.planar_axis = *planar_axis;
    options.planar_level = (*planar_axis == 0 ? center_x : *planar_axis == 1 ? center_y : center_z)[p.first];
  }
  const bool swapped = p.first != p.a;
  Distance d;
  bool done = false;
  if (p.boxes) {
    const bool certain = box_box(first.shape, first.X_W, second.shape, second.X_W, near, d);
    if (!(d.phi < near)) return 0;
    done = calc_patch(first, second, d, certain, options, patch_scratch, patch);
  }
  if (!done) {
    narrow(pair, near, d);
    if (!(d.phi < near)) return 0;
    if (swapped) detail::swap_roles(d);
    calc_patch(first, second, d, true, options, patch_scratch, patch);
  }
  for (int i = 0; i < patch.n; ++i) {
    detail::Patch::Point& from = patch.points[i];
    Contact& to = out[i];
    if (swapped) {
      detail::swap_roles(from.at);
      if (from.reference != PatchSide::None) from.reference = from.reference == PatchSide::A ? PatchSide::B : PatchSide::A;
    }
    to.pair = pair;
    to.id = make_id(pair, from.code);
    to.phi = from.at.phi;
    to.p_WA = from.at.p_WA;
    to.p_WB = from.at.p_WB;
    to.friction = p.friction;
    to.spin = 0;
    to.reference = from.reference;
    to.kind = from.kind;
    to.edge_W = from.edge_W;
    to.side_W = from.side_W;
    detail::set_frame(from.at.nhat_BA_W, planar_axis, to);
  }
  return patch.n;
}

int Workspace::Impl::fill(int pair, double limit, double near, Contact* out) {
  const PairData& p = pairs[pair];
  if (is_beyond(pair, near)) return 0;
  if (p.patch) return fill_patch(pair, limit, near, out);
  Distance d;
  narrow(pair, near, d);
  if (!(d.phi < near)) return 0;
  out->pair = pair;
  out->id = make_id(pair);
  out->phi = d.phi;
  out->p_WA = d.p_WA;
  out->p_WB = d.p_WB;
  out->friction = p.friction;
  forget_patch(*out);
  detail::set_frame(d.nhat_BA_W, planar_axis, *out);
  return 1;
}

// Same as fill(), for two spheres whose centres are `length` apart.
inline bool Workspace::Impl::fill_spheres(int pair, double limit, double length, double inverse_length, Contact& out) {
  const PairData& p = pairs[pair];
  const double phi = length - radius_sum[pair];
  if (!(phi < limit)) return false;
  const Vector3d a(center_x[p.a], center_y[p.a], center_z[p.a]), b(center_x[p.b], center_y[p.b], center_z[p.b]);
  const Vector3d n = length > 0 ? Vector3d((a - b) * inverse_length) : coincident_normal;
  out.pair = pair;
  out.id = make_id(pair);
  out.phi = phi;
  out.p_WA = a - p.radius_a * n;
  out.p_WB = b + p.radius_b * n;
  out.friction = p.friction;
  forget_patch(out);
  detail::set_frame(n, planar_axis, out);
  return true;
}

namespace {

/// Computes the squared distances of the bounding centres of all pairs.
void measure_centers(Workspace::Impl& w) {
  double* d2 = w.center_distance2.data();
  const double *x = w.center_x.data(), *y = w.center_y.data(), *z = w.center_z.data();
  for (const Workspace::Impl::BroadRun& run : w.broad_runs) {
    const double cx = x[run.fixed], cy = y[run.fixed], cz = z[run.fixed];
    const double *ox = x + run.other, *oy = y + run.other, *oz = z + run.other;
    double* to = d2 + run.begin;
    for (int k = 0; k < run.count; ++k) {
      const double dx = cx - ox[k], dy = cy - oy[k], dz = cz - oz[k];
      to[k] = dx * dx + dy * dy + dz * dz;
    }
  }
}

/// Lists the pairs that may be nearer than the distance from which they are left out, by index, with the distances of their centres.
/// @returns the number of these pairs
int find_candidates(const QueryOptions& options, Workspace::Impl& w) {
  const int n_p = static_cast<int>(w.pairs.size());
  const double *sum = w.radius_sum.data(), *max_distance = w.max_distance.data(), *d2 = w.center_distance2.data();
  double *excess = w.excess.data(), *near = w.left_out.data();
  const double margin = options.margin, cutoff = options.cutoff;
  for (int i = 0; i < n_p; ++i) near[i] = std::min(max_distance[i] + margin, cutoff);
  for (std::size_t i = 0; i < options.near.size(); ++i) near[i] = std::min(near[i], options.near[i]);
  for (int i = 0; i < n_p; ++i) {
    const double reach = (sum[i] + near[i]) * (1.0 + 1e-12);
    excess[i] = d2[i] - reach * std::abs(reach);
  }
  int* candidates = w.candidates.data();
  int n = 0;
  for (int i = 0; i < n_p; ++i) {
    candidates[n] = i;
    n += excess[i] <= 0.0 ? 1 : 0;
  }
  double* length = w.center_distance.data();
  for (int k = 0; k < n; ++k) length[k] = d2[candidates[k]];
  Eigen::Map<Eigen::ArrayXd> lengths(length, n), inverse_lengths(w.center_inverse.data(), n);
  lengths = lengths.sqrt();
  inverse_lengths = lengths.inverse();
  return n;
}

/// Keeps only the nearest contacts, up to the allowed number.
void keep_nearest(int most, Workspace::Impl& w, std::vector<Contact>& out) {
  w.nearest.clear();
  for (const Contact& c : out) w.nearest.emplace_back(c.phi, c.id);
  std::nth_element(w.nearest.begin(), w.nearest.begin() + most, w.nearest.end());
  const std::pair<double, std::uint64_t> first_dropped = w.nearest[most];
  std::erase_if(out, [&](const Contact& c) { return std::pair(c.phi, c.id) >= first_dropped; });
}

}  // namespace

void query(const world::Model& model, const world::Kinematics& kinematics, const QueryOptions& options, Workspace& work,
           std::vector<Contact>& out) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  core::require_nonnegative("margin", options.margin);
  if (!options.near.empty()) core::require_size("near", static_cast<long>(options.near.size()), static_cast<long>(w.pairs.size()));
  require_length("cutoff", options.cutoff);
  w.set_kinematics(kinematics);
  measure_centers(w);
  const int n = find_candidates(options, w);

  out.reserve(w.pairs.size() + std::min(w.n_patch_points, Workspace::Impl::kReservedContacts));
  const int* candidates = w.candidates.data();
  auto slots = static_cast<std::size_t>(n);
  for (int k = 0; k < n && w.n_patch_points > 0; ++k) slots += static_cast<std::size_t>(w.slots(candidates[k]) - 1);
  out.resize(slots);
  Contact* next = out.data();
  const double *length = w.center_distance.data(), *inverse_length = w.center_inverse.data(), *near = w.left_out.data();
  for (int k = 0; k < n; ++k) {
    const int i = candidates[k];
    const double limit = std::min(w.max_distance[i] + options.margin, options.cutoff);
    next += w.pairs[i].kernel ? w.fill(i, limit, near[i], next) : w.fill_spheres(i, near[i], length[k], inverse_length[k], *next);
  }
  out.resize(static_cast<std::size_t>(next - out.data()));

  const std::optional<int>& most = model.scene().max_contacts;
  if (most && static_cast<int>(out.size()) > *most) keep_nearest(*most, w, out);
}

// Two rows of three numbers, and not one of four, because the cone solver knows cones of three only.
void split_turning(const world::Model& model, std::vector<Contact>& contacts) {
  constexpr std::uint64_t kTwin = 1ull << 50;  // beyond every pair
  if (model.planar_axis()) return;
  const std::size_t n = contacts.size();
  for (std::size_t i = 0; i < n; ++i) {
    const world::Pair& pair = model.pairs()[static_cast<std::size_t>(contacts[i].pair)];
    if (pair.torsional == 0 || pair.friction == 0) continue;
    contacts[i].spin = pair.torsional / pair.friction;
    Contact& twin = contacts.emplace_back(contacts[i]);
    twin.spin = -twin.spin;
    twin.id += kTwin;
  }
}

void query_pairs(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double cutoff,
                 Workspace& work, std::vector<Contact>& out) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  require_length("cutoff", cutoff);
  std::size_t slots = 0;
  for (const int i : pair_indices) {
    require_pair(w, i);
    slots += static_cast<std::size_t>(w.slots(i));
  }
  w.set_kinematics(kinematics, pair_indices);
  out.resize(slots);
  Contact* next = out.data();
  for (const int i : pair_indices) {
    const double reach = (w.radius_sum[i] + cutoff) * (1.0 + 1e-12);
    if (w.distance2(i) <= reach * std::abs(reach)) next += w.fill(i, cutoff, cutoff, next);
  }
  out.resize(static_cast<std::size_t>(next - out.data()));
}

double calc_min_distance(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices,
                         double stop_below, Workspace& work) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  require_length("stop_below", stop_below);
  for (const int i : pair_indices) require_pair(w, i);
  w.set_kinematics(kinematics);
  double best = std::numeric_limits<double>::infinity();
  Distance d;
  // The pair of hulls that looks nearest is measured first, because its distance is likely to put the other pairs out of reach. It may end
  // the search only at its place in the order, so the answer does not depend on which pair was measured first.
  const int nearest = w.guess_nearest_hulls(pair_indices);
  if (nearest >= 0) w.narrow(nearest, std::numeric_limits<double>::infinity(), d);
  const double phi_nearest = nearest >= 0 ? d.phi : best;
  best = phi_nearest;
  for (const int i : pair_indices) {
    const Workspace::Impl::PairData& p = w.pairs[i];
    const double limit = std::max(best, stop_below);
    double phi = phi_nearest;
    if (i != nearest) {
      const double d2 = w.distance2(i), reach = (w.radius_sum[i] + limit) * (1.0 + 1e-12);
      if (p.half_space < 0 && d2 > reach * std::abs(reach)) continue;
      if (p.kernel) {
        if (w.is_beyond(i, limit)) continue;
        w.narrow(i, limit, d);
        phi = d.phi;
      } else {
        phi = std::sqrt(d2) - w.radius_sum[i];
      }
    }
    if (phi < stop_below) return phi;
    best = std::min(best, phi);
  }
  return best;
}

bool any_nearer(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> pair_indices, double distance,
                Workspace& work) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  require_length("distance", distance);
  for (const int i : pair_indices) require_pair(w, i);
  w.set_kinematics(kinematics);
  Distance d;
  return std::any_of(pair_indices.begin(), pair_indices.end(), [&](int i) {
    const Workspace::Impl::PairData& p = w.pairs[i];
    const double d2 = w.distance2(i), reach = (w.radius_sum[i] + distance) * (1.0 + 1e-12);
    if (p.half_space < 0 && d2 > reach * std::abs(reach)) return false;
    if (!p.kernel) return std::sqrt(d2) - w.radius_sum[i] < distance;
    if (w.is_beyond(i, distance)) return false;
    w.narrow(i, distance, d);
    return d.phi < distance;
  });
}

Distance pair_distance(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  require_pair(w, pair);
  w.set_kinematics(kinematics, std::span(&pair, 1));
  Distance out;
  w.narrow(pair, std::numeric_limits<double>::infinity(), out);
  return out;
}

Gaps::Gaps(const world::Model& model, const world::Kinematics& kinematics, Workspace& work) : kinematics_(kinematics), work_(work.impl()) {
  require_match(work_, model, kinematics);
}

inline void Gaps::place(int geometry) {
  if (std::exchange(work_.placed[geometry], stamp_) != stamp_) work_.place(geometry, kinematics_);
}

double Gaps::calc(int pair, double enough) {
  require_pair(work_, pair);
  if (work_.stamp != stamp_) stamp_ = ++work_.stamp;
  place(work_.pairs[pair].a);
  place(work_.pairs[pair].b);
  const double bound = work_.lower_bound(pair);
  if (bound >= enough) return bound;
  if (work_.is_beyond(pair, enough)) return enough;
  Distance out;
  work_.narrow(pair, enough, out);
  return std::min(out.phi, enough);
}

double calc_pair_lower_bound(const world::Model& model, const world::Kinematics& kinematics, int pair, Workspace& work) {
  Workspace::Impl& w = work.impl();
  require_match(w, model, kinematics);
  require_pair(w, pair);
  w.set_kinematics(kinematics, std::span(&pair, 1));
  return w.lower_bound(pair);
}

}  // namespace stiction::contact
