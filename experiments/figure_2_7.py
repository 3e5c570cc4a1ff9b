"""Figures 2-7 and 2-8: an arm follows a joint path, quasi-static and second-order, at many step sizes."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number
from .systems import load, slope, solved

TITLE = "Figures 2-7 and 2-8: tracking error of an iiwa over the step"
START = np.array([0, 0, 0, -1.70, 0, 1.0, 0])
TRAVEL = 0.5  # of every joint [rad]
DURATION = 10.0  # [s]


def reference(times: np.ndarray) -> np.ndarray:
    """Cubic from START with zero velocity at both ends (7, n)."""
    s = times / DURATION
    return START[:, None] + TRAVEL * (3 * s**2 - 2 * s**3)


def mean_error(times: np.ndarray, q: np.ndarray) -> float:
    """(2.17): time average of ‖q - q_ref‖, q linear between its samples."""
    fine = np.linspace(0, DURATION, 20001)
    moved = np.array([np.interp(fine, times, row) for row in q])
    return float(np.trapezoid(np.linalg.norm(moved - reference(fine), axis=0), fine) / DURATION)


def quasi_static(model: st.Model, h: float, ahead: float = 1.0) -> float:
    """Step k goes to time (k + 1) h with the command of time (k + ahead) h."""
    times = h * np.arange(round(DURATION / h) + 1)
    commands = reference(np.maximum(times - (1 - ahead) * h, 0))
    q = np.empty((7, len(times)))
    q[:, 0] = START
    work = st.StepWorkspace(model)
    for k in range(1, len(times)):
        q[:, k] = solved(st.step(model, q[:, k - 1], commands[:, k], h=h, workspace=work)).q_next
    return mean_error(times, q)


def second_order(model: st.Model, h: float) -> tuple[float, float]:
    """Error [rad], and the largest armature that the explicit springs need at this step [kg m²]."""
    plant = st.Plant(model, timestep=h, time_constant=10 * h, friction_time_constant=100 * h)
    knots = h * np.arange(round(DURATION / h) + 1)
    result = st.simulate(plant, START, knots, reference(knots), record_interval=h)
    if result.status != st.Status.Solved:
        return float("nan"), float(np.max(plant.armature))
    return mean_error(result.times, result.q), float(np.max(plant.armature))


def draw_arm(result: Result, model: st.Model) -> None:
    """Figure 2-7: lines through the origins of the links, from the side and from above."""
    figure, axes = plt.subplots(1, 2, figsize=(5, 2.6))
    for q, label in ((START, "start"), (START + TRAVEL, "end")):
        poses = model.body_poses(q)
        x, y, z = np.array([poses[f"arm/link_{i}"].p for i in range(8)]).T
        axes[0].plot(x, z, "o-", ms=3, label=label)
        axes[1].plot(x, y, "o-", ms=3, label=label)
    for ax, name in zip(axes, ("z", "y"), strict=True):
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_xlabel("x [m]")
        ax.set_ylabel(f"{name} [m]")
    axes[0].legend()
    result.draw("arm", figure, "Figure 2-7: the arm at the start and at the end of the reference, from the side and from above.")


def run(quick: bool) -> Result:
    model = load("iiwa")
    steps = np.array([0.01, 0.1, 0.5] if quick else [1e-4, 1e-3, 3.125e-3, 0.01, 0.03125, 0.1, 0.25, 0.5])
    ours = np.array([quasi_static(model, h) for h in steps])
    held = np.array([quasi_static(model, h, ahead=0.0) for h in steps[steps >= 0.01]])
    theirs, armature = np.array([second_order(model, h) for h in steps]).T

    result = Result(
        f"A gravity-compensated arm on joint springs follows a cubic of {TRAVEL} rad in every joint within {DURATION:g} s. Error: time average of the distance of all seven joints from "
        "the reference (2.17), with motions linear between steps. Second order: MuJoCo with critically damped springs. The thesis has Drake's SAP, whose springs are implicit; "
        "MuJoCo's are explicit, and `Plant` adds armature K h² to the motors so that large steps stay stable, which is what drags at h ≥ 0.1 s.",
        settings={"h": steps.tolist(), "duration": DURATION, "damping_ratio": 1.0},
    )
    # At the smallest steps what is left is the tolerance of the step itself.
    result.add("quasi-static: error grows with h", "yes", " → ".join(number(e) for e in ours) + " rad", bool(np.all(np.diff(ours) > -1e-6)))
    result.add("quasi-static: error at h = 0.5 s", "small", f"{1e3 * ours[-1]:.2f} mrad", ours[-1] < 0.01)
    result.add(
        "quasi-static against second order",
        "slightly better, more so as h gets smaller",
        f"better at {int(np.sum(ours < theirs))} of {len(steps)} steps",
        bool(np.all(ours < theirs)),
    )
    result.add("second order at the smallest h", "–", f"{1e3 * theirs[0]:.2f} mrad: the lag of its damping", None)
    result.add(
        "second order at h = 0.5 s",
        "small, stable",
        f"{number(theirs[-1])} rad, with {number(armature[-1])} kg m² of armature",
        None,
        "explicit springs: not the SAP of the thesis",
    )
    result.add(
        "quasi-static if commands are held instead of reached: exponent of the error in h",
        "–",
        f"{slope(steps[steps >= 0.01], held):.3f}",
        None,
        f"{1e3 * held[-1]:.1f} mrad at 0.5 s: one step of lag",
    )

    draw_arm(result, model)
    figure, axes = plt.subplots(figsize=(4.4, 2.8))
    axes.loglog(steps, ours, "o-", ms=4, label="quasi-static")
    axes.loglog(steps[steps >= 0.01], held, "o:", ms=3, color="C0", label="quasi-static, command held")
    axes.loglog(steps, theirs, "s-", ms=4, color="C1", label="second order (MuJoCo)")
    axes.set_xlabel("step h [s]")
    axes.set_ylabel("mean tracking error [rad]")
    axes.legend(fontsize=7)
    result.draw("error", figure, "Figure 2-8: mean tracking error over the step size.")
    result.data["error"] = {"h_s": steps, "quasi_static_rad": ours, "second_order_rad": theirs, "armature_kg_m2": armature}
    return result
