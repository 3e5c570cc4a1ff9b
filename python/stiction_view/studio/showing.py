"""What came out: plans, alone, side by side or beside their run, and scenarios, played and in figures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .panel import BLUE, GREEN, NOTHING, ORANGE, RED, FigureControls, PlaybackControls, set_choices
from .player import Player
from .results import Result, Run
from .scenario import Played
from .stage import Shown, Stage

MAX_RESULTS = 8
IN_MUJOCO = "the same in MuJoCo"


def words_of_run(run: Run, knot: int) -> str:
    k = min(knot, len(run.times) - 1)
    body = run.planned.bodies[run.planned.goal_body].moving
    off = np.linalg.norm(run.planned.poses[k, body, :3] - run.simulated.poses[k, body, :3])
    return f"t = {run.times[k]:.2f} s, the object is {1e3 * off:.1f} mm from where it is planned"


class Showing:
    """Keeps the last results. `changed` is called when another one is shown, or more is known of it."""

    def __init__(self, controls: PlaybackControls, figures: FigureControls, stage: Stage, changed: Callable[[], None]):
        self._controls, self._figures, self._stage, self._changed = controls, figures, stage, changed
        self._player = Player(controls, stage)
        self._results: list[Result] = []
        self._result: Result | None = None
        self._played: Played | None = None

    @property
    def results(self) -> tuple[Result, ...]:
        return tuple(self._results)

    @property
    def result(self) -> Result | None:
        """That was shown last."""
        return self._result

    @property
    def played(self) -> Played | None:
        """A scenario in its place."""
        return self._played

    @property
    def knot(self) -> int:
        """That is shown; -1: none yet."""
        return self._player.knot

    def tick(self, now: float) -> None:
        self._player.tick(now)

    def rest(self) -> None:
        """A task is posed in place of what was shown."""
        self._player.rest()

    def close_scenario(self) -> None:
        self._played = None
        self._controls.live.visible = False

    # ---- which one ----

    def add(self, result: Result) -> None:
        """Shows a new one."""
        self._results = [*self._results, result][-MAX_RESULTS:]
        self._result = result
        self.list_results()
        set_choices(self._controls.which, self._controls.which.options, result.label)
        self.show()

    def add_run(self, result: Result, run: Run) -> None:
        """Of a result; it is seen beside its plan if that is shown."""
        result.run = run
        self.list_results()
        if self._result is result:
            set_choices(self._controls.beside, self._controls.beside.options, IN_MUJOCO)
            self.show()

    def add_verdict(self, result: Result, verdict: str) -> None:
        result.verdict = verdict
        self._say_result()

    def list_results(self) -> None:
        """Choices of what is shown, and beside what."""
        labels, result, controls = [r.label for r in self._results], self._result, self._controls
        set_choices(controls.which, labels or [NOTHING], result.label if result else (labels or [NOTHING])[-1])
        beside = [NOTHING, *([IN_MUJOCO] if result and result.run else []), *(x for x in labels if not result or x != result.label)]
        set_choices(controls.beside, beside, controls.beside.value if controls.beside.value in beside else NOTHING)

    def choose(self) -> None:
        chosen = next((r for r in self._results if r.label == self._controls.which.value), None)
        if chosen is not None and chosen is not self._result:
            self._result = chosen
            self.list_results()
            self.show()

    def choose_beside(self) -> None:
        if self._stage.shown and self._result is not None and self._played is None:
            self.show()

    # ---- what is seen ----

    def _motions(self, result: Result) -> tuple[list[Shown], Run | None]:
        """The plan that is shown and what is beside it."""
        beside = self._controls.beside.value
        if beside == IN_MUJOCO and result.run is not None:
            return [Shown(result.run.planned, result.pictures, "planned"), Shown(result.run.simulated, result.pictures, "in MuJoCo")], result.run
        first = Shown(result.drawn, result.pictures, result.label)
        other = next((r for r in self._results if r.label == beside), None)
        return [first, *([Shown(other.drawn, other.pictures, other.label)] if other is not None else [])], None

    def show(self) -> None:
        """Raises ValueError: there is no result."""
        result = self._result
        if result is None:
            raise ValueError("result: nothing is planned yet")
        motions, run = self._motions(result)
        self.close_scenario()
        series = result.series
        if run is None:
            self._player.start(motions, lambda knot: series.line(min(knot, len(series.force) - 1)))
        else:
            self._player.start(motions, lambda knot: words_of_run(run, knot))
        self._say_result()
        charts = [
            ("effort used", "%", 100 * series.effort_share(), BLUE),
            ("max_force used", "%", 100 * series.press_share(), RED),
            ("friction used", "%", 100 * series.friction_use, ORANGE),
            ("largest contact force", "N", series.force, RED),
            ("smallest gap", "mm", 1e3 * series.gap, GREEN),
        ]
        self._figures.fill_charts(np.arange(len(series.force)), "knot", [c for c in charts if run is None and np.isfinite(c[2]).any()])

    def _say_result(self) -> None:
        if self._result is not None:
            self._figures.words.content = self._result.words()
            self._changed()

    def show_scenario(self, played: Played) -> None:
        """It was carried out."""
        self._played = played
        self._controls.live.visible = played.scenario is not None
        self._player.start([Shown(played.drawn, played.pictures, played.name, with_goal=False)], lambda knot: played.lines[min(knot, len(played.lines) - 1)])
        self._figures.words.content = played.words
        colors = (RED, BLUE, GREEN)
        self._figures.fill_charts(played.times, "t [s]", [(t, unit, v, colors[k % 3]) for k, (t, (unit, v)) in enumerate(played.charts.items())])
