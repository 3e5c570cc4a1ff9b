"""Section 3.6.2: does the object lag behind its plan while the robot accelerates, and lead while it decelerates?"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st
from scipy.spatial.transform import Rotation

from .report import Result, number

TITLE = "Section 3.6.2: the phase between plan and simulation"
TASKS = ("planar_pushing", "planar_hand", "iiwa_bimanual_planar", "allegro_ball", "allegro_pen", "allegro_door")
SEEDS = 2
PUSHES = 6  # of a plan, at most
WINDOW = 5  # samples of 20 ms over which speeds are taken
LEAST_SHARE = 0.1  # of the largest acceleration of the joints, and of the fastest motion of the object: less is neither


def poses(model: st.Model, configurations: np.ndarray) -> tuple[np.ndarray, Rotation]:
    body = next(i for i, body in enumerate(model.bodies) if body.kind == st.BodyKind.Object)
    found = [model.calc_kinematics(q).X_WB[body] for q in configurations]
    return np.array([X.p for X in found]), Rotation.from_matrix(np.array([X.R for X in found]))


def along_path(model: st.Model, run: st.TransferResult) -> tuple[np.ndarray, np.ndarray]:
    """How far the object is ahead of its plan along the plan's own direction (metres and radians alike), and the planned speed there."""
    p, R = poses(model, run.q)
    p_plan, R_plan = poses(model, run.q_plan)
    ahead = np.hstack([p - p_plan, (R * R_plan.inv()).as_rotvec()])
    motion = np.zeros_like(ahead)
    motion[WINDOW:-WINDOW, :3] = p_plan[2 * WINDOW :] - p_plan[: -2 * WINDOW]
    motion[WINDOW:-WINDOW, 3:] = (R_plan[2 * WINDOW :] * R_plan[: -2 * WINDOW].inv()).as_rotvec()
    speed = np.linalg.norm(motion, axis=1)
    last = np.maximum.accumulate(np.where(speed > LEAST_SHARE * speed.max(), np.arange(len(speed)), 0))  # a plan that stands still keeps its last direction
    direction = motion[last] / np.maximum(np.linalg.norm(motion[last], axis=1, keepdims=True), 1e-12)
    return np.sum(ahead * direction, axis=1), speed


def acceleration(model: st.Model, run: st.TransferResult) -> np.ndarray:
    """Of the simulated joints: change of their speed."""
    joints = run.q[:, model.n_q - model.n_a :]
    out = np.zeros(len(joints))
    speed = np.linalg.norm(joints[WINDOW:] - joints[:-WINDOW], axis=1)
    out[WINDOW : len(speed)] = speed[WINDOW:] - speed[:-WINDOW]
    return out


def collect(name: str, quick: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Per push: lead over time, and −1, 0, 1 where the robot decelerates, does neither, accelerates."""
    task = st.load_task(name)
    out = []
    for seed in range(1 if quick else SEEDS):
        found = st.plan(task, seed=seed, timeout_s=20)
        if found.status != st.Status.Solved:
            continue
        run = st.transfer(found.plan, whole=False, speed=20.0)
        pushes = [piece for piece in run.pieces if piece.kind == st.SegmentKind.Contact][: 1 if quick else PUSHES]
        for piece in pushes:
            part = found.plan[piece.first_segment : piece.last_segment + 1]
            limits = st.SpeedLimits(load_time=0, pause=0.3, **({"revolute": 0.4} if quick else {}))
            alone = st.transfer(part, whole=True, alone=False, velocity_reference=False, hold=0.5, uniform=limits)
            if alone.status != st.Status.Solved or len(alone.times) < 6 * WINDOW:
                continue
            lead, _ = along_path(task.model, alone)
            rate = acceleration(task.model, alone)
            out.append((lead, np.sign(rate) * (np.abs(rate) > LEAST_SHARE * np.abs(rate).max())))
    return out


def run(quick: bool) -> Result:
    names = ("planar_hand",) if quick else TASKS
    result = Result(
        "Every push alone from its planned state, with the commands and the simulation of figure 3-8. The lead is how far the object is ahead of the plan in the direction in which the plan moves it, metres and radians alike; "
        "a lag is below zero. The robot accelerates where the speed of the simulated joints rises. Means over the samples of all pushes. In the model of the simulation objects come to rest within 50 ms and joints lag behind their commands.",
        settings={"tasks": list(names), "window_s": 0.02 * WINDOW},
    )
    means = {}
    shown: tuple[np.ndarray, np.ndarray] | None = None
    for name in names:
        found = collect(name, quick)
        if not found:
            result.add(f"{name}: pushes", "–", "none")
            continue
        shown = shown or found[-1]
        lead, phase = (np.concatenate(part) for part in zip(*found))
        faster, slower = (1e3 * float(lead[phase == sign].mean()) for sign in (1, -1))
        means[name] = faster, slower
        ours = f"{number(faster)} while accelerating, {number(slower)} while decelerating, {number(1e3 * float(lead.mean()))} on the whole"
        result.add(f"{name}: mean lead [mm, mrad]", "shown only", ours, note=f"{len(found)} pushes")
    judge(result, means)
    if shown is not None:
        draw(result, *shown)
    return result


def judge(result: Result, means: dict[str, tuple[float, float]]) -> None:
    claims = {
        "lags while the robot accelerates": lambda faster, slower: faster < 0,
        "leads while the robot decelerates": lambda faster, slower: slower > 0,
        "is further ahead while the robot decelerates than while it accelerates": lambda faster, slower: slower > faster,
    }
    for claim, holds in claims.items():
        names = [name for name, pair in means.items() if holds(*pair)]
        ours = f"{'' if len(names) == len(means) else 'differs: '}on {len(names)} of {len(means)} tasks"
        thesis = "on all systems" if "further" not in claim else "follows from both"
        result.add(f"the object {claim}", thesis, ours, len(names) == len(means) or None, "" if len(names) == len(means) else "not " + ", ".join(sorted(set(means) - set(names))))


def draw(result: Result, lead: np.ndarray, phase: np.ndarray) -> None:
    figure, ax = plt.subplots(figsize=(5.5, 2.4))
    times = 0.02 * np.arange(len(lead))
    ax.plot(times, 1e3 * lead, lw=1, color="0.4")
    for sign, label, colour in ((1, "accelerates", "C3"), (-1, "decelerates", "C0")):
        ax.plot(times[phase == sign], 1e3 * lead[phase == sign], ".", ms=3, color=colour, label=label)
    ax.axhline(0, color="0.7", lw=0.8)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("lead [mm, mrad]")
    ax.legend(fontsize=7)
    result.draw("lead", figure, "Lead of the object over one push.")
    result.data["lead"] = {"time_s": times, "lead": lead, "phase": phase}
