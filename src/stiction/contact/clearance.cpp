#include "stiction/contact/clearance.hpp"

#include <algorithm>

#include "stiction/contact/workspace.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {
namespace {

using world::BodyKind;
using world::Model;

bool is_of_links(const Model& model, const world::Pair& pair) {
  const auto body = [&](int geometry) -> const world::Body& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)];
  };
  const world::Body &a = body(pair.geometry_a), &b = body(pair.geometry_b);
  if (a.kind != BodyKind::Robot) return false;  // objects come first
  return b.kind == BodyKind::Fixed || (b.kind == BodyKind::Robot && a.owner == b.owner);
}

world::Kinematics calc_rest(const Model& model) {
  Eigen::VectorXd q = model.neutral();
  const auto& rest = model.scene().rest;
  if (static_cast<int>(rest.size()) == model.n_a()) q.tail(model.n_a()) = Eigen::Map<const Eigen::VectorXd>(rest.data(), model.n_a());
  world::KinematicsWorkspace work(model);
  world::Kinematics out;
  world::calc_kinematics(model, q, work, out);
  return out;
}

}  // namespace

std::span<const ClosePair> find_close_pairs(const Model& model, Workspace& work) {
  Workspace::Impl& w = work.impl();
  if (w.close_pairs_known) return w.close_pairs;
  w.close_pairs_known = true;
  if (model.n_a() == 0) return w.close_pairs;
  const double most = world::share::kClearance * model.scales().robots().length;
  const world::Kinematics rest = calc_rest(model);
  Gaps gaps(model, rest, work);
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    if (!is_of_links(model, model.pairs()[static_cast<std::size_t>(i)])) continue;
    const double gap = gaps.calc(i, most);
    if (gap > 0 && gap < most) w.close_pairs.push_back({i, gap});
  }
  return w.close_pairs;
}

PairClearances split_by_clearance(const Model& model, std::span<const int> pairs, double clearance, Workspace& work) {
  PairClearances out{.usual = clearance};
  const std::span<const ClosePair> close = find_close_pairs(model, work);
  for (const int i : pairs) {
    const auto found = std::ranges::lower_bound(close, i, {}, &ClosePair::pair);
    if (found != close.end() && found->pair == i && found->clearance() < clearance)
      out.close.emplace_back(i, found->clearance());
    else
      out.pairs.push_back(i);
  }
  return out;
}

bool any_too_near(const Model& model, const world::Kinematics& kinematics, const PairClearances& pairs, double share, Workspace& work) {
  if (any_nearer(model, kinematics, pairs.pairs, share * pairs.usual, work)) return true;
  return std::any_of(pairs.close.begin(), pairs.close.end(), [&](const auto& close) {
    return any_nearer(model, kinematics, std::span(&close.first, 1), share * close.second, work);
  });
}

}  // namespace stiction::contact
