#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: kernels in closed form, exact to rounding and smooth where the nearest points are unique.
// Each takes (a, X_WA, b, X_WB, context, out); docs/theory/contact.md §2–4.

namespace stiction::contact::detail {

void sphere_sphere_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void sphere_capsule_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void sphere_box_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void sphere_cylinder_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void sphere_mesh_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void capsule_capsule_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void box_box_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);  // box_box.cpp
void sphere_halfspace_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void capsule_halfspace_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void box_halfspace_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void cylinder_halfspace_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);
void mesh_halfspace_kernel(const ShapeData&, const Pose&, const ShapeData&, const Pose&, const KernelContext&, Distance&);

}  // namespace stiction::contact::detail
