"""Plans, alone, side by side or beside their run, and scenarios: played and in figures."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import stiction as st
import viser

from . import results
from .exporting import export
from .growing import start_growing
from .jobs import Job
from .panel import BLUE, GREEN, NOTHING, ORANGE, POSE, RED, RESULT
from .posing import Posing
from .results import Result, Run
from .scenario import Played
from .stage import Shown

MAX_RESULTS = 8
IN_MUJOCO = "the same in MuJoCo"


class Showing(Posing):
    """What came out."""

    handlers = (*Posing.handlers, "plan", "cancel", "view", "which", "beside", "simulate", "check", "save")
    counted = 0
    knot_shown = -1
    next_knot = 0.0

    def tick(self) -> None:
        super().tick()
        if self.rested:
            self.rested = False
            if self.panel.again.value:
                self.drop()
                self.when_free(self.on_plan)
        self.play(time.monotonic())

    def on_plan(self) -> None:
        problem, pictures = self.problem, self.pictures
        if problem is None or pictures is None:
            raise ValueError("plan: a scenario is shown; open a task")
        self.must_be_free("Planning")
        task, options, seed = problem.task(), dict(problem.options), problem.seed
        budget, refine = float(self.panel.budget.value), bool(self.panel.refine.value)
        command, task_file, files = problem.command(budget), problem.task_file(), problem.files()
        self.counted += 1
        number = self.counted
        self.to_pose()
        growing = start_growing(self.server, task, self.stage.size_of(task.model.object_names[task.goal.object]))

        def work(job: Job) -> Result:
            out = st.plan(task, options=options, seed=seed, timeout_s=budget, on_progress=job.watch, on_growth=growing.trees.take)
            plan, reason = out.plan, out.reason
            lines = [command]
            if refine and plan.status == st.Status.Solved and not job.cancelled.is_set():
                job.label = "Refining"
                plan = st.refine(plan, timeout_s=budget, on_progress=job.watch).plan
                lines.append("stiction refine out")
            return results.make_result(number, plan, pictures, "\n".join(lines), task_file, reason, job.seconds(), files)

        self.start(Job("Planning", work, self.planned, seen=lambda: growing.show(self.view == POSE), ended=growing.end))

    def planned(self, job: Job) -> None:
        self.results = [*self.results, job.result][-MAX_RESULTS:]
        self.result = job.result
        self.list_results()
        self.panel.set_choices(self.panel.which, self.panel.which.options, self.result.label)
        self.to_result()
        self.panel.say(self.result.headline())

    def on_simulate(self) -> None:
        result = self.result
        if result is None:
            raise ValueError("simulate: nothing is planned yet")
        budget = float(self.panel.budget.value)

        def done(job: Job) -> None:
            result.run = job.result
            self.list_results()
            if self.result is result:
                self.panel.set_choices(self.panel.beside, self.panel.beside.options, IN_MUJOCO)
                self.to_result()
            self.panel.say(job.result.words)

        self.start(Job("Running in MuJoCo", lambda _: results.make_run(result, budget), done))

    def on_check(self) -> None:
        result = self.result
        if result is None:
            raise ValueError("check: nothing is planned yet")

        def done(job: Job) -> None:
            result.verdict = job.result
            self.say_result()
            self.panel.say(result.verdict)

        self.start(Job("Checking", lambda _: results.check(result), done))

    # ---- what came out ----

    def list_results(self) -> None:
        """Choices of what is shown, and beside what."""
        labels = [r.label for r in self.results]
        panel = self.panel
        panel.set_choices(panel.which, labels or [NOTHING], self.result.label if self.result else (labels or [NOTHING])[-1])
        beside = [NOTHING, *([IN_MUJOCO] if self.result and self.result.run else []), *(x for x in labels if not self.result or x != self.result.label)]
        panel.set_choices(panel.beside, beside, panel.beside.value if panel.beside.value in beside else NOTHING)

    def on_view(self, name: str) -> None:
        if name == POSE:
            if self.problem is None:
                raise ValueError("pose: a scenario is shown; open a task")
            self.to_pose()
        elif self.result is not None:
            self.to_result()
        else:
            raise ValueError("result: nothing is planned yet")

    def on_which(self) -> None:
        chosen = next((r for r in self.results if r.label == self.panel.which.value), None)
        if chosen is not None and chosen is not self.result:
            self.result = chosen
            self.list_results()
            self.to_result()

    def on_beside(self) -> None:
        if self.view == RESULT and self.result is not None and self.played is None:
            self.to_result()

    def motions(self) -> tuple[list[Shown], Run | None]:
        """The plan that is shown and what is beside it."""
        result = self.result
        assert result is not None
        beside = self.panel.beside.value
        if beside == IN_MUJOCO and result.run is not None:
            return [Shown(result.run.planned, result.pictures, "planned"), Shown(result.run.simulated, result.pictures, "in MuJoCo")], result.run
        first = Shown(result.drawn, result.pictures, result.label)
        other = next((r for r in self.results if r.label == beside), None)
        return [first, *([Shown(other.drawn, other.pictures, other.label)] if other is not None else [])], None

    def to_result(self) -> None:
        motions, run = self.motions()
        self.view, self.played = RESULT, None
        self.stage.show(motions)
        self.set_frames(max(len(m.plan.poses) for m in motions))
        self.say_result()
        assert self.result is not None
        series = self.result.series
        charts = []
        if run is None:
            charts = [
                ("effort used", "%", 100 * series.effort_share(), BLUE),
                ("max_force used", "%", 100 * series.press_share(), RED),
                ("friction used", "%", 100 * series.friction_use, ORANGE),
                ("largest contact force", "N", series.force, RED),
                ("smallest gap", "mm", 1e3 * series.gap, GREEN),
            ]
            charts = [c for c in charts if np.isfinite(c[2]).any()]
        self.panel.fill_charts(np.arange(len(series.force)), "knot", charts)

    def set_frames(self, count: int) -> None:
        panel = self.panel
        panel.frame.disabled = False
        panel.playback.visible = True
        panel.frame.max = max(1, count - 1)
        self.knot_shown = -1
        panel.frame.value = 0
        panel.play.value = True

    def say_result(self) -> None:
        if self.result is not None:
            self.panel.figures.content = self.result.words()
            self.say_command()

    def played_done(self, job: Job) -> None:
        """A scenario was carried out."""
        played: Played = job.result
        self.played, self.view, self.problem, self.pictures = played, RESULT, None, None
        self.stage.show([Shown(played.drawn, played.pictures, played.name, with_goal=False)])
        self.panel.about.content = played.words
        self.panel.figures.content = played.words
        colors = (RED, BLUE, GREEN)
        self.panel.fill_charts(played.times, "t [s]", [(t, unit, v, colors[k % 3]) for k, (t, (unit, v)) in enumerate(played.charts.items())])
        self.set_frames(len(played.drawn.poses))

    def play(self, now: float) -> None:
        """Follows the slider, and moves it while it plays."""
        if self.view != RESULT or not self.stage.shown:
            return
        panel = self.panel
        last = int(panel.frame.max)
        if panel.play.value and now >= self.next_knot:
            self.next_knot = now + 1 / float(panel.speed.value)
            if self.knot_shown >= last:
                panel.play.value = False
            elif self.knot_shown == int(panel.frame.value):
                panel.frame.value = self.knot_shown + 1
        knot = min(int(panel.frame.value), last)
        if knot != self.knot_shown:
            self.knot_shown = knot
            self.stage.show_frame(knot)
            panel.line.content = self.words_at(knot)

    def words_at(self, knot: int) -> str:
        if self.played is not None:
            return self.played.lines[min(knot, len(self.played.lines) - 1)]
        result = self.result
        assert result is not None
        if self.panel.beside.value == IN_MUJOCO and result.run is not None:
            run = result.run
            k = min(knot, len(run.times) - 1)
            body = run.planned.bodies[run.planned.goal_body].moving
            off = np.linalg.norm(run.planned.poses[k, body, :3] - run.simulated.poses[k, body, :3])
            return f"t = {run.times[k]:.2f} s, the object is {1e3 * off:.1f} mm from where it is planned"
        return result.series.line(min(knot, len(result.series.force) - 1))

    def on_save(self, client: viser.ClientHandle | None = None) -> None:
        """For whoever pressed it; None: for all who are there."""
        result = self.result
        if result is None:
            raise ValueError("export: nothing is planned yet")
        choice = self.panel.format.value
        receiver = client or self.server
        done: Callable[[Job], None] = lambda job: receiver.send_file_download(*job.result, save_immediately=True)
        self.start(Job("Writing", lambda _: export(result, choice), done))
