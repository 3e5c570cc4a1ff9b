"""Table 5-1, acceptance of contact-aware control: what its forces, errors and speeds have to keep to, with contacts known from noisy torques."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import control_runs
from .control_runs import LAMBDA_MAX, MASSES, NOISE, OFFSETS, START_SPREAD, Run, add_bounds, draw_range, series
from .figure_5_6 import rms
from .figure_5_7 import fall_time
from .report import Result

TITLE = "Table 5-1: acceptance of contact-aware control"
SEEDS = 10
SCENARIOS = ("box_in_the_way", "mug_placement", "mug_moving", "egg_under_tray", "plate", "push_along_arm", "two_contacts", "three_contacts")
BOUNDS = (8, 10, 15, 20, 30)  # λ_max [N]
SWEPT = "mug_moving"  # one ball on a table: what torques tell is the force of one pair
SETTLE = 0.3  # [s]
CHATTER = ("box_in_the_way", "mug_placement")
SEPARATION = (8.5, 12.0)  # of mug_moving: its tool passes the edge [s]
FREE = 1.0  # [s] at the start, without contact


def largest(values: list[float]) -> str:
    return f"{max(values):.2f} N, of {len(values)} runs"


def add_steady(result: Result, ours: dict[str, list[Run]], free: dict[str, list[Run]]) -> None:
    """1: settled forces where the reference asks for more."""
    for name, runs in ours.items():
        error, p95 = [r["bound_error"] for r in runs], [r["bound_p95"] for r in runs]
        result.add(f"1  {name}: mean | ‖f‖ − λ_max |, worst run", "≤ 2 N", largest(error), max(error) <= 2)
        result.add(f"1  {name}: 95th percentile of ‖f‖, worst run", "≤ 18 N", largest(p95), max(p95) <= 18)
        above, settled = sum(r["above_ticks"] for r in runs), sum(r["settled_ticks"] for r in runs)
        rise = max(runs, key=lambda r: r["peak_rise"])
        note = f"{above} of {settled} ticks above 1.2 λ_max; largest rise in a tick {rise['peak_rise']:.1f} N, {abs(rise['commanded_rise']):.1f} N of it by the command"
        result.add(f"1  {name}: settled force in a single tick, largest of a run, worst run", "–", f"{max(r['settled_peak'] for r in runs):.1f} N", None, note)
        tracking = [r["settled_peak"] for r in free[name]]
        result.add(f"1  {name}: settled force of tracking alone, largest of a run, least run", "> 2 λ_max", f"{min(tracking):.1f} N", min(tracking) > 2 * LAMBDA_MAX)


def at_bound(r: Run) -> float:
    """Mean force over the ticks in which it is predicted at its bound, from a settling time after the first of them on [N]."""
    time, bounded = r.columns["time"], r.columns["bounded"] > 0
    return float(r.columns["force"][bounded & (r.columns["force"] > 0) & (time > time[np.argmax(bounded)] + SETTLE)].mean())


def add_sweep(result: Result, bounds: tuple[int, ...], seeds: int) -> None:
    """2: forces follow their bound."""
    means = np.array([[at_bound(r) for r in control_runs.run_seeds(SWEPT, "contact_aware", seeds, noisy=True, lambda_max=b)] for b in bounds])
    slope = float(np.polyfit(bounds, means.mean(axis=1), 1)[0])
    note = f"{SWEPT}, λ_max = {bounds[0]} … {bounds[-1]} N, {seeds} runs each: {', '.join(f'{m:.1f}' for m in means.mean(axis=1))} N"
    result.add("2  slope in λ_max of the mean force where the reference asks for more", "1 ± 0.1", f"{slope:.3f}", abs(slope - 1) <= 0.1, note)


def add_impact(result: Result, ours: dict[str, list[Run]], free: dict[str, list[Run]]) -> None:
    """3: an impact is over before a tick; what the law does is to be no worse than tracking."""
    for name, runs in ours.items():
        mine, other = np.mean([r["peak_force"] for r in runs]), np.mean([r["peak_force"] for r in free[name]])
        result.add(f"3  {name}: largest force at any time, mean of runs", "not above tracking alone", f"{mine:.1f} against {other:.1f} N", mine <= other)


def add_errors(result: Result, ours: list[Run], free: list[Run]) -> None:
    """4: mug placement, over the ticks in which both laws touch; before the first contact; at the end."""
    for column, unit in (("error", "mm"), ("angle_error", "mrad")):
        ratios = []
        for a, b in zip(ours, free, strict=True):
            touched = (a.columns["force"] > 0) & (b.columns["force"] > 0)
            ratios.append(rms(a.columns[column][touched]) / rms(b.columns[column][touched]))
        kind = "position" if column == "error" else "orientation"
        result.add(f"4  {kind} error in contact over that of tracking alone, worst run", "< 1", f"{max(ratios):.2f}", max(ratios) < 1)
        before = [abs(rms(a.columns[column][a.columns["time"] < FREE]) - rms(b.columns[column][b.columns["time"] < FREE])) for a, b in zip(ours, free, strict=True)]
        end = [1e3 * r.columns[column][-1] for r in ours]
        moving = [1e3 * r.columns[column][r.columns["time"] < FREE].max() for r in ours]
        result.add(f"4  {kind} error before contact: difference between the laws", "none", f"{1e3 * max(before):.2g} {unit}", max(before) < 1e-3 * max(moving))
        result.add(f"4  {kind} error at the end", "as before contact", f"{max(end):.2f} {unit}", max(end) <= max(moving), f"in free motion up to {max(moving):.2f} {unit}")


def spike(r: Run, window: tuple[float, float]) -> float:
    """Largest ‖q̇‖ in the window above the largest after it, when the arm follows its reference again [rad/s]."""
    time, speed = r.columns["time"], r.columns["speed"]
    return float(speed[(time >= window[0]) & (time <= window[1])].max() - speed[time > window[1]].max())


def add_separation(result: Result, ours: list[Run], equality: list[Run]) -> None:
    """5: over the edge of a table."""
    mine, other = np.mean([spike(r, SEPARATION) for r in ours]), np.mean([spike(r, SEPARATION) for r in equality])
    result.add("5  ‖q̇‖ at separation above that of the reference, null space over contact-aware", "≥ 2", f"{other / mine:.2f}", other >= 2 * mine, f"{other:.3f} and {mine:.3f} rad/s, means of runs")
    falls = [[1e3 * fall_time(r) for r in runs] for runs in (ours, equality)]
    result.add("5  time in which the force falls from 0.9 to 0.1 λ_max, contact-aware against null space", "longer", f"{np.mean(falls[0]):.0f} against {np.mean(falls[1]):.0f} ms", np.mean(falls[0]) > np.mean(falls[1]))
    rates = [np.mean([r["peak_force_rate"] for r in runs]) for runs in (ours, equality)]
    result.add("5  largest fall of a settled force in a tick, contact-aware and null space", "smaller", f"{rates[0]:.0f} and {rates[1]:.0f} N/s", None, "not reached: both hop while they slide, and a hop is λ_max in a tick of 5 ms, 3000 N/s")


def add_chatter(result: Result, ours: dict[str, list[Run]], names: tuple[str, ...], seeds: int) -> None:
    """6: contacts made, and what damping and cost do to them."""
    for name in names:
        made = [r["contacts_made"] for r in ours[name]]
        result.add(f"6  {name}: contacts made in a run", "few", f"{np.mean(made):.1f} ({min(made)} to {max(made)})")
        same = control_runs.run_seeds(name, "contact_aware", seeds)
        for what, controller in (("w_max = 0", {"damping": {"largest": 0}}), ("the cost of (5.22)", {"cost": "equilibrium"})):
            runs = control_runs.run_seeds(name, "contact_aware", seeds, changes={"controller": controller})
            result.add(
                f"6  {name}: contacts made with {what}, contacts as simulated",
                "more",
                f"{np.mean([r['contacts_made'] for r in runs]):.1f} against {np.mean([r['contacts_made'] for r in same]):.1f}",
                None,
                f"largest settled force {max(r['settled_peak'] for r in runs):.1f} against {max(r['settled_peak'] for r in same):.1f} N",
            )


def add_timing(result: Result, ours: dict[str, list[Run]], judged: bool) -> None:
    """7: processor time on the machine that made this page."""
    tick = float(np.min([r["tick_p99_s"] for runs in ours.values() for r in runs]))
    sense = float(np.max([np.min([r["sense_p99_s"] for r in runs]) for runs in ours.values()]))
    result.add("7  99th percentile of a tick of the controller, run least disturbed by others", "≪ 5 ms", f"{1e6 * tick:.0f} µs", tick < 5e-4 if judged else None)
    result.add("7  99th percentile of an estimate of contacts, run least disturbed by others of the scenario with the longest", "≪ 5 ms", f"{1e6 * sense:.0f} µs", sense < 5e-3 if judged else None)


def run(quick: bool) -> Result:
    seeds, names = (1, SCENARIOS[:3]) if quick else (SEEDS, SCENARIOS)
    result = Result(
        f"{seeds} runs of each, contacts known from joint torques alone. They differ in joints at the start ({1e3 * START_SPREAD:g} mrad), friction (0.2 to 0.4), noise "
        f"({NOISE} N·m), offsets of torques that change with posture ({OFFSETS} N·m) and masses ({100 * MASSES:g} %); standard deviations. Forces are settled 0.3 s after their "
        "pair touches. Baselines do not need to know contacts from torques, and are told of those of the simulation.",
        settings={"scenarios": names, "seeds": seeds},
    )
    ours = {name: control_runs.run_seeds(name, "contact_aware", seeds, noisy=True) for name in names}
    free = {name: control_runs.run_seeds(name, "unconstrained", seeds) for name in names}
    equality = control_runs.run_seeds("mug_moving", "null_space", seeds)
    add_steady(result, ours, free)
    add_sweep(result, BOUNDS[::4] if quick else BOUNDS, min(seeds, 3))
    add_impact(result, ours, free)
    add_errors(result, ours["mug_placement"], free["mug_placement"])
    add_separation(result, ours["mug_moving"], equality)
    add_chatter(result, ours, ("mug_placement",) if quick else CHATTER, seeds)
    add_timing(result, ours, judged=not quick)

    figure, axes = plt.subplots(len(names), 1, figsize=(6.4, 1.6 * len(names)))
    for axis, name in zip(axes, names, strict=True):
        draw_range(axis, "contact_aware", ours[name][0].columns["time"], np.array([r.columns["force"] for r in ours[name]]), every=24)
        add_bounds(axis)
        axis.set_ylim(0, 3 * LAMBDA_MAX)
        axis.set_ylabel("force [N]")
        axis.set_title(name, fontsize=9)
    axes[-1].set_xlabel("time [s]")
    result.draw("forces", figure, "Mean and range of the runs. Dashed: force from which a contact counts, and λ_max. Impacts go beyond the picture.")
    result.data["forces"] = series({"contact_aware": ours["box_in_the_way"][0]}, "force", "speed", "error")
    return result
