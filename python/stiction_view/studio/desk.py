"""What is asked for on the page, done one after the other in one thread."""

from __future__ import annotations

import queue
import traceback
from collections.abc import Callable

import stiction as st

from .uploads import Refused

MISTAKES = (st.InvalidInput, Refused, ValueError, OSError, ImportError)
Say = Callable[[str], None]  # what is wrong


class Desk:
    """Any thread may post; one thread does it. What went wrong is handed to `say`."""

    def __init__(self, say: Say):
        self._events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._say = say

    def post(self, call: Callable[[], None]) -> None:
        self._events.put(call)

    def do_all(self, wait_s: float) -> None:
        """What was posted; if nothing was, waits for it."""
        try:
            self.guarded(self._events.get(timeout=wait_s))
            while True:
                self.guarded(self._events.get_nowait())
        except queue.Empty:
            pass

    def guarded(self, call: Callable[[], None]) -> None:
        """A mistake is said on the page; a fault of ours as well, and where it happened on stderr."""
        try:
            call()
        except MISTAKES as error:
            self._say(str(error))
        except Exception as error:
            self._say(f"a fault of the studio: {type(error).__name__}: {error}")
            traceback.print_exc()
