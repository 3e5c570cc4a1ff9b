"""What a plan asks of its motors and of fragile things, knot by knot: shares of `effort` and of `max_force`, as `stiction check` judges them."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

# Lines of the scene in canonical form (`scene_text` of a plan file). Names may hold commas, numbers do not.
COORDINATE = re.compile(r"^- \{name: (.+), lower: [^,]+, upper: [^,]+, stiffness: ([^,}]+)(?:, effort: ([^,}]+))?", re.MULTILINE)
FRAGILE = re.compile(r"^- \{name: (.+), shape: \{.+, friction: [^,}]+, max_force: ([^,}]+)\}$", re.MULTILINE)


Normal = tuple[int, int, float]  # of a contact: the two geometries, the normal force [N]


@dataclass(frozen=True)
class Loads:
    """Rows are knots of a plan, or pictures of a run."""

    joints: list[str]
    torque: np.ndarray  # (knots, n_a) of the joint springs, K (u − q) [N m or N]
    effort: np.ndarray  # (n_a), infinite where a motor has no limit
    fragile: list[str]  # geometries that have a max_force
    max_force: np.ndarray  # (fragile) [N]
    press: np.ndarray  # (knots, fragile) largest normal force from one other geometry [N]
    presser: list[list[str]]  # (knots, fragile) which one that is; "": none

    def effort_shares(self) -> np.ndarray:
        """(knots, n_a) |torque| / effort; 0 where the motor has no limit."""
        return np.abs(self.torque) / self.effort

    def effort_share(self) -> np.ndarray:
        """(knots) the largest of a joint; NaN where no motor has a limit."""
        return self.effort_shares().max(axis=1) if self.limited().any() else np.full(len(self.torque), np.nan)

    def press_shares(self) -> np.ndarray:
        """(knots, fragile) press / max_force."""
        return self.press / self.max_force

    def press_share(self) -> np.ndarray:
        """(knots) the largest of a fragile thing; NaN where nothing is fragile."""
        return self.press_shares().max(axis=1) if self.fragile else np.full(len(self.press), np.nan)

    def limited(self) -> np.ndarray:
        """(n_a) which motors have a limit."""
        return np.isfinite(self.effort)

    def unlimited_joints(self) -> list[str]:
        return [name for name, limited in zip(self.joints, self.limited()) if not limited]

    def of_run(self, torque: np.ndarray, normals: list[list[Normal]], geometries: list[str]) -> Loads:
        """With what a simulation measured: torque (frames, n_a) [N m or N], contacts per frame."""
        return dataclasses.replace(self, torque=torque, **_press(normals, geometries, self.fragile))

    def effort_words(self, knot: int) -> str:
        """The largest effort at a knot."""
        shares = self.effort_shares()[knot]
        return f"{100 * shares.max():.1f} % ({self.joints[int(shares.argmax())]})" if self.limited().any() else "no motor has a limit"

    def press_words(self, knot: int) -> str:
        """The largest press on a fragile thing at a knot."""
        shares = self.press_shares()[knot]
        worst = int(shares.argmax())
        if not self.presser[knot][worst]:
            return "0.0 %, nothing touches"
        pair = f"{self.presser[knot][worst]} – {self.fragile[worst]}"
        return f"{100 * shares[worst]:.1f} % ({pair}: {self.press[knot, worst]:.3g} of {self.max_force[worst]:.3g} N)"


def read_loads(data: dict[str, Any]) -> Loads:
    """Of the object of a plan file. Raises KeyError, TypeError, ValueError or IndexError."""
    text = data["scene_text"]
    springs = {name: (float(stiffness), float(effort or "inf")) for name, stiffness, effort in COORDINATE.findall(text)}
    joints = [str(name) for name in data["joints"]]
    for name in joints:
        if name not in springs:
            raise ValueError(f"scene_text: no coordinate {name!r}, which is one of joints")
    stiffness, effort = np.array([springs[name] for name in joints], dtype=float).reshape(-1, 2).T

    knots = [knot for segment in data["segments"] for knot in segment["knots"]]
    u, q = (np.array([knot[key] for knot in knots], dtype=float).reshape(len(knots), len(joints)) for key in ("u", "joints"))
    bears = {name: float(force) for name, force in FRAGILE.findall(text)}
    geometries = [str(geometry["name"]) for geometry in data["geometries"]]
    fragile = [name for name in geometries if name in bears]
    normals = [[(c["a"], c["b"], float(np.dot(c["force"], c["normal"]))) for c in knot["contacts"] if fragile] for knot in knots]
    return Loads(
        joints=joints,
        torque=stiffness * (u - q),
        effort=effort,
        fragile=fragile,
        max_force=np.array([bears[name] for name in fragile]),
        **_press(normals, geometries, fragile),
    )


def _press(normals: list[list[Normal]], geometries: list[str], fragile: list[str]) -> dict[str, Any]:
    """`press` and `presser` of Loads."""
    pressed = [_pressed(row, geometries, fragile) for row in normals]
    return {
        "press": np.array([[force for force, _ in row] for row in pressed]).reshape(len(normals), len(fragile)),
        "presser": [[name for _, name in row] for row in pressed],
    }


def _pressed(normals: list[Normal], geometries: list[str], fragile: list[str]) -> list[tuple[float, str]]:
    """Per fragile thing the largest sum of normal forces of one pair [N], and what presses."""
    pairs: dict[tuple[int, int], float] = {}
    for a, b, force in normals:
        pairs[a, b] = pairs.get((a, b), 0.0) + force
    worst = dict.fromkeys(fragile, (0.0, ""))
    for (a, b), force in pairs.items():
        for thing, other in ((geometries[a], geometries[b]), (geometries[b], geometries[a])):
            if thing in worst and force > worst[thing][0]:
                worst[thing] = (force, other)
    return [worst[name] for name in fragile]
