"""Figures 2-9 to 2-12: an arm with a gripper puts one of ten boxes on a stack, quasi-static and second-order."""

from __future__ import annotations

import time

import matplotlib.pyplot as plt
import numpy as np
import stiction as st
import yaml
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from . import drake_plant
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
FIRM_STEP = 0.02  # [s]
FINAL_STEPS = (0.01, 0.1, 0.5)  # of figure 2-11
CARRIED = 0  # the box that is moved
HEIGHT_ON_STACK = 0.26  # of its centre in the end [m]
SAP_DAMPING = np.array([100, 100, 100, 100, 1, 1, 1, 20, 20])  # [N m s/rad, N s/m]
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
    """Times, configurations (n_q, n), median time of a step [s] and mean number of contacts that carry force."""
    times, commands = load_commands()
    steps = round(times[-1] / h)
    grid = h * np.arange(steps + 1)
    q = np.empty((model.n_q, steps + 1))
    q[:, 0] = start(model, commands)
    work = st.StepWorkspace(model)
    active = 0
    seconds = []
    for k in range(1, steps + 1):
        u = np.array([np.interp(grid[k], times, row) for row in commands])
        started = time.perf_counter()
        result = solved(st.step(model, q[:, k - 1], u, h=h, workspace=work))
        seconds.append(time.perf_counter() - started)
        q[:, k] = result.q_next
        active += sum(contact.active for contact in result.contacts)
    return grid, q, float(np.median(seconds)), active / steps


def second_order(model: st.Model, timestep: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, configurations and wall time [s]."""
    times, commands = load_commands()
    constant = max(2e-3, 10 * timestep)
    plant = st.Plant(model, timestep=timestep, time_constant=constant, friction_time_constant=10 * constant)
    result = st.simulate(plant, start(model, commands), times, commands.T, record_interval=0.01)
    if result.status != st.Status.Solved:
        raise RuntimeError(f"the simulation at h = {timestep} s ended with {result.message}")
    return result.times, result.q.T, result.wall_s


def sap(h: float, near_rigid: float = 1.0) -> tuple[np.ndarray, np.ndarray, float]:
    """The same by Drake's SAP with the damping of the thesis."""
    times, commands = load_commands()
    plant = drake_plant.DrakePlant(MODELS / "stacking.yaml", h, SAP_DAMPING, near_rigid)
    started = time.perf_counter()
    motion = plant.simulate(start(plant.library, commands), times, commands, record_interval=0.01)
    return motion.times, motion.q, time.perf_counter() - started


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
    result.add("median time of a step at h = 0.1 s, called from Python", "< 10 ms (solver alone)", f"{1e3 * seconds:.2f} ms", seconds < 10e-3)
    result.add("all boxes at the end, steps up to 0.1 s: distance to the reference", "same stack", f"{1e3 * final[good, 0].max():.2f} mm", final[good, 0].max() <= TOLERANCE_M, "asked: 5 mm")
    result.add("all boxes at the end, steps up to 0.1 s: angle to the reference", "same stack", f"{np.rad2deg(final[good, 1].max()):.2f}°", final[good, 1].max() <= TOLERANCE_RAD, "asked: 2°")
    result.add("the box stands on the stack at every step", "yes", ", ".join(f"{1e3 * motions[h][1][2, -1]:.1f} mm" for h in steps), all(abs(motions[h][1][2, -1] - HEIGHT_ON_STACK) < 2e-3 for h in steps), "height of its centre; 260 mm")
    result.add("mean error of the box over its motion", "below 5 mm at small h", ", ".join(f"{1e3 * e:.2f} mm" for e in mean[:, 0]), None, "at h = " + ", ".join(number(h) for h in steps) + " s")
    result.add("mean angular error", "–", ", ".join(f"{np.rad2deg(e):.2f}°" for e in mean[:, 1]), None)
    result.data["errors"] = {"h_s": steps, "mean_m": mean[:, 0], "mean_rad": mean[:, 1], "final_m": final[:, 0], "final_rad": final[:, 1]}
    result.settings["reference_wall_s"] = round(wall, 1)
    curves = {"quasi-static": (steps, mean)}
    finals = {f"quasi-static, h = {h:g} s": motions[h][1][:, -1] for h in FINAL_STEPS if h in motions}
    if drake_plant.is_available():
        sap_steps, sap_mean, sap_finals = add_sap(result, quick, motions, times_ref, reference)
        curves["second order (SAP)"] = (sap_steps, sap_mean)
        finals = sap_finals | finals
    else:
        result.add("second order by SAP", "sinks from h = 0.01 s on", "–", None, drake_plant.MISSING)
    if len(steps) > 1:
        draw_errors(result, curves)
    draw_finals(result, finals, len([h for h in FINAL_STEPS if h in motions]))
    draw_motion(result, motions, times_ref, reference)
    return result


def add_sap(result: Result, quick: bool, motions: dict, times_ref: np.ndarray, reference: np.ndarray) -> tuple[list[float], np.ndarray, dict]:
    """Steps, mean errors and final configurations of SAP, against its own motion at a small step; ours against the same."""
    reference_step = 0.005 if quick else 5e-4
    steps = [0.1] if quick else [0.005, 0.01, 0.02, 0.05, 0.1, 0.5]
    truth_times, truth, wall = sap(reference_step)
    found = {h: sap(h)[:2] for h in steps}
    mean = np.array([mean_errors(*found[h], truth_times, truth) for h in steps])
    final = np.array([final_errors(found[h][1], truth) for h in steps])
    ours = np.array([mean_errors(*motions[h][:2], truth_times, truth) for h in motions])
    apart = mean_errors(truth_times, truth, times_ref, reference)
    result.settings |= {"sap_h": steps, "sap_reference_h": reference_step, "sap_damping": SAP_DAMPING.tolist(), "sap_reference_wall_s": round(wall, 1)}
    result.data["errors_sap"] = {"h_s": steps, "mean_m": mean[:, 0], "mean_rad": mean[:, 1], "final_m": final[:, 0], "final_rad": final[:, 1]}

    at = "at h = " + ", ".join(number(h) for h in steps) + " s"
    coarse = [h for h in steps if h >= 0.05 and h in motions]
    result.add(f"SAP at h = {reference_step:g} s against MuJoCo: mean distance and angle of the box", "–", f"{1e3 * apart[0]:.2f} mm, {np.rad2deg(apart[1]):.2f}°", None, "lag of the published damping of the arm; MuJoCo's is critical")
    result.add("quasi-static against SAP: mean error of the box", "small up to 0.1 s", ", ".join(f"{1e3 * e:.2f} mm" for e in ours[:, 0]), None, "at h = " + ", ".join(number(h) for h in motions) + " s")
    end = np.array([final_errors(motions[h][1], truth) for h in motions if h <= LARGEST_GOOD_STEP + 1e-9]).max(axis=0)
    result.add("all boxes at the end, steps up to 0.1 s: distance and angle to SAP", "same stack", f"{1e3 * end[0]:.2f} mm, {np.rad2deg(end[1]):.2f}°", bool(np.all(end <= (TOLERANCE_M, TOLERANCE_RAD))), "asked: 5 mm, 2°")
    result.add("SAP: mean error of the box", "large from h = 0.01 s on", ", ".join(f"{1e3 * e:.3g} mm" for e in mean[:, 0]), None, f"{at}, against SAP at {reference_step:g} s")
    result.add(
        "SAP: height of the box in the end",
        "boxes sink into each other and the ground",
        ", ".join(f"{1e3 * found[h][1][2, -1]:.0f} mm" for h in steps),
        all(found[h][1][2, -1] < HEIGHT_ON_STACK - 2e-3 for h in steps if h >= 0.01),
        f"{at}; from 0.05 s on the stack falls",
    )
    firm = sap(FIRM_STEP, near_rigid=0.01)[1]
    result.add(
        f"the same at h = {FIRM_STEP:g} s where SAP's limit of the stiffness is lifted (β = 0.01 instead of 1, Castro et al. 2021, V.B)",
        "–",
        f"{1e3 * firm[2, -1]:.1f} mm",
        abs(firm[2, -1] - HEIGHT_ON_STACK) < 2e-3,
        "so it is this limit, of about 1/h², that lets contacts yield",
    )
    result.add(
        "quasi-static against SAP at the same h ≥ 0.05 s: mean error of the box",
        "smaller",
        ", ".join(f"{1e3 * mean_errors(*motions[h][:2], truth_times, truth)[0]:.2f} / {1e3 * mean[steps.index(h), 0]:.0f} mm" for h in coarse),
        all(mean_errors(*motions[h][:2], truth_times, truth)[0] < mean[steps.index(h), 0] for h in coarse),
    )
    return steps, mean, {f"SAP, h = {h:g} s": found[h][1][:, -1] for h in FINAL_STEPS if h in found}


def draw_errors(result: Result, curves: dict[str, tuple[list[float], np.ndarray]]) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(6, 2.4))
    for label, (steps, mean) in curves.items():
        axes[0].loglog(steps, 1e3 * mean[:, 0], "o-", ms=4, label=label)
        axes[1].loglog(steps, np.rad2deg(mean[:, 1]), "o-", ms=4)
    axes[0].set_ylabel("mean error [mm]")
    axes[1].set_ylabel("mean error [°]")
    axes[0].legend(fontsize=7)
    for axis in axes:
        axis.set_xlabel("step h [s]")
    result.draw("errors", figure, "Figure 2-10: error of the carried box, each against its own second-order reference.")


def draw_finals(result: Result, finals: dict[str, np.ndarray], columns: int) -> None:
    """Figure 2-11: outlines of the boxes in the plane of y and z."""
    rows = len(finals) // columns
    figure, axes = plt.subplots(rows, columns, figsize=(2 * columns, 1.5 * rows), squeeze=False, sharex=True, sharey=True)
    sizes = [item["shapes"][0]["box"]["size"] for item in yaml.safe_load((MODELS / "stacking.yaml").read_text(encoding="utf-8"))["objects"]]
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    for axis, (title, q) in zip(axes.flat, finals.items(), strict=True):
        for i in range(BOXES):
            p, xyzw = box(q, i)
            side = np.array(p + Rotation.from_quat(xyzw).apply(corners * sizes[i]))[:, 1:]
            outline = side[ConvexHull(side).vertices]
            axis.fill(*outline.T, facecolor="C3" if i == CARRIED else "0.8", edgecolor="k", lw=0.6, alpha=0.7)
        axis.axhline(0, color="k", lw=1)
        axis.set_aspect("equal")
        axis.set_xlim(-0.28, 0.38)
        axis.set_ylim(-0.06, 0.31)
        axis.set_title(title, fontsize=7)
        axis.grid(False)
    result.draw("finals", figure, "Figure 2-11: the boxes at the end, seen along the x axis; the carried one is red.")


def draw_motion(result: Result, motions: dict, times_ref: np.ndarray, reference: np.ndarray) -> None:
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
