#include "stiction/contact/patch_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace stiction::contact::detail {
namespace {

/// Tilt between the bodies [rad] for the choice among many points: the points that would touch first at this tilt stay.
constexpr double kTilt = 0.1;

class Reducer {
 public:
  Reducer(const PatchFrame& frame, const PatchOptions& options, PatchScratch& scratch)
      : frame_(frame), options_(options), scratch_(scratch), points_(scratch.gathered) {}

  void run(Patch& out);

 private:
  void flatten();
  void keep_extremes_of_section();
  void keep_most();

  const Patch::Point& point(int i) const { return points_[static_cast<std::size_t>(i)]; }

  const PatchFrame& frame_;
  const PatchOptions& options_;
  PatchScratch& scratch_;
  std::vector<Patch::Point>& points_;
};

/// Moves the points into the plane of a planar model and removes the out-of-plane part of their normals. In the plane a face is an edge,
/// and an edge is a corner.
void Reducer::flatten() {
  const int k = options_.planar_axis;
  for (Patch::Point& p : points_) {
    Vector3d& n = p.at.nhat_BA_W;
    if (std::abs(n[k]) > 1e-5) continue;  // a mesh whose sides are not perpendicular to the plane
    n[k] = 0;
    n.normalize();
    Vector3d middle = 0.5 * (p.at.p_WA + p.at.p_WB);
    middle[k] = options_.planar_level;
    p.at.p_WA = middle + 0.5 * p.at.phi * n;
    p.at.p_WB = middle - 0.5 * p.at.phi * n;
  }
  std::sort(points_.begin(), points_.end(), [](const Patch::Point& p, const Patch::Point& q) { return p.code < q.code; });
  std::size_t n = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    bool seen = false;
    for (std::size_t j = 0; j < n && !seen; ++j) {
      seen = (points_[i].at.p_WA - points_[j].at.p_WA).norm() + (points_[i].at.p_WB - points_[j].at.p_WB).norm() <= frame_.same;
    }
    if (!seen) points_[n++] = points_[i];
  }
  points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(n), points_.end());
  if (points_.size() > 2) keep_extremes_of_section();
}

/// Keeps the two end points along the reference face and the lowest point.
void Reducer::keep_extremes_of_section() {
  const Vector3d t = Vector3d::Unit(options_.planar_axis).cross(frame_.m);
  const auto along = [&](const Patch::Point& p) { return t.dot(p.at.p_WA); };
  const auto lower = [&](const Patch::Point& p, const Patch::Point& q) { return p.at.phi < q.at.phi - frame_.same; };
  const auto shorter = [&](const Patch::Point& p, const Patch::Point& q) { return along(p) < along(q) - frame_.same; };
  // Compare positions, not codes: codes of large meshes may coincide.
  const auto least = std::min_element(points_.begin(), points_.end(), shorter);
  const auto most = std::max_element(points_.begin(), points_.end(), shorter);
  const auto lowest = std::min_element(points_.begin(), points_.end(), lower);
  const double level = lowest->at.phi + frame_.same;
  const bool is_end = least->at.phi <= level || most->at.phi <= level;
  auto end = points_.begin();
  for (auto p = points_.begin(); p != points_.end(); ++p) {
    if (p != least && p != most && (is_end || p != lowest)) continue;
    if (p != end) *end = *p;
    ++end;
  }
  points_.erase(end, points_.end());
}

/// Keeps the lowest point, and the points that would be lowest if the bodies tilted by kTilt in evenly spread directions fixed in the
/// reference. At a tie the point with the lower code stays, so that rounding does not decide.
void Reducer::keep_most() {
  std::vector<int>& order = scratch_.order;  // points by code; the kept points come first
  order.resize(points_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [this](int i, int j) { return point(i).code < point(j).code; });
  std::ptrdiff_t kept = 0;
  const auto keep_lowest = [&](const Vector3d& tilt) {
    std::ptrdiff_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t k = 0; k < std::ssize(order); ++k) {
      const Distance& at = point(order[static_cast<std::size_t>(k)]).at;
      const double height = at.phi - tilt.dot(at.p_WA);
      if (height < least - frame_.same) least = height, best = k;
    }
    if (best < kept) return;
    std::rotate(order.begin() + kept, order.begin() + best, order.begin() + best + 1);
    ++kept;
  };
  keep_lowest(Vector3d::Zero());
  for (int k = 1; k < Patch::kMost; ++k) {
    const double angle = 2 * std::numbers::pi * k / (Patch::kMost - 1);
    keep_lowest(kTilt * (std::cos(angle) * frame_.e1 + std::sin(angle) * frame_.e2));
  }
  scratch_.kept.clear();
  for (std::ptrdiff_t k = 0; k < kept; ++k) scratch_.kept.push_back(point(order[static_cast<std::size_t>(k)]));
  points_.swap(scratch_.kept);
}

void Reducer::run(Patch& out) {
  if (options_.planar_axis >= 0) flatten();
  if (points_.size() > Patch::kMost) keep_most();  // needed in any case, because Patch has no room for more
  out.n = 0;
  for (Patch::Point& p : points_) {
    // Codes of large meshes may coincide.
    const auto is_taken = [&] {
      return std::any_of(out.points.begin(), out.points.begin() + out.n, [&](const Patch::Point& q) { return q.code == p.code; });
    };
    while (is_taken()) p.code = (p.code + 1) % kWitnessCode;
    int at = out.n++;
    for (; at > 0 && out.points[at - 1].code > p.code; --at) out.points[at] = out.points[at - 1];
    out.points[at] = p;
  }
}

}  // namespace

void reduce_patch(const PatchFrame& frame, const PatchOptions& options, PatchScratch& scratch, Patch& out) {
  Reducer(frame, options, scratch).run(out);
}

}  // namespace stiction::contact::detail
