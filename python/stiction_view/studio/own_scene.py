"""A task of a robot and an object that were dropped: on a floor, the object before the robot, to be moved by its own length."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import stiction as st

from .. import meshes
from ..bodies import in_world, pose_in
from .picture import Pictures

SHAPES = {"box": ("length x [m]", "length y [m]", "length z [m]"), "cylinder": ("radius [m]", "height [m]"), "sphere": ("radius [m]",), "capsule": ("radius [m]", "length [m]")}


@dataclass(frozen=True)
class ObjectSpec:
    """`kind` of SHAPES with `sizes` in its order, or "mesh" with `file`."""

    kind: str
    sizes: tuple[float, ...] = ()
    file: Path | None = None
    scale: float = 1.0
    mass: float = 0.1  # [kg]
    friction: float = 0.8

    def shape(self) -> dict[str, Any]:
        s = self.sizes
        match self.kind:
            case "box":
                return {"box": {"size": list(s[:3])}}
            case "sphere":
                return {"sphere": {"radius": s[0]}}
            case "cylinder" | "capsule":
                return {self.kind: {"radius": s[0], "length": s[1]}}
            case _:
                return {"mesh": {"file": self.file.name if self.file else "", "scale": self.scale}}


def bounds(pictures: Pictures, q: np.ndarray, kind: str) -> np.ndarray:
    """Lowest and highest corner (2, 3) of the bodies of a kind, without half-spaces [m]."""
    poses = pictures.poses(q)[0]
    points = []
    for geometry in pictures.geometries:
        body = pictures.bodies[geometry.body]
        mesh = meshes.of_shape(geometry.shape) if body.kind == kind else None
        if mesh is None:
            continue
        points.append(in_world(in_world(mesh[0], geometry.X_BG), pose_in(body, poses)))
    if not points:
        return np.zeros((2, 3))
    cloud = np.concatenate(points)
    return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _robot(file: Path) -> dict[str, Any]:
    """As a text, so that the task is whole without the file; meshes are looked for in the folder of the task, which is that of the robot."""
    content = file.read_bytes()
    try:
        source = content.decode()
    except UnicodeDecodeError:  # the reader of files knows other encodings
        source = file.name
    return {"name": "robot", "urdf" if file.suffix.lower() == ".urdf" else "mjcf": source}


def make_spec(robot: Path, thing: ObjectSpec, floor: bool = True) -> dict[str, Any]:
    """The task, as a task file says it. The object lies on the floor where the robot's middle reaches, its goal is one length further on.

    Raises stiction.InvalidInput: what the reader of scenes refuses.
    """
    free = {"name": "object", "joint": "free", "mass": thing.mass, "shapes": [{"name": "shape", **thing.shape(), "friction": thing.friction}]}
    ground = [{"name": "floor", "shapes": [{"half_space": None}]}] if floor else []
    scene: dict[str, Any] = {"robots": [_robot(robot)], "objects": [free], "fixed": ground}
    model = st.load_model(scene, base=robot.parent)
    pictures = Pictures(model)
    q = model.neutral()
    arm, body = bounds(pictures, q, "robot"), bounds(pictures, q, "object")
    index = model.object_index("object")
    body = body - np.array(model.object_pose(q, "object").p)  # in the frame of the object
    size = np.linalg.norm(body[1] - body[0])
    reach = max(float(np.max(model.reach, initial=0.0)), float(np.linalg.norm(arm[1] - arm[0])) / 2)
    along = np.array([1.0, 0.0, 0.0])
    place = (arm[0] + arm[1]) / 2 + 0.5 * reach * along
    place[2] = -body[0, 2]
    start = {"position": place.tolist(), "quaternion_wxyz": [1, 0, 0, 0]}
    goal = {"position": (place + size * np.array([0.0, 1.0, 0.0])).tolist(), "quaternion_wxyz": [1, 0, 0, 0]}
    others = {info.name: start_of(model, q, i) for i, info in enumerate(model.objects) if i != index}
    return {
        "name": robot.stem,
        "description": f"{robot.name} moves a {thing.kind}.",
        "scene": scene,
        "start": {"objects": {"object": start, **others}},
        "goal": {"objects": {"object": goal}},
        "tolerance": {"position": float(f"{0.1 * size:.2g}"), "angle": 0.1},
    }


def start_of(model: st.Model, q: np.ndarray, index: int) -> dict[str, Any]:
    """Where an object of the robot's own file is."""
    info = model.objects[index]
    values = q[info.q_begin : info.q_begin + info.n_q]
    if info.n_q == 7:
        return {"position": values[:3].tolist(), "quaternion_wxyz": [values[6], *values[3:6]]}
    return {"coordinates": values.tolist()}
