"""Bodies as their files show them: few triangles, sharp edges, colours, a switch to what touches, in pages and in the studio."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import browser
from stiction_view import meshes, surfaces

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402
from studio_driven import Driven  # noqa: E402

from stiction_view import dress, looks  # noqa: E402
from stiction_view.drawing import Drawing  # noqa: E402
from stiction_view.studio import catalog  # noqa: E402
from stiction_view.studio.app import Studio  # noqa: E402
from stiction_view.studio.panel import SEEN, TOUCHES  # noqa: E402
from stiction_view.studio.picture import Pictures  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402

# An arm whose upper link is only seen, whose finger has a picture around its collision sphere, and a puck as it touches.
SCENE = """<mujoco><asset><mesh name="wedge" vertex="0 0 0 .3 0 0 0 .1 0 0 0 .1"/><mesh name="lost" file="lost.stl"/></asset><worldbody>
  <geom type="plane" size="1 1 1"/>
  <body name="upper" pos="0 0 .06"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="a" axis="0 0 1"/>
    <geom type="mesh" mesh="wedge" contype="0" conaffinity="0" rgba="1 0 0 1"/>
    <body name="finger" pos=".3 0 0"><joint name="b" axis="0 0 1"/><geom size=".03"/><geom type="box" size=".2 .04 .04" pos=".1 0 0" contype="0" conaffinity="0" rgba="1 0 0 1"/></body></body>
  <body name="puck" pos="0.5 .2 0.02"><freejoint/><geom type="cylinder" size="0.04 0.02" mass="0.1"/></body></worldbody>
  <actuator><position joint="a" kp="50"/><position joint="b" kp="50"/></actuator></mujoco>"""
RED = (255, 0, 0)


def soup(surface: surfaces.Surface) -> surfaces.Surface:
    """As an STL file has it."""
    return surface[0][surface[1]].reshape(-1, 3), np.arange(3 * len(surface[1])).reshape(-1, 3)


def volume(surface: surfaces.Surface) -> float:
    a, b, c = (surface[0][surface[1][:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def box_of(count: int) -> surfaces.Surface:
    """A cube of edge 2 whose faces have 2 count² triangles each."""
    line = np.linspace(-1, 1, count + 1)
    u, v = (x.ravel() for x in np.meshgrid(line, line, indexing="ij"))
    i, j = (x.ravel() for x in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    a, b, c, d = ((i + di) * (count + 1) + j + dj for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    face = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    points, triangles = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            corner = np.empty((len(u), 3))
            corner[:, axis], corner[:, (axis + 1) % 3], corner[:, (axis + 2) % 3] = sign, u, v
            triangles.append((face if sign > 0 else face[:, ::-1]) + len(u) * len(points))
            points.append(corner)
    return np.concatenate(points), np.concatenate(triangles)


def test_points_that_a_file_repeats_are_welded_and_edges_stay_sharp() -> None:
    cube = surfaces.weld(soup(surfaces.weld(box_of(1))))
    assert (len(cube[0]), len(cube[1])) == (8, 12) and volume(cube) == pytest.approx(8)
    sharp = surfaces.split_creases(cube)
    assert len(sharp[0]) == 24, "three normals at each corner"
    assert volume(sharp) == pytest.approx(8)
    ball = surfaces.weld(soup(meshes.sphere(0.1)[:2]))
    assert len(surfaces.split_creases(ball)[0]) == len(ball[0]), "a ball has no edges"
    rod = surfaces.split_creases(surfaces.weld(soup(meshes.cylinder(0.1, 0.2)[:2])))
    assert len(rod[0]) == 4 * meshes.ROUND + 2 + 2 * meshes.ROUND, "the rim twice, once for the side and once for the lid"
    empty = surfaces.weld((np.zeros((3, 3)), np.array([[0, 1, 2]])))
    assert len(surfaces.split_creases(empty)[1]) == 0


@pytest.mark.parametrize("most", [300, 1000, 4000])
def test_simpler_surfaces_are_where_the_given_ones_are(most: int) -> None:
    cube = surfaces.weld(box_of(40))
    few = surfaces.simplify(cube, most)
    assert most / 4 < len(few[1]) <= most < len(cube[1])
    assert volume(few) == pytest.approx(8, rel=0.02) and np.abs(few[0]).max() == pytest.approx(1, abs=0.02)
    angles = np.linspace(0, np.pi, 121)[1:-1], np.linspace(0, 2 * np.pi, 160, endpoint=False)
    ball = surfaces.weld(meshes._revolve(np.column_stack([np.sin(angles[0]), -np.cos(angles[0])]), np.zeros(118))[:2])
    few = surfaces.simplify(ball, most)
    assert len(few[1]) <= most
    edge = np.sqrt(4 * np.pi / len(few[1]) * 2)
    np.testing.assert_allclose(np.linalg.norm(few[0], axis=1), 1, atol=edge**2 / 4)


def test_triangles_are_shared_out() -> None:
    assert surfaces.share_out([100, 5, 50], 1000) == 100, "enough for all"
    assert surfaces.share_out([100, 5, 50], 65) == 30
    assert surfaces.share_out([], 10) == 1


def test_way_out_ends_at_the_last_triangle_within_reach() -> None:
    inner, outer = box_of(2), box_of(3)
    thick = np.concatenate([inner[0], 1.5 * outer[0]]), np.concatenate([inner[1], outer[1] + len(inner[0])])
    x, y = np.array([[0.9, 0.1, 0.2], [1.2, 0.1, 0.2], [1.6, 0.1, 0.2]]), np.tile([1.0, 0, 0], (3, 1))
    np.testing.assert_allclose(surfaces.find_ways_out(x, y, thick, 1), [0.6, 0.3, 0], atol=1e-12)
    np.testing.assert_allclose(surfaces.find_ways_out(x, y, thick, 0.2), [0.1, 0, 0], atol=1e-12)
    assert not surfaces.find_ways_out(x, y, (np.empty((0, 3)), np.empty((0, 3), dtype=int)), 1).any()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "scene.xml").write_text(SCENE)
    return tmp_path / "scene.xml"


@pytest.fixture
def task(file: Path) -> st.Task:
    return st.Task({"scene": {"file": file.name}, "goal": {"objects": {"puck": {"position": [0.5, 0.3, 0.02]}}}, "tolerance": {"position": 0.01, "angle": 0.1}}, base=file.parent)


def test_looks_have_the_colours_of_the_file_and_no_more_triangles_than_a_page_bears(task: st.Task, monkeypatch: pytest.MonkeyPatch) -> None:
    found = looks.read_looks(task.model)
    assert set(found.patches) == {"robot/upper", "robot/finger", "puck"}
    assert [(p.color, p.opacity) for p in found.patches["robot/finger"]] == [(RED, None)]
    low, high = (f(found.mesh("robot/upper")[0], axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose([low, high], [[0, 0, 0], [0.3, 0.1, 0.1]], atol=1e-6)
    fine = surfaces.weld(box_of(60))

    class Fine:
        meshes = [fine, fine]
        notes: list[str] = []
        visuals = [type("Visual", (), {"body": k, "mesh": k % 2, "shape": None, "color": [1, 0, 0, 1], "X_BV": st.Pose(np.eye(3), [0, 0, 0])}) for k in range(3)]

    monkeypatch.setattr(st, "read_visuals", lambda _: Fine)
    monkeypatch.setattr(looks, "MOST_TRIANGLES", 6000)
    patches = [p for parts in looks.read_looks(task.model).patches.values() for p in parts]
    assert 3 * 500 < sum(len(p.triangles) for p in patches) <= 6000


def test_a_drawing_shows_one_of_both(task: st.Task) -> None:
    pictures = Pictures(task.model)
    plan = pictures.plan(task.q_start, task.goal.X_WG, task.goal.object, "scene")
    with serving("127.0.0.1", 0) as server:
        drawing = Drawing(server, plan, rods=pictures.rods(), looks=pictures.looks())
        assert drawing.view.radius > 0.25, "what is only seen is in the picture as well"
        colours = {name: [color for mesh, color in painted if mesh.visible] for name, painted in drawing.painted.items()}
        assert colours["robot/upper"] == colours["robot/finger"] == [RED]
        assert [ghost.visible for ghost in drawing.goal_ghosts[plan.goal_body]] == [True, False]
        drawing.show_as(seen=False)
        colours = {name: [color for mesh, color in painted if mesh.visible] for name, painted in drawing.painted.items()}
        assert colours["robot/upper"] == [] and RED not in colours["robot/finger"] and len(colours["puck"]) > 1
        assert [ghost.visible for ghost in drawing.goal_ghosts[plan.goal_body]] == [False, True]
        assert all(node.visible for node in drawing.loose_nodes), "the bones of an arm"


@pytest.fixture
def driven(file: Path, tmp_path: Path) -> Iterator[Driven]:
    (folder := tmp_path / "studio").mkdir()
    entries, first = catalog.find(str(file))
    with serving("127.0.0.1", 0) as server:
        yield Driven(Studio(server, entries, first, folder))


def test_the_studio_switches_and_says_what_is_left_out(driven: Driven) -> None:
    head, stage = driven.panel.head, driven.studio.stage
    assert head.seen.visible and head.seen.value == SEEN and driven.said == []
    assert "meshes whose files are missing" in head.notes.content and "lost" in head.notes.content
    assert stage.posed is not None and all(node.visible for node in stage.posed.seen)
    head.seen.value = TOUCHES
    driven.until(lambda: not stage.seen)
    assert not any(node.visible for node in stage.posed.seen) and all(node.visible for node in stage.posed.touched)
    driven.press("reset")
    driven.studio.posing.show(aim=True)
    assert not any(node.visible for node in stage.posed.seen), "it stays so"


def test_a_built_in_task_without_pictures_has_no_switch(tmp_path: Path) -> None:
    entries, first = catalog.find("planar_pushing")
    with serving("127.0.0.1", 0) as server:
        studio = Studio(server, entries, first, tmp_path)
        assert not studio.panel.head.seen.visible and studio.stage.posed.seen == []


def red(picture: np.ndarray) -> float:
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 150) & (g < 90) & (b < 90)).mean())


@browser.needed
def test_a_page_has_both_and_a_button(task: st.Task, tmp_path: Path) -> None:
    page = st.view(task, html=tmp_path / "page.html")
    assert page.stat().st_size < 5_000_000
    with browser.Browser() as chromium:
        label = "(document.querySelector('#stiction button') || {}).textContent"
        chromium.open(page)
        chromium.wait_for(lambda: chromium.evaluate(label) == "Show what touches", 120, "the page")
        chromium.wait_for(lambda: red(chromium.screenshot()) > 0.01, 120, "the red arm")
        chromium.evaluate("document.querySelector('#stiction button').click()")
        chromium.wait_for(lambda: chromium.evaluate(label) == "Show what is seen", 120, "the other recording")
        chromium.wait_for(lambda: np.abs(chromium.screenshot().astype(int) - 255).max(axis=2).mean() > 2 and red(chromium.screenshot()) < 0.001, 120, "the grey arm")
        assert chromium.errors == []
    assert "<button>" not in st.show(st.load_task("planar_pushing")).html, "where no file shows anything, there is nothing to switch"


def test_a_plan_of_a_file_is_dressed_and_one_whose_scene_is_gone_is_not(task: st.Task, file: Path, tmp_path: Path) -> None:
    from stiction_view import load_plan

    plan = task.follow([task.q_start[-2:] + [0.1, 0.0], task.q_start[-2:] + [0.2, 0.1]])
    plan.write(tmp_path / "plan.json")
    drawn = load_plan(tmp_path / "plan.json")
    dressed, seen = dress.of_file(tmp_path / "plan.json", drawn)
    names = [body.name for body in dressed.bodies]
    assert "robot/upper" in names and "robot/upper" in seen.patches and "robot/upper" not in [body.name for body in drawn.bodies]
    known = [name for name in names if name in task.model.body_poses(task.q_start)]
    assert known == names and dressed.poses.shape[0] == len(drawn.poses)
    X = task.model.body_poses(plan.q[-1])["robot/upper"]
    row = dressed.poses[-1, dressed.bodies[names.index("robot/upper")].moving]
    np.testing.assert_allclose(row[:3], X.p, atol=1e-6)
    assert "robot/upper" not in dress.of_file(tmp_path / "plan.json", drawn, bare=False)[1].patches
    file.unlink()
    assert dress.of_file(tmp_path / "plan.json", drawn) == (drawn, looks.NOTHING)
