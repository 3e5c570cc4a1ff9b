"""Figures 2-7 and 2-8: an arm follows a joint path, quasi-static and second-order, at many step sizes."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from . import drake_plant
from .report import Result, number
from .systems import SCENES, load, slope, solved

TITLE = "Figures 2-7 and 2-8: tracking error of an iiwa over the step"
START = np.array([0, 0, 0, -1.70, 0, 1.0, 0])
TRAVEL = 0.5  # of every joint [rad]
DURATION = 10.0  # [s]
SAP_DAMPING = np.array([100, 100, 100, 100, 1, 1, 1])  # [N m s/rad]


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
    result = st.simulate(plant, START, knots, reference(knots).T, record_interval=h)
    if result.status != st.Status.Solved:
        return float("nan"), float(np.max(plant.armature))
    return mean_error(result.times, result.q.T), float(np.max(plant.armature))


def implicit_springs(h: float, ahead: float = 1.0) -> float:
    """The same with Drake's SAP, whose springs are implicit, and the damping of the thesis."""
    knots = h * np.arange(round(DURATION / h) + 1)
    plant = drake_plant.DrakePlant(SCENES / "iiwa.yaml", h, SAP_DAMPING)
    motion = plant.simulate(START, knots, reference(knots), record_interval=h, ahead=ahead)
    return mean_error(motion.times, motion.q)


def damping_lag(model: st.Model) -> float:
    """Error of a slow motion: D q̇ = K (q_ref - q), with q̇ = TRAVEL / DURATION on average [rad]."""
    return float(np.linalg.norm(SAP_DAMPING / model.stiffness)) * TRAVEL / DURATION


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
        "the reference (2.17), with motions linear between steps. Second order, twice: Drake's SAP, as in the thesis, with implicit springs and the damping of its "
        f"experiment ({', '.join(f'{d:g}' for d in SAP_DAMPING)} N·m·s/rad); and MuJoCo with critically damped springs, which are explicit: `Plant` adds armature K h² to the motors so that "
        "large steps stay stable, and that is what drags at h ≥ 0.1 s. A step is given the command of its end; dotted curves are given that of its start.",
        settings={"h": steps.tolist(), "duration": DURATION, "damping_ratio": 1.0, "sap_damping": SAP_DAMPING.tolist()},
    )
    # At the smallest steps what is left is the tolerance of the step itself.
    result.add("quasi-static: error grows with h", "yes", " → ".join(number(e) for e in ours) + " rad", bool(np.all(np.diff(ours) > -1e-6)))
    result.add("quasi-static: error at h = 0.5 s", "small", f"{1e3 * ours[-1]:.2f} mrad", ours[-1] < 0.01)
    add_better(result, "MuJoCo", ours, theirs)
    result.add("MuJoCo at the smallest h", "–", f"{1e3 * theirs[0]:.2f} mrad: the lag of its damping", None)
    result.add("MuJoCo at h = 0.5 s", "–", f"{number(theirs[-1])} rad, with {number(armature[-1])} kg m² of armature", None, "explicit springs: not the SAP of the thesis")
    result.add(
        "quasi-static if commands are held instead of reached: exponent of the error in h",
        "–",
        f"{slope(steps[steps >= 0.01], held):.3f}",
        None,
        f"{1e3 * held[-1]:.1f} mrad at 0.5 s: one step of lag",
    )
    result.data["error"] = {"h_s": steps, "quasi_static_rad": ours, "second_order_rad": theirs, "armature_kg_m2": armature}
    if drake_plant.is_available():
        sap = np.array([implicit_springs(h) for h in steps])
        sap_held = np.array([implicit_springs(h, ahead=0.0) for h in steps[steps >= 0.01]])
        result.data["error"] |= {"sap_rad": sap}
        add_sap(result, model, steps, ours, held, sap, sap_held)
    else:
        sap = sap_held = None
        result.add("second order by SAP", "Figure 2-8", "–", None, drake_plant.MISSING)

    draw_arm(result, model)
    draw_errors(result, steps, ours, held, theirs, sap, sap_held)
    return result


def add_better(result: Result, name: str, ours: np.ndarray, theirs: np.ndarray) -> None:
    better = int(np.sum(ours < theirs))
    result.add(f"quasi-static against {name}", "slightly better, more so as h gets smaller", f"better at {better} of {len(ours)} steps", better == len(ours))


def add_sap(result: Result, model: st.Model, steps: np.ndarray, ours: np.ndarray, held: np.ndarray, sap: np.ndarray, sap_held: np.ndarray) -> None:
    add_better(result, "SAP", ours, sap)
    lag = damping_lag(model)
    result.add(
        "SAP: error",
        "small, also at h = 0.5 s",
        " → ".join(number(1e3 * e) for e in sap) + " mrad",
        bool(np.all(np.abs(sap - lag) < 0.01 * lag)),
        f"the lag of its damping at every step: ‖D/K‖ · 0.05 rad/s = {1e3 * lag:.2f} mrad",
    )
    result.add(
        "if commands are held instead of reached: quasi-static against SAP, at h = " + ", ".join(number(h) for h in steps[steps >= 0.01]) + " s",
        "slightly better",
        ", ".join(f"{1e3 * a:.3g} / {1e3 * b:.3g}" for a, b in zip(held, sap_held, strict=True)) + " mrad",
        bool(np.all(held < sap_held)),
        "these grow with h, as the thesis says of both",
    )


def draw_errors(
    result: Result, steps: np.ndarray, ours: np.ndarray, held: np.ndarray, theirs: np.ndarray, sap: np.ndarray | None, sap_held: np.ndarray | None
) -> None:
    figure, axes = plt.subplots(figsize=(4.4, 2.8))
    axes.loglog(steps, ours, "o-", ms=4, label="quasi-static")
    axes.loglog(steps[steps >= 0.01], held, "o:", ms=3, color="C0", label="quasi-static, command held")
    if sap is not None and sap_held is not None:
        axes.loglog(steps, sap, "^-", ms=4, color="C2", label="second order (SAP)")
        axes.loglog(steps[steps >= 0.01], sap_held, "^:", ms=3, color="C2", label="second order (SAP), command held")
    axes.loglog(steps, theirs, "s-", ms=4, color="C1", label="second order (MuJoCo)")
    axes.set_xlabel("step h [s]")
    axes.set_ylabel("mean tracking error [rad]")
    axes.legend(fontsize=6)
    result.draw("error", figure, "Figure 2-8: mean tracking error over the step size.")
