"""Figures 2-3 and 2-4: a robot as a spring, and what goes wrong when its motion is prescribed."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .gripper import FRICTION, RADIUS, START, STIFFNESS, WEIGHT, Ours
from .report import Result
from .systems import load_with_stiffness, solved

TITLE = "Figures 2-3 and 2-4: robots as springs, not as prescribed motions"
H = 0.01


def squeeze(ours: Ours, depth: float) -> np.ndarray:
    """State with both fingers commanded `depth` into the ball."""
    q = START.copy()
    q[3], q[4] = -RADIUS, RADIUS
    return ours.step(q, np.array([0.0, -RADIUS + depth, RADIUS - depth]), H).q


def lift(ours: Ours, depth: float, height: float, increment: float) -> float:
    """How high the ball is after the gripper was commanded up by `height` [m]."""
    q = squeeze(ours, depth)
    for y in np.arange(increment, height + increment / 2, increment):
        q = ours.step(q, np.array([y, -RADIUS + depth, RADIUS - depth]), H).q
    return float(q[1] - RADIUS)


def add_free_body(result: Result, ours: Ours, quick: bool) -> None:
    """Figure 2-3: (2.14) for the left finger."""
    commands = np.linspace(-0.12, -0.09, 13 if quick else 31)
    states = [ours.step(np.array([0, RADIUS, 0, -0.12, 0.12]), np.array([0, u, -u]), H) for u in commands]
    x = np.array([state.q[3] for state in states])
    force = np.array([state.force[0, 0] for state in states])
    away = commands < -RADIUS - 1e-9
    result.add(
        "(a) away from the ball: x_l - u_l", "0", f"{np.max(np.abs(x - commands)[away]):.1e} m", np.max(np.abs(x - commands)[away]) < 1e-6
    )
    balance = float(np.max(np.abs(force - STIFFNESS * (commands - x))))
    result.add("(b) contact force against k (u_l - x_l)", "equal (2.14)", f"{balance:.1e} N", balance < 1e-4)
    penetration = float(np.max(x + RADIUS))
    result.add("penetration, however deep the command", "0", f"{max(penetration, 0):.1e} m", penetration < 1e-6)

    figure, axes = plt.subplots(1, 2, figsize=(6.6, 2.5))
    axes[0].plot(1e3 * commands, 1e3 * commands, color="0.7", label="prescribed motion")
    axes[0].plot(1e3 * commands, 1e3 * x, "o", ms=3, label="spring")
    axes[0].set_ylabel("x_l [mm]")
    axes[0].legend()
    axes[1].plot(1e3 * commands, force, "o", ms=3)
    axes[1].set_ylabel("contact force [N]")
    for ax in axes:
        ax.set_xlabel("u_l [mm]")
    result.draw("finger", figure, "Left finger: position and contact force against its command. The surface of the ball is at -100 mm.")
    result.data["finger"] = {"u_m": commands, "x_m": x, "force_N": force}


def add_lifting(result: Result, ours: Ours, quick: bool) -> None:
    """The same robot positions, two commands: one lifts the ball, one does not."""
    increment = 2e-4 if quick else 1e-4
    weak, strong = squeeze(ours, 0.005), squeeze(ours, 0.02)
    same = float(np.max(np.abs(weak - strong)))
    result.add(
        "configurations of a weak (5 mm) and a strong (20 mm) squeeze",
        "equal: motion alone cannot tell them apart",
        f"{same:.1e} m apart",
        same < 1e-6,
    )
    low, high = (lift(ours, depth, 0.03, increment) for depth in (0.005, 0.02))
    result.add(
        "… and the ball after the gripper is commanded 30 mm up",
        "stays | is lifted",
        f"{1e3 * low:.2f} | {1e3 * high:.2f} mm",
        abs(low) < 1e-5 and abs(high - 0.02) < 1e-4,
        "20 mm: the spring gives way by weight/k",
    )
    lower, upper = 0.005, 0.02
    for _ in range(8 if quick else 10):
        depth = (lower + upper) / 2
        lower, upper = (lower, depth) if lift(ours, depth, 0.025, increment) > 1e-3 else (depth, upper)
    predicted = WEIGHT / (2 * FRICTION * STIFFNESS)
    result.add(
        "smallest squeeze that lifts",
        f"weight/(2 μ k) = {1e3 * predicted:g} mm",
        f"{1e3 * upper:.2f} mm",
        -FRICTION * increment - 1e-4 < upper - predicted < 1e-4,
        f"Anitescu's gap takes off up to μ · {1e3 * increment:g} mm",
    )


def add_wall(result: Result) -> None:
    """Figure 2-4: one joint pushes against a wall, at many stiffnesses."""
    stiffnesses = np.array([1e2, 1e3, 1e4, 1e5])
    depth = 0.01
    forces, speeds = [], []
    for k in stiffnesses:
        step = solved(st.step(load_with_stiffness("cart_wall", float(k)), [0.0], [-depth], h=H, tol_complementarity=1e-11))
        forces.append(step.lambda_[0, 0] / H)
        speeds.append(step.delta[0] / H)
    error = float(np.max(np.abs(np.array(forces) / (stiffnesses * depth) - 1)))
    result.add("2-4 (b) impedance: force on the wall against k · depth", "determined", f"{error:.1e} relative", error < 1e-4)
    still = float(np.max(np.abs(speeds)))
    result.add(
        "2-4 (b) speed of the robot while the command is 1 m/s into the wall", "that of the wall, 0", f"{still:.1e} m/s", still < 1e-3
    )
    result.add(
        "2-4 (a) admittance is k → ∞: force per micrometre of command",
        "not determined",
        f"{stiffnesses[0] * 1e-6:g} N at {stiffnesses[0]:g} N/m … {stiffnesses[-1] * 1e-6:g} N at {stiffnesses[-1]:g} N/m, without bound",
        None,
    )
    result.data["wall"] = {"stiffness_N_m": stiffnesses, "force_N": forces}


def run(quick: bool) -> Result:
    result = Result(
        f"The gripper of figure 2-2: two fingers (k = {STIFFNESS:g} N/m), a ball of {WEIGHT:g} N and radius {RADIUS} m, μ = {FRICTION}; and one joint before a wall. A "
        "command that would have the robot inside the ball gives a position on its surface and a force; the same positions with another command give another force.",
        settings={"h": H, "stiffness": STIFFNESS, "friction": FRICTION, "weight": WEIGHT},
    )
    ours = Ours()
    add_free_body(result, ours, quick)
    add_lifting(result, ours, quick)
    add_wall(result)
    return result
