"""Demonstrations, and how they are read from files (docs/demonstrations.md)."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ._core import DofKind, InvalidInput, Task
from ._files import read_csv, read_npz
from ._values import fields_equal
from .exports import POSE, poses_of_objects

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}
ANGLES = {"rad": 1.0, "deg": math.pi / 180}
FAST_OBJECT, FAST_TURN, FAST_REVOLUTE, FAST_PRISMATIC = 5.0, 50.0, 20.0, 5.0  # no hand moves faster [m/s], [rad/s]: such a change is a jump


@dataclass(frozen=True, eq=False)
class Demonstration:
    """Demonstrated motion of joints and objects over time, in the order and units of a model."""

    time: np.ndarray  # (times) [s], increasing
    joints: np.ndarray  # (times, n_a) [rad or m]
    commands: np.ndarray | None  # the same, as the robot was commanded
    poses: np.ndarray  # (times, objects, 7): x y z [m] qx qy qz qw, in the world
    notes: list[str] = field(default_factory=list)  # what was read otherwise than it stands

    def __eq__(self, other: object) -> bool:
        return fields_equal(self, other) if isinstance(other, Demonstration) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can change


def read_demonstration(file: str | os.PathLike[str], task: Task, *, unit: str = "m", angle: str = "rad") -> Demonstration:
    """Reads a demonstration from a table (.csv) or arrays (.npz), as `stiction export` writes them.

      file: a .csv file has a column time_s, a column q_JOINT or JOINT for every joint (ROBOT/ may be left out if the name is unique), columns
        OBJECT_x … OBJECT_qw for every object, and q_cmd_JOINT if there are commands. Other columns are not read. A .npz file has the arrays
        time, q (times, joints), joints (names), poses (times, objects, 7) and objects (names), and q_cmd if there are commands.
      task: Task with the model.
      unit, angle: units of lengths (m, cm, mm) and of angles (rad, deg) in the file.

    Returns a Demonstration. Raises InvalidInput: missing columns, times that do not increase, invalid quaternions, jumps, wrong units.
    """
    path = Path(file)
    if unit not in UNITS or angle not in ANGLES:
        raise InvalidInput(f"unit, angle: got '{unit}', '{angle}', expected one of {', '.join(UNITS)} and of {', '.join(ANGLES)}")
    readers: dict[str, Callable[[Path, Task], tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray, list[str]]]] = {".csv": _read_csv, ".npz": _read_npz}
    if (ending := path.suffix.lower()) not in readers:
        raise InvalidInput(f"{path}: got the ending '{path.suffix}', expected .csv or .npz")
    time, joints, commands, poses, notes = readers[ending](path, task)
    scale = by_kind(task, ANGLES[angle], UNITS[unit])
    poses = poses.copy()
    poses[..., :3] *= UNITS[unit]
    out = Demonstration(time, joints * scale, None if commands is None else commands * scale, _normal(poses, path), notes)
    _check(out, path, task)
    return out


def by_kind(task: Task, revolute: float, prismatic: float) -> np.ndarray:
    """One of the two numbers for each joint (n_a)."""
    return np.array([revolute if dof.kind == DofKind.Revolute else prismatic for dof in task.model.dofs[-task.model.n_a :]])


def _find_joints(names: Sequence[str], task: Task, place: str) -> tuple[list[int], list[str]]:
    """Columns of the joints of the model, in its order, among the names of a file."""
    known = task.model.joint_names
    short = [name.split("/", 1)[1] for name in known]
    columns = []
    for name, plain in zip(known, short):
        fitting = [i for i, given in enumerate(names) if given == name or (given == plain and short.count(plain) == 1)]
        if len(fitting) != 1:
            found = f"{len(fitting)} columns" if fitting else "none"
            raise InvalidInput(f"{place}: joint {name}: got {found}, expected one of that name; the file has {', '.join(names) or 'no names'}")
        columns.append(fitting[0])
    in_order = columns == sorted(columns)
    return columns, [] if in_order else [f"joints are taken by their names, which stand in another order than in the model: {', '.join(names[i] for i in sorted(columns))}"]


def _read_csv(file: Path, task: Task) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray, list[str]]:
    table = read_csv(file)
    head = table.names
    if len(table.cells) < 2:
        raise InvalidInput(f"{file}: got {len(table.cells)} rows of numbers, expected a head and at least two")

    def column(name: str) -> np.ndarray:
        values = np.empty(len(table.cells))
        for k, row in enumerate(table.cells):
            given = row[head.index(name)]
            try:
                values[k] = float(given.replace("_", "?"))  # Python takes 1_0 for 10
            except ValueError:
                raise InvalidInput(f"{file}:{table.lines[k]}: {name}: got '{given}', expected a number") from None
        return values

    if "time_s" not in head:
        raise InvalidInput(f"{file}: time_s: got no such column, expected the time [s]; the file has {', '.join(head)}")
    of_joint = {name: re.sub(r"^q_(?!cmd_)", "", name) for name in head if name != "time_s" and not name.startswith(("q_cmd_", "velocity_", "torque_"))}
    given, names = list(of_joint), list(of_joint.values())
    columns, notes = _find_joints(names, task, str(file))
    joints = np.column_stack([column(given[i]) for i in columns])
    wanted = [f"q_cmd_{names[i]}" for i in columns]
    missing = [name for name in wanted if name not in head]
    if missing and len(missing) < len(wanted):
        notes.append(f"commands are not read, because there is no column {', '.join(missing)}")
    commands = None if missing else np.column_stack([column(name) for name in wanted])
    poses = np.empty((len(joints), len(task.model.object_names), len(POSE)))
    for k, name in enumerate(task.model.object_names):
        for i, axis in enumerate(POSE):
            if f"{name}_{axis}" not in head:
                raise InvalidInput(f"{file}: {name}_{axis}: got no such column, expected the pose of the object as {', '.join(f'{name}_{a}' for a in POSE)}")
            poses[:, k, i] = column(f"{name}_{axis}")
    return column("time_s"), joints, commands, poses, notes


def _read_npz(file: Path, task: Task) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray, list[str]]:
    arrays = read_npz(file, ("time", "q", "joints", "poses", "objects"), "arrays of a demonstration")
    model = task.model
    times, names, objects = len(np.atleast_1d(arrays["time"])), list(map(str, np.atleast_1d(arrays["joints"]))), list(map(str, np.atleast_1d(arrays["objects"])))
    columns, notes = _find_joints(names, task, str(file))
    if missing := [name for name in model.object_names if name not in objects]:
        raise InvalidInput(f"{file}: objects: got {', '.join(objects)}, expected also {', '.join(missing)}")
    shapes = {"time": (times,), "q": (times, len(names)), "q_cmd": (times, len(names)), "poses": (times, len(objects), len(POSE))}
    numbers = {name: _numbers(arrays[name], shape, f"{file}: {name}") for name, shape in shapes.items() if name in arrays}
    poses = numbers["poses"][:, [objects.index(name) for name in model.object_names]]
    return numbers["time"], numbers["q"][:, columns], numbers["q_cmd"][:, columns] if "q_cmd" in numbers else None, poses, notes


def _numbers(array: np.ndarray, shape: tuple[int, ...], place: str) -> np.ndarray:
    if array.dtype.kind not in "fiu":
        raise InvalidInput(f"{place}: got an array of {array.dtype}, expected numbers")
    if array.shape != shape:
        raise InvalidInput(f"{place}: got the shape {array.shape}, expected {shape}")
    return np.asarray(array, dtype=float)


def _normal(poses: np.ndarray, file: Path) -> np.ndarray:
    """With unit quaternions that do not change their sign from one time to the next."""
    length = np.linalg.norm(poses[..., 3:], axis=2)
    off = np.argwhere(~(np.abs(length - 1) < 0.02))
    if len(off):
        k, i = off[0]
        raise InvalidInput(f"{file}: time {k}: quaternion of object {i}: got length {length[k, i]:.3g}, expected 1, as qx, qy, qz, qw")
    poses[..., 3:] /= length[..., None]
    for k in range(1, len(poses)):
        flipped = np.sum(poses[k, :, 3:] * poses[k - 1, :, 3:], axis=1) < 0
        poses[k, flipped, 3:] *= -1
    return poses


def _check(demonstration: Demonstration, file: Path, task: Task) -> None:
    time, joints, poses = demonstration.time, demonstration.joints, demonstration.poses
    for name, values in (("time_s", time), ("joints", joints), ("poses", poses), ("commands", demonstration.commands)):
        if values is not None and not np.isfinite(values).all():
            raise InvalidInput(f"{file}: {name}: got a number that is not finite at time {int(np.argwhere(~np.isfinite(values))[0][0])}, expected numbers")
    if len(time) < 2 or (np.diff(time) <= 0).any():
        k = int(np.argmax(np.diff(time) <= 0)) if len(time) > 1 else 0
        raise InvalidInput(f"{file}: time_s: got {time[min(k + 1, len(time) - 1)]:g} after {time[k]:g}, expected times that increase")
    _check_units(demonstration, file, task)
    _check_jumps(demonstration, file, task)
    _check_limits(demonstration, file, task)


def _check_units(demonstration: Demonstration, file: Path, task: Task) -> None:
    """Lengths a thousand times too large, angles in degrees: what fits the task once it is divided."""
    start = poses_of_objects(task.model, task.q_start[None])[0, :, :3]
    size = max(1.0, float(np.abs(start).max()))
    largest = float(np.median(np.abs(demonstration.poses[..., :3]).max(axis=(1, 2))))
    if largest > 20 * size and largest / 1000 < 20 * size:
        raise InvalidInput(f"{file}: got positions of {largest:.0f} m, where the task has {size:.2g} m; are they millimetres? --unit mm (unit='mm') reads them")
    if largest > 20 * size:
        raise InvalidInput(f"{file}: got positions of {largest:.0f} m, expected metres near those of the task, {size:.2g} m")
    revolute = by_kind(task, 1, 0) > 0
    angles = np.abs(demonstration.joints[:, revolute])
    if angles.size and angles.max() > 4 * math.pi:
        raise InvalidInput(f"{file}: got joint angles of {angles.max():.0f} rad; are they degrees? --angle deg (angle='deg') reads them")


def _check_limits(demonstration: Demonstration, file: Path, task: Task) -> None:
    model = task.model
    room = by_kind(task, 0.05, 0.01)  # a measured joint may be a little beyond
    beyond = (demonstration.joints < model.lower - room) | (demonstration.joints > model.upper + room)
    if beyond.any():
        k, j = map(int, np.argwhere(beyond)[0])
        value, name = demonstration.joints[k, j], model.joint_names[j]
        raise InvalidInput(
            f"{file}: {name}: got {value:.3f} at {demonstration.time[k]:.2f} s, expected {model.lower[j]:.3f} to {model.upper[j]:.3f}; are joints in another order than their names say?"
        )


def _check_jumps(demonstration: Demonstration, file: Path, task: Task) -> None:
    dt = np.diff(demonstration.time)
    fastest = by_kind(task, FAST_REVOLUTE, FAST_PRISMATIC)
    speed = np.abs(np.diff(demonstration.joints, axis=0)) / dt[:, None]
    if (speed > fastest).any():
        k, j = map(int, np.argwhere(speed > fastest)[0])
        change = demonstration.joints[k + 1, j] - demonstration.joints[k, j]
        raise InvalidInput(f"{file}: {task.model.joint_names[j]}: got a jump by {change:.3f} between {demonstration.time[k]:.3f} s and {demonstration.time[k + 1]:.3f} s, expected a motion")
    p, rotation = demonstration.poses[..., :3], demonstration.poses[..., 3:]
    moved = np.linalg.norm(np.diff(p, axis=0), axis=2)
    turned = 2 * np.arccos(np.clip(np.abs(np.sum(rotation[1:] * rotation[:-1], axis=2)), 0, 1))
    jumps = np.argwhere((moved > FAST_OBJECT * dt[:, None]) | (turned > FAST_TURN * dt[:, None]))
    if len(jumps):
        k, i = map(int, jumps[0])
        raise InvalidInput(
            f"{file}: {task.model.object_names[i]}: got a jump by {moved[k, i]:.3f} m and {turned[k, i]:.2f} rad between {demonstration.time[k]:.3f} s and "
            f"{demonstration.time[k + 1]:.3f} s, expected a motion; was the object lost from sight?"
        )
