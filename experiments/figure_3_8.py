"""Figure 3-8: plans of the quasi-static model, run open loop in a second-order simulation."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number

TITLE = "Figure 3-8: transfer of plans to a second-order simulation"
SEGMENTS = 10  # at least, of each system
MAX_SEEDS = 12
MAX_UNSOLVED = 2  # seeds in a row, after which a task is left out
TIMEOUT_S = 20  # of the planner
MODELS = (("sub-steps", None), ("one step per edge", 1))
LEAST_LENGTH = 5e-3  # [m, rad] a segment that hardly moves the object says nothing about the model


def systems(quick: bool) -> list[str]:
    """Tasks with a floor or a palm as they are; their variants for published timings are not executed."""
    names = [name for name in st.list_tasks() if "table_3_2" not in name and not name.startswith("impc_")]
    return [name for name in names if name in ("planar_hand", "planar_pushing")] if quick else names


def free(task: st.Task) -> bool:
    """The first object moves in space, not on a joint: its configuration has a quaternion."""
    return task.model.n_q != task.model.n_v


def collect(name: str, quick: bool) -> list[dict[str, np.ndarray]]:
    """Per model (rows: segments; Δ and L of position and angle)."""
    rows: list[list[list[float]]] = [[] for _ in MODELS]
    unsolved = 0
    task = st.load_task(name)
    for seed in range(2 if quick else MAX_SEEDS):
        result = st.plan(task, seed=seed, timeout_s=TIMEOUT_S)
        unsolved = 0 if result.status == st.Status.Solved else unsolved + 1
        if unsolved == MAX_UNSOLVED:
            break
        if unsolved:
            continue
        for table, (_, substeps) in zip(rows, MODELS):
            execution = {"velocity_reference": False, "uniform": st.SpeedLimits(load_time=0, **({"revolute": 0.4, "prismatic": 0.05, "pause": 0.3} if quick else {}))}
            run = st.transfer(result.plan, substeps=substeps, whole=False, **execution)
            for piece in run.pieces:
                if (e := piece.alone) is not None:
                    table.append([e.mean_position, e.length_position, e.mean_angle, e.length_angle])
        if sum(max(row[1], row[3]) > LEAST_LENGTH for row in rows[0]) >= SEGMENTS:
            break
    names = ("mean_position", "length_position", "mean_angle", "length_angle")
    return [dict(zip(names, np.array(table).reshape(-1, 4).T)) for table in rows]


def normalised(table: dict[str, np.ndarray], kind: str) -> np.ndarray:
    moves = table[f"length_{kind}"] > LEAST_LENGTH
    return table[f"mean_{kind}"][moves] / table[f"length_{kind}"][moves]


def median(values: np.ndarray) -> str:
    return number(float(np.median(values))) if len(values) else "–"


def run(quick: bool) -> Result:
    names = systems(quick)
    found = {name: collect(name, quick) for name in names}
    tables = {name: table for name, table in found.items() if len(table[0]["mean_angle"])}
    result = Result(
        "Every plan is cut at its regrasps, and every segment starts at rest from the planned state. Joints move at 0.1 rad/s or 0.0125 m/s, commands are held for a "
        "moment after each segment, nothing is fed back. Δ is the mean error (3.10), L the length of the planned path (3.12), Δ/L (3.11). The same commands and the same simulation are compared "
        "with two models: exact steps in sub-steps as planned here, and one step per extension of the tree as in the thesis. Objects on joints come to rest within 50 ms, as on a table. Whole plans: `bench/transfer.py`, docs/theory/execution.md.",
        settings={"tasks": names, "least_length": LEAST_LENGTH},
    )
    for name in names:
        if name not in tables:
            result.add(f"{name}: segments", "≥ 10", "0", None if quick else False, f"no plan in {TIMEOUT_S} s, {MAX_UNSOLVED} seeds")
            continue
        fine, coarse = tables[name]
        count = int(np.sum(np.maximum(fine["length_position"], fine["length_angle"]) > LEAST_LENGTH))
        result.add(f"{name}: segments", "≥ 10", str(count), None if quick else count >= SEGMENTS)
        for kind, unit in (("position", "m/m"), ("angle", "rad/rad")):
            ours, theirs = normalised(fine, kind), normalised(coarse, kind)
            result.add(f"{name}: median Δ/L of {kind} [{unit}]", "plotted only", f"{median(ours)} (sub-steps), {median(theirs)} (one step)")
    judge(result, tables)
    draw(result, tables)
    for name in tables:
        for (label, _), table in zip(MODELS, tables[name]):
            result.data[f"{name}_{label.replace(' ', '_').replace('-', '_')}"] = table
    return result


def judge(result: Result, tables: dict) -> None:
    def pooled(names: list[str], model: int, kind: str) -> np.ndarray:
        return np.concatenate([normalised(tables[n][model], kind) for n in names]) if names else np.array([])

    planar = [n for n in tables if not free(st.load_task(n))]
    space = [n for n in tables if n not in planar]
    if planar:
        fine, coarse = (np.median(pooled(planar, model, "angle")) for model in (0, 1))
        result.add("planar systems, median Δ/L of orientation", "low", f"{fine:.3f} (sub-steps), {coarse:.3f} (one step)", fine < 0.25, "below 0.25")
    if planar and space:
        for kind in ("position", "angle"):
            a, b = np.median(pooled(planar, 0, kind)), np.median(pooled(space, 0, kind))
            result.add(f"systems in space transfer worse: median Δ/L of {kind}", "yes", f"{a:.3f} in a plane, {b:.3f} in space", None)


def draw(result: Result, tables: dict) -> None:
    names = list(tables)
    figure, axes = plt.subplots(len(names), 4, figsize=(9, 1.9 * len(names)), squeeze=False)
    for row, name in zip(axes, names):
        for column, (kind, scale, unit) in enumerate((("position", 1e3, "mm"), ("angle", 1.0, "rad"))):
            for (label, _), table, marker in zip(MODELS, tables[name], ("o", "x")):
                row[column].plot(scale * table[f"length_{kind}"], scale * table[f"mean_{kind}"], marker, ms=3.5, label=label)
            row[column].set_xlabel(f"path length [{unit}]")
            row[column].set_ylabel(f"Δ [{unit}]")
            values = [normalised(table, kind) for table in tables[name]]
            row[2 + column].boxplot(values, widths=0.5, showmeans=True, showfliers=False)
            row[2 + column].set_xticklabels(["sub-steps", "one step"], fontsize=7)
            row[2 + column].set_ylabel(f"Δ/L, {kind}")
        row[0].set_title(name, loc="left", fontsize=9)
    axes[0, 0].legend(fontsize=6)
    result.draw("transfer", figure, "Left: mean error over path length, one mark per segment. Right: normalised errors; the triangle is the mean.")
