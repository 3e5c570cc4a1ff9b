"""Episodes of a task, many at once: what `stiction.gym` shows to Gymnasium. NumPy alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._core import InvalidInput, Task
from .grasps import Grasps

STEP_S = 0.1
REVOLUTE, PRISMATIC = 0.05, 0.02  # largest change of a command in a step [rad], [m]
LOST = 20.0  # an object that is so many tolerances farther from its goal than it was has been lost
SUCCESS = 10.0  # reward


@dataclass(frozen=True)
class Outcome:
    """What a step came to, (N) each."""

    reward: np.ndarray
    success: np.ndarray
    lost: np.ndarray
    unsolved: np.ndarray  # the step could not be computed; the state stayed
    truncated: np.ndarray


class Episodes:
    """N episodes side by side; each starts at a start of its own."""

    def __init__(
        self, task: Task, number: int, *, starts: Grasps | None, increment: Any, max_steps: int, lost: float | None, threads: int, goals: Grasps | None = None
    ) -> None:
        if number < 1:
            raise InvalidInput(f"num_envs: got {number}, expected at least 1")
        if max_steps < 1:
            raise InvalidInput(f"max_steps: got {max_steps}, expected at least 1")
        self.task, self.model, self.number = task, task.model, number
        self._work = _core.BatchWorkspace(task.model, threads)
        self.increment = _increments(task.model, increment)
        self._max_steps = max_steps
        self._lost = LOST * task.goal.tol_position if lost is None else lost
        self._law = _core.FrictionLaw.Anitescu if task.model.planar_axis is not None else _core.FrictionLaw.Coulomb  # as the planner's
        self._object = task.model.object_names[task.goal.object]
        self._goals = None if goals is None else _goals(task, goals)
        self._start_q, self._start_u = _starts(task, starts, self._goals is not None)
        self.q = np.tile(task.q_start, (number, 1))
        self.u = self.q[:, -task.model.n_a :].copy()
        self.steps = np.zeros(number, dtype=int)
        self.goal = np.tile(np.concatenate([task.goal.X_WG.p, task.goal.X_WG.quaternion_wxyz]), (number, 1))  # (N, 7) of the object
        self._start_error = self._error = self._calc_error(self.q, self.goal)

    def reset(self, which: np.ndarray, random: np.random.Generator) -> None:
        """The episodes of a mask begin anew."""
        index = random.integers(0, len(self._start_q), size=int(which.sum()))
        self.q[which], self.u[which], self.steps[which] = self._start_q[index], self._start_u[index], 0
        if self._goals is not None:
            self.goal[which] = self._draw_goals(self.q[which], random)
        error = self._calc_error(self.q[which], self.goal[which])
        self._start_error, self._error = self._start_error.copy(), self._error.copy()
        self._start_error[which] = self._error[which] = error

    def step(self, actions: np.ndarray, which: np.ndarray) -> Outcome:
        """Moves the commands of the episodes of a mask by actions in [-1, 1] (N, n_a); the others stay."""
        model, n_a = self.model, self.model.n_a
        if actions.shape != (self.number, n_a):
            raise InvalidInput(f"actions: got the shape {actions.shape}, expected ({self.number}, {n_a})")
        if not np.isfinite(actions[which]).all():
            raise InvalidInput("actions: got numbers that are not finite")
        u = self.u[which] + np.clip(actions[which], -1, 1) * self.increment
        self.u[which] = np.clip(u, model.lower, model.upper)
        batch = _core.step_batch(model, self.q[which], self.u[which], h=STEP_S, friction_law=self._law, effort_limits=True, workspace=self._work)
        self.q[which] = batch.q_next
        self.steps[which] += 1
        before = self._error
        self._error = before.copy()
        self._error[which] = self._calc_error(batch.q_next, self.goal[which])
        unsolved = np.zeros(self.number, dtype=bool)
        unsolved[which] = ~batch.solved
        return self._judge(before, which, unsolved)

    def _calc_error(self, q: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """(N, 2) [m], [rad]."""
        return self.task.goal_errors(q) if self._goals is None else _differences(self.model.object_poses(q, self._object), goal)

    def _draw_goals(self, q: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """For each state one of the goals at which its object is not yet, where there is one."""
        assert self._goals is not None
        at, tolerances = self.model.object_poses(q, self._object), (self.task.goal.tol_position, self.task.goal.tol_angle)
        away = np.stack([(_differences(at, np.broadcast_to(goal, at.shape)) > tolerances).any(axis=1) for goal in self._goals], axis=1)
        return self._goals[np.argmax(away + random.random(away.shape), axis=1)]

    def _judge(self, before: np.ndarray, which: np.ndarray, unsolved: np.ndarray) -> Outcome:
        goal = self.task.goal
        tolerances = np.array([goal.tol_position, goal.tol_angle])
        success = which & (self._error <= tolerances).all(axis=1)
        lost = which & (self._error[:, 0] > self._start_error[:, 0] + self._lost)
        reward = ((before - self._error) / tolerances).sum(axis=1) + SUCCESS * success
        return Outcome(reward, success, lost, unsolved, which & (self.steps >= self._max_steps))

    @property
    def error(self) -> np.ndarray:
        """Of the object from its goal (N, 2) [m], [rad]."""
        return self._error

    @property
    def size(self) -> int:
        """Numbers of an observation."""
        return 2 * self.model.n_a + 9 * len(self.model.object_names) + 6

    def observe(self) -> np.ndarray:
        """(N, size): joints, commands less joints, position and two columns of the rotation of each object; from the object to its goal the translation
        and the rotation vector, in the world."""
        n_a = self.model.n_a
        joints = self.q[:, -n_a:]
        poses = [self.model.object_poses(self.q, name) for name in self.model.object_names]
        parts = [joints, self.u - joints, *(np.hstack([pose[:, :3], _columns(pose[:, 3:])]) for pose in poses)]
        at = poses[self.task.goal.object]
        parts += [self.goal[:, :3] - at[:, :3], _turn(at[:, 3:], self.goal[:, 3:])]
        return np.hstack(parts).astype(np.float32)


def _increments(model: _core.Model, given: Any) -> np.ndarray:
    """(n_a)"""
    if given is None:
        kinds = [dof.kind for dof in model.dofs[-model.n_a :]]
        return np.array([REVOLUTE if kind == _core.DofKind.Revolute else PRISMATIC for kind in kinds])
    out = np.broadcast_to(np.asarray(given, dtype=float), (model.n_a,)) if np.ndim(given) == 0 or np.shape(given) == (model.n_a,) else None
    if out is None or not (np.isfinite(out) & (out > 0)).all():
        raise InvalidInput(f"increment: got {given}, expected a number > 0, or {model.n_a} of them [rad or m]")
    return np.array(out)


def _goals(task: Task, grasps: Grasps) -> np.ndarray:
    """(goals, 7)"""
    if grasps.scene_sha256 != task.scene_sha256:
        raise InvalidInput(f"goals: got grasps of another scene (task {grasps.task}), expected those of {task.name}")
    if not len(grasps):
        raise InvalidInput("goals: got no grasps, expected at least one")
    return grasps.pose


def _starts(task: Task, grasps: Grasps | None, anywhere: bool) -> tuple[np.ndarray, np.ndarray]:
    """Of grasps those away from the goal of the task, or all of them."""
    if grasps is None:
        return task.q_start[None], task.q_start[None, -task.model.n_a :]
    if grasps.scene_sha256 != task.scene_sha256:
        raise InvalidInput(f"starts: got grasps of another scene (task {grasps.task}), expected those of {task.name}")
    if anywhere and len(grasps):
        return grasps.q, grasps.u
    away = (task.goal_errors(grasps.q) > (task.goal.tol_position, task.goal.tol_angle)).any(axis=1)
    if not away.any():
        raise InvalidInput(f"starts: got {len(grasps)} grasps, and none of them away from the goal; find more of them, or take another goal")
    return grasps.q[away], grasps.u[away]


def _columns(wxyz: np.ndarray) -> np.ndarray:
    """The first two columns of the rotations (N, 6)."""
    w, x, y, z = wxyz.T
    return np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])


def _differences(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of poses (N, 7): positions [m] and angles [rad] (N, 2)."""
    return np.column_stack([np.linalg.norm(a[:, :3] - b[:, :3], axis=1), np.linalg.norm(_turn(a[:, 3:], b[:, 3:]), axis=1)])


def _turn(at: np.ndarray, to: np.ndarray) -> np.ndarray:
    """The rotation vectors that lead from the rotations `at` (N, 4) to `to` (N, 4), in the world [rad] (N, 3)."""
    w0, v0, w1, v1 = at[:, :1], at[:, 1:], to[:, :1], to[:, 1:]
    w = w0 * w1 + np.sum(v0 * v1, axis=1, keepdims=True)
    v = w0 * v1 - w1 * v0 - np.cross(v1, v0)
    v = np.where(w < 0, -v, v)
    sine = np.linalg.norm(v, axis=1, keepdims=True)
    angle = 2 * np.arctan2(sine, np.abs(w))
    return v * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
