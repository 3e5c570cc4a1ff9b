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
from .problem import Problem, Snapshot, chain, names_of, numbers_of, ranges_of
from .stage import Grip, Stage
from .texts import plain

SETTLED = 0.3  # [s] after the last change faults are looked for
STEP = 0.005  # [m] of the arrows beside a number
WHOLE = 6  # joints with which an arm takes its hand anywhere; with fewer only the place of a link is dragged
MOST_UNDONE = 50


def handles_of(problem: Problem) -> dict[str, list[Grip]]:
    """What can be dragged, by its name."""
    model = problem.model
    names = model.object_names
    goals = {f"goal of {names[i]}": [Grip(i, at_goal=True)] for i in problem.goal_objects}
    if len(goals) == 1:
        goals = {"goal": next(iter(goals.values()))}
    elif goals:
        goals = {"all goals": [grip for grips in goals.values() for grip in grips]} | goals
    starts = {f"start of {name}": [Grip(i)] for i, name in enumerate(names)}
    joints = {body.name: sum(k >= model.n_vu for k in body.dofs) for body in model.bodies}
    links = {f"link {link.name}": [Grip(link=link.name, turns=joints[link.name] >= WHOLE)] for link in model.links if joints[link.name]}
    return goals | starts | links


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
        self._handles: dict[str, list[Grip]] = {}  # of the task, by their names
        self._dragged: dict[Grip, tuple[st.Pose, bool]] = {}  # the last pose of each handle that was not taken yet, and whether it was let go
        self._undo: list[Snapshot] = []  # the last is the newest
        self._changing = ""  # what the newest one was taken before

    @property
    def problem(self) -> Problem | None:
        """That is posed; None: a scenario is shown."""
        return self._problem

    @property
    def pictures(self) -> Pictures | None:
        return self._pictures

    def open(self, problem: Problem, pictures: Pictures) -> None:
        """Another task; show() draws it."""
        self._problem, self._pictures = problem, pictures
        controls, model, index = self._controls, problem.model, problem.goal_object
        self._undo, self._changing = [], ""
        controls.fill_goal(problem.goal_names(), problem.goal_numbers(), STEP, [r for i in problem.goal_parts() for r in ranges_of(model, i)])
        of_start = [r for i in chain(model, index) for r in ranges_of(model, i)]
        controls.fill_start(names_of(model, index), numbers_of(model, problem.start, index), STEP, of_start)
        units = ["m" if model.dofs[model.n_vu + j].kind == st.DofKind.Prismatic else "rad" for j in range(model.n_a)]
        ranges = [problem.joint_range(j) for j in range(model.n_a)]
        controls.fill_joints(model.joint_names, ranges, problem.start[model.n_qu :].tolist(), units)
        self._handles = handles_of(problem)
        set_choices(controls.handle, [NOTHING, *self._handles], next(iter(self._handles), NOTHING))
        controls.undo.disabled = True
        set_choices(controls.keyframe, [AS_GIVEN, *problem.keyframes], problem.keyframe or AS_GIVEN)
        set_choices(controls.goal_of, [model.object_names[i] for i in problem.movable()] or [NOTHING], model.object_names[index])
        controls.keyframe.visible = bool(problem.keyframes)
        controls.goal_of.visible = len(problem.movable()) > 1
        controls.any_turn.visible = problem.can_turn_freely
        controls.any_turn.value = problem.any_turn

    def close(self) -> None:
        """Nothing is posed."""
        self._problem = self._pictures = None
        self._handles = {}

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
            self._stage.pose(problem, pictures, aim, self.pick)
            self._grip()
            self._settle_at = time.monotonic()  # faults follow the first picture
        self._changed()

    def moved(self, dragged: Grip | None = None) -> None:
        """Shows start and goal as they are now, and all handles but the one that is dragged; faults follow when nothing moves any more."""
        problem, pictures, controls = self._problem, self._pictures, self._controls
        assert problem is not None and pictures is not None
        self.show()
        self._stage.move_start(problem, pictures)
        self._stage.move_goal(problem, pictures)
        model = problem.model
        shown: list[tuple[Sequence[Any], list[float]]] = [
            (controls.goal, problem.goal_numbers()),
            (controls.start, numbers_of(model, problem.start, problem.goal_object)),
            (controls.joints, problem.start[model.n_qu :].tolist()),
        ]
        for handles, values in shown:
            for handle, value in zip(handles, values):
                if abs(handle.value - value) > 1e-9:
                    handle.value = value
        self._stage.put_handles(problem, dragged)
        if dragged is None or not dragged.link:
            self._say_posture()
        self._settle_at, self._moved_since = time.monotonic() + SETTLED, True
        self._changed()

    def _find_faults(self) -> None:
        problem, pictures = self._problem, self._pictures
        if problem is None or pictures is None or self._stage.posed is None:
            return
        found = faults.find(problem, pictures)
        self._stage.mark(found)
        self._controls.faults.content = "\n".join(f"- ⚠ {plain(fault.message)}" for fault in found) or "Lint finds no fault in this start and goal."

    def _follow_goal(self) -> None:
        if self._problem is not None and self._pictures is not None:
            self._stage.follow_goal(self._problem, self._pictures)

    # ---- the handle in the scene ----

    def grips(self) -> list[Grip]:
        """What has a handle now."""
        return self._handles.get(self._controls.handle.value, [])

    def _grip(self) -> None:
        """The handles where they are wanted."""
        assert self._problem is not None
        self._gripped = self._controls.handle.value
        self._stage.hold(self._problem, self.grips(), self.drag)
        self._say_posture()

    def choose_handle(self) -> None:
        if self._problem is not None and self._controls.handle.value != self._gripped:
            self.show()
            self._grip()

    def pick(self, link: str) -> None:
        """A link was clicked: it gets the handle. Any thread may call it."""
        self._post(lambda: self._take_link(link))

    def _take_link(self, link: str) -> None:
        name = f"link {link}"
        if self._problem is not None and name in self._controls.handle.options:
            set_choices(self._controls.handle, self._controls.handle.options, name)
            self.choose_handle()

    def drag(self, grip: Grip, pose: st.Pose, ended: bool) -> None:
        """A handle is there now. Any thread may call it; poses that come faster than they are taken are left out, but for the last."""
        before = self._dragged.get(grip)
        self._dragged[grip] = pose, ended or (before is not None and before[1])
        if before is None:
            self._post(lambda: self._take_drag(grip))

    def _take_drag(self, grip: Grip) -> None:
        pose, ended = self._dragged.pop(grip, (None, False))
        if pose is not None and self._problem is not None and grip in self.grips():
            with self._stage.server.atomic():  # in one message: an arm does not come apart on its way, and fewer take less time
                self._follow(self._problem, grip, pose, ended)

    def _follow(self, problem: Problem, grip: Grip, pose: st.Pose, ended: bool) -> None:
        """What is dragged goes where the handle is, or as near as it may."""
        self._remember(f"drag {grip}")
        if grip.link:
            self._say_posture(problem.drag_link(grip.link, pose, grip.turns))
        elif grip.at_goal:
            problem.set_goal(pose, grip.index)
        else:
            problem.set_start(grip.index, pose)
        if ended:
            self._changing = ""
        self.moved(None if ended else grip)

    def _say_posture(self, placed: st.PlacedLinks | None = None) -> None:
        """The joints where a link has the handle, and how far it is from where it was dragged to."""
        problem, line = self._problem, self._controls.posture
        line.visible = any(grip.link for grip in self.grips())
        if problem is None or not line.visible:
            return
        model = problem.model
        joints = [f"{name.split('/')[-1]} {value:.3f}" for name, value in zip(model.joint_names, problem.start[model.n_qu :])]
        far = ""
        if placed is not None and placed.status == st.Status.MaxIterations:
            far = f"out of reach: {1e3 * placed.position:.0f} mm and {placed.angle:.2f} rad short  \n"
        line.content = f"{far}joints: {plain(', '.join(joints))}"

    # ---- back again ----

    def _remember(self, change: str) -> None:
        """Start and goal before a change; those of one drag, or of one number, count once."""
        if self._problem is None or change == self._changing:
            return
        self._undo = [*self._undo, self._problem.snapshot()][-MOST_UNDONE:]
        self._changing = change
        self._controls.undo.disabled = False

    def undo(self) -> None:
        """As it was before the last change."""
        if self._problem is None or not self._undo:
            return
        self._problem.restore(self._undo.pop())
        self._changing = ""
        self._controls.undo.disabled = not self._undo
        self._show_choices(self._problem)
        self.moved()
        self._follow_goal()

    def _show_choices(self, problem: Problem) -> None:
        controls = self._controls
        controls.any_turn.value = problem.any_turn
        set_choices(controls.keyframe, controls.keyframe.options, problem.keyframe or AS_GIVEN)

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
        before = problem.goal_numbers() if at_goal else numbers_of(problem.model, problem.start, problem.goal_object)
        if len(values) != len(before) or np.abs(np.subtract(values, before)).max() <= 1e-9:
            return
        self._remember(f"numbers {at_goal} {int(np.argmax(np.abs(np.subtract(values, before))))}")
        if at_goal:
            problem.set_goal_numbers(values)
        else:
            problem.set_start_numbers(problem.goal_object, values)
        self.moved()
        self._follow_goal()

    def read_any_turn(self) -> None:
        problem = self._problem
        if problem is not None and problem.can_turn_freely and problem.any_turn != self._controls.any_turn.value:
            self._remember("any turn")
            problem.any_turn = bool(self._controls.any_turn.value)
            self.moved()

    def choose_keyframe(self) -> None:
        """Raises stiction.InvalidInput."""
        problem, chosen = self._problem, self._controls.keyframe.value
        if problem is None or chosen == (problem.keyframe or AS_GIVEN):
            return
        self._remember(f"keyframe {chosen}")
        if chosen == AS_GIVEN:
            problem.start_as_given()
        else:
            problem.start_at(chosen)
        self.moved()

    def read_joints(self) -> None:
        problem, joints = self._problem, self._controls.joints
        if problem is None or len(joints) != problem.model.n_a:
            return
        changed = [j for j, handle in enumerate(joints) if abs(handle.value - problem.start[problem.model.n_qu + j]) > 1e-9]
        if changed:
            self._remember(f"joint {changed[0]}")
        for j in changed:
            problem.set_joint(j, joints[j].value)
        if changed:
            self.moved()

    def reset(self) -> None:
        """Start and goal of the task, and its options."""
        if self._problem is not None:
            self._remember("reset")
            self._problem.reset()
            self._show_choices(self._problem)
            self.moved()
            self._follow_goal()
