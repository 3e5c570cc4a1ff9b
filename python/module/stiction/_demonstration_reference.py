"""What a repair follows: a demonstration without its noise, as configurations of the model."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ._core import Model, Task
from ._demonstration_file import Demonstration, by_kind
from .exports import POSE

STEP_REVOLUTE, STEP_PRISMATIC = 0.03, 0.01  # of a command between two times of a reference [rad], [m]
MOST_TIMES = 2000
SHAKING = 1.5  # times the way of joints that are smoothed: they shake
SMOOTHING_S = 0.08  # standard deviation of the weights of what is smoothed [s]


def calm(demonstration: Demonstration) -> Demonstration:
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


class Reference:
    """The demonstration at times between which no command moves farther than a sub-step, as configurations of the model."""

    def __init__(self, task: Task, demonstration: Demonstration, fineness: int) -> None:
        model = task.model
        largest = by_kind(task, STEP_REVOLUTE, STEP_PRISMATIC) / fineness
        parts = np.abs(np.diff(demonstration.joints, axis=0) / largest).max(axis=1)
        way = np.concatenate([[0], np.cumsum(np.maximum(parts, 1e-3))])  # in largest moves of a joint; where joints rest time goes by quickly
        count = min(max(math.ceil(way[-1] - 1e-9), 2), MOST_TIMES)
        self.times = np.interp(np.linspace(0, way[-1], count + 1), way, demonstration.time)

        def at_times(values: np.ndarray) -> np.ndarray:
            return np.column_stack([np.interp(self.times, demonstration.time, column) for column in values.reshape(len(values), -1).T])

        joints = np.clip(at_times(demonstration.joints), model.lower, model.upper)
        self.commands = joints if demonstration.commands is None else np.clip(
            at_times(demonstration.commands), model.command_lower, model.command_upper
        )
        poses = at_times(demonstration.poses).reshape(len(self.times), -1, len(POSE))
        poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
        states = [_configuration(model, task.q_start, poses[0], joints[0])]
        for pose, q in zip(poses[1:], joints[1:]):
            states.append(_configuration(model, states[-1], pose, q))
        self.q = np.vstack(states)
        self.task = task.with_(start=self.q[0], goal=goal_of(task, self.q[-1]))


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
        out += [at.p - pose[:3], 0.5 * (at.R - _rotation_matrix(pose[3:])).ravel()]
    return np.concatenate(out)


def _rotation_matrix(xyzw: np.ndarray) -> np.ndarray:
    """Of a unit quaternion x y z w."""
    x, y, z, w = xyzw
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def goal_of(task: Task, q: np.ndarray) -> np.ndarray:
    """What a task takes as the goal for where its objects, and those that carry them through joints, are at q."""
    named = set()
    for index in task.goal_objects:
        while index >= 0:
            named.add(index)
            index = task.model.objects[index].parent
    return np.concatenate([_goal_numbers(task.model, index, q) for index in sorted(named)])


def _goal_numbers(model: Model, index: int, q: np.ndarray) -> np.ndarray:
    info = model.objects[index]
    if info.n_q != 7:
        return q[info.q_begin : info.q_begin + info.n_q]
    pose = model.object_pose(q, info.name)
    R = pose.R
    pitch = math.asin(float(np.clip(-R[2, 0], -1, 1)))
    return np.array([*pose.p, math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])])


def off_by(task: Task, q: np.ndarray, shown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far the objects of the goal are at q from where they are at `shown`, at most (N) [m], [rad]."""
    position, angle = np.zeros(len(q)), np.zeros(len(q))
    for index in task.goal_objects:
        is_at, was_at = (task.model.object_poses(at, task.model.object_names[index]) for at in (q, shown))
        position = np.maximum(position, np.linalg.norm(is_at[:, :3] - was_at[:, :3], axis=1))
        angle = np.maximum(angle, 2 * np.arccos(np.clip(np.abs(np.sum(is_at[:, 3:] * was_at[:, 3:], axis=1)), 0, 1)))
    return position, angle
