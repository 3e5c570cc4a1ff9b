"""Live streams: a plan, or a run as it happens, in Foxglove and in rerun (docs/streams.md)."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ._core import BodyKind, InvalidInput, Model, Plan, RunSample, Task, make_trajectory
from ._mcap import name_links
from .pages import _load, _viewer

RATE = 50.0  # frames a second of a plan, those of a run
FOXGLOVE_PORT = 8765
LONGEST = 0.35  # of an arrow, times the radius of what matters


@dataclass(frozen=True)
class Contact:
    """What acts between two geometries at a point."""

    a: str  # name, as body/geometry
    b: str
    point: np.ndarray  # in W [m] (3)
    force: np.ndarray  # on a, in W [N] (3)


@dataclass(frozen=True)
class Frame:
    """Everything at one moment."""

    time: float  # since the start [s]
    q: np.ndarray  # (n_q)
    u: np.ndarray  # commands (n_a) [rad or m]
    torque: np.ndarray  # of the motors (n_a) [N m or N]; empty: unknown
    contacts: list[Contact]
    state: str  # what goes on: settle, contact, regrasp; hold, push, regrasp, replan
    figures: dict[str, float] = field(default_factory=dict)  # of a run: plans, pieces, goal_share


@dataclass(frozen=True)
class Solid:
    """What a body looks like, in its frame."""

    body: str
    kind: str  # robot, object, fixed
    vertices: np.ndarray  # (n, 3) [m]
    triangles: np.ndarray  # (m, 3)
    colors: np.ndarray  # of triangles (m, 3), 0 to 255


@dataclass(frozen=True)
class Scene:
    """What is drawn of a task."""

    name: str
    model: Model
    frames: dict[str, str]  # body -> its name as a frame: links as in their URDF
    solids: list[Solid]
    radius: float  # of what matters [m]
    goal: tuple[str, np.ndarray]  # the object, and where it is to go: x y z qx qy qz qw


class Sink(Protocol):
    """A viewer, or a file."""

    live: bool  # somebody looks while frames are sent
    address: str  # where it is looked at

    def send(self, frame: Frame) -> None: ...
    def wait(self, timeout_s: float) -> bool: ...  # until somebody looks
    def close(self) -> None: ...


def make_scene(shown: Plan | Task) -> Scene:
    """Meshes of the bodies, as `stiction view` draws them; half-spaces are squares."""
    drawn = _load(shown)
    bodies, links, camera, frames = (_viewer(name) for name in ("bodies", "links", "camera", "frames"))
    parts = bodies.body_meshes(drawn, links.find(drawn)[0])
    radius = float(camera.choose_view(drawn, parts, frames.choose_frames(drawn)).radius)
    solids = [_solid(drawn.bodies[part.body], part.mesh, bodies) for part in parts]
    for geometry in drawn.geometries:
        if geometry.shape["type"] == "half_space":
            solids.append(_square(drawn.bodies[geometry.body], geometry.X_BG, 6 * radius, bodies.FIXED))
    model = shown.task.model if isinstance(shown, Plan) else shown.model
    names = {body.name: body.name for body in model.bodies} | name_links(model)
    goal = drawn.bodies[drawn.goal_body].name, np.concatenate([drawn.goal.position, np.roll(drawn.goal.wxyz, -1)])
    return Scene(drawn.task, model, names, solids, radius, goal)


def _solid(body: Any, mesh: Any, bodies: Any) -> Solid:
    if body.kind == "object":
        colors = np.array(bodies.OBJECT)[mesh[2]]
    else:
        color = bodies.FIXED if body.kind == "fixed" else bodies.ROBOT if body.moving is not None else bodies.ROBOT_BASE
        colors = np.tile(color, (len(mesh[1]), 1))
    return Solid(body.name, body.kind, np.asarray(mesh[0]), np.asarray(mesh[1]), colors)


def _square(body: Any, X_BG: Any, side: float, color: Any) -> Solid:
    """The boundary of a half-space, as far as it is of interest."""
    corners = side / 2 * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    return Solid(body.name, body.kind, corners @ X_BG.rotation().T + X_BG.position, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(color, (2, 1)))


def frames_of(plan: Plan, *, speed: float = 1.0, pause: float = 0.0, rate: float = RATE) -> Iterator[Frame]:
    """Yields the frames of a plan at equal times, and its end. Between two knots a frame has the contacts of the next knot. Raises InvalidInput."""
    if not 0 < rate <= 1000:
        raise InvalidInput(f"rate: got {rate:g}, expected frames a second in (0, 1000]")
    trajectory = make_trajectory(plan, speed=speed, pause=pause)
    model, times = plan.task.model, np.asarray(trajectory.times)
    q, u, knots, segments = (np.asarray(values) for values in (trajectory.q, trajectory.u, trajectory.knots, trajectory.segments))
    contacts = [[Contact(c.a, c.b, c.point, c.force) for c in at] for at in plan.contacts]
    stiffness = np.asarray(model.stiffness)
    for t in np.append(np.arange(0, times[-1], 1 / rate), times[-1]):
        k = max(1, int(np.searchsorted(times, t)))
        share = (t - times[k - 1]) / (times[k] - times[k - 1])
        at = model.retract(q[k - 1], share * model.local(q[k - 1], q[k]))
        command = (1 - share) * u[k - 1] + share * u[k]
        kind = plan.segments[segments[k]].kind.name.lower()
        yield Frame(float(t), at, command, stiffness * (command - at[-model.n_a :]), contacts[knots[k]], kind)


def frame_of(sample: RunSample, model: Model) -> Frame:
    """What a run sees at a moment."""
    geometries, pairs = model.geometries, model.pairs
    contacts = [
        Contact(geometries[pairs[force.pair].geometry_a].name, geometries[pairs[force.pair].geometry_b].name, force.p_WC, force.force_W) for force in sample.forces
    ]
    figures = {"plans": sample.plans, "pieces": sample.piece + 1, "goal_share": sample.goal_share}
    return Frame(sample.time, sample.q, sample.u, sample.torque, contacts, sample.state.name.lower(), figures)


class Arrows:
    """Lengths of forces: the largest one so far is as long as an arrow may be."""

    def __init__(self, scene: Scene) -> None:
        self.longest = LONGEST * scene.radius
        self._largest = 0.0

    def scale(self, contacts: Sequence[Contact]) -> float:
        """[m/N] for these contacts."""
        self._largest = max([self._largest, *(float(np.linalg.norm(contact.force)) for contact in contacts)])
        return self.longest / self._largest if self._largest > 0 else 0.0


class Stream:
    """Open viewers that show frames. Pass it as on_sample of run(): a call with a RunSample shows the sample. Use it in a `with` block, which closes it."""

    def __init__(self, shown: Plan | Task, sinks: list[Sink], *, paced: bool) -> None:
        self._shown, self._sinks, self._paced = shown, sinks, paced
        self._model = shown.task.model if isinstance(shown, Plan) else shown.model
        self._begin: float | None = None
        self._offset = 0.0  # of the time of what is sent now; a plan that is played again goes on
        self._last = 0.0

    @property
    def live(self) -> bool:
        """True: a viewer is connected."""
        return any(sink.live for sink in self._sinks)

    @property
    def addresses(self) -> list[str]:
        """Addresses at which viewers show the stream."""
        return [sink.address for sink in self._sinks]

    def __call__(self, sample: RunSample) -> None:
        self.send(frame_of(sample, self._model))

    def send(self, frame: Frame) -> None:
        """Sends a frame to all viewers. If the stream is paced, it waits until the time of the frame."""
        at = Frame(frame.time + self._offset, frame.q, frame.u, frame.torque, frame.contacts, frame.state, frame.figures)
        if self._paced:
            self._begin = time.monotonic() - at.time if self._begin is None else self._begin
            time.sleep(max(0.0, self._begin + at.time - time.monotonic()))
        for sink in self._sinks:
            sink.send(at)
        self._last = at.time

    def play(self, plan: Plan | None = None, *, speed: float = 1.0, pause: float = 0.0, rate: float = RATE) -> float:
        """Plays a plan once. A further call continues after it.

        plan: Plan of the task that is shown. None: the plan that is shown.
        speed: factor on the full speed that follows from the object and the motors, > 0.
        pause: time of constant commands between pushes and regrasps [s].
        rate: frames per second.

        Returns the length of the plan [s]. Raises InvalidInput.
        """
        played = self._shown if plan is None else plan
        if not isinstance(played, Plan):
            raise InvalidInput(f"plan: got {type(played).__name__}, expected a Plan; run(task, on_sample=stream) shows a task that is not planned")
        self._offset = self._last
        for frame in frames_of(played, speed=speed, pause=pause, rate=rate):
            self.send(frame)
        return self._last - self._offset

    def wait(self, timeout_s: float = 0.2) -> bool:
        """Waits until all viewers are connected, at most timeout_s. Returns True if they are; a file always is."""
        return all([sink.wait(timeout_s) for sink in self._sinks])

    def close(self) -> None:
        for sink in self._sinks:
            sink.close()

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def stream(
    shown: Plan | Task, *, foxglove: int | None = None, host: str = "127.0.0.1", rerun: str | os.PathLike[str] | None = None, paced: bool | None = None
) -> Stream:
    """Opens live viewers, Foxglove or rerun, on a plan or a task (docs/streams.md).

    Use the stream in a `with` block: with st.stream(task, foxglove=8765) as stream: st.run(task, on_sample=stream).

      shown: Plan or Task.
      foxglove: port of a server to which Foxglove connects; 0: any free port. None: no server.
      host: address on which the server listens. Everybody who can reach this address can watch.
      rerun: a file .rrd to write, or the address of a running viewer, `rerun+http://127.0.0.1:9876/proxy`. None: no rerun.
      paced: True: a frame is sent when its time has come. None: paced, unless the stream only writes a file.

    Returns a Stream. Raises InvalidInput: no viewer, a port in use, a viewer that does not answer; MissingExtra: install
    `stiction[foxglove]` or `stiction[rerun]` with pip.
    """
    if not isinstance(shown, (Plan, Task)):
        raise InvalidInput(f"shown: got {type(shown).__name__}, expected a Plan or a Task")
    if foxglove is None and rerun is None:
        raise InvalidInput("foxglove, rerun: got neither, expected a port of Foxglove, a file or an address of rerun, or both")
    scene = make_scene(shown)
    sinks: list[Sink] = []
    try:
        if foxglove is not None:
            from ._foxglove import Foxglove

            sinks.append(Foxglove(scene, host, foxglove))
        if rerun is not None:
            from ._rerun import Rerun

            sinks.append(Rerun(scene, os.fspath(rerun)))
    except Exception:
        for sink in sinks:
            sink.close()
        raise
    return Stream(shown, sinks, paced=any(sink.live for sink in sinks) if paced is None else paced)


def robots_of(model: Model) -> dict[str, list[int]]:
    """Robot -> its joints, as indices into u."""
    out: dict[str, list[int]] = {}
    for i, name in enumerate(model.joint_names):
        out.setdefault(name.split("/")[0], []).append(i)
    return out


def kinds_of(model: Model) -> dict[str, str]:
    """Body -> robot, object or fixed."""
    words = {BodyKind.Robot: "robot", BodyKind.Object: "object", BodyKind.Fixed: "fixed"}
    return {body.name: words[body.kind] for body in model.bodies}
