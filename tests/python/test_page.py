"""The page of a plan: drawn by a real browser, nothing logged as an error, nothing fetched, small."""

from __future__ import annotations

import copy
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import children
import numpy as np
import pytest

import browser
import synthetic
from stiction_view import InvalidPlan, load_plan
from stiction_view.bodies import body_meshes
from stiction_view.camera import choose_view, make_cloud, sample_surfaces, visible
from stiction_view.frames import MAX_FRAMES, choose_frames, frame_times
from stiction_view.scene import make_page

MAX_BYTES = 10_000_000


def write(folder: Path, plan: dict) -> Path:
    file = folder / "plan.json"
    file.write_text(json.dumps(plan))
    return file


def view(root: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    return children.run(
        [sys.executable, "-m", "stiction_view", *arguments],
        env={**os.environ, "PYTHONPATH": str(root / "python")},
        limit=120,
    )


# ---- the page in a browser ----


def share(picture: np.ndarray, hue: tuple[float, float], saturation: float = 0.25) -> float:
    """Part of the pixels whose hue [degrees] lies in a range and that are coloured at all."""
    rgb = picture.astype(float) / 255
    high, low = rgb.max(axis=2), rgb.min(axis=2)
    spread = np.where(high > low, high - low, 1.0)
    r, g, b = np.moveaxis(rgb, 2, 0)
    angle = 60 * np.select([high == r, high == g], [((g - b) / spread) % 6, (b - r) / spread + 2], (r - g) / spread + 4)
    coloured = (high - low > saturation * np.maximum(high, 1e-9)) & (high > 0.2)
    return float((coloured & (angle >= hue[0]) & (angle <= hue[1])).mean())


ORANGE, BLUE, PINK = (15, 48), (205, 235), (318, 352)


@pytest.fixture(scope="module")
def page(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    done = view(root, write(folder, synthetic.make_plan()), "--html", folder / "plan.html")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "" and done.stderr == ""
    return folder / "plan.html"


def scene(window: browser.Browser) -> np.ndarray:
    """The part of the picture that only the 3-D scene draws: right of viser's notes, above the time bar, our panel hidden."""
    window.evaluate("document.getElementById('stiction').style.display = 'none'")
    picture = window.screenshot()
    return picture[: int(0.85 * len(picture)), int(0.38 * picture.shape[1]) :]


def scene_at(window: browser.Browser, fraction: float) -> np.ndarray:
    """The scene after a click on the time bar. Asked again and again: on a slow machine the page drops clicks while it still loads."""
    window.scrub(fraction)
    return scene(window)


def check_quiet(window: browser.Browser) -> None:
    assert window.errors == []
    outside = [url[:120] for url in window.requests if not url.startswith(("file:", "data:", "blob:"))]
    assert outside == []


def open_page(window: browser.Browser, file: Path) -> None:
    window.open(file)
    window.wait_for(lambda: window.evaluate("document.querySelector('.mantine-Slider-track') !== null"), 90, "the time bar")


@browser.needed
def test_page_in_chromium_draws_object_forces_and_regrasp(page: Path) -> None:
    with browser.Browser() as window:
        open_page(window, page)
        assert window.evaluate("document.title") == "two fingers & a ball · stiction"
        assert "2.0 mm" in window.evaluate("document.getElementById('stiction').innerText")

        # In the second push the ball and the force arrows show, and the fingers are grey.
        picture = window.wait_for(lambda: p if share(p := scene_at(window, 0.95), ORANGE) > 0.02 else None, 180, "the ball")
        pushing = window.wait_for(lambda: p if share(p := scene_at(window, 0.95), PINK) > 0.001 else None, 180, "force arrows")
        assert share(pushing, BLUE) < 0.001
        assert (np.abs(picture.astype(int) - 255).max(axis=2) > 20).mean() > 0.1, "more than the background"

        # While regrasping the fingers are blue and there are no forces; going backwards works.
        regrasp = window.wait_for(lambda: p if share(p := scene_at(window, 0.5), BLUE) > 0.006 else None, 180, "blue fingers")
        assert share(regrasp, ORANGE) > 0.02
        assert share(regrasp, PINK) < 0.0005
        check_quiet(window)


def test_page_draws_the_search_tree_where_the_plan_has_one(tmp_path: Path) -> None:
    plan = synthetic.make_plan()
    with_tree = make_page(load_plan(write(tmp_path, plan)))
    plan["tree"] = []
    without = make_page(load_plan(write(tmp_path, plan)))
    assert "search tree" in with_tree and "search tree" not in without
    assert len(with_tree) > len(without)


def test_wall_hides_what_is_behind_it(tmp_path: Path) -> None:
    plan = synthetic.make_plan()
    plan["bodies"].append({"name": "wall", "kind": "fixed", "moving": False, "position": [0.3, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]})
    wall = {"type": "box", "half_extents": [0.01, 0.4, 0.4]}
    origin = {"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0], "friction": 0.5}
    plan["geometries"].append({"name": "wall/slab", "body": len(plan["bodies"]) - 1, "shape": wall, **origin})
    loaded = load_plan(write(tmp_path, plan))
    parts = body_meshes(loaded, {})
    assert choose_view(loaded, parts, choose_frames(loaded)).position[0] < 0.3
    samples = sample_surfaces(loaded, parts)
    cloud = make_cloud(loaded, samples, 0)
    assert visible(cloud, np.array([1.0, 0.0, 0.5])) < 0.1, "a wall has no gaps"
    assert visible(cloud, np.array([-1.0, 0.0, 0.5])) > 0.5
    del samples[loaded.goal_body]
    cloud = make_cloud(loaded, samples, 0)  # of an object without a surface
    with np.errstate(all="raise"):
        assert visible(cloud, np.array([1.0, 0.0, 0.5]), ~cloud.is_object) > 0
        assert visible(cloud, np.array([1.0, 0.0, 0.5])) == 0


def test_page_is_small_and_self_contained(page: Path) -> None:
    assert page.stat().st_size < MAX_BYTES
    text = page.read_text(encoding="utf-8")
    head = text[: text.index("window.__VISER_EMBED_DATA__")]
    assert not re.search(r"<(script|link|img|iframe)[^>]+(src|href)=[\"']?(https?:)?//", head)
    assert list(page.parent.glob(".plan.html*")) == [], "no temporary file is left"


@browser.needed
def test_page_of_a_real_plan_is_drawn(root: Path, real_plan: Path, tmp_path: Path) -> None:
    file = tmp_path / "plan.html"
    done = view(root, real_plan, "--html", file)
    assert done.returncode == 0, done.stderr
    assert file.stat().st_size < MAX_BYTES
    with browser.Browser() as window:
        open_page(window, file)
        window.wait_for(lambda: share(scene_at(window, 0.9), ORANGE) > 0.003, 180, "the object")
        check_quiet(window)


def test_long_plan_stays_small_and_short(root: Path, tmp_path: Path) -> None:
    plan = synthetic.make_plan(knots_per_segment=400, kinds=("settle",) + ("contact", "regrasp") * 4)
    file = tmp_path / "plan.html"
    done = view(root, write(tmp_path, plan), "--html", file)
    assert done.returncode == 0, done.stderr
    assert file.stat().st_size < MAX_BYTES


# ---- frames ----


@pytest.mark.parametrize("knots, segments", [(1, 1), (2, 3), (30, 20), (700, 40)])
def test_frames_keep_both_ends_of_every_segment(tmp_path: Path, knots: int, segments: int) -> None:
    kinds = tuple("contact" if k % 2 else "regrasp" for k in range(segments))
    plan = load_plan(write(tmp_path, synthetic.make_plan(knots, kinds)))
    frames = choose_frames(plan)
    times = frame_times(frames)
    assert np.all(np.diff(frames) > 0)
    for segment in range(segments):
        mine = np.flatnonzero(plan.segment == segment)
        assert {mine[0], mine[-1]} <= set(frames)
    assert len(frames) <= max(MAX_FRAMES, 2 * segments)
    assert len(times) == len(frames) + 1
    assert np.all(np.diff(times) > 0)
    assert times[-1] <= 60


# ---- bad input ----


def edit(**changes: object) -> dict:
    plan = copy.deepcopy(synthetic.make_plan())
    for path, value in changes.items():
        target = plan
        *parents, last = path.split("__")
        for key in parents:
            target = target[int(key) if key.isdigit() else key]
        key = int(last) if last.isdigit() else last
        if value is KeyError:
            del target[key]
        else:
            target[key] = value
    return plan


@pytest.mark.parametrize(
    "plan, message",
    [
        (edit(format="other"), "format: got 'other', expected 'stiction-plan'"),
        (edit(format_version=2), "format_version: got 2, expected 1"),
        (edit(goal=KeyError), "field 'goal' is missing"),
        (edit(goal__object="cube"), "goal.object: 'cube' is not an object of the plan"),
        (edit(segments=[]), "segments: got no knots, expected a plan that moves"),
        (edit(segments__1__kind="jump"), "segments[1].kind: got 'jump'"),
        (edit(segments__0__knots__0__bodies=[[0.0] * 7]), "segments[0]: a knot has bodies of shape (1, 7)"),
        (edit(tree__1__parent=2), "tree: a node comes before its parent"),
        (edit(goal__position=[0.0, 1.0]), "expected 3 finite numbers"),
    ],
)
def test_bad_plan_is_refused_by_file_and_field(tmp_path: Path, plan: dict, message: str) -> None:
    file = write(tmp_path, plan)
    with pytest.raises(InvalidPlan) as caught:
        load_plan(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)


def test_program_on_truncated_file_says_so_with_exit_code_2(root: Path, tmp_path: Path) -> None:
    file = write(tmp_path, synthetic.make_plan())
    file.write_text(file.read_text()[:1000])
    done = view(root, file, "--html", tmp_path / "plan.html")
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: {file}: not a JSON file")
    assert not (tmp_path / "plan.html").exists()


def test_program_on_missing_file_or_folder_has_exit_code_2(root: Path, tmp_path: Path) -> None:
    done = view(root, tmp_path / "none.json", "--html", tmp_path / "plan.html")
    assert (done.returncode, done.stderr) == (2, f"error: {tmp_path}/none.json: cannot be read (No such file or directory)\n")
    done = view(root, write(tmp_path, synthetic.make_plan()), "--html", tmp_path / "missing" / "plan.html")
    assert done.returncode == 2
    assert "cannot be written (No such file or directory)" in done.stderr
