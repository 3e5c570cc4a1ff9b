"""A task or a plan in closed loop while somebody watches, and pulls at its objects with the mouse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import stiction as st

from .jobs import Job
from .live import LivePlant
from .panel import HeadControls, RunControls
from .picture import Pictures
from .posing import Posing
from .scenario import Played, chosen_frames
from .showing import Showing
from .stage import Stage
from .texts import plain
from .work import Work

LONGEST = 3600.0  # [s] of one run, by the clock of the plant and by that on the wall


def weight_of(model: st.Model, index: int) -> float:
    """Of an object and all that hangs on it [N]."""
    mass = sum(info.mass for i, info in enumerate(model.objects) if i == index or info.parent == index)
    return float(f"{9.81 * mass:.2g}")


def counted(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


@dataclass
class Ended:
    """What came of it."""

    runs: list[st.RunResult]
    times: np.ndarray  # [s] (samples)
    q: np.ndarray  # (samples, n_q)
    force: np.ndarray  # of the hand [N] (samples)

    @property
    def reached(self) -> int:
        return sum(run.reached for run in self.runs)

    def words(self) -> str:
        """How it went, in markdown."""
        plans = [plan for run in self.runs for plan in run.plans]
        causes = list(dict.fromkeys(plan.cause for plan in plans if plan.cause))
        rows = [f"**run live** for {self.times[-1]:.1f} s: {counted(self.reached, 'time')} at the goal, {counted(len(plans), 'plan')}"]
        if self.force.max() > 0:
            rows.append(f"pulled with up to {self.force.max():.3g} N")
        if causes:
            rows.append(f"planned because of: {plain('; '.join(causes))}")
        for run in self.runs[-1:]:
            if run.end not in (st.RunEnd.Reached, st.RunEnd.Cancelled):
                rows.append(f"⚠ {plain(run.message)}")
        return "  \n".join(rows)


def carry_out(job: Job, plant: LivePlant, task: st.Task, plan: st.Plan | None, options: st.PlannerOptions | dict[str, object], seed: int) -> Ended:
    """Runs until it is cancelled or cannot go on: at the goal it rests, and goes on as soon as the object is not there any more."""
    goal = task.goal
    runs: list[st.RunResult] = []

    def watch(progress: st.Progress) -> bool:
        job.text = f"{plant.now()[0]:.1f} s, plan {max(1, progress.iteration)}, {progress.best:.3g} tolerances from the goal"
        return not job.cancelled.is_set()

    def is_over(q: np.ndarray) -> bool:
        position, angle = task.goal_errors(q[None])[0]
        return job.cancelled.is_set() or bool(position > goal.tol_position or angle > goal.tol_angle)

    target: st.Task | st.Plan = task if plan is None else plan
    while not job.cancelled.is_set():
        runs.append(st.run(target, plant=plant, options=options, seed=seed, duration=LONGEST, timeout_s=LONGEST, on_progress=watch))
        if not runs[-1].reached:
            break
        job.text = f"{plant.now()[0]:.1f} s, at the goal: pull at the object, or stop"
        if not plant.rest(is_over):
            break
        target = task
    log = plant.log
    return Ended(runs, np.array(log.times), np.array(log.q), np.linalg.norm(log.force_W, axis=1))


def as_played(ended: Ended, task: st.Task, pictures: Pictures) -> Played:
    """The whole of it, to be looked at again."""
    chosen = chosen_frames(len(ended.times))
    drawn = pictures.plan(ended.q[chosen], task.goal.X_WG, task.goal.object, task.name)
    errors = task.goal_errors(ended.q[chosen])
    share = np.max(errors / [task.goal.tol_position, task.goal.tol_angle], axis=1)
    force = ended.force[chosen]
    lines = [f"t = {t:.2f} s, {s:.2g} tolerances from the goal" + (f", pulled with {f:.2g} N" if f > 0 else "") for t, s, f in zip(ended.times[chosen], share, force)]
    charts = {"distance from the goal": ("tolerances", share), "force of the hand": ("N", force)}
    return Played(task.name, drawn, pictures, ended.times[chosen], lines, ended.words(), charts)


class Running:
    """The part of the studio behind `Run live`."""

    def __init__(self, head: HeadControls, controls: RunControls, stage: Stage, work: Work, posing: Posing, showing: Showing):
        self._head, self._controls, self._stage, self._work, self._posing, self._showing = head, controls, stage, work, posing, showing
        self._plant: LivePlant | None = None
        self._pictures: Pictures | None = None
        self._time = -1.0  # that is shown

    @property
    def plant(self) -> LivePlant | None:
        """That runs now."""
        return self._plant

    def open(self) -> None:
        """Another task is posed."""
        problem = self._posing.problem
        if problem is not None:
            self._controls.newton.value = max(self._controls.newton.min or 0.0, weight_of(problem.model, problem.goal_object))

    def run(self) -> None:
        """The plan that is shown, or else the task that is posed. Raises ValueError: there is none, or another job runs."""
        problem, pictures = self._posing.problem, self._posing.pictures
        if problem is None or pictures is None:
            raise ValueError("run: no task is open; open one")
        self._work.must_be_free("Running live")
        result = self._showing.result if self._stage.shown and self._showing.played is None else None
        plan, options, seed = (None, dict(problem.options), problem.seed) if result is None else (result.plan, result.plan.options, result.plan.seed)
        task = problem.task() if result is None else result.plan.task
        pictures = pictures if result is None else result.pictures
        start = pictures.plan(task.q_start, task.goal.X_WG, task.goal.object, task.name)
        self._stage.run(start, pictures, self.pull)
        plant = LivePlant(task, float(self._controls.newton.value), 2 * self._stage.size_of(task.model.object_names[task.goal.object]))
        self._plant, self._pictures, self._time = plant, pictures, -1.0
        self._head.say("")

        def done(job: Job) -> None:
            ended: Ended = job.result
            self._head.say(ended.words())
            if self._stage.running is not None and ended.runs:
                self._showing.show_scenario(as_played(ended, task, pictures))

        self._work.start(Job("Running live", lambda job: carry_out(job, plant, task, plan, options, seed), done, ended=self._end))

    def _end(self) -> None:
        self._plant = None

    def pull(self, body: str, point_W: np.ndarray, hand_W: np.ndarray, phase: str) -> None:
        """The mouse drags a body. Any thread may call it."""
        plant = self._plant
        if plant is not None:
            plant.hold.drag(plant.now()[1], body, point_W, hand_W, phase)

    def tick(self) -> None:
        """Shows where things are; a run that is not looked at any more ends."""
        plant, pictures = self._plant, self._pictures
        if plant is None or pictures is None:
            return
        if self._stage.running is None:
            self._work.cancel()
            return
        plant.hold.newton = float(self._controls.newton.value)
        time, q, force, point = plant.now()
        if time != self._time:
            self._time = time
            self._stage.show_run(pictures.poses(q)[0], force / plant.hold.newton * plant.hold.stretch, point)
