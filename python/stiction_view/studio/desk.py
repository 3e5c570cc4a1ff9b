"""What the parts of the studio share: the page, what is asked for there, done one after the other in one thread, and long work beside it."""

from __future__ import annotations

import queue
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import stiction as st
import viser

from .exporting import reproduce, script
from .jobs import Job, Worker
from .panel import RESULT, Controls
from .picture import Pictures
from .problem import Problem
from .results import Result
from .scenario import Played
from .stage import Stage
from .uploads import Refused

TICK = 1 / 60  # [s] how often the page is looked at
LONGEST_COMMAND = 20_000  # characters that the page shows
PROGRESS = 0.2  # [s] between two words on progress
MISTAKES = (st.InvalidInput, Refused, ValueError, OSError, ImportError)


class Desk:
    """`labels` can be picked. A handler on_NAME answers the control NAME of the panel."""

    handlers: tuple[str, ...] = ()

    def __init__(self, server: viser.ViserServer, labels: list[str], folder: Path):
        self.server, self.folder = server, folder
        self.events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.worker = Worker()
        self.running: Job | None = None  # until its end was seen here
        self.after: Callable[[], None] | None = None  # what waits for that
        self.problem: Problem | None = None  # that is posed
        self.pictures: Pictures | None = None  # of its model
        self.results: list[Result] = []
        self.result: Result | None = None  # that is shown
        self.played: Played | None = None  # a scenario in its place
        self.view = ""
        self.next_word = 0.0
        self.stage = Stage(server)
        self.panel = Controls(server, self.events.put, labels, {name: getattr(self, f"on_{name}") for name in self.handlers})

    # ---- the loop ----

    def run(self) -> None:
        """Until interrupted."""
        while True:
            self.step(TICK)

    def step(self, wait_s: float) -> None:
        """Does what was asked for, and what is due."""
        try:
            self.guarded(self.events.get(timeout=wait_s))
            while True:
                self.guarded(self.events.get_nowait())
        except queue.Empty:
            pass
        self.guarded(self.tick)

    def guarded(self, call: Callable[[], None]) -> None:
        """A mistake is said on the page; a fault of ours as well, and where it happened on stderr."""
        try:
            call()
        except MISTAKES as error:
            self.panel.say(str(error), fault=True)
        except Exception as error:
            self.panel.say(f"a fault of the studio: {type(error).__name__}: {error}", fault=True)
            traceback.print_exc()

    def tick(self) -> None:
        now = time.monotonic()
        job = self.running
        if job is not None and now >= self.next_word:
            self.next_word = now + PROGRESS
            job.seen()
            self.panel.progress.value = 100 * min(1.0, job.fraction)
            self.panel.progress_text.content = f"{job.label}: {job.text or f'{job.seconds():.1f} s'}"

    # ---- long work ----

    def must_be_free(self, wish: str) -> None:
        if self.running is not None:
            raise ValueError(f"{wish}: got it while another job runs ({self.running.label.lower()}); cancel that first, or wait")

    def start(self, job: Job) -> None:
        self.must_be_free(job.label)
        done = job.done
        job.done = lambda j: self.events.put(lambda: self.finish(j, done))
        self.running = job
        self.worker.start(job)
        self.panel.say("")
        self.next_word = 0.0
        self.panel.progress.value = 0.0
        for handle in (self.panel.cancel, self.panel.progress, self.panel.progress_text):
            handle.visible = True
        self.panel.plan.disabled = True

    def finish(self, job: Job, done: Callable[[Job], None]) -> None:
        for handle in (self.panel.cancel, self.panel.progress, self.panel.progress_text):
            handle.visible = False
        self.panel.plan.disabled = False
        self.running = None
        job.ended()
        if (after := self.after) is not None:
            self.after = None
            self.events.put(after)
        if job.dropped:
            return
        if job.error is not None:
            if isinstance(job.error, MISTAKES):
                raise type(job.error)(*job.error.args)
            raise job.error
        done(job)

    def on_cancel(self) -> None:
        self.worker.cancel()

    def drop(self) -> None:
        """What runs is not wanted any more."""
        self.after = None
        if self.running is not None:
            self.running.dropped = True
            self.worker.cancel()

    def when_free(self, call: Callable[[], None]) -> None:
        """Does it now, or as soon as what runs is over."""
        if self.running is None:
            call()
        else:
            self.after = call

    def say_command(self) -> None:
        """The text that gives the plan that is shown, or the one that `Plan` would make."""
        if self.view == RESULT and self.result is not None:
            text = reproduce(self.result)
        elif self.problem is not None:
            text = script(self.problem.command(float(self.panel.budget.value)), self.problem.task_file())
        else:
            text = ""
        if len(text) > LONGEST_COMMAND:
            text = "# task.yaml is in the download `everything`\n" + text.rstrip().rsplit("\n", 1)[-1] + "\n"
        self.panel.command.content = f"```sh\n{text}```" if text else ""
