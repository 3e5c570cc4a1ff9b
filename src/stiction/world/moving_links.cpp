#include "stiction/world/moving_links.hpp"

#include <algorithm>

#include "stiction/world/model_impl.hpp"

namespace stiction::world {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void MovingLinks::select(const Model& model, std::span<const char> moving, std::span<const int> bodies) {
  const Model::Impl& m = model.impl();
  links_.clear();
  marked_.assign(m.bodies.size(), 0);
  for (const int body : bodies) marked_[at(body)] = 1;
  for (int i = static_cast<int>(m.link_nodes.size()) - 1; i >= 0; --i) {  // parents come first
    const LinkNode& node = m.link_nodes[at(i)];
    if (!marked_[at(node.body)]) continue;
    marked_[at(node.parent)] = 1;
    links_.push_back(i);
  }
  std::reverse(links_.begin(), links_.end());
  std::ranges::fill(marked_, 0);
  std::erase_if(links_, [&](int i) {
    const LinkNode& node = m.link_nodes[at(i)];
    const bool turns = node.kind != LinkNode::Kind::Welded && moving[at(node.v - m.n_vu)];
    marked_[at(node.body)] = turns || marked_[at(node.parent)];
    return !marked_[at(node.body)];
  });
}

void MovingLinks::update(const Model& model, const Eigen::VectorXd& q, Kinematics& out) const {
  const Model::Impl& m = model.impl();
  for (const int i : links_) place_link(m.link_nodes[at(i)], q, out);
}

}  // namespace stiction::world
