"""Logs of sensor_msgs/JointState in MCAP files, and the scenarios of sensing that they become."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402
from stiction._mcap import definition  # noqa: E402

UR5 = "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
POSTURE = [0.3, -1.2, 1.6, -1.97, -1.57, 0.4]


def state(t: float, joints: list[str], q: object, tau: object, velocity: object = ()) -> dict:
    stamp = {"sec": int(t), "nanosec": round((t - int(t)) * 1e9)}
    return {"header": {"stamp": stamp, "frame_id": ""}, "name": joints, "position": list(q), "velocity": list(velocity), "effort": list(tau)}


def write(file: Path, messages: list[tuple[str, dict]], interface: str = "sensor_msgs/JointState") -> Path:
    with file.open("wb") as out, Writer(out) as writer:
        schema = writer.register_msgdef(interface.replace("/", "/msg/"), definition(interface))
        for i, (topic, message) in enumerate(messages):
            writer.write_message(topic=topic, schema=schema, message=message, log_time=(i + 1) * 10**9, publish_time=0)
    return file


@pytest.fixture(scope="module")
def model() -> st.Model:
    return st.load_model({"robots": [{"name": "arm", "urdf": UR5}]})


@pytest.fixture(scope="module")
def joints(model: st.Model) -> list[str]:
    return [name.split("/")[1] for name in model.joint_names]


def push(model: st.Model) -> np.ndarray:
    return st.calc_contact_torque(model, POSTURE, "arm/forearm_link", [0.06, 0.02, 0.2], [-20, 0, 0])


def test_log_becomes_the_series_of_a_scenario_whatever_the_order_of_its_names(tmp_path: Path, model: st.Model, joints: list[str]) -> None:
    order = np.random.default_rng(0).permutation(6)
    names = [joints[k] for k in order]
    tau = [np.zeros(6), push(model)]
    file = write(tmp_path / "log.mcap", [("/joint_states", state(0.5 * i, names, np.array(POSTURE)[order], tau[i][order])) for i in range(2)])
    log = st.load_joint_states(file)
    assert log.joints == names and log.t.tolist() == [0, 0.5], "simulated time begins at 0"
    unstamped = [("/joint_states", state(0, names, np.array(POSTURE)[order], tau[i][order])) for i in range(2)]
    assert st.load_joint_states(write(file, unstamped)).t.tolist() == [1, 2], "no stamps: the times of the log"
    log = st.load_joint_states(write(file, [("/joint_states", state(1 + i, names, np.array(POSTURE)[order], tau[i][order], np.arange(6))) for i in range(2)]))
    assert log.t.tolist() == [1, 2] and np.array_equal(log.velocity[1], np.arange(6))
    assert np.allclose(log.tau[1], push(model)[order])
    assert any("efforts are taken for the external torques" in note for note in log.notes)
    log.save(tmp_path / "log.npz")
    scenario = {"scene": {"robots": [{"name": "arm", "urdf": UR5}]}, "sensing": {"friction": 0.5, "noise": 0.1}, "series": "log.npz"}
    loaded = st.load_sensing_scenario(scenario, base=tmp_path)
    assert np.allclose(loaded.q, POSTURE) and np.allclose(loaded.tau[1], push(model))
    still, touched = st.sense(loaded)
    assert still.verdict == st.Verdict.BelowThreshold and touched.verdict == st.Verdict.Explained
    assert "arm/forearm_link" in {c.link for c in touched.candidates}


def test_motion_that_was_exported_is_read_again(tmp_path: Path) -> None:
    (file,) = st.plan(st.load_task("planar_pushing"), seed=0).plan.export(tmp_path / "motion.mcap")
    log = st.load_joint_states(file)
    assert log.q.shape == log.tau.shape == (len(log.t), len(log.joints)) and len(log.t) > 10
    assert np.all(np.diff(log.t) > 0)


def test_messages_without_a_measurement_are_left_out_and_said(tmp_path: Path) -> None:
    nan = float("nan")
    messages = [
        state(1, ["a", "b"], [1, 2], [3, 4]),
        state(2, ["b", "a"], [2, 1], [4, nan]),
        state(3, ["finger"], [0], [0]),
        state(4, ["a", "b"], [1, 2], []),
        state(5, ["b", "a"], [20, 10], [40, 30]),
        state(5, ["a", "b"], [1, 2], [3, 4]),
        state(6, ["a", "a", "b"], [1, 2, 3], [3, 4, 5]),
    ]
    log = st.load_joint_states(write(tmp_path / "log.mcap", [("/joint_states", m) for m in messages]))
    assert log.joints == ["a", "b"] and log.t.tolist() == [1, 5]
    assert log.q.tolist() == [[1, 2], [10, 20]] and log.tau.tolist() == [[3, 4], [30, 40]]
    assert np.isnan(log.velocity).all()
    for why in ("lack a joint", "not finite", "a position and an effort", "not later", "name a joint twice"):
        assert any(f"1 of 7 messages" in note and why in note for note in log.notes), why
    assert st.load_joint_states(tmp_path / "log.mcap", joints=["b"]).q[:, 0].tolist() == [2, 2, 20], "another joint of the message may lack a number"


def test_topics_are_chosen_by_name(tmp_path: Path) -> None:
    file = write(tmp_path / "log.mcap", [("/left", state(1, ["a"], [1], [2])), ("/right", state(1, ["a"], [3], [4]))])
    with pytest.raises(st.InvalidInput, match=r"topic: got 2 topics of sensor_msgs/msg/JointState, expected one of '/left', '/right'"):
        st.load_joint_states(file)
    with pytest.raises(st.InvalidInput, match=r"got topic '/up', expected one of '/left', '/right'"):
        st.load_joint_states(file, topic="/up")
    assert st.load_joint_states(file, topic="/right").q.tolist() == [[3]]


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(st.InvalidInput, match=r"none\.mcap: got a file that cannot be read"):
        st.load_joint_states(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("t,q0\n")
    with pytest.raises(st.InvalidInput, match=r"text\.mcap: got .*, expected an MCAP file"):
        st.load_joint_states(tmp_path / "text.mcap")
    whole = write(tmp_path / "log.mcap", [("/joint_states", state(1, ["a"], [1], [2]))])
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-60])
    with pytest.raises(st.InvalidInput, match=r"cut\.mcap"):
        st.load_joint_states(cut)
    with pytest.raises(st.InvalidInput, match=r"joints: got 'c', expected one of 'a'"):
        st.load_joint_states(whole, joints=["c"])
    with pytest.raises(st.InvalidInput, match=r"joints: got \[\], expected names that differ"):
        st.load_joint_states(whole, joints=[])
    other = write(tmp_path / "other.mcap", [("/tf", {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}, "wrench": {}})], "geometry_msgs/WrenchStamped")
    with pytest.raises(st.InvalidInput, match=r"got 0 topics .*, expected a topic of sensor_msgs/msg/JointState"):
        st.load_joint_states(other)
    no_efforts = write(tmp_path / "bare.mcap", [("/joint_states", state(1, ["a"], [1], []))])
    with pytest.raises(st.InvalidInput, match=r"a position and an effort for every name .* expected at least one message"):
        st.load_joint_states(no_efforts)
    with pytest.raises(st.InvalidInput, match=r"expected a name that ends in \.npz"):
        st.load_joint_states(whole).save(tmp_path / "log.csv")


def test_series_that_is_an_mcap_file_says_what_to_do(tmp_path: Path) -> None:
    scenario = {"scene": {"robots": [{"name": "arm", "urdf": UR5}]}, "sensing": {"friction": 0.5}, "series": "log.mcap"}
    with pytest.raises(st.InvalidInput, match=r"got an MCAP file, expected CSV or NPZ; stiction\.load_joint_states\('log\.mcap'\)"):
        st.load_sensing_scenario(scenario, base=tmp_path)


def test_without_the_packages_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = write(tmp_path / "log.mcap", [("/joint_states", state(1, ["a"], [1], [2]))])
    for module in ("mcap", "mcap.reader"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(st.MissingExtra, match=r"stiction\[mcap\]"):
        st.load_joint_states(file)
