"""Figures 4-4 and 4-5: what the torque of one joint shows of a contact."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from . import touch
from .report import Result, number
from .touch import percent

TITLE = "Figures 4-4 and 4-5: what one joint can show of a contact"
SHOWN = 100
RANGE = (0.28, 0.34)  # of the forearm over meshes, axes and n_d, as far as the thesis leaves them open; sampling adds four standard deviations
PUBLISHED_SHARE, SHARE_ERROR = 0.80, 0.03  # of samples with η ≥ 0.4
COMPACT = (0.018, 0.036)  # of the iiwa's link 6, the same


def add_missed(result: Result, name: str, link: dict[str, Any], of_thesis: bool) -> None:
    """Share of samples with η ≥ 0.4, and the same for what the thesis leaves open of (4.8): the cone of the dome, and whether the sign of τ counts."""
    (at,) = [row for row in link["eta"] if row["epsilon"] == 0.02]
    note = f"mean η {at['mean']:.3f}: a force of 1 N is missed with this probability"
    result.add(f"{name}: η ≥ 0.4 at ε = 0.02 N m/N, exact cone, abs(τ) ≤ ε", "80 %" if of_thesis else "–", percent(at["at_least_0_4"]), None, note)
    if not of_thesis:
        return
    polyhedral = link["at_least_0_4"]["absolute"]
    share = polyhedral["4"]
    signed = link["at_least_0_4"]["signed"].values()
    others = ", ".join(f"{'exact cone' if rays == 'exact' else f'n_d = {rays}'}: {percent(found)}" for rays, found in polyhedral.items() if rays != "4")
    note = f"{others}; with τ ≤ ε as (4.8c) is printed {percent(min(signed))} to {percent(max(signed))}; within {100 * SHARE_ERROR:g} %, for the published number is round"
    within = abs(share - PUBLISHED_SHARE) < SHARE_ERROR
    result.add(f"{name}: the same by samples on the dome of the cone of n_d = 4", "80 %", percent(share) if within else f"differs: {percent(share)}", within or None, note)


def run(quick: bool) -> Result:
    data = touch.maps(quick)
    links = {link["name"]: link for link in data["detectability"]}
    meshes = data["iiwa"] == "iiwa"
    compact, whole = f"{data['iiwa']}, link 6", f"{data['iiwa']}, link 6, all faces"
    result = Result(
        "Share of a link's surface on which every force of the cone turns the last joint before it (4.7), and η_ε, the share of forces that turn it by no more than ε (4.8), with "
        f"μ = 1 and {next(iter(links.values()))['samples']} samples uniform by area. The thesis does not state n_d, nor the mesh and axis of the UR5. Here: the collision mesh of the "
        "package example-robot-data with all faces, about the elbow axis (y of the link), about its x axis for comparison, and without the faces that nothing can touch. "
        + ("The iiwa is that of figure 4-3, about joint 6 (z of the link)." if meshes else "There is no mesh of an iiwa: the link of capsules is rounder, so that next to nothing of it is fully detectable."),
        settings={"samples": next(iter(links.values()))["samples"]},
    )
    thesis = {compact: "2.19 %", whole: "2.19 %", "UR5 forearm": "32.58 %", "UR5 forearm, axis x": "32.58 %"}
    for name, link in links.items():
        full = link["full"]
        error = 4 * np.sqrt(full["4"] * (1 - full["4"]) / link["samples"])
        spread = ", ".join(f"{rays}: {percent(share)}" for rays, share in full.items() if rays != "4")
        verdict = RANGE[0] - error < full["4"] < RANGE[1] + error if name in ("UR5 forearm", "UR5 forearm, axis x") else None
        if meshes and name in (compact, whole):
            verdict = COMPACT[0] - error < full["4"] < COMPACT[1] + error
        result.add(f"{name}: fully detectable, n_d = 4", thesis.get(name, "–"), percent(full["4"]), verdict, f"n_d = {spread}; {link['triangles']} triangles")
    iiwa, forearm = links[compact], links["UR5 forearm"]
    least = RANGE[0] / COMPACT[1]
    far_more = forearm["full"]["4"] > least * iiwa["full"]["4"]
    result.add("far more of the long link than of the compact one", "32.58 % | 2.19 %", f"{percent(forearm['full']['4'])} | {percent(iiwa['full']['4'])}", far_more, f"{least:.1f} times at least, of meshes, axes and n_d that the thesis leaves open")
    for name in (compact, whole, "UR5 forearm", "Panda link 6"):
        add_missed(result, name, links[name], of_thesis=name.startswith("iiwa"))
    higher = all(a["mean"] > b["mean"] for a, b in zip(iiwa["eta"], forearm["eta"], strict=True))
    result.add("η of the compact link above that of the long one, at every ε", "yes", "yes" if higher else "no", higher)

    figure, axes = plt.subplots(1, 3, figsize=(6.6, 3.0), width_ratios=(1, 1, 1.5))
    for axis, name, columns, labels in ((axes[0], compact, (1, 2), "yz"), (axes[1], "UR5 forearm", (0, 2), "xz")):
        points = np.array(links[name]["points"])[:SHOWN]
        touch.scatter(axis, points[:, columns], -points[:, 4], [(-2, "c", "fully"), (0, "k", "in part")])
        axis.set_xlabel(f"{labels[0]} [m]")
        axis.set_ylabel(f"{labels[1]} [m]")
        axis.set_title(name.replace(" of capsules", ""), fontsize=8)
    axes[1].legend(fontsize=7, loc="lower right")
    for name in (compact, "Panda link 6", "UR5 forearm"):
        rows = links[name]["eta"]
        axes[2].plot([r["epsilon"] for r in rows], [r["mean"] for r in rows], "o-", ms=3, label=name)
    axes[2].set_xlabel("ε [N m/N]")
    axes[2].set_ylabel("mean η")
    axes[2].legend(fontsize=7)
    result.draw("detectability", figure, f"Left: where a contact is fully detectable ({SHOWN} samples). Right: share of forces that turn the joint by no more than ε.")
    names = list(links)
    result.data["eta"] = {"epsilon": np.array([r["epsilon"] for r in iiwa["eta"]])} | {f"mean:{name}": np.array([r["mean"] for r in links[name]["eta"]]) for name in names}
    result.add(f"mean η, {data['iiwa']} over UR5 forearm, ε = 0.02", "–", number(iiwa["eta"][3]["mean"] / forearm["eta"][3]["mean"]))
    return result
