"""Figure 3-2: tasks of trajectory optimisation, and where each scheme brings the object."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .planar import draw_object, draw_robot, finish
from .report import Result

TITLE = "Figure 3-2: where trajectory optimisation brings the object"
SCHEMES = ("analytic", "randomized-first", "randomized-zeroth", "exact")
TASKS = ("planar_pushing", "planar_hand", "allegro_ball")


def errors(task: st.Task, q: np.ndarray) -> tuple[float, float]:
    """Position [m] and angle [rad] between the object at q and the goal."""
    X_WB = task.model.object_pose(q, task.model.object_names[task.goal.object])
    X_WG = task.goal.X_WG
    cosine = (np.trace(np.asarray(X_WG.R).T @ np.asarray(X_WB.R)) - 1) / 2
    return float(np.linalg.norm(np.asarray(X_WB.p) - np.asarray(X_WG.p))), float(np.arccos(np.clip(cosine, -1, 1)))


def best(task: st.Task, scheme: str, quick: bool) -> st.OptimizeResult:
    seeds = range(1 if quick else 3) if scheme.startswith("randomized") else range(1)
    runs = [st.optimize(task, scheme=scheme, seed=seed, iterations=3 if quick else None, timeout_s=600) for seed in seeds]
    return min(runs, key=lambda run: run.cost.total)


def run(quick: bool) -> Result:
    names = TASKS[:2] if quick else TASKS
    result = Result(
        "Starts and goals of the tasks of figure 3-1, and the last configuration of the best run of each scheme. The thesis shows pictures only. On the planar hand the exact "
        "scheme starts without contact, and so without a gradient."
    )
    figure, axes = plt.subplots(2, len(names), figsize=(3 * len(names), 5), squeeze=False)
    for column, name in zip(axes.T, names):
        task = st.load_task(f"impc_{name}")
        start = errors(task, task.q_start)
        ends = {scheme: best(task, scheme, quick).q[-1] for scheme in SCHEMES}
        for scheme, q in ends.items():
            position, angle = errors(task, q)
            ours = f"{1e3 * position:.1f} mm, {angle:.3f} rad (start: {1e3 * start[0]:.0f} mm, {start[1]:.2f} rad)"
            result.add(f"{name}, {scheme}: from the goal", "shown only", ours)
        smoothed = [np.hypot(*errors(task, ends[scheme])) for scheme in SCHEMES[:3]]
        nearer = max(smoothed) < np.hypot(*start)
        result.add(f"{name}: every smoothed scheme ends nearer to the goal than it starts", "yes", "yes" if nearer else "no", nearer)
        column[0].set_title(name)
        if task.model.planar_axis is None:
            draw_errors(column, task, ends)
        else:
            draw_plane(column, name, task, ends)
    result.draw("ends", figure, "Above: start, and goal (thick); for the Allegro hand the errors at the end. Below: the last configuration of each scheme, the goal shaded.")
    return result


def draw_plane(column: np.ndarray, name: str, task: st.Task, ends: dict[str, np.ndarray]) -> None:
    X_WG = task.goal.X_WG
    goal = np.array([X_WG.p[1], X_WG.p[2], np.arctan2(X_WG.R[2][1], X_WG.R[1][1])])
    draw_robot(column[0], task.model, task.q_start)
    draw_object(column[0], name, task.q_start, ec="k")
    draw_object(column[0], name, goal, ec="C6", lw=2.5)
    draw_object(column[1], name, goal, fill=True, fc="C6", ec="C6", alpha=0.25)
    for i, (scheme, q) in enumerate(ends.items()):
        draw_object(column[1], name, q, ec=f"C{i}")
    for ax in column:
        finish(ax)


def draw_errors(column: np.ndarray, task: st.Task, ends: dict[str, np.ndarray]) -> None:
    values = np.array([errors(task, q) for q in ends.values()])
    for ax, row, unit in zip(column, values.T * [[1e3], [1]], ("mm", "rad")):
        ax.bar(range(len(row)), row, color=[f"C{i}" for i in range(len(row))])
        ax.set_xticks(range(len(row)), [s.replace("randomized", "rand.") for s in ends], fontsize=6)
        ax.set_ylabel(f"from the goal [{unit}]")
