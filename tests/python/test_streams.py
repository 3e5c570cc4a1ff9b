"""Live streams: what Foxglove and rerun are sent is what the plan, or the run, says."""

from __future__ import annotations

import json
import re
import signal
import socket
import struct
import sys
import threading
import time
from pathlib import Path
from typing import Any

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
LIMIT_S = 20.0


@pytest.fixture(scope="module")
def st(program: Path):
    sys.path.insert(0, str(program.parent / "python"))
    return pytest.importorskip("stiction")


@pytest.fixture(scope="module")
def plan(st, plan_file: Path):
    return st.read_plan(plan_file)


# ---- the wire of Foxglove, read without its package


def wire(data: bytes) -> dict[int, list[Any]]:
    """The fields of a message of protobuf by number: integers, doubles, or bytes."""
    out: dict[int, list[Any]] = {}
    at = 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(data):
        number, kind = divmod(varint(), 8)
        value: Any
        if kind == 0:
            value = varint()
        elif kind == 1:
            (value,) = struct.unpack_from("<d", data, at)
            at += 8
        elif kind == 5:
            (value,) = struct.unpack_from("<I", data, at)
            at += 4
        else:
            size = varint()
            value = data[at : at + size]
            at += size
        out.setdefault(number, []).append(value)
    return out


def numbers(data: bytes, count: int) -> list[float]:
    """Doubles 1 to count of a message; zeros are not sent."""
    fields = wire(data)
    return [fields.get(k + 1, [0.0])[0] for k in range(count)]


def poses_in(data: bytes) -> dict[str, tuple[list[float], list[float]]]:
    """Position and quaternion x y z w of each frame of FrameTransforms, all in `world`."""
    out = {}
    for transform in (wire(part) for part in wire(data)[1]):
        assert transform[2] == [b"world"]
        out[transform[3][0].decode()] = (numbers(transform[4][0], 3), numbers(transform[5][0], 4))
    return out


class Viewer:
    """A client of the websocket protocol that subscribes to everything, and keeps what comes until `frames` messages of /state are there."""

    def __init__(self, address: str, frames: int) -> None:
        from websockets.sync.client import connect

        self._socket = connect(address, subprotocols=["foxglove.sdk.v1"], open_timeout=LIMIT_S, close_timeout=0.1, max_size=None)  # type: ignore[list-item]
        self._frames = frames
        self.messages: dict[str, list[tuple[int, bytes]]] = {}
        self.schemas: dict[str, str] = {}
        topics: dict[int, str] = {}
        while "/state" not in self.schemas:
            said = json.loads(self._socket.recv(timeout=LIMIT_S))
            if said["op"] == "advertise":
                for channel in said["channels"]:
                    topics[channel["id"]] = channel["topic"]
                    self.schemas[channel["topic"]] = channel["schemaName"]
        self._topics = topics
        subscriptions = [{"id": number, "channelId": number} for number in topics]
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        while len(self.messages.get("/state", [])) < self._frames:
            data = self._socket.recv(timeout=LIMIT_S)
            if isinstance(data, bytes) and data[0] == 1:
                number, log_time = struct.unpack_from("<IQ", data, 1)
                self.messages.setdefault(self._topics[number], []).append((log_time, data[13:]))

    def finish(self) -> None:
        self._thread.join(LIMIT_S)
        assert not self._thread.is_alive(), "not all frames came"
        self._socket.close()

    def json(self, topic: str) -> list[dict[str, Any]]:
        return [json.loads(data) for _, data in self.messages[topic]]


@pytest.fixture(scope="module")
def shown(st, plan) -> tuple[Viewer, list[Any]]:
    """What Foxglove is sent of the plan, and the frames."""
    pytest.importorskip("foxglove")
    from stiction.streams import frames_of

    frames = list(frames_of(plan, rate=10))
    with st.stream(plan, foxglove=0, paced=False) as stream:
        (address,) = stream.addresses
        assert re.fullmatch(r"ws://127\.0\.0\.1:\d+", address), "nobody else can look unless a host is given"
        viewer = Viewer(address, len(frames))
        while not stream.wait():
            pass
        assert stream.play(rate=10) == pytest.approx(frames[-1].time)
        viewer.finish()
    return viewer, frames


def test_frames_of_a_plan_are_at_equal_times_and_end_at_its_end(st, plan) -> None:
    from stiction.streams import frames_of

    trajectory, frames = st.make_trajectory(plan, speed=1.0), list(frames_of(plan, rate=10))
    times = [frame.time for frame in frames]
    assert times[0] == 0 and times[-1] == trajectory.duration and np.allclose(np.diff(times)[:-1], 0.1)
    assert np.array_equal(frames[0].q, trajectory.q[0]) and np.allclose(frames[-1].q, plan.q[-1], atol=1e-12)
    for column in range(plan.task.model.n_a):
        wanted = np.interp(times, trajectory.times, trajectory.u[:, column])
        assert np.allclose([frame.u[column] for frame in frames], wanted, atol=1e-12)
    with pytest.raises(st.InvalidInput, match=r"rate: got 0, expected frames a second in \(0, 1000\]"):
        list(frames_of(plan, rate=0))


def test_foxglove_has_poses_of_all_bodies(shown, plan) -> None:
    viewer, frames = shown
    assert viewer.schemas["/tf"] == "foxglove.FrameTransforms" and viewer.schemas["/scene"] == viewer.schemas["/forces"] == "foxglove.SceneUpdate"
    model, sent = plan.task.model, viewer.messages["/tf"]
    assert len(sent) == len(frames)
    stamps = np.array([log_time for log_time, _ in sent])
    assert np.allclose((stamps - stamps[0]) * 1e-9, [frame.time for frame in frames], atol=1e-6)
    links = {link.name for link in model.links}
    for frame, (_, data) in zip(frames, sent):
        poses = poses_in(data)
        # Both robots have links of the same names, which are frames as robot/link then.
        wanted = model.calc_kinematics(frame.q).X_WB
        assert set(poses) == {body.name for body in model.bodies} and links <= set(poses)
        for body, pose in zip(model.bodies, wanted):
            position, (x, y, z, w) = poses[body.name]
            assert np.allclose(position, pose.p, atol=1e-12)
            rotation = np.array(
                [
                    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
                ]
            )
            assert np.allclose(rotation, pose.R, atol=1e-12)


def test_foxglove_ends_where_the_plan_file_does(shown, plan_file: Path) -> None:
    """The file was written by the program: poses x y z qw qx qy qz of the bodies that move, rounded to 1e-6."""
    viewer, _ = shown
    raw = json.loads(plan_file.read_text(encoding="utf-8"))
    poses = poses_in(viewer.messages["/tf"][-1][1])
    moving = [body["name"] for body in raw["bodies"] if body["moving"]]
    for name, numbers_ in zip(moving, raw["segments"][-1]["knots"][-1]["bodies"]):
        assert np.allclose(poses[name][0], numbers_[:3], atol=2e-6)
        x, y, z, w = poses[name][1]
        assert abs(np.dot([w, x, y, z], numbers_[3:])) == pytest.approx(1, abs=2e-6)


def test_foxglove_has_contacts_as_numbers_and_as_arrows(shown, plan) -> None:
    viewer, frames = shown
    assert sum(len(frame.contacts) for frame in frames) > 20
    longest = []
    for frame, said, (_, drawn) in zip(frames, viewer.json("/contacts"), viewer.messages["/forces"]):
        assert [(c["a"], c["b"]) for c in said["contacts"]] == [(c.a, c.b) for c in frame.contacts]
        for contact, wanted in zip(said["contacts"], frame.contacts):
            assert [contact["point"][axis] for axis in "xyz"] == wanted.point.tolist() and [contact["force"][axis] for axis in "xyz"] == wanted.force.tolist()
            assert contact["newton"] == pytest.approx(np.linalg.norm(wanted.force))
        (entity,) = wire(drawn)[2]
        arrows = [wire(arrow) for arrow in wire(entity).get(7, [])]
        assert wire(entity)[2] == [b"world"] and wire(entity)[3] == [b"forces"], "one entity, so that arrows of the frame before are gone"
        forces = [c for c in frame.contacts if np.linalg.norm(c.force) > 0]
        assert len(arrows) == len(forces)
        for arrow, contact in zip(arrows, forces):
            pose = wire(arrow[1][0])
            assert np.allclose(numbers(pose[1][0], 3), contact.point, atol=1e-12)
            x, y, z, w = numbers(pose[2][0], 4)
            axis = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]  # the arrow lies along x
            assert np.allclose(axis, contact.force / np.linalg.norm(contact.force), atol=1e-9)
            longest.append((arrow[2][0] + arrow[4][0]) / np.linalg.norm(contact.force))
    assert (np.diff(longest) <= 1e-12).all(), "the largest force so far is as long as an arrow may be"


def test_foxglove_has_joints_and_commands_of_each_robot(shown, plan) -> None:
    viewer, frames = shown
    model = plan.task.model
    for robot in dict.fromkeys(joint.split("/")[0] for joint in model.joint_names):
        columns = [i for i, joint in enumerate(model.joint_names) if joint.startswith(robot + "/")]
        for topic, has_effort in ((f"/{robot}/joint_states", True), (f"/{robot}/joint_commands", False)):
            assert viewer.schemas[topic] == "foxglove.JointStates" and len(viewer.messages[topic]) == len(frames)
            for frame, (_, data) in zip(frames, viewer.messages[topic]):
                joints = [wire(joint) for joint in wire(data)[2]]
                assert [joint[1][0].decode() for joint in joints] == [model.joint_names[i].split("/")[1] for i in columns], "as in the URDF"
                wanted = frame.q[-model.n_a :] if has_effort else frame.u
                assert [joint[2][0] for joint in joints] == wanted[columns].tolist()
                assert [5 in joint for joint in joints] == [has_effort] * len(joints)
                if has_effort:
                    torque = np.asarray(model.stiffness) * (frame.u - frame.q[-model.n_a :])
                    assert np.allclose([joint[5][0] for joint in joints], torque[columns], atol=1e-12)


def test_foxglove_has_the_meshes_and_so_has_who_comes_late(st, plan, shown) -> None:
    from stiction.streams import make_scene

    scene = make_scene(plan)
    assert {solid.body for solid in scene.solids} >= set(plan.task.model.object_names)

    def triangles(data: bytes) -> dict[str, int]:
        out = {}
        for entity in (wire(part) for part in wire(data)[2]):
            assert entity[5] == [1], "it moves with its frame"
            (mesh,) = (wire(part) for part in entity[12])
            assert len(mesh[2]) == len(mesh[4]), "a colour for each corner"
            out[entity[3][0].decode()] = len(mesh[2]) // 3
        return out

    wanted = {f"{k} {solid.body}": len(solid.triangles) for k, solid in enumerate(scene.solids)}
    wanted["goal"] = sum(len(solid.triangles) for solid in scene.solids if solid.body == scene.goal[0])
    ((_, data),) = shown[0].messages["/scene"]
    assert triangles(data) == wanted
    frame = shown[1][0]
    with st.stream(plan, foxglove=0, paced=False) as stream:
        for number in range(2):  # the second one comes after frames were sent
            viewer = Viewer(stream.addresses[0], 1)
            stream.wait()
            while "/state" not in viewer.messages:
                stream.send(frame)
                time.sleep(0.02)
            viewer.finish()
            received = [data for _, data in viewer.messages.get("/scene", [])]
            assert received, f"viewer {number} has no meshes"
            assert triangles(received[0]) == wanted


def test_a_port_that_is_taken_is_named(st, plan) -> None:
    pytest.importorskip("foxglove")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(st.InvalidInput, match=rf"foxglove: got 127.0.0.1:{port}, which cannot be listened on .*, expected an address of this machine and a port that is free"):
            st.stream(plan, foxglove=port)


# ---- rerun


def rows_of(file: Path) -> dict[str, dict[str, list[Any]]]:
    """Entity -> component -> its values in the order of time; `time` is that timeline [s]."""
    chunk = pytest.importorskip("rerun.chunk")
    out: dict[str, dict[str, list[Any]]] = {}
    for part in chunk.RrdReader(file).stream():
        batch = part.to_record_batch()
        columns = out.setdefault(part.entity_path.replace("\\", ""), {})
        for name in batch.schema.names:
            values = batch.column(name)
            columns.setdefault(name.split(":")[-1], []).extend(1e-9 * v.value for v in values) if name == "time" else columns.setdefault(name.split(":")[-1], []).extend(values.to_pylist())
    return out


def test_rerun_holds_poses_forces_joints_and_meshes(st, plan, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from stiction.streams import frames_of, make_scene

    file = tmp_path / "folder" / "motion.rrd"
    with st.stream(plan, rerun=file) as stream:
        assert not stream.live and stream.wait(0), "a file needs nobody"
        stream.play(rate=5)
    rows, frames, model = rows_of(file), list(frames_of(plan, rate=5)), plan.task.model
    kinds = {st.BodyKind.Robot: "robot", st.BodyKind.Object: "object", st.BodyKind.Fixed: "fixed"}
    for index, body in enumerate(model.bodies):
        entity = rows[f"/world/{kinds[body.kind]}/{body.name}"]
        assert np.allclose(entity["time"], [frame.time for frame in frames], atol=1e-9)
        poses = [model.calc_kinematics(frame.q).X_WB[index] for frame in frames]
        assert np.allclose([p[0] for p in entity["translation"]], [pose.p for pose in poses], atol=1e-6), "single precision"
        turned = np.einsum("ki,ki->k", [q[0] for q in entity["quaternion"]], [np.roll(pose.quaternion_wxyz, -1) for pose in poses])
        assert np.allclose(np.abs(turned), 1, atol=1e-6)
    arrows = rows["/world/forces"]
    for frame, origins, vectors in zip(frames, arrows["origins"], arrows["vectors"], strict=True):
        assert np.allclose(np.reshape(origins, (-1, 3)), np.reshape([c.point for c in frame.contacts], (-1, 3)), atol=1e-6)
        for vector, contact in zip(vectors, frame.contacts):
            force = float(np.linalg.norm(contact.force))
            assert force == 0 or np.allclose(np.asarray(vector) / np.linalg.norm(vector), contact.force / force, atol=1e-5)
    for i, joint in enumerate(model.joint_names):
        assert np.allclose(np.ravel(rows[f"/joints/{joint}/position"]["scalars"]), [frame.q[-model.n_a + i] for frame in frames], atol=1e-12)
        assert np.allclose(np.ravel(rows[f"/joints/{joint}/command"]["scalars"]), [frame.u[i] for frame in frames], atol=1e-12)
    pairs = {(c.a, c.b) for frame in frames for c in frame.contacts}
    for a, b in pairs:
        newtons = dict(zip(np.round(rows[f"/newton/{a} by {b}"]["time"], 6), np.ravel(rows[f"/newton/{a} by {b}"]["scalars"])))
        for frame in frames:
            whole = sum((c.force for c in frame.contacts if (c.a, c.b) == (a, b)), np.zeros(3))
            assert newtons.get(round(frame.time, 6), 0.0) == pytest.approx(np.linalg.norm(whole), abs=1e-9)
    for number, solid in enumerate(make_scene(plan).solids):
        (corners,) = rows[f"/world/{solid.kind}/{solid.body}/shape_{number}"]["vertex_positions"]
        assert np.allclose(corners, solid.vertices[solid.triangles].reshape(-1, 3), atol=1e-6)


def test_rerun_without_a_viewer_or_a_name_of_a_file_is_named(st, plan, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    with pytest.raises(st.InvalidInput, match=r"rerun: got 'rerun\+http://127.0.0.1:9/proxy', where no viewer answers .*, expected the address of one that was started before"):
        st.stream(plan, rerun="rerun+http://127.0.0.1:9/proxy")
    with pytest.raises(st.InvalidInput, match=r"rerun: got '.*motion.mcap', expected a file that ends in .rrd, or an address as rerun"):
        st.stream(plan, rerun=tmp_path / "motion.mcap")


# ---- runs


class Kept:
    """A viewer that keeps what it is sent."""

    live, address = False, "kept"

    def __init__(self) -> None:
        self.frames: list[Any] = []

    def send(self, frame: Any) -> None:
        self.frames.append(frame)

    def wait(self, timeout_s: float) -> bool:
        return True

    def close(self) -> None:
        pass


def test_samples_of_a_run_are_what_it_returns(st, plan) -> None:
    samples: list[Any] = []
    run = st.run(plan, seed=0, duration=3.0, plan_step_time_s=1e-4, threads=1, on_sample=samples.append)
    assert len(samples) == len(run.times) > 50
    for name in ("time", "q", "q_plan", "u", "piece"):
        got = np.array([getattr(sample, name) for sample in samples])
        assert np.array_equal(got, getattr(run, name if name != "time" else "times")), name
    assert {sample.state for sample in samples} >= {st.RunState.Hold, st.RunState.Push}
    assert all(len(sample.torque) == plan.task.model.n_a for sample in samples) and np.abs([sample.torque for sample in samples]).max() > 0
    assert any(force.normal > 0 for sample in samples if sample.state == st.RunState.Push for force in sample.forces)
    without = st.run(plan, seed=0, duration=3.0, plan_step_time_s=1e-4, threads=1)
    assert np.array_equal(without.q, run.q), "who looks changes nothing"


def test_forces_of_a_sample_carry_the_object(st) -> None:
    """A box at rest on a table: the table carries its weight."""
    cart = '<robot name="cart"><link name="rail"/><link name="body"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>'
    cart += '<joint name="x" type="prismatic"><parent link="rail"/><child link="body"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="100" velocity="1"/></joint></robot>'
    task = st.Task(
        {
            "name": "rest",
            "scene": {
                "gravity": [0, 0, -9.81],
                "robots": [{"name": "cart", "urdf": cart, "base": {"position": [0, 0, 0.5]}}],
                "objects": [{"name": "box", "joint": "free", "mass": 2.0, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}}]}],
                "fixed": [{"name": "table", "shapes": [{"half_space": {}}]}],
            },
            "start": {"joints": {"cart/x": 0.5}, "objects": {"box": {"position": [0, 0, 0.05], "rpy": [0, 0, 0]}}},
            "goal": {"objects": {"box": {"position": [0, 0, 0.05], "rpy": [0, 0, 0]}}},
            "tolerance": {"position": 0.01, "angle": 0.1},
        }
    )
    samples: list[Any] = []
    run = st.run(task, seed=0, duration=3.0, on_sample=samples.append)
    assert run.reached
    model = task.model
    total = np.zeros(3)
    for force in samples[-1].forces:
        names = [model.geometries[index].name.split("/")[0] for index in (model.pairs[force.pair].geometry_a, model.pairs[force.pair].geometry_b)]
        total += force.force_W if names[0] == "box" else -force.force_W
    assert np.allclose(total, [0, 0, 2.0 * 9.81], atol=0.01 * 2.0 * 9.81)


def test_a_stream_takes_a_run_as_it_happens(st, plan) -> None:
    from stiction.streams import Stream

    kept = Kept()
    stream = Stream(plan, [kept], paced=False)
    run = st.run(plan, seed=0, duration=2.0, plan_step_time_s=1e-4, threads=1, on_sample=stream)
    assert [frame.time for frame in kept.frames] == run.times.tolist()
    assert np.array_equal([frame.q for frame in kept.frames], run.q)
    touched = [contact for frame in kept.frames for contact in frame.contacts]
    names = {geometry.name for geometry in plan.task.model.geometries}
    assert touched and all({contact.a, contact.b} <= names for contact in touched)
    assert {frame.state for frame in kept.frames} <= {"hold", "push", "regrasp", "replan"} and kept.frames[-1].figures["pieces"] == run.piece[-1] + 1


def test_a_plant_of_ones_own_is_shown_without_forces(st, plan) -> None:
    samples: list[Any] = []
    st.run(plan.task, plant=st.SimulatedPlant(plan.task), seed=0, duration=0.3, on_sample=samples.append)
    assert samples and all(len(sample.torque) == 0 and sample.forces == [] for sample in samples)


def test_an_error_of_who_looks_ends_the_run_and_is_raised(st, plan) -> None:
    seen = []

    def look(sample: Any) -> None:
        seen.append(sample)
        raise OSError("the viewer is gone")

    with pytest.raises(OSError, match="the viewer is gone"):
        st.run(plan, seed=0, duration=2.0, on_sample=look)
    assert len(seen) == 1


def test_plans_that_are_played_again_go_on(st, plan) -> None:
    from stiction.streams import Stream

    kept = Kept()
    stream = Stream(plan, [kept], paced=False)
    length = stream.play(rate=5)
    stream.play(rate=5)
    times = [frame.time for frame in kept.frames]
    assert times[-1] == pytest.approx(2 * length) and (np.diff(times) >= 0).all()


# ---- the command


@pytest.fixture
def streaming(program: Path, tmp_path: Path):
    """Starts the command with the Python of the tests."""

    def start(*words: object) -> children.Child:
        return children.Child([program, "stream", *words], env={"PATH": "/usr/bin:/bin", "STICTION_PYTHON": sys.executable, "HOME": str(tmp_path)}, cwd=tmp_path)

    return start


def address_of(child: children.Child) -> str:
    from limits import within

    assert child.stderr is not None
    with within(children.LIMIT, "the address"):
        return child.stderr.readline().split()[0]


def test_the_command_plays_a_plan_until_ctrl_c(streaming, plan_file: Path) -> None:
    pytest.importorskip("foxglove")
    with streaming(plan_file, "--foxglove", 0, "--speed", 5, "--json") as child:
        viewer = Viewer(address_of(child), 20)
        viewer.finish()
        done = child.stop(signal.SIGINT)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["status"] == "Done"
    times = [said["time_s"] for said in viewer.json("/state")]
    assert np.allclose(np.diff(times), 0.02, atol=1e-9)


def test_the_command_shows_a_run_as_it_happens(streaming) -> None:
    pytest.importorskip("foxglove")
    with streaming("planar_pushing", "--run", "--foxglove", 0, "--seed", 0, "--duration", 1.0, "--json") as child:
        viewer = Viewer(address_of(child), 20)
        viewer.finish()
        done = child.finish()
    result = json.loads(done.stdout)
    assert done.returncode == 3 and result["status"] == "TimeUp", done.stderr
    assert {said["state"] for said in viewer.json("/state")} <= {"hold", "push", "regrasp", "replan"}


def test_the_command_writes_a_file_once(streaming, plan_file: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    with streaming(plan_file, "--rerun", tmp_path / "plan.rrd", "--speed", 5, "--json") as child:
        done = child.finish()
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["times"] == 1 and (tmp_path / "plan.rrd").stat().st_size > 1000


def test_bad_words_are_named(st, stiction, plan_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for words, message in (
        (("planar_pushing", "--foxglove"), "PLAN: got the task 'planar_pushing', expected a plan (`stiction plan planar_pushing`), or --run"),
        ((plan_file,), "--foxglove, --rerun: got neither, expected at least one"),
        ((plan_file, "--foxglove", "70000"), "--foxglove: got '70000', expected an integer from 0 to 65535"),
        ((plan_file, "--foxglove", "--speed", "0"), "--speed: got '0'"),
        (("no_such_task", "--run", "--foxglove"), "no_such_task"),
    ):
        done = stiction("stream", *words, "--json")
        assert done.returncode == 2 and message in done.stderr and json.loads(done.stdout)["status"] == "InvalidInput", done.stderr
    plan = st.read_plan(plan_file)
    with pytest.raises(st.InvalidInput, match="foxglove, rerun: got neither"):
        st.stream(plan)
    with pytest.raises(st.InvalidInput, match="shown: got str, expected a Plan or a Task"):
        st.stream("plan.json", foxglove=0)
    from stiction.streams import Stream

    with pytest.raises(st.InvalidInput, match=r"plan: got Task, expected a Plan; run\(task, on_sample=stream\)"):
        Stream(plan.task, [Kept()], paced=False).play()
    for module in ("foxglove", "rerun"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(st.MissingExtra, match=r"a stream to Foxglove: no Python module 'foxglove'; `pip install 'stiction\[foxglove\]'` brings it"):
        st.stream(plan, foxglove=0)
    with pytest.raises(st.MissingExtra, match=r"a stream to rerun: no Python module 'rerun'; `pip install 'stiction\[rerun\]'` brings it"):
        st.stream(plan, rerun="plan.rrd")


def test_commands_of_the_page_are_read(st) -> None:
    """They serve until they are ended, or need an optional package: tests of documents do not run them."""
    from stiction._stream_command import make_parser

    block = re.search(r"^```shell\n(.*?)^```", (ROOT / "docs" / "streams.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    assert block is not None
    lines = [line.split() for line in block[1].splitlines() if line.startswith("stiction stream ")]
    given = [make_parser().parse_args(words[2:]) for words in lines]
    assert [(a.target, a.foxglove, a.rerun, a.run) for a in given] == [("out", None, "out/plan.rrd", False), ("out", 8765, None, False), ("planar_hand", 8765, None, True)]
