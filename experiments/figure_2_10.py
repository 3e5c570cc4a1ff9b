"""Figures 2-9 to 2-12: an arm with a gripper puts one of ten boxes on a stack, quasi-static and second-order."""

from __future__ import annotations

import time

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number
from .systems import SCENES, solved

TITLE = "Figures 2-9 to 2-12: stacking boxes, 69 degrees of freedom"
MODELS = SCENES.parents[1] / "models"
BOX_PLACES = np.array(
    [
        [0.55, 0, 0.03],
        [0.70, 0, 0.04],
        [0.70, 0, 0.115],
        [0.70, 0, 0.19],
        [0.50, -0.2, 0.04],
        [0.50, -0.2, 0.115],
        [0.50, -0.2, 0.19],
        [0.45, 0.2, 0.04],
        [0.45, 0.2, 0.115],
        [0.48, 0.3, 0.04],
    ]
)
BOXES = len(BOX_PLACES)
CARRIED = 0  # the box that is moved
# Asked of the end of the motion, for every box and all steps up to LARGEST_GOOD_STEP.
TOLERANCE_M, TOLERANCE_RAD, LARGEST_GOOD_STEP = 5e-3, np.deg2rad(2.0), 0.1


def load_commands() -> tuple[np.ndarray, np.ndarray]:
    """Times of the knots [s] and commands (9, knots)."""
    table = np.loadtxt(MODELS / "stacking_commands.csv", delimiter=",", skiprows=1)
    return table[:, 0], table[:, 1:].T


def start(model: st.Model, commands: np.ndarray) -> np.ndarray:
    q = model.neutral()
    for box, place in enumerate(BOX_PLACES):
        q[7 * box : 7 * box + 3] = place
    q[-model.n_a :] = commands[:, 0]
    return q


def quasi_static(model: st.Model, h: float) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Times, configurations (n_q, n), mean time of a step [s] and mean number of contacts that carry force."""
    times, commands = load_commands()
    steps = round(times[-1] / h)
    grid = h * np.arange(steps + 1)
    q = np.empty((model.n_q, steps + 1))
    q[:, 0] = start(model, commands)
    work = st.StepWorkspace(model)
    active = 0
    started = time.perf_counter()
    for k in range(1, steps + 1):
        u = np.array([np.interp(grid[k], times, row) for row in commands])
        result = solved(st.step(model, q[:, k - 1], u, h=h, workspace=work))
        q[:, k] = result.q_next
        active += sum(contact.active for contact in result.contacts)
    return grid, q, (time.perf_counter() - started) / steps, active / steps


def second_order(model: st.Model, timestep: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, configurations and wall time [s]."""
    times, commands = load_commands()
    constant = max(2e-3, 10 * timestep)
    plant = st.Plant(model, timestep=timestep, time_constant=constant, friction_time_constant=10 * constant)
    result = st.simulate(plant, start(model, commands), times, commands, record_interval=0.01)
    if result.status != st.Status.Solved:
        raise RuntimeError(f"the simulation at h = {timestep} s ended with {result.message}")
    return result.times, result.q, result.wall_s


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between the orientations in two arrays of quaternions (4, n) [rad]."""
    return 2 * np.arccos(np.clip(np.abs(np.sum(a * b, axis=0)), 0, 1))


def box(q: np.ndarray, i: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (3, n) and quaternions (4, n)."""
    return q[7 * i : 7 * i + 3], q[7 * i + 3 : 7 * i + 7]


def mean_errors(times: np.ndarray, q: np.ndarray, reference_times: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """(2.18) of the carried box at the times of the coarser motion: mean distance [m] and angle [rad]."""
    nearest = np.clip(np.searchsorted(reference_times, times - 1e-9), 0, len(reference_times) - 1)
    p, r = box(q, CARRIED)
    p_ref, r_ref = box(reference[:, nearest], CARRIED)
    return float(np.mean(np.linalg.norm(p - p_ref, axis=0))), float(np.mean(angles(r, r_ref)))


def final_errors(q: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """Largest distance [m] and angle [rad] of any box at the end."""
    pairs = [(box(q[:, -1:], i), box(reference[:, -1:], i)) for i in range(BOXES)]
    return max(float(np.linalg.norm(a[0] - b[0])) for a, b in pairs), max(float(angles(a[1], b[1])[0]) for a, b in pairs)


def run(quick: bool) -> Result:
    model = st.load_model(MODELS / "stacking.yaml")
    reference_step = 8e-4 if quick else 5e-5
    steps = [0.1] if quick else [0.01, 0.02, 0.05, 0.1, 0.2, 0.5]
    times_ref, reference, wall = second_order(model, reference_step)
    motions = {h: quasi_static(model, h) for h in steps}
    mean = np.array([mean_errors(*motions[h][:2], times_ref, reference) for h in steps])
    final = np.array([final_errors(motions[h][1], reference) for h in steps])

    result = Result(
        "An iiwa 7 with a gripper lifts a box, turns it by 90°, puts it on a stack of three and retreats; six more boxes stand by. Robots and boxes are described in "
        f"`models/stacking.yaml`, commands in `models/stacking_commands.csv`. Reference: MuJoCo at h = {reference_step:g} s. Errors are those of the carried box, averaged over the 20 s "
        "of the motion (2.18); the final ones are the worst of all ten boxes. Published waypoints are lowered by 47 mm, where the pads of this gripper meet the box.",
        settings={"h": steps, "reference_h": reference_step},
    )
    _, _, seconds, active = motions[0.1]
    good = np.array(steps) <= LARGEST_GOOD_STEP + 1e-9
    result.add("degrees of freedom", "69", str(model.n_v), model.n_v == 69)
    result.add("contacts that carry force, mean over the steps", "56", f"{active:.0f}", None, "faces touch in four points; the thesis has corner balls besides")
    result.add("time of a step at h = 0.1 s, called from Python", "< 10 ms (solver alone)", f"{1e3 * seconds:.2f} ms", seconds < 10e-3)
    result.add("all boxes at the end, steps up to 0.1 s: distance to the reference", "same stack", f"{1e3 * final[good, 0].max():.2f} mm", final[good, 0].max() <= TOLERANCE_M, "asked: 5 mm")
    result.add("all boxes at the end, steps up to 0.1 s: angle to the reference", "same stack", f"{np.rad2deg(final[good, 1].max()):.2f}°", final[good, 1].max() <= TOLERANCE_RAD, "asked: 2°")
    result.add("the box stands on the stack at every step", "yes", ", ".join(f"{1e3 * motions[h][1][2, -1]:.1f} mm" for h in steps), all(abs(motions[h][1][2, -1] - 0.26) < 2e-3 for h in steps), "height of its centre; 260 mm")
    result.add("mean error of the box over its motion", "below 5 mm at small h", ", ".join(f"{1e3 * e:.2f} mm" for e in mean[:, 0]), None, "at h = " + ", ".join(number(h) for h in steps) + " s")
    result.add("mean angular error", "–", ", ".join(f"{np.rad2deg(e):.2f}°" for e in mean[:, 1]), None)
    draw(result, steps, mean, motions, times_ref, reference)
    result.data["errors"] = {"h_s": steps, "mean_m": mean[:, 0], "mean_rad": mean[:, 1], "final_m": final[:, 0], "final_rad": final[:, 1]}
    result.settings["reference_wall_s"] = round(wall, 1)
    return result


def draw(result: Result, steps: list[float], mean: np.ndarray, motions: dict, times_ref: np.ndarray, reference: np.ndarray) -> None:
    if len(steps) > 1:
        figure, axes = plt.subplots(1, 2, figsize=(6, 2.4))
        axes[0].loglog(steps, 1e3 * mean[:, 0], "o-", ms=4)
        axes[0].set_ylabel("mean error [mm]")
        axes[1].loglog(steps, np.rad2deg(mean[:, 1]), "o-", ms=4)
        axes[1].set_ylabel("mean error [°]")
        for axis in axes:
            axis.set_xlabel("step h [s]")
        result.draw("errors", figure, "Figure 2-10: error of the carried box against the second-order reference.")
    figure, axes = plt.subplots(2, 2, figsize=(6, 3.6), sharex=True)
    shown = [h for h in (0.01, 0.1, 0.5) if h in motions]
    every = max(1, len(times_ref) // 200)
    for axis, label, value in (
        (axes[0, 0], "x [m]", lambda q: q[0]),
        (axes[0, 1], "y [m]", lambda q: q[1]),
        (axes[1, 0], "z [m]", lambda q: q[2]),
        (axes[1, 1], "turned by [°]", lambda q: np.rad2deg(angles(q[3:7], q[3:7, :1]))),
    ):
        axis.plot(times_ref[::every], value(reference[:7])[::every], "k-", lw=2.5, alpha=0.3, label="second order")
        for h in shown:
            thin = max(1, len(motions[h][0]) // 200)
            axis.plot(motions[h][0][::thin], value(motions[h][1][:7])[::thin], lw=1, label=f"quasi-static, h = {h:g} s")
        axis.set_ylabel(label)
    axes[0, 0].legend(fontsize=6)
    for axis in axes[1]:
        axis.set_xlabel("time [s]")
    result.draw("motion", figure, "Figure 2-12: the carried box.")
