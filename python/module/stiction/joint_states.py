"""Logs of sensor_msgs/JointState in MCAP files, as arrays and as the series of a scenario of sensing."""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ._core import InvalidInput
from ._extras import require
from ._files import write_whole
from ._values import fields_equal

INTERFACE = "sensor_msgs/msg/JointState"


@dataclass(frozen=True, eq=False)
class JointStates:
    """Positions and efforts of joints over time, from a log."""

    joints: list[str]
    t: np.ndarray  # (moments) [s]
    q: np.ndarray  # (moments, joints) [rad or m]
    velocity: np.ndarray  # (moments, joints) [rad/s or m/s]; NaN where a message has none
    tau: np.ndarray  # (moments, joints) efforts [N m or N]
    notes: list[str] = field(default_factory=list)  # a sentence each: what was left out, and what efforts are

    def __eq__(self, other: object) -> bool:
        return fields_equal(self, other) if isinstance(other, JointStates) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # its arrays can change

    def save(self, file: str | PathLike[str]) -> Path:
        """Writes the arrays t, q, tau and joints to an .npz file, which the key `series` of a sensing scenario reads."""
        path = Path(file)
        if path.suffix != ".npz":
            raise InvalidInput(f"file: got '{path}', expected a name that ends in .npz")
        write_whole(path, lambda out: np.savez(out, t=self.t, q=self.q, tau=self.tau, joints=np.array(self.joints)))
        return path


def load_joint_states(file: str | PathLike[str], *, topic: str | None = None, joints: Sequence[str] | None = None) -> JointStates:
    """Reads the sensor_msgs/JointState messages of an MCAP file (ROS 2), for contact sensing on a recorded robot.

    file: MCAP file.
    topic: topic of the messages. None: the only topic of this type.
    joints: names of the joints to read, in this order. None: the joints of most messages, in their order there. Messages without all of these
      joints are left out.

    Returns JointStates. Times are the stamps of the messages, or the times of the log if the messages have no stamps. Raises InvalidInput: no
    such file, topic or joint, or no message with finite positions and efforts; MissingExtra: the packages that read the file are not installed.
    """
    path = Path(file)
    states = _Reader(path, list(_read_messages(path, topic)))
    if joints is None:
        return states.read(states.find_joints())
    return states.read([joints] if isinstance(joints, str) else list(joints))


def _read_messages(path: Path, topic: str | None) -> Iterator[tuple[float, Any]]:
    """Time of the log [s] and message."""
    mcap = require("mcap", "load_joint_states", "mcap.reader")
    exceptions = require("mcap", "load_joint_states", "mcap.exceptions")
    decoder = require("mcap", "load_joint_states", "mcap_ros2.decoder")
    try:
        with path.open("rb") as stream:
            reader = mcap.make_reader(stream, decoder_factories=[decoder.DecoderFactory()])
            chosen = _choose_topic(path, reader.get_summary(), topic)
            for schema, channel, record, message in reader.iter_decoded_messages(topics=[chosen]):
                if schema is not None and schema.name == INTERFACE:
                    yield 1e-9 * record.log_time, message
    except OSError as error:
        raise InvalidInput(f"{path}: got a file that cannot be read ({error.strerror}), expected an MCAP file") from None
    except InvalidInput:
        raise
    except (exceptions.McapError, struct.error, EOFError) as error:
        got = "an empty file" if path.stat().st_size == 0 else "an .npz file, which `series` of a scenario reads" if path.suffix == ".npz" else f"'{error}'"
        raise InvalidInput(f"{path}: got {got}, expected an MCAP file of ROS 2") from None
    except Exception as error:  # of what unpacks and reads messages, which raise errors of their own
        raise InvalidInput(f"{path}: got a message that cannot be read ({error}), expected a whole file; `mcap recover` keeps what can be read") from None


def _choose_topic(path: Path, summary: Any, topic: str | None) -> str:
    if summary is None:
        raise InvalidInput(f"{path}: got a file without an index, expected a whole one; `mcap recover` makes one")
    names = {schema.id for schema in summary.schemas.values() if schema.name == INTERFACE}
    topics = sorted({channel.topic for channel in summary.channels.values() if channel.schema_id in names})
    if topic is None and len(topics) == 1:
        return topics[0]
    if topic in topics:
        return str(topic)
    got = f"topic '{topic}'" if topic is not None else f"{len(topics)} topics of {INTERFACE}"
    expected = f"one of {_quote(topics)}" if topics else f"a topic of {INTERFACE}"
    raise InvalidInput(f"{path}: topic: got {got}, expected {expected}")


class _Reader:
    def __init__(self, path: Path, messages: list[tuple[float, Any]]) -> None:
        self._path = path
        self._messages = messages

    def find_joints(self) -> list[str]:
        """The names of most messages, in the order of the first of these; publishers that share a topic have joints of their own."""
        if not self._messages:
            raise InvalidInput(f"{self._path}: got no message of {INTERFACE}, expected at least one")
        sets = Counter(frozenset(message.name) for _, message in self._messages)
        most = max(sets, key=lambda names: (sets[names], len(names)))
        return next(list(message.name) for _, message in self._messages if frozenset(message.name) == most)

    def read(self, joints: list[str]) -> JointStates:
        self._require_names(joints)
        rows: list[tuple[float, list[float], list[float], list[float]]] = []
        left_out: Counter[str] = Counter()
        are_stamped = any(_stamp_of(message) > 0 for _, message in self._messages)  # simulated time begins at 0, which alone tells nothing
        for log_time, message in self._messages:
            row = _row_of(message, joints, _stamp_of(message) if are_stamped else log_time)
            if isinstance(row, str):
                left_out[row] += 1
            elif rows and row[0] <= rows[-1][0]:
                left_out["are not later than the one before"] += 1
            else:
                rows.append(row)
        notes = [f"{self._path}: {count} of {len(self._messages)} messages {why} and are left out" for why, count in sorted(left_out.items())]
        if not rows:
            raise InvalidInput(f"{'; '.join(notes)}: expected at least one message with finite positions and efforts of {_quote(joints)}")
        notes.append(f"{self._path}: efforts are taken for the external torques; the torques of gravity and of friction have to be taken off them first")
        t, q, velocity, tau = (np.array(column, dtype=float) for column in zip(*rows))
        return JointStates(joints, t, q, velocity, tau, notes)

    def _require_names(self, joints: list[str]) -> None:
        if not joints or len(set(joints)) != len(joints):
            raise InvalidInput(f"joints: got {joints}, expected names that differ, at least one")
        known = {name for _, message in self._messages for name in message.name}
        for joint in joints:
            if joint not in known:
                raise InvalidInput(f"{self._path}: joints: got '{joint}', expected one of {_quote(sorted(known))}")


def _quote(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


def _stamp_of(message: Any) -> float:
    return float(message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)


def _row_of(message: Any, joints: list[str], time: float) -> tuple[float, list[float], list[float], list[float]] | str:
    """Time, positions, velocities and efforts of the joints; a text: why the message has none."""
    at = {name: i for i, name in enumerate(message.name)}
    n = len(message.name)
    if len(at) != n:
        return "name a joint twice"
    if any(joint not in at for joint in joints):
        return "lack a joint"
    if len(message.position) != n or len(message.effort) != n:
        return "have not a position and an effort for every name"
    q, tau = ([float(values[at[joint]]) for joint in joints] for values in (message.position, message.effort))
    if not all(map(math.isfinite, q + tau)):
        return "have a number that is not finite"
    velocity = [float(message.velocity[at[joint]]) if len(message.velocity) == n else math.nan for joint in joints]
    return time, q, velocity, tau
