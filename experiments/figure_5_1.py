"""Figure 5-1: a reference that goes through what is in the way, with the forces of every law, and of every bound."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import control_runs
from .control_runs import COLOURS, LAMBDA_MAX, LAWS, add_bounds, series
from .report import Result, number

TITLE = "Figure 5-1: what the reference would crush, and forces that follow their bound"
BOUNDS = (8, 10, 15, 20, 30)  # λ_max [N]
ERROR = 2.0  # [N] in the mean
SLOPE = 0.1


def run_laws(result: Result) -> None:
    runs = {law: control_runs.run("box_in_the_way", law) for law in LAWS}
    for law, name in LAWS.items():
        r = runs[law]
        note = f"at any time {r['peak_force']:.1f} N, rms error of the tool in contact {1e3 * r['rms_error_contact']:.1f} mm"
        result.add(f"{name}: settled force, largest", "shown only", f"{r['settled_peak']:.1f} N", None, note)
    ours, free = runs["contact_aware"], runs["unconstrained"]
    holds = ours["settled_peak"] < 1.2 * LAMBDA_MAX < free["settled_peak"]
    result.add(f"settled force within 1.2 λ_max = {1.2 * LAMBDA_MAX:g} N", "contact-aware only", "contact-aware" if holds else "otherwise", holds)
    result.add("largest force at any time, contact-aware over unconstrained", "–", number(ours["peak_force"] / free["peak_force"]), ours["peak_force"] <= free["peak_force"] * (1 + 1e-9))  # the same impact, but for rounding

    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    for law, name in reversed(LAWS.items()):
        axes.plot(runs[law].columns["time"], runs[law].columns["force"], color=COLOURS[law], lw=1, label=name)
    add_bounds(axes)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("contact force [N]")
    axes.legend()
    result.draw("laws", figure, "Largest contact force while the tool is led 45 mm into a box. Dashed: force from which a contact counts, and λ_max.")
    result.data["laws"] = series(runs, "force", "speed", "error")


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
    result = Result(
        "The thesis shows an egg that its controller leaves whole and the reference would crush. Here an iiwa of balls with the stiffness of section 5.6 "
        "follows a straight line of the tool that ends 45 mm inside a box (`scenarios/box_in_the_way.yaml`, μ = 0.3), in MuJoCo with joint impedance control at "
        "5 kHz and commands at 200 Hz. Forces are called settled 0.3 s after a contact is made. Contacts are those of the simulation, without noise.",
        settings={"scenario": "box_in_the_way", "bounds_N": BOUNDS},
    )
    run_laws(result)
    sweep_bounds(result, BOUNDS[::2] if quick else BOUNDS)
    return result
