"""A task and what was changed of it: start, goal, options, seed. Nothing here draws."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import stiction as st
from stiction.sdf import convert_sdf, is_sdf

from ..bodies import slug
from .picture import quaternions
from .texts import plain


def rpy(R: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.cos(pitch) < 1e-9:  # roll and yaw turn about the same axis
        return np.array([0.0, pitch, np.arctan2(-R[0, 1], R[1, 1])])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def rotation(angles: Sequence[float]) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """Axis times angle of a rotation [rad]."""
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    angle = np.arctan2(np.linalg.norm(sine), (np.trace(R) - 1) / 2)
    if np.linalg.norm(sine) > 1e-9:
        return angle * sine / np.linalg.norm(sine)
    _, axes = np.linalg.eigh(R + R.T)  # nothing, or half a turn about the axis that stays
    return angle * axes[:, -1]


def place(model: st.Model, q: np.ndarray, index: int, X_WB: st.Pose) -> np.ndarray:
    """q with an object as near to X_WB as its joint lets it, inside its limits."""
    info = model.objects[index]
    if info.n_q == 7:
        w, x, y, z = quaternions(X_WB.R[None])[0]
        out = q.copy()
        out[info.q_begin : info.q_begin + 7] = [*X_WB.p, x, y, z, w]
        return out
    kinematics = model.calc_kinematics(q)
    X = kinematics.X_WB[info.body]
    turn = rotation_vector(X_WB.R @ X.R.T)
    delta = np.zeros(model.n_v)
    for k in range(info.v_begin, info.v_begin + info.n_v):
        dof = model.dofs[k]
        along = X_WB.p - X.p if dof.kind == st.DofKind.Prismatic else turn
        delta[k] = kinematics.axis_W[:, k] @ along
    out = model.retract(q, delta)
    if info.n_v == 1:
        dof = model.dofs[info.v_begin]
        out[info.q_begin] = np.clip(out[info.q_begin], dof.lower, dof.upper)
    return out


def chain(model: st.Model, index: int) -> list[int]:
    """The object and those that it hangs on, from the world outwards."""
    out: list[int] = []
    while index >= 0:
        out.insert(0, index)
        index = model.objects[index].parent
    return out


def numbers(values: Any) -> list[float]:
    """As short as reads back to the same place: a nanometre, a nanoradian. What rounding leaves of 0 is 0."""
    return [round(float(f"{x:.9g}"), 12) + 0.0 for x in np.asarray(values, dtype=float)]


def names_of(model: st.Model, index: int) -> list[str]:
    """What numbers_of() are, with units."""
    if model.objects[index].n_q == 7:
        return ["x [m]", "y [m]", "z [m]", "roll [rad]", "pitch [rad]", "yaw [rad]"]
    dofs = [model.dofs[k] for i in chain(model, index) for k in range(model.objects[i].v_begin, model.objects[i].v_begin + model.objects[i].n_v)]
    return [f"{dof.name} [{'m' if dof.kind == st.DofKind.Prismatic else 'rad'}]" for dof in dofs]


def numbers_of(model: st.Model, q: np.ndarray, index: int) -> list[float]:
    """x y z roll pitch yaw of a free object, the coordinates of any other and of what it hangs on."""
    if model.objects[index].n_q == 7:
        X = model.object_pose(q, model.object_names[index])
        return numbers([*X.p, *rpy(X.R)])
    parts = [model.objects[i] for i in chain(model, index)]
    return numbers(np.concatenate([q[i.q_begin : i.q_begin + i.n_q] for i in parts]))


def ranges_of(model: st.Model, index: int) -> list[tuple[float, float] | None]:
    """Limits of own_numbers(); None where one has none."""
    info = model.objects[index]
    if info.n_q == 7:
        return [None] * 6
    limits = [(float(dof.lower), float(dof.upper)) for dof in model.dofs[info.v_begin : info.v_begin + info.n_v]]
    return [limit if np.isfinite(limit).all() and limit[0] < limit[1] else None for limit in limits]


def with_numbers(model: st.Model, q: np.ndarray, index: int, values: Sequence[float]) -> np.ndarray:
    """q with numbers_of() an object, hinges and sliders inside their limits."""
    if model.objects[index].n_q == 7:
        return place(model, q, index, st.Pose(rotation(values[3:]), values[:3]))
    out, given = q.copy(), iter(values)
    for i in chain(model, index):
        info = model.objects[i]
        for k in range(info.n_q):
            dof = model.dofs[info.v_begin + k]
            out[info.q_begin + k] = np.clip(next(given), dof.lower, dof.upper) if info.n_v == 1 else next(given)
    return out


def own_names(model: st.Model, index: int) -> list[str]:
    """What own_numbers() are, with units."""
    return names_of(model, index)[-len(own_numbers(model, model.neutral(), index)) :]


def own_numbers(model: st.Model, q: np.ndarray, index: int) -> list[float]:
    """x y z roll pitch yaw of a free object, the coordinates of any other without those of what it hangs on."""
    info = model.objects[index]
    return numbers_of(model, q, index)[-(6 if info.n_q == 7 else info.n_q) :]


def with_own_numbers(model: st.Model, q: np.ndarray, index: int, values: Sequence[float]) -> np.ndarray:
    """q with own_numbers() of an object."""
    return with_numbers(model, q, index, [*numbers_of(model, q, index)[: -len(values)], *values])


@dataclass(frozen=True)
class Snapshot:
    """Start and goal as they were."""

    start: np.ndarray
    goal: np.ndarray
    start_moved: bool
    moved_goals: frozenset[int]
    any_turn: bool
    keyframe: str


def converted(sdf: Path, folder: Path) -> tuple[Path, list[str]]:
    """The MJCF of an SDF, in `folder`, and what is otherwise in it. Raises stiction.InvalidInput, stiction.MissingExtra."""
    mjcf = folder / f"{sdf.stem}.xml"
    return mjcf, convert_sdf(sdf, mjcf)


class Problem:
    """What is planned. `spec` is a task as in a file, `folder` that of its paths; of a built-in task `name` stands for it in commands.

    `scene` is the file that a whole scene came from, `notes` what was read otherwise than it says.
    """

    def __init__(self, task: st.Task, spec: dict[str, Any], folder: Path, name: str, scene: Path | None = None, notes: Sequence[str] = ()):
        self.given, self.spec, self.folder, self.name, self.scene = task, spec, folder, name, scene
        self.model: st.Model = task.model
        self.about = plain(task.description)  # in markdown
        self.keyframes: list[str] = []  # of a scene
        self.notes = [*notes, *self.model.notes]
        self.goal_of = ""  # object of the goal of a scene; empty: the first one
        self.seed = int(task.options.seed)
        self.reset()

    @staticmethod
    def open(source: str | Path) -> Problem:
        """A built-in task by its name, or a file. Raises stiction.InvalidInput."""
        task = st.load_task(source)
        name = source if isinstance(source, str) else str(source)
        return Problem(task, {"base": str(task.file), "name": task.name}, Path(task.file).parent, name)

    @staticmethod
    def of_dict(spec: dict[str, Any], folder: Path, notes: Sequence[str] = ()) -> Problem:
        """A task that is in no file. Raises stiction.InvalidInput."""
        return Problem(st.Task(spec, base=folder), spec, folder, "", notes=notes)

    @staticmethod
    def of_scene(file: Path, folder: Path, goal_of: str = "") -> Problem:
        """A whole scene that is in one file; its task is written into `folder`, and so is the MJCF of an SDF.

        Raises ValueError: there is nothing to plan in it; stiction.MissingExtra: an SDF, and nothing that reads it.
        """
        to = folder / (f"{file.stem}_{slug(goal_of)}.yaml" if goal_of else f"{file.stem}.yaml")
        mjcf, notes = converted(file, folder) if is_sdf(file) else (file, list[str]())
        try:
            task = st.import_scene(mjcf, out=to, object=goal_of)
        except st.InvalidInput as error:
            message = str(error).replace(str(mjcf), str(file))
            raise ValueError(message + (". A robot without objects is opened under 'Own', where it gets one" if "without an object" in message else "")) from None
        made = Problem(task, {"base": to.name, "name": file.stem}, folder, to.name, file.resolve(), notes)
        made.keyframes = st.list_keyframes(mjcf)
        made.goal_of = goal_of
        found = [line.removeprefix("# ") for line in to.read_text(encoding="utf-8").splitlines() if line.startswith("# ")]
        made.about = f"**Found in {plain(file.name)}**  \n" + plain("  \n".join(found))
        return made

    def with_goal_of(self, index: int) -> Problem:
        """The same scene with another object to be moved. Raises ValueError."""
        assert self.scene is not None
        made = Problem.of_scene(self.scene, self.folder, self.model.object_names[index])
        made.seed, made.options = self.seed, dict(self.options)
        if self.start_moved:
            made.start, made.start_moved, made.keyframe = self.start.copy(), True, self.keyframe
            made.goal[made.model.n_qu :] = made.start[made.model.n_qu :]
        return made

    def reset(self) -> None:
        """Start, goal and options of the task."""
        self.start = np.array(self.given.q_start)
        self.goal = np.concatenate([self.given.q_goal, self.start[self.model.n_qu :]])
        self.start_moved = False
        self.keyframe = ""  # where the start was put last; empty: where it is given
        self.moved_goals: set[int] = set()  # objects whose goals are other than the task's
        self.any_turn = self.given_any_turn()
        self.options: dict[str, Any] = {}

    # ---- changes ----

    def snapshot(self) -> Snapshot:
        return Snapshot(self.start.copy(), self.goal.copy(), self.start_moved, frozenset(self.moved_goals), self.any_turn, self.keyframe)

    def restore(self, was: Snapshot) -> None:
        self.start, self.goal = was.start.copy(), was.goal.copy()
        self.start_moved, self.moved_goals, self.any_turn, self.keyframe = was.start_moved, set(was.moved_goals), was.any_turn, was.keyframe

    @property
    def goal_moved(self) -> bool:
        return bool(self.moved_goals)

    @property
    def goal_object(self) -> int:
        return self.given.goal.object

    @property
    def goal_objects(self) -> list[int]:
        """All that the goal names."""
        return list(self.given.goal_objects)

    def goal_parts(self) -> list[int]:
        """These, and what they hang on."""
        return sorted({i for leaf in self.given.goal_objects for i in chain(self.model, leaf)})

    @property
    def can_turn_freely(self) -> bool:
        """The goal may leave the orientation open."""
        return self.model.objects[self.goal_object].n_q == 7

    def given_any_turn(self) -> bool:
        """The goal of the task leaves the orientation open."""
        begin, free = self.model.objects[self.given.goal.object].v_begin, self.given.goal.open
        return self.can_turn_freely and bool(free) and all(free[begin + 3 : begin + 6])

    def movable(self) -> list[int]:
        """Objects that the goal of a scene may be for; `BODY.JOINT` is one of several joints of a body."""
        if self.scene is None:
            return []
        names = self.model.object_names
        return [i for i, name in enumerate(names) if not any(name.startswith(f"{other}.") for other in names)]

    def start_as_given(self) -> None:
        self.start, self.start_moved, self.keyframe = np.array(self.given.q_start), False, ""

    def start_at(self, keyframe: str) -> None:
        """Joints and objects as a keyframe has them. Raises stiction.InvalidInput."""
        at = st.Task({**self.spec, "start": {"keyframe": keyframe}}, base=self.folder)
        self.start, self.start_moved, self.keyframe = np.array(at.q_start), True, keyframe

    def joint_range(self, joint: int) -> tuple[float, float]:
        """Limits of a joint; half a turn, or the reach, each way where there are none."""
        low, high = float(self.model.lower[joint]), float(self.model.upper[joint])
        dof = self.model.dofs[self.model.n_vu + joint]
        wide = np.pi if dof.kind == st.DofKind.Revolute else float(np.max(self.model.reach, initial=1.0))
        return (low if np.isfinite(low) else -wide), (high if np.isfinite(high) else wide)

    def set_joint(self, joint: int, value: float) -> None:
        low, high = self.joint_range(joint)
        self.start[self.model.n_qu + joint] = np.clip(value, low, high)
        self.start_moved = True

    def set_start(self, index: int, X_WB: st.Pose) -> None:
        self.start = place(self.model, self.start, index, X_WB)
        self.start_moved = True

    def set_goal(self, X_WB: st.Pose, index: int | None = None) -> None:
        """Of an object that the goal names; None: of the one that it is named after."""
        index = self.goal_object if index is None else index
        self.goal = place(self.model, self.goal, index, X_WB)
        self.moved_goals.add(index)

    def goal_names(self) -> list[str]:
        """Of goal_numbers(), with units, and the objects' names where there are several free ones."""
        parts = self.goal_parts()
        several = sum(self.model.objects[i].n_q == 7 for i in parts) > 1
        return [f"{self.model.object_names[i]} {name}" if several and self.model.objects[i].n_q == 7 else name for i in parts for name in own_names(self.model, i)]

    def goal_numbers(self) -> list[float]:
        """own_numbers() of goal_parts()."""
        return [x for i in self.goal_parts() for x in own_numbers(self.model, self.goal, i)]

    def set_goal_numbers(self, values: Sequence[float]) -> None:
        """goal_numbers(); what differs is moved."""
        given = list(values)
        for i in self.goal_parts():
            before = own_numbers(self.model, self.goal, i)
            own, given = given[: len(before)], given[len(before) :]
            if np.abs(np.subtract(own, before)).max() > 1e-9:
                self.goal = with_own_numbers(self.model, self.goal, i, own)
                self.moved_goals.add(i)

    def drag_link(self, name: str, X_WB: st.Pose, turns: bool) -> st.PlacedLinks:
        """Joints of the start with which a link is where it was dragged to, or as near to it as it gets, nearest to those that they are. Raises stiction.InvalidInput."""
        placed = st.place_links(self.model, self.start, {name: X_WB if turns else X_WB.p}, postures=1, overlap=True)
        self.start, self.start_moved = np.array(placed.q), True
        return placed

    def set_start_numbers(self, index: int, values: Sequence[float]) -> None:
        self.start = with_numbers(self.model, self.start, index, values)
        self.start_moved = True

    # ---- the task as it is now ----

    def _start(self) -> dict[str, Any]:
        model, objects = self.model, {}
        for info in model.objects:
            q = self.start[info.q_begin : info.q_begin + info.n_q]
            if info.n_q == 7:
                objects[info.name] = {"position": numbers(q[:3]), "quaternion_wxyz": numbers([q[6], *q[3:6]])}
            else:
                objects[info.name] = {"coordinates": numbers(q)}
        return {"objects": objects, "joints": numbers(self.start[model.n_qu :])}

    def document(self, options: bool = False) -> dict[str, Any]:
        """The task as a task file says it: the given one, the start where it was changed, with `options` those that were."""
        out = dict(self.spec)
        if self.start_moved:
            out["start"] = self._start()
        if options and self.options:
            out["planner"] = dict(self.options)
        return out

    def in_file(self) -> bool:
        """The task of the file, but for its goal, seed and options."""
        return set(self.spec) <= {"base", "name"} and not self.start_moved

    def _goal_values(self) -> list[float | None]:
        """What set_goal() takes; a coordinate that may be anything is None. Objects that were not moved keep what the task leaves open, and those that were may still turn as they may there."""
        model, given, values = self.model, self.given.goal.open, list[float | None]()
        for i in self.goal_parts():
            info = model.objects[i]
            own: list[float | None] = list(own_numbers(model, self.goal, i))
            free = list(given[info.v_begin : info.v_begin + info.n_v]) if given else [False] * info.n_v
            if i == self.goal_object:
                free = [False] * 3 + [self.any_turn] * 3 if info.n_q == 7 else [False] * info.n_v
            elif i in chain(model, self.goal_object):
                free = [False] * info.n_v
            elif i in self.moved_goals:
                free = [False] * 3 + free[3:] if info.n_q == 7 else [False] * info.n_v
            values += [None if any_value else x for x, any_value in zip(own, free)]
        return values

    def _goal_is_given(self) -> bool:
        return not self.goal_moved and self.any_turn == self.given_any_turn()

    def task(self) -> st.Task:
        """Raises stiction.InvalidInput."""
        if self.in_file():
            task = st.load_task(self.name if self.name in st.list_tasks() else self.folder / self.name)
        else:
            task = st.Task(self.document(), base=self.folder)
        if not self._goal_is_given():
            task.set_goal(self._goal_values())
        return task

    def task_file(self) -> str | None:
        """Text of the task file that command() names; None where a name or a file says it already."""
        if self.in_file() and not self.options:
            return None
        return json.dumps(self.document(options=True), indent=1, ensure_ascii=False) + "\n"  # JSON is YAML

    def files(self) -> dict[str, bytes]:
        """What a task that is in no file reads from its folder."""
        if "base" in self.spec:
            return {}
        return {str(file.relative_to(self.folder)): file.read_bytes() for file in sorted(self.folder.rglob("*")) if file.is_file()}

    def command(self, timeout_s: float) -> str:
        """The line that plans this again; of a scene a line before it imports that."""
        words = ["stiction", "plan", self.name if self.task_file() is None else "task.yaml", "--seed", str(self.seed)]
        if not self._goal_is_given():
            words += ["--goal", " ".join("~" if x is None else f"{x:.9g}" for x in self._goal_values())]
        line = shlex.join([*words, "--timeout", f"{timeout_s:g}", "-o", "out"])
        if self.scene is None:
            return line
        return f"test -f {shlex.quote(self.name)} || {shlex.join(['stiction', 'import', str(self.scene), *(['--object', self.goal_of] if self.goal_of else []), '-o', self.name])}\n{line}"
