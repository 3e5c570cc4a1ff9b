"""Built-in scenarios whose arm has pictures: red boxes around all of its links, also around the first, which nothing can touch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
HALF = 0.09  # of a box: more than the radius of a ball of this arm
PICTURE = f"""<visual><origin xyz="0 0 0.03"/><geometry><box size="{2 * HALF} {2 * HALF} {2 * HALF}"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>"""
RED = [255, 0, 0]
LINKS = 8


def arm(folder: Path) -> Path:
    """The file of the arm."""
    file = folder / "arm.urdf"
    file.write_text((ROOT / "models" / "iiwa7_balls.urdf").read_text().replace("</inertial>", f"</inertial>{PICTURE}"))
    return file


def of(name: str, folder: Path) -> Path:
    """A built-in scenario with this arm."""
    return write(yaml.safe_load((ROOT / "scenarios" / f"{name}.yaml").read_text()), folder)


def write(scenario: dict[str, Any], folder: Path) -> Path:
    scenario["scene"]["robots"][0]["urdf"] = str(arm(folder))
    (file := folder / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    return file


def check(page: dict[str, Any]) -> None:
    """What is drawn of the links of the arm."""
    seen = [mesh for mesh in page["meshes"] if mesh.get("as") == "seen"]
    touches = [mesh for mesh in page["meshes"] if mesh.get("as") == "touches"]
    assert len(seen) == LINKS and all(mesh["color"] == RED and mesh["alpha"] == 1 for mesh in seen)
    bodies = [mesh["body"] for mesh in seen]
    assert len({mesh["body"] for mesh in touches}) == LINKS - 1 and {mesh["body"] for mesh in touches} < set(bodies), "nothing can touch the first link"
    assert not any(mesh["body"] in bodies for mesh in page["meshes"] if "as" not in mesh), "bodies without pictures are in both"


def arrows(picture: np.ndarray) -> float:
    """Of the colour of forces."""
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 100) & (g < 0.25 * r) & (b > 0.3 * r) & (b < 0.45 * r)).mean())


def red(picture: np.ndarray) -> float:
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 100) & (g < 0.25 * r) & (b < 0.25 * r)).mean())
