"""`stiction studio` in a real browser: a task is picked, its goal dragged, planned and scrubbed; what is refused is said on the page; scenarios open."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import browser
from studio_window import PATIENCE, Program, Window, colours, drawn, orange, square

MAX_BYTES = 5_000_000  # of page and scene
GRIP = (255, 45, 105)  # square of the handle that moves both directions of a plane


def check_quiet(window: Window, program: Program) -> None:
    assert window.browser.errors == []
    own = (program.address, program.address.replace("http", "ws"), "data:", "blob:", "about:")
    assert [u[:120] for u in window.browser.requests if not u.startswith(own)] == []
    assert program.end() == "", "nothing on stderr"


@browser.needed
def test_task_is_picked_its_goal_dragged_planned_and_scrubbed(program: Path, root: Path) -> None:
    with Program(program, "planar_hand", root=root) as studio, browser.Browser() as chromium:
        window = Window(chromium)
        window.visit(studio.address)
        window.choose("Open", "planar_pushing")
        window.wait_text("A ball pushes a box")
        goal = ("0", "-0.5")
        chromium.wait_for(lambda: (window.value("box/y [m]"), window.value("box/z [m]")) == goal, PATIENCE, "the goal in numbers")
        window.wait_text("Lint finds no fault")

        grip = chromium.wait_for(lambda: square(window.scene(), GRIP), PATIENCE, "the handle of the goal")
        window.drag(grip, (60, 30))
        y, z = chromium.wait_for(lambda: (now := (window.value("box/y [m]"), window.value("box/z [m]"))) != goal and [float(x) for x in now], PATIENCE, "the goal to follow")
        assert y > 0.05 and z < -0.52, "right and down, as the mouse went"
        window.wait_text("Lint finds no fault")

        window.press("Plan", "button")
        off, allowed = map(float, window.wait_text(r"solved in [\d.]+ s, ([\d.]+) mm of ([\d.]+) off the goal").groups())
        assert off <= allowed
        window.press("Export", "[role=tab]")
        words = window.wait_text(r"stiction plan planar_pushing --seed 0 --goal '([-\d.e]+) ([-\d.e]+) ").groups()
        np.testing.assert_allclose([float(w) for w in words], [y, z], atol=6e-4)  # the field shows millimetres

        chromium.scrub(0.01)
        before = window.picture()
        chromium.scrub(0.5)
        window.wait_text(r"motors [\s\S]*contacts ")
        chromium.wait_for(lambda: np.abs(window.scene().astype(int) - before[:, :600]).max(axis=2).mean() > 1, PATIENCE, "the object to move")
        picture = window.scene()
        assert orange(picture) > 0.005 and 0.02 < drawn(picture) < 0.98 and colours(picture) > 20
        assert 100_000 < chromium.received <= MAX_BYTES
        check_quiet(window, studio)
