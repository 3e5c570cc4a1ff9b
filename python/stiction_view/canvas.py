"""Pages of a scene with arrows, fields on surfaces and plots over time, drawn by canvas.js alone.

viser's player, which draws plans, has neither a field that changes on a surface nor plots that follow its time; this page has both.
"""

from __future__ import annotations

import base64
import html
import json
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from . import links
from .bodies import Color, body_meshes
from .looks import Looks
from .plan import Body, Geometry

CREASE = 0.8  # [rad] edges sharper than this look sharp
NEIGHBOURS = 4  # samples that colour a vertex


def pack(array: np.ndarray, kind: str) -> str:
    """Little-endian bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")


def shares(values: np.ndarray) -> str:
    """Numbers in [0, 1] in 16 bits."""
    return pack(np.round(np.clip(values, 0, 1) * 65535), "<u2")


# ---- meshes ----


def shade(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles (n, 3, 3) → vertices, their normals, triangles. A normal is the mean over triangles that meet there at less than CREASE, by area."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    corners, cross, area = corners[area > 0], cross[area > 0], area[area > 0]
    flat = cross / area[:, None]
    size = np.ptp(corners.reshape(-1, 3), axis=0).max()
    _, place = np.unique(np.round(corners.reshape(-1, 3) / (1e-6 * size)).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(place.ravel(), kind="stable")
    starts = np.flatnonzero(np.diff(place.ravel()[order], prepend=-1))
    normals = np.empty((3 * len(corners), 3))
    for group in np.split(order, starts[1:]):
        own = flat[group // 3]
        near = own @ own.T >= np.cos(CREASE)
        normals[group] = near @ cross[group // 3]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    both = np.column_stack([corners.reshape(-1, 3), normals])
    _, first, triangles = np.unique(np.round(both, 6), axis=0, return_index=True, return_inverse=True)
    return both[first, :3], both[first, 3:], triangles.reshape(-1, 3)


def refine(corners: np.ndarray, longest: float) -> np.ndarray:
    """Triangles (n, 3, 3) cut across their longest edges until none is longer."""
    done = []
    while len(corners):
        edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)  # edge k from corner k to the next
        worst = edges.argmax(axis=1)
        fine = edges.max(axis=1) <= longest
        done.append(corners[fine])
        coarse = np.take_along_axis(corners[~fine], ((worst[~fine][:, None] + np.arange(3)) % 3)[:, :, None], axis=1)
        middle = (coarse[:, 0] + coarse[:, 1]) / 2
        a, b = coarse.copy(), coarse.copy()
        a[:, 1], b[:, 0] = middle, middle
        corners = np.concatenate([a, b])
    return np.concatenate(done)


def blend(vertices: np.ndarray, normals: np.ndarray, points: np.ndarray, point_normals: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """The samples that colour each vertex and their weights (n, NEIGHBOURS): near in place, and on the same side of the surface."""
    count = min(NEIGHBOURS, len(points))
    near, weight = [], []
    for some in np.array_split(np.arange(len(vertices)), max(1, len(vertices) // 2000)):
        apart = ((vertices[some, None] - points[None]) ** 2).sum(axis=2) / spacing**2 + 4 * (1 - normals[some] @ point_normals.T)
        best = np.argpartition(apart, count - 1, axis=1)[:, :count]
        apart = np.take_along_axis(apart, best, axis=1)
        w = np.exp(apart.min(axis=1, keepdims=True) - apart)
        near.append(best)
        weight.append(w / w.sum(axis=1, keepdims=True))
    return np.concatenate(near), np.concatenate(weight)


def mesh_entry(body: int, corners: np.ndarray, color: Color, alpha: float = 1.0) -> dict[str, Any]:
    vertices, normals, triangles = shade(corners)
    return {
        "body": body,
        "color": color,
        "alpha": alpha,
        "points": pack(vertices, "<f4"),
        "normals": pack(normals, "<f4"),
        "triangles": pack(triangles, "<u4"),
    }


def dress(entries: list[dict[str, Any]], bodies: list[Body], looks: Looks) -> list[dict[str, Any]]:
    """Entries of what touches, and after them those of bodies as their files show them; the page draws one of both. Normals of the latter are left to the page."""
    drawn = {index: looks.patches[body.name] for index, body in enumerate(bodies) if body.name in looks.patches}
    touching = [entry | {"as": "touches"} if entry["body"] in drawn else entry for entry in entries]
    return touching + [
        {
            "as": "seen",
            "body": index,
            "color": patch.color,
            "alpha": 1.0 if patch.opacity is None else patch.opacity,
            "points": pack(patch.vertices, "<f4"),
            "triangles": pack(patch.triangles, "<u4"),
        }
        for index, patches in drawn.items()
        for patch in patches
    ]


def seen_points(bodies: list[Body], looks: Looks) -> list[tuple[int, np.ndarray]]:
    """Of bodies as their files show them, in their frames."""
    return [(index, patch.vertices.astype(float)) for index, body in enumerate(bodies) for patch in looks.patches.get(body.name, [])]


# ---- what moves ----


@dataclass
class Scene:
    """Bodies over the frames, as links.find and body_meshes take them."""

    bodies: list[Body]
    geometries: list[Geometry]
    poses: np.ndarray  # (frames, moving bodies, 7)

    def __post_init__(self) -> None:
        moving = sum(body.moving is not None for body in self.bodies)
        if self.poses.ndim != 3 or self.poses.shape[1:] != (moving, 7) or len(self.poses) == 0 or not np.isfinite(self.poses).all():
            raise ValueError(f"bodies of shape {self.poses.shape}, expected (frames, {moving}, 7) finite numbers")

    def all_poses(self) -> np.ndarray:
        """(frames, bodies, 7)"""
        out = np.empty((len(self.poses), len(self.bodies), 7))
        for index, body in enumerate(self.bodies):
            if body.moving is not None:
                out[:, index] = self.poses[:, body.moving]
            else:
                assert body.pose is not None
                out[:, index] = np.concatenate([body.pose.position, body.pose.wxyz])
        return out

    def parts(self) -> list[tuple[int, np.ndarray]]:
        """Triangles (n, 3, 3) of every body in its frame, with rods between spheres."""
        rods, _ = links.find(self)  # type: ignore[arg-type]
        return [(part.body, part.mesh[0][part.mesh[1]]) for part in body_meshes(self, rods)]  # type: ignore[arg-type]


def look(points: np.ndarray, outward: np.ndarray | None) -> dict[str, Any]:
    """A view of all points, from aside of where a contact pushes."""
    low, high = points.min(axis=0), points.max(axis=0)
    azimuth = -0.6
    if outward is not None and np.linalg.norm(outward[:2]) > 0.3 * np.linalg.norm(outward):
        azimuth = float(np.arctan2(outward[1], outward[0])) - 0.8
    elevation = -0.3 if outward is not None and outward[2] < -0.5 * np.linalg.norm(outward) else 0.35  # from below what pushes from below
    return {"look_at": ((low + high) / 2).tolist(), "radius": float(np.linalg.norm(high - low) / 2), "azimuth": azimuth, "elevation": elevation}


def arrow_scale(newtons: list[float], radius: float) -> dict[str, float]:
    """Metres per newton and the longest arrow [m]: a fifth of the scene for the middle force, at most twice that."""
    middle = float(np.median(newtons)) if newtons else 1.0
    longest = 0.4 * radius
    return {"scale": 0.5 * longest / max(middle, 1e-12), "longest": longest}


def as_page(title: str, data: dict[str, Any]) -> str:
    """One self-contained page."""
    folder = files(__package__)
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    page = folder.joinpath("canvas.html").read_text(encoding="utf-8").replace("@TITLE@", html.escape(title), 1)
    page = page.replace("@SCRIPT@", folder.joinpath("canvas.js").read_text(encoding="utf-8"), 1)
    return page.replace("@DATA@", text, 1)

