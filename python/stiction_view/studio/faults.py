"""What lint finds in a task, with the place where it shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import stiction as st

from .picture import Pictures
from .problem import Problem

TITLES = {
    "overlap": "overlap",
    "stuck": "stuck",
    "force": "pressed too hard",
    "unsupported": "nothing supports it",
    "hold": "nothing holds it at the goal",
    "reach": "out of reach",
    "weight": "too heavy",
    "gravity": "gravity",
    "size": "size",
    "units": "units",
    "quaternion": "quaternion",
    "sample_box": "goal outside the box",
    "goal": "already there",
}


@dataclass(frozen=True)
class Fault:
    """`label` stands at `point` in the scene (None: it has no place); `bodies` are painted."""

    kind: str
    message: str
    label: str
    point: np.ndarray | None
    bodies: tuple[str, ...]
    at_goal: bool


def length(x: float) -> str:
    """As people say it."""
    return f"{1e3 * x:.3g} mm" if abs(x) < 0.1 else f"{x:.3g} m"


def find(problem: Problem, pictures: Pictures) -> list[Fault]:
    """Of the task as it is now. Raises stiction.InvalidInput: it cannot be read."""
    return [_place(finding, problem, pictures) for finding in st.lint(problem.task())]


def _place(finding: st.Finding, problem: Problem, pictures: Pictures) -> Fault:
    model = problem.model
    at_goal = finding.where == "goal"
    owners = {g.name: pictures.bodies[g.body].name for g in pictures.geometries}
    bodies = tuple(dict.fromkeys(owners.get(name, name) for name in finding.names))
    point = finding.p_W
    if point is None and (objects := [b for b in bodies if b in model.object_names]):
        point = model.object_pose(problem.goal if at_goal else problem.start, objects[0]).p
    title = TITLES.get(finding.kind, finding.kind)
    pair = f" of {' and '.join(body.split('/')[-1] for body in bodies)}" if finding.kind == "overlap" else ""
    label = title + pair + ("" if finding.amount is None else f": {length(finding.amount)}")
    return Fault(finding.kind, finding.message, label, None if point is None else np.array(point), bodies, at_goal)
