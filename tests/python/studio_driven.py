"""A studio without a browser: controls set as the page sets them, and the loop run by hand."""

from __future__ import annotations

import time
from collections.abc import Callable

from stiction_view.studio.app import Studio


class Driven:
    """A studio and what it refuses."""

    def __init__(self, studio: Studio):
        self.studio, self.panel = studio, studio.panel
        self.said: list[str] = []
        say = studio.panel.head.say

        def hear(text: str, fault: bool = False) -> None:
            if fault:
                self.said.append(text)
            say(text, fault)

        studio.panel.head.say = hear  # type: ignore[method-assign]

    def until(self, condition: Callable[[], object], seconds: float = 200) -> None:
        end = time.monotonic() + seconds
        while not condition():
            self.studio.step(0.01)
            assert time.monotonic() < end, f"it said {self.said[-3:]}"

    def press(self, name: str, *words: object) -> None:
        """As the page does it, and done at once."""
        self.studio.desk.guarded(lambda: self.studio.handlers.by_name[name](*words))

    def plan(self) -> None:
        before = self.studio.showing.result
        self.press("plan")
        self.until(lambda: self.studio.work.running is None and self.studio.showing.result is not before)
