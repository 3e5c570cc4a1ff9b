"""Triangle meshes of the shapes in a plan file.

A mesh is (vertices (n, 3), triangles (m, 3), patch (m)). Patches are numbers 0, 1, 2 that an object paints in different colours, so
that a rotation shows even on a sphere. Vertices are shared where the surface is smooth and doubled at edges.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray, np.ndarray]

ROUND = 48  # segments around an axis; a multiple of 8, so that stripes end on edges


def _revolve(profile: np.ndarray, patch: np.ndarray) -> Mesh:
    """Turns a polyline (k, 2) of (radius, z), bottom to top, about z. `patch` (k − 1) is the patch of each ring; −1 means stripes."""
    angle = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate([np.column_stack([r * circle, np.full(ROUND, z)]) for r, z in profile])
    triangles, patches = [], []
    around = np.arange(ROUND)
    following = (around + 1) % ROUND
    stripes = around // (ROUND // 8) % 2
    for ring in range(len(profile) - 1):
        low, high = ring * ROUND, (ring + 1) * ROUND
        of_ring = stripes if patch[ring] < 0 else np.full(ROUND, patch[ring])
        if profile[ring, 0] > 0:
            triangles.append(np.column_stack([low + around, low + following, high + following]))
            patches.append(of_ring)
        if profile[ring + 1, 0] > 0:
            triangles.append(np.column_stack([low + around, high + following, high + around]))
            patches.append(of_ring)
    return vertices, np.concatenate(triangles), np.concatenate(patches)


def join(meshes: list[Mesh]) -> Mesh:
    offsets = np.cumsum([0] + [len(m[0]) for m in meshes])
    return (
        np.concatenate([m[0] for m in meshes]),
        np.concatenate([m[1] + offset for m, offset in zip(meshes, offsets)]),
        np.concatenate([m[2] for m in meshes]),
    )


def sphere(radius: float) -> Mesh:
    polar = np.linspace(-np.pi / 2, np.pi / 2, 25)
    profile = radius * np.column_stack([np.cos(polar), np.sin(polar)])
    profile[[0, -1], 0] = 0.0
    patch = np.full(24, -1)
    patch[:2] = patch[-2:] = 2
    return _revolve(profile, patch)


def capsule(radius: float, half_length: float) -> Mesh:
    polar = np.linspace(0, np.pi / 2, 9)
    top = np.column_stack([radius * np.cos(polar), half_length + radius * np.sin(polar)])
    top[-1, 0] = 0.0
    bottom = top[::-1] * [1.0, -1.0]
    profile = np.concatenate([bottom, top]) if half_length > 0 else np.concatenate([bottom[:-1], top])
    return _revolve(profile, np.full(len(profile) - 1, -1))


def cylinder(radius: float, half_length: float) -> Mesh:
    side = _revolve(np.array([[radius, -half_length], [radius, half_length]]), np.array([-1]))
    top = _revolve(np.array([[radius, half_length], [0.25 * radius, half_length], [0.0, half_length]]), np.array([-1, 2]))
    bottom = _revolve(np.array([[0.0, -half_length], [0.25 * radius, -half_length], [radius, -half_length]]), np.array([2, -1]))
    return join([side, top, bottom])


def box(half_extents: list[float]) -> Mesh:
    faces = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            # Corners of one face, counterclockwise seen from outside.
            u, v = (axis + 1) % 3, (axis + 2) % 3
            corners = np.zeros((4, 3))
            corners[:, axis] = sign
            corners[:, u] = [-1, 1, 1, -1]
            corners[:, v] = [-1, -1, 1, 1]
            order = [[0, 1, 2], [0, 2, 3]] if sign > 0 else [[0, 2, 1], [0, 3, 2]]
            patch = 1 if axis == 1 and sign > 0 else 2 if axis == 2 and sign > 0 else 0
            faces.append((corners * half_extents, np.array(order), np.full(2, patch)))
    return join(faces)


def polyhedron(vertices: list[list[float]], triangles: list[list[int]]) -> Mesh:
    points, corners = np.asarray(vertices, dtype=float), np.asarray(triangles, dtype=int)
    if len(corners) < 400:  # few faces: show them as facets, each in one colour
        a, b, c = (points[corners[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        steep = np.abs(normal[:, 2]) > 0.9 * np.linalg.norm(normal, axis=1)
        turn = np.arctan2(normal[:, 1], normal[:, 0]) + 0.1  # no face of a box is where the colour changes
        patch = np.where(steep, 2 * (normal[:, 2] > 0), (turn // (np.pi / 2)).astype(int) % 2)
        return points[corners].reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), patch
    outward = points[corners].mean(axis=1) - points.mean(axis=0)
    return points, corners, (np.arctan2(outward[:, 1], outward[:, 0]) // (np.pi / 4)).astype(int) % 2


def of_shape(shape: dict[str, Any]) -> Mesh | None:
    """Mesh of a `shape` of the plan file in its geometry frame; None for a half-space, which has no bounds."""
    match shape["type"]:
        case "sphere":
            return sphere(shape["radius"])
        case "capsule":
            return capsule(shape["radius"], shape["half_length"])
        case "cylinder":
            return cylinder(shape["radius"], shape["half_length"])
        case "box":
            return box(shape["half_extents"])
        case "mesh":
            return polyhedron(shape["vertices"], shape["triangles"])
        case "half_space":
            return None
        case other:
            raise ValueError(f"unknown shape {other!r}")


def compact(mesh: Mesh, keep: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of the part of a mesh whose triangles are in `keep`."""
    used, triangles = np.unique(mesh[1][keep], return_inverse=True)
    return mesh[0][used], triangles.reshape(-1, 3)


def _triangle_areas(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def surface_area(mesh: Mesh) -> float:
    return float(_triangle_areas(mesh).sum())


def surface_points(mesh: Mesh, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points spread evenly over the surface."""
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    area = _triangle_areas(mesh)
    face = rng.choice(len(area), size=count, p=area / area.sum())
    s, t = rng.random((2, count, 1))
    flip = s + t > 1
    s, t = np.where(flip, 1 - s, s), np.where(flip, 1 - t, t)
    return a[face] + s * (b[face] - a[face]) + t * (c[face] - a[face])
