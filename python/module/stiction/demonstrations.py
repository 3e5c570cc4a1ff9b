"""Demonstrations, and their repair: plans that follow them as nearly as contact allows (docs/demonstrations.md)."""

from __future__ import annotations

import csv
import math
import os
import re
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import _command
from ._core import DofKind, InvalidInput, Model, Plan, Status, Task, check_plan, load_task, optimize, plan, refine
from ._files import require_folder
from .exports import POSE, poses_of_objects

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}
ANGLES = {"rad": 1.0, "deg": math.pi / 180}
FAST_OBJECT, FAST_TURN, FAST_REVOLUTE, FAST_PRISMATIC = 5.0, 50.0, 20.0, 5.0  # no hand moves faster [m/s], [rad/s]: such a change is a jump
STEP_REVOLUTE, STEP_PRISMATIC = 0.03, 0.01  # of a command between two times of a reference [rad], [m]
MOST_TIMES = 2000
SHAKING = 1.5  # times the way of joints that are smoothed: they shake
SMOOTHING_S = 0.08  # standard deviation of the weights of what is smoothed [s]
WINDOW, KEPT = 16, 4  # times that are optimised at once, and of these the ones that are kept
ITERATIONS = 6
SETTLING = 20  # steps that the object has to come to rest at the start
JOINT_WEIGHT = 0.03  # of a largest move of a joint beside a tolerance of the object
KAPPA = 300.0  # of the smoothed models [1/J]
LOST = 20.0  # an object that is so many tolerances from where it was shown does not come back
FINENESS = (1, 2, 4)  # parts of a largest move that are tried, until the check accepts the plan
BOUND = 0.2  # of a command from its joint [rad or m]
NEAR = 1.5  # tolerances that an object may be off where the planner goes on
KEYFRAME = 8.0  # tolerances by which an object moves between two poses that the planner brings it to
PLANS = 3  # to one pose
PLAN_S = 10.0  # for one of them [s]
ARRIVED = 0.8  # of a tolerance
HALF = 0.5  # of a demonstration: an object that is lost before is lost in finer steps as well


@dataclass(frozen=True)
class Demonstration:
    """Joints and objects over time, by the names and units of a model."""

    time: np.ndarray  # (times) [s], increasing
    joints: np.ndarray  # (times, n_a) [rad or m]
    commands: np.ndarray | None  # the same, as the robot was commanded
    poses: np.ndarray  # (times, objects, 7): x y z [m] qx qy qz qw, in the world
    notes: list[str] = field(default_factory=list)  # what was read otherwise than it stands


@dataclass(frozen=True)
class Repair:
    """A plan, and how it differs from the demonstration."""

    plan: Plan
    demonstration: Demonstration
    times: np.ndarray  # (N) of the demonstration at which the two are compared [s]
    position_error: np.ndarray  # (N) of the object of the goal [m]
    angle_error: np.ndarray  # (N) [rad]
    joint_change: np.ndarray  # (N) the largest change of a joint [rad or m]
    start_moved: tuple[float, float]  # by which the object came to rest at the start [m], [rad]
    complete: bool  # the plan follows the demonstration to its end
    accepted: bool  # by check_plan(), which simulates it in half the steps
    planned_from: float | None  # time from which the planner brought the object where it was shown, and joints went their own ways [s]
    wall_s: float

    @property
    def holds(self) -> bool:
        """It ends where the demonstration ends, within the tolerances of the task, also in half the steps."""
        return self.complete and self.plan.status == Status.Solved and self.accepted

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """Less is better."""
        goal = self.plan.task.goal
        return not self.holds, not self.complete, -float(self.times[-1]), self.plan.error.position / goal.tol_position + self.plan.error.angle / goal.tol_angle

    def sentences(self) -> list[str]:
        """What had to change."""
        goal = self.plan.task.goal
        out = list(self.demonstration.notes)
        if self.start_moved[0] > 1e-4 or self.start_moved[1] > 1e-3:
            out.append(f"at the start the object moves by {1e3 * self.start_moved[0]:.1f} mm and {self.start_moved[1]:.3f} rad until it rests on what touches it")
        if self.planned_from is not None:
            out.append(f"from {self.planned_from:.2f} s on joints go other ways, planned from one pose of the object to the next: near what was shown the object is lost")
        worst = int(np.argmax(self.joint_change))
        out.append(f"joints change by up to {self.joint_change[worst]:.3f} rad or m, the most at {self.times[worst]:.2f} s")
        worst = int(np.argmax(self.position_error / goal.tol_position + self.angle_error / goal.tol_angle))
        out.append(f"the object is off by up to {1e3 * self.position_error[worst]:.1f} mm and {self.angle_error[worst]:.3f} rad, the most at {self.times[worst]:.2f} s")
        out.append(f"at the end it is off by {1e3 * self.position_error[-1]:.1f} mm and {self.angle_error[-1]:.3f} rad")
        if not self.complete:
            out.append(f"the plan ends at {self.times[-1]:.2f} s of {self.demonstration.time[-1]:.2f} s: the object is lost there, or the time was used up")
        elif not self.accepted:
            out.append("`stiction check` does not accept the plan, which depends on the size of its steps: carry it out with feedback (`stiction run`), or show a simpler motion")
        return out


# ---- reading


def read_demonstration(file: str | os.PathLike[str], task: Task, *, unit: str = "m", angle: str = "rad") -> Demonstration:
    """A demonstration from a table (.csv) or arrays (.npz), as `stiction export` writes them.

      csv: a column time_s, q_JOINT or JOINT for every joint (ROBOT/ may be left out where that is clear), for every object OBJECT_x … OBJECT_qw; q_cmd_JOINT
        of commands if there are. Other columns are not read.
      npz: time, q (times, joints) with joints (names), poses (times, objects, 7) with objects; q_cmd if there is.
      unit, angle: of lengths (m, cm, mm) and angles (rad, deg) in the file.

    Raises InvalidInput: what is missing, times that do not increase, quaternions that are none, jumps, units that cannot be meant.
    """
    path = Path(file)
    if unit not in UNITS or angle not in ANGLES:
        raise InvalidInput(f"unit, angle: got '{unit}', '{angle}', expected one of {', '.join(UNITS)} and of {', '.join(ANGLES)}")
    readers: dict[str, Callable[[Path, Task], tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray, list[str]]]] = {".csv": _read_csv, ".npz": _read_npz}
    if path.suffix not in readers:
        raise InvalidInput(f"{path}: got the ending '{path.suffix}', expected .csv or .npz")
    time, joints, commands, poses, notes = readers[path.suffix](path, task)
    scale = np.array([UNITS[unit] if dof.kind == DofKind.Prismatic else ANGLES[angle] for dof in _joints(task)])
    poses = poses.copy()
    poses[..., :3] *= UNITS[unit]
    out = Demonstration(time, joints * scale, None if commands is None else commands * scale, _normal(poses, path), notes)
    _check(out, path, task)
    return out


def _joints(task: Task) -> list[Any]:
    return task.model.dofs[-task.model.n_a :]


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
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            rows = [row for row in csv.reader(text) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{file}: cannot be read ({error}), expected a table") from None
    if len(rows) < 3:
        raise InvalidInput(f"{file}: got {max(len(rows) - 1, 0)} rows of numbers, expected a head and at least two")
    head = [name.strip() for name in rows[0]]

    def column(name: str, index: int) -> np.ndarray:
        values = np.empty(len(rows) - 1)
        for k, row in enumerate(rows[1:]):
            try:
                values[k] = float(row[index])
            except (ValueError, IndexError):
                given = row[index] if index < len(row) else "nothing"
                raise InvalidInput(f"{file}:{k + 2}: {name}: got '{given}', expected a number") from None
        return values

    if "time_s" not in head:
        raise InvalidInput(f"{file}: time_s: got no such column, expected the time [s]; the file has {', '.join(head)}")
    named = {re.sub(r"^q_(?!cmd_)", "", name): i for i, name in enumerate(head) if not name.startswith(("q_cmd_", "velocity_", "torque_"))}
    names = [name for name in named if name != "time_s"]
    columns, notes = _find_joints(names, task, str(file))
    joints = np.column_stack([column(names[i], named[names[i]]) for i in columns])
    wanted = [f"q_cmd_{names[i]}" for i in columns]
    commands = np.column_stack([column(name, head.index(name)) for name in wanted]) if all(name in head for name in wanted) else None
    poses = np.empty((len(joints), len(task.model.object_names), len(POSE)))
    for k, name in enumerate(task.model.object_names):
        for i, axis in enumerate(POSE):
            if f"{name}_{axis}" not in head:
                raise InvalidInput(f"{file}: {name}_{axis}: got no such column, expected the pose of the object as {', '.join(f'{name}_{a}' for a in POSE)}")
            poses[:, k, i] = column(f"{name}_{axis}", head.index(f"{name}_{axis}"))
    return column("time_s", head.index("time_s")), joints, commands, poses, notes


def _read_npz(file: Path, task: Task) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray, list[str]]:
    try:
        with np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{file}: cannot be read ({error}), expected arrays") from None
    model = task.model
    for name in ("time", "q", "joints", "poses", "objects"):
        if name not in arrays:
            raise InvalidInput(f"{file}: {name}: got none, expected arrays time, q, joints, poses, objects; the file has {', '.join(arrays) or 'nothing'}")
    columns, notes = _find_joints([str(name) for name in arrays["joints"]], task, str(file))
    time, objects = np.asarray(arrays["time"], dtype=float), [str(name) for name in arrays["objects"]]
    missing = [name for name in model.object_names if name not in objects]
    if missing:
        raise InvalidInput(f"{file}: objects: got {', '.join(objects)}, expected also {', '.join(missing)}")
    shapes = {"q": (len(time), len(arrays["joints"])), "poses": (len(time), len(objects), len(POSE))}
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise InvalidInput(f"{file}: {name}: got the shape {arrays[name].shape}, expected {shape}")
    commands = arrays.get("q_cmd")
    poses = np.asarray(arrays["poses"], dtype=float)[:, [objects.index(name) for name in model.object_names]]
    return time, np.asarray(arrays["q"], dtype=float)[:, columns], None if commands is None else np.asarray(commands, dtype=float)[:, columns], poses, notes


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
    revolute = np.array([dof.kind == DofKind.Revolute for dof in _joints(task)])
    angles = np.abs(demonstration.joints[:, revolute])
    if angles.size and angles.max() > 4 * math.pi:
        raise InvalidInput(f"{file}: got joint angles of {angles.max():.0f} rad; are they degrees? --angle deg (angle='deg') reads them")


def _check_limits(demonstration: Demonstration, file: Path, task: Task) -> None:
    model = task.model
    room = np.array([0.05 if dof.kind == DofKind.Revolute else 0.01 for dof in _joints(task)])  # a measured joint may be a little beyond
    beyond = (demonstration.joints < model.lower - room) | (demonstration.joints > model.upper + room)
    if beyond.any():
        k, j = map(int, np.argwhere(beyond)[0])
        value, name = demonstration.joints[k, j], model.joint_names[j]
        raise InvalidInput(
            f"{file}: {name}: got {value:.3f} at {demonstration.time[k]:.2f} s, expected {model.lower[j]:.3f} to {model.upper[j]:.3f}; are joints in another order than their names say?"
        )


def _check_jumps(demonstration: Demonstration, file: Path, task: Task) -> None:
    dt = np.diff(demonstration.time)
    fastest = np.array([FAST_REVOLUTE if dof.kind == DofKind.Revolute else FAST_PRISMATIC for dof in _joints(task)])
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


# ---- repairing


def repair(task: Task, demonstration: Demonstration, *, timeout_s: float = 120.0, threads: int = 0, on_progress: Callable[[float], bool | None] | None = None) -> Repair:
    """A plan that follows the demonstration and obeys contact: nothing penetrates, forces are in their cones and within the motors.

    Windows of the demonstration are tracked one after the other by trajectory optimisation (iMPC) from where the window before has led to in the exact model.
    Objects count first, joints may leave the demonstration where that brings the object nearer. The goal of the plan is where the demonstration ends.
      timeout_s: [s] > 0. on_progress: called with the share that is done; False ends the repair.

    Raises InvalidInput.
    """
    begin = clock.monotonic()
    demonstration = _calm(demonstration)
    best: Repair | None = None
    going_on = True

    def left() -> float:
        return timeout_s - (clock.monotonic() - begin)

    def tell(followed: _Follower) -> None:
        nonlocal going_on
        going_on = on_progress is None or on_progress(followed.share) is not False

    def plan_on(reference: _Reference, followed: _Follower) -> None:
        nonlocal best
        if best is None or best.holds or not going_on or left() < 0 or not followed.cut():
            return
        for index in followed.keyframes():
            if going_on and left() > 0 and followed.plan_to(index, left()):
                tell(followed)
        best = _better(best, _result(reference, followed, demonstration, clock.monotonic() - begin))

    tracked: list[tuple[_Reference, _Follower]] = []
    finest: _Reference | None = None
    for fineness in FINENESS:
        reference = _Reference(task, demonstration, fineness)
        if best is not None and (best.holds or not going_on or left() < 0 or finest is None or len(reference.q) == len(finest.q)):
            break
        finest, followed = reference, _Follower(reference, threads)
        while going_on and not followed.ended and left() > 0:
            followed.go_on(left())
            tell(followed)
        best = _better(best, _result(reference, followed, demonstration, clock.monotonic() - begin))
        if followed.share_near < HALF:  # finer steps would lose it as well
            plan_on(reference, followed)
        else:
            tracked.append((reference, followed))
    for reference, followed in tracked:  # the planner goes on where the object was lost
        plan_on(reference, followed)
    assert best is not None
    return best


def _better(best: Repair | None, tried: Repair) -> Repair:
    return tried if best is None or tried.rank < best.rank else best


def _calm(demonstration: Demonstration) -> Demonstration:
    """Without the noise of single frames, where joints go back and forth much more than forward; else as it is."""
    smooth = _smooth(demonstration.time, demonstration.joints)

    def way(joints: np.ndarray) -> float:
        return float(np.abs(np.diff(joints, axis=0)).sum())

    if way(demonstration.joints) <= SHAKING * way(smooth):
        return demonstration
    poses = _smooth(demonstration.time, demonstration.poses.reshape(len(demonstration.time), -1)).reshape(demonstration.poses.shape)
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
    note = f"joints shake from one time to the next: everything is smoothed over {2 * SMOOTHING_S:.2f} s"
    commands = None if demonstration.commands is None else _smooth(demonstration.time, demonstration.commands)
    return replace(demonstration, joints=smooth, poses=poses, commands=commands, notes=[*demonstration.notes, note])


def _smooth(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """At each time the line that fits the values around it best; a motion that is straight stays as it is, also at its ends."""
    out = np.empty_like(values)
    for k, t in enumerate(time):
        first, last = np.searchsorted(time, [t - 3 * SMOOTHING_S, t + 3 * SMOOTHING_S])
        x = time[first:last] - t
        w = np.exp(-0.5 * (x / SMOOTHING_S) ** 2)
        s0, s1, s2 = w.sum(), (w * x).sum(), (w * x * x).sum()
        share = s0 * s2 - s1 * s1
        weights = w * (s2 - s1 * x) / share if share > 1e-9 * s0 * s2 and len(x) > 2 else w / s0
        out[k] = weights @ values[first:last]
    return out


class _Reference:
    """The demonstration at times between which no command moves farther than a sub-step, as configurations of the model."""

    def __init__(self, task: Task, demonstration: Demonstration, fineness: int) -> None:
        model = task.model
        largest = np.array([STEP_REVOLUTE if dof.kind == DofKind.Revolute else STEP_PRISMATIC for dof in _joints(task)]) / fineness
        parts = np.abs(np.diff(demonstration.joints, axis=0) / largest).max(axis=1)
        way = np.concatenate([[0], np.cumsum(np.maximum(parts, 1e-3))])  # in largest moves of a joint; where joints rest time goes by quickly
        count = min(max(math.ceil(way[-1] - 1e-9), 2), MOST_TIMES)
        self.times = np.interp(np.linspace(0, way[-1], count + 1), way, demonstration.time)

        def at_times(values: np.ndarray) -> np.ndarray:
            return np.column_stack([np.interp(self.times, demonstration.time, column) for column in values.reshape(len(values), -1).T])

        joints = np.clip(at_times(demonstration.joints), model.lower, model.upper)
        self.commands = joints if demonstration.commands is None else np.clip(at_times(demonstration.commands), model.lower, model.upper)
        poses = at_times(demonstration.poses).reshape(len(self.times), -1, len(POSE))
        poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
        states = [_configuration(model, task.q_start, poses[0], joints[0])]
        for pose, q in zip(poses[1:], joints[1:]):
            states.append(_configuration(model, states[-1], pose, q))
        self.q = np.vstack(states)
        self.task = task.with_(start=self.q[0], goal=_goal_of(task, self.q[-1]))


def _configuration(model: Model, near: np.ndarray, poses: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """The configuration with these joints whose objects are nearest to the poses: Gauss-Newton on positions and rotations, from one that is near."""
    q = near.copy()
    q[-model.n_a :] = joints
    for _ in range(20):
        error = _pose_error(model, q, poses)
        slope = np.empty((len(error), model.n_vu))
        for k in range(model.n_vu):
            step = np.zeros(model.n_v)
            step[k] = 1e-6
            slope[:, k] = (_pose_error(model, model.retract(q, step), poses) - error) / 1e-6
        change = np.zeros(model.n_v)
        change[: model.n_vu] = -np.linalg.lstsq(slope, error, rcond=None)[0]
        q = model.retract(q, change)
        if np.abs(change).max() < 1e-9:
            break
    return q


def _pose_error(model: Model, q: np.ndarray, poses: np.ndarray) -> np.ndarray:
    out = []
    for name, pose in zip(model.object_names, poses):
        at = model.object_pose(q, name)
        out += [at.p - pose[:3], 0.5 * (at.R - rotation_matrix(pose[3:])).ravel()]
    return np.concatenate(out)


def rotation_matrix(xyzw: np.ndarray) -> np.ndarray:
    """Of a unit quaternion x y z w."""
    x, y, z, w = xyzw
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _goal_of(task: Task, q: np.ndarray) -> np.ndarray:
    """What a task takes as the goal for where its object is at q."""
    info = task.model.objects[task.goal.object]
    if info.n_q != 7:
        return q[info.q_begin : info.q_begin + info.n_q]
    pose = task.model.object_pose(q, info.name)
    R = pose.R
    pitch = math.asin(float(np.clip(-R[2, 0], -1, 1)))
    return np.array([*pose.p, math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])])


class _Follower:
    """Commands so far, and where they lead in the exact model, in full steps and, as `check` takes them, in half ones."""

    def __init__(self, reference: _Reference, threads: int) -> None:
        self._reference, self._task, self._threads = reference, reference.task, threads
        self.commands = np.empty((0, self._task.model.n_a))
        self.states = self.halves = reference.q[:1]  # after each command
        self.marks, self.indices = [0], [0]  # states at times of the reference, and which times
        self._u = reference.commands[0]
        self._failed = False
        self.planned_from: int | None = None  # index of the reference from which the planner went on
        for _ in range(SETTLING):  # the object comes to rest on what touches it
            self._failed = self._failed or not self._carry_out(reference.commands[0])
        self.marks = [len(self.states) - 1]

    def _carry_out(self, command: np.ndarray) -> bool:
        """Another command. False: a step has no solution."""
        full = self._task.with_(start=self.states[-1]).follow(command[None], u_start=self._u)
        half = self._task.with_(start=self.halves[-1]).follow(np.vstack([0.5 * (self._u + command), command]), u_start=self._u)
        if Status.NumericalFailure in (full.status, half.status):
            return False
        self.commands, self._u = np.vstack([self.commands, command]), command
        self.states, self.halves = np.vstack([self.states, full.q[-1:]]), np.vstack([self.halves, half.q[-1:]])
        return True

    def _mark(self, index: int) -> None:
        """The last state is where the reference is at this index."""
        self.marks.append(len(self.states) - 1)
        self.indices.append(index)

    @property
    def at(self) -> int:
        return self.indices[-1]

    @property
    def ended(self) -> bool:
        return self._failed or self.at == len(self._reference.q) - 1

    @property
    def failed(self) -> bool:
        return self._failed

    @property
    def share(self) -> float:
        return self.at / (len(self._reference.q) - 1)

    def go_on(self, timeout_s: float) -> None:
        """Another window."""
        end = len(self._reference.q) - 1
        last = min(self.at + WINDOW, end)
        window = np.vstack([self.states[-1:], self._between(self._reference.q[self.at + 1 : last + 1])])
        guess = self._reference.commands[self.at + 1 : last + 1]
        found = optimize(self._task, section=self._section(len(guess)), reference=window, u_guess=guess, u_before=self._u, threads=self._threads, timeout_s=timeout_s)
        if not len(found.u):
            self._failed = True
            return
        for command in found.u if last == end else found.u[:KEPT]:
            if not self._carry_out(command):
                self._failed = True
                return
            self._mark(self.at + 1)
        name, goal = self._task.model.object_names[self._task.goal.object], self._task.goal
        off = self._task.model.object_pose(self.states[-1], name).p - self._task.model.object_pose(self._reference.q[self.at], name).p
        self._failed = bool(np.linalg.norm(off) > LOST * goal.tol_position)

    def _between(self, window: np.ndarray) -> np.ndarray:
        """A window whose objects are moved by half of what half steps lead elsewhere, so that what was shown lies in the middle."""
        model = self._task.model
        apart = model.local(self.states[-1], self.halves[-1])
        apart[model.n_vu :] = 0
        return np.array([model.retract(q, -0.5 * apart) for q in window])

    def _tolerances_off(self, q: np.ndarray, index: Any) -> np.ndarray:
        """Of the object from the reference, (N)."""
        goal = self._task.goal
        position, angle = _off(self._task, q, np.atleast_2d(self._reference.q[index]))
        return position / goal.tol_position + angle / goal.tol_angle

    def _near(self) -> np.ndarray:
        """Times of the reference up to which the object was near where it was shown, in full and in half steps, as indices into marks."""
        off = np.maximum(*(self._tolerances_off(q[self.marks], self.indices) for q in (self.states, self.halves)))
        return np.flatnonzero(off <= NEAR)

    @property
    def share_near(self) -> float:
        """Of the demonstration, up to where the object was last near where it was shown."""
        near = self._near()
        return self.indices[int(near[-1])] / (len(self._reference.q) - 1) if len(near) else 0.0

    def cut(self) -> bool:
        """Back to the last time at which the object was near where it was shown, in full and in half steps, before anything that `check` refuses on the way.
        False: it never was."""
        first = self._first_refused()
        near = [k for k in self._near() if self.marks[k] < first]
        if not near:
            return False
        last = int(near[-1])
        self.marks, self.indices = self.marks[: last + 1], self.indices[: last + 1]
        self._take_back(self.marks[-1])
        self._failed = False
        return True

    def _first_refused(self) -> float:
        """The first knot of which `check` names a fault; infinite: none, or only where it ends."""
        places = [re.search(r"segment 0, knot (\d+)", item.where) for item in check_plan(self._task.follow(self.commands)).items if not item.pass_]
        return min((int(place[1]) for place in places if place is not None), default=math.inf)

    def keyframes(self) -> list[int]:
        """Times of the reference that are left, between which the object moves by some tolerances; its end is the last one."""
        end, out, last = len(self._reference.q) - 1, [], self.at
        for index in range(self.at + 1, end):
            if self._tolerances_off(self._reference.q[index][None], last)[0] >= KEYFRAME:
                out.append(index)
                last = index
        return [*out, end]

    def plan_to(self, index: int, timeout_s: float) -> bool:
        """Brings the object where it was shown at that time; joints go their own ways. False: it is not there."""
        begin, enough = clock.monotonic(), 1.0 if index == len(self._reference.q) - 1 else NEAR
        for attempt in range(PLANS):
            left = min(PLAN_S, timeout_s - (clock.monotonic() - begin))
            if left <= 0 or self._arrived(index) <= ARRIVED:
                break
            task = self._task.with_(goal=_goal_of(self._task, self._between(self._reference.q[index][None])[0]))
            found = plan(task, q_start=self.states[-1], u_start=self._u, seed=attempt, threads=self._threads, timeout_s=left)
            if found.status != Status.Solved:
                continue
            fine = refine(found.plan, threads=self._threads, timeout_s=left).plan  # in steps so small that half ones lead there as well
            before, count = self._arrived(index), len(self.commands)
            if not all(self._carry_out(command) for command in np.asarray(fine.u)[1:]) or self._arrived(index) >= before:
                self._take_back(count)
                continue
            self.planned_from = self.at if self.planned_from is None else self.planned_from
        if self._arrived(index) > enough:
            return False
        self._mark(index)
        return True

    def _take_back(self, count: int) -> None:
        """To where so many commands have led."""
        self.commands, self.states, self.halves = self.commands[:count], self.states[: count + 1], self.halves[: count + 1]
        self._u = self.commands[-1]

    def _arrived(self, index: int) -> float:
        """The largest share of its tolerances by which the object is off, in full and in half steps."""
        goal = self._task.goal
        offs = [_off(self._task, q[-1:], self._reference.q[index][None]) for q in (self.states, self.halves)]
        return max(max(position[0] / goal.tol_position, angle[0] / goal.tol_angle) for position, angle in offs)

    def _section(self, horizon: int) -> dict[str, Any]:
        """Objects in their tolerances, joints in largest moves."""
        goal, model = self._task.goal, self._task.model
        objects = {}
        for info in model.objects:
            dofs = model.dofs[info.v_begin : info.v_begin + info.n_v]
            objects[info.name] = [1 / (goal.tol_angle if dof.kind == DofKind.Revolute else goal.tol_position) ** 2 for dof in dofs]
        joints = [JOINT_WEIGHT / (STEP_REVOLUTE if dof.kind == DofKind.Revolute else STEP_PRISMATIC) ** 2 for dof in _joints(self._task)]
        weights = {"objects": objects, "objects_final": objects, "robots": joints, "robots_final": joints, "input": joints}
        return {"horizon": horizon, "iterations": ITERATIONS, "tolerance": 1e-3, "input_bound": BOUND, "analytic": {"kappa": KAPPA}, "weights": weights}


def _result(reference: _Reference, followed: _Follower, demonstration: Demonstration, wall_s: float) -> Repair:
    task, n_a = reference.task, reference.task.model.n_a
    states, shown = followed.states[followed.marks], reference.q[followed.indices]
    position, angle = _off(task, states, shown)
    made = task.follow(followed.commands)
    return Repair(
        plan=made,
        demonstration=demonstration,
        times=reference.times[followed.indices],
        position_error=position,
        angle_error=angle,
        joint_change=np.abs(states[:, -n_a:] - shown[:, -n_a:]).max(axis=1),
        start_moved=(float(position[0]), float(angle[0])),
        complete=followed.at == len(reference.q) - 1 and not followed.failed,
        accepted=check_plan(made).pass_,
        planned_from=None if followed.planned_from is None else float(reference.times[followed.planned_from]),
        wall_s=wall_s,
    )


def _off(task: Task, q: np.ndarray, shown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far the object of the goal is at q from where it is at `shown` (N) [m], [rad]."""
    name = task.model.object_names[task.goal.object]
    is_at, was_at = task.model.object_poses(q, name), task.model.object_poses(shown, name)
    angle = 2 * np.arccos(np.clip(np.abs(np.sum(is_at[:, 3:] * was_at[:, 3:], axis=1)), 0, 1))
    return np.linalg.norm(is_at[:, :3] - was_at[:, :3], axis=1), angle


def main(words: Sequence[str]) -> int:
    """`stiction repair`"""
    parser = _command.make_parser("repair", "Makes a demonstration, which may break the laws of contact, into a plan of the contact model, and says what had to change.")
    parser.add_argument("task", metavar="TASK", help="name or file of a task: its scene and tolerances count")
    parser.add_argument("file", type=Path, metavar="FILE", help="joints and objects over time: .csv or .npz, as `stiction export` writes them")
    parser.add_argument("--unit", choices=list(UNITS), default="m", help="of lengths in the file (default: %(default)s)")
    parser.add_argument("--angle", choices=list(ANGLES), default="rad", help="of joint angles in the file (default: %(default)s)")
    parser.add_argument("--timeout", type=_command.positive, default=120.0, metavar="S", help="[s] (default: %(default)s)")
    parser.add_argument("--threads", type=_command.integer(0, 4096), default=0, metavar="N", help="(default: all cores)")
    parser.add_argument("-o", "--out", type=Path, default=Path("repaired"), metavar="FOLDER", help="for plan.json (default: ./%(default)s)")
    a = parser.parse_args(words)
    task = load_task(a.task)
    done = repair(task, read_demonstration(a.file, task, unit=a.unit, angle=a.angle), timeout_s=a.timeout, threads=a.threads)
    file = a.out / "plan.json"
    require_folder(file)
    done.plan.write(file)
    reached = done.holds
    sentences = done.sentences()
    rows = {"what changed" if i == 0 else "and": sentence for i, sentence in enumerate(sentences)} | {"time": f"{done.wall_s:.1f} s", "plan": str(file)}
    result: dict[str, Any] = {"status": "Done" if reached else "NotSolved", "task": task.name, "complete": done.complete, "accepted": done.accepted, "changes": sentences, "wall_s": done.wall_s, "plan": str(file)}
    result["end"] = {"position": float(done.position_error[-1]), "angle": float(done.angle_error[-1])}
    _command.report(a, f"{task.name}: {'repaired' if reached else 'not repaired to its end'}", rows, result)
    return _command.DONE if reached else _command.NOT_SOLVED
