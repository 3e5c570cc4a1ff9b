#include "stiction/world/robot_chains.hpp"

#include <algorithm>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::world {

RobotChains::RobotChains(const Model& model) {
  std::vector<int> chain_of(static_cast<std::size_t>(model.n_v()), -1);
  for (const auto& robot : model.robots()) {
    for (const auto& chain : robot.chains) {
      auto& joints = joints_.emplace_back();
      for (const int v : chain) {
        chain_of[static_cast<std::size_t>(v)] = size() - 1;
        joints.push_back(v - model.n_vu());
      }
    }
  }
  if (size() > 64) core::throw_invalid("robots", std::to_string(size()) + " branches", "at most 64");
  all_ = size() == 64 ? ~ChainMask{0} : (ChainMask{1} << size()) - 1;

  object_pairs_.resize(joints_.size());
  against_.resize(joints_.size());
  const auto body_of = [&](int geometry) -> const Body& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)];
  };
  const auto mask_of = [&](const Body& body) {
    ChainMask mask = 0;
    if (body.kind != BodyKind::Robot) return mask;
    for (const int v : body.dofs) mask |= ChainMask{1} << chain_of[static_cast<std::size_t>(v)];
    return mask;
  };
  depth_.assign(joints_.size(), 0);
  for (const Body& body : model.bodies()) {
    if (body.kind != BodyKind::Robot || body.dofs.empty()) continue;
    int depth = 0;
    for (std::size_t i = 1; i < body.dofs.size(); ++i) {
      depth += chain_of[static_cast<std::size_t>(body.dofs[i])] != chain_of[static_cast<std::size_t>(body.dofs[i - 1])];
    }
    depth_[static_cast<std::size_t>(chain_of[static_cast<std::size_t>(body.dofs.back())])] = depth;
  }
  const auto pairs = model.pairs();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Body& a = body_of(pairs[i].geometry_a);
    const Body& b = body_of(pairs[i].geometry_b);
    // A trunk moves both sides of a pair of two of its fingers alike, so it does not change that pair.
    const ChainMask mask = mask_of(a) ^ mask_of(b);
    const ChainMask both = mask_of(a) & mask_of(b);
    pair_mask_.push_back(mask != 0 ? mask : both);
    const bool object = a.kind == BodyKind::Object || b.kind == BodyKind::Object;
    object_pair_.push_back(object ? 1 : 0);
    for (int c = 0; c < size(); ++c) {
      if (!(mask >> c & 1)) continue;
      against_[static_cast<std::size_t>(c)].push_back(static_cast<int>(i));
      if (object) object_pairs_[static_cast<std::size_t>(c)].push_back(static_cast<int>(i));
    }
  }
}

std::vector<int> RobotChains::joints_of(ChainMask mask) const {
  std::vector<int> joints;
  for (int c = 0; c < size(); ++c) {
    if (mask >> c & 1)
      joints.insert(joints.end(), joints_[static_cast<std::size_t>(c)].begin(), joints_[static_cast<std::size_t>(c)].end());
  }
  std::sort(joints.begin(), joints.end());
  return joints;
}

void RobotChains::pairs_of(ChainMask mask, std::vector<int>& pairs) const {
  pairs.clear();
  for (std::size_t i = 0; i < pair_mask_.size(); ++i) {
    if (pair_mask_[i] & mask) pairs.push_back(static_cast<int>(i));
  }
}

}  // namespace stiction::world
