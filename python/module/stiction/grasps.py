"""Held grasps: states of search trees in which the robot holds the object at rest (docs/learning.md)."""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from . import _command, _core
from ._core import InvalidInput, Task, load_task, version
from ._files import read_npz, require_writable, write_whole
from ._values import fields_equal

STEP_S = 0.1
SETTLING = 20  # steps that a state may take to come to rest
HELD = 20  # steps that it is looked at afterwards, and in each trial
STILL = (1e-5, 1e-4)  # objects that move less than this in a step rest [m], [rad]
NEW = (1e-3, 1e-2, 1e-2)  # states that differ by less are the same: places of objects [m] and [rad], joints [rad or m]
FRICTION_LOSSES = np.linspace(0.1, 0.9, 9)  # that are tried
LEAST_NODES, NODES_EACH = 64, 4  # of a tree, and for each grasp that is still to be found
EXPLORING = {"goal_bias": 0.1}  # a tree that goes everywhere, not straight to the goal


@dataclass(frozen=True, eq=False)
class Grasps:
    """Held grasps: states at rest with the commands that hold them. The first axis of each array is the index of the grasp."""

    task: str
    scene_sha256: str
    joints: list[str]
    object: str  # of the goal
    q: np.ndarray  # (grasps, n_q) configurations
    u: np.ndarray  # (grasps, n_a) commands that hold them [m or rad]
    pose: np.ndarray  # (grasps, 7) of the object: x y z [m], then the quaternion w x y z
    margin: np.ndarray  # (grasps) share of all friction that can be lost; 0: less than a tenth
    contacts: np.ndarray  # (grasps) between the robot and the object
    alone: np.ndarray  # (grasps) nothing but the robot touches the object

    def __len__(self) -> int:
        return len(self.q)

    def __eq__(self, other: Any) -> bool:
        return fields_equal(self, other) if isinstance(other, Grasps) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can change

    def __getitem__(self, which: Any) -> Grasps:
        """Returns the grasps of a mask, a slice or a list of indices."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Grasps(**{name: value[which] if isinstance(value, np.ndarray) else value for name, value in values.items()})

    def write(self, file: str | os.PathLike[str]) -> Path:
        """Writes the arrays to an .npz file without pickles: np.load(file)["q"]. Raises InvalidInput: the file cannot be written."""
        arrays: dict[str, Any] = {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)} | {"code_version": np.array(version())}

        def save(to: Path) -> None:
            with to.open("wb") as out:  # given a name it would add to it
                np.savez_compressed(out, **arrays)

        return write_whole(Path(file), save)


def read_grasps(file: str | os.PathLike[str], task: Task) -> Grasps:
    """Reads grasps from a file that Grasps.write() wrote. Raises InvalidInput: this is no such file, or the grasps belong to another scene."""
    names = [field.name for field in fields(Grasps)]
    values: dict[str, Any] = read_npz(file, names, "a file that `stiction grasps` wrote")
    out = Grasps(**{name: values[name] if values[name].ndim and name != "joints" else values[name].tolist() for name in names})
    if out.scene_sha256 != task.scene_sha256:
        raise InvalidInput(f"{file}: scene_sha256: got that of another scene (task {out.task}), expected that of {task.name}; make the grasps anew")
    n, model = len(out.margin), task.model
    for name, shape in {"q": (n, model.n_q), "u": (n, model.n_a), "pose": (n, 7), "margin": (n,), "contacts": (n,), "alone": (n,)}.items():
        array = np.asarray(getattr(out, name))
        if np.shape(array) != shape or array.dtype.kind not in "biuf" or not np.isfinite(array).all():
            raise InvalidInput(f"{file}: {name}: got an array of shape {np.shape(array)} and type {array.dtype}, expected finite numbers of shape {shape}")
    return out


def find_grasps(
    task: Task,
    *,
    count: int = 256,
    seed: int = 0,
    timeout_s: float = 60.0,
    tilt: float = 0.1,
    least_margin: float = 0.1,
    alone: bool = False,
    threads: int = 0,
    on_progress: Callable[[int], bool | None] | None = None,
) -> Grasps:
    """Finds grasps: states in which the robot holds the object of the goal at rest. Use them as starts for learning (docs/learning.md).

    The states are nodes of search trees of the task. A state is a grasp if it comes to rest under its command, and if the object then stays
    within the tolerances of the goal for 2 s, also with tilted gravity and with less friction. No two grasps are equal.

      task: Task.
      count: number of grasps to find, as far as the time allows.
      seed: of the first search tree; each further tree has the next seed.
      timeout_s: largest wall time [s].
      tilt: angle by which gravity is tilted in four directions [rad], in [0, pi/2).
      least_margin: share of the friction that a grasp can lose and still hold, in [0, 0.9].
      alone: True: only states in which nothing but the robot touches the object.
      threads: 0: all cores.
      on_progress: function that is called after each tree with the number of grasps found. The return value False ends the search.

    Returns Grasps. Raises InvalidInput.

        >>> grasps = st.find_grasps(st.load_task("planar_hand"), count=5, seed=0)
        >>> grasps.q.shape, grasps.u.shape, bool((grasps.margin >= 0.1).all())
        ((5, 7), (5, 4), True)
    """
    found = _Found(task)
    _find(found, task, count, seed, timeout_s, tilt, least_margin, alone, threads, on_progress)
    return found.grasps()


def _find(
    found: _Found, task: Task, count: int, seed: int, timeout_s: float, tilt: float, least_margin: float, alone: bool, threads: int,
    on_progress: Callable[[int], bool | None] | None = None,
) -> None:  # fmt: skip
    """find_grasps(), for a caller that keeps what was found before Ctrl-C."""
    _check(count, tilt, least_margin)
    start, tree = time.monotonic(), 0
    while len(found) < count:
        left = timeout_s - (time.monotonic() - start)
        if left <= 0:
            break
        q, u = _grow(task, seed + tree, max(LEAST_NODES, NODES_EACH * (count - len(found))), left, threads)
        found.add(_held(task, q, u, tilt, least_margin, alone, threads), count)
        tree += 1
        if on_progress is not None and on_progress(len(found)) is False:
            break


def _check(count: int, tilt: float, least_margin: float) -> None:
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InvalidInput(f"count: got {count}, expected an integer of at least 1")
    if not 0 <= tilt < math.pi / 2:
        raise InvalidInput(f"tilt: got {tilt}, expected [0, pi/2) [rad]")
    if not 0 <= least_margin <= FRICTION_LOSSES[-1]:
        raise InvalidInput(f"least_margin: got {least_margin}, expected [0, {FRICTION_LOSSES[-1]:g}]")


class _Enough(Exception):
    """The trees have as many nodes as are wanted."""


def _grow(task: Task, seed: int, nodes: int, timeout_s: float, threads: int) -> tuple[np.ndarray, np.ndarray]:
    """States and commands of the first nodes of the trees of a search."""
    parts: list[_core.Growth] = []

    def take(growth: _core.Growth) -> None:
        parts.append(growth)
        if sum(len(part.parents) for part in parts) >= nodes:
            raise _Enough

    with contextlib.suppress(_Enough):
        _core.plan(task, seed=seed, threads=threads, timeout_s=timeout_s, options=EXPLORING, on_growth=take)
    model = task.model
    return np.vstack([np.empty((0, model.n_q)), *(part.q for part in parts)]), np.vstack([np.empty((0, model.n_a)), *(part.u for part in parts)])


def _held(task: Task, q: np.ndarray, u: np.ndarray, tilt: float, least_margin: float, alone: bool, threads: int) -> Grasps:
    trial = _Trial(task, threads)
    q, u = trial.settle(q, u)
    contacts, by_robot = trial.count_contacts(q, u)
    kept = (contacts > 0) & (by_robot | (not alone))
    q, u, contacts, by_robot = q[kept], u[kept], contacts[kept], by_robot[kept]
    kept = trial.stays_tilted(q, u, tilt)
    q, u, contacts, by_robot = q[kept], u[kept], contacts[kept], by_robot[kept]
    margin = trial.friction_margin(q, u)
    name = task.model.object_names[task.goal.object]
    out = Grasps(task.name, task.scene_sha256, task.model.joint_names, name, q, u, task.model.object_poses(q, name), margin, contacts, by_robot)
    return out[margin >= least_margin - 1e-9]


class _Trial:
    """What states do when their commands are held."""

    def __init__(self, task: Task, threads: int) -> None:
        self._task, self._model, self._work = task, task.model, _core.BatchWorkspace(task.model, threads)
        self._law = _core.FrictionLaw.Anitescu if task.model.planar_axis is not None else _core.FrictionLaw.Coulomb  # as the planner's

    def _step(self, q: np.ndarray, u: np.ndarray, **options: Any) -> tuple[np.ndarray, np.ndarray]:
        batch = _core.step_batch(self._model, q, u, h=STEP_S, friction_law=self._law, workspace=self._work, **options)
        return batch.q_next, batch.solved

    def moved(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """(N, 2): the largest translation [m] and rotation [rad] of an object."""
        out = np.zeros((len(a), 2))
        for name in self._model.object_names:
            A, B = self._model.object_poses(a, name), self._model.object_poses(b, name)
            angle = 2 * np.arccos(np.clip(np.abs(np.sum(A[:, 3:] * B[:, 3:], axis=1)), 0, 1))
            out = np.maximum(out, np.column_stack([np.linalg.norm(A[:, :3] - B[:, :3], axis=1), angle]))
        return out

    def settle(self, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States that come to rest, where they rest, and their commands."""
        rested_q, rested_u = [np.empty((0, self._model.n_q))], [np.empty((0, self._model.n_a))]
        for _ in range(SETTLING):
            if not len(q):
                break
            q_next, solved = self._step(q, u)
            rests = solved & (self.moved(q, q_next) <= STILL).all(axis=1)
            rested_q.append(q_next[rests])
            rested_u.append(u[rests])
            going = solved & ~rests
            q, u = q_next[going], u[going]
        return np.vstack(rested_q), np.vstack(rested_u)

    def count_contacts(self, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the robot with the object of the goal, and whether nothing else touches it."""
        robots = {body.name for body in self._model.bodies if body.kind == _core.BodyKind.Robot}
        body = self._model.bodies[self._model.objects[self._task.goal.object].body].name
        counts, alone = np.zeros(len(q), dtype=int), np.ones(len(q), dtype=bool)
        for i in range(len(q)):
            for contact in _core.step(self._model, q[i], u[i], h=STEP_S, friction_law=self._law).contacts:
                sides = [name.rsplit("/", 1)[0] for name in (contact.a, contact.b)]
                if contact.active and body in sides:
                    other = sides[1 - sides.index(body)]
                    counts[i] += other in robots
                    alone[i] &= other in robots
        return counts, alone

    def _stays(self, q: np.ndarray, u: np.ndarray, tau: Callable[[np.ndarray], np.ndarray] | None, scale: float) -> np.ndarray:
        """Objects are within the tolerances of the goal of where they were, for HELD steps."""
        goal, still_held = self._task.goal, np.arange(len(q))
        now = q
        for _ in range(HELD):
            if not len(still_held):
                break
            now, solved = self._step(now, u[still_held], tau_ext=None if tau is None else tau(now), friction_scale=scale)
            kept = solved & (self.moved(q[still_held], now) <= (goal.tol_position, goal.tol_angle)).all(axis=1)
            now, still_held = now[kept], still_held[kept]
        out = np.zeros(len(q), dtype=bool)
        out[still_held] = True
        return out

    def stays_tilted(self, q: np.ndarray, u: np.ndarray, tilt: float) -> np.ndarray:
        kept = np.ones(len(q), dtype=bool)
        for side in range(4 if tilt > 0 else 0):
            some = np.flatnonzero(kept)
            kept[some] = self._stays(q[some], u[some], lambda at: _core.calc_weights_aside(self._model, at, tilt, side), 1.0)
        return kept

    def friction_margin(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The largest share of FRICTION_LOSSES up to which the object stays."""
        margin, kept = np.zeros(len(q)), np.arange(len(q))
        for loss in FRICTION_LOSSES:
            kept = kept[self._stays(q[kept], u[kept], None, 1 - loss)]
            margin[kept] = loss
        return margin


class _Found:
    """Grasps of several trees, each once."""

    def __init__(self, task: Task) -> None:
        self._task, self._parts, self._keys, self._size = task, [], set(), 0  # type: ignore[var-annotated]

    def __len__(self) -> int:
        return self._size

    def add(self, more: Grasps, count: int) -> None:
        position, angle, joint = NEW
        cells = np.hstack([more.pose[:, :3] / position, more.pose[:, 3:] * 2 / angle, more.q[:, -more.u.shape[1] :] / joint]).round()
        new = []
        for i, cell in enumerate(cells):
            key = cell.tobytes()
            if key not in self._keys and self._size < count:
                self._keys.add(key)
                self._size += 1
                new.append(i)
        self._parts.append(more[new])

    def grasps(self) -> Grasps:
        model, goal = self._task.model, self._task.goal
        empty = {"q": (0, model.n_q), "u": (0, model.n_a), "pose": (0, 7), "margin": (0,), "contacts": (0,), "alone": (0,)}
        arrays = {name: np.concatenate([np.empty(shape), *(getattr(part, name) for part in self._parts)]) for name, shape in empty.items()}
        arrays |= {"contacts": arrays["contacts"].astype(int), "alone": arrays["alone"].astype(bool)}
        return Grasps(self._task.name, self._task.scene_sha256, model.joint_names, model.object_names[goal.object], **arrays)


def main(words: Sequence[str]) -> int:
    """`stiction grasps`"""
    parser = _command.make_parser("grasps", "Finds and writes grasps: states in which the robot holds the object at rest, with the share of friction that each can lose.")
    parser.add_argument("task", metavar="TASK", help="name or file of a task")
    parser.add_argument("-o", "--out", type=Path, default=Path("grasps.npz"), metavar="FILE", help="file to write (default: %(default)s)")
    parser.add_argument("--count", type=_command.integer(1, 10**7), default=256, metavar="N", help="number of grasps to find, as far as the time allows (default: %(default)s)")
    parser.add_argument("--seed", type=_command.integer(0, 2**63 - 1), default=0, metavar="N", help="seed of the first search tree (default: %(default)s)")
    parser.add_argument("--timeout", type=_command.positive, default=60.0, metavar="S", help="largest wall time [s] (default: %(default)s)")
    parser.add_argument("--tilt", type=_command.nonnegative, default=0.1, help="angle by which gravity is tilted in the test of a grasp [rad] (default: %(default)s)")
    parser.add_argument("--least-margin", type=_command.nonnegative, default=0.1, help="share of the friction that a grasp can lose and still hold (default: %(default)s)")
    parser.add_argument("--alone", action="store_true", help="only states in which nothing but the robot touches the object")
    parser.add_argument("--threads", type=_command.integer(0, 4096), default=0, metavar="N", help="number of threads (default: all cores)")
    a = parser.parse_args(words)
    task = load_task(a.task)
    require_writable(a.out)
    found, interrupted = _Found(task), False
    try:
        _find(found, task, a.count, a.seed, a.timeout, a.tilt, a.least_margin, a.alone, a.threads)
    except KeyboardInterrupt:
        interrupted = True
    grasps = found.grasps()
    file = grasps.write(a.out)
    least = float(grasps.margin.min()) if len(grasps) else None
    rows = {"grasps": str(len(grasps)), "by the robot alone": str(int(grasps.alone.sum())), "file": str(file)}
    if least is not None:
        rows["friction to lose"] = f"{least:.1f} to {grasps.margin.max():.1f}, median {np.median(grasps.margin):.1f}"
    enough = len(grasps) == a.count
    result = {"status": "Cancelled" if interrupted else "Done" if enough else "MaxIterations", "task": task.name, "grasps": len(grasps), "alone": int(grasps.alone.sum()), "least_margin": least, "file": str(file)}
    _command.report(a, f"{task.name}: held grasps", rows, result)
    return _command.INTERRUPTED if interrupted else _command.DONE if enough else _command.NOT_SOLVED
