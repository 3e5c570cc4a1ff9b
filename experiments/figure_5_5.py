"""Figure 5-5: contact force of the mug placement task."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from . import control_runs
from .control_runs import LAMBDA_MAX, LAWS, THRESHOLD, add_bounds, draw_range, series
from .report import Result

TITLE = "Figure 5-5: mug placement, contact force"
SEEDS = 10
PEAK = 18.0  # of the 95th percentile [N]
SHOWN_FORCE = 50.0  # [N]
ERROR = 2.0  # [N] in the mean


def run(quick: bool) -> Result:
    seeds = 2 if quick else SEEDS
    result = Result(
        "The tool goes down by 0.22 m past the edge of a table, which the last links touch, waits, and comes back in 10 s (`scenarios/mug_placement.yaml`; table, "
        f"posture and friction are ours). {seeds} runs with other joints at the start (2 mrad, standard deviation) and other friction (0.2 to 0.4); contacts are those of the "
        "simulation. The first picture has the norm of the largest force in all runs, the second the components of this force on the robot in one run of the scenario as it is; z is up. Numbers are those of all runs.",
        settings={"scenario": "mug_placement", "seeds": seeds},
    )
    runs = {law: control_runs.run_seeds("mug_placement", law, seeds) for law in LAWS if law != "null_space"}
    ours, free = runs["contact_aware"], runs["unconstrained"]
    error, p95 = max(r["bound_error"] for r in ours), max(r["bound_p95"] for r in ours)
    result.add("contact-aware: deviation from λ_max, mean over a run, worst run", "close to λ_max", f"{error:.2f} N", error < ERROR)
    result.add("contact-aware: 95th percentile of the settled force, worst run", "close to λ_max", f"{p95:.1f} N", p95 < PEAK)
    mean = np.mean([r["mean_force"] for r in free])
    result.add("unconstrained: mean settled force", f"above λ_max = {LAMBDA_MAX:g} N", f"{mean:.1f} N", mean > 2 * LAMBDA_MAX, "at least twice λ_max")
    for law, each in runs.items():
        peaks = [r["peak_force"] for r in each]
        result.add(f"{LAWS[law]}: largest force, impact included", "shown only", f"{min(peaks):.1f} to {max(peaks):.1f} N", None, "an impact is shorter than a tick: chance says where in it the sample lies")
    times = [r["tick_p99_s"] for r in ours]
    result.add("99th percentile of a tick", "200 Hz", f"{1e6 * np.median(times):.1f} µs, median of runs", np.median(times) < 5e-3)

    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    for law in ("unconstrained", "contact_aware"):
        forces = np.array([r.columns["force"] for r in runs[law]])
        time = runs[law][0].columns["time"]
        draw_range(axes, law, time, forces)
    add_bounds(axes)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("contact force [N]")
    axes.legend()
    result.draw("force", figure, "Mean and range of the runs. Dashed: force from which a contact counts, and λ_max.")
    add_components(result)
    result.data["force"] = series({law: each[0] for law, each in runs.items()}, "force")
    return result


def largest(forces: list[st.PairForce]) -> np.ndarray:
    """On the robot [N]; zero without contact."""
    return max((np.asarray(force.force_W) for force in forces), key=np.linalg.norm, default=np.zeros(3))


def add_components(result: Result) -> None:
    """x, y, z and the norm, as in the thesis: above the baseline, below the contact-aware law."""
    figure, axes = plt.subplots(2, 1, figsize=(6.4, 4.2), sharex=True)
    for ax, law in zip(axes, (st.Law.Unconstrained, st.Law.ContactAware)):
        run = st.control("mug_placement", law=law)
        force = np.array([largest(at) for at in run.forces])
        norm = np.linalg.norm(force, axis=1)
        name = LAWS["unconstrained" if law == st.Law.Unconstrained else "contact_aware"]
        agrees = float(np.max(np.abs(norm - run.largest_force)))
        result.add(f"{name}: norm of x, y, z against the largest force", "–", f"within {agrees:.1e} N", agrees < 1e-9)
        touching = norm > THRESHOLD
        ours = ", ".join(f"{axis} {value:.1f}" for axis, value in zip("xyz", force[touching].mean(axis=0)))
        result.add(f"{name}: mean force above {THRESHOLD:g} N [N]", "shown only", f"{ours}, norm {norm[touching].mean():.1f}")
        for values, label in zip((*force.T, norm), ("x", "y", "z", "norm")):
            ax.plot(run.times[::4], np.clip(values[::4], -SHOWN_FORCE, SHOWN_FORCE), lw=0.9, color="k" if label == "norm" else None, label=label)
        add_bounds(ax)
        ax.set_title(name, fontsize=8, loc="left")
        ax.set_ylabel("force [N]")
        result.data[f"components_{name}"] = {"time_s": run.times} | {f"{axis}_N": values for axis, values in zip("xyz", force.T)}
    axes[0].legend(fontsize=7, ncol=4)
    axes[1].set_xlabel("time [s]")
    result.draw("components", figure, f"Components and norm of the largest force on the robot, one run; impacts are cut at {SHOWN_FORCE:g} N.")
