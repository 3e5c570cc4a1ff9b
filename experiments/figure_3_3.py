"""Figure 3-3: the local Mahalanobis metric of the planar hand."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .planar import draw_object, draw_robot, finish
from .report import Result, number

TITLE = "Figure 3-3: sublevel sets of the local Mahalanobis metric"
GAMMA = 1e-6
SMOOTHED = st.Analytic(kappa=100.0)
PARTS = (("b", [-0.785398, -0.785398, 0.785398, 0.785398], "C3"), ("c", [-0.85, -0.4, 0.3, 0.8], "C0"))  # joints of two configurations
BALL = [0.0, 0.35, 0.0]
MOVES = 25


def shape(model: st.Model, q: np.ndarray) -> np.ndarray:
    """Σ of (3.5)."""
    local = st.calc_local_model(model, q, q[3:], smoothing=SMOOTHED, regularisation=st.FixedEpsilon(epsilon=1.0))
    if local.status != st.Status.Solved:
        raise RuntimeError("no local model")
    return local.B[:3] @ local.B[:3].T + GAMMA * np.eye(3)


def distance(sigma: np.ndarray, e: np.ndarray) -> float:
    return float(e @ np.linalg.solve(sigma, e))


def volume(sigma: np.ndarray) -> float:
    return 4 / 3 * np.pi * np.sqrt(np.linalg.det(sigma))


def ellipse(sigma: np.ndarray, i: int, j: int) -> np.ndarray:
    """Outline of the projection of the 1-sublevel set on two coordinates."""
    circle = np.array([f(np.linspace(0, 2 * np.pi, 41)) for f in (np.cos, np.sin)])
    return np.linalg.cholesky(sigma[np.ix_([i, j], [i, j])]) @ circle


def smallest_gap(model: st.Model, q: np.ndarray) -> float:
    contacts = st.step(model, q, q[3:], smoothing=SMOOTHED).contacts
    names = model.object_names
    return min(c.phi for c in contacts if c.a.split("/")[0] in names or c.b.split("/")[0] in names)


def run(quick: bool) -> Result:
    model = st.load_task("planar_hand").model
    result = Result(
        "Sublevel sets {e : eᵀΣ⁻¹e ≤ 1} with Σ = BᵤBᵤᵀ + γI, γ = 1e-6 and analytic smoothing with κ = 100, shown about their centres. b₁ and c₁ lie where the major axes meet "
        "the outlines, b₂ and c₂ as far away along the minor axes. The thesis does not give the joint angles; ours are in the file.",
        settings={"gamma": GAMMA, "kappa": SMOOTHED.kappa},
    )
    figure, axes = plt.subplots(2, 3, figsize=(9, 5.2))
    names = ("y [m]", "z [m]", "θ [rad]")
    sigmas = {}
    for k, (part, joints, colour) in enumerate(PARTS):
        q = np.array(BALL + joints)
        sigma = sigmas[part] = shape(model, q)
        squares, directions = np.linalg.eigh(sigma)
        major = np.sqrt(squares[-1]) * directions[:, -1]
        minor = np.linalg.norm(major) * directions[:, 0]
        near, far = distance(sigma, major), distance(sigma, minor)
        result.add(f"{part}₁ is nearer than {part}₂, as far in the Euclidean metric", "yes", f"{number(near)} < {number(far)}", near < far)
        for ax, (i, j) in zip(axes[0], ((0, 1), (2, 0), (2, 1))):
            ax.plot(*ellipse(sigma, i, j), color=colour, label=f"configuration {part}")
            for point, mark in ((major, "o"), (minor, "x")):
                ax.plot(point[i], point[j], mark, color=colour, ms=4)
            ax.set_xlabel(names[i])
            ax.set_ylabel(names[j])
        ax = axes[1][k]
        draw_robot(ax, model, q)
        draw_object(ax, "planar_hand", q, ec="k")
        draw_object(ax, "planar_hand", q[:3] + major, ec=colour, ls="--")
        draw_object(ax, "planar_hand", q[:3] + minor, ec=colour, ls=":")
        ax.set_title(f"configuration {part}: at {part}₁ (dashed), {part}₂ (dotted)", fontsize=8)
        finish(ax)
    axes[0][0].legend(fontsize=7)
    turned = np.abs(np.linalg.eigh(sigmas["b"])[1][:, -1] @ np.linalg.eigh(sigmas["c"])[1][:, -1])
    ratio = volume(sigmas["b"]) / volume(sigmas["c"])
    result.add("the two ellipsoids differ", "greatly", f"volumes 1 : {number(1 / ratio)}, major axes {np.degrees(np.arccos(turned)):.0f}° apart")
    shrink(result, axes[1][2], model, quick)
    result.draw("metric", figure, "Above: sublevel sets of two configurations. Below: the configurations, and the volume as the arms draw back from the ball.")
    return result


def shrink(result: Result, ax: plt.Axes, model: st.Model, quick: bool) -> None:
    """(d): the volume as the arms move away from the ball."""
    start = np.array(BALL + PARTS[0][1])
    gaps, volumes = [], []
    for s in np.linspace(0, 0.5, 6 if quick else MOVES):
        q = start + np.concatenate([np.zeros(3), s * np.array([1.0, 0, -1.0, 0])])
        q[3:] = np.clip(q[3:], model.lower, model.upper)
        gaps.append(smallest_gap(model, q))
        volumes.append(volume(shape(model, q)))
    result.data["volume"] = {"gap": gaps, "volume": volumes}
    away = bool((np.diff(gaps) >= -1e-9).all() and (np.diff(volumes) < 0).all())
    result.add("volume shrinks as the fingers leave the ball", "yes", f"{number(volumes[0])} at {1e3 * gaps[0]:.0f} mm, {number(volumes[-1])} at {1e3 * gaps[-1]:.0f} mm", away)
    ax.semilogy(1e3 * np.array(gaps), volumes)
    ax.set_xlabel("gap [mm]")
    ax.set_ylabel("volume of the sublevel set")
