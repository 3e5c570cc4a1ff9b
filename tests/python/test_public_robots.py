"""Every URDF of the package example-robot-data, as it is: it loads, takes a step, and its geometry is where Pinocchio has it."""

from __future__ import annotations

import itertools
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path[:0] = [str(MODULE), str(ROOT / "bench")]

import pinocchio  # noqa: E402
from public_robots import PACKAGES, load, urdf_files  # noqa: E402
import stiction as st  # noqa: E402

FILES = urdf_files(PACKAGES / "example-robot-data" / "robots")
REFUSED = {
    "alex_psyonic_hands.urdf": "unknown joint 'index_q1' to mimic",
    "ur3.urdf": "got no link, in a file of xacro",
}
CAPSULES = {("simple_humanoid.urdf", "BODY")}  # an element of the file tells Pinocchio to take its cylinder as a capsule
DIRECTIONS = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def support(d: np.ndarray, kind: str, radius: float = 0, half_length: float = 0, half_extents=(), points=()) -> np.ndarray:
    """Of a shape in its own frame, in the directions d."""
    if kind == "mesh":
        return (d @ np.asarray(points).T).max(axis=1)
    if kind == "box":
        return np.abs(d) @ np.asarray(half_extents)
    if kind == "cylinder":
        return radius * np.hypot(d[:, 0], d[:, 1]) + half_length * np.abs(d[:, 2])
    return radius + half_length * np.abs(d[:, 2])  # of a sphere, half_length is 0


def of_stiction(model: st.Model) -> dict[str, np.ndarray]:
    """Per link, in its frame: the support of all its collision geometry."""
    out = defaultdict(lambda: np.full(len(DIRECTIONS), -np.inf))
    for geometry in model.geometries:
        body = model.bodies[geometry.body]
        if body.kind != st.BodyKind.Robot:
            continue
        shape = dict(geometry.shape)
        kind = shape.pop("type")
        if kind == "mesh":
            shape = {"points": shape["vertices"]}
        link = body.name.removeprefix("robot/")
        h = support(DIRECTIONS @ geometry.X_BG.R, kind, **shape) + DIRECTIONS @ geometry.X_BG.p
        out[link] = np.maximum(out[link], h)
    return dict(out)


def of_pinocchio(file: Path) -> dict[str, np.ndarray]:
    model = pinocchio.buildModelFromUrdf(str(file))
    collision = pinocchio.buildGeomFromUrdf(model, str(file), pinocchio.GeometryType.COLLISION, package_dirs=[str(PACKAGES)])
    out = defaultdict(lambda: np.full(len(DIRECTIONS), -np.inf))
    for item in collision.geometryObjects:
        frame = model.frames[item.parentFrame]
        X = frame.placement.inverse() * item.placement
        d, shape = DIRECTIONS @ X.rotation, item.geometry
        kind = type(shape).__name__.lower()
        if kind == "box":
            h = support(d, kind, half_extents=shape.halfSide)
        elif kind in ("cylinder", "capsule"):
            h = support(d, kind, shape.radius, shape.halfLength)
        elif kind == "sphere":
            h = support(d, kind, shape.radius)
        else:
            h = support(d, "mesh", points=shape.vertices() if hasattr(shape, "vertices") else shape.points())
        out[frame.name] = np.maximum(out[frame.name], h + DIRECTIONS @ X.translation)
    return dict(out)


def test_the_package_is_there() -> None:
    assert len(FILES) >= 60


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_robot_loads_takes_a_step_and_has_its_geometry(file: Path) -> None:
    if file.name in REFUSED:
        with pytest.raises(st.InvalidInput, match=REFUSED[file.name]):
            load(file)
        return
    model, status = load(file)
    assert status == st.Status.Solved
    assert (model.stiffness > 0).all() and (model.lower < model.upper).all()
    ours, theirs = of_stiction(model), of_pinocchio(file)
    assert ours.keys() == theirs.keys()
    for link, h in theirs.items():
        if (file.name, link) in CAPSULES:
            continue
        size = np.abs(h).max()
        # Hulls of meshes are inside those of the files, by 0.2 % of a diagonal, that is of 2√3 size, at most (decision 25).
        outside, inside = (ours[link] - h).max(), (h - ours[link]).max()
        assert outside <= 1e-6 * size and inside <= 2e-3 * 2 * np.sqrt(3) * size, f"{link}: {outside} m outside, {inside} m inside, of {size}"
