"""Plans over time for other programs: every format says what the plan file says."""

from __future__ import annotations

import csv
import io
import json
import re
import struct
import sys
from itertools import chain
from pathlib import Path
from types import ModuleType

import children
import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2._dynamic import generate_dynamic
from mcap_ros2.decoder import DecoderFactory

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def st(program: Path):
    sys.path.insert(0, str(program.parent / "python"))
    return pytest.importorskip("stiction")


@pytest.fixture(scope="module")
def raw(plan_file: Path) -> dict:
    return json.loads(plan_file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def knots(raw: dict) -> list[dict]:
    """Those of the plan file, the start first."""
    return [raw["start"] | {"contacts": []}, *chain.from_iterable(segment["knots"] for segment in raw["segments"])]


@pytest.fixture(scope="module")
def motion(stiction, plan_file: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """The motion as JSON, by the program."""
    file = tmp_path_factory.mktemp("motion") / "motion.json"
    done = stiction("export", plan_file, "-o", file, "--json")
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    read = json.loads(file.read_text(encoding="utf-8"))
    assert out["files"] == [str(file)] and out["knots"] == len(read["knots"]) and out["duration_s"] == read["knots"][-1]["time"]
    return read


def column(motion: dict, name: str) -> np.ndarray:
    return np.array([knot[name] for knot in motion["knots"]])


def find_knots(motion: dict, knots: list[dict]) -> list[int | None]:
    """The knot of the plan file that has the joints of each knot of the motion, found by its numbers; None in between."""
    out: list[int | None] = []
    at = 0
    for knot in motion["knots"]:
        same = [i for i in range(at, len(knots)) if knots[i]["joints"] == knot["q"]]
        out.append(same[0] if same else None)
        at = same[0] if same else at
    return out


def test_the_motion_is_that_of_the_plan_file(motion: dict, raw: dict, knots: list[dict], st) -> None:
    assert motion["joints"] == raw["joints"] and motion["objects"] == [o["name"] for o in raw["objects"]]
    assert motion["scene_sha256"] == raw["scene_sha256"] and motion["seed"] == raw["seed"] and motion["status"] == "Solved"
    found = find_knots(motion, knots)
    kinds = [knot["segment"] for knot in motion["knots"]]
    assert set(kinds) >= {"contact", "regrasp"}
    assert found[-1] == len(knots) - 1 and len(set(found) - {None}) >= 0.9 * (len(knots) - found[0]), "knots of the plan, in order, and some in between"
    rest = [k for k, (a, b) in enumerate(zip(kinds, kinds[1:])) if a != b and a != "settle"]
    assert rest and all(motion["knots"][k]["q_cmd"] == knots[found[k]]["u"] for k in rest), "where a piece ends nothing moves that commands would have to lead (E.17)"
    stiffness = st.load_task("planar_hand").model.stiffness
    np.testing.assert_allclose(column(motion, "torque"), stiffness * (column(motion, "q_cmd") - column(motion, "q")), rtol=0, atol=1e-12 * stiffness.max())
    compared = 0
    for place, knot in zip(found, motion["knots"]):
        if place is not None:
            (y, z, angle), (pose,) = knots[place]["objects"][0]["coordinates"], knot["objects"]
            np.testing.assert_allclose(pose["position"], [0, y, z], atol=1e-12)
            np.testing.assert_allclose(np.abs(pose["quaternion_xyzw"]), np.abs([np.sin(angle / 2), 0, 0, np.cos(angle / 2)]), atol=1e-9)
            same_forces = [c["force"] for c in knot["contacts"]] == [c["force"] for c in knots[place]["contacts"]]
            compared += same_forces
            for contact in knot["contacts"]:
                assert contact["a"] in {g["name"] for g in raw["geometries"]} and contact["b"] in {g["name"] for g in raw["geometries"]}
    assert compared >= 0.9 * sum(place is not None for place in found), "equal states may come twice"
    assert sum(len(knot["contacts"]) for knot in motion["knots"]) > 10


def test_time_is_that_of_the_time_parametrisation(motion: dict, plan_file: Path, st) -> None:
    t, command = column(motion, "time"), column(motion, "q_cmd")
    trajectory = st.make_trajectory(st.read_plan(plan_file))
    assert t.tolist() == trajectory.times.tolist() and t[0] == 0 and (np.diff(t) > 0).all()
    speed = np.abs(np.diff(command, axis=0)).max(axis=1) / np.diff(t)
    pushes = np.array([knot["segment"] == "contact" for knot in motion["knots"]])[1:]
    assert np.median(speed[pushes]) < 0.5 * np.median(speed[~pushes]), "what is pushed may coast and trail by little (E.13), what moves freely may not"
    velocity = column(motion, "velocity")
    np.testing.assert_allclose(np.cumsum(velocity[1:] * np.diff(t)[:, None], axis=0), (column(motion, "q") - column(motion, "q")[0])[1:], atol=1e-9)
    assert not velocity[0].any()


def test_orientations_do_not_jump(motion: dict) -> None:
    quaternions = np.array([knot["objects"][0]["quaternion_xyzw"] for knot in motion["knots"]])
    assert (np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1, atol=1e-12)


def test_csv_and_npz_say_the_same(motion: dict, plan_file: Path, st, tmp_path: Path) -> None:
    plan = st.read_plan(plan_file)
    table, beside = plan.export(tmp_path / "new/motion.csv")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["time_s"]) for row in rows] == [knot["time"] for knot in motion["knots"]]
    for name in ("q", "q_cmd", "velocity", "torque"):
        assert [[float(row[f"{name}_{joint}"]) for joint in motion["joints"]] for row in rows] == column(motion, name).tolist(), name
    (name,) = motion["objects"]
    pose = [knot["objects"][0]["position"] + knot["objects"][0]["quaternion_xyzw"] for knot in motion["knots"]]
    assert [[float(row[f"{name}_{axis}"]) for axis in ("x", "y", "z", "qx", "qy", "qz", "qw")] for row in rows] == pose
    with beside.open(encoding="utf-8", newline="") as file:
        contacts = [(float(c["time_s"]), c["a"], c["b"], [float(c[f"force_{axis}"]) for axis in "xyz"]) for c in csv.DictReader(file)]
    expected = [(knot["time"], c["a"], c["b"], c["force"]) for knot in motion["knots"] for c in knot["contacts"]]
    assert contacts == expected

    (file,) = plan.export(tmp_path / "motion", format="npz")
    with np.load(file, allow_pickle=False) as arrays:
        assert arrays["joints"].tolist() == motion["joints"] and arrays["kinds"].tolist() == [knot["segment"] for knot in motion["knots"]]
        assert arrays["poses"][:, 0].tolist() == pose and arrays["torque"].tolist() == column(motion, "torque").tolist()
        assert [(motion["knots"][k]["time"], str(a), str(b), f.tolist()) for k, a, b, f in zip(*(arrays[f"contact_{n}"] for n in ("knot", "a", "b", "force")))] == expected
        assert str(arrays["task"]) == "planar_hand"


@pytest.fixture(scope="module")
def messages(st, plan_file: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list]:
    """By topic: (schema, log time [ns], bytes, message)."""
    (file,) = st.read_plan(plan_file).export(tmp_path_factory.mktemp("mcap") / "motion.mcap")
    out: dict[str, list] = {}
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for schema, channel, record, message in reader.iter_decoded_messages():
            assert channel.message_encoding == "cdr" and schema.encoding == "ros2msg"
            assert re.fullmatch(r"(/[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*)+", channel.topic), channel.topic
            out.setdefault(channel.topic, []).append((schema.name, record.log_time, record.data, message))
        (metadata,) = [record.metadata for record in reader.iter_metadata()]
        assert metadata["task"] == "planar_hand"
    return out


def seconds(stamp) -> float:
    return stamp.sec + 1e-9 * stamp.nanosec


def test_mcap_holds_a_trajectory_for_each_robot(messages: dict[str, list], motion: dict) -> None:
    time, command = column(motion, "time"), column(motion, "q_cmd")
    robots = dict.fromkeys(joint.split("/")[0] for joint in motion["joints"])
    assert len(robots) == 2
    for robot in robots:
        columns = [i for i, joint in enumerate(motion["joints"]) if joint.startswith(robot + "/")]
        ((schema, log_time, _, message),) = messages[f"/{robot}/joint_trajectory"]
        assert schema == "trajectory_msgs/msg/JointTrajectory" and log_time == 0
        assert message.joint_names == [motion["joints"][i].split("/")[1] for i in columns], "as in the URDF"
        assert seconds(message.header.stamp) == 0, "now, for a controller"
        assert np.array([list(point.positions) for point in message.points]).tolist() == command[:, columns].tolist()
        times = np.array([seconds(point.time_from_start) for point in message.points])
        np.testing.assert_allclose(times, time, atol=1e-9)
        assert (np.diff(times) > 0).all(), "a controller refuses others"
        assert not any(len(point.velocities) or len(point.accelerations) or len(point.effort) for point in message.points), "linear between knots"
        states = messages[f"/{robot}/joint_states"]
        assert {schema for schema, *_ in states} == {"sensor_msgs/msg/JointState"}
        for name, field in (("q", "position"), ("velocity", "velocity"), ("torque", "effort")):
            assert [list(getattr(state, field)) for *_, state in states] == column(motion, name)[:, columns].tolist(), field


def test_mcap_holds_the_urdf_of_each_robot_and_frames_that_stand(messages: dict[str, list], st) -> None:
    urdf = (ROOT / "models" / "planar_arm.urdf").read_text(encoding="utf-8") if (ROOT / "models" / "planar_arm.urdf").exists() else None
    for robot, text in st.load_task("planar_hand").model.scene.robot_urdfs.items():
        ((schema, log_time, _, message),) = messages[f"/{robot}/robot_description"]
        assert schema == "std_msgs/msg/String" and log_time == 0 and message.data == text and text.lstrip().startswith("<")
        assert urdf is None or "<robot" in text
    ((schema, _, _, message),) = messages["/tf_static"]
    assert schema == "tf2_msgs/msg/TFMessage" and message.transforms


def test_mcap_holds_objects_and_wrenches_at_their_points(messages: dict[str, list], motion: dict) -> None:
    assert len(messages["/tf"]) == len(motion["knots"])
    wrenches: dict[tuple[str, int], list] = {}
    for topic, records in messages.items():
        if topic.startswith("/contacts/"):
            for schema, log_time, _, message in records:
                assert schema == "geometry_msgs/msg/WrenchStamped" and "/" + message.header.frame_id == topic
                wrenches.setdefault(log_time, []).append(message)
    for knot, (_, log_time, _, message) in zip(motion["knots"], messages["/tf"]):
        assert log_time == round(1e9 * knot["time"])
        frames = {frame.child_frame_id: frame.transform for frame in message.transforms}
        assert {f.header.frame_id for f in message.transforms if f.child_frame_id in motion["objects"] or f.child_frame_id.startswith("contacts/")} == {"world"}
        for name, pose in zip(motion["objects"], knot["objects"]):
            assert [getattr(frames[name].translation, axis) for axis in "xyz"] == pose["position"]
            assert [getattr(frames[name].rotation, axis) for axis in "xyzw"] == pose["quaternion_xyzw"]
        acting = {w.header.frame_id: [w.wrench.force.x, w.wrench.force.y, w.wrench.force.z] for w in wrenches.get(log_time, []) if w.header.frame_id in frames}
        found = sorted([getattr(frames[name].translation, axis) for axis in "xyz"] + force for name, force in acting.items())
        assert found == sorted(c["point"] + c["force"] for c in knot["contacts"])
        ended = [w for w in wrenches.get(log_time, []) if w.header.frame_id not in frames]
        assert not any((w.wrench.force.x, w.wrench.force.y, w.wrench.force.z) != (0, 0, 0) for w in ended)


def test_a_reader_that_shares_nothing_with_the_writer_agrees(plan_file: Path, motion: dict, st, tmp_path: Path) -> None:
    """rosbags has its own MCAP and its own CDR; `make release-check` installs it."""
    any_reader = pytest.importorskip("rosbags.highlevel").AnyReader
    (file,) = st.read_plan(plan_file).export(tmp_path / "motion.mcap")
    read: dict[str, list] = {}
    with any_reader([file]) as reader:
        for connection, stamp, raw in reader.messages():
            read.setdefault(connection.topic, []).append((stamp, reader.deserialize(raw, connection.msgtype)))
    command = column(motion, "q_cmd")
    for robot in dict.fromkeys(joint.split("/")[0] for joint in motion["joints"]):
        columns = [i for i, joint in enumerate(motion["joints"]) if joint.startswith(robot + "/")]
        ((_, message),) = read[f"/{robot}/joint_trajectory"]
        assert [list(point.positions) for point in message.points] == command[:, columns].tolist()
        assert len(read[f"/{robot}/joint_states"]) == len(motion["knots"])
    assert [stamp for stamp, _ in read["/tf"]] == [round(1e9 * knot["time"]) for knot in motion["knots"]]
    forces = sum(abs(m.wrench.force.z) + abs(m.wrench.force.y) for topic, records in read.items() if topic.startswith("/contacts/") for _, m in records)
    assert forces == pytest.approx(sum(abs(c["force"][2]) + abs(c["force"][1]) for knot in motion["knots"] for c in knot["contacts"]))


def test_bytes_on_the_wire_are_those_of_cdr(messages: dict[str, list]) -> None:
    """Without any reader: encapsulation, stamp, frame with its length and its zero, padding to 8, six numbers."""
    topic = next(topic for topic in messages if topic.startswith("/contacts/"))
    for _, log_time, data, message in messages[topic][:20]:
        name = topic[1:].encode() + b"\0"
        head = struct.pack("<IIIII", 0x100, log_time // 10**9, log_time % 10**9, len(name), 0)[:16] + name
        head += b"\0" * (-(len(head) - 4) % 8)
        force = message.wrench.force
        assert data == head + struct.pack("<6d", force.x, force.y, force.z, 0, 0, 0)


def test_times_of_a_given_trajectory(plan_file: Path, st, tmp_path: Path) -> None:
    plan = st.read_plan(plan_file)
    trajectory = st.make_trajectory(plan, speed=0.5, pause=1.0)
    (file,) = plan.export(tmp_path / "slow.npz", trajectory=trajectory)
    with np.load(file) as arrays:
        assert arrays["time"].tolist() == trajectory.times.tolist()
    pushes = lambda of: np.diff(of.times)[[plan.segments[k].kind == st.SegmentKind.Contact for k in of.segments[1:]]].sum()
    pieces = 1 + sum(a.kind != b.kind for a, b in zip(plan.segments, plan.segments[1:]) if a.kind != st.SegmentKind.Settle)
    assert 1.5 < pushes(st.make_trajectory(plan, speed=0.5)) / pushes(st.make_trajectory(plan, speed=1.0)) < 2.01, "half the speed, apart from starts and stops"
    assert trajectory.duration - st.make_trajectory(plan, speed=0.5).duration == pytest.approx(1.0 * (pieces - 1), abs=1e-6)


def test_bad_input_is_named(stiction, plan_file: Path, st, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = st.read_plan(plan_file)
    with pytest.raises(st.InvalidInput, match="format: got 'bag', expected one of csv, json, lerobot, mcap, npz"):
        plan.export(tmp_path / "motion.csv", format="bag")
    with pytest.raises(st.InvalidInput, match="motion.txt: format: got 'txt', expected one of"):
        plan.export(tmp_path / "motion.txt")
    (tmp_path / "file").write_text("")
    with pytest.raises(st.InvalidInput, match="file/folder: cannot be made .*, expected a folder to write to"):
        plan.export(tmp_path / "file/folder/motion.csv")
    with pytest.raises(st.InvalidInput, match="^/proc/motion.csv: cannot be written .*, expected a folder to write to"):
        plan.export("/proc/motion.csv")  # no one may write there, root neither
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(st.InvalidInput, match="folder.csv: got a folder, expected a file"):
        plan.export(tmp_path / "folder.csv")
    other = st.make_trajectory(st.plan(st.load_task("planar_pushing"), seed=0).plan)
    with pytest.raises(st.InvalidInput, match="trajectory: got 5 coordinates"):
        plan.export(tmp_path / "motion.csv", trajectory=other)
    for words, message in (
        ((plan_file,), "format: got none, expected --format"),
        ((plan_file, "--format", "bag"), "format: got 'bag'"),
        ((tmp_path / "none.json", "--format", "csv"), "none.json"),
        ((plan_file, "--format", "csv", "--speed", "-1"), "speed"),
        ((plan_file, "--format", "csv", "--colour"), "unrecognized arguments: --colour"),
        ((plan_file, "-o", tmp_path / "file/motion.csv"), "file: cannot be made"),
    ):
        done = stiction("export", *words, "--json")
        assert done.returncode == 2 and message in done.stderr and done.stderr.startswith("stiction: ") and done.stderr.count("\n") == 1, done.stderr
        assert json.loads(done.stdout)["status"] == "InvalidInput"
    monkeypatch.setitem(sys.modules, "mcap_ros2", None)
    monkeypatch.setitem(sys.modules, "mcap_ros2.writer", None)
    with pytest.raises(st.MissingExtra, match=r"format mcap: no Python module 'mcap_ros2.writer'; `pip install 'stiction\[mcap\]'` brings it"):
        plan.export(tmp_path / "motion.mcap")
    assert not (tmp_path / "motion.mcap").exists()


def test_the_program_says_that_the_extra_is_missing(program: Path, plan_file: Path, tmp_path: Path) -> None:
    """With a Python that has the packages of the wheel and not those of the extra."""
    blocked = tmp_path / "blocked"
    (blocked / "mcap_ros2").mkdir(parents=True)
    (blocked / "sitecustomize.py").write_text("import sys\nsys.modules['mcap_ros2'] = None\n", encoding="ascii")
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nPYTHONPATH="{blocked}:$PYTHONPATH" exec "{sys.executable}" "$@"\n', encoding="ascii")
    python.chmod(0o755)
    words = [program, "export", plan_file, "-o", tmp_path / "motion.mcap"]
    done = children.run(words, limit=60, env={"STICTION_PYTHON": str(python), "PATH": "/usr/bin:/bin"})
    assert done.returncode == 70 and "pip install 'stiction[mcap]'" in done.stderr, done.stderr
    assert [path.name for path in tmp_path.glob("*motion*")] == []


def test_help_is_that_of_the_command(stiction) -> None:
    done = stiction("export", "--help")
    assert done.returncode == 0 and done.stdout.startswith("usage: stiction export") and "--format" in done.stdout


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def test_the_script_of_the_tutorial_sends_the_trajectory(stiction, real_plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a stand-in for ROS that decodes what it is given."""
    page = ROOT / "docs/tutorials/ros2_control.md"
    assert stiction("export", real_plan, "-o", tmp_path / "out/motion.mcap").returncode == 0
    sent = []

    class Node:
        def create_publisher(self, kind, topic, depth):
            assert (kind, topic) == ("JointTrajectory", "/arm_controller/joint_trajectory")
            return self

        publish = staticmethod(sent.append)
        get_subscription_count = staticmethod(lambda: 1)

    def deserialize(data: bytes, kind: str):
        from stiction._mcap import definition

        return generate_dynamic("trajectory_msgs/msg/JointTrajectory", definition("trajectory_msgs/JointTrajectory"))["trajectory_msgs/msg/JointTrajectory"](data)

    modules = {
        "rclpy": {"init": lambda: None, "create_node": lambda name: Node(), "spin_once": lambda node, timeout_sec: None},
        "rclpy.serialization": {"deserialize_message": deserialize},
        "trajectory_msgs": {},
        "trajectory_msgs.msg": {"JointTrajectory": "JointTrajectory"},
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        module.__dict__.update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.chdir(tmp_path)
    (script,), (settings,) = blocks(page, "py"), blocks(page, "yaml")
    exec(compile(script, str(page), "exec"), {})
    (message,) = sent
    parameters = yaml.safe_load(settings)["arm_controller"]["ros__parameters"]
    assert sorted(message.joint_names) == sorted(parameters["joints"])
    raw = json.loads(real_plan.read_text(encoding="utf-8"))
    assert list(message.points[-1].positions) == raw["segments"][-1]["knots"][-1]["u"]


@pytest.mark.filterwarnings("ignore:the plan does not reach its goal")
def test_topics_of_a_robot_have_one_name_where_names_are_alike(st, tmp_path: Path) -> None:
    text = (ROOT / "tasks" / "planar_hand.yaml").read_text(encoding="utf-8")
    names = {"left": "hand-ö", "right": "hand-ä"}  # the second comes first in the alphabet
    for before, after in names.items():
        text = re.sub(rf"(?<=[\[ ]){before}(?=[,\]\s])", after, text)
    (tmp_path / "task.yaml").write_text(text.replace("../models", str(ROOT / "models")), encoding="utf-8")
    task = st.load_task(tmp_path / "task.yaml")
    (file,) = task.follow(task.q_start[None, -4:] + 0.01).export(tmp_path / "motion.mcap")
    with file.open("rb") as stream:
        found = {channel.topic: message.data for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages() if channel.topic.endswith("description")}
    urdfs = task.model.scene.robot_urdfs
    assert found == {"/hand/robot_description": urdfs["hand-ö"], "/hand_2/robot_description": urdfs["hand-ä"]}


def test_names_of_topics_differ_where_names_do(st) -> None:
    from stiction._mcap import Tokens, definition

    tokens = Tokens()
    assert [tokens(name) for name in ("cube/box", "cube-box", "3_fingers", "__a", "cube/box")] == ["cube_box", "cube_box_2", "n_3_fingers", "a", "cube_box"]
    text = definition("tf2_msgs/TFMessage")
    assert text.count("MSG: ") == 5 and io.StringIO(text).readline().split() == ["geometry_msgs/TransformStamped[]", "transforms"]
