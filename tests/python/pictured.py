"""Built-in scenarios whose arm has pictures: red boxes around all of its balls, and one for its first link, which nothing can touch."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
WIDE = 1.2  # half a box, in radii of its ball
BALL = re.compile(r'<collision name="ball_\d">\s*<origin xyz="([^"]*)"/>\s*<geometry><sphere radius="([^"]*)"/></geometry>\s*</collision>')
RED = [255, 0, 0]
LINKS = 8


def picture(origin: str, radius: float) -> str:
    size = " ".join([str(2 * WIDE * radius)] * 3)
    return f"""<visual><origin xyz="{origin}"/><geometry><box size="{size}"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>"""


def arm(folder: Path) -> Path:
    """The file of the arm."""
    text, balls = BALL.subn(lambda found: found[0] + picture(found[1], float(found[2])), (ROOT / "models" / "iiwa7_balls.urdf").read_text())
    assert balls == 14
    file = folder / "arm.urdf"
    file.write_text(text.replace("</inertial>", f"</inertial>{picture('0 0 0.07', 0.06)}", 1))
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
