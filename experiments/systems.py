"""Where the systems of the experiments lie."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import stiction as st
import yaml

SCENES = Path(__file__).resolve().parent / "scenes"


def load(name: str) -> st.Model:
    return st.load_model(SCENES / f"{name}.yaml")


def solved(result: st.StepResult) -> st.StepResult:
    """The result, which an experiment may use only if it is one."""
    if result.status != st.Status.Solved:
        raise RuntimeError(f"a step ended with {result.status.name}")
    return result


def slope(x: np.ndarray, y: np.ndarray) -> float:
    """Exponent of y ~ xⁿ by least squares on logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def load_with_stiffness(name: str, stiffness: float) -> st.Model:
    """The scene with another stiffness of its robot."""
    scene = yaml.safe_load((SCENES / f"{name}.yaml").read_text(encoding="utf-8"))["scene"]
    (robot,) = scene["robots"]
    robot["stiffness"] = stiffness
    return st.load_model(scene, base=SCENES)
