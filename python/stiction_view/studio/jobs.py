"""Long work beside the page: one job at a time, in a thread of its own, that can be watched and cancelled."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass
class Job:
    """`work(job)` runs until it returns, or soon after `cancelled` is set; then `done(job)` is called, in the same thread.

    Whoever owns the page calls `seen` now and then while it runs, and `ended` when it is over, however it went; a result that is `dropped` is not wanted any more.
    """

    label: str
    work: Callable[[Job], Any]
    done: Callable[[Job], None]
    seen: Callable[[], None] = lambda: None
    ended: Callable[[], None] = lambda: None
    dropped: bool = False
    cancelled: threading.Event = field(default_factory=threading.Event)
    result: Any = None
    error: BaseException | None = None
    fraction: float = 0.0  # of the budget, in [0, 1]
    text: str = ""
    begun: float = field(default_factory=time.monotonic)

    def seconds(self) -> float:
        return time.monotonic() - self.begun

    def watch(self, progress: Any) -> bool:
        """For `on_progress` of the library: notes how far it is; False stops it."""
        self.fraction = float(progress.fraction)
        self.text = f"{progress.elapsed_s:.1f} s, {progress.size} nodes, best {progress.best:.3g} tolerances from the goal"
        return not self.cancelled.is_set()


class Worker:
    """Runs one job; a new one is refused while it runs."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._job: Job | None = None
        self._thread: threading.Thread | None = None

    @property
    def job(self) -> Job | None:
        """That runs now."""
        return self._job

    def start(self, job: Job) -> bool:
        with self._lock:
            if self._job is not None:
                return False
            self._job = job
            self._thread = threading.Thread(target=self._run, args=(job,), name=job.label, daemon=True)
            self._thread.start()
        return True

    def cancel(self) -> None:
        if (job := self._job) is not None:
            job.cancelled.set()

    def end(self, seconds: float) -> None:
        """Cancels what runs, and waits so long at most for its end."""
        self.cancel()
        if (thread := self._thread) is not None:
            thread.join(seconds)

    def _run(self, job: Job) -> None:
        try:
            job.result = job.work(job)
        except BaseException as error:  # shown on the page
            job.error = error
        with self._lock:
            self._job = None
        job.done(job)
