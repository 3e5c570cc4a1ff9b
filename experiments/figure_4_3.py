"""Figures 4-3 and 4-6: residuals over the surface, and rejection sampling."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import touch
from .report import Result
from .touch import percent

TITLE = "Figures 4-3 and 4-6: residuals over two links, and what rejection sampling keeps"
SHOWN = 80
EPSILON, DELTA = 0.005, 0.1  # of ½ ‖·‖² [(N m)²]


def run(quick: bool) -> Result:
    data = touch.maps(quick)
    dense, sparse = data["dense"], data["sparse"]
    result = Result(touch.case(quick), settings={"samples": [dense["samples"], sparse["samples"]], "epsilon": EPSILON})
    meshes = data["iiwa"] == "iiwa"
    rejected = 1 - dense["accepted_eps"] / dense["samples"]
    for name, d, accepted, samples in (("dense", dense, 491, 20000), ("sparse", sparse, 24, 1000)):
        share = accepted / samples
        error = 4 * np.sqrt(share * (1 / samples + 1 / d["samples"]))
        holds = abs(d["accepted_eps"] / d["samples"] - share) < error if meshes else None
        result.add(f"accepted with ε = {EPSILON}, {name}", f"{accepted} of {samples}", f"{d['accepted_eps']} of {d['samples']}", holds, "four standard deviations" if meshes else "")
    every = data["all_faces"]
    result.add("the same with the faces inside the robot, dense", "–", f"{every['accepted_eps']} of {every['samples']}")
    result.add("rejected", "approximately 98 %", percent(rejected), abs(rejected - 0.98) < 0.01)
    shares = [d["accepted_eps"] / d["samples"] for d in (dense, sparse)]
    error = 4 * np.sqrt(shares[0] * (1 / dense["samples"] + 1 / sparse["samples"]))
    result.add("share accepted, dense and sparse", "equal", " | ".join(map(percent, shares)), abs(shares[0] - shares[1]) < error, "four standard deviations")

    figure, axes = plt.subplots(1, 2, figsize=(6.4, 2.9), sharey=True)
    for axis, d, title in zip(axes, (dense, sparse), ("dense", "sparse"), strict=True):
        points = np.array([p[:3] for p in d["points"]])
        residuals = np.array([p[3] for p in d["points"]]) / 2
        chosen = np.r_[np.flatnonzero(residuals > DELTA)[:SHOWN], np.flatnonzero(residuals <= DELTA)[:SHOWN]]
        bounds = [(EPSILON, "C3", f"≤ {EPSILON}"), (DELTA, "C1", f"≤ {DELTA}"), (np.inf, "0.8", "more")]
        touch.scatter(axis, points[chosen][:, [0, 2]], residuals[chosen], bounds)
        axis.set_title(f"{title}: {d['accepted_eps']} of {d['samples']}", fontsize=8)
        axis.set_xlabel("x [m]")
    axes[0].set_ylabel("z [m]")
    axes[1].legend(title="½ l", fontsize=7, title_fontsize=7)
    result.draw("residuals", figure, f"Residuals of points on links 5 and 6, seen along y. At most {SHOWN} above δ and below it are shown.")
    result.data["residuals"] = {name: np.array([p[i] for p in dense["points"]]) for i, name in enumerate(("x_m", "y_m", "z_m", "l_Nm2"))}
    return result
