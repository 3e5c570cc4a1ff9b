"""One long job at a time beside the page, how far it is, and what waits for its end."""

from __future__ import annotations

from collections.abc import Callable

from .desk import MISTAKES, Desk
from .jobs import Job, Worker
from .panel import HeadControls, SearchControls

AT_END = 3.0  # [s] for the end of a job that is cancelled when the program ends
PROGRESS = 0.2  # [s] between two words on progress


class Work:
    """Runs jobs; their ends are posted to the desk."""

    def __init__(self, desk: Desk, head: HeadControls, controls: SearchControls):
        self._desk, self._head, self._controls = desk, head, controls
        self._worker = Worker()
        self._running: Job | None = None  # until its end was seen here
        self._after: Callable[[], None] | None = None  # what waits for that
        self._next_word = 0.0

    @property
    def running(self) -> Job | None:
        """The job whose end was not seen yet."""
        return self._running

    def must_be_free(self, wish: str) -> None:
        """Raises ValueError: another job runs."""
        if self._running is not None:
            raise ValueError(f"{wish}: got it while another job runs ({self._running.label.lower()}); cancel that first, or wait")

    def start(self, job: Job) -> None:
        """Raises ValueError: another job runs."""
        self.must_be_free(job.label)
        done = job.done
        job.done = lambda j: self._desk.post(lambda: self._finish(j, done))
        self._running = job
        self._worker.start(job)
        self._head.say("")
        self._next_word = 0.0
        self._controls.show_job(True)

    def _finish(self, job: Job, done: Callable[[Job], None]) -> None:
        self._controls.show_job(False)
        self._running = None
        job.ended()
        if (after := self._after) is not None:
            self._after = None
            self._desk.post(after)
        if job.dropped:
            return
        if job.error is not None:
            if isinstance(job.error, MISTAKES):
                raise type(job.error)(*job.error.args)
            raise job.error
        done(job)

    def tick(self, now: float) -> None:
        """Says how far it is."""
        job = self._running
        if job is not None and now >= self._next_word:
            self._next_word = now + PROGRESS
            job.seen()
            self._controls.show_progress(job.fraction, f"{job.label}: {job.text or f'{job.seconds():.1f} s'}")

    def cancel(self) -> None:
        self._worker.cancel()

    def end(self) -> None:
        """The program ends: waits a little for what runs, so that its temporary files go."""
        self._worker.end(AT_END)

    def drop(self) -> None:
        """What runs is not wanted any more, nor what waits for it."""
        self._after = None
        if self._running is not None:
            self._running.dropped = True
            self.cancel()

    def when_free(self, call: Callable[[], None]) -> None:
        """Does it now, or as soon as what runs is over."""
        if self._running is None:
            call()
        else:
            self._after = call
