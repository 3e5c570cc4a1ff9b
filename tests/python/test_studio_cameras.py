"""Cameras of the studio, with pages that draw late: what is judged and sent is the view that a page will have, not the one that it told last."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from viser import CameraHandle

from stiction_view.camera import View
from stiction_view.studio.cameras import Cameras
from stiction_view.studio.server import serving

FIELDS = {"SetCameraPositionMessage": "position", "SetCameraLookAtMessage": "look_at", "SetCameraUpDirectionMessage": "up_direction"}


class Page:
    """A browser: what is sent waits until it draws, and it tells its camera when it is asked to."""

    def __init__(self, number: int):
        self.client_id = number
        self.sent: list[Any] = []
        self.has: dict[str, Any] = {"position": (3.0, 3.0, 3.0), "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0), "fov": 1.3, "near": 0.01, "far": 1000.0}
        self._websock_connection = SimpleNamespace(queue_message=self.sent.append)
        self.camera = CameraHandle(self)  # type: ignore[arg-type]
        self.tell()

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        yield

    def draw(self) -> None:
        for message in self.sent:
            kind = type(message).__name__
            if kind in FIELDS:
                self.has[FIELDS[kind]] = message.position if kind != "SetCameraLookAtMessage" else message.look_at
            else:
                name = kind.removeprefix("SetCamera").removesuffix("Message").lower()
                self.has[name] = getattr(message, name)
        self.sent.clear()

    def tell(self) -> None:
        state = self.camera._state
        state.image_width, state.image_height, state.update_timestamp = 500, 500, 1.0
        for name, value in self.has.items():
            setattr(state, name, np.array(value) if isinstance(value, tuple) else value)

    def looks_as(self, view: View) -> bool:
        wanted = {"position": view.position, "look_at": view.look_at, "up_direction": view.up, "fov": view.fov, "near": 0.01 * view.radius}
        return all(np.allclose(self.has[name], value) for name, value in wanted.items())


def view_along(axis: int, radius: float = 1.0) -> View:
    """At the origin, from so far away that the radius fills most of the picture."""
    position, up = np.zeros(3), np.zeros(3)
    position[axis] = 4 * radius
    up[(axis + 1) % 3] = 1
    return View(position, np.zeros(3), up, 0.6, radius, np.zeros(3))


SMALL, LARGE, ASIDE = view_along(0, 0.1), view_along(0, 1.0), view_along(2, 0.1)
POINT = np.array([0.0, 0.0, 0.5])  # only the large one sees it


@pytest.fixture
def pages(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Cameras, dict[int, Any]]]:
    with serving("127.0.0.1", 0) as server:
        there: dict[int, Any] = {}
        monkeypatch.setattr(server, "get_clients", lambda: dict(there))
        yield Cameras(server), there


def come(cameras: Cameras, there: dict[int, Any]) -> Page:
    """One more, which has the view of those who come."""
    page = Page(len(there))
    there[page.client_id] = page
    cameras.welcome()
    page.draw()
    page.tell()
    return page


def test_place_is_judged_by_the_view_that_is_on_its_way(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    cameras.aim(LARGE)
    page = come(cameras, there)
    assert page.looks_as(LARGE) and cameras.lost(POINT) == []
    cameras.aim(SMALL)
    assert cameras.lost(POINT) == [page], "viser knows what it has sent"
    page.tell()  # of the scene before, in which the place shows
    assert cameras.lost(POINT) == [page]
    page.draw()
    page.tell()
    assert page.looks_as(SMALL) and cameras.lost(POINT) == [page]
    cameras.aim(LARGE, [page])
    page.tell()  # it has not come yet
    assert cameras.lost(POINT) == []


@pytest.mark.parametrize("knows", [False, True], ids=["first", "later"])
def test_view_arrives_whole_where_a_page_tells_its_camera_while_it_is_sent(pages: tuple[Cameras, dict[int, Any]], knows: bool) -> None:
    """Whatever message it comes between; what it tells may be the same as what is sent in all but one."""
    cameras, there = pages
    number = count = 0
    near = dataclasses.replace(LARGE, position=0.6 * LARGE.position)
    for told in (near, LARGE, dataclasses.replace(LARGE, look_at=np.array([0.3, 0.2, 0.1])), dataclasses.replace(near, up=np.array([0.0, 0.6, 0.8]))):
        for moment in range(14):
            cameras.aim(told)
            page = come(cameras, there)
            if not knows:
                cameras.aim(ASIDE)
                page.tell()  # still the one before
            number, count = page.client_id, 0

            def queue(message: Any, page: Page = page, moment: int = moment) -> None:
                nonlocal count
                page.sent.append(message)
                count += 1
                if count == moment:
                    page.tell()

            page._websock_connection.queue_message = queue
            cameras.aim(LARGE, [page])
            for _ in range(2):
                page.draw()
                page.tell()
                cameras.welcome()
            assert page.looks_as(LARGE), (told, moment, page.has)
            page.has["position"] = (6.0, 1.0, 0.0)
            page.tell()
            cameras.welcome()
            page.draw()
            assert page.has["position"] == (6.0, 1.0, 0.0), "turned"
            del there[number]


def test_view_that_somebody_has_turned_counts_from_then_on(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    cameras.aim(SMALL)
    page, other = come(cameras, there), come(cameras, there)
    page.has["position"] = (4.0, 0.0, 0.0)  # backs off
    page.tell()
    assert cameras.lost(POINT) == [other]
    page.has["look_at"] = (8.0, 0.0, 0.0)  # and turns round
    page.tell()
    assert cameras.lost(POINT) == [page, other]


def test_view_is_sent_again_where_the_page_told_it_before_another_came(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    cameras.aim(SMALL)
    page = come(cameras, there)
    cameras.aim(ASIDE)
    page.tell()  # still the first, and viser takes it for known
    cameras.aim(SMALL)
    page.draw()
    page.tell()
    assert page.looks_as(SMALL) and cameras.lost(np.zeros(3)) == []


def test_who_comes_while_the_scene_changes_has_the_view_of_the_scene(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    cameras.aim(SMALL)
    page = Page(0)
    cameras.aim(LARGE)  # nobody is told: viser counts a page from its first camera on
    there[0] = page
    cameras.welcome()
    page.draw()
    assert page.looks_as(LARGE)
    page.has["position"] = (0.0, 4.0, 0.0)
    page.tell()
    cameras.welcome()
    page.draw()
    assert page.has["position"] == (0.0, 4.0, 0.0), "once"


def test_view_fits_a_narrow_picture_until_somebody_turns_it(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    side = np.array([0.0, 0.0, 0.9])
    wide = View(LARGE.position, LARGE.look_at, LARGE.up, LARGE.fov, LARGE.radius, LARGE.label, width=1.0)
    cameras.aim(wide)
    page = come(cameras, there)
    assert page.looks_as(wide) and cameras.lost(side) == []
    page.camera._state.image_width = 250  # by 500
    cameras.welcome()
    page.draw()
    assert page.looks_as(wide.for_picture(0.5)) and np.linalg.norm(page.has["position"]) == pytest.approx(8.0)
    assert cameras.lost(side) == []
    page.has["position"] = (6.0, 1.0, 0.0)
    page.tell()
    cameras.welcome()
    page.draw()
    assert page.has["position"] == (6.0, 1.0, 0.0)
    page.camera._state.image_width = 250
    cameras.aim(wide)
    page.draw()
    assert page.looks_as(wide.for_picture(0.5)), "the next one fits at once"


def test_page_without_height_is_no_fault(pages: tuple[Cameras, dict[int, Any]]) -> None:
    cameras, there = pages
    cameras.aim(SMALL)
    page = come(cameras, there)
    page.camera._state.image_height = 0
    assert cameras.lost(np.zeros(3)) == [] and cameras.lost(np.array([0.0, 0.5, 0.0])) == [page]
