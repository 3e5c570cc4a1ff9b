"""Meshes of the bodies of a plan, where they are, and the colours they have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import meshes
from .plan import Body, Plan, Pose

Color = tuple[int, int, int]

ROBOT: Color = (205, 208, 214)
ROBOT_BASE: Color = (128, 134, 144)
ROBOT_OPACITY = 0.72
ROBOT_REGRASP: Color = (96, 146, 232)
FIXED: Color = (172, 176, 184)
OBJECT: tuple[Color, Color, Color] = ((238, 126, 36), (253, 226, 178), (120, 52, 10))
GOAL: Color = (38, 160, 92)
FORCE: Color = (206, 24, 74)
TREE: Color = (128, 112, 196)
KIND_COLOR: dict[str, Color] = {"settle": (158, 162, 170), "contact": OBJECT[0], "regrasp": (70, 122, 214)}
KIND_TEXT = {"settle": "settle", "contact": "push", "regrasp": "regrasp"}

GOAL_AXES, OBJECT_AXES = 1.6, 1.3  # lengths, times the size of the object


@dataclass
class BodyMesh:
    body: int
    mesh: meshes.Mesh  # in the body frame


def body_meshes(plan: Plan, rods: dict[int, list[meshes.Mesh]]) -> list[BodyMesh]:
    """One mesh per body: its geometries, and rods between spheres."""
    result = []
    for index in range(len(plan.bodies)):
        parts = list(rods.get(index, []))
        for geometry in plan.geometries:
            mesh = meshes.of_shape(geometry.shape) if geometry.body == index else None
            if mesh is not None:
                vertices = mesh[0] @ geometry.X_BG.rotation().T + geometry.X_BG.position
                parts.append((vertices, mesh[1], mesh[2]))
        if parts:
            result.append(BodyMesh(index, meshes.join(parts)))
    return result


def pose_in(body: Body, poses: np.ndarray) -> Pose:
    """Of a body where the moving ones are at (moving bodies, 7)."""
    if body.moving is None:
        assert body.pose is not None
        return body.pose
    row = poses[body.moving]
    return Pose(row[:3], row[3:])


def pose_at(plan: Plan, body: int, knot: int) -> Pose:
    return pose_in(plan.bodies[body], plan.poses[knot])


def in_world(points: np.ndarray, pose: Pose) -> np.ndarray:
    return points @ pose.rotation().T + pose.position


def slug(name: str) -> str:
    """A node name without the separators of the scene tree."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in name)
