"""Where everybody looks from, also before their page has told it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from ..camera import View
from ..drawing import far_end, look

FAR_STEP, FAR_STEPS = 1e-3, 100  # parts of a far end; viser takes what differs by 1e-5 for the same


@dataclass(frozen=True)
class Aim:
    """A view that was sent."""

    whole: View
    far: float
    width: float = np.inf  # by its height, of the picture that it was sent to
    passing: tuple[View, ...] = ()  # sent just before

    @property
    def view(self) -> View:
        return self.whole.for_picture(self.width)

    def has_come(self, camera: viser.CameraHandle) -> bool:
        """Whether what viser knows of a camera is this view, or was told by a page that had it."""
        return abs(camera.far - self.far) < 1e-6 * self.far

    def is_kept(self, camera: viser.CameraHandle) -> bool:
        """Whether it has come and nobody has turned it since."""
        view, near = self.view, 1e-3 * self.whole.radius
        return self.has_come(camera) and bool(np.allclose(camera.position, view.position, atol=near) and np.allclose(camera.look_at, view.look_at, atol=near))

    def is_half_there(self, camera: viser.CameraHandle) -> bool:
        """Whether it has come with a part of what was sent just before: viser keeps back what a page tells while it sends."""
        if not self.has_come(camera):
            return False
        now, wanted = _told(camera), _sent(self.view)
        return any(
            np.allclose(has, other) and not np.allclose(other, aimed) for view in self.passing for has, other, aimed in zip(now, _sent(view), wanted, strict=True)
        )


def _told(camera: viser.CameraHandle) -> tuple[Any, ...]:
    return camera.position, camera.look_at, camera.up_direction, camera.fov, camera.near


def _sent(view: View) -> tuple[Any, ...]:
    """The same of a view, as look() sends it."""
    return view.position, view.look_at, view.up, view.fov, 0.01 * view.radius


def width_of(camera: viser.CameraHandle) -> float:
    """Of its picture, by the height; a page may have none."""
    return camera.image_width / max(camera.image_height, 1)


def is_seen(view: View | viser.CameraHandle, width: float, point: np.ndarray) -> bool:
    """Whether a place is in a picture of that width by its height."""
    away = np.asarray(view.look_at) - view.position
    right = np.cross(away, view.up if isinstance(view, View) else view.up_direction)
    R = np.stack([v / np.linalg.norm(v) for v in (right, np.cross(right, away), away)])
    x, y, depth = R @ (point - view.position)
    height = depth * np.tan(view.fov / 2)
    return bool(depth > 0 and abs(y) < height and abs(x) < width * height)


class Cameras:
    """Only one thread at a time may call it.

    A page tells its camera when it draws, which a large scene keeps waiting. What it told before it had a view overwrites in viser the view that was sent,
    and what was dragged or typed meanwhile would be judged by the view of the scene before. So the far end of each view that is sent is another by a little:
    of a camera with another end the view counts that is on its way.
    """

    def __init__(self, server: viser.ViserServer):
        self._server = server
        self._first: Aim | None = None  # of those who come
        self._sent: dict[int, Aim] = {}  # the last, by client
        self._count = 0

    def welcome(self) -> None:
        """Aims the cameras of those who came since the last call: a page that comes back, or came while the view changed, has the one before.

        A view that nobody has turned fits the picture, also where that has become narrower.
        """
        if self._first is None:
            return
        clients = self._server.get_clients()
        self._sent = {number: aim for number, aim in self._sent.items() if number in clients}
        for number, client in clients.items():
            camera, is_new = client.camera, number not in self._sent
            sent = self._sent.setdefault(number, self._first)
            if is_new and not sent.has_come(camera):
                self._send(client, sent.whole)
            elif sent.is_half_there(camera):
                self._send(client, sent.whole)
            elif (width := width_of(camera)) != sent.width and sent.is_kept(camera):
                if np.array_equal(sent.whole.for_picture(width).position, sent.view.position):
                    self._sent[number] = dataclasses.replace(sent, width=width)
                else:
                    self._send(client, sent.whole)

    def aim(self, view: View, clients: Iterable[viser.ClientHandle] | None = None) -> None:
        """Cameras of those who come, and of `clients`; None: of all who are there."""
        self.welcome()
        self._first = Aim(view, self._new_far(view))
        look(self._server.initial_camera, view, self._first.far)
        for client in self._server.get_clients().values() if clients is None else clients:
            self._send(client, view)

    def lost(self, point: np.ndarray) -> list[viser.ClientHandle]:
        """Those in whose picture a place is not, once they have the view that was sent to them."""
        self.welcome()
        return [client for client in self._server.get_clients().values() if not self._sees(client, point)]

    def _sees(self, client: viser.ClientHandle, point: np.ndarray) -> bool:
        camera, sent = client.camera, self._sent.get(client.client_id)
        return is_seen(camera if sent is None or sent.has_come(camera) else sent.view, width_of(camera), point)

    def _new_far(self, view: View) -> float:
        self._count += 1
        return far_end(view) * (1 + FAR_STEP * (self._count % FAR_STEPS))

    def _send(self, client: viser.ClientHandle, view: View) -> None:
        before, aim = self._sent.get(client.client_id), Aim(view, self._new_far(view), width_of(client.camera))
        with client.atomic():
            passing = [_carried(aim.view, client.camera.position)]
            if before is None or not before.has_come(client.camera):
                other = _other(aim.view)
                passing += [other, _carried(aim.view, other.position, other.look_at)]
                look(client.camera, other)  # viser keeps back what it takes for known, and the page will have the view that is on its way
            look(client.camera, aim.view, aim.far)
        self._sent[client.client_id] = dataclasses.replace(aim, passing=tuple(passing))


def _carried(view: View, position: np.ndarray, look_at: np.ndarray | None = None) -> View:
    """With what is looked at as viser takes it along with the position, from the one before."""
    return dataclasses.replace(view, look_at=(view.look_at if look_at is None else look_at) + view.position - position)


def _other(view: View) -> View:
    """Another in all that is sent."""
    r = view.radius
    return dataclasses.replace(view, position=view.position + r, look_at=view.look_at + 2 * r, up=np.roll(view.up, 1), fov=0.9 * view.fov, radius=1.1 * r)
