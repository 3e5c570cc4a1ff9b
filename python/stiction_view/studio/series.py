"""What a plan asks of motors and contacts, knot by knot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..loads import Loads, read_loads
from .texts import plain


@dataclass(frozen=True)
class Series(Loads):
    """Rows are knots. NaN where there is nothing to say of."""

    friction_use: np.ndarray  # (knots) largest |f_t| / (μ f_n) of a contact, 1: it slides
    force: np.ndarray  # (knots) largest of a contact [N]
    gap: np.ndarray  # (knots) smallest signed distance of a contact before the step [m]

    def line(self, knot: int) -> str:
        """The figures of one knot in words."""
        use, force, gap = self.friction_use[knot], self.force[knot], self.gap[knot]
        motor = plain(self.effort_words(knot).replace(" %", " % of their effort", 1))
        touch = f"{force:.2f} N, friction used {100 * use:.0f} %, gap {round(1e3 * gap, 2) + 0.0:.2f} mm" if np.isfinite(force) else "nothing touches"
        return f"**motors** {motor}  \n**contacts** {touch}" + (f"  \n**max_force** {self.press_words(knot)}" if self.fragile else "")


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


def make_series(data: dict[str, Any]) -> Series:
    """Of the object of a plan file."""
    knots = [knot for segment in data["segments"] for knot in segment["knots"]]
    use, force, gap = np.array([_knot(knot) for knot in knots]).T
    return Series(**vars(read_loads(data)), friction_use=use, force=force, gap=gap)
