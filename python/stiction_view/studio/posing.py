"""A task on the stage: its start and goal are moved, and what lint says of them is shown."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import stiction as st

from . import faults
from .panel import AS_GIVEN, NOTHING, PoseControls, Post, set_choices
from .picture import Pictures
from .problem import Problem, names_of, numbers_of
from .stage import Stage

SETTLED = 0.3  # [s] after the last change faults are looked for
STEP = 0.005  # [m] of the arrows beside a number


class Posing:
    """`changed` is called when the task is shown, or is another now."""

    def __init__(self, controls: PoseControls, stage: Stage, post: Post, changed: Callable[[], None]):
        self._controls, self._stage, self._post, self._changed = controls, stage, post, changed
        self._problem: Problem | None = None
        self._pictures: Pictures | None = None  # of its model
        self._settle_at: float | None = None  # when faults are looked for
        self._moved_since = False  # since then
        self._rested = False  # faults were looked for, and something is another now
        self._gripped = NOTHING  # what the handle moves
        self._at_keyframe = AS_GIVEN  # where the start was put last
        self._dragged: tuple[st.Pose, bool] | None = None  # the last pose of the handle that was not taken yet, and whether it was let go

    @property
    def problem(self) -> Problem | None:
        """That is posed; None: a scenario is shown."""
        return self._problem

    @property
    def pictures(self) -> Pictures | None:
        return self._pictures

    def open(self, problem: Problem, pictures: Pictures) -> None:
        """Another task; show() draws it."""
        self._problem, self._pictures, self._at_keyframe = problem, pictures, AS_GIVEN
        controls, model, index = self._controls, problem.model, problem.goal_object
        names = names_of(model, index)
        controls.fill_goal(names, problem.goal_numbers(), STEP)
        controls.fill_start(names, numbers_of(model, problem.start, index), STEP)
        units = ["m" if model.dofs[model.n_vu + j].kind == st.DofKind.Prismatic else "rad" for j in range(model.n_a)]
        ranges = [problem.joint_range(j) for j in range(model.n_a)]
        controls.fill_joints(model.joint_names, ranges, problem.start[model.n_qu :].tolist(), units)
        handles = self._handles()
        set_choices(controls.handle, [NOTHING, *handles], "goal" if "goal" in handles else NOTHING)
        set_choices(controls.keyframe, [AS_GIVEN, *problem.keyframes], AS_GIVEN)
        set_choices(controls.goal_of, [model.object_names[i] for i in problem.movable()] or [NOTHING], model.object_names[index])
        controls.keyframe.visible = bool(problem.keyframes)
        controls.goal_of.visible = len(problem.movable()) > 1
        controls.any_turn.visible = problem.can_turn_freely
        controls.any_turn.value = problem.any_turn

    def close(self) -> None:
        """Nothing is posed."""
        self._problem = self._pictures = None

    def tick(self, now: float) -> None:
        if self._settle_at is not None and now >= self._settle_at:
            self._settle_at = None
            self._find_faults()
            self._rested, self._moved_since = self._moved_since, False

    def take_rest(self) -> bool:
        """Whether what was moved has come to rest since the last call."""
        rested, self._rested = self._rested, False
        return rested

    # ---- what is shown ----

    def show(self, aim: bool = False) -> None:
        problem, pictures = self._problem, self._pictures
        if problem is None or pictures is None:
            return
        if self._stage.posed is None or aim:
            self._stage.pose(problem, pictures, aim)
            self._grip()
            self._settle_at = time.monotonic()  # faults follow the first picture
        self._changed()

    def moved(self) -> None:
        """Shows start and goal as they are now; faults follow when nothing moves any more."""
        problem, pictures, controls = self._problem, self._pictures, self._controls
        assert problem is not None and pictures is not None
        self.show()
        self._stage.move_start(problem, pictures)
        self._stage.move_goal(problem)
        model = problem.model
        shown: list[tuple[Sequence[Any], list[float]]] = [
            (controls.goal, numbers_of(model, problem.goal, problem.goal_object)),
            (controls.start, numbers_of(model, problem.start, problem.goal_object)),
            (controls.joints, problem.start[model.n_qu :].tolist()),
        ]
        for handles, values in shown:
            for handle, value in zip(handles, values):
                if abs(handle.value - value) > 1e-9:
                    handle.value = value
        self._settle_at, self._moved_since = time.monotonic() + SETTLED, True
        self._changed()

    def _find_faults(self) -> None:
        problem, pictures = self._problem, self._pictures
        if problem is None or pictures is None or self._stage.posed is None:
            return
        found = faults.find(problem, pictures)
        self._stage.mark(found)
        self._controls.faults.content = "\n".join(f"- ⚠ {fault.message}" for fault in found) or "Lint finds no fault in this start and goal."

    def _follow_goal(self) -> None:
        if self._problem is not None and self._pictures is not None:
            self._stage.follow_goal(self._problem, self._pictures)

    # ---- the handle in the scene ----

    def _handles(self) -> dict[str, tuple[int, bool]]:
        """What can be dragged: object, and whether its goal."""
        problem = self._problem
        assert problem is not None
        objects = range(len(problem.model.objects))
        goal = {"goal": (problem.goal_object, True)} if problem.goal_object in objects else {}
        return goal | {f"start of {problem.model.object_names[i]}": (i, False) for i in objects}

    def _held(self) -> tuple[int | None, bool]:
        return self._handles().get(self._controls.handle.value, (None, True))

    def _grip(self) -> None:
        """The handle where it is wanted."""
        assert self._problem is not None
        self._gripped = self._controls.handle.value
        index, at_goal = self._held()
        self._stage.hold(self._problem, index, at_goal, self.drag)

    def choose_handle(self) -> None:
        if self._problem is not None and self._controls.handle.value != self._gripped:
            self.show()
            self._grip()

    def drag(self, pose: st.Pose, ended: bool) -> None:
        """The handle is there now. Any thread may call it; poses that come faster than they are taken are left out, but for the last."""
        waiting, self._dragged = self._dragged is not None, (pose, ended or bool(self._dragged and self._dragged[1]))
        if not waiting:
            self._post(self._take_drag)

    def _take_drag(self) -> None:
        (pose, ended), self._dragged = self._dragged or (None, False), None
        problem = self._problem
        if pose is None or problem is None:
            return
        index, at_goal = self._held()
        if index is None:
            return
        if at_goal:
            problem.set_goal(pose)
        else:
            problem.set_start(index, pose)
        self.moved()
        if ended:
            self._stage.put_handle(problem, at_goal)

    # ---- numbers ----

    def read_goal(self) -> None:
        self._read(self._controls.goal, at_goal=True)

    def read_start(self) -> None:
        self._read(self._controls.start, at_goal=False)

    def _read(self, handles: list[Any], at_goal: bool) -> None:
        problem = self._problem
        if problem is None:
            return
        values = [float(handle.value) for handle in handles]
        before = numbers_of(problem.model, problem.goal if at_goal else problem.start, problem.goal_object)
        if len(values) != len(before) or np.abs(np.subtract(values, before)).max() <= 1e-9:
            return
        if at_goal:
            problem.set_goal_numbers(values)
        else:
            problem.set_start_numbers(problem.goal_object, values)
        self.moved()
        self._follow_goal()
        self._stage.put_handle(problem, self._held()[1])

    def read_any_turn(self) -> None:
        problem = self._problem
        if problem is not None and problem.can_turn_freely and problem.any_turn != self._controls.any_turn.value:
            problem.any_turn = bool(self._controls.any_turn.value)
            self.moved()

    def choose_keyframe(self) -> None:
        """Raises stiction.InvalidInput."""
        problem, chosen = self._problem, self._controls.keyframe.value
        if problem is None or chosen == self._at_keyframe:
            return
        self._at_keyframe = chosen
        if chosen == AS_GIVEN:
            problem.start_as_given()
        else:
            problem.start_at(chosen)
        self.moved()
        self._grip()

    def read_joints(self) -> None:
        problem, joints = self._problem, self._controls.joints
        if problem is None or len(joints) != problem.model.n_a:
            return
        changed = [j for j, handle in enumerate(joints) if abs(handle.value - problem.start[problem.model.n_qu + j]) > 1e-9]
        for j in changed:
            problem.set_joint(j, joints[j].value)
        if changed:
            self.moved()

    def reset(self) -> None:
        """Start and goal of the task, and its options."""
        if self._problem is not None:
            self._problem.reset()
            self._controls.any_turn.value = self._problem.any_turn
            self._controls.keyframe.value = self._at_keyframe = AS_GIVEN
            self.moved()
            self._follow_goal()
            self._grip()
