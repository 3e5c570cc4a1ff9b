"""Section 3.4.5: what refining a path makes of its length, its time and its gaps."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .growth import SYSTEMS
from .report import Result, number

TITLE = "Section 3.4.5: paths before and after refinement"
SEEDS = 3
TIMEOUT_S = 30
FIGURES = ("length", "joints", "time", "gap")


def object_length(plan: st.Plan) -> float:
    """(3.12) of all objects, metres and radians alike, as in the distance of figure 3-6."""
    model = plan.task.model
    bodies = [i for i, body in enumerate(model.bodies) if body.kind == st.BodyKind.Object]
    poses = [[model.calc_kinematics(q).X_WB[i] for i in bodies] for q in plan.q]
    return sum(float(np.linalg.norm(b.p - a.p)) + angle_between(a.R, b.R) for before, after in zip(poses, poses[1:]) for a, b in zip(before, after))


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arccos(np.clip((np.trace(np.asarray(a).T @ np.asarray(b)) - 1) / 2, -1, 1)))


def measure(plan: st.Plan) -> np.ndarray:
    """Length of the objects' and of the joints' path, time of the motion at the default speed, and the largest gap under force."""
    joints = plan.q[:, plan.task.model.n_q - plan.task.model.n_a :]
    gap = st.check_plan(plan).at("force_gap").value
    return np.array([object_length(plan), np.abs(np.diff(joints, axis=0)).sum(), st.make_trajectory(plan).duration, gap])


def run(quick: bool) -> Result:
    names = ("planar_pushing", "planar_hand") if quick else tuple(SYSTEMS)
    seeds = range(1 if quick else SEEDS)
    result = Result(
        "Plans of the six tasks before and after `stiction refine` (docs/theory/refinement.md), mean of the seeds that are solved. The thesis has no numbers. "
        "Beside them is the path of Algorithm 2 as printed, with its large steps and jumps, where it reaches the goal.\n\n"
        "* **Length** is that of the objects (3.12), metres and radians alike.\n* **Joints** is the sum over all joints.\n* **Time** is that of the motion at the "
        "default speed.\n* **Gap** is the largest distance at which a force acts when the plan is replayed in half steps, in hundredths of the object's size. "
        "Anitescu's relaxation leaves so much of Coulomb's law.",
        settings={"seeds": list(seeds)},
    )
    means, printed = {}, {}
    for name in names:
        task = st.load_task(name)
        rows = []
        for seed in seeds:
            found = st.plan(task, seed=seed, timeout_s=TIMEOUT_S)
            if found.status != st.Status.Solved:
                continue
            refined = st.refine(found.plan, timeout_s=TIMEOUT_S)
            rows.append([measure(found.plan), measure(refined.plan)])
        if not rows:
            result.add(f"{name}: plans", "–", f"none in {TIMEOUT_S} s, {len(seeds)} seeds")
            continue
        means[name] = before, after = np.mean(rows, axis=0)
        texts = [f"{label} {number(a)} → {number(b)}" for label, a, b in zip(("length", "joints", "time [s]", "gap"), before, after)]
        note = f"{len(rows)} of {len(seeds)} seeds"
        if (path := path_as_printed(name)) is not None:
            printed[name] = path
            note += f"; path of Algorithm 2: length {number(path[0])}, gap {number(path[1])}"
        result.add(f"{name}: before → after", "shown only", ", ".join(texts), note=note)
    judge(result, means, printed)
    draw(result, means)
    result.data["refinement"] = {f"{label}_{when}": np.array([pair[i][k] for pair in means.values()]) for k, label in enumerate(FIGURES) for i, when in enumerate(("before", "after"))}
    return result


def path_as_printed(name: str) -> tuple[float, float] | None:
    """Length of the objects' path and gap under force of Algorithm 2; None where it does not reach the goal."""
    found = st.plan(st.load_task(f"{name}_table_3_2"), seed=0, timeout_s=TIMEOUT_S)
    return (object_length(found.plan), st.check_plan(found.plan).at("force_gap").value) if found.status == st.Status.Solved else None


def judge(result: Result, means: dict[str, tuple[np.ndarray, np.ndarray]], printed: dict[str, tuple[float, float]]) -> None:
    claims = {"shorter: the objects": 0, "shorter: the joints": 1, "shorter: the time of the motion": 2, "more realistic: the gap under force": 3}
    for claim, k in claims.items():
        add_claim(result, claim, {name: after[k] / before[k] for name, (before, after) in means.items()})
    against = {name: (means[name][1][0] / length, means[name][1][3] / gap) for name, (length, gap) in printed.items()}
    add_claim(result, "shorter than the path of Algorithm 2: the objects", {name: ratios[0] for name, ratios in against.items()})
    add_claim(result, "more realistic than the path of Algorithm 2: the gap under force", {name: ratios[1] for name, ratios in against.items()})


def add_claim(result: Result, claim: str, ratios: dict[str, float]) -> None:
    """After over before is below one on every task, or the row says where it is not."""
    if not ratios:
        return
    count = sum(ratio < 1 for ratio in ratios.values())
    ours = f"{'' if count == len(ratios) else 'differs: '}on {count} of {len(ratios)} tasks"
    result.add(claim, "yes", ours, count == len(ratios) or None, ", ".join(f"{name} {number(ratio)} times" for name, ratio in ratios.items()))


def draw(result: Result, means: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
    figure, ax = plt.subplots(figsize=(5.5, 2.6))
    for k, label in enumerate(FIGURES):
        ax.bar(np.arange(len(means)) + 0.2 * k, [after[k] / max(before[k], 1e-12) for before, after in means.values()], 0.18, label=label)
    ax.axhline(1, color="0.5", lw=0.8)
    ax.set_yscale("log")
    ax.set_xticks(np.arange(len(means)) + 0.3, list(means), fontsize=7)
    ax.set_ylabel("after / before")
    ax.legend(fontsize=7)
    result.draw("refinement", figure, "What refinement leaves of the lengths, the time and the gap of a plan.")
