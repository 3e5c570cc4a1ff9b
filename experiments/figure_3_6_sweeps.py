"""Sweeps around figure 3-6: what weights, h, κ and σ do to hypotheses 2, 3 and 4."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from . import growth
from .figure_3_6 import UNNECESSARY, compare
from .report import Result, number

TITLE = "Figure 3-6, swept: weights of the global metric, h, κ and σ"
RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)  # of the published weight of positions over that of angles
STEPS = (0.05, 0.1, 0.2)  # h [s]; published: 0.1
KAPPAS = (10.0, 30.0, 100.0, 300.0)  # [1/J]; published: 100
SPREADS = (0.3, 1.0, 3.0)  # of the published σ
LENGTHS = (1.0, 2.0)  # of the published length of an extension
ALIKE = 0.1  # as in figure 3-6


def mean_areas(name: str, settings: dict[str, Any], seeds: range, iterations: int) -> np.ndarray:
    """Least distance and packing ratio, means over iterations and runs, and the distance at the end."""
    rows = []
    for seed in seeds:
        tree = growth.grow(name, settings, seed, iterations)
        distance = growth.distances(tree, iterations)
        packing = growth.by_iteration(tree, tree.packing_ratio(growth.SYSTEMS[name].threshold), iterations)
        rows.append([distance.mean(), packing.mean(), distance[-1]])
    return np.mean(rows, axis=0)


def share_extended(name: str, settings: dict[str, Any], iterations: int) -> float:
    """Of the jumps to a contact sample, those from which anything was extended."""
    tree = growth.grow(name, settings, 0, iterations).tree
    jumps = {i for i, node in enumerate(tree) if node.edge == st.SegmentKind.Regrasp}
    return len(jumps & {node.parent for node in tree}) / max(len(jumps), 1)


def add_weights(result: Result, names: tuple[str, ...], seeds: range, iterations: int) -> None:
    """Hypothesis 3: only the ratio of the weights says which node is nearest."""
    local = {name: mean_areas(name, {}, seeds, iterations) for name in names}
    rows: dict[str, list[float]] = {name: [] for name in names}
    best = dict.fromkeys(names, np.inf)
    for ratio in RATIOS:
        verdicts = {}
        for name in names:
            weights = growth.SYSTEMS[name].weights
            found = mean_areas(name, {"metric": {"global": weights | {"position": ratio * weights["position"]}}}, seeds, iterations)
            verdicts[name] = compare(local[name], found)
            best[name] = min(best[name], found[0])
            rows[name].append(found[0])
        supported = sum(verdict == "supported" for verdict in verdicts.values())
        others = ", ".join(f"{name} {verdict}" for name, verdict in verdicts.items() if verdict != "supported")
        result.add(f"hypothesis 3, positions over angles {ratio:g} times as published", "supported everywhere", f"supported on {supported} of {len(names)} tasks", supported == len(names) or None, others)
    nearer = [name for name in names if local[name][0] < best[name]]
    ours = f"on {len(nearer)} of {len(names)} tasks"
    result.add("hypothesis 3: the tree with the local metric comes nearer to the goal than with the best of all weights", "everywhere", ours, len(nearer) == len(names) or None)
    result.data["weights"] = {"ratio": np.array(RATIOS)} | {f"distance_{name}": np.array(values) for name, values in rows.items()}
    for name in names:
        shares = [share_extended(name, settings, iterations) for settings in ({}, {"metric": {"global": growth.SYSTEMS[name].weights}})]
        result.add(f"{name}: jumps to contacts that were extended", "–", f"{100 * shares[0]:.0f} % with the local metric, {100 * shares[1]:.0f} % with the global one")


def scheme_settings(task: st.Task, scheme: str, h: float, kappa: float, spread: float) -> dict[str, Any]:
    thesis = task.options.thesis
    sampling = thesis.get("randomized", {"std_u": 0.1, "samples": 100})  # without any the default
    return {
        "scheme": scheme,
        "h": h,
        "smoothing": thesis.get("smoothing", {}) | {"kappa": kappa},
        "randomized": sampling | {"std_u": (spread * np.asarray(sampling["std_u"])).tolist()},
    }


def add_schemes(result: Result, names: tuple[str, ...], seeds: range, iterations: int, quick: bool) -> None:
    """Hypothesis 2: packing ratios over h, κ and σ."""
    for name in names:
        task = st.load_task(f"{name}_table_3_2")
        ratios: dict[str, dict[tuple[float, float], float]] = {scheme: {} for scheme in growth.SCHEMES}
        for scheme in growth.SCHEMES[: 1 if quick else None]:
            amounts = KAPPAS if scheme == "analytic" else SPREADS
            for h, amount in {*((h, 100.0 if scheme == "analytic" else 1.0) for h in STEPS), *((0.1, amount) for amount in amounts)}:
                settings = scheme_settings(task, scheme, h, *((amount, 1.0) if scheme == "analytic" else (100.0, amount)))
                ratios[scheme][h, amount] = float(mean_areas(name, settings, seeds, iterations)[1])
        for scheme, found in ratios.items():
            if not found:
                continue
            unit = "κ" if scheme == "analytic" else "σ/σ published"
            text = ", ".join(f"h = {h:g}, {unit} = {amount:g}: {ratio:.2f}" for (h, amount), ratio in sorted(found.items()))
            result.add(f"{name}, {scheme}: packing ratio over all iterations", "–", text)
        if quick:
            return
        published = [ratios[scheme][0.1, 100.0 if scheme == "analytic" else 1.0] for scheme in growth.SCHEMES]
        best = [max(ratios[scheme].values()) for scheme in growth.SCHEMES]
        apart, left = np.ptp(published), np.ptp(best)
        ours = f"{'yes' if left <= ALIKE else 'differs'}: {left:.2f} apart, {apart:.2f} with the published values"
        result.add(f"hypothesis 2 on {name}: alike with the best h, κ and σ of each scheme", "believed of plate", ours, left <= ALIKE or None, f"alike: at most {ALIKE:g} apart")


def add_reach(result: Result, names: tuple[str, ...], seeds: range, iterations: int) -> None:
    """Hypothesis 4: can more smoothing, a longer step or a longer extension do without contact samples?"""
    for name in names:
        task = st.load_task(f"{name}_table_3_2")
        with_samples = mean_areas(name, {}, seeds, iterations)
        found = {}
        for kappa in KAPPAS:
            for h in STEPS:
                for length in LENGTHS:
                    settings = scheme_settings(task, "analytic", h, kappa, 1.0) | {"grasp_probability": 0, "length": length * task.options.thesis["length"]}
                    found[kappa, h, length] = mean_areas(name, settings, seeds, iterations)
        (kappa, h, length), best = min(found.items(), key=lambda item: item[1][2])
        published = found[100.0, 0.1, 1.0]
        unnecessary = best[2] <= with_samples[2]
        ours = f"{'yes' if unnecessary else 'differs'}: {number(best[2])} from the goal at the end with κ = {kappa:g}, h = {h:g}, {length:g} times the length"
        note = f"{number(published[2])} as published, {number(with_samples[2])} with contact samples"
        result.add(f"hypothesis 4 on {name}: no contact samples needed, with the best κ, h and length", "yes", ours, unnecessary or None, note)
        result.data[f"reach_{name}"] = {"kappa": [k for k, _, _ in found], "h": [h for _, h, _ in found], "length": [n for _, _, n in found], "distance": [v[2] for v in found.values()]}


def run(quick: bool) -> Result:
    names = ("planar_hand",) if quick else tuple(growth.SYSTEMS)
    iterations = 60 if quick else growth.ITERATIONS
    seeds = range(1 if quick else 3)
    result = Result(
        "Runs as in figure 3-6, with fewer seeds.\n\n"
        "| hypothesis | judged for |\n|---|---|\n| 3 | other weights of the global metric, of which only the ratio matters |\n| 2 | other time steps h, and other "
        "amounts of smoothing (half as many iterations) |\n| 4 | more and less smoothing, other h, longer extensions |\n\n"
        "With a global metric a node and the jumps from it to contact samples are equally near to every subgoal, for the object is at the same place. The first "
        "of them is extended, and most jumps never are.",
        settings={"iterations": iterations, "seeds": list(seeds), "ratios": RATIOS, "h": STEPS, "kappa": KAPPAS, "spread": SPREADS, "length": LENGTHS},
    )
    add_weights(result, names, seeds, iterations)
    add_schemes(result, names if quick else ("planar_hand", "allegro_plate"), range(1 if quick else 2), iterations // 2, quick)
    if not quick:
        add_reach(result, UNNECESSARY, seeds, iterations)
    figure, ax = plt.subplots(figsize=(4.2, 2.8))
    for name in names:
        ax.plot(RATIOS, result.data["weights"][f"distance_{name}"], "o-", ms=3, label=growth.SYSTEMS[name].title)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("weight of positions over angles, published = 1")
    ax.set_ylabel("least distance, mean")
    ax.legend(fontsize=6)
    result.draw("weights", figure, "Least distance to the goal over all iterations, with a global metric.")
    return result
