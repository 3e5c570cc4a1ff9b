"""Figure 5-3: contacts with friction, where the force is not along the normal. Both costs over the coefficient of friction."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from . import control_runs
from .control_runs import FRICTION, LAMBDA_MAX
from .report import Result

TITLE = "Figure 5-3: friction, and the costs (5.22) and (5.24)"
COSTS = {"command": "(5.24)", "equilibrium": "(5.22)"}
SCENARIOS = ("box_in_the_way", "mug_placement")
COEFFICIENTS = np.arange(9) / 10
ERROR = 2.0  # [N] in the mean


def run(quick: bool) -> Result:
    coefficients = COEFFICIENTS[::4] if quick else COEFFICIENTS
    result = Result(
        "With friction the force is not along the normal, and the cost of (5.22), which compares the predicted equilibrium with the reference, may command a motion "
        "away from the obstacle: contacts are made again and again. That is why the thesis has (5.24). Both, in both scenarios, for μ from 0 to 0.8 in the "
        "simulation; the controllers do not know μ. Deviation: mean | ‖f‖ − λ_max | over the settled ticks in which the reference asks for more.",
        settings={"scenarios": SCENARIOS, "friction": coefficients.tolist(), "lambda_max_N": LAMBDA_MAX},
    )
    figure, axes = plt.subplots(2, len(SCENARIOS), figsize=(6.4, 4.2), sharex=True)
    columns: dict[str, np.ndarray] = {"friction": coefficients}
    for scenario, column in zip(SCENARIOS, axes.T, strict=True):
        for cost, equation in COSTS.items():
            runs = [control_runs.run(scenario, changes={"controller": {"cost": cost}}, friction=mu / FRICTION) for mu in coefficients]
            error, p95, made = (np.array([r[name] for r in runs]) for name in ("bound_error", "bound_p95", "contacts_made"))
            columns |= {f"deviation_N:{scenario}:{cost}": error, f"p95_N:{scenario}:{cost}": p95, f"contacts_made:{scenario}:{cost}": made}
            column[0].plot(coefficients, error, "o-", ms=3, lw=1, label=equation)
            column[1].plot(coefficients, made, "o-", ms=3, lw=1)
            worst = int(np.argmax(error))
            note = f"95 % below {p95.max():.1f} N, {made.min():.0f} to {made.max():.0f} contacts made"
            result.add(f"{scenario}, {equation}: largest deviation over μ", "close to λ_max", f"{error[worst]:.2f} N, μ = {coefficients[worst]:.1f}", error[worst] < ERROR, note)
        column[0].set_title(scenario, fontsize=9)
        column[1].set_xlabel("μ")
    axes[0, 0].set_ylabel("deviation [N]")
    axes[1, 0].set_ylabel("contacts made")
    axes[0, 0].legend()
    makes = {cost: sum(columns[f"contacts_made:{s}:{cost}"][coefficients > 0].sum() for s in SCENARIOS) for cost in COSTS}
    result.add(
        "contacts made with friction, (5.24) against (5.22)",
        "fewer",
        f"{makes['command']:.0f} against {makes['equilibrium']:.0f}",
        None,
    )
    result.draw("friction", figure, "Above: mean deviation of settled forces from λ_max. Below: contacts made in a run.")
    result.data["friction"] = columns
    return result
