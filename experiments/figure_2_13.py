"""Figure 2-13: the stochastic force field. Samples inside the wall are projected onto it, so their mean is pushed away."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import stiction as st

from .report import Result
from .systems import load

TITLE = "Figure 2-13: stochastic force field in front of a wall"
STD = 0.1  # of the Gaussian [m]
TRUE_MASS = st.FixedEpsilon(epsilon=1.0)


def density(x: float) -> float:
    return math.exp(-x * x / 2) / math.sqrt(2 * math.pi)


def cumulative(x: float) -> float:
    return (1 + math.erf(x / math.sqrt(2))) / 2


def exact_mean(q: float) -> float:
    """E max(q + w, 0), w ~ N(0, STD²)."""
    return q * cumulative(q / STD) + STD * density(q / STD)


def variance(q: float) -> float:
    second = (q * q + STD * STD) * cumulative(q / STD) + q * STD * density(q / STD)
    return second - exact_mean(q) ** 2


def sample(model: st.Model, q: float, scheme: type, samples: int, seed: int) -> tuple[float, float]:
    """Smoothed next position and its derivative by q."""
    local = st.calc_local_model(
        model, [q], [], scheme=scheme(std_q=[STD], std_u=[0.0], samples=samples, seed=seed), with_A=True, regularisation=TRUE_MASS
    )
    assert local.status == st.Status.Solved and local.failed == 0 and local.A is not None
    return float(local.c[0]), float(local.A[0, 0])


def run(quick: bool) -> Result:
    model = load("block_wall")
    samples = 500 if quick else 10000
    positions = np.linspace(-0.3, 0.3, 13 if quick else 25)
    steps = np.array([st.step(model, [q], [], regularisation=TRUE_MASS).q_next[0] for q in positions])
    first = np.array([sample(model, q, st.RandomizedFirstOrder, samples, i) for i, q in enumerate(positions)])
    zeroth = np.array([sample(model, q, st.RandomizedZerothOrder, samples, i) for i, q in enumerate(positions)])
    means = np.array([exact_mean(q) for q in positions])
    gradients = np.array([cumulative(q / STD) for q in positions])

    result = Result(
        f"A block without actuators in front of a wall; its step is a projection, f(q) = max(q, 0) (2.26). Smoothed by a Gaussian of {STD} m it is "
        "q Φ(q/s) + s φ(q/s), its derivative Φ(q/s).",
        settings={"std": STD, "samples": samples, "seed": "index of q", "epsilon": 1.0, "q": positions.tolist()},
    )
    projection = float(np.max(np.abs(steps - np.maximum(positions, 0))))
    # At q = 0 neither gap nor impulse is positive: a complementarity of 1e-10 J·s leaves √(1e-10 h/m) there.
    result.add("exact step against max(q, 0)", "equal (2.26)", f"{projection:.1e} m", projection < 1.1 * math.sqrt(1e-10 * 0.1 / 1.0))
    sigmas = float(np.max(np.abs(first[:, 0] - means) / np.sqrt([variance(q) / samples for q in positions])))
    result.add(f"mean of {samples} samples against the closed form", "–", f"at most {sigmas:.2f} standard errors", sigmas < 4)
    deviation = np.sqrt(np.maximum(gradients * (1 - gradients), 1 / samples) / samples)
    sigmas = float(np.max(np.abs(first[:, 1] - gradients) / deviation))
    result.add("first-order gradient against Φ(q/s)", "–", f"at most {sigmas:.2f} standard errors", sigmas < 4)
    error = float(np.max(np.abs(zeroth[:, 1] - gradients)))
    result.add("zeroth-order gradient against Φ(q/s)", "the same quantity (2.4.1)", f"within {error:.3f}", error < 5 / math.sqrt(samples))
    at_wall = exact_mean(0.0)
    ours = first[len(positions) // 2, 0]
    result.add("push at the wall, q = 0", "to the right", f"{1e3 * ours:.1f} mm ({1e3 * at_wall:.1f} in closed form)", ours > 0)

    figure, axes = plt.subplots(1, 2, figsize=(7, 2.7))
    fine = np.linspace(-0.3, 0.3, 101)
    axes[0].plot(fine, np.maximum(fine, 0), color="0.6", label="exact")
    axes[0].plot(fine, [exact_mean(q) for q in fine], label="closed form")
    axes[0].plot(positions, first[:, 0], "o", ms=3, label=f"{samples} samples")
    axes[0].set_ylabel("next position [m]")
    axes[1].plot(fine, fine > 0, color="0.6", label="exact")
    axes[1].plot(fine, [cumulative(q / STD) for q in fine], label="closed form")
    axes[1].plot(positions, first[:, 1], "o", ms=3, label="first order")
    axes[1].plot(positions, zeroth[:, 1], "x", ms=4, label="zeroth order")
    axes[1].set_ylabel("derivative")
    for ax in axes:
        ax.set_xlabel("q [m]")
        ax.legend()
    result.draw("field", figure, "Exact and smoothed projection of the block, and their derivatives.")
    columns = {"q_m": positions, "exact_m": steps, "closed_form_m": means, "sampled_m": first[:, 0], "closed_form_gradient": gradients}
    result.data["field"] = columns | {"first_order_gradient": first[:, 1], "zeroth_order_gradient": zeroth[:, 1]}
    return result
