"""The page of `stiction sense`: a robot coloured by how well a contact there explains its torques, candidates, and what can be felt where."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from . import bodies as drawn
from . import canvas, dress
from .plan import read_bodies, read_document, rotation_matrices

FORMAT = "stiction-sense"
FORMAT_VERSION = 1
MAX_MOMENTS = 150  # on the page; longer series are thinned evenly
MAX_OTHERS = 4  # candidates that do not explain the torques, the best of them
MAX_SETS = 3  # sets of contacts at the same time, the best of them
EXPLAINS: drawn.Color = drawn.FORCE
OTHER: drawn.Color = (122, 128, 140)
TRUTH: drawn.Color = (20, 140, 78)
VERDICTS = {"Explained": "explained", "Unexplained": "no single contact explains them", "BelowThreshold": "below the threshold"}


def load_sense(file: Path) -> dict[str, Any]:
    """Data of the page. Raises InvalidPlan."""
    return read_document(file, FORMAT, FORMAT_VERSION, _read)


def _read(data: dict[str, Any]) -> dict[str, Any]:
    moments = data["moments"]
    if not moments:
        raise ValueError("moments: none, nothing to draw")
    chosen = np.unique(np.linspace(0, len(moments) - 1, min(len(moments), MAX_MOMENTS)).round().astype(int))
    total, moments = len(moments), [moments[i] for i in chosen]
    bodies, geometries = read_bodies(data)
    looks = dress.of_scene(data.get("scene_file"))
    world = canvas.Scene(bodies, geometries, np.array([m["bodies"] for m in moments], dtype=float))
    everywhere = world.all_poses()

    entries, samples, seen = [], [], []
    for body, corners in world.parts():
        kind = bodies[body].kind
        fixed = kind != "robot"
        entries.append(canvas.mesh_entry(body, corners, drawn.FIXED if fixed else drawn.ROBOT_BASE, 0.5 if fixed else 1.0))
        if not fixed:
            seen.append((body, corners.reshape(-1, 3)))
    for index, link in enumerate(data["links"]):
        spacing = float(link["spacing"])
        points, normals = (np.reshape(np.array(link[key], dtype=float), (-1, 3)) for key in ("points", "point_normals"))
        corners = canvas.refine(np.reshape(np.array(link["corners"], dtype=float), (-1, 3, 3)), spacing)
        vertices, shading, triangles = canvas.shade(corners)
        near, weight = canvas.blend(vertices, shading, points, normals, spacing)
        entries.append(
            {
                "body": link["body"],
                "color": drawn.ROBOT,
                "alpha": 1.0,
                "link": index,
                "points": canvas.pack(vertices, "<f4"),
                "normals": canvas.pack(shading, "<f4"),
                "triangles": canvas.pack(triangles, "<u4"),
                "near": canvas.pack(near, "<u2"),
                "weight": canvas.pack(np.ceil(255 * weight), "u1"),
            }
        )
        lifted = points + 0.05 * spacing * normals  # above the surface, so that they are seen
        samples.append({"body": link["body"], "link": index, "points": canvas.pack(lifted, "<f4"), "normals": canvas.pack(normals, "<f4")})
        seen.append((link["body"], vertices))
    seen += canvas.seen_points(bodies, looks)

    arrows = [_arrows(moment) for moment in moments]
    cloud = np.concatenate([p @ rotation_matrices(pose[None, body, 3:])[0].T + pose[body, :3] for pose in everywhere[:: max(1, len(everywhere) // 5)] for body, p in seen])
    reach = 0.2 * float(np.linalg.norm(np.ptp(cloud, axis=0)))
    tails = [np.array(a["point"]) - reach * np.array(a["force"]) / np.linalg.norm(a["force"]) for some in arrows for a in some]
    cloud = np.concatenate([cloud, np.reshape(tails, (-1, 3))])
    first = next((a["force"] for some in arrows for a in some), None)
    view = canvas.look(cloud, -np.array(first) if first is not None else None)
    return {
        "title": data["scenario"],
        "description": data["description"],
        "view": view,
        "bodies": len(bodies),
        "meshes": canvas.dress(entries, bodies, looks),
        "samples": samples,
        "poses": canvas.pack(everywhere, "<f4"),
        "times": [m["t"] for m in moments],
        "arrows": arrows,
        "arrow": canvas.arrow_scale([float(np.linalg.norm(a["force"])) for some in arrows for a in some if a["color"] != OTHER], view["radius"]),
        "fields": _fields(data, moments),
        "rows": [["friction", f"{data['friction']:g}"], *([["shown", f"{len(moments)} of {total} moments"]] if len(moments) < total else []), *looks.rows()],
        "frame_rows": [_rows(m) for m in moments],
        "keys": [[EXPLAINS, "explains the torques"], [OTHER, "does not"], *([[TRUTH, "the contact"]] if data["truths"] else [])],
    }


def _arrows(moment: dict[str, Any]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    others = 0
    for number, candidate in enumerate(moment["candidates"], 1):
        others += not candidate["explains"]
        if others > MAX_OTHERS:
            break
        out.append(
            {
                "point": candidate["point"],
                "force": candidate["force"],
                "color": EXPLAINS if candidate["explains"] else OTHER,
                "wide": 1.0 if candidate["explains"] else 0.6,
                "ball": True,
                "label": str(number),
            }
        )
    for number, group in enumerate(_sets(moment), 1):
        for letter, contact in zip("abc", group["contacts"], strict=False):
            out.append({"point": contact["point"], "force": contact["force"], "color": EXPLAINS, "wide": 1.0, "ball": True, "label": f"{number}{letter}"})
    for number, truth in enumerate(moment["truths"], 1):
        out.append(
            {
                "point": truth["point"],
                "force": truth["force"],
                "color": TRUTH,
                "wide": 0.45,
                "ball": False,
                "front": True,
                "label": "the contact" if len(moment["truths"]) == 1 else f"contact {number}",
            }
        )
    return out


def _sets(moment: dict[str, Any]) -> list[dict[str, Any]]:
    """Sets of several contacts that explain the torques."""
    sets = moment.get("contact_sets")
    return sets["groups"][:MAX_SETS] if sets and sets["explained"] and sets["count"] > 1 else []


def _place_of(contact: dict[str, Any]) -> str:
    force = np.linalg.norm(contact["force"])
    return f"{contact['link'].split('/')[-1]} {force:.1f} N ± {100 * contact['deviation']:.1f} cm" + ("" if contact["unique"] else ", not unique")


def _rows(moment: dict[str, Any]) -> list[list[str]]:
    rows = [["torques", f"{moment['tau_norm']:.2f} N·m, {VERDICTS[moment['verdict']]}"]]
    if "posterior" in moment:
        rows += [["nothing touches", _percent(moment["posterior"]["nothing"])]]
        rows += [[f"95 %: {link['link'].split('/')[-1]}", _percent(link["probability"])] for link in moment["posterior"]["credible"]]
    for number, candidate in enumerate(moment["candidates"], 1):
        if candidate["explains"]:
            force, left = np.linalg.norm(candidate["force"]), np.sqrt(max(candidate["residual"], 0.0))
            where = f", within {100 * candidate['extent']:.1f} cm" if candidate["extent"] > 0 else ""
            rows.append([f"{number}  {candidate['link'].split('/')[-1]}", f"{force:.1f} N, leaves {left:.2f} N·m{where}"])
    sets = _sets(moment)
    if sets:
        rows.append([f"{moment['contact_sets']['count']} contacts", "ambiguous" if moment["contact_sets"]["ambiguous"] else "isolated"])
    for number, group in enumerate(sets, 1):
        rows += [[f"{number}{letter}", _place_of(contact)] for letter, contact in zip("abc", group["contacts"], strict=False)]
    return rows


def _percent(probability: float) -> str:
    return f"{100 * probability:.0f} %" if probability >= 0.005 or probability == 0 else "below 1 %"


def _credible(moments: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Places by the probability of a touch that likelier places hold."""
    if not all("posterior" in m for m in moments):
        return []
    return [
        {
            "name": "credible places",
            "low": "0: the likeliest",
            "high": "100 %: not touched",
            "meaning": "Share of the probability of a touch that likelier places hold. Places up to 95 % are the credible set.",
            "fades_from": 0.95,
            "values": [[canvas.shares(np.array(link)) for link in m["posterior"]["levels"]] for m in moments],
        }
    ]


def _fields(data: dict[str, Any], moments: list[dict[str, Any]]) -> list[dict[str, Any]]:
    residual = {
        "name": "residual",
        "low": "0: explained",
        "high": "100 %",
        "meaning": "Share of the torques, √l / ‖τ‖, that the best single force in the friction cone leaves over there.",
        "values": [
            [canvas.shares(np.sqrt(np.maximum(link, 0)) / m["tau_norm"] if m["tau_norm"] > 0 else np.ones(len(link))) for link in m["residuals"]]
            for m in moments
        ],
    }
    if "detectability" not in data:
        return [residual, *_credible(moments)]
    felt = data["detectability"]
    eta = {
        "name": "detectability η",
        "low": "0: every force is felt",
        "high": "100 %: none",
        "meaning": f"Share η of the forces of {felt['force']:.3g} N in the friction cone whose torque on the joint before the link is below {_span(felt['thresholds'])}.",
        "values": [[canvas.shares(np.array(link)) for link in felt["eta"]]],
    }
    return [residual, eta, *_credible(moments)]


def _span(thresholds: list[float | None]) -> str:
    """Least torques that joints show; None: a joint without a torque sensor."""
    known = [threshold for threshold in thresholds if threshold is not None]
    if not known:
        return "what it shows"
    least, most = min(known), max(known)
    return f"{least:.3g} N·m" if most - least <= 1e-9 * most else f"what it shows, {least:.3g} to {most:.3g} N·m"


def make_page(data: dict[str, Any]) -> str:
    return canvas.as_page(data["title"], data)
