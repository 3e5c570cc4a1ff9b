"""Scenes in Drake, for the experiments. Drake is optional (`make experiments`): without it these tests are skipped."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
pytest.importorskip("pydrake", reason="Drake is not installed: `make experiments`")
sys.path[:0] = [str(MODULE), str(ROOT)]

from experiments.drake_plant import DrakePlant  # noqa: E402

SCENE = f"""
gravity: [0, 0, -10]
robots: [{{name: pusher, urdf: {ROOT}/models/planar_pusher.urdf, stiffness: 100}}]
objects:
  - {{name: ball, joint: free, mass: 1, shapes: [{{sphere: {{radius: 0.1}}}}]}}
  - {{name: box, joint: free, mass: 2, shapes: [{{box: {{size: [0.3, 0.2, 0.1]}}}}]}}
fixed: [{{name: ground, shapes: [{{half_space: {{}}, friction: 0.5}}]}}]
filters: [{{exclude: [pusher, "*"]}}]
"""
BALL, BOX = [5, 0, 0.1], [5, 2, 0.05]
RAMP = np.array([[0, 1.0], [0, 0]])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def start(plant: DrakePlant) -> np.ndarray:
    q = plant.library.neutral()
    for name, place in (("ball", BALL), ("box", BOX)):
        begin = next(item.q_begin for item in plant.library.objects if item.name == name)
        q[begin : begin + 3] = place
        q[begin + 3 : begin + 7] = [0, 0, np.sin(0.4), np.cos(0.4)]
    return q


def test_objects_rest_where_they_are_put(scene: Path) -> None:
    plant = DrakePlant(scene, 1e-2, [20.0, 20.0])
    q0 = start(plant)
    motion = plant.simulate(q0, np.array([0, 0.505]), np.zeros((2, 2)), record_interval=0.1)
    assert motion.steps == 50 and np.allclose(motion.times, [0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert np.array_equal(motion.q[:, 0], q0)
    assert np.max(np.abs(motion.q - q0[:, None])) < 1e-3


def test_joint_follows_a_ramp_with_the_lag_of_its_damping(scene: Path) -> None:
    """D q̇ = K (u - q) once the motion is steady, at any step: springs are implicit."""
    for h in (1e-3, 0.1):
        plant = DrakePlant(scene, h, [20.0, 20.0])
        motion = plant.simulate(start(plant), np.array([0, 10.0]), RAMP, record_interval=0.1)
        assert motion.q[-2, -1] == pytest.approx(1.0 - 20 / 100 * 0.1, abs=1e-6)
        held = DrakePlant(scene, h, [20.0, 20.0]).simulate(start(plant), np.array([0, 10.0]), RAMP, 0.1, ahead=0.0)
        assert held.q[-2, -1] == pytest.approx(1.0 - 20 / 100 * 0.1 - h * 0.1, abs=1e-6)


def test_pushed_object_slides_with_the_friction_of_the_pair(tmp_path: Path) -> None:
    """A flat box on a slope of 45°: acceleration g (sin - μ cos), with the mean 2 a b / (a + b) = 2/3 of 1 and 0.5."""
    path = tmp_path / "slope.yaml"
    path.write_text(SCENE.replace("[0, 0, -10]", "[10, 0, -10]"))
    plant = DrakePlant(path, 1e-3, [20.0, 20.0])
    motion = plant.simulate(start(plant), np.array([0, 0.3]), np.zeros((2, 2)), record_interval=0.1)
    begin = next(item.q_begin for item in plant.library.objects if item.name == "box")
    travel = motion.q[begin, -1] - BOX[0]
    assert travel == pytest.approx(0.5 * (10 - 2 / 3 * 10) * 0.3**2, rel=0.02)


def test_what_is_not_built_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.replace("mass: 2,", "mass: 2, inertia: [1, 1, 1],"))
    with pytest.raises(ValueError, match="object 'box': only a free object of one shape"):
        DrakePlant(path, 1e-2, [20.0, 20.0])
    path.write_text(SCENE)
    with pytest.raises(ValueError, match="damping has 1 values, expected 2"):
        DrakePlant(path, 1e-2, [20.0])
