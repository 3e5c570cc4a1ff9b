"""From where a plan is looked at."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from . import meshes
from .bodies import GOAL_AXES, OBJECT_AXES, BodyMesh, in_world, pose_at
from .plan import Plan


ROBOT_SEEN = 0.3  # part of the picture of a robot that is enough


@dataclass
class View:
    position: np.ndarray
    look_at: np.ndarray
    up: np.ndarray
    fov: float
    radius: float  # of what matters [m]
    label: np.ndarray  # above everything, in the picture
    width: float = 0.0  # by its height, of the narrowest picture in which everything shows

    def for_picture(self, width: float) -> View:
        """From as far away as a picture of that width by its height needs."""
        if not 0 < width < self.width:
            return self
        return dataclasses.replace(self, position=self.look_at + self.width / width * (self.position - self.look_at))

    def aside(self, share: float) -> View:
        """What is looked at is that share of half the height to the right of the middle."""
        away = self.position - self.look_at
        right = np.cross(self.up, away)
        step = -share * np.linalg.norm(away) * np.tan(self.fov / 2) * right / np.linalg.norm(right)
        return dataclasses.replace(self, position=self.position + step, look_at=self.look_at + step)


def is_on_one_joint(plan: Plan, body: int) -> bool:
    return plan.object_joints.get(plan.bodies[body].name) in ("hinge", "slider")


def choose_view(plan: Plan, parts: list[BodyMesh], frames: np.ndarray, also: Iterable[int] = ()) -> View:
    """Frames what moves and the goal, from a side from which the object is seen. The origins of the bodies `also` count as well.

    Plane problems are looked at along the normal of their plane. Otherwise the candidates are directions on the upper half of a sphere,
    and the one from which most of the object is not hidden behind anything else wins, over a few moments of the plan. A robot may be hidden in
    part; one that hardly shows counts against a direction: a hand behind a door.
    """
    moments = frames[np.linspace(0, len(frames) - 1, 5).round().astype(int)]
    samples = sample_surfaces(plan, parts)

    interesting = [in_world(samples[plan.goal_body], plan.goal)] if plan.goal_body in samples else [plan.goal.position[None]]
    for body, points in samples.items():
        if plan.bodies[body].moving is not None:
            interesting += [in_world(points, pose_at(plan, body, knot)) for knot in moments]
    interesting += [pose_at(plan, body, knot).position[None] for body in also for knot in moments]
    core = np.concatenate(interesting)
    size = np.linalg.norm(np.ptp(core, axis=0))
    # Robot bases and fixed bodies count where they are of the size of the rest; a table as large as a room does not.
    for body, points in samples.items():
        if plan.bodies[body].moving is None:
            world = in_world(points, pose_at(plan, body, 0))
            if np.linalg.norm(np.ptp(world, axis=0)) < 1.2 * size:
                interesting.append(world)
    object_size = np.abs(next(p.mesh[0] for p in parts if p.body == plan.goal_body)).max() if plan.goal_body in samples else 0.0
    if is_on_one_joint(plan, plan.goal_body):
        object_size = 0.0  # no frames are drawn
    interesting.append(in_world(GOAL_AXES * object_size * np.eye(3), plan.goal))
    interesting += [in_world(OBJECT_AXES * object_size * np.eye(3), pose_at(plan, plan.goal_body, knot)) for knot in moments]
    everything = np.concatenate(interesting)
    low, high = everything.min(axis=0), everything.max(axis=0)
    centre = (low + high) / 2

    joint = plan.object_joints.get(plan.bodies[plan.goal_body].name, "free")
    plane_views = {
        "planar_xy": (np.array([0.0, -0.1, 1.0]), np.array([0.0, 0.0, 1.0])),
        "planar_yz": (np.array([1.0, 0.07, 0.1]), np.array([0.0, 0.0, 1.0])),
        "planar_xz": (np.array([0.07, -1.0, 0.1]), np.array([0.0, 0.0, 1.0])),
    }
    fov = np.radians(40.0)
    if joint in plane_views:
        direction, up = plane_views[joint]
        fov = np.radians(12.0)  # from far away, so that the near side of a body hides nothing beside it
    else:
        up = np.array([0.0, 0.0, 1.0])
        candidates = [
            np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
            for e in np.radians([30.0, 42.0, 55.0])
            for a in np.radians(np.arange(0.0, 360.0, 22.5) - 45.0)
        ]
        if plan.bodies[plan.goal_body].kind != "object":  # nothing is to be seen before all else
            candidates = candidates[:1]
        knots, counts = np.unique(moments, return_counts=True)
        clouds = [make_cloud(plan, samples, knot) for knot in knots]
        scores = [sum(count * (visible(cloud, d) + min(visible(cloud, d, cloud.is_robot), ROBOT_SEEN)) for cloud, count in zip(clouds, counts)) for d in candidates]
        direction = candidates[int(np.argmax(np.round(scores, 2)))]
    direction = direction / np.linalg.norm(direction)

    # Distance at which all points fit, for a page that is wider than high.
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    above = np.cross(direction, right)
    offset = everything - centre
    depth = offset @ direction
    vertical = np.abs(offset @ above) / np.tan(0.80 * fov / 2) + depth
    horizontal = np.abs(offset @ right) / np.tan(1.1 * fov / 2) + depth
    distance = max(vertical.max(), horizontal.max())
    radius = float(np.linalg.norm(offset, axis=1).max())
    label = centre + 1.08 * (offset @ above).max() * above
    width = float((np.abs(offset @ right) / (distance - depth)).max() / np.tan(fov / 2))
    return View(centre + distance * direction, centre, up, fov, radius, label, width)


def _cell(points: np.ndarray) -> float:
    """Of the depth buffer: a fourteenth of the object."""
    return float(np.linalg.norm(np.ptp(points, axis=0))) / 14


def sample_surfaces(plan: Plan, parts: list[BodyMesh]) -> dict[int, np.ndarray]:
    """Points on every body, as close as the cells of the depth buffer: a wall with gaps would hide nothing."""
    rng = np.random.default_rng(0)
    seen = plan.bodies[plan.goal_body].kind == "object"
    cell = _cell(next((part.mesh[0] for part in parts if seen and part.body == plan.goal_body), np.zeros((1, 3))))

    def count(area: float) -> int:
        return int(np.clip(3 * area / cell**2 if cell > 0 else 0, 400, 20000))

    return {part.body: meshes.surface_points(part.mesh, count(meshes.surface_area(part.mesh)), rng) for part in parts}


@dataclass(frozen=True)
class Cloud:
    """Points on all bodies at one moment."""

    world: np.ndarray  # (n, 3)
    is_object: np.ndarray  # (n)
    is_robot: np.ndarray  # (n) and moves
    cell: float  # of the depth buffer [m]


def make_cloud(plan: Plan, samples: dict[int, np.ndarray], knot: int) -> Cloud:
    world = [in_world(p, pose_at(plan, body, knot)) for body, p in samples.items()]
    is_object = [np.full(len(p), body == plan.goal_body) for body, p in samples.items()]
    is_robot = [np.full(len(p), plan.bodies[body].kind == "robot" and plan.bodies[body].moving is not None) for body, p in samples.items()]
    points = np.concatenate(world)
    # An object without a surface is a point, and a scene of one point has one cell.
    cell = _cell(samples.get(plan.goal_body, points)) or _cell(points) or 1.0
    return Cloud(points, np.concatenate(is_object), np.concatenate(is_robot), cell)


def visible(cloud: Cloud, direction: np.ndarray, of: np.ndarray | None = None) -> float:
    """Part of the picture of the object, or of the points `of`, that nothing else covers, seen from `direction`: a coarse depth buffer of surface points."""
    wanted = cloud.is_object if of is None else of
    if not wanted.any():
        return 0.0
    right = np.cross([0.0, 0.0, 1.0], direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    world = cloud.world
    column, row = (np.round(world @ axis / cloud.cell).astype(int) for axis in (right, up))
    near = np.ones(len(world), dtype=bool)
    for index in (column, row):  # nothing else can cover it
        near &= (index >= index[wanted].min()) & (index <= index[wanted].max())
    world, wanted, column, row = world[near], wanted[near], column[near], row[near]
    key = (column - column.min()) * (np.ptp(row) + 1) + row - row.min()
    # Sorted by cell and, within a cell, by depth: the last point of a cell is the one that is seen.
    order = np.lexsort((world @ direction, key))
    seen = order[np.append(np.diff(key[order]) > 0, True)]
    return float(wanted[seen].sum() / len(np.unique(key[wanted])))
