"""Figure 5-1: a reference that goes through what is in the way, with the forces of every law, and of every bound."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import control_runs
from .control_runs import LAMBDA_MAX, LAWS, add_bounds, draw_range, series, span
from .report import Result, number

TITLE = "Figure 5-1: what the reference would crush, and forces that follow their bound"
SEEDS = 10
BOUNDS = (8, 10, 15, 20, 30)  # λ_max [N]
ERROR = 2.0  # [N] in the mean
SLOPE = 0.1


def run_laws(result: Result, seeds: int) -> None:
    runs = {law: control_runs.run_seeds("egg_under_tray", law, seeds) for law in LAWS}
    settled = {law: [r["settled_peak"] for r in each] for law, each in runs.items()}
    peaks = {law: [r["peak_force"] for r in each] for law, each in runs.items()}
    for law, name in LAWS.items():
        error = np.mean([1e3 * r["rms_error_contact"] for r in runs[law]])
        note = f"at any time {span(peaks[law], 1, ' N')}, rms error of the tool in contact {error:.1f} mm"
        result.add(f"{name}: settled force, largest of a run", "shown only", span(settled[law], 1, ' N'), None, note)
    holds = max(settled["contact_aware"]) < 1.2 * LAMBDA_MAX < min(settled["unconstrained"])
    result.add(f"settled force within 1.2 λ_max = {1.2 * LAMBDA_MAX:g} N, every run", "contact-aware only", "contact-aware" if holds else "otherwise", holds)
    ratios = [a / b for a, b in zip(peaks["contact_aware"], peaks["unconstrained"], strict=True)]
    same = 1 + 1e-9  # the same impact, but for rounding
    result.add("largest force at any time, contact-aware over unconstrained, worst run", "–", number(max(ratios)), max(ratios) <= same)

    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    for law in reversed(LAWS):
        draw_range(axes, law, runs[law][0].columns["time"], np.array([r.columns["force"] for r in runs[law]]))
    add_bounds(axes)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("contact force [N]")
    axes.legend()
    result.draw("laws", figure, "Force on a tray that is put down on an egg, mean and range of the runs. Dashed: force from which a contact counts, and λ_max.")
    result.data["laws"] = series({law: each[0] for law, each in runs.items()}, "force", "speed", "error")


def sweep_bounds(result: Result, bounds: tuple[int, ...]) -> None:
    runs = [control_runs.run("box_in_the_way", lambda_max=bound) for bound in bounds]
    means = np.array([r["mean_force"] for r in runs])
    slope = float(np.polyfit(bounds, means, 1)[0])
    result.add("slope of the mean settled force in λ_max", "1: “close to λ_max”", f"{slope:.3f}", abs(slope - 1) < SLOPE, f"λ_max = {bounds[0]} … {bounds[-1]} N")
    worst = max(r["bound_error"] for r in runs)
    result.add("mean deviation from λ_max where the reference asks for more, largest", "–", f"{worst:.2f} N", worst < ERROR)
    figure, axes = plt.subplots(figsize=(3.4, 2.8))
    axes.plot([0, max(bounds)], [0, max(bounds)], "-", color="0.6", label="λ_max")
    axes.plot(bounds, means, "o", ms=4, label="mean, settled")
    axes.plot(bounds, [r["settled_peak"] for r in runs], "^", ms=4, color="C1", label="largest, settled")
    axes.set_xlabel("λ_max [N]")
    axes.set_ylabel("contact force [N]")
    axes.legend()
    result.draw("bounds", figure, "Forces settle at their bound.")
    result.data["bounds"] = {"lambda_max_N": np.array(bounds, dtype=float), "mean_N": means, "largest_N": np.array([r["settled_peak"] for r in runs])}


def run(quick: bool) -> Result:
    seeds = 2 if quick else SEEDS
    result = Result(
        "The thesis shows an egg that its controller leaves whole and the reference would crush. Here a tray is put down on an egg (`scenarios/egg_under_tray.yaml`) by an "
        "iiwa of balls with the stiffness of section 5.6, in MuJoCo with joint impedance control at 5 kHz and commands at 200 Hz. "
        f"{seeds} runs of each law with other joints at the start (2 mrad) and other friction (0.2 to 0.4). Forces are called settled 0.3 s after a contact is made. Contacts are those of the simulation. "
        "Bounds: the tool is led 45 mm into a box (`scenarios/box_in_the_way.yaml`).",
        settings={"scenarios": ("egg_under_tray", "box_in_the_way"), "seeds": seeds, "bounds_N": BOUNDS},
    )
    run_laws(result, seeds)
    sweep_bounds(result, BOUNDS[::2] if quick else BOUNDS)
    return result
