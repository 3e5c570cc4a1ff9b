"""Frames of a stream for rerun, into a file or a viewer. Entities: docs/streams.md."""

from __future__ import annotations

import socket
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from ._core import InvalidInput
from ._extras import require
from ._files import require_folder
from .streams import Arrows, Contact, Frame, Scene, Solid, kinds_of, robots_of

DEFAULT = "rerun+http://127.0.0.1:9876/proxy"
ANSWER_S = 2.0
FORCE = (206, 24, 74)
GOAL = (38, 160, 92, 90)


class Rerun:
    """A recording; the timeline `time` is seconds since the start."""

    def __init__(self, scene: Scene, target: str) -> None:
        """target: a file .rrd, or the address of a viewer. Raises InvalidInput, MissingExtra."""
        self._rr = rr = require("rerun", "a stream to rerun", "rerun")
        self._scene, self._arrows = scene, Arrows(scene)
        self._kinds, self._open = kinds_of(scene.model), set[str]()
        self.live, self.address = "://" in target, target
        if self.live:
            _require_viewer(target)
        elif Path(target).suffix != ".rrd":
            raise InvalidInput(f"rerun: got '{target}', expected a file that ends in .rrd, or an address as {DEFAULT}")
        else:
            require_folder(Path(target))
        self._to = rr.RecordingStream(f"stiction: {scene.name}")
        try:
            if self.live:
                self._to.connect_grpc(target)
            else:
                self._to.save(target)
        except (RuntimeError, OSError, ValueError) as error:
            raise InvalidInput(f"rerun: got '{target}', which cannot be written to ({error}), expected a file or the address of a viewer") from None
        self._draw()

    def _draw(self) -> None:
        """What does not change: meshes, and the object at its goal."""
        rr = self._rr
        self._to.log(["world"], rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for number, solid in enumerate(self._scene.solids):
            self._to.log([*self._path(solid.body), f"shape_{number}"], self._mesh(solid, solid.colors), static=True)
        name, goal = self._scene.goal
        for solid in self._scene.solids:
            if solid.body == name:
                self._to.log(["world", "goal"], rr.Transform3D(translation=goal[:3], quaternion=goal[3:]), static=True)
                self._to.log(["world", "goal", "shape"], self._mesh(solid, np.tile(GOAL, (len(solid.triangles), 1))), static=True)

    def _mesh(self, solid: Solid, colors: np.ndarray) -> object:
        """Corners one by one, each with the colour of its triangle."""
        corners = solid.vertices[solid.triangles].reshape(-1, 3)
        return self._rr.Mesh3D(vertex_positions=corners, triangle_indices=np.arange(len(corners)).reshape(-1, 3), vertex_colors=np.repeat(colors, 3, axis=0))

    def _path(self, body: str) -> list[str]:
        return ["world", self._kinds[body], body]

    def wait(self, timeout_s: float) -> bool:
        return True  # a viewer has answered before this was made

    def send(self, frame: Frame) -> None:
        rr, to = self._rr, self._to
        to.set_time("time", duration=frame.time)
        for body, pose in self._scene.model.body_poses(frame.q).items():
            to.log(self._path(body), rr.Transform3D(translation=pose.p, quaternion=np.roll(pose.quaternion_wxyz, -1)))
        scale = self._arrows.scale(frame.contacts)
        origins, vectors = ([getattr(contact, name) for contact in frame.contacts] for name in ("point", "force"))
        labels = [f"{contact.a} by {contact.b}" for contact in frame.contacts]
        drawn = {"origins": np.reshape(origins, (-1, 3)), "vectors": scale * np.reshape(vectors, (-1, 3))}
        to.log(["world", "forces"], rr.Arrows3D(**drawn, radii=0.045 * self._arrows.longest, colors=[FORCE], labels=labels, show_labels=False))
        self._send_series(frame)

    def _send_series(self, frame: Frame) -> None:
        model = self._scene.model
        joints = frame.q[-model.n_a :]
        for robot, columns in robots_of(model).items():
            for i in columns:
                name = model.joint_names[i].split("/", 1)[1]
                values = {"position": joints[i], "command": frame.u[i]} | ({"torque": frame.torque[i]} if len(frame.torque) else {})
                for kind, value in values.items():
                    self._to.log(["joints", robot, name, kind], self._rr.Scalars(float(value)))
        forces = _sum_forces(frame.contacts)
        for pair in sorted(forces.keys() | self._open):  # a pair that has opened ends with a zero
            self._to.log(["newton", pair], self._rr.Scalars(forces.get(pair, 0.0)))
        self._open = set(forces)
        self._to.log(["state"], self._rr.TextLog(frame.state))
        for name, value in frame.figures.items():
            self._to.log(["run", name], self._rr.Scalars(float(value)))

    def close(self) -> None:
        self._to.flush()
        self._to.disconnect()


def _sum_forces(contacts: list[Contact]) -> dict[str, float]:
    """Length of the whole force of each pair [N]."""
    sums: dict[str, np.ndarray] = {}
    for contact in contacts:
        pair = f"{contact.a} by {contact.b}"
        sums[pair] = sums.get(pair, np.zeros(3)) + contact.force
    return {pair: float(np.linalg.norm(force)) for pair, force in sums.items()}


def _require_viewer(address: str) -> None:
    """Raises InvalidInput: nothing listens there; rerun itself would keep what is sent, and say nothing."""
    parts = urlsplit(address)
    try:
        host, port = parts.hostname, parts.port
        if not host or not port:
            raise ValueError("no host and port")
        socket.create_connection((host, port), timeout=ANSWER_S).close()
    except (OSError, ValueError) as error:
        raise InvalidInput(f"rerun: got '{address}', where no viewer answers ({error}), expected the address of one that was started before with `rerun`, or a file .rrd") from None
