"""Thin rods that join the spheres of a robot, so that a finger looks like one.

Models for contact often cover a link by a few spheres. The plan file has no joints, but it has the motion: the origin of a link (its joint) stays
put in the frame of the link before it. Rods are for the eye only and thinner than the spheres, so they never seem to touch anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import meshes
from .plan import Plan, rotation_matrices

THICKNESS = 0.62  # of the smallest sphere of the link
STILL = 2e-4  # [m] a point that moves less than this in a frame is fixed in it


@dataclass
class LooseRod:
    """Joins two links with something undrawn between them, so it has to be placed anew at every knot."""

    parent: int
    p_P: np.ndarray  # end in the parent's frame
    child: int  # the other end is the child's origin
    length: float
    radius: float


def _tracks(plan: Plan, body: int, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (k, 3) and rotations (k, 3, 3) of a body."""
    column = plan.bodies[body].moving
    if column is None:
        pose = plan.bodies[body].pose
        assert pose is not None
        return np.tile(pose.position, (len(knots), 1)), np.tile(pose.rotation(), (len(knots), 1, 1))
    rows = plan.poses[knots, column]
    return rows[:, :3], rotation_matrices(rows[:, 3:])


def rod(a: np.ndarray, b: np.ndarray, radius: float) -> meshes.Mesh | None:
    """A capsule from a to b."""
    length = float(np.linalg.norm(b - a))
    if length < 1e-4:
        return None
    vertices, triangles, patch = meshes.capsule(radius, length / 2)
    return vertices @ along(b - a).T + (a + b) / 2, triangles, patch


def along(direction: np.ndarray) -> np.ndarray:
    """A rotation that takes z to `direction`."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def find(plan: Plan) -> tuple[dict[int, list[meshes.Mesh]], list[LooseRod]]:
    """Rods fixed to a body, in its frame, and loose ones."""
    centres: dict[int, list[np.ndarray]] = {}
    radii: dict[int, float] = {}
    other: set[int] = set()
    for geometry in plan.geometries:
        if plan.bodies[geometry.body].kind != "robot":
            continue
        if geometry.shape["type"] == "sphere":
            centres.setdefault(geometry.body, []).append(geometry.X_BG.position)
            radii[geometry.body] = min(radii.get(geometry.body, np.inf), geometry.shape["radius"])
        else:
            other.add(geometry.body)

    fixed: dict[int, list[meshes.Mesh]] = {}
    loose: list[LooseRod] = []
    knots = np.unique(np.linspace(0, len(plan.poses) - 1, 200).round().astype(int))

    def add(body: int, a: np.ndarray, b: np.ndarray, radius: float) -> None:
        mesh = rod(a, b, radius)
        if mesh is not None:
            fixed.setdefault(body, []).append(mesh)

    for child, points in centres.items():
        if plan.bodies[child].moving is None:
            continue
        radius = THICKNESS * radii[child]
        chain = sorted([np.zeros(3), *points], key=np.linalg.norm)
        robot = plan.bodies[child].name.split("/")[0]
        origin, _ = _tracks(plan, child, knots)
        best: tuple[float, float, int, np.ndarray] | None = None
        for parent in range(child):
            body = plan.bodies[parent]
            if body.kind != "robot" or body.name.split("/")[0] != robot or parent not in centres | dict.fromkeys(other):
                continue
            position, rotation = _tracks(plan, parent, knots)
            local = np.einsum("kji,kj->ki", rotation, origin - position)
            spread = float(np.ptp(local, axis=0).max())
            key = (round(spread, 4), float(np.linalg.norm(local.mean(axis=0))), parent, local.mean(axis=0))
            if best is None or key[:2] < best[:2]:
                best = key
        if best is None:  # nothing to hang on: a slider, a floating finger
            chain = chain[1:]
        else:
            spread, _, parent, joint = best
            start = min(centres.get(parent, [np.zeros(3)]), key=lambda p: float(np.linalg.norm(p - joint)))
            if spread <= STILL:
                if parent not in other:  # a palm reaches its fingers by itself
                    add(parent, start, joint, radius)
            else:
                position, rotation = _tracks(plan, parent, knots)
                length = float(np.linalg.norm(position + rotation @ start - origin, axis=1).mean())
                if parent not in other:
                    loose.append(LooseRod(parent, start, child, length, radius))
                else:
                    # Out of a palm: from the point around which the joint swings least.
                    loose.append(LooseRod(parent, _pivot(np.einsum("kji,kj->ki", rotation, origin - position)), child, 0.0, radius))
        for a, b in zip(chain[:-1], chain[1:]):
            add(child, a, b, radius)
    for rod_ in loose:
        if rod_.length == 0.0:
            position, rotation = _tracks(plan, rod_.parent, knots)
            origin, _ = _tracks(plan, rod_.child, knots)
            rod_.length = float(np.linalg.norm(position + rotation @ rod_.p_P - origin, axis=1).mean())
    return fixed, [r for r in loose if r.length > 1e-3]


def ends(rods: list[LooseRod]) -> set[int]:
    """Bodies that loose rods join."""
    return {body for rod_ in rods for body in (rod_.parent, rod_.child)}


def _pivot(points: np.ndarray) -> np.ndarray:
    """Centre of the sphere through a track of points (least squares, the nearest to the track of those that fit)."""
    mean = points.mean(axis=0)
    offset = points - mean
    square = (offset**2).sum(axis=1)
    centre = np.linalg.lstsq(2 * offset, square - square.mean(), rcond=1e-2)[0]
    return mean + centre
