"""Figure 1-1 (c, d) and (1.1): a box pushed by a ball on a rail, its modes, smoothing, and a descent that stays on its side."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st
import yaml

from .report import Result
from .systems import SCENES, solved

TITLE = "Figure 1-1 and (1.1): pushing a box with a ball"
SIDES = {"left": 1.0, "right": -1.0}  # where the ball is, and the direction in which it can push
RIGHT_BASE = 0.1  # of the ball's rail [m]: the ball then touches the right face where both coordinates are equal
KAPPAS = (20.0, 100.0)  # of the dashed lines
START_GAP = 0.1  # [m]
GOAL = 0.15  # from the box [m]
STEPS = 300
FIRST_KAPPA, LAST_KAPPA = 20.0, 1e6
STIFFNESS = 100.0  # of the ball's spring [N/m]
RESISTANCE = 0.01  # of the box over that stiffness: next to nothing, as at the steady state of (1.1)
STEADY = st.FixedEpsilon(epsilon=RESISTANCE * STIFFNESS * 0.1**2)  # ε m/h² with m = 1 kg and h = 0.1 s


def load_side(side: str) -> st.Model:
    scene = yaml.safe_load((SCENES / "ball_and_box.yaml").read_text(encoding="utf-8"))["scene"]
    if side == "right":
        scene["robots"][0]["base"]["position"][0] = RIGHT_BASE
    return st.load_model(scene, base=SCENES)


def next_box(model: st.Model, q_a: float, u: float, kappa: float | None = None) -> tuple[float, float, float]:
    """Next position of the box that starts at 0, its derivative by u, and the impulse between both."""
    smoothing = {} if kappa is None else {"smoothing": st.Analytic(kappa=kappa)}
    out = solved(st.step(model, [0.0, q_a], [u], with_B=True, regularisation=STEADY, **smoothing))
    return float(out.q_next[0]), float(out.B[0, 0]), sum(float(np.linalg.norm(contact.lambda_)) for contact in out.contacts)


def descend(model: st.Model, q_a: float, goal: float) -> np.ndarray:
    """(1.2) with smoothing that fades: commands from the first guess u = q_a on."""
    commands = [q_a]
    for kappa in np.geomspace(FIRST_KAPPA, LAST_KAPPA, STEPS):
        box, slope, _ = next_box(model, q_a, commands[-1], kappa)
        commands.append(commands[-1] - 0.5 * (box - goal) * slope)
    return np.array(commands)


def search_modes(models: dict[str, st.Model], goal: float) -> tuple[str, float]:
    """(1.1) for each of the four linear pieces, by its slope at one command inside: name and cost of the best."""
    costs = {}
    for side, sign in SIDES.items():
        for contact, inside in (("contact", sign * 0.05), ("no contact", -sign * 0.05)):
            box, slope, _ = next_box(models[side], -sign * START_GAP, inside)
            u = inside if abs(slope) < 1e-6 else inside + (goal - box) / slope
            u = sign * max(sign * u, 0) if contact == "contact" else sign * min(sign * u, 0)
            costs[f"{side}, {contact}"] = 0.5 * (box + slope * (u - inside) - goal) ** 2
    return min(costs.items(), key=lambda item: item[1])


def run(quick: bool) -> Result:
    models = {side: load_side(side) for side in SIDES}
    commands = np.linspace(-0.2, 0.2, 20 if quick else 80)  # an even number: none at the kink
    result = Result(
        f"The box is at 0. The ball starts {1e3 * START_GAP:g} mm beside it and has a spring of {STIFFNESS:g} N/m. The box resists a step with {100 * RESISTANCE:g} % of this stiffness, so that it follows the ball to 1/{1 + RESISTANCE:g} of a command: without any resistance smoothing would send it away. The dashed lines "
        f"of the thesis are analytic smoothing with κ = {KAPPAS[0]:g} and {KAPPAS[1]:g}. The descent is (1.2) with steps of half the gradient, and κ grows from {FIRST_KAPPA:g} to {LAST_KAPPA:g}.",
        settings={"start_gap": START_GAP, "goal": GOAL, "steps": STEPS, "kappas": list(KAPPAS)},
    )
    figure, axes = plt.subplots(1, 3, figsize=(8.6, 2.7))
    result.data["steps"] = {"u_m": commands}
    for ax, (side, sign) in zip(axes, SIDES.items()):
        rows = np.array([next_box(models[side], -sign * START_GAP, u) for u in commands])
        truth = sign * np.maximum(sign * commands, 0)
        touches = sign * commands > 0
        error = float(np.max(np.abs(rows[:, 0] - truth / (1 + RESISTANCE))))
        bound = "max" if sign > 0 else "min"
        result.add(f"ball on the {side}: q₊ against {bound}(0, u)/{1 + RESISTANCE:g}", "the box follows the ball, or stays", f"{error:.1e} m", error < 1e-6)
        slopes = float(np.max(np.abs(rows[:, 1] - touches / (1 + RESISTANCE))))
        modes = bool(((rows[:, 2] > 1e-6) == touches).all())
        thesis = f"0 without contact, 1 in contact (here 1/{1 + RESISTANCE:g})"
        result.add(f"ball on the {side}: slope in each mode", thesis, f"within {slopes:.1e}", slopes < 1e-3 and modes)
        ax.plot(commands[~touches], rows[~touches, 0], "C3", lw=2, label="no contact")
        ax.plot(commands[touches], rows[touches, 0], "C2", lw=2, label="contact")
        for kappa in KAPPAS:
            smooth = np.array([next_box(models[side], -sign * START_GAP, u, kappa) for u in commands])
            ax.plot(commands, smooth[:, 0], "--", lw=1, label=f"κ = {kappa:g}")
            rising = bool((smooth[:, 1] > 0).all() and (sign * np.diff(smooth[:, 1]) > -1e-9).all())
            result.add(f"ball on the {side}, κ = {kappa:g}: slope", "positive without contact, too", f"{smooth[:, 1].min():.2g} to {smooth[:, 1].max():.2g}", rising)
            result.data["steps"] |= {f"smooth_{side}_{kappa:g}_m": smooth[:, 0]}
        result.data["steps"] |= {f"exact_{side}_m": rows[:, 0]}
        ax.set_title(f"ball on the {side}")
        ax.set_xlabel("u [m]")
    axes[0].set_ylabel("q₊ of the box [m]")
    axes[0].legend(fontsize=7)
    add_descents(result, models, axes[2])
    result.draw("modes", figure, "Left and middle: next position of the box over the command, in both modes and smoothed. Right: descents of (1.1).")
    return result


def add_descents(result: Result, models: dict[str, st.Model], ax: plt.Axes) -> None:
    cases = (("left", GOAL, True), ("left", -GOAL, False), ("right", -GOAL, True))
    for side, goal, expected in cases:
        q_a = -SIDES[side] * START_GAP
        path = descend(models[side], q_a, goal)
        box, _, _ = next_box(models[side], q_a, path[-1])
        _, slope, _ = next_box(models[side], q_a, path[-1], LAST_KAPPA)
        reached = abs(box - goal) < 1e-3
        where = "right" if goal > 0 else "left"
        thesis = "reaches it" if expected else "moves away until the slope is gone"
        away = SIDES[side] * (path[-1] - q_a) < 0 and abs(box) < 1e-6 and slope < 1e-3
        ours = f"ball to {path[-1]:+.3f} m, box to {box:+.4f} m of {goal:+.2f} m"
        result.add(f"descent with the ball on the {side}, goal on the {where}", thesis, ours, reached if expected else away and not reached)
        ax.plot(path, label=f"ball {side}, goal {where}")
    name, cost = search_modes(models, -GOAL)
    result.add("search over the four modes, goal on the left", "picks the right side in contact", f"{name}, cost {cost:.1e} m²", name == "right, contact" and cost < 1e-8)
    _, slope, _ = next_box(models["left"], -START_GAP, -START_GAP)
    result.add("exact slope at the first guess", "0", f"{slope:.1e}", abs(slope) < 1e-6)
    ax.set_xlabel("step")
    ax.set_title("u [m]")
    ax.legend(fontsize=7)
