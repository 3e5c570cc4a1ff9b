"""What is downloaded: files, and the lines that plan the same again."""

from __future__ import annotations

import viser
from stiction.reports import make_report

from .exporting import as_zip, export, reproduce, script
from .jobs import Job
from .panel import ExportControls, HeadControls, SearchControls
from .posing import Posing
from .showing import Showing
from .stage import Stage
from .work import Work

LONGEST_COMMAND = 20_000  # characters that the page shows


class Downloads:
    def __init__(self, server: viser.ViserServer, head: HeadControls, controls: ExportControls, search: SearchControls, stage: Stage, work: Work, posing: Posing, showing: Showing):
        self._server, self._head, self._controls, self._search, self._stage = server, head, controls, search, stage
        self._work, self._posing, self._showing = work, posing, showing

    def say_command(self) -> None:
        """The text that gives the plan that is shown, or the one that `Plan` would make."""
        result, problem = self._showing.result, self._posing.problem
        if self._stage.shown and result is not None:
            text = reproduce(result)
        elif problem is not None:
            text = script(problem.command(float(self._search.budget.value)), problem.task_file())
        else:
            text = ""
        if len(text) > LONGEST_COMMAND:
            text = "# task.yaml is in the download `everything`\n" + text.rstrip().rsplit("\n", 1)[-1] + "\n"
        self._controls.command.content = f"```sh\n{text}```" if text else ""

    def report(self, client: viser.ClientHandle | None = None) -> None:
        """Of the plan that is shown, or else of the task that is posed, which is planned for it. Raises ValueError: there is none, or another job runs."""
        result, problem, note = self._showing.result, self._posing.problem, str(self._controls.note.value)
        if self._stage.shown and result is not None and self._showing.played is None:
            task, plan, seed = result.plan.task, result.plan, result.plan.seed
        elif problem is not None:
            task, plan, seed = problem.task().with_(options=problem.options), None, problem.seed
        else:
            raise ValueError("report: no task is open; open one, or use `stiction report`")
        budget, receiver = float(self._search.budget.value), client or self._server

        def done(job: Job) -> None:
            receiver.send_file_download(f"{task.name or 'task'}-report.zip", job.result, save_immediately=True)
            self._head.say("The report is downloaded. Look at it before you send it.")

        self._work.start(Job("Writing a report", lambda _: as_zip(make_report(task, seed=seed, timeout_s=budget, plan=plan, note=note)), done))

    def save(self, client: viser.ClientHandle | None = None) -> None:
        """For whoever pressed it; None: for all who are there. Raises ValueError: there is no plan, or another job runs."""
        result = self._showing.result
        if result is None:
            raise ValueError("export: nothing is planned yet")
        choice, receiver = self._controls.format.value, client or self._server

        def done(job: Job) -> None:
            receiver.send_file_download(*job.result, save_immediately=True)

        self._work.start(Job("Writing", lambda _: export(result, choice), done))
