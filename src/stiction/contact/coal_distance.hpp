#pragma once

#include <memory>

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: pairs without a closed form, by Coal's GJK and EPA. docs/theory/contact.md §5.

namespace stiction::contact::detail {

/// Coal's picture of a capsule, box, cylinder or convex mesh.
std::shared_ptr<const CoalShape> make_coal_shape(const ShapeData& shape);

/// Solver storage of one thread. Nothing in it outlives a query, so results do not depend on what was asked before.
class CoalScratch {
 public:
  CoalScratch();
  ~CoalScratch();
  CoalScratch(const CoalScratch&) = delete;
  CoalScratch& operator=(const CoalScratch&) = delete;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

void coal_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context, Distance& out);

}  // namespace stiction::contact::detail
