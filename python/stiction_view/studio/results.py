"""What came out: plans and runs, with all that is drawn and written of them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np
import stiction as st

from ..plan import Plan, read_plan_object
from .picture import Pictures
from .series import Series, make_series
from .texts import plain

MAX_SAMPLES = 600  # of a run that are drawn

ENDED = {st.Status.Solved: "solved", st.Status.Cancelled: "cancelled, best path so far", st.Status.MaxIterations: "not solved in time, best path so far"}


@dataclass
class Run:
    """A plan carried out open loop in MuJoCo: as planned and as simulated, sample by sample."""

    times: np.ndarray  # [s]
    planned: Plan
    simulated: Plan
    words: str


@dataclass
class Result:
    """A plan with its figures."""

    number: int
    plan: st.Plan
    drawn: Plan
    series: Series
    command: str
    task_file: str | None
    reason: str
    seconds: float
    pictures: Pictures
    files: dict[str, bytes] = field(default_factory=dict)  # that its task reads beside itself
    run: Run | None = None
    verdict: str = ""
    notes: list[str] = field(default_factory=list)

    @property
    def label(self) -> str:
        """As it stands in a list."""
        error = self.plan.error
        return f"{self.number}: {self.plan.task.name}, seed {self.plan.seed}, {1e3 * error.position:.1f} mm"

    def headline(self) -> str:
        """How it ended, in markdown."""
        plan, error, goal = self.plan, self.plan.error, self.plan.task.goal
        off = f"{1e3 * error.position:.1f} mm of {1e3 * goal.tol_position:.3g} off the goal, {error.angle:.3f} rad of {goal.tol_angle:.3g}"
        return f"**{ENDED.get(plan.status, plan.status.name)}** in {self.seconds:.1f} s, {off}" + (f"  \n{plain(self.reason)}" if self.reason else "")

    def words(self) -> str:
        """Its figures, in markdown."""
        kinds = self.drawn.segment_kinds
        rows = [
            self.headline(),
            f"{kinds.count('contact')} pushes, {kinds.count('regrasp')} regrasps, {len(self.drawn.poses)} knots",
        ]
        share = self.series.effort_share()
        if np.isfinite(share).any():
            rows.append(f"motors give up to {100 * np.nanmax(share):.1f} % of their efforts")
        if self.series.fragile:
            rows.append(f"max_force used up to {100 * self.series.press_share().max():.1f} %")
        if np.isfinite(self.series.force).any():
            rows.append(f"contacts up to {np.nanmax(self.series.force):.2f} N")
        return "  \n".join([*rows, *([self.verdict] if self.verdict else []), *([self.run.words] if self.run else [])])


def make_result(number: int, plan: st.Plan, pictures: Pictures, command: str, task_file: str | None, reason: str, seconds: float, files: dict[str, bytes] | None = None) -> Result:
    """Raises ValueError where there is nothing to draw."""
    data = json.loads(plan.to_text())
    return Result(number, plan, pictures.with_bare_links(read_plan_object(data), plan.q[1:]), make_series(data), command, task_file, reason, seconds, pictures, files or {})


def make_run(result: Result, timeout_s: float) -> Run:
    """Runs the plan in MuJoCo. Raises ValueError: no sample came out."""
    plan = result.plan
    out = st.transfer(plan, alone=False, timeout_s=timeout_s)
    if len(out.times) == 0:
        raise ValueError(f"the simulation gave nothing ({out.message or out.status.name})")
    chosen = np.unique(np.linspace(0, len(out.times) - 1, min(len(out.times), MAX_SAMPLES)).round().astype(int))
    goal, pictures = plan.task.goal, result.pictures
    planned, simulated = (pictures.plan(q[chosen], goal.X_WG, goal.object, plan.task.name) for q in (out.q_plan, out.q))
    end = "reaches the goal" if out.reached else "drops the object" if out.dropped is not None else "misses the goal"
    words = f"**in MuJoCo**, open loop, it {end}: {1e3 * out.error.position:.1f} mm, {out.error.angle:.3f} rad off after {out.duration_s:.1f} s"
    if out.status != st.Status.Solved:
        words += f" ({plain(out.message or 'time used up')})"
    return Run(out.times[chosen], planned, simulated, words)


def check(result: Result) -> str:
    """The verdict of the checker, which shares nothing with the planner."""
    report = st.check_plan(result.plan)
    if report.pass_:
        return "**check** passed"
    worst = [
        "the search ended without a solution" if i.name == "status" else f"{i.name} {i.value:.3g} of {i.limit:.3g} {i.unit}".rstrip()
        for i in report.items
        if not i.pass_ and i.limit is not None
    ]
    return "**check** failed: " + plain(", ".join(worst or [report.status.name]))
