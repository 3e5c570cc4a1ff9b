"""Start, goal and options of a task, and what lint says of them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import stiction as st

from . import faults, form
from .desk import MISTAKES, Desk
from .panel import POSE
from .problem import names_of, numbers_of

SETTLED = 0.3  # [s] after the last change faults are looked for
STEP = 0.005  # [m] of the arrows beside a number


class Posing(Desk):
    """A task that is posed."""

    handlers = ("handle", "goal", "start", "joints", "reset", "options", "options_reset", "seed")
    settle_at: float | None = None  # when faults are looked for
    moved_since = False  # since then
    rested = False  # it has been looked for faults, something is another now
    dragged: tuple[st.Pose, bool] | None = None

    def tick(self) -> None:
        super().tick()
        if self.settle_at is not None and time.monotonic() >= self.settle_at:
            self.settle_at = None
            self.find_faults()
            self.rested, self.moved_since = self.moved_since, False

    def fill_pose(self) -> None:
        """Numbers of goal and start."""
        problem, panel = self.problem, self.panel
        assert problem is not None
        index = problem.goal_object
        names = names_of(problem.model, index)
        panel.goal = panel.fill_numbers(panel.goal_folder, panel.goal, names, problem.goal_numbers(), STEP, "goal")
        panel.start = panel.fill_numbers(panel.start_folder, panel.start, names, numbers_of(problem.model, problem.start, index), STEP, "start")

    def fill_options(self) -> None:
        problem = self.problem
        assert problem is not None
        given = problem.given.options
        self.panel.options_fault.visible = False
        self.panel.fill_options(form.fields(given), given.to_dict())

    # ---- posing ----

    def handles(self) -> dict[str, tuple[int, bool]]:
        """What can be dragged: object, and whether its goal."""
        problem = self.problem
        assert problem is not None
        objects = [i for i, info in enumerate(problem.model.objects) if info.n_v > 1]
        goal = {"goal": (problem.goal_object, True)} if problem.goal_object in objects else {}
        return goal | {f"start of {problem.model.object_names[i]}": (i, False) for i in objects}

    def to_pose(self, aim: bool = False) -> None:
        problem, pictures = self.problem, self.pictures
        if problem is None or pictures is None:
            return
        if self.view != POSE or aim:
            self.view = POSE
            self.stage.pose(problem, pictures, aim)
            self.grip()
            self.settle_at = time.monotonic()  # faults follow the first picture
        self.panel.frame.disabled = True
        self.say_command()

    def grip(self) -> None:
        """The handle in the scene, where it is wanted."""
        assert self.problem is not None
        index, at_goal = self.handles().get(self.panel.handle.value, (None, True))

        def moved(pose: st.Pose, ended: bool) -> None:
            waiting, self.dragged = self.dragged is not None, (pose, ended or bool(self.dragged and self.dragged[1]))
            if not waiting:
                self.events.put(self.on_dragged)

        self.stage.hold(self.problem, index, at_goal, moved)

    def on_handle(self) -> None:
        if self.problem is not None:
            self.to_pose()
            self.grip()

    def on_dragged(self) -> None:
        (pose, ended), self.dragged = self.dragged or (None, False), None
        problem = self.problem
        if pose is None or problem is None:
            return
        index, at_goal = self.handles().get(self.panel.handle.value, (None, True))
        if index is None:
            return
        if at_goal:
            problem.set_goal(pose)
        else:
            problem.set_start(index, pose)
        self.moved()
        if ended:
            self.stage.put_handle(problem, at_goal)

    def moved(self) -> None:
        """Shows start and goal as they are now; faults and, if wanted, a plan follow when nothing moves any more."""
        problem, pictures = self.problem, self.pictures
        assert problem is not None and pictures is not None
        self.to_pose()
        self.stage.move_start(problem, pictures)
        self.stage.move_goal(problem)
        model = problem.model
        for handles, q in ((self.panel.goal, problem.goal), (self.panel.start, problem.start)):
            for handle, value in zip(handles, numbers_of(model, q, problem.goal_object)):
                if abs(handle.value - value) > 1e-9:
                    handle.value = value
        for handle, value in zip(self.panel.joints, problem.start[model.n_qu :]):
            if abs(handle.value - value) > 1e-9:
                handle.value = float(value)
        self.settle_at, self.moved_since = time.monotonic() + SETTLED, True
        self.say_command()

    def follow_goal(self) -> None:
        if self.problem is not None and self.pictures is not None:
            self.stage.follow_goal(self.problem, self.pictures)

    def on_goal(self) -> None:
        self._numbers(self.panel.goal, at_goal=True)

    def on_start(self) -> None:
        self._numbers(self.panel.start, at_goal=False)

    def _numbers(self, handles: list[Any], at_goal: bool) -> None:
        problem = self.problem
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
        self.follow_goal()
        self.stage.put_handle(problem, self.handles().get(self.panel.handle.value, (None, True))[1])

    def on_joints(self) -> None:
        problem = self.problem
        if problem is None or len(self.panel.joints) != problem.model.n_a:
            return
        changed = [j for j, handle in enumerate(self.panel.joints) if abs(handle.value - problem.start[problem.model.n_qu + j]) > 1e-9]
        for j in changed:
            problem.set_joint(j, self.panel.joints[j].value)
        if changed:
            self.moved()

    def on_reset(self) -> None:
        if self.problem is not None:
            self.problem.reset()
            self.fill_options()
            self.moved()
            self.follow_goal()
            self.grip()

    def find_faults(self) -> None:
        problem, pictures = self.problem, self.pictures
        if problem is None or pictures is None or self.view != POSE:
            return
        self.faults = faults.find(problem, pictures)
        self.stage.mark(self.faults)
        found = "\n".join(f"- ⚠ {fault.message}" for fault in self.faults)
        self.panel.faults.content = found or "Lint finds no fault in this start and goal."

    # ---- options ----

    def on_options(self) -> None:
        problem, panel = self.problem, self.panel
        if problem is None:
            return
        try:
            values = {name: field.read(handle.value) for name, (field, handle) in panel.options.items()}
            problem.options = form.changed(problem.given.options, values)
        except MISTAKES as error:
            panel.options_fault.content, panel.options_fault.visible = f"**⚠ {error}**", True
            return
        changed = ", ".join(f"`{name}`" for name in problem.options)
        panel.options_fault.content, panel.options_fault.visible = f"changed: {changed}", bool(changed)
        self.say_command()

    def on_options_reset(self) -> None:
        if self.problem is not None:
            self.problem.options = {}
            self.fill_options()
            self.say_command()

    def on_seed(self) -> None:
        if self.problem is None:
            return
        seed = self.panel.seed.value
        if not 0 <= seed < 2**63 or seed != int(seed):
            raise ValueError(f"Seed: got {seed}, expected a whole number from 0 on; {self.problem.seed} stays")
        self.problem.seed = int(seed)
        self.say_command()
