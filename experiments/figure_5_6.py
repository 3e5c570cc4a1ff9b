"""Figure 5-6: tracking errors of the mug placement task."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import control_runs
from .control_runs import draw_range, series
from .report import Result

TITLE = "Figure 5-6: mug placement, tracking errors"
SEEDS = 10


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def run(quick: bool) -> Result:
    seeds = 2 if quick else SEEDS
    result = Result(
        f"Runs as of figure 5-5, {seeds} of each law. Errors while the arm is in contact under both laws, so that both are judged over the same ticks. "
        "The thesis has significantly smaller errors with the contact-aware controller, by pictures.",
        settings={"scenario": "mug_placement", "seeds": seeds},
    )
    runs = {law: control_runs.run_seeds("mug_placement", law, seeds) for law in ("contact_aware", "unconstrained")}
    for column, unit, factor, name in (("error", "mm", 1e3, "position"), ("angle_error", "mrad", 1e3, "orientation")):
        ratios, values = [], {law: [] for law in runs}
        for ours, free in zip(*runs.values(), strict=True):
            touched = (ours.columns["force"] > 0) & (free.columns["force"] > 0)
            for law, r in zip(runs, (ours, free), strict=True):
                values[law].append(factor * rms(r.columns[column][touched]))
            ratios.append(values["contact_aware"][-1] / values["unconstrained"][-1])
        mean = {law: np.mean(v) for law, v in values.items()}
        text = f"{mean['contact_aware']:.1f} against {mean['unconstrained']:.1f} {unit}"
        verdict = max(ratios) < 1
        note = f"ratio {min(ratios):.2f} to {max(ratios):.2f} over the runs"
        result.add(f"{name} error in contact, contact-aware against unconstrained", "smaller", text, True if verdict else None, note if verdict else f"{note}: not reproduced")
    figure, axes = plt.subplots(1, 2, figsize=(6.4, 2.6))
    for law, each in runs.items():
        for axis, column in zip(axes, ("error", "angle_error"), strict=True):
            draw_range(axis, law, each[0].columns["time"], 1e3 * np.array([r.columns[column] for r in each]))
            axis.set_xlabel("time [s]")
    axes[0].set_ylabel("position error [mm]")
    axes[1].set_ylabel("orientation error [mrad]")
    axes[0].legend()
    result.draw("errors", figure, "Errors of the tool, mean and range of the runs.")
    result.data["errors"] = series({law: each[0] for law, each in runs.items()}, "error", "angle_error")
    return result
