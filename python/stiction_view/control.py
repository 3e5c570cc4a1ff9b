"""The page of `stiction control`: the arm over time with its contact forces, and what was bounded, tracked and given up beneath it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from . import bodies as drawn
from . import canvas, dress
from .plan import read_bodies, read_document, rotation_matrices

FORMAT = "stiction-control"
FORMAT_VERSION = 1
FREE: drawn.Color = (70, 122, 214)
BOUND: drawn.Color = (20, 22, 28)
LINES: list[drawn.Color] = [(206, 24, 74), (70, 122, 214), (38, 160, 92), (238, 126, 36), (128, 112, 196), (20, 150, 160), (150, 110, 60)]
LAWS = {"contact_aware": "forces bounded", "unconstrained": "tracking alone", "null_space": "null space"}


def load_control(file: Path) -> dict[str, Any]:
    """Data of the page. Raises InvalidPlan."""
    return read_document(file, FORMAT, FORMAT_VERSION, read)


def line(name: str, color: drawn.Color, values: np.ndarray, dash: bool = False) -> dict[str, Any]:
    return {"name": name, "color": color, "values": canvas.pack(values, "<f4"), "dash": dash}


def plot(title: str, unit: str, lines: list[tuple[str, np.ndarray]], limit: float | None = None, limit_name: str = "", least: float = 0.0) -> dict[str, Any]:
    top = max([float(v.max()) for _, v in lines] + [limit or 0.0, least])
    entries = [line(name, LINES[k % len(LINES)], values) for k, (name, values) in enumerate(lines)]
    if limit is not None and lines:
        entries.append(line(limit_name, BOUND, np.full(len(lines[0][1]), limit), dash=True))
    return {"title": title, "unit": unit, "lines": entries, "low": min([float(v.min()) for _, v in lines] + [0.0]), "high": top if top > 0 else 1.0}


def read(data: dict[str, Any]) -> dict[str, Any]:
    """What the page is made of, from the document."""
    ticks, frames = data["ticks"], data["frames"]
    if not frames:
        raise ValueError("frames: none, nothing to draw")
    bodies, geometries = read_bodies(data)
    looks = dress.of_scene(data.get("scene_file"))
    world = canvas.Scene(bodies, geometries, np.array([f["bodies"] for f in frames], dtype=float))
    everywhere = world.all_poses()

    entries, seen = [], []
    for body, corners in world.parts():
        robot = bodies[body].kind == "robot"
        color = drawn.FIXED if bodies[body].kind == "fixed" else drawn.ROBOT if bodies[body].moving is not None else drawn.ROBOT_BASE
        entries.append(canvas.mesh_entry(body, corners, color, 1.0 if robot else 0.55))
        seen.append((body, corners.reshape(-1, 3)))
    seen += canvas.seen_points(bodies, looks)
    some = everywhere[:: max(1, len(everywhere) // 10)]
    robots = [p @ rotation_matrices(pose[None, b, 3:])[0].T + pose[b, :3] for pose in some for b, p in seen if bodies[b].kind == "robot"]
    cloud = np.concatenate(robots or [np.zeros((1, 3))])
    size = float(np.linalg.norm(np.ptp(cloud, axis=0)))
    for body, points in seen:  # a table as large as a room is not framed
        placed = points @ rotation_matrices(everywhere[0, None, body, 3:])[0].T + everywhere[0, body, :3]
        if bodies[body].kind != "robot" and np.linalg.norm(np.ptp(placed, axis=0)) < size:
            cloud = np.concatenate([cloud, placed])

    limit = float(data["lambda_max"])
    shown = [ticks[f["tick"]] for f in frames]
    arrows = [
        [
            {"point": f["point"], "force": f["force"], "color": drawn.FORCE, "label": f"{np.linalg.norm(f['force']):.1f} N"}
            for f in tick["forces"]
        ]
        for tick in shown
    ]
    pushes = [np.array(f["force"]) for tick in ticks for f in tick["forces"]]
    view = canvas.look(cloud, None)
    if pushes and np.linalg.norm(mean := np.sum(pushes, axis=0)) > 0:
        view["azimuth"] = float(np.arctan2(mean[1], mean[0])) + 0.5 * np.pi - 0.5 if np.linalg.norm(mean[:2]) > 0.3 * np.linalg.norm(mean) else view["azimuth"]
    return {
        "title": data["scenario"],
        "description": data["description"],
        "view": view,
        "bodies": len(bodies),
        "meshes": canvas.dress(entries, bodies, looks),
        "poses": canvas.pack(everywhere, "<f4"),
        "times": [t["t"] for t in shown],
        "arrows": arrows,
        "arrow": canvas.arrow_scale([float(np.linalg.norm(f)) for f in pushes], view["radius"]),
        "rows": [["law", LAWS.get(data["law"], data["law"])], ["bound", f"{limit:g} N"], ["impact", f"{max([float(np.linalg.norm(f)) for f in pushes], default=0.0):.1f} N at most"], *looks.rows()],
        "frame_rows": [_rows(data, tick) for tick in shown],
        "keys": [[drawn.FORCE, "contact force on the arm"]],
        "plot_times": canvas.pack(np.array([t["t"] for t in ticks]), "<f4"),
        "plots": _plots(data, ticks, limit),
    }


def _rows(data: dict[str, Any], tick: dict[str, Any]) -> list[list[str]]:
    error = f"{1e3 * tick['error']:.1f} {data['error_unit']}"
    force = max([float(np.linalg.norm(f["force"])) for f in tick["forces"]], default=0.0)
    return [["force", f"{force:.1f} N{', at its bound' if tick['bounded'] else ''}" if force > 0 else "free"], ["behind", error]]


def _plots(data: dict[str, Any], ticks: list[dict[str, Any]], limit: float) -> list[dict[str, Any]]:
    forces: dict[str, np.ndarray] = {}
    for k, tick in enumerate(ticks):
        for f in tick["forces"]:
            forces.setdefault(f"{f['a']} – {f['b']}", np.zeros(len(ticks)))[k] = np.linalg.norm(f["force"])
    short = {name: " – ".join(part.split("/", 1)[-1] for part in name.split(" – ")) for name in forces}
    torque = np.array([t["torque"] for t in ticks], dtype=float)
    joints = [name.split("/")[-1] for name in data["joints"]]
    effort = data["effort"]
    force_lines = [(short[name], values) for name, values in forces.items()] or [("no contact", np.zeros(len(ticks)))]
    plots = [
        plot("contact forces", "N", force_lines, limit, "λ_max"),
        plot("tracking error", data["error_unit"], [("", 1e3 * np.array([t["error"] for t in ticks]))]),
        plot("bound given up", "N", [("slack", np.array([t["slack"] for t in ticks]))], least=1e-3 * limit),  # below a thousandth of it, it counts as kept
    ]
    if all(most is not None for most in effort):
        share = 100 * torque / np.array(effort, dtype=float)
        plots.append(plot("motor torques", "% of their limits", [(name, share[:, j]) for j, name in enumerate(joints)]))
    else:
        plots.append(plot("motor torques", data["torque_unit"], [(name, torque[:, j]) for j, name in enumerate(joints)]))
    return plots


def make_page(data: dict[str, Any]) -> str:
    return canvas.as_page(data["title"], data)
