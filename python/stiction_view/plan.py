"""Reads the parts of a plan file that a picture needs (docs/plan_file.md)."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .loads import Loads, read_loads

FORMAT = "stiction-plan"
FORMAT_VERSION = 1
SEGMENT_KINDS = ("settle", "contact", "regrasp")
T = TypeVar("T")


class InvalidPlan(ValueError):
    """The file is no plan of this version; the message names file and field."""


@dataclass(frozen=True)
class Pose:
    """X_AB: `position` [m] and `wxyz` of B in A."""

    position: np.ndarray
    wxyz: np.ndarray

    def rotation(self) -> np.ndarray:
        return rotation_matrices(self.wxyz[None])[0]


@dataclass(frozen=True)
class Geometry:
    name: str
    body: int
    shape: dict[str, Any]
    X_BG: Pose


@dataclass(frozen=True)
class Body:
    name: str
    kind: str  # robot, object, fixed
    moving: int | None  # column in Plan.poses, None for a body that stays where `pose` says
    pose: Pose | None


@dataclass(frozen=True)
class Contact:
    point: np.ndarray  # (3) in W [m]
    force: np.ndarray  # (3) in W, on A [N]
    on_object: bool  # whether one of the two bodies is an object


@dataclass(frozen=True)
class Plan:
    task: str
    status: str
    seed: int
    error_position: float  # [m]
    error_angle: float  # [rad]
    bodies: list[Body]
    geometries: list[Geometry]
    object_joints: dict[str, str]
    goal_body: int
    goal: Pose
    goal_region: list[str]  # "y = 0.35", "θ in [1, 1.5]"; empty: the pose itself
    poses: np.ndarray  # (knots, moving bodies, 7): x, y, z, qw, qx, qy, qz in W
    contacts: list[list[Contact]]  # per knot
    segment: np.ndarray  # (knots) index of the segment
    segment_kinds: list[str]
    tree_parents: np.ndarray  # (nodes), -1 for the root
    tree_poses: np.ndarray  # (nodes, 7) of the goal's object: x, y, z, qw, qx, qy, qz in W
    loads: Loads | None = None  # None: of a motion that is no plan
    more_goals: list[tuple[int, Pose]] = field(default_factory=list)  # of other objects: body and pose


COORDINATES = {
    "free": ("x", "y", "z", "roll", "pitch", "yaw"),
    "planar_xy": ("x", "y", "angle"),
    "planar_yz": ("y", "z", "angle"),
    "planar_xz": ("x", "z", "angle"),
    "hinge": ("angle",),
    "slider": ("position",),
}


def _status(data: dict) -> str:
    """As the file has it; a task that is shown before it is planned took no time, unlike a search that came to nothing."""
    is_unplanned = data["status"] == "MaxIterations" and data["statistics"]["iterations"] == 0 and data["timing"]["wall_s"] == 0
    return "not planned" if is_unplanned else str(data["status"])


def _region(region: dict, joints: list[str]) -> list[str]:
    """The bounds of a goal region in words, those that are there."""
    names = [name for joint in joints for name in COORDINATES[joint]]
    if not len(names) == len(region["lower"]) == len(region["upper"]):
        raise ValueError(f"goal.region: expected {len(names)} bounds")
    words = []
    for name, lower, upper in zip(names, region["lower"], region["upper"]):
        if lower is not None and lower == upper:
            words.append(f"{name} = {lower:.3g}")
        elif lower is not None or upper is not None:
            low, high = ("−∞" if lower is None else f"{lower:.3g}"), ("∞" if upper is None else f"{upper:.3g}")
            words.append(f"{name} in [{low}, {high}]")
    return words


def rotation_matrices(wxyz: np.ndarray) -> np.ndarray:
    """(n, 4) unit quaternions → (n, 3, 3)."""
    w, x, y, z = np.moveaxis(wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _vector(value: Any, size: int) -> np.ndarray:
    array = np.asarray(value, dtype=float)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ValueError(f"got {value!r}, expected {size} finite numbers")
    return array


def _pose(entry: dict[str, Any]) -> Pose:
    return Pose(_vector(entry["position"], 3), _vector(entry["quaternion_wxyz"], 4))


def read_document(file: Path, format_name: str, version: int, read: Callable[[dict[str, Any]], T]) -> T:
    """What `read` makes of the JSON object in `file`. Raises InvalidPlan."""
    try:
        data = json.loads(Path(file).read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidPlan(f"{file}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise InvalidPlan(f"{file}: not a JSON file ({error})") from None
    if not isinstance(data, dict) or data.get("format") != format_name:
        got = data.get("format") if isinstance(data, dict) else type(data).__name__
        raise InvalidPlan(f"{file}: format: got {got!r}, expected {format_name!r}")
    if data.get("format_version") != version:
        raise InvalidPlan(f"{file}: format_version: got {data.get('format_version')!r}, expected {version}")
    try:
        return read(data)
    except KeyError as error:
        raise InvalidPlan(f"{file}: field {error} is missing") from None
    except (TypeError, ValueError, IndexError) as error:
        raise InvalidPlan(f"{file}: {error}") from None


def load_plan(file: Path) -> Plan:
    """Reads `file`. Raises InvalidPlan."""
    return read_document(file, FORMAT, FORMAT_VERSION, read_plan_object)


def read_bodies(data: dict[str, Any]) -> tuple[list[Body], list[Geometry]]:
    """The members `bodies` and `geometries` of a document."""
    bodies: list[Body] = []
    moving = 0
    for entry in data["bodies"]:
        if entry["moving"]:
            bodies.append(Body(entry["name"], entry["kind"], moving, None))
            moving += 1
        else:
            bodies.append(Body(entry["name"], entry["kind"], None, _pose(entry)))
    geometries = [Geometry(g["name"], g["body"], g["shape"], _pose(g)) for g in data["geometries"]]
    for geometry in geometries:
        if not 0 <= geometry.body < len(bodies):
            raise ValueError(f"geometries: body {geometry.body} of {geometry.name!r} does not exist")
    return bodies, geometries


def read_plan_object(data: dict[str, Any]) -> Plan:
    """The plan of the object in its file. Raises KeyError, TypeError, ValueError or IndexError; load_plan() names the file."""
    bodies, geometries = read_bodies(data)
    moving = sum(body.moving is not None for body in bodies)

    goal = data["goal"]
    goal_body = next((i for i, body in enumerate(bodies) if body.kind == "object" and body.name == goal["object"]), None)
    if goal_body is None:
        raise ValueError(f"goal.object: {goal['object']!r} is not an object of the plan")

    poses: list[np.ndarray] = []
    contacts: list[list[Contact]] = []
    segment: list[int] = []
    kinds: list[str] = []
    is_object = [bodies[g.body].kind == "object" for g in geometries]
    for index, entry in enumerate(data["segments"]):
        if entry["kind"] not in SEGMENT_KINDS:
            raise ValueError(f"segments[{index}].kind: got {entry['kind']!r}, expected one of {', '.join(SEGMENT_KINDS)}")
        kinds.append(entry["kind"])
        for knot in entry["knots"]:
            pose = np.asarray(knot["bodies"], dtype=float)
            if pose.shape != (moving, 7) or not np.isfinite(pose).all():
                raise ValueError(f"segments[{index}]: a knot has bodies of shape {pose.shape}, expected ({moving}, 7) finite numbers")
            poses.append(pose)
            contacts.append(
                [
                    Contact(_vector(c["point"], 3), _vector(c["force"], 3), is_object[c["a"]] or is_object[c["b"]])
                    for c in knot["contacts"]
                ]
            )
            segment.append(index)
    if not poses:
        raise ValueError("segments: got no knots, expected a plan that moves; a longer search may find one (`stiction plan --timeout`)")

    parents = np.array([node["parent"] for node in data["tree"]], dtype=int)
    if (parents >= np.arange(len(parents))).any() or (parents < -1).any():
        raise ValueError("tree: a node comes before its parent")
    tree = np.array([_vector(node["object"], 7) for node in data["tree"]]).reshape(-1, 7)

    return Plan(
        task=str(data["task"]["name"]),
        status=_status(data),
        seed=int(data["seed"]),
        error_position=float(data["error"]["position"]),
        error_angle=float(data["error"]["angle"]),
        bodies=bodies,
        geometries=geometries,
        object_joints={o["name"]: o["joint"] for o in data["objects"]},
        goal_body=goal_body,
        goal=_pose(goal),
        goal_region=_region(goal["region"], [o["joint"] for o in data["objects"]]) if "region" in goal else [],
        poses=np.stack(poses),
        contacts=contacts,
        segment=np.array(segment),
        segment_kinds=kinds,
        tree_parents=parents,
        tree_poses=tree,
        loads=read_loads(data),
    )
