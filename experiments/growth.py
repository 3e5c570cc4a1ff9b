"""Trees of chapter 3: the settings of the published runs, the three smoothing schemes and the ablations of 3.5."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import stiction as st

ITERATIONS = 1000
RUNS = 5
SCHEMES = ("analytic", "randomized-first", "randomized-zeroth")
COLOURS = {
    "analytic": "C0",
    "randomized-first": "C1",
    "randomized-zeroth": "C2",
    "exact": "C3",
    "no contact samples": "C4",
    "global metric": "C5",
}


@dataclass(frozen=True)
class System:
    """Global weights [1/m², 1/rad²] as published (the angle of a free object by its half: 5/4), and η where the published scripts have one, else
    that of PlanarHand."""

    title: str
    weights: dict[str, float]
    threshold: float = 3.0
    published: tuple[float, float, float] = (0, 0, 0)  # Table 3.2 [s], in the order of SCHEMES


SYSTEMS = {
    "planar_pushing": System("PlanarPushing", {"position": 20, "angle": 10}, published=(3.25, 7.50, 7.40)),
    "planar_hand": System("PlanarHand", {"position": 10, "angle": 1}, published=(10.32, 21.34, 21.00)),
    "allegro_ball": System("AllegroHand", {"position": 1, "angle": 1.25}, published=(31.01, 80.12, 82.00)),
    "allegro_plate": System("AllegroPlate", {"position": 1, "angle": 1.25}, published=(117.16, 161.64, 168.11)),
    "allegro_pen": System("AllegroPen", {"position": 1, "angle": 1.25}, 5.0, (24.84, 86.12, 81.23)),
    "allegro_door": System("AllegroDoor", {"position": 1, "angle": 1}, published=(12.42, 34.55, 33.80)),
}


def variants(system: System) -> dict[str, dict[str, Any]]:
    """What each curve of Fig. 3-6 changes in the settings of Algorithm 2."""
    return {
        "analytic": {},
        "randomized-first": {"scheme": "randomized-first"},
        "randomized-zeroth": {"scheme": "randomized-zeroth"},
        "exact": {"scheme": "exact"},
        "no contact samples": {"grasp_probability": 0},
        "global metric": {"metric": {"global": system.weights}},
    }


def grow(name: str, settings: dict[str, Any], seed: int, iterations: int) -> st.PlanResult:
    """A tree of so many extensions, with the settings of the published runs and those that differ from them."""
    task = st.load_task(f"{name}_table_3_2")
    options = {"max_iterations": iterations, "thesis": task.options.thesis | settings | {"stop_at_goal": False}}
    return st.plan(task, options=options, seed=seed, timeout_s=600)


def distances(result: st.PlanResult, iterations: int) -> np.ndarray:
    """Least distance to the goal after each iteration, ‖(position, angle)‖ with metres and radians alike, as in the thesis."""
    least = np.minimum.accumulate(np.linalg.norm(result.tree_errors, axis=1))
    return by_iteration(result, least, iterations)


def by_iteration(result: st.PlanResult, values: np.ndarray, iterations: int) -> np.ndarray:
    """A series over nodes as one over iterations 1 …, each the value at the last node until then."""
    after = np.array([node.iteration for node in result.tree])
    last = np.searchsorted(after, np.arange(1, iterations + 1), side="right") - 1
    return values[last]
