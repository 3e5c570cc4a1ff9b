"""Figures 4-7 and 4-8: rejection sampling followed by descents."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import touch
from .report import Result

TITLE = "Figures 4-7 and 4-8: from accepted samples to minima of the residual"
TORQUE_6 = 0.0817417009  # of the case [N m]; a contact on link 5 cannot make it
FORCE = 10.0  # [N]


def count(runs: list[dict]) -> tuple[int, int, int]:
    """Samples that δ accepts, descents that converge, and those that do to the local minimum on link 5."""
    ends = [r for r in runs if r["converged"]]
    return len(runs), len(ends), sum(r["link"].endswith("link_5") and r["after"] / 2 < 1.01 * TORQUE_6**2 / 2 for r in ends)


def lies_among(published: int, counts: np.ndarray) -> bool:
    """Whether a published count is one that sets of samples give: within three of their standard deviations of their mean."""
    return bool(abs(published - counts.mean()) < 3 * counts.std(ddof=1))


def run(quick: bool) -> Result:
    data = touch.maps(quick)
    runs = data["descents"][0]
    before, after = (np.array([r[name] for r in runs]) / 2 for name in ("before", "after"))
    converged = np.array([r["converged"] for r in runs])
    on_5 = np.array([r["link"].endswith("link_5") for r in runs])
    result = Result(touch.case(quick) + " Descents are Algorithm 4; counts are of the first of eight sets of samples, and in brackets the least and the most of all. On link 5 no contact makes the torque of joint 6, so that ½ τ₆² is left.", settings={"samples": 1000, "delta": 0.1})
    sets = [count(some) for some in data["descents"]]
    spread = [f"{min(column)} to {max(column)}" for column in zip(*sets, strict=True)]
    accepted, ends, locals_ = (np.array(column) for column in zip(*sets, strict=True))
    meshes = data["iiwa"] == "iiwa"
    result.add("accepted with δ = 0.1", "175 of 1000 (184 in 4-10)", f"{len(runs)} of 1000 ({spread[0]})", lies_among(175, accepted) if meshes else None)
    result.add("of these converge", "155 of 175: 89 %", f"{converged.sum()} of {len(runs)}: {100 * converged.mean():.0f} % ({spread[1]})", lies_among(155, ends) if meshes else bool(converged.mean() > 0.5))
    least = float(after[on_5].min())
    local = on_5 & converged & (after < 1.01 * least)
    result.add("local minimum on link 5", "0.003", f"{least:.6f}", abs(least / (TORQUE_6**2 / 2) - 1) < 1e-3, f"½ τ₆² = {TORQUE_6**2 / 2:.6f}")
    result.add("samples that converge to it", "about 60", f"{local.sum()} ({spread[2]})", lies_among(60, locals_) if meshes else None)
    best = min((r for r in runs if r["link"].endswith("link_6")), key=lambda r: r["after"])
    result.add("global minimum on link 6", "yes", f"{best['after'] / 2:.2g}, {best['force']:.2f} N", best["after"] / 2 < least and abs(best["force"] / FORCE - 1) < 0.02, "a force of 10 N made the torques")
    lower = bool(np.all(after[converged] <= before[converged]))
    result.add("what converges ends at or below its start", "yes", "yes" if lower else "no", lower)

    figure, axes = plt.subplots(1, 2, figsize=(6.4, 2.8))
    start, end = (np.array([r[name] for r in runs]) for name in ("start", "end"))
    gaps = np.full(len(runs), np.nan)  # one line for all of them
    axes[0].plot(*(np.c_[start[:, i], end[:, i], gaps].ravel() for i in (0, 2)), "-", color="0.7", lw=0.6)
    axes[0].plot(start[:, 0], start[:, 2], ".", ms=3, color="C0", label="accepted")
    axes[0].plot(end[converged, 0], end[converged, 2], "s", ms=3, color="C3", label="converged")
    axes[0].set_aspect("equal")
    axes[0].set_xlabel("x [m]")
    axes[0].set_ylabel("z [m]")
    axes[0].legend(fontsize=7)
    bins = np.logspace(-7, -0.9, 30)
    axes[1].hist(before, bins=bins, color="C0", alpha=0.6, histtype="stepfilled", label="accepted")
    axes[1].hist(np.maximum(after[converged], 1e-7), bins=bins, color="C3", alpha=0.6, histtype="stepfilled", label="converged")
    axes[1].set_xscale("log")
    axes[1].set_xlabel("½ l [(N m)²]")
    axes[1].set_ylabel("samples")
    result.draw("descents", figure, "Left: samples and where their descents end. Right: their residuals.")
    result.data["descents"] = {"before_Nm2": before, "after_Nm2": after, "converged": converged.astype(float), "link": np.where(on_5, 5.0, 6.0)}
    return result
