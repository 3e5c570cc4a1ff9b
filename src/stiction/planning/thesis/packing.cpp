#include "stiction/planning/thesis/packing.hpp"

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/tree.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::planning {

void PackingOptions::validate() const {
  core::require_positive("packing.threshold", threshold);
  core::require_positive("packing.gamma", gamma);
  if (samples < 1) core::throw_invalid("packing.samples", std::to_string(samples), "at least 1");
}

Eigen::VectorXd calc_packing_ratio(const world::Model& model, const std::vector<world::SampleBox>& boxes,
                                   const std::vector<NodeRecord>& tree, const PackingOptions& options) {
  options.validate();
  if (boxes.empty()) core::throw_invalid("planner.sample_box", "none", "a box for at least one object");
  Eigen::VectorXd ratio(static_cast<Eigen::Index>(tree.size()));
  if (tree.empty()) return ratio;

  const world::ObjectSpace space(model);
  std::vector<Eigen::VectorXd> outside;  // samples that no node has reached so far
  for (int i = 0; i < options.samples; ++i) {
    core::Random random(options.seed, static_cast<std::uint64_t>(i));
    space.sample(boxes, random, outside.emplace_back(tree.front().q.head(space.n_q())));
  }
  LocalModel local;
  Eigen::VectorXd e(space.n_v());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    local.set(tree[i].c_u, tree[i].B_u, space.n_q(), Eigen::VectorXd::Constant(space.n_v(), options.gamma));
    std::erase_if(outside, [&](const Eigen::VectorXd& q_u) {
      space.error(local.c_u.data(), q_u.data(), e.data());
      return (local.L_inv.triangularView<Eigen::Lower>() * e).squaredNorm() <= options.threshold;
    });
    ratio[static_cast<Eigen::Index>(i)] = 1.0 - static_cast<double>(outside.size()) / options.samples;
  }
  return ratio;
}

}  // namespace stiction::planning
