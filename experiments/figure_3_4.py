"""Figure 3-4: trees of the planar hand with a ball that moves up and down and turns."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number

TITLE = "Figure 3-4: trees in the space of the object, with and without the pieces of 3.4"
GOAL = np.array([0.35, np.pi])
BOX = np.array([[0.3, -0.01], [0.4, np.pi]])  # of subgoals
NODES = 50
SHOWN, OUTLINES = 40, 8  # edges and sublevel sets that are drawn of a tree
THRESHOLD = 3.0  # η of the packing ratio
# The settings of the published runs of this system.
SETTINGS = {
    "sample_box": {"carriage": {"lower": BOX[0, :1].tolist(), "upper": BOX[1, :1].tolist()}, "ball": {"lower": BOX[0, 1:].tolist(), "upper": BOX[1, 1:].tolist()}},
    "margins": False,
    "goal_bias": 0.1,
}
THESIS = {"grasp_probability": 0.2, "gamma": 1e-6, "length": 0.2, "regularisation": {"epsilon": 1}}
VARIANTS = {
    "ours": {},
    "no contact samples": {"grasp_probability": 0},
    "global metric": {"metric": {"global": {"position": 100, "angle": 1}}},
    "exact": {"scheme": "exact"},
}


def positions(result: st.PlanResult) -> np.ndarray:
    return np.array([node.q[:2] for node in result.tree])


def draw_tree(ax: plt.Axes, result: st.PlanResult, nodes: int, title: str) -> None:
    at = positions(result)[:nodes]
    shown = range(1, nodes, max(1, nodes // SHOWN))
    gap = np.full(2, np.nan)
    edges = np.array([point for i in shown for point in (at[result.tree[i].parent], at[i], gap)])
    ax.plot(*edges.T, color="0.4", lw=0.5)
    outlines = [np.vstack([outline(result.tree[i]).T, gap]) for i in shown[:: max(1, len(shown) // OUTLINES)]]
    ax.plot(*np.vstack(outlines).T, color="C0", lw=0.4)
    ax.plot(*at[0], "s", color="k", ms=4)
    ax.plot(*GOAL, "*", color="C3", ms=8)
    ax.set_xlim(0.2, 0.5)
    ax.set_ylim(-0.6, 3.8)
    ax.set_title(title, fontsize=8)
    ax.grid(False)
    ax.set_xticks([0.2, 0.35, 0.5])
    ax.set_yticks(range(4))


def outline(node: st.TreeNode) -> np.ndarray:
    """Of the 1-sublevel set of its metric."""
    sigma = node.B_u @ node.B_u.T + THESIS["gamma"] * np.eye(2)
    circle = np.array([f(np.linspace(0, 2 * np.pi, 15)) for f in (np.cos, np.sin)])
    return np.linalg.cholesky(sigma) @ circle + node.c_u[:2, None]


def coverage(model: st.Model, result: st.PlanResult) -> float:
    """Packing ratio of the first nodes under the smoothed metric (κ = 100) at their configurations, whatever the tree itself was grown with."""
    rng = np.random.default_rng(0)
    samples = rng.uniform(*BOX, size=(2000, 2))
    inside = np.zeros(len(samples), dtype=bool)
    for node in result.tree[:NODES]:
        local = st.calc_local_model(model, node.q, node.q[2:], smoothing=st.Analytic(kappa=100.0), regularisation=st.FixedEpsilon(epsilon=1.0))
        if local.status != st.Status.Solved:
            continue
        sigma = local.B[:2] @ local.B[:2].T + THESIS["gamma"] * np.eye(2)
        e = samples - local.c[:2]
        inside |= np.einsum("ij,ij->i", e, np.linalg.solve(sigma, e.T).T) <= THRESHOLD
    return float(inside.mean())


def path(result: st.PlanResult) -> np.ndarray:
    """From the root to the node that is nearest to the goal."""
    node, nodes = int(np.argmin(np.linalg.norm(result.tree_errors, axis=1))), []
    while node >= 0:
        nodes.append(result.tree[node].q[:2])
        node = result.tree[node].parent
    return np.array(nodes)


def run(quick: bool) -> Result:
    seeds = range(2 if quick else 10)
    result = Result(
        "Settings of the published runs of PlanarHandFixedY (γ = 1e-6, length 0.2 rad, one step per extension, jumps to contact samples). Coverage is the packing ratio (3.9) with "
        f"η = {THRESHOLD:g} and how far the tree spreads in angle, at {NODES} nodes, mean over {len(seeds)} seeds. The ratio is given by the metric that a tree was grown with, and for all trees alike by the smoothed one. Under the exact scheme a node without contact has no reachable set at all.",
        settings={"nodes": NODES, "seeds": list(seeds)},
    )
    figure, axes = plt.subplots(2, 4, figsize=(10, 5.6), sharex=True, sharey=True)
    task = st.load_task("planar_hand_fixed_y")
    whole = st.plan(task, options=SETTINGS | {"max_iterations": 10000, "thesis": THESIS}, seed=0, timeout_s=120)
    nodes = len(whole.tree)
    for ax, count in zip(axes[0], (nodes // 8, nodes // 4, nodes // 2, nodes)):
        draw_tree(ax, whole, max(count, 2), f"{max(count, 2)} nodes")
    axes[0][-1].plot(*path(whole).T, color="C3", lw=1.5)
    result.add("a whole run reaches the goal", "yes", f"{whole.status.name}, {nodes} nodes", whole.status == st.Status.Solved, "the published script allows 2000 nodes")
    covered = {}
    for ax, (name, changes) in zip(axes[1], VARIANTS.items()):
        options = SETTINGS | {"max_iterations": 4 * NODES, "thesis": THESIS | changes | {"stop_at_goal": False}}
        trees = [st.plan(task, options=options, seed=seed, timeout_s=120) for seed in seeds]
        ratios = np.array([tree.packing_ratio(THRESHOLD)[:NODES][-1] for tree in trees])
        smoothed = np.array([coverage(task.model, tree) for tree in trees])
        widths = np.array([np.ptp(positions(tree)[:NODES, 1]) for tree in trees])
        covered[name] = smoothed.mean(), widths.mean()
        ours = f"packing ratio {number(ratios.mean())} by its own metric, {number(smoothed.mean())} by the smoothed one, spread {widths.mean():.2f} rad"
        result.add(f"{NODES} nodes, {name}", "shown only", ours)
        draw_tree(ax, trees[0], NODES, f"{NODES} nodes, {name}")
    for name, (ratio, width) in list(covered.items())[1:]:
        more = covered["ours"][0] > ratio, covered["ours"][1] > width
        ours = "yes" if all(more) else "no" if not any(more) else "by packing ratio only" if more[0] else "by spread only"
        result.add(f"covers more than: {name}", "yes", ours, all(more) or None)
    for ax in axes[-1]:
        ax.set_xlabel("z [m]")
    for row in axes:
        row[0].set_ylabel("θ [rad]")
    result.data["tree"] = {"z": positions(whole)[:, 0], "angle": positions(whole)[:, 1], "parent": np.array([n.parent for n in whole.tree])}
    result.draw("trees", figure, "Above: one run as it grows, with 1-sublevel sets of nodes; red: the path. Below: trees of 50 nodes. Square: start, star: goal.")
    return result
