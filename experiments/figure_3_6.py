"""Figure 3-6: how trees grow with three smoothing schemes and without the pieces of 3.4."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import growth
from .report import Result, number

TITLE = "Figure 3-6: packing ratio and distance to the goal of six tasks, with schemes and ablations"
ABLATIONS = ("exact", "no contact samples", "global metric")
UNNECESSARY = ("allegro_plate", "allegro_pen")  # where the thesis finds that contact samples are
SHOWN = 40  # points of a curve


def run(quick: bool) -> Result:
    names = ("planar_pushing", "planar_hand") if quick else tuple(growth.SYSTEMS)
    iterations = 200 if quick else growth.ITERATIONS
    seeds = range(2 if quick else growth.RUNS)
    result = Result(
        "Settings are those of the published runs (tasks `…_table_3_2`): one step per extension, jumps to contact samples, published γ, lengths, boxes and "
        "standard deviations, 100 samples. The contact sampler is ours.\n\n"
        "* **Distance** is the least ‖qᵘ − q_goal‖ over the tree, metres and radians alike.\n* **Packing ratio** (3.9) is the share of 1000 draws from the boxes "
        "within η of a node, eᵀ(BᵤBᵤᵀ + γI)⁻¹e ≤ η. B is that of the variant (exact: that of the exact dynamics), and η that of the published scripts: 5 for "
        "the pen, else 3.\n* **Supported** on a task is a hypothesis that holds for the areas under both curves, which are means over runs and iterations. It is "
        "refuted where it fails in both. The end is not judged: there most ratios are 1.",
        settings={"iterations": iterations, "seeds": list(seeds), "samples": 1000},
    )
    means: dict[str, dict[str, np.ndarray]] = {}
    figure, axes = plt.subplots(2, len(names), figsize=(2.6 * len(names) + 1, 4.6), squeeze=False)
    sound = True
    for column, name in zip(axes.T, names):
        system = growth.SYSTEMS[name]
        means[name] = {}
        result.data[name] = {"iteration": np.arange(1, iterations + 1)}
        for variant, planner in growth.variants(system).items():
            trees = [growth.grow(name, planner, seed, iterations) for seed in seeds]
            distance = np.array([growth.distances(tree, iterations) for tree in trees])
            packing = np.array([growth.by_iteration(tree, tree.packing_ratio(system.threshold), iterations) for tree in trees])
            sound &= bool((np.diff(packing) >= 0).all() and (packing <= 1).all() and (np.diff(distance) <= 0).all())
            means[name][variant] = np.array([distance.mean(), packing.mean()])
            result.data[name] |= {f"distance_{variant}": distance.mean(axis=0), f"packing_{variant}": packing.mean(axis=0)}
            ours = f"distance {spread(distance[:, -1])}, packing ratio {spread(packing[:, -1])}"
            result.add(f"{name}, {variant}: at the end", "plotted only", ours, note=areas(means[name][variant]))
            draw(column, variant, distance, packing)
        column[0].set_title(system.title)
        column[0].set_yscale("log")
        column[1].set_ylim(0, 1)
        column[1].set_xlabel("iterations")
    axes[0][0].set_ylabel("least distance to the goal")
    axes[1][0].set_ylabel("packing ratio")
    axes[0][-1].legend(fontsize=6)
    result.add("curves: distance never rises, packing ratio never falls and stays below 1", "–", "in every run" if sound else "no", sound)
    hypotheses(result, means)
    result.draw("growth", figure, "Least distance to the goal and packing ratio over iterations, mean of the runs.")
    return result


def spread(values: np.ndarray) -> str:
    """Mean ± standard deviation of the runs."""
    return f"{number(values.mean())} ± {values.std():.2g}"


def draw(column: np.ndarray, variant: str, distance: np.ndarray, packing: np.ndarray) -> None:
    at = np.unique(np.linspace(0, distance.shape[1] - 1, SHOWN).astype(int))
    for ax, values in zip(column, (distance, packing)):
        ax.plot(at + 1, values[:, at].mean(axis=0), color=growth.COLOURS[variant], label=variant)


def areas(means: np.ndarray) -> str:
    return f"over all iterations {number(means[0])}, {number(means[1])}"


def hypotheses(result: Result, means: dict[str, dict[str, np.ndarray]]) -> None:
    """The four of 3.5 by the areas under the curves of all tasks; that on computing time is judged in Table 3.2."""
    by_task = {ablation: {name: compare(runs["analytic"], runs[ablation]) for name, runs in means.items()} for ablation in ABLATIONS}
    judge(result, "1: smoothing beats exact linearisation", by_task["exact"], "everywhere")
    judge(result, "2: analytic and randomised smoothing perform alike", {name: equal(runs) for name, runs in means.items()}, "on most tasks", share=0.5)
    judge(result, "3: the local metric beats a global one", by_task["global metric"], "everywhere")
    samples = by_task["no contact samples"]
    judge(result, "4: contact samples help", {name: samples[name] for name in means if name not in UNNECESSARY}, "e.g. on PlanarPushing, PlanarHand, AllegroHand")
    for name in filter(means.__contains__, UNNECESSARY):
        without, with_samples = means[name]["no contact samples"], means[name]["analytic"]
        as_good = without[0] <= with_samples[0] and without[1] >= with_samples[1]
        ours = f"{'yes' if as_good else 'differs'}: mean distance {number(without[0])} without, {number(with_samples[0])} with them"
        result.add(f"hypothesis 4: contact samples are not necessary on {name}", "yes", ours, as_good or None)


def compare(ours: np.ndarray, ablation: np.ndarray) -> str:
    nearer, fuller = ours[0] < ablation[0], ours[1] > ablation[1]
    return "supported" if nearer and fuller else "refuted" if not nearer and not fuller else "mixed"


def equal(runs: dict[str, np.ndarray]) -> str:
    """Alike: the packing ratios of the three schemes, over all iterations, lie within 0.1 of each other."""
    ratios = [runs[scheme][1] for scheme in growth.SCHEMES]
    return "supported" if max(ratios) - min(ratios) <= 0.1 else "refuted"


def judge(result: Result, claim: str, verdicts: dict[str, str], thesis: str, share: float = 1.0) -> None:
    """A claim holds where it is supported on more than half of the tasks (share 0.5), or on all of them."""
    count = sum(verdict == "supported" for verdict in verdicts.values())
    others = ", ".join(f"{name} {verdict}" for name, verdict in verdicts.items() if verdict != "supported")
    holds = count == len(verdicts) or count > share * len(verdicts)
    result.add(f"hypothesis {claim}", thesis, f"{'' if holds else 'differs: '}supported on {count} of {len(verdicts)} tasks", holds or None, others)
