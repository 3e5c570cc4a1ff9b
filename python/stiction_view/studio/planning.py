"""Long work on what is posed and on what came out: a plan, its run in MuJoCo, its verdict."""

from __future__ import annotations

import stiction as st
import viser

from . import results
from .growing import start_growing
from .jobs import Job
from .panel import HeadControls, SearchControls
from .posing import Posing
from .results import Result
from .showing import Showing
from .stage import Stage
from .work import Work


class Planning:
    def __init__(self, server: viser.ViserServer, head: HeadControls, controls: SearchControls, stage: Stage, work: Work, posing: Posing, showing: Showing):
        self._server, self._head, self._controls, self._stage = server, head, controls, stage
        self._work, self._posing, self._showing = work, posing, showing
        self._counted = 0  # searches that were begun

    @property
    def budget(self) -> float:
        """Of a job [s]."""
        return float(self._controls.budget.value)

    def tick(self) -> None:
        """A plan is wanted, if so chosen, whenever what was moved has come to rest."""
        if self._posing.take_rest() and self._controls.again.value:
            self._work.drop()
            self._work.when_free(self.plan)

    def open(self) -> None:
        """Another task is posed."""
        assert self._posing.problem is not None
        self._controls.seed.value = self._posing.problem.seed

    def read_seed(self) -> bool:
        """Whether there is a task that it is for. Raises ValueError."""
        problem = self._posing.problem
        if problem is None:
            return False
        seed = self._controls.seed.value
        if not 0 <= seed < 2**63 or seed != int(seed):
            raise ValueError(f"Seed: got {seed}, expected a whole number from 0 on; {problem.seed} stays")
        problem.seed = int(seed)
        return True

    def plan(self) -> None:
        """Raises ValueError: there is no task, or another job runs."""
        problem, pictures = self._posing.problem, self._posing.pictures
        if problem is None or pictures is None:
            raise ValueError("plan: no task is open; open one")
        self._work.must_be_free("Planning")
        task, options, seed = problem.task(), dict(problem.options), problem.seed
        budget, refine = self.budget, bool(self._controls.refine.value)
        command, task_file, files = problem.command(budget), problem.task_file(), problem.files()
        self._counted += 1
        number = self._counted
        self._posing.show()
        stage = self._stage
        growing = start_growing(self._server, task, stage.size_of(task.model.object_names[task.goal.object]))

        def work(job: Job) -> Result:
            out = st.plan(task, options=options, seed=seed, timeout_s=budget, on_progress=job.watch, on_growth=growing.trees.take)
            plan, reason = out.plan, out.reason
            lines = [command]
            if refine and plan.status == st.Status.Solved and not job.cancelled.is_set():
                job.label = "Refining"
                plan = st.refine(plan, timeout_s=budget, on_progress=job.watch).plan
                lines.append("stiction refine out")
            return results.make_result(number, plan, pictures, "\n".join(lines), task_file, reason, job.seconds(), files)

        self._work.start(Job("Planning", work, self._planned, seen=lambda: growing.show(stage.posed is not None), ended=growing.end))

    def _planned(self, job: Job) -> None:
        result: Result = job.result
        self._showing.add(result)
        self._head.say(result.headline())

    def _result(self, wish: str) -> Result:
        if self._showing.result is None:
            raise ValueError(f"{wish}: nothing is planned yet")
        return self._showing.result

    def simulate(self) -> None:
        """Raises ValueError: there is no plan, or another job runs."""
        result, budget = self._result("simulate"), self.budget

        def done(job: Job) -> None:
            self._showing.add_run(result, job.result)
            self._head.say(job.result.words)

        self._work.start(Job("Running in MuJoCo", lambda _: results.make_run(result, budget), done))

    def check(self) -> None:
        """Raises ValueError: there is no plan, or another job runs."""
        result = self._result("check")

        def done(job: Job) -> None:
            self._showing.add_verdict(result, job.result)
            self._head.say(result.verdict)

        self._work.start(Job("Checking", lambda _: results.check(result), done))
