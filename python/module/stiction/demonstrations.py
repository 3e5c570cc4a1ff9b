"""Demonstrations, and their repair: plans that follow them as nearly as contact allows (docs/demonstrations.md)."""

from __future__ import annotations

import math
import os
import re
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import _command
from ._core import DofKind, Plan, Status, Task, check_plan, load_task, optimize, plan, refine
from ._demonstration_file import ANGLES, UNITS, by_kind
from ._demonstration_file import Demonstration as Demonstration
from ._demonstration_file import read_demonstration as read_demonstration
from ._demonstration_reference import STEP_PRISMATIC, STEP_REVOLUTE, Reference, calm, goal_of, off_by
from ._files import require_writable
from ._values import fields_equal

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


@dataclass(frozen=True, eq=False)
class Repair:
    """Result of repair(): a plan, and how it differs from the demonstration."""

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

    def __eq__(self, other: object) -> bool:
        return fields_equal(self, other) if isinstance(other, Repair) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can change

    @property
    def holds(self) -> bool:
        """True: the plan ends where the demonstration ends, within the tolerances of the task, also if it is simulated in half steps."""
        return self.complete and self.plan.status == Status.Solved and self.accepted

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """Key to sort repairs: a smaller rank is a better repair."""
        goal = self.plan.task.goal
        return not self.holds, not self.complete, -float(self.times[-1]), self.plan.error.position / goal.tol_position + self.plan.error.angle / goal.tol_angle

    def sentences(self) -> list[str]:
        """Returns sentences on how the plan differs from the demonstration."""
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


def repair(task: Task, demonstration: Demonstration | str | os.PathLike[str], *, timeout_s: float = 120.0, threads: int = 0, on_progress: Callable[[float], bool | None] | None = None) -> Repair:
    """Finds a plan that follows a demonstration as closely as contact physics allows (docs/demonstrations.md).

    In the plan no bodies penetrate, and all forces are within their friction cones and the limits of the motors. Trajectory optimisation
    (iMPC) tracks one window of the demonstration after the other. Each window starts from the state that the previous one reached in the
    exact model. The motion of the object has priority; joints may differ from the demonstration if this brings the object closer. The goal of
    the plan is the pose of the object at the end of the demonstration.

      task: Task that gives the scene and the tolerances.
      demonstration: Demonstration of read_demonstration(), or a file that it reads.
      timeout_s: largest wall time [s], > 0.
      threads: 0: all cores.
      on_progress: function that is called with the share that is done. The return value False ends the repair.

    Returns a Repair. Raises InvalidInput.
    """
    begin = clock.monotonic()
    demonstration = calm(demonstration if isinstance(demonstration, Demonstration) else read_demonstration(demonstration, task))
    best: Repair | None = None
    going_on = True

    def left() -> float:
        return timeout_s - (clock.monotonic() - begin)

    def tell(followed: _Follower) -> None:
        nonlocal going_on
        going_on = on_progress is None or on_progress(followed.share) is not False

    def plan_on(reference: Reference, followed: _Follower) -> None:
        nonlocal best
        if best is None or best.holds or not going_on or left() < 0 or not followed.cut():
            return
        for index in followed.keyframes():
            if going_on and left() > 0 and followed.plan_to(index, left()):
                tell(followed)
        best = _better(best, _result(reference, followed, demonstration, clock.monotonic() - begin))

    tracked: list[tuple[Reference, _Follower]] = []
    finest: Reference | None = None
    for fineness in FINENESS:
        reference = Reference(task, demonstration, fineness)
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


class _Follower:
    """Commands so far, and where they lead in the exact model, in full steps and, as `check` takes them, in half ones."""

    def __init__(self, reference: Reference, threads: int) -> None:
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
        position, angle = off_by(self._task, q, np.atleast_2d(self._reference.q[index]))
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
            task = self._task.with_(goal=goal_of(self._task, self._between(self._reference.q[index][None])[0]))
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
        offs = [off_by(self._task, q[-1:], self._reference.q[index][None]) for q in (self.states, self.halves)]
        return max(max(position[0] / goal.tol_position, angle[0] / goal.tol_angle) for position, angle in offs)

    def _section(self, horizon: int) -> dict[str, Any]:
        """Objects in their tolerances, joints in largest moves."""
        goal, model = self._task.goal, self._task.model
        objects = {}
        for info in model.objects:
            dofs = model.dofs[info.v_begin : info.v_begin + info.n_v]
            objects[info.name] = [1 / (goal.tol_angle if dof.kind == DofKind.Revolute else goal.tol_position) ** 2 for dof in dofs]
        joints = (JOINT_WEIGHT / by_kind(self._task, STEP_REVOLUTE, STEP_PRISMATIC) ** 2).tolist()
        weights = {"objects": objects, "objects_final": objects, "robots": joints, "robots_final": joints, "input": joints}
        return {"horizon": horizon, "iterations": ITERATIONS, "tolerance": 1e-3, "input_bound": BOUND, "analytic": {"kappa": KAPPA}, "weights": weights}


def _result(reference: Reference, followed: _Follower, demonstration: Demonstration, wall_s: float) -> Repair:
    task, n_a = reference.task, reference.task.model.n_a
    states, shown = followed.states[followed.marks], reference.q[followed.indices]
    position, angle = off_by(task, states, shown)
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


def main(words: Sequence[str]) -> int:
    """`stiction repair`"""
    parser = _command.make_parser("repair", "Makes a plan that follows a demonstration as closely as contact physics allows, and reports the differences.")
    parser.add_argument("task", metavar="TASK", help="name or file of a task that gives the scene and the tolerances")
    parser.add_argument("file", type=Path, metavar="FILE", help="joints and objects over time: .csv or .npz, as `stiction export` writes them")
    parser.add_argument("--unit", choices=list(UNITS), default="m", help="unit of lengths in the file (default: %(default)s)")
    parser.add_argument("--angle", choices=list(ANGLES), default="rad", help="unit of joint angles in the file (default: %(default)s)")
    parser.add_argument("--timeout", type=_command.positive, default=120.0, metavar="S", help="largest wall time [s] (default: %(default)s)")
    parser.add_argument("--threads", type=_command.integer(0, 4096), default=0, metavar="N", help="number of threads (default: all cores)")
    parser.add_argument("-o", "--out", type=Path, default=Path("repaired"), metavar="FOLDER", help="folder for plan.json (default: ./%(default)s)")
    a = parser.parse_args(words)
    task = load_task(a.task)
    file = a.out / "plan.json"
    demonstration = read_demonstration(a.file, task, unit=a.unit, angle=a.angle)
    require_writable(file)
    done = repair(task, demonstration, timeout_s=a.timeout, threads=a.threads)
    done.plan.write(file)
    reached = done.holds
    sentences = done.sentences()
    rows = {"what changed" if i == 0 else "and": sentence for i, sentence in enumerate(sentences)} | {"time": f"{done.wall_s:.1f} s", "plan": str(file)}
    result: dict[str, Any] = {"status": "Done" if reached else "NotSolved", "task": task.name, "complete": done.complete, "accepted": done.accepted, "changes": sentences, "wall_s": done.wall_s, "plan": str(file)}
    result["end"] = {"position": float(done.position_error[-1]), "angle": float(done.angle_error[-1])}
    _command.report(a, f"{task.name}: {'repaired' if reached else 'not repaired to its end'}", rows, result)
    return _command.DONE if reached else _command.NOT_SOLVED
