"""A small plan file made in memory: two fingers turn a ball in a bowl of two boxes; no part of the library is needed."""

from __future__ import annotations

import math
from typing import Any


def _quaternion_z(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def make_scene_text(effort: float | None = 2.0, max_force: float | None = None) -> str:
    """The lines that a picture needs, in the form of the program: a spring of 10 N m/rad, and a ball that bears max_force."""
    motor = "" if effort is None else f", effort: {effort:.12g}"
    bears = "" if max_force is None else f", max_force: {max_force:.12g}"
    return (
        "coordinates:\n- {name: ball/x, lower: -inf, upper: inf, stiffness: 0, friction: 0.1, damping: 0.2}\n"
        f"- {{name: hand/sweep, lower: -3, upper: 1e+03, stiffness: 10{motor}}}\n"
        "geometries:\n- {name: table/top, shape: {half_space: true}, pose: {p: [0, 0, 0], R: [1, 0, 0, 0, 1, 0, 0, 0, 1]}, friction: 0.8}\n"
        f"- {{name: ball/ball, shape: {{sphere: 0.06}}, pose: {{p: [0, 0, 0], R: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}, friction: 0.8{bears}}}\n"
    )


def make_plan(knots_per_segment: int = 12, kinds: tuple[str, ...] = ("settle", "contact", "regrasp", "contact")) -> dict[str, Any]:
    radius, distance = 0.06, 0.075
    bodies = [
        {"name": "hand/palm", "kind": "robot", "moving": False, "position": [0, 0, -0.09], "quaternion_wxyz": [1, 0, 0, 0]},
        {"name": "hand/left", "kind": "robot", "moving": True},
        {"name": "hand/right", "kind": "robot", "moving": True},
        {"name": "ball", "kind": "object", "moving": True},
        {"name": "table", "kind": "fixed", "moving": False, "position": [0, 0, -0.1], "quaternion_wxyz": [1, 0, 0, 0]},
    ]
    origin = {"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0], "friction": 0.8}
    geometries = [
        {"name": "hand/palm/box", "body": 0, "shape": {"type": "box", "half_extents": [0.05, 0.08, 0.01]}, **origin},
        {"name": "hand/left/finger", "body": 1, "shape": {"type": "capsule", "radius": 0.012, "half_length": 0.03}, **origin},
        {"name": "hand/right/finger", "body": 2, "shape": {"type": "cylinder", "radius": 0.012, "half_length": 0.04}, **origin},
        {"name": "ball/ball", "body": 3, "shape": {"type": "sphere", "radius": radius}, **origin},
        {"name": "table/top", "body": 4, "shape": {"type": "half_space"}, **origin},
        {
            "name": "hand/palm/wedge",
            "body": 0,
            "shape": {
                "type": "mesh",
                "vertices": [[-0.05, 0, 0.01], [0.05, 0, 0.01], [0, 0.03, 0.01], [0, 0.01, 0.025]],
                "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            },
            **origin,
        },
    ]
    segments = []
    angle, sweep = 0.0, 0.0
    for kind in kinds:
        knots = []
        for k in range(knots_per_segment):
            if kind == "contact":
                angle += 0.03
                sweep += 0.03
            elif kind == "regrasp":
                sweep -= 0.03
            away = distance + (0.03 * math.sin(math.pi * k / knots_per_segment) if kind == "regrasp" else 0.0)
            fingers = [[s * away * math.cos(sweep), s * away * math.sin(sweep), 0.0] for s in (1.0, -1.0)]
            contacts = []
            if kind == "contact":
                for index, p in enumerate(fingers):
                    normal = [-c / away for c in p]
                    contacts.append(
                        {
                            "a": 3,
                            "b": 1 + index,
                            "point": [radius / away * c for c in p],
                            "normal": normal,
                            "force": [4.0 * normal[0] - normal[1], 4.0 * normal[1] + normal[0], 0.0],
                            "friction": 0.8,
                            "gap": 0.0,
                        }
                    )
            knots.append(
                {
                    "u": [sweep],
                    "joints": [sweep],
                    "objects": [{"position": [0, 0, 0], "quaternion_wxyz": _quaternion_z(angle)}],
                    "bodies": [[*p, 1.0, 0.0, 0.0, 0.0] for p in fingers] + [[0.0, 0.0, 0.0, *_quaternion_z(angle)]],
                    "contacts": contacts,
                }
            )
        segments.append({"kind": kind, "knots": knots})
    return {
        "format": "stiction-plan",
        "format_version": 1,
        "code_version": "0.1.0",
        "task": {"name": "two fingers & a ball", "builtin": False, "file": "task.yaml"},
        "scene_sha256": "0" * 64,
        "scene_text": make_scene_text(),
        "status": "Solved",
        "seed": 7,
        "options": {},
        "statistics": {},
        "timing": {"wall_s": 0.1, "threads": 1, "created": "2026-01-01T00:00:00Z"},
        "step": {"h": 0.1},
        "substep": None,
        "joints": ["hand/sweep"],
        "objects": [{"name": "ball", "joint": "free"}],
        "bodies": bodies,
        "geometries": geometries,
        "start": {"u": [0.0], "joints": [0.0], "objects": [{"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]},
        "goal": {
            "object": "ball",
            "position": [0.0, 0.0, 0.002],
            "quaternion_wxyz": _quaternion_z(0.8),
            "tolerance": {"position": 0.01, "angle": 0.1},
            "from": "task",
        },
        "error": {"position": 0.002, "angle": abs(0.8 - angle)},
        "segments": segments,
        "tree": [
            {"parent": -1, "edge": "settle", "object": [0, 0, 0, 1, 0, 0, 0]},
            {"parent": 0, "edge": "contact", "object": [0, 0, 0, *_quaternion_z(angle)]},
            {"parent": 0, "edge": "contact", "object": [0, 0, 0, *_quaternion_z(-angle)]},
        ],
    }
