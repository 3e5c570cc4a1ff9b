"""Errata of chapter 2: what is printed, what holds, and a number of the library for each."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .figure_2_14 import kernel, sharpness
from .report import Result, number
from .systems import load, solved

TITLE = "Errata of chapter 2"
H = 0.1
STIFFNESS = 100.0


def add_complementarity(result: Result) -> None:
    """§2.4.3: a cone keeps vᵀλ = 2/κ, its barrier has degree 2; a half-line keeps 1/κ. In the thesis's κ = our κ / h."""
    kappa = 50.0
    model = load("ball_on_floor")
    q = model.neutral()
    step = solved(st.step(model, q, [0.03, 0.01, -0.02], h=H, smoothing=st.Analytic(kappa=kappa, self_sharpness=1)))
    (contact,) = step.contacts
    v = contact.displacement + [contact.phi, 0, 0]
    cone = float(v @ contact.lambda_) * kappa / H
    result.add(
        "§2.4.3  κ_thesis vᵀλ of a frictional contact in space",
        "1",
        f"{cone:.8f}",
        abs(cone - 2) < 1e-6,
        "2: the barrier of the cone has degree 2",
    )

    limit = load("cart_limit")
    u = -0.05
    x = float(solved(st.step(limit, [0.05], [u], h=H, smoothing=st.Analytic(kappa=kappa, limit_sharpness=1))).q_next[0])
    line = STIFFNESS * (x - u) * x * kappa
    result.add("§2.4.3  the same of a half-line (a joint limit)", "1", f"{line:.8f}", abs(line - 1) < 1e-6, "1 holds here")


def add_closed_form(result: Result) -> None:
    """(2.34) has 4/(κh²k²) where (2.32) gives 4/(κhk)."""
    limit = load("cart_limit")
    kappa, u = 100.0, -0.05
    for h in (0.1, 0.05):
        x = float(solved(st.step(limit, [0.05], [u], h=h, smoothing=st.Analytic(kappa=kappa, limit_sharpness=1))).q_next[0])
        constant = (2 * x - u) ** 2 - u**2  # of q⁺ = (u + √(u² + constant))/2
        kappa_thesis = kappa / h
        printed, right = 4 / (kappa_thesis * h**2 * STIFFNESS**2), 4 / (kappa_thesis * h * STIFFNESS)
        result.add(
            f"(2.34)  the constant under the root, h = {h} s",
            f"4/(κh²k²) = {number(printed)} m²",
            f"{number(constant)} m²",
            abs(constant / right - 1) < 1e-6 < abs(constant / printed - 1),
            f"4/(κhk) = {number(right)} m², from (2.32)",
        )


def add_variance(result: Result) -> None:
    """(2.35) has no variance: its second moment within ±L grows with log L."""
    kappa = 100.0
    sigma = sharpness(kappa)
    scale = math.sqrt(2 / sigma)
    w = np.linspace(-0.3, 0.3, 7)
    student = 1 / (scale * (2 + (w / scale) ** 2) ** 1.5)
    error = float(np.max(np.abs(kernel(w, kappa) / student - 1)))
    result.add(
        "(2.35)  against Student's t, two degrees of freedom, scale √(2/σ)",
        "an elliptical distribution",
        f"{error:.1e} apart",
        error < 1e-12,
    )

    # ∫ w² ρ over |w| < L, by the substitution w = √(4/σ) sinh(s).
    lengths = np.geomspace(0.01, 100, 41)
    moments = np.array([second_moment(kappa, length) for length in lengths])
    rise = float(moments[-1] - moments[-11]) / (4 / sigma * math.log(lengths[-1] / lengths[-11]))
    result.add(
        "(2.35)  growth of the second moment per e-fold of L, times σ/4",
        "–",
        f"{rise:.6f}",
        abs(rise - 1) < 1e-3,
        "does not end: infinite variance",
    )

    figure, axes = plt.subplots(figsize=(4.2, 2.6))
    axes.semilogx(lengths, 1e4 * moments)
    axes.set_xlabel("L [m]")
    axes.set_ylabel("∫ w² ρ(w) dw over |w| < L  [cm²]")
    result.draw("moment", figure, "The distribution (2.35) of analytic smoothing has no variance (κ = 100/J, k = 100 N/m).")
    result.data["moment"] = {"L_m": lengths, "second_moment_m2": moments}


def second_moment(kappa: float, length: float) -> float:
    width = math.sqrt(4 / sharpness(kappa))
    points, weights = np.polynomial.legendre.leggauss(200)
    s = math.asinh(length / width) / 2 * (points + 1)
    w = width * np.sinh(s)
    return 2 * float(np.sum(weights * w**2 * kernel(w, kappa) * width * np.cosh(s))) * math.asinh(length / width) / 2


def run(quick: bool) -> Result:
    result = Result(
        "Where the printed text of chapter 2 contradicts itself or its own equations, with what the library computes. ✓ means that the library follows the corrected form and "
        "contradicts the printed one. The barrier weight of the thesis is our κ/h.",
        settings={"h": H, "stiffness": STIFFNESS},
    )
    add_complementarity(result)
    add_closed_form(result)
    add_variance(result)
    return result
