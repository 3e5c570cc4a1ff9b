"""What is downloaded: files, and the lines that plan the same again."""

from __future__ import annotations

import viser

from .exporting import export, reproduce, script
from .jobs import Job
from .panel import ExportControls, SearchControls
from .posing import Posing
from .showing import Showing
from .stage import Stage
from .work import Work

LONGEST_COMMAND = 20_000  # characters that the page shows


class Downloads:
    def __init__(self, server: viser.ViserServer, controls: ExportControls, search: SearchControls, stage: Stage, work: Work, posing: Posing, showing: Showing):
        self._server, self._controls, self._search, self._stage = server, controls, search, stage
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

    def save(self, client: viser.ClientHandle | None = None) -> None:
        """For whoever pressed it; None: for all who are there. Raises ValueError: there is no plan, or another job runs."""
        result = self._showing.result
        if result is None:
            raise ValueError("export: nothing is planned yet")
        choice, receiver = self._controls.format.value, client or self._server

        def done(job: Job) -> None:
            receiver.send_file_download(*job.result, save_immediately=True)

        self._work.start(Job("Writing", lambda _: export(result, choice), done))
