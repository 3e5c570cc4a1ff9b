"""Programs that tests start. Each has a process group of its own and a limit, and is ended together with the programs that it has started."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from limits import within

LIMIT = 120.0  # [s]
_ENDING = (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM)


@contextlib.contextmanager
def default_signals() -> Iterator[None]:
    """Programs that are started in this block end at SIGINT and SIGHUP, also where this process ignores these signals.

    A script that is started in the background ignores SIGINT, and one that is started with nohup ignores SIGHUP. A program inherits the
    signals that its parent ignores, but not those that its parent handles. The block therefore handles them, by doing nothing.
    """
    ignored = [number for number in _ENDING if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda *_: None)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


class Child(subprocess.Popen):
    """A running program. As a context it ends the program and all that this has started."""

    def __init__(self, words: Sequence[object], **options: Any):
        """The options are those of Popen; by default stdin is empty, and stdout and stderr are kept as text."""
        kept = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        with default_signals():
            super().__init__([str(word) for word in words], start_new_session=True, **kept | options)

    def line(self, limit: float = LIMIT) -> str:
        """The next line on stdout, empty at its end."""
        assert self.stdout is not None
        with within(limit, f"a line of {self.args!r}"):
            return self.stdout.readline()

    def send_group(self, number: int) -> None:
        """The program and all that it has started get the signal, as a terminal sends it."""
        with contextlib.suppress(ProcessLookupError):  # all have ended
            os.killpg(self.pid, number)

    def stop(self, number: int = signal.SIGINT, limit: float = LIMIT) -> subprocess.CompletedProcess[str]:
        """The program alone gets the signal, unless it has ended; what it says until its end. Raises TimeoutExpired: it does not end."""
        if self.poll() is None:
            self.send_signal(number)
        return self.finish(limit)

    def finish(self, limit: float = LIMIT) -> subprocess.CompletedProcess[str]:
        """Waits for its end. Raises TimeoutExpired: it does not end."""
        try:
            out, err = self.communicate(timeout=limit)
        except BaseException:
            self.kill_group()
            raise
        return subprocess.CompletedProcess(self.args, self.returncode, out, err)

    def kill_group(self) -> None:
        self.send_group(signal.SIGKILL)
        self.wait()

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.kill_group()
        super().__exit__(kind, value, trace)


def run(words: Sequence[object], *, limit: float = LIMIT, input: str | None = None, cwd: Path | str | None = None, **options: Any) -> subprocess.CompletedProcess[str]:
    """Runs a program to its end. Raises TimeoutExpired: it takes longer than the limit [s]; the program has been ended then."""
    if input is not None:
        options["stdin"] = subprocess.PIPE
    with Child(words, cwd=cwd, **options) as child:
        out, err = child.communicate(input, timeout=limit)
    return subprocess.CompletedProcess(child.args, child.returncode, out, err)
