"""Table 5-1, rows of several contacts: with a force and moment sensor under the base, and what remains if contacts are known."""

from __future__ import annotations

import numpy as np

from . import control_runs
from .control_runs import LAMBDA_MAX
from .report import Result

TITLE = "Table 5-1, several contacts at once: a sensor under the base"
SEEDS = 10
ERROR, PEAK = 2.0, 18.0  # [N] as asked in table 5-1
SCENARIOS = ("two_contacts", "three_contacts")
# Standard deviations: white noise of the sensor; offsets stand for weights that are not as thought, too.
BASE = {"force_noise": 1.0, "moment_noise": 0.1, "force_offset": 0.5, "moment_offset": 0.5}
BETTER = {"force_noise": 0.25, "moment_noise": 0.05, "force_offset": 0.25, "moment_offset": 0.1}
LATE = 0.025  # [s] about the lag of observer, low-pass and tick
DAMPING = {"damping": {"largest": 176, "force_scale": 1.0}}  # what follows from that lag by (C.14)


def run_base(name: str, seeds: int, base: dict[str, float] | None) -> list[control_runs.Run]:
    """Runs of table 5-1, and a sensor under the base."""
    return control_runs.run_seeds(name, "contact_aware", seeds, noisy=True, base=base)


def run(quick: bool) -> Result:
    seeds = 1 if quick else SEEDS
    result = Result(
        f"Runs as of table 5-1: {seeds} of each, with the same noise of torques. The sensor under the base has white noise of {BASE['force_noise']:g} N and {BASE['moment_noise']:g} N·m and offsets of "
        f"{BASE['force_offset']:g} N and {BASE['moment_offset']:g} N·m that change over a radian, the better one {BETTER['force_noise']:g} N, {BETTER['moment_noise']:g} N·m, {BETTER['force_offset']:g} N and {BETTER['moment_offset']:g} N·m. "
        f"The last rows are told the contacts of the simulation, {1e3 * LATE:g} ms late, with the damping that follows from such a lag (C.14).",
        settings={"seeds": seeds, "base": BASE, "better": BETTER, "late_s": LATE},
    )
    for name in SCENARIOS if not quick else SCENARIOS[:1]:
        cases = {"torques": run_base(name, seeds, None), "torques and base": run_base(name, seeds, BASE)}
        if not quick:
            cases["torques and a better base"] = run_base(name, seeds, BETTER)
        cases["contacts known, late"] = control_runs.run_seeds(name, "contact_aware", seeds, changes={"estimator": {"contacts": True, "delay": LATE}, "controller": DAMPING})
        for case, runs in cases.items():
            add_rows(result, f"{name}, {case}", runs, quick)
    return result


def add_rows(result: Result, label: str, runs: list[control_runs.Run], quick: bool) -> None:
    errors = [r["bound_error"] for r in runs]
    p95 = max(r["bound_p95"] for r in runs)
    above, settled = sum(r["above_ticks"] for r in runs), sum(r["settled_ticks"] for r in runs)
    makes = np.mean([r["contacts_made"] for r in runs])
    note = f"mean of runs {np.mean(errors):.2f} N; {makes:.0f} contacts made in a run; {above} of {settled} ticks above 1.2 λ_max = {1.2 * LAMBDA_MAX:g} N"
    result.add(f"{label}: mean | ‖f‖ − λ_max |, worst run", f"≤ {ERROR:g} N", f"{max(errors):.2f} N", None if quick else max(errors) <= ERROR, note)
    result.add(f"{label}: 95th percentile of ‖f‖, worst run", f"≤ {PEAK:g} N", f"{p95:.2f} N", None if quick and p95 > PEAK else p95 <= PEAK)
