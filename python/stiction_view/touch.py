"""The page of `stiction touch`: the arm among things that it does not know, what it felt and took into its map, where it planned to go, and the forces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from . import bodies as drawn
from . import canvas, control, links, meshes
from .plan import read_document

FORMAT = "stiction-touch"
FORMAT_VERSION = 1
UNKNOWN: drawn.Color = (238, 126, 36)
BALL: drawn.Color = (70, 122, 214)
ROUTE: drawn.Color = (38, 160, 92)
ESTIMATE: drawn.Color = BALL
SIDES = 6  # of a route


def load_touch(file: Path) -> dict[str, Any]:
    """Data of the page. Raises InvalidPlan."""
    return read_document(file, FORMAT, FORMAT_VERSION, _read)


def tube(points: np.ndarray, radius: float) -> np.ndarray:
    """Triangles (n, 3, 3) around a polyline (k, 3)."""
    angle = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)])
    out = []
    for a, b in zip(points, points[1:]):
        if np.linalg.norm(b - a) < 1e-3 * radius:
            continue
        low = ring @ links.along(b - a).T
        after = np.roll(low, -1, axis=0)
        out += [np.stack([a + low, a + after, b + after], axis=1), np.stack([a + low, b + after, b + low], axis=1)]
    return np.concatenate(out) if out else np.zeros((0, 3, 3))


def _ball(touch: dict[str, Any]) -> np.ndarray:
    vertices, triangles, _ = meshes.sphere(touch["radius"] + touch["spread"])
    return (vertices + np.array(touch["point"]) - touch["radius"] * np.array(touch["normal"]))[triangles]


def _read(data: dict[str, Any]) -> dict[str, Any]:
    data["bodies"].append({"name": "map", "kind": "fixed", "moving": False, "position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]})
    data["description"] = data["description"] or ""
    page = control.read(data)
    place, frames = len(data["bodies"]) - 1, len(page["times"])
    unknown = {k for k, body in enumerate(data["bodies"]) if body["name"] in data["unknown"]}
    for mesh in page["meshes"]:
        if mesh["body"] in unknown:  # of which no file shows anything
            mesh.update(color=UNKNOWN, alpha=0.3)

    def since(t: float) -> int:
        return int(np.searchsorted(page["times"], t))

    for touch in data["touches"]:
        page["meshes"].append(canvas.mesh_entry(place, _ball(touch), BALL, 0.45) | {"frames": [since(touch["t"]), frames], "mark": True})
    ends = [since(route["t"]) for route in data["routes"][1:]] + [frames]
    for route, end in zip(data["routes"], ends):
        corners = tube(np.array(route["points"], dtype=float).reshape(-1, 3), 0.006 * page["view"]["radius"])
        if len(corners):
            page["meshes"].append(canvas.mesh_entry(place, corners, ROUTE) | {"frames": [since(route["t"]), end], "mark": True})

    shown = [data["ticks"][f["tick"]] for f in data["frames"]]
    for tick, arrows, rows in zip(shown, page["arrows"], page["frame_rows"]):
        told = tick.get("told")
        if told is not None:
            size = float(np.linalg.norm(told["force"]))
            arrows.append({"point": told["point"], "force": told["force"], "color": ESTIMATE, "label": f"felt {size:.1f} N", "ball": True, "front": True})
        rows[-1:] = [["felt", _told(data, tick)], ["to the goal", f"{tick['to_goal']:.2f} rad"], ["known", _known(data, tick["t"])]]
    page["rows"] = [
        ["outcome", "reached its goal" if data["outcome"] == "Reached" else f"gave up: {data['reason']}"],
        ["bound", f"{data['lambda_max']:g} N"],
        ["located", _located(data)],
    ]
    page["keys"] = [[drawn.FORCE, "contact force"], [ESTIMATE, "as felt by the joints; what the map has of it"], [UNKNOWN, "there, but not known"], [ROUTE, "planned way of the hand"]]
    page["plots"] = _plots(data, page["plots"])
    return page


def _told(data: dict[str, Any], tick: dict[str, Any]) -> str:
    told = tick.get("told")
    if told is None:
        return "nothing"
    size = f"{float(np.linalg.norm(told['force'])):.1f} N"
    if not tick["forces"]:
        return size
    apart = min(float(np.linalg.norm(np.subtract(told["point"], f["point"]))) for f in tick["forces"])
    return f"{size}, {100 * apart:.1f} cm from the contact"


def _known(data: dict[str, Any], t: float) -> str:
    count = sum(touch["t"] <= t for touch in data["touches"])
    return "nothing in its way" if count == 0 else f"{count} place{'s' if count > 1 else ''} touched"


def _located(data: dict[str, Any]) -> str:
    errors = [touch["error"] for touch in data["touches"] if touch["error"] is not None]
    return ", ".join(f"{100 * e:.1f}" for e in errors) + " cm from the contacts" if errors else "nothing"


def _plots(data: dict[str, Any], plots: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Forces with their estimate, the way that is left, tracking and torques."""
    ticks = data["ticks"]
    forces, error, _, torques = plots
    felt = np.array([np.linalg.norm(t["told"]["force"]) if t.get("told") else 0.0 for t in ticks])
    forces["lines"].append(control.line("felt", ESTIMATE, felt))
    forces["high"] = max(forces["high"], float(felt.max()))
    left = control.plot("to the goal", "rad", [("largest joint", np.array([t["to_goal"] for t in ticks]))])
    return [forces, left, error, torques]


def make_page(data: dict[str, Any]) -> str:
    return canvas.as_page(data["title"], data)
