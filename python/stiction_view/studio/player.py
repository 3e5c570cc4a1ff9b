"""Motions on the stage, knot by knot: the slider is followed, and moved while they play."""

from __future__ import annotations

from collections.abc import Callable

from .panel import PlaybackControls
from .stage import Shown, Stage


class Player:
    def __init__(self, controls: PlaybackControls, stage: Stage):
        self._controls, self._stage = controls, stage
        self._words_at: Callable[[int], str] = lambda knot: ""
        self._knot = -1  # that is shown
        self._next = 0.0  # when the next one is due
        self._played = False  # at the last tick

    @property
    def knot(self) -> int:
        """That is shown; -1: none yet."""
        return self._knot

    def start(self, motions: list[Shown], words_at: Callable[[int], str]) -> None:
        """Puts motions on the stage and plays them from their first knot; `words_at` says what there is to say of a knot."""
        self._stage.show(motions)
        self._words_at, self._knot = words_at, -1
        controls = self._controls
        controls.frame.disabled = False
        controls.folder.visible = True
        controls.frame.max = max(1, max(len(m.plan.poses) for m in motions) - 1)
        controls.frame.value = 0
        controls.play.value = True

    def rest(self) -> None:
        """A task is posed in their place."""
        self._controls.frame.disabled = True

    def tick(self, now: float) -> None:
        if not self._stage.shown:
            return
        controls = self._controls
        last = int(controls.frame.max)
        played, self._played = self._played, bool(controls.play.value)
        if self._played and not played and self._knot >= last:  # somebody wants to see it again
            controls.frame.value = 0
        elif self._played and now >= self._next:
            self._next = now + 1 / float(controls.speed.value)
            if self._knot >= last:
                controls.play.value = self._played = False
            elif self._knot == int(controls.frame.value):
                controls.frame.value = self._knot + 1
        knot = min(int(controls.frame.value), last)
        if knot != self._knot:
            self._knot = knot
            self._stage.show_frame(knot)
            controls.line.content = self._words_at(knot)
