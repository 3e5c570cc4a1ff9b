"""Frames of a stream as messages of Foxglove, over its websocket. Topics: docs/streams.md."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Any

import numpy as np

from ._core import InvalidInput
from ._extras import require
from ._mcap import WORLD, Tokens
from .streams import Arrows, Contact, Frame, Scene, Solid, robots_of

FORCE = (206, 24, 74)
GOAL = (38, 160, 92)
QUIET_S = 0.1  # without another subscription
BACKLOG = 4096  # messages that a viewer may be behind before the oldest are dropped

XYZ = {"type": "object", "properties": {axis: {"type": "number"} for axis in "xyz"}}
FORCES = {
    "title": "stiction.Contacts",
    "type": "object",
    "properties": {
        "contacts": {
            "type": "array",
            "items": {"type": "object", "properties": {"a": {"type": "string"}, "b": {"type": "string"}, "newton": {"type": "number"}, "point": XYZ, "force": XYZ}},
        }
    },
}
STATE = {
    "title": "stiction.State",
    "type": "object",
    "properties": {"state": {"type": "string"}, "time_s": {"type": "number"}} | {name: {"type": "number"} for name in ("plans", "pieces", "goal_share")},
}


class _Newcomers:
    """Gives the meshes to whoever subscribes to them."""

    def __init__(self, sink: Foxglove) -> None:
        self._sink = sink

    def on_subscribe(self, client: Any, channel: Any) -> None:
        self._sink.newcomer(channel.topic)


class Foxglove:
    """A server; a viewer that comes late has the meshes with the next frame."""

    live = True

    def __init__(self, scene: Scene, host: str, port: int) -> None:
        """Raises InvalidInput: the port cannot be listened on; MissingExtra."""
        self._sdk = sdk = require("foxglove", "a stream to Foxglove", "foxglove")
        require("foxglove", "a stream to Foxglove", "foxglove.channels")
        if not 0 <= port <= 65535:
            raise InvalidInput(f"foxglove: got {port}, expected a port from 0 to 65535")
        self._scene, self._arrows = scene, Arrows(scene)
        self._begin_ns = time.time_ns()
        self._wanted = threading.Event()  # somebody has subscribed to the meshes, and has none
        self._subscribed = threading.Event()
        self._last_subscription = 0.0  # by the monotonic clock [s]
        self._context = sdk.Context()
        self._open_channels()
        try:
            self._server = sdk.start_server(name=f"stiction: {scene.name}", host=host, port=port, context=self._context, server_listener=_Newcomers(self), message_backlog_size=BACKLOG)
        except (RuntimeError, OSError, ValueError) as error:
            raise InvalidInput(f"foxglove: got {host}:{port}, which cannot be listened on ({error}), expected an address of this machine and a port that is free") from None
        self.address = f"ws://{host}:{self._server.port}"

    def _open_channels(self) -> None:
        channels, context, tokens = self._sdk.channels, self._context, Tokens()
        self._tf = channels.FrameTransformsChannel("/tf", context=context)
        self._meshes = channels.SceneUpdateChannel("/scene", context=context)
        self._forces = channels.SceneUpdateChannel("/forces", context=context)
        self._contacts = self._sdk.Channel("/contacts", schema=FORCES, context=context)
        self._state = self._sdk.Channel("/state", schema=STATE, context=context)
        model = self._scene.model
        self._joints = [
            (
                columns,
                [model.joint_names[i].split("/", 1)[1] for i in columns],
                channels.JointStatesChannel(f"/{tokens(robot)}/joint_states", context=context),
                channels.JointStatesChannel(f"/{tokens(robot)}/joint_commands", context=context),
            )
            for robot, columns in robots_of(model).items()
        ]

    def newcomer(self, topic: str) -> None:
        """Of the thread of the server."""
        if topic == "/scene":
            self._wanted.set()
        self._last_subscription = time.monotonic()
        self._subscribed.set()

    def wait(self, timeout_s: float) -> bool:
        """A viewer subscribes to one topic after another; it is there once it has ended."""
        if not self._subscribed.wait(timeout_s):
            return False
        while (left := self._last_subscription + QUIET_S - time.monotonic()) > 0:
            time.sleep(left)
        return True

    def send(self, frame: Frame) -> None:
        at = self._begin_ns + round(1e9 * frame.time)
        stamp = self._sdk.messages.Timestamp(sec=at // 10**9, nsec=at % 10**9)
        self._tf.log(self._transforms(frame, stamp), log_time=at)
        if self._wanted.is_set():
            self._wanted.clear()
            self._meshes.log(self._draw(stamp), log_time=at)
        self._forces.log(self._draw_forces(frame.contacts, stamp), log_time=at)
        self._contacts.log({"contacts": [_to_json(contact) for contact in frame.contacts]}, log_time=at)
        self._send_joints(frame, stamp, at)
        self._state.log({"state": frame.state, "time_s": frame.time} | frame.figures, log_time=at)

    def _send_joints(self, frame: Frame, stamp: Any, at: int) -> None:
        messages, joints = self._sdk.messages, frame.q[-self._scene.model.n_a :]
        for columns, names, states, commands in self._joints:
            efforts = [float(frame.torque[i]) for i in columns] if len(frame.torque) else [None] * len(columns)
            measured = [messages.JointState(name=name, position=float(joints[i]), effort=effort) for name, i, effort in zip(names, columns, efforts)]
            states.log(messages.JointStates(timestamp=stamp, joints=measured), log_time=at)
            sent = [messages.JointState(name=name, position=float(frame.u[i])) for name, i in zip(names, columns)]
            commands.log(messages.JointStates(timestamp=stamp, joints=sent), log_time=at)

    def _transforms(self, frame: Frame, stamp: Any) -> Any:
        messages = self._sdk.messages
        poses = self._scene.model.body_poses(frame.q)
        out = []
        for body, pose in poses.items():
            name = self._scene.frames[body]
            if name == WORLD:
                continue
            w, x, y, z = map(float, pose.quaternion_wxyz)
            place = {"translation": _vector(messages, pose.p), "rotation": messages.Quaternion(x=x, y=y, z=z, w=w)}
            out.append(messages.FrameTransform(timestamp=stamp, parent_frame_id=WORLD, child_frame_id=name, **place))
        return messages.FrameTransforms(transforms=out)

    def _draw(self, stamp: Any) -> Any:
        """The meshes of all bodies, and the object at its goal."""
        messages = self._sdk.messages
        entities = []
        for number, solid in enumerate(self._scene.solids):
            triangles = _triangles(messages, solid, [_color(messages, color) for color in solid.colors])
            frame = self._scene.frames[solid.body]
            entities.append(messages.SceneEntity(timestamp=stamp, frame_id=frame, id=f"{number} {solid.body}", frame_locked=True, triangles=[triangles]))
        name, goal = self._scene.goal
        for solid in self._scene.solids:
            if solid.body == name:
                x, y, z, w = map(float, goal[3:])
                pose = messages.Pose(position=_vector(messages, goal[:3]), orientation=messages.Quaternion(x=x, y=y, z=z, w=w))
                ghost = _triangles(messages, solid, [_color(messages, GOAL, 0.35)] * len(solid.triangles), pose)
                entities.append(messages.SceneEntity(timestamp=stamp, frame_id=WORLD, id="goal", frame_locked=True, triangles=[ghost]))
        return messages.SceneUpdate(entities=entities)

    def _draw_forces(self, contacts: list[Contact], stamp: Any) -> Any:
        messages, scale = self._sdk.messages, self._arrows.scale(contacts)
        thick = 0.09 * self._arrows.longest
        arrows = []
        for contact in contacts:
            force = float(np.linalg.norm(contact.force))
            length = scale * force
            if length <= 0:
                continue
            x, y, z, w = _from_x(contact.force / force)
            pose = messages.Pose(position=_vector(messages, contact.point), orientation=messages.Quaternion(x=x, y=y, z=z, w=w))
            head = min(0.25 * self._arrows.longest, 0.5 * length)
            arrows.append(
                messages.ArrowPrimitive(pose=pose, shaft_length=length - head, shaft_diameter=thick, head_length=head, head_diameter=2 * thick, color=_color(messages, FORCE))
            )
        return messages.SceneUpdate(entities=[messages.SceneEntity(timestamp=stamp, frame_id=WORLD, id="forces", arrows=arrows)])

    def close(self) -> None:
        with contextlib.suppress(RuntimeError):
            self._server.stop()


def _vector(messages: Any, values: Any) -> Any:
    x, y, z = map(float, values)
    return messages.Vector3(x=x, y=y, z=z)


def _color(messages: Any, rgb: Any, alpha: float = 1.0) -> Any:
    r, g, b = (float(value) / 255 for value in rgb)
    return messages.Color(r=r, g=g, b=b, a=alpha)


def _triangles(messages: Any, solid: Solid, colors: list[Any], pose: Any = None) -> Any:
    """Corners one by one, each with the colour of its triangle."""
    points = [messages.Point3(x=float(x), y=float(y), z=float(z)) for x, y, z in solid.vertices[solid.triangles].reshape(-1, 3)]
    return messages.TriangleListPrimitive(pose=pose, points=points, colors=[color for color in colors for _ in range(3)])


def _to_json(contact: Contact) -> dict[str, Any]:
    out: dict[str, Any] = {"a": contact.a, "b": contact.b, "newton": float(np.linalg.norm(contact.force))}
    return out | {name: dict(zip("xyz", map(float, getattr(contact, name)))) for name in ("point", "force")}


def _from_x(direction: np.ndarray) -> tuple[float, float, float, float]:
    """The quaternion x y z w of the shortest rotation that takes the x axis to a unit vector."""
    if direction[0] < -1 + 1e-9:
        return 0.0, 0.0, 1.0, 0.0
    quaternion = np.array([0.0, -direction[2], direction[1], 1 + direction[0]])
    x, y, z, w = map(float, quaternion / np.linalg.norm(quaternion))
    return x, y, z, w
