"""A motion as messages of ROS 2 in an MCAP file; no ROS is needed. Topics and frames: docs/exports.md."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import BodyKind
from ._extras import require

if TYPE_CHECKING:
    from .exports import Motion

WORLD = "world"

# The interfaces that are used, field by field in their order on the wire.
INTERFACES = {
    "std_msgs/String": "string data",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
    "sensor_msgs/JointState": "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "trajectory_msgs/JointTrajectory": "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points",
    "trajectory_msgs/JointTrajectoryPoint": "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\nbuiltin_interfaces/Duration time_from_start",
}


def definition(name: str) -> str:
    """The text of an interface and of all that it is made of, as it stands in a file."""
    used: list[str] = []

    def visit(interface: str) -> None:
        for part in re.findall(r"^(\w+/\w+)", INTERFACES[interface], flags=re.MULTILINE):
            if part in INTERFACES and part not in used:
                used.append(part)
                visit(part)

    visit(name)
    return "".join([INTERFACES[name], *(f"\n{'=' * 80}\nMSG: {part}\n{INTERFACES[part]}" for part in used)])


def nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)


def stamp(seconds: float) -> dict[str, int]:
    sec, nanosec = divmod(nanoseconds(seconds), 10**9)
    return {"sec": sec, "nanosec": nanosec}


def xyz(values: Any) -> dict[str, float]:
    return dict(zip("xyz", map(float, values)))


def transform(seconds: float, child: str, position: Any, quaternion_xyzw: Any = (0, 0, 0, 1), parent: str = WORLD) -> dict[str, Any]:
    """Pose of the frame `child` in the frame `parent`."""
    return {
        "header": {"stamp": stamp(seconds), "frame_id": parent},
        "child_frame_id": child,
        "transform": {"translation": xyz(position), "rotation": dict(zip("xyzw", map(float, quaternion_xyzw)))},
    }


def token(name: str) -> str:
    """A name as a part of a topic: letters, digits and single underscores, no digit first."""
    plain = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", name)).strip("_")
    return plain if plain[:1].isalpha() else f"n_{plain}"


class Tokens:
    """Tokens of names; different names have different ones."""

    def __init__(self) -> None:
        self._of: dict[str, str] = {}

    def __call__(self, name: str) -> str:
        if name not in self._of:
            base, taken = token(name), set(self._of.values())
            self._of[name] = next(t for n in range(1, len(taken) + 2) if (t := base if n == 1 else f"{base}_{n}") not in taken)
        return self._of[name]


class Recorder:
    """Messages into the file, by the name of their interface."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[str, Any] = {}

    def add(self, topic: str, interface: str, seconds: float, message: dict[str, Any]) -> None:
        if interface not in self._schemas:
            package, name = interface.split("/")
            self._schemas[interface] = self._writer.register_msgdef(f"{package}/msg/{name}", definition(interface))
        time = nanoseconds(seconds)
        self._writer.write_message(topic=topic, schema=self._schemas[interface], message=message, log_time=time, publish_time=time)


def robots_of(joints: list[str]) -> dict[str, list[int]]:
    """Indices of the joints robot/joint of each robot."""
    out: dict[str, list[int]] = {}
    for i, joint in enumerate(joints):
        out.setdefault(joint.split("/")[0], []).append(i)
    return out


def add_joints(to: Recorder, motion: Motion, tokens: Tokens) -> None:
    """Of each robot what a controller is sent, and what its joints then do."""
    for robot, columns in robots_of(motion.joints).items():
        names = [motion.joints[i].split("/", 1)[1] for i in columns]
        points = [
            {"positions": command[columns].tolist(), "velocities": [], "accelerations": [], "effort": [], "time_from_start": stamp(t)}
            for t, command in zip(motion.time, motion.q_cmd)
        ]
        start = {"stamp": stamp(0), "frame_id": ""}  # a controller takes the time 0 for now
        to.add(f"/{tokens(robot)}/joint_trajectory", "trajectory_msgs/JointTrajectory", 0, {"header": start, "joint_names": names, "points": points})
        for k, t in enumerate(motion.time):
            state = {"header": {"stamp": stamp(t), "frame_id": ""}, "name": names}
            state |= {"position": motion.q[k, columns].tolist(), "velocity": motion.velocity[k, columns].tolist(), "effort": motion.torque[k, columns].tolist()}
            to.add(f"/{tokens(robot)}/joint_states", "sensor_msgs/JointState", t, state)


def add_descriptions(to: Recorder, motion: Motion, tokens: Tokens) -> None:
    """The URDF of each robot, as robot_state_publisher has it."""
    for robot, text in motion.plan.task.model.scene.robot_urdfs.items():
        to.add(f"/{tokens(robot)}/robot_description", "std_msgs/String", 0, {"data": text})


class Links:
    """The links of the robots as frames, each in the frame of the link that it hangs on, as robot_state_publisher has them."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self._frames = name_links(model)
        self._links = [(link.name, link.parent, link.moves) for link in model.links]

    def transforms(self, seconds: float, q: Any, moving: bool) -> list[dict[str, Any]]:
        """Those that joints move, or all others."""
        poses = self._model.body_poses(q)
        return [self._transform(seconds, poses, link, parent) for link, parent, moves in self._links if moves == moving and self._frames[link] != WORLD]

    def _transform(self, seconds: float, poses: dict[str, Any], link: str, parent: str | None) -> dict[str, Any]:
        pose = poses[link] if parent is None else poses[parent].inverse() @ poses[link]
        return transform(seconds, self._frames[link], pose.p, _xyzw(pose), WORLD if parent is None else self._frames[parent])


def name_links(model: Any) -> dict[str, str]:
    """Frame of each link robot/link: its name in the file of the robot. The links of a robot of which a name is taken are robot/link, all of them."""
    poses = model.body_poses(model.neutral())
    links = {link.name: link.name.split("/", 1) for link in model.links}
    taken = Counter(name for _, name in links.values())
    taken.update(body.name for body in model.bodies if body.kind != BodyKind.Robot)
    roots = {link.name for link in model.links if link.parent is None}
    at_world = {name for name in roots if links[name][1] == WORLD and _is_identity(poses[name])}
    shared = {robot for full, (robot, name) in links.items() if taken[name] > 1 or (name == WORLD and full not in at_world)}
    return {full: full if robot in shared else name for full, (robot, name) in links.items()}


def _is_identity(pose: Any) -> bool:
    return not np.any(pose.p) and np.array_equal(pose.R, np.eye(3))


def add_fixed(to: Recorder, motion: Motion, links: Links) -> None:
    """What does not move: fixed bodies, where robots stand, and links that are welded to others."""
    model, q = motion.plan.task.model, motion.plan.q[0]
    poses = model.body_poses(q)
    fixed = [transform(0, body.name, poses[body.name].p, _xyzw(poses[body.name])) for body in model.bodies if body.kind == BodyKind.Fixed]
    fixed += links.transforms(0, q, moving=False)
    if fixed:
        to.add("/tf_static", "tf2_msgs/TFMessage", 0, {"transforms": fixed})


def _xyzw(pose: Any) -> list[float]:
    w, x, y, z = pose.quaternion_wxyz
    return [x, y, z, w]


def name_contacts(contacts: list[Any], tokens: Tokens) -> dict[str, Any]:
    """The contacts of a knot by the names of their frames: contacts/A/by/B/NUMBER, the number among those of the two."""
    out: dict[str, Any] = {}
    for contact in contacts:
        pair = f"contacts/{tokens(contact.a)}/by/{tokens(contact.b)}"
        out[f"{pair}/point_{sum(name.startswith(pair + '/') for name in out)}"] = contact
    return out


def add_world(to: Recorder, motion: Motion, links: Links) -> None:
    """Objects, links of robots, and contacts with a frame each at its point: a wrench acts at the origin of its frame."""
    tokens = Tokens()
    open_before: set[str] = set()
    for k, t in enumerate(motion.time):
        contacts = name_contacts(motion.contacts[k], tokens)
        frames = [transform(t, name, pose[:3], pose[3:]) for name, pose in zip(motion.objects, motion.poses[k])]
        frames += links.transforms(t, motion.q_all[k], moving=True)
        frames += [transform(t, name, contact.point) for name, contact in contacts.items()]
        to.add("/tf", "tf2_msgs/TFMessage", t, {"transforms": frames})
        for name in sorted(contacts.keys() | open_before):  # those that opened end with a force of zero
            force = contacts[name].force if name in contacts else (0, 0, 0)
            wrench = {"header": {"stamp": stamp(t), "frame_id": name}, "wrench": {"force": xyz(force), "torque": xyz((0, 0, 0))}}
            to.add(f"/{name}", "geometry_msgs/WrenchStamped", t, wrench)
        open_before = set(contacts)


def write(motion: Motion, file: Path) -> None:
    """Raises MissingExtra: the packages that write it are not there."""
    ros2 = require("mcap", "format mcap", "mcap_ros2.writer")
    with file.open("wb") as out, ros2.Writer(out) as writer:
        to = Recorder(writer)
        links = Links(motion.plan.task.model)
        robots = Tokens()
        add_joints(to, motion, robots)
        add_descriptions(to, motion, robots)
        add_fixed(to, motion, links)
        add_world(to, motion, links)
        writer.add_metadata(name="stiction", data={name: str(value) for name, value in motion.about().items()})
