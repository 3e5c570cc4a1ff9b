"""Figure 2-14: the log barrier is randomised smoothing by another distribution."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result, number
from .systems import load, solved

TITLE = "Figure 2-14: analytic and randomised smoothing are the same for a spring before a wall"
H = 0.1
STIFFNESS = 100.0
TRUE_MASS = st.FixedEpsilon(epsilon=1.0)
THETA = 2.0  # degree of the barrier of a contact without friction: it is the limit of a cone


def sharpness(kappa: float) -> float:
    """σ of (2.35), with our κ per energy and the degree of the barrier: k κ/θ [1/m²]."""
    return STIFFNESS * kappa / THETA


def closed_form(u: np.ndarray | float, kappa: float) -> np.ndarray | float:
    """(2.34), corrected."""
    return (u + np.sqrt(np.square(u) + 4 / sharpness(kappa))) / 2


def kernel(w: np.ndarray, kappa: float) -> np.ndarray:
    """(2.35): Student's t with two degrees of freedom and scale √(2/σ)."""
    sigma = sharpness(kappa)
    return np.sqrt(4 * sigma / (sigma * w * w + 4) ** 3)


def mean_of_exact(model: st.Model, u: float, kappa: float, nodes: int) -> float:
    """E_w[f(u + w)] over the kernel, f the exact step. With w = √(4/σ) tan a the density of a is cos(a)/2."""
    width = np.sqrt(4 / sharpness(kappa))
    kink = np.arctan(-u / width)
    points, weights = np.polynomial.legendre.leggauss(nodes)
    total = 0.0
    for lower, upper in ((-np.pi / 2, kink), (kink, np.pi / 2)):
        angles = (upper + lower) / 2 + (upper - lower) / 2 * points
        values = [solved(st.step(model, [0.05], [u + width * np.tan(a)], h=H)).q_next[0] for a in angles]
        total += (upper - lower) / 2 * float(np.sum(weights * values * np.cos(angles) / 2))
    return total


def smoothed(model: st.Model, u: float, kappa: float) -> float:
    return float(solved(st.step(model, [0.05], [u], h=H, smoothing=st.Analytic(kappa=kappa, self_sharpness=1, limit_sharpness=1))).q_next[0])


def add_spring(result: Result, quick: bool) -> None:
    """(a), (c), (d): one cart, one wall."""
    wall, limit = load("cart_wall"), load("cart_limit")
    commands = np.linspace(-0.2, 0.2, 5 if quick else 9)
    kappas = (10.0, 100.0) if quick else (10.0, 100.0, 1000.0)
    nodes = 12 if quick else 24
    ours = np.array([[smoothed(wall, u, kappa) for u in commands] for kappa in kappas])
    formula = np.array([closed_form(commands, kappa) for kappa in kappas])
    means = np.array([[mean_of_exact(wall, u, kappa, nodes) for u in commands] for kappa in kappas])

    error = float(np.max(np.abs(ours - formula)))
    result.add("analytic step against (2.34) with 4θ/(κ_thesis h k)", "equal", f"{error:.1e} m", error < 1e-8)
    error = float(np.max(np.abs(means - ours)))
    result.add("mean of the exact step over the kernel (2.35) against the analytic step", "equal", f"{error:.1e} m", error < 1e-6)
    printed = (commands + np.sqrt(commands**2 + 4 * THETA / ((kappas[0] / H) * H**2 * STIFFNESS**2))) / 2
    gap = float(np.max(np.abs(printed - means[0])))
    result.add(
        "(2.34) as printed, 4/(κ_thesis h² k²), against that mean",
        "equal",
        f"{1e3 * gap:.1f} mm off at κ = {kappas[0]:g}/J",
        gap > 1e-3,
        "erratum",
    )
    # A joint limit is a plain half-line, θ = 1, the very barrier of (2.31).
    half_line = max(abs(smoothed(limit, u, 100.0) - (u + np.sqrt(u * u + 4 / (100.0 * STIFFNESS))) / 2) for u in commands)
    result.add("the same with a joint limit for a wall, θ = 1", "equal", f"{half_line:.1e} m", half_line < 1e-8)
    draw_spring(result, wall, kappas)
    result.data["spring"] = {
        "kappa_1_J": np.repeat(kappas, len(commands)),
        "u_m": np.tile(commands, len(kappas)),
        "analytic_m": ours.ravel(),
        "closed_form_m": formula.ravel(),
        "mean_over_kernel_m": means.ravel(),
    }


def draw_spring(result: Result, wall: st.Model, kappas: tuple[float, ...]) -> None:
    u = np.linspace(-0.2, 0.2, 41)
    figure, axes = plt.subplots(1, 2, figsize=(7, 2.7))
    axes[0].plot(u, np.maximum(u, 0), color="0.6", label="exact")
    for std in (0.03, 0.1):
        sampling = st.RandomizedFirstOrder(std_q=[0.0], std_u=[std], samples=400, seed=0)
        gaussian = [st.calc_local_model(wall, [0.05], [x], scheme=sampling, h=H).c[0] for x in u[::4]]
        axes[0].plot(u[::4], gaussian, "o", ms=3, color="C2", alpha=0.5 + 4 * std, label=f"Gaussian, {std} m")
        axes[1].plot(u, np.exp(-((u / std) ** 2) / 2) / (std * np.sqrt(2 * np.pi)), color="C2", alpha=0.5 + 4 * std)
    for kappa, style in zip(kappas[:2], ("-", "--"), strict=True):
        axes[0].plot(u, [smoothed(wall, x, kappa) for x in u], style, color="C6", label=f"κ = {kappa:g}/J")
        axes[1].plot(u, kernel(u, kappa), style, color="C6")
    axes[0].set_xlabel("u [m]")
    axes[0].set_ylabel("next position [m]")
    axes[0].legend()
    axes[1].set_xlabel("w [m]")
    axes[1].set_ylabel("density [1/m]")
    result.draw("spring", figure, "(c) Smoothed steps of the cart before the wall. (d) The distributions that they average over.")


# ---- (b), (e): a ball drags a cart

FRICTION, DEPTH, MASS = 0.25, 0.2, 1.0


def dragged(u: np.ndarray) -> np.ndarray:
    """Next position of the cart in closed form: sticking, then sliding with Anitescu's gap."""
    m, k, mu, d = MASS / H**2, STIFFNESS, FRICTION, DEPTH
    onset = mu * d * (1 + k / m)
    slip = np.maximum(np.abs(u) - onset, 0) / (1 + mu**2 + mu**2 * k / m)
    return np.sign(u) * np.where(slip > 0, mu * k * (d + mu * slip) / m, np.abs(u) * k / (k + m))


def add_cart(result: Result, quick: bool) -> None:
    model = load("cart_and_ball")
    u = np.linspace(-0.3, 0.3, 13 if quick else 31)
    samples = 100 if quick else 1000

    def cart(kappa: float | None = None) -> np.ndarray:
        smoothing = st.Exact() if kappa is None else st.Analytic(kappa=kappa)
        return np.array([solved(st.step(model, [0, 0, 0], [x, -DEPTH], h=H, regularisation=TRUE_MASS, smoothing=smoothing)).q_next[0] for x in u])

    def gaussian(std: float) -> np.ndarray:
        scheme = st.RandomizedFirstOrder(std_q=[0.0], std_u=[std, 0.0], samples=samples, seed=0)
        return np.array([st.calc_local_model(model, [0, 0, 0], [x, -DEPTH], scheme=scheme, h=H, regularisation=TRUE_MASS).c[0] for x in u])

    exact = cart()
    error = float(np.max(np.abs(exact - dragged(u))))
    result.add("cart under the ball: exact step against its closed form", "–", f"{error:.1e} m", error < 1e-6)
    inside = np.abs(u) < 0.09
    stick = float(np.polyfit(u[inside], exact[inside], 1)[0])
    flat = float(np.polyfit(u[u > 0.15], exact[u > 0.15], 1)[0])
    result.add("slope where the contact sticks", "linear", f"{stick:.4f}", abs(stick - 0.5) < 1e-3)
    result.add(
        "slope where it slides", "flat", f"{flat:.4f}", flat < 0.15 * stick, "not 0: Anitescu's gap lifts the ball and presses harder"
    )
    kappas = (20.0, 100.0, 500.0, 2500.0)
    curves = {kappa: cart(kappa) for kappa in kappas}
    errors = [float(np.max(np.abs(curves[kappa] - exact))) for kappa in kappas]
    result.add(
        "analytic step towards the exact one as κ grows",
        "converges",
        " → ".join(number(1e3 * e) for e in errors) + " mm",
        bool(np.all(np.diff(errors) < 0)),
    )
    stds = (0.03, 0.06, 0.12)
    means = {std: gaussian(std) for std in stds}
    best = {kappa: min(stds, key=lambda std: float(np.max(np.abs(means[std] - curves[kappa])))) for kappa in kappas}
    apart = {kappa: float(np.max(np.abs(means[best[kappa]] - curves[kappa]))) for kappa in kappas}
    kappa = min(kappas, key=lambda k: apart[k])
    result.add(
        "closest pair of an analytic and a Gaussian curve",
        "qualitatively similar",
        f"{1e3 * apart[kappa]:.1f} mm apart (κ = {kappa:g}/J, {best[kappa]} m)",
        None,
    )

    figure, axes = plt.subplots(figsize=(4.4, 2.8))
    axes.plot(u, exact, color="0.5", label="exact")
    for k, style in zip(kappas[:3], ("-", "--", ":"), strict=True):
        axes.plot(u, curves[k], style, color="C6", label=f"κ = {k:g}/J")
    for std, alpha in zip(stds[1:], (0.9, 0.5), strict=True):
        axes.plot(u, means[std], "o", ms=3, color="C2", alpha=alpha, label=f"Gaussian, {std} m")
    axes.set_xlabel("u along the cart [m]")
    axes.set_ylabel("next position of the cart [m]")
    axes.legend(fontsize=7)
    result.draw("cart", figure, "(e) A ball pressed 0.2 m into a cart drags it along: sticking in the middle, sliding outside.")
    columns = {"u_m": u, "exact_m": exact} | {f"analytic_{k:g}_m": curve for k, curve in curves.items()}
    result.data["cart"] = columns | {f"gaussian_{std:g}_m": curve for std, curve in means.items()}


def run(quick: bool) -> Result:
    result = Result(
        f"A cart on a spring k = {STIFFNESS:g} N/m before a wall: the log barrier gives q⁺ = (u + √(u² + 4/σ))/2 with σ = h k κ_thesis/θ = k κ/θ, whose second "
        "derivative by u is the density (2.35). Averaging the exact step max(u, 0) over that density must give q⁺ again; we integrate the steps that the library "
        "computes. The thesis has θ = 1 (one half-line); a contact without friction is the limit of a cone here, so θ = 2.\n\n"
        "The second system is a cart without motor under a ball that is pressed onto it and moved along. Parameters of figure 2-14e are not printed; ours: ball springs "
        f"{STIFFNESS:g} N/m, cart {MASS:g} kg, μ = {FRICTION}, command {DEPTH} m inside the cart, h = {H} s, ε = 1.",
        settings={"h": H, "stiffness": STIFFNESS, "friction": FRICTION, "depth": DEPTH, "mass": MASS, "seed": 0},
    )
    add_spring(result, quick)
    add_cart(result, quick)
    return result
