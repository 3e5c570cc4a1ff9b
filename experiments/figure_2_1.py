"""Figure 2-1: Anitescu's boundary layer. A sliding contact opens by h μ |v_t|."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number
from .systems import load, slope, solved

TITLE = "Figure 2-1: sliding opens a gap that vanishes with the step"
FRICTION = 0.5
SPEED = 0.1  # of the command along the ground [m/s]
DEPTH = 0.02  # of the command below the ground [m]
STIFFNESS = 100.0


def slide(model: st.Model, h: float) -> tuple[float, float, float]:
    """Gap [m], slip speed [m/s] and ratio of friction to normal force once the ball slides steadily."""
    u = np.array([0.0, -DEPTH])
    q = solved(st.step(model, [0.0, 0.0], u, h=h)).q_next
    work = st.StepWorkspace(model)
    # The ball lags until the spring force reaches μ f_n, over μ·DEPTH of travel; twice that far is steady.
    for _ in range(int(np.ceil(2 * FRICTION * DEPTH / (SPEED * h))) + 3):
        u[0] += SPEED * h
        result = solved(st.step(model, q, u, h=h, workspace=work))
        q = result.q_next
    (contact,) = result.contacts
    return contact.anitescu_gap, contact.slide / h, float(np.linalg.norm(contact.lambda_[1:]) / contact.lambda_[0])


def run(quick: bool) -> Result:
    model = load("grazing")
    steps = np.geomspace(1e-3, 0.1, 5 if quick else 9)
    gaps, speeds, ratios = np.array([slide(model, h) for h in steps]).T
    predicted = steps * FRICTION * speeds

    result = Result(
        f"A ball on springs of {STIFFNESS:g} N/m is pressed onto the ground (command {1e3 * DEPTH:g} mm below it, μ = {FRICTION}) and dragged along it at "
        f"{SPEED} m/s. Coulomb's law has it slide on the surface; in the relaxation (2.12) it slides at the distance φ = μ δt.",
        settings={"friction": FRICTION, "speed": SPEED, "depth": DEPTH, "stiffness": STIFFNESS, "h": steps.tolist()},
    )
    error = float(np.max(np.abs(gaps / predicted - 1)))
    result.add("gap over h μ |v_t|, largest deviation from 1", "1 (2.12b)", number(error), error < 1e-3)
    exponent = slope(steps, gaps)
    result.add("exponent of the gap in h", "1: vanishes as h → 0", f"{exponent:.4f}", abs(exponent - 1) < 1e-3)
    result.add("gap at h = 0.1 s", "–", f"{1e3 * gaps[-1]:.3f} mm", None)
    cone = float(np.max(np.abs(ratios - FRICTION)))
    result.add("friction over normal force against μ", "on the boundary of the cone", number(cone), cone < 1e-4)

    figure, axes = plt.subplots(figsize=(4.2, 2.8))
    axes.loglog(steps, 1e3 * predicted, "-", color="0.6", label="h μ |v_t|")
    axes.loglog(steps, 1e3 * gaps, "o", ms=4, label="computed")
    axes.set_xlabel("step h [s]")
    axes.set_ylabel("gap [mm]")
    axes.legend()
    result.draw("gap", figure, "Distance at which a sliding contact carries its force.")
    result.data["gap"] = {"h_s": steps, "gap_m": gaps, "slip_speed_m_s": speeds, "friction_ratio": ratios}
    return result
