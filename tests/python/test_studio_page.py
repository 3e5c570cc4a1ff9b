"""`stiction studio` in a real browser: a task is picked, its goal dragged, planned and scrubbed; what is refused is said on the page; scenarios open."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import browser
from studio_window import PATIENCE, Program, Window, colours, drawn, orange, red, square

MAX_BYTES = 5_000_000  # of page and scene
GRIP = (255, 45, 105)  # square of the handle that moves both directions of a plane


@pytest.fixture(scope="module")
def window(program: Path, root: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Window]:
    """The studio of this file's tests: started, and ended with nothing said on stderr."""
    with Program(program, "planar_hand", root=root) as studio, browser.Browser() as chromium:
        opened = Window(chromium, tmp_path_factory.mktemp("downloads"))
        opened.visit(studio.address)
        yield opened
        assert studio.end() == "", "nothing on stderr"


def check_quiet(window: Window) -> None:
    assert window.browser.errors == []
    own = (window.address, window.address.replace("http", "ws"), "data:", "blob:", "about:")
    assert [u[:120] for u in window.browser.requests if not u.startswith(own)] == []
    assert "a fault of the studio" not in window.text()


@browser.needed
def test_task_is_picked_its_goal_dragged_planned_scrubbed_and_exported(window: Window) -> None:
    chromium = window.browser
    window.choose("Open", "planar_pushing")
    window.wait_text("A ball pushes a box")
    goal = ("0", "-0.5")
    chromium.wait_for(lambda: (window.value("box/y [m]"), window.value("box/z [m]")) == goal, PATIENCE, "the goal in numbers")
    window.wait_text("Lint finds no fault")

    window.pull(lambda picture: square(picture, GRIP), (60, 30), lambda: (window.value("box/y [m]"), window.value("box/z [m]")) != goal, "the goal to follow its handle")
    window.wait_text("Lint finds no fault")

    window.fill("Time at most [s]", 300)  # on a busy machine a second is little
    window.press("Plan", "button")
    off, allowed = map(float, window.wait_text(r"solved in [\d.]+ s, ([\d.]+) mm of ([\d.]+) off the goal").groups())
    assert off <= allowed
    y, z = (float(window.value(f"box/{axis} [m]")) for axis in "yz")
    assert y > 0.05 and z < -0.52, "right and down, as the mouse went"
    window.turn_to("Export")
    words = window.wait_text(r"stiction plan planar_pushing --seed 0 --goal '([-\d.e]+) ([-\d.e]+) ").groups()
    np.testing.assert_allclose([float(w) for w in words], [y, z], atol=6e-4)  # the field shows millimetres

    window.choose("What", "json")
    window.press("Download", "button")
    file = window.downloads / "planar_pushing-seed0-motion.json"
    chromium.wait_for(file.exists, PATIENCE, "the download")
    assert json.loads(file.read_text())["format"] == "stiction-motion"

    chromium.scrub(0.01)
    before = window.scene()
    chromium.scrub(0.5)
    window.wait_text(r"motors [\s\S]*contacts ")
    chromium.wait_for(lambda: np.abs(window.scene().astype(int) - before).max(axis=2).mean() > 1, PATIENCE, "the object to move")
    picture = window.scene()
    assert orange(picture) > 0.005 and 0.02 < drawn(picture) < 0.98 and colours(picture) > 20
    assert 100_000 < chromium.received <= MAX_BYTES
    check_quiet(window)


@browser.needed
def test_result_that_is_looked_at_from_elsewhere_is_in_the_picture(window: Window) -> None:
    window.choose("Open", "allegro_cube")
    window.turn_to("Pose")
    window.wait_text("Lint finds no fault")
    window.fill("z [m]", 0.3)
    window.wait_text("no robot reaches 'cube'")
    window.browser.wait_for(lambda: red(window.scene()) > 0.003, PATIENCE, "the goal, which was above the picture")
    window.press("Back to the task", "button")
    window.wait_text("Lint finds no fault")
    window.fill("Time at most [s]", 300)
    window.press("Plan", "button")
    window.wait_text(r"solved in [\d.]+ s")
    window.browser.wait_for(lambda: orange(window.scene()) > 0.01, PATIENCE, "the object")
    check_quiet(window)


@browser.needed
def test_link_is_dragged_with_the_mouse_and_comes_back(window: Window) -> None:
    window.choose("Open", "planar_pushing")
    window.turn_to("Pose")
    window.wait_text("Lint finds no fault")
    window.choose("Drag", "link hand/ball")
    said = window.wait_text(r"joints: (.*)").group(1)
    window.pull(lambda picture: square(picture, GRIP), (15, -20), lambda: window.wait_text(r"joints: (.*)").group(1) != said, "the joints to follow")
    window.turn_to("Export")
    window.wait_text("stiction plan task.yaml")
    window.turn_to("Pose")
    window.press("Undo", "button")
    window.browser.wait_for(lambda: window.wait_text(r"joints: (.*)").group(1) == said, PATIENCE, "the joints to come back")
    window.turn_to("Export")
    window.wait_text("stiction plan planar_pushing")
    window.turn_to("Pose")
    check_quiet(window)


URDF = """<robot name="pusher"><link name="base"/><link name="tip"><collision><geometry>{shape}</geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="tip"/><origin xyz="0 0 0.05"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="50"/></joint></robot>"""


def files_of_all_kinds(folder: Path) -> dict[str, Path]:
    """Good ones and bad ones."""
    contents = {
        "good.urdf": URDF.format(shape='<sphere radius="0.04"/>').encode(),
        "outside.urdf": URDF.format(shape='<mesh filename="../../etc/mesh.stl"/>').encode(),
        "broken.urdf": b"<robot><link",
        "markup.urdf": URDF.format(shape='<mesh filename="../&lt;img src=y&gt;&lt;joint&gt; *a* ![b](c).stl"/>').encode(),
        "noise.stl": random.Random(0).randbytes(500),
        "scene.zip": b"PK\x03\x04" + bytes(100),
        "hidden.urdf": b"PK\x03\x04" + bytes(100),
    }
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    with (folder / "large.stl").open("wb") as file:
        file.truncate(200_000_000)
    return {name: folder / name for name in [*contents, "large.stl"]}


@browser.needed
def test_files_are_refused_with_a_message_and_a_good_robot_is_drawn(window: Window, tmp_path: Path) -> None:
    files = files_of_all_kinds(tmp_path)
    window.turn_to("Own")
    window.wait_text("Drop a robot")
    for name, message in {
        "scene.zip": r"scene.zip: got a file of type '.zip', expected a URDF",
        "hidden.urdf": r"hidden.urdf: got a zip archive, expected a URDF",
        "large.stl": r"large.stl: got 200 MB, expected at most 20 MB",
        "outside.urdf": r"outside.urdf: mesh: got '../../etc/mesh.stl', expected a path below the file",
        "broken.urdf": r"broken.urdf: no XML",
        "markup.urdf": r"markup.urdf: mesh: got '../<img src=y><joint> \*a\* !\[b\]\(c\).stl', expected a path below the file",
        "good.urdf": r"good.urdf: taken",
    }.items():
        window.browser.choose_file(files[name])
        window.wait_text(message)
    window.press("Make the scene", "button")
    window.wait_text(r"good.urdf on a floor: pose it, then plan")
    window.browser.wait_for(lambda: orange(window.scene()) > 0.0005, PATIENCE, "the object")
    check_quiet(window)


@browser.needed
@pytest.mark.parametrize(("scenario", "words"), [("panda_wrist (sense)", r"a single contact explains the torques"), ("box_in_the_way (control)", r"N of 15")])
def test_scenarios_open_in_it(window: Window, scenario: str, words: str) -> None:
    window.choose("Open", scenario)
    window.wait_text(words)
    window.browser.wait_for(lambda: drawn(window.scene()) > 0.02, PATIENCE, "the arm")
    check_quiet(window)


@browser.needed
def test_a_hundred_clicks_and_uploads_at_random_leave_no_exception(window: Window, tmp_path: Path) -> None:
    rng, files = random.Random(0), list(files_of_all_kinds(tmp_path).values())
    window.fill("Time at most [s]", 1)  # of searches that are begun
    for _ in range(100):
        if rng.random() < 0.1:
            if window.browser.evaluate("!!document.querySelector('input[type=file]')"):
                window.browser.choose_file(rng.choice(files))
            continue
        x, y, _ = rng.choice(window.targets())
        if rng.random() < 0.2:
            window.drag((x, y), (rng.uniform(-40, 40), rng.uniform(-40, 40)), steps=1)
        else:
            window.click_at((x, y))
        if rng.random() < 0.2:
            window.type(rng.choice(["0.3", "-5", "1e9", "x", ""]))
    check_quiet(window)
    window.browser.visit(window.address)  # whatever was folded away or covered
    window.wait_text(r"Open[\s\S]*Export")
    for task in ("planar_pushing", "planar_hand"):  # one of them is another than the last
        window.choose("Open", task)
    window.wait_text("Lint finds no fault")
    check_quiet(window)
