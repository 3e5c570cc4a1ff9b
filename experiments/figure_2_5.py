"""Figures 2-5 and 2-6: the parallel gripper through four contact modes, against Coulomb's law."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from .gripper import EPSILON, FRICTION, RADIUS, STIFFNESS, WEIGHT, Coulomb, Ours, State, simulate
from .report import Result, number
from .systems import slope

TITLE = "Figures 2-5 and 2-6: gripper and ball, cones against Coulomb's law"
H = 0.01
FINE_H = 0.0005  # k μ h v is half a percent of the squeeze
KNOT_TIMES = [0.0, 0.08, 0.23, 0.35]
KNOTS = np.array(
    [
        [0, -1.06 * RADIUS, 1.06 * RADIUS],
        [0, -0.9 * RADIUS, 0.9 * RADIUS],
        [-0.03, -0.9 * RADIUS, 0.9 * RADIUS],
        [-0.03, -0.9 * RADIUS, 0.9 * RADIUS],
    ]
)
CHANGES = (0.03, 0.13, 0.23)  # printed: contact, slip, end of slip [s]


def commands(h: float) -> tuple[np.ndarray, np.ndarray]:
    times = h * np.arange(1, round(KNOT_TIMES[-1] / h) + 1)
    return times, np.column_stack([np.interp(times, KNOT_TIMES, column) for column in KNOTS.T])


def mode_changes(states: list[State], times: np.ndarray, h: float) -> list[float]:
    """When the left finger touches, starts to slide and stops: ends of the first and starts of the second kind of steps."""
    touching = np.array([state.phi[0] < 1e-5 for state in states])
    # After the stop the layer closes within a few steps, ever slower; half the commanded speed counts as sliding.
    sliding = np.array([abs(state.slip[0]) > 0.5 * 0.2 * h and state.force[0, 0] > 1e-3 for state in states])
    return [
        float(times[np.argmax(touching)]),
        float(times[np.argmax(sliding)] - h),
        float(times[len(times) - 1 - np.argmax(sliding[::-1])]),
    ]


def series(states: list[State]) -> dict[str, np.ndarray]:
    pick = {
        "x_l_m": lambda s: s.q[3],
        "y_m": lambda s: s.q[2],
        "c_n1_N": lambda s: s.force[0, 0],
        "c_f1_N": lambda s: s.force[0, 1],
        "c_n3_N": lambda s: s.force[2, 0],
        "phi_1_m": lambda s: s.phi[0],
    }
    return {name: np.array([get(state) for state in states]) for name, get in pick.items()}


def add_mode_changes(result: Result, times: np.ndarray, ours: list[State], theirs: list[State]) -> None:
    ours_at, theirs_at = mode_changes(ours, times, H), mode_changes(theirs, times, H)
    for i, what in enumerate(("touch", "start of slip", "end of slip")):
        good = abs(ours_at[i] - CHANGES[i]) < 0.011 and abs(theirs_at[i] - CHANGES[i]) < 0.011
        result.add(
            f"mode change: {what}",
            f"{CHANGES[i]} s",
            f"{ours_at[i]:.2f} s (Coulomb: {theirs_at[i]:.2f} s)",
            good,
            "the layer closes within three steps" if i == 2 else "",
        )


def add_forces(result: Result, times: np.ndarray, a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> None:
    peak = float(a["c_n1_N"][np.searchsorted(times, 0.08 - 1e-9)])
    result.add("c_n1 at 0.08 s", "10 N", f"{peak:.4f} N", abs(peak - 10) < 0.01)
    stick = (times < 0.125) | (times > 0.285)
    for name, label in (("c_n1_N", "c_n1"), ("c_f1_N", "c_f1"), ("c_n3_N", "c_n3")):
        scale = float(np.max(np.abs(b[name])))
        error = float(np.max(np.abs(a[name] - b[name])[stick])) / scale
        result.add(f"{label} against Coulomb, away from slip", "same", f"{100 * error:.3f} % of {scale:.3g} N", error < 0.01)
    slide = (times > 0.155) & (times < 0.225)
    gap = float(np.mean(a["phi_1_m"][slide]))
    predicted = FRICTION * 0.2 * H  # the gripper is pulled down at 0.2 m/s
    result.add(
        "φ_1 while the fingers slide",
        "small increase",
        f"{1e3 * gap:.3f} mm (μ h |v_t| = {1e3 * predicted:g} mm)",
        abs(gap / predicted - 1) < 0.02,
    )
    extra = float(np.mean((a["c_n1_N"] - b["c_n1_N"])[slide]))
    result.add(
        "c_n1 while they slide, more than Coulomb's",
        "Coulomb's stays constant",
        f"{extra:.3f} N = k φ_1: {100 * extra / 10:.0f} %",
        abs(extra - STIFFNESS * gap) < 0.02,
    )
    after = float(abs(a["phi_1_m"][-1]))
    result.add("φ_1 at the end", "layer disappears", f"{after:.1e} m", after < 1e-5)


def largest_differences(h: float) -> tuple[dict[str, float], bool]:
    """Largest difference of each force from Coulomb's over all times away from mode changes, as a share of the largest one; whether the modes change
    within a step of each other."""
    times, u = commands(h)
    states = {"ours": simulate(Ours(), u, h), "coulomb": simulate(Coulomb(), u, h)}
    a, b = series(states["ours"]), series(states["coulomb"])
    changes = [mode_changes(states[who], times, h) for who in ("ours", "coulomb")]
    away = np.all([abs(times - change) > 0.005 for change in changes[1]], axis=0)
    shares = {name: float(np.max(np.abs(a[name] - b[name])[away]) / np.max(np.abs(b[name]))) for name in ("c_n1_N", "c_f1_N", "c_n3_N")}
    return shares, bool(np.max(np.abs(np.subtract(*changes))) < 1.01 * h)


def add_refinement(result: Result, quick: bool) -> None:
    steps = np.array([0.01, 0.005, 0.0025] if quick else [0.01, 0.005, 0.0025, 0.00125])
    errors = []
    for h in steps:
        times, u = commands(float(h))
        slide = (times > 0.18) & (times < 0.225)
        a, b = (series(simulate(model, u, float(h)))["c_n1_N"][slide] for model in (Ours(), Coulomb()))
        errors.append(float(np.mean(np.abs(a - b))))
    exponent = slope(steps, np.array(errors))
    result.add(
        "difference in c_n1 while sliding, as h shrinks",
        "vanishes with h",
        " → ".join(number(e) for e in errors) + f" N, exponent {exponent:.3f}",
        abs(exponent - 1) < 0.1,
    )
    shares, same_modes = largest_differences(FINE_H)
    result.add(
        f"all forces against Coulomb, sliding included, h = {1e3 * FINE_H:g} ms",
        "same",
        ", ".join(f"{name[:-2]} {100 * share:.2f} %" for name, share in shares.items()),
        max(shares.values()) < 0.01 and same_modes,
        "modes change within one step of Coulomb's; 5 ms around the changes are left out",
    )


def draw(result: Result, times: np.ndarray, u: np.ndarray, a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(7, 2.4))
    for ax, name, column in ((axes[0], "x_l_m", 1), (axes[1], "y_m", 0)):
        ax.plot(times, 1e3 * u[:, column], color="0.6", label="command")
        ax.plot(times, 1e3 * b[name], label="Coulomb")
        ax.plot(times, 1e3 * a[name], ".", ms=4, label="ours")
        ax.set_ylabel(name[:-2] + " [mm]")
    axes[0].legend()
    finish(axes)
    result.draw("positions", figure, "Figure 2-5: left finger. Dashed: the printed mode changes.")

    figure, axes = plt.subplots(1, 3, figsize=(8.4, 2.4))
    for ax, names in ((axes[0], ("c_n1_N", "c_f1_N")), (axes[1], ("c_n3_N",)), (axes[2], ("phi_1_m",))):
        for i, name in enumerate(names):
            scale = 1e3 if name == "phi_1_m" else 1
            ax.plot(times, scale * b[name], color=f"C{2 * i}", label=f"{name[:-2]}, Coulomb")
            ax.plot(times, scale * a[name], ".", ms=4, color=f"C{2 * i + 1}", label=f"{name[:-2]}, ours")
        ax.legend(fontsize=7)
    axes[0].set_ylabel("force [N]")
    axes[2].set_ylabel("φ_1 [mm]")
    finish(axes)
    result.draw("forces", figure, "Figure 2-6: forces at the left finger (1) and the ground (3), and the distance at the finger.")


def finish(axes: np.ndarray) -> None:
    for ax in axes:
        ax.set_xlabel("t [s]")
        for change in CHANGES:
            ax.axvline(change, color="C2", lw=0.8, ls="--")


def run(quick: bool) -> Result:
    result = Result(
        f"Two fingers close on a ball, squeeze it with 10 N and are pulled down until they slip. h = {H} s, weight {WEIGHT:g} N, k = {STIFFNESS:g} N/m, μ = {FRICTION}. The thesis "
        f"sets ε = 0; we take {EPSILON:g} (steps need some). The reference is the same balance of forces with Coulomb's law, solved by trying all modes of the three contacts "
        "in NumPy; it shares no code with the library.",
        settings={"h": H, "stiffness": STIFFNESS, "friction": FRICTION, "weight": WEIGHT, "epsilon": EPSILON},
    )
    times, u = commands(H)
    ours, theirs = simulate(Ours(), u, H), simulate(Coulomb(), u, H)
    a, b = series(ours), series(theirs)
    add_mode_changes(result, times, ours, theirs)
    add_forces(result, times, a, b)
    add_refinement(result, quick)
    draw(result, times, u, a, b)
    columns = {f"ours_{name}": values for name, values in a.items()} | {f"coulomb_{name}": values for name, values in b.items()}
    result.data["gripper"] = {"t_s": times, **columns}
    return result
