"""What a plan asks of motors and contacts, knot by knot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import stiction as st


@dataclass(frozen=True)
class Series:
    """Rows are knots. NaN where there is nothing to say of."""

    joints: list[str]
    torque: np.ndarray  # (knots, n_a) of the joint springs, K (u − q) [N m or N]
    effort: np.ndarray  # (n_a), infinite where a motor has no limit
    friction_use: np.ndarray  # (knots) largest |f_t| / (μ f_n) of a contact, 1: it slides
    force: np.ndarray  # (knots) largest of a contact [N]
    gap: np.ndarray  # (knots) smallest signed distance of a contact before the step [m]

    def effort_share(self) -> np.ndarray:
        """(knots) largest |torque| / effort of a joint; NaN where no motor has a limit."""
        limited = np.isfinite(self.effort)
        if not limited.any():
            return np.full(len(self.torque), np.nan)
        return (np.abs(self.torque[:, limited]) / self.effort[limited]).max(axis=1)

    def line(self, knot: int) -> str:
        """The figures of one knot in words."""
        share, use, force, gap = self.effort_share()[knot], self.friction_use[knot], self.force[knot], self.gap[knot]
        worst = int(np.nanargmax(np.where(np.isfinite(self.effort), np.abs(self.torque[knot]) / self.effort, -1))) if np.isfinite(share) else -1
        motor = f"{100 * share:.1f} % of their effort ({self.joints[worst]})" if worst >= 0 else "no motor has a limit"
        touch = f"{force:.2f} N, friction used {100 * use:.0f} %, gap {round(1e3 * gap, 2) + 0.0:.2f} mm" if np.isfinite(force) else "nothing touches"
        return f"**motors** {motor}  \n**contacts** {touch}"


def _knot(knot: dict[str, Any]) -> tuple[float, float, float]:
    """Friction use, force and gap of the contacts that press."""
    use, largest, gap = np.nan, np.nan, np.nan
    for contact in knot["contacts"]:
        force, normal = np.array(contact["force"]), np.array(contact["normal"])
        pressed = float(force @ normal)
        if pressed <= 0:
            continue
        largest = np.fmax(largest, np.linalg.norm(force))
        gap = np.fmin(gap, contact["gap"])
        if contact["friction"] > 0:
            use = np.fmax(use, np.linalg.norm(force - pressed * normal) / (contact["friction"] * pressed))
    return float(use), float(largest), float(gap)


def make_series(model: st.Model, data: dict[str, Any]) -> Series:
    """Of the object of a plan file."""
    knots = [knot for segment in data["segments"] for knot in segment["knots"]]
    u, q = (np.array([knot[key] for knot in knots]).reshape(len(knots), -1) for key in ("u", "joints"))
    use, force, gap = np.array([_knot(knot) for knot in knots]).T
    return Series(list(model.joint_names), model.stiffness * (u - q), np.array(model.effort), use, force, gap)
