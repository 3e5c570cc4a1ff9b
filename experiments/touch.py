"""What the programs of bench/ say of sensing, for the figures of chapter 4."""

from __future__ import annotations

import json
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import stiction as st

CASE = (
    "Posture and torques of the thesis's figures 4-6 to 4-10. {} μ = 1, n_d = 4; residuals of the thesis's figures are ½ ‖·‖², and so are those here."
)
MESHES = (
    "The arm is an iiwa 7 with the meshes that `make experiments` unpacks (`models/iiwa_meshes.urdf`), without the faces that nothing can touch; those of the thesis are cut from "
    "the same files by hand."
)
CAPSULES = (
    "The arm is an iiwa 7 of capsules (`models/iiwa_primitives.urdf`), as `make experiments` did not unpack the meshes: numbers of samples differ with the surface."
)


@cache
def measure(name: str, *arguments: str) -> Any:
    """The JSON object that a program of bench/ prints, with NaN where it has null: nothing to take a median of."""
    program = Path(st.__file__).absolute().parents[2] / "bench" / name
    if not program.is_file():
        raise RuntimeError(f"no program {program}: `make build` makes it")
    done = subprocess.run([str(program), *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{program}: {done.stderr.strip()}")
    return json.loads(done.stdout, object_hook=lambda entry: {name: float("nan") if value is None else value for name, value in entry.items()})


def maps(quick: bool) -> dict[str, Any]:
    return measure("sensing_maps", "2000" if quick else "20000")


def case(quick: bool) -> str:
    """What the figures of one posture have in common."""
    return CASE.format(MESHES if maps(quick)["iiwa"] == "iiwa" else CAPSULES)


def percent(share: float) -> str:
    return f"{100 * share:.2f} %"


def scatter(axes: Any, points: np.ndarray, values: np.ndarray, colours: list[tuple[float, str, str]]) -> None:
    """Points by the first bound that their value does not exceed."""
    below = np.full(len(values), False)
    for bound, colour, label in colours:
        chosen = (values <= bound) & ~below
        below |= chosen
        axes.plot(*points[chosen].T, ".", ms=2.5, color=colour, label=label)
    axes.set_aspect("equal")
