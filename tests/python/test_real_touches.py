"""Torques of a real arm: rest, noise of each joint, sign, joints without a sensor, probabilities. Rows: docs/tutorials/franka_touches.csv."""

from __future__ import annotations

import csv
import json
import pickle
import sys
from pathlib import Path

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path[:0] = [str(MODULE), str(ROOT / "bench")]

import real_touches  # noqa: E402

import stiction as st  # noqa: E402

FINGER = real_touches.FINGER


@pytest.fixture(scope="module")
def logs() -> dict:
    return real_touches.load_logs()


@pytest.fixture(scope="module")
def sensor() -> st.Sensor:
    model, links = real_touches.load_arm("panda")
    return st.Sensor(model, links=links)


def test_table_has_its_licence_and_26_touches(logs: dict) -> None:
    notice = (real_touches.DATA.parent / "franka_touches.license.txt").read_text()
    assert "MIT License" in notice and "(c) 2024 Maryam Rezayati" in notice
    assert sum(bool(log["touched"]) for log in logs.values()) == 26 and len(logs) == 28
    assert sum(len(log["rest"]) + len(log["touched"]) for log in logs.values()) == 96


def test_real_touches_are_on_the_links_that_were_touched(sensor: st.Sensor, logs: dict) -> None:
    own = real_touches.judge_logs(sensor, logs, "own")
    assert own["logs"] == 26 and own["below_threshold"] == 0 and own["first"] >= 19 and own["best_two"] >= 24 and own["in_set"] >= 25 and own["set_links"] <= 1.7
    none = real_touches.judge_logs(sensor, logs, "none")
    assert none["first"] < own["first"] and none["in_set"] < own["in_set"]  # the rest is what helps


def test_rest_right_after_a_push_is_no_touch(sensor: st.Sensor, logs: dict) -> None:
    """Noise, what touches leave, and how well both are known, from the other logs."""
    unknown = real_touches.count_false_alarms(sensor, logs, knows_touches=False)
    assert unknown["rows"] == 17 and unknown["alarms"] > 0  # else there is nothing to learn
    known = real_touches.count_false_alarms(sensor, logs, knows_touches=True)
    assert known["alarms"] == 0 and known["nearest_to_threshold"] < 0.9
    assert 0.005 < known["share"][0] <= known["share"][1] < 0.06


def test_noise_of_few_rows_raises_the_threshold(sensor: st.Sensor, logs: dict) -> None:
    calibration = real_touches.calibrate_without(sensor.model, logs, None)
    assert calibration.hysteresis.settle == 1 and calibration.hysteresis.freedom > 4 and 3 < calibration.freedom < 17
    touch = np.array([0, 0, 0, 0, 2.0, 0, 0, 0])
    after, before = calibration.calc_noise(touch=touch, seconds=0.2), calibration.calc_noise()
    assert np.allclose(before.covariance[:7, :7], 2 * calibration.within[:7, :7]) and np.all(before.freedom == calibration.freedom)
    assert after.covariance[4, 4] > 2 * before.covariance[4, 4] and after.covariance[3, 3] == before.covariance[3, 3]
    assert np.array_equal(calibration.calc_noise(touch=touch, seconds=1.0).covariance, before.covariance)
    q, tau = np.full(8, 0.02), np.array([0, 0, 0, 0, 0.1, 0, 0, 0])
    options = {"noise": after.covariance, "unmeasured": [FINGER]}
    sure, unsure = sensor.sense(q, tau, **options), sensor.sense(q, tau, freedom=after.freedom, **options)
    assert sure.threshold == pytest.approx(4 * np.sqrt(after.covariance[4, 4])) and unsure.threshold > 1.1 * sure.threshold
    assert sensor.sense(q, tau, freedom=1e9, **options).threshold == pytest.approx(sure.threshold)
    again = pickle.loads(pickle.dumps(calibration))
    assert again.hysteresis.share == calibration.hysteresis.share > 0
    with pytest.raises(st.InvalidInput, match="^freedom: got 0"):
        sensor.sense(q, tau, freedom=0, **options)


def test_noise_of_joints_and_rest_change_what_is_said(sensor: st.Sensor, logs: dict) -> None:
    log = logs["link5/c9_6.csv"]
    rest = log["rest"][-1][2]
    _, q, tau = log["touched"][0]
    options = {"sign": -1, "unmeasured": [FINGER], "posterior": True}
    calibration = real_touches.calibrate_without(sensor.model, logs, "link5/c9_6.csv")
    assert calibration.records == 27 and calibration.postures == 6 and calibration.noise_between.shape == (8, 8)
    assert calibration.deviation[6] < 0.1 * calibration.deviation[0]  # the last joint is far more quiet
    result = sensor.sense(q, tau, rest=rest, noise=calibration.noise, **options)
    posterior = result.posterior
    assert next(iter(posterior.links)) == "robot/panda_link5" == posterior.credible[0] == result.candidates[0].link
    assert posterior.nothing + sum(posterior.links.values()) == pytest.approx(1)
    assert posterior.points("robot/panda_link5").shape[1] == 3
    assert posterior.probabilities("robot/panda_link5").sum() == pytest.approx(posterior.links["robot/panda_link5"], rel=1e-6)
    again = pickle.loads(pickle.dumps(result))
    assert again.posterior.links == posterior.links
    # Numbers of each joint, a covariance and one number are the same where they say the same.
    one = sensor.sense(q, tau, rest=rest, noise=0.1, **options)
    many = sensor.sense(q, tau, rest=rest, noise=np.full(8, 0.1), **options)
    matrix = sensor.sense(q, tau, rest=rest, noise=0.01 * np.eye(8), **options)
    for other in (many, matrix):
        assert [c.link for c in other.candidates] == [c.link for c in one.candidates]
        assert other.noise == pytest.approx(0.1)
    # Turned by hand and less its rest the same torques say the same.
    by_hand = sensor.sense(q, rest - tau, noise=0.1, unmeasured=[FINGER], posterior=True)
    assert by_hand.posterior.links == one.posterior.links
    quiet = sensor.sense(q, rest, rest=rest, noise=0.1, **options)
    assert quiet.verdict == st.Verdict.BelowThreshold and quiet.largest == 0 and quiet.threshold == pytest.approx(0.4)
    assert quiet.posterior.nothing > 0.5 and sensor.sense(q, rest, rest=rest).posterior is None


def test_unmeasured_joint_is_unknown_and_not_zero(sensor: st.Sensor) -> None:
    """A push of a finger along its slide moves the finger alone; without its sensor nothing says so."""
    q = np.array([0, 0.3, 0, -2, 0, 2.2, 0.7, 0.02])
    hand = next(link for link in sensor.links if link.name.endswith("hand"))
    tau = st.calc_contact_torque(sensor.model, q, hand.name, hand.p_L[10], -20 * hand.n_L[10])
    known = sensor.sense(q, tau, noise=0.05, unmeasured=[7])
    tau[7] = 1e3
    other = sensor.sense(q, tau, noise=0.05, unmeasured=["robot/panda_finger_joint1"])
    assert [c.p_L.tolist() for c in known.candidates] == [c.p_L.tolist() for c in other.candidates]
    assert known.verdict == st.Verdict.Explained


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"noise": [0.1] * 7}, r"^noise: got shape \(7, 1\), expected one number, 8 standard deviations"),
        ({"noise": [0.1] * 7 + [0.0]}, r"^noise\[7\]: got 0"),
        ({"noise": np.ones((8, 8))}, "^noise: got a covariance whose correlations"),
        ({"noise": 0}, "^noise: got 0"),
        ({"sign": 0}, "^sign: got 0, expected 1 or -1"),
        ({"rest": [0.0] * 3}, "^rest: got 3 numbers"),
        ({"unmeasured": list(range(8))}, "^unmeasured: got all joints"),
        ({"unmeasured": ["panda_joint9"]}, "panda_joint9"),
        ({"touch_prior": 1.0}, "^touch_prior: got 1"),
    ],
)
def test_options_that_cannot_be_meant_are_refused(sensor: st.Sensor, options: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        sensor.sense(np.zeros(8) + 0.02, np.zeros(8), **options)


def scenario(folder: Path, **sensing: object) -> Path:
    """One log as a scenario."""
    lines = [line for line in real_touches.DATA.read_text().splitlines() if not line.startswith("#")]
    rows = sorted((row for row in csv.DictReader(lines) if row["file"] == "link5/c9_6.csv"), key=lambda row: float(row["t"]))
    names = ["t", *(f"q{j}" for j in range(7)), *(f"tau_ext{j}" for j in range(7))]
    (folder / "log.csv").write_text("\n".join([",".join(names), *(",".join(row[name] for name in names) for row in rows)]) + "\n")
    text = {
        "scene": {"robots": [{"name": "robot", "urdf": real_touches.PANDA}]},
        "sensing": {"links": ["robot/panda_link*"], "sign": -1, "unmeasured": [FINGER]} | sensing,
        "series": "log.csv",
    }
    file = folder / "log.yaml"
    file.write_text(json.dumps(text))
    return file


def test_scenario_takes_rest_and_noise_from_its_record(tmp_path: Path) -> None:
    noise = [0.08, 0.05, 0.06, 0.07, 0.009, 0.007, 0.004, 1]
    loaded = st.load_sensing_scenario(scenario(tmp_path, noise=noise, rest={"seconds": [7.1, 7.3]}))
    results = st.sense(tmp_path / "log.yaml")
    assert [r.verdict.name for r in results] == ["BelowThreshold", "BelowThreshold", "Explained", "Explained", "BelowThreshold"]
    assert results[2].candidates[0].link == "robot/panda_link5"
    assert any("panda_link0: no joint moves it" in note for note in loaded.sensor.notes)
    by_rows = st.sense(scenario(tmp_path, noise=noise, rest={"rows": [0, 1]}))
    assert by_rows[2].posterior.links == results[2].posterior.links
    assert st.load_sensing_scenario(scenario(tmp_path, noise="rest", rest={"rows": [0, 1]})).notes[-1].startswith("noise is known from 1 differences only")


@pytest.mark.parametrize(
    ("sensing", "message"),
    [
        ({"rest": {"seconds": [1, 2]}}, r"rest.seconds: got \[1, 2\], which no moment is in, expected seconds between 7.19"),
        ({"rest": {"rows": [0, 0]}, "noise": "rest"}, "one row alone gives a rest, and says nothing of noise"),
        ({"noise": "rest"}, "noise: got 'rest' without rows of rest"),
        ({"noise": [1, 2]}, "sensing.noise"),
        ({"sign": 2}, "sensing.sign"),
        ({"unmeasured": ["finger"]}, "finger"),
        ({"unmeasured": []}, "a joint without a torque sensor is named in sensing.unmeasured"),
    ],
)
def test_scenarios_that_cannot_be_meant_are_refused_where_they_stand(tmp_path: Path, sensing: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        st.load_sensing_scenario(scenario(tmp_path, **sensing))


def test_sign_of_total_torques_follows_from_gravity() -> None:
    model, _ = real_touches.load_arm("panda")
    q = np.array([[0.3, 0.5, 0.1, -1.5, 0.2, 2.0, 0.7, 0.02], [0.1, 0.9, 0.4, -1.2, 0.2, 1.5, 0.2, 0.02]])
    tau = np.array([st.calc_holding_torques(model, row) for row in q])
    assert np.abs(tau).max() > 10
    assert st.check_sign(model, q, tau).sign == 1 and st.check_sign(model, q, -tau).sign == -1
    assert st.check_sign(model, q, 0.01 * tau).sign == 0


def test_momentum_observer_and_friction(sensor: st.Sensor) -> None:
    """Torques of a slow motion with gravity and friction alone, then a push."""
    model = sensor.model
    t = np.arange(0, 6, 0.005)
    phase = np.arange(8)
    amplitude = np.where(phase < 7, 0.3, 0.01)
    centre = np.array([0, 0.3, 0, -1.8, 0, 2.0, 0.5, 0.02])
    q = centre + amplitude * np.sin(2 * t[:, None] + phase)
    qd = 2 * amplitude * np.cos(2 * t[:, None] + phase)
    frictionless = st.observe(model, t, q, qd, np.zeros_like(q))  # all that moves it is external
    friction_torque = 0.6 * np.tanh(qd / 0.001) + 0.3 * qd
    # Motors that do exactly this much, and overcome friction: nothing is left over.
    shift, start = 4, 100  # steps that the observer is behind; until it has forgotten its start
    motor = frictionless[start + shift :] + friction_torque[start:-shift]
    t, q, qd = t[start:-shift], q[start:-shift], qd[start:-shift]
    friction = st.identify_friction(model, t, q, qd, motor, stiction_speed=0.001)
    assert np.allclose(friction.coulomb[:7], 0.6, atol=0.1) and np.allclose(friction.viscous[:7], 0.3, atol=0.2)
    left, raw = st.observe(model, t, q, qd, motor, friction=friction), st.observe(model, t, q, qd, motor)
    assert np.sqrt(np.mean(left[start:, :7] ** 2)) < 0.2 * np.sqrt(np.mean(raw[start:, :7] ** 2))
    with pytest.raises(st.InvalidInput, match="times that increase"):
        st.observe(model, t[::-1], q, qd, motor)


def test_touch_that_lasts_is_one_measurement() -> None:
    random = np.random.default_rng(0)
    deviation = np.array([0.06, 0.05, 0.04, 0.06, 0.007, 0.007, 0.002])
    onset = st.TouchOnset(np.zeros(7), deviation, drift=0.01 * deviation)
    touch = np.array([0, 0.4, 0, 0, 0, 0, 0.0])
    said = [onset.update(touch * (i >= 200) + deviation * random.normal(size=7), 0.005) for i in range(260)]
    assert not any(said[:200]) and all(said[210:]) and onset.touches and onset.sum > onset.bound
    assert 55 <= onset.rows <= 65 and abs(onset.mean[1] - onset.rest[1] - 0.4) < 0.05
    assert onset.noise[1, 1] < 0.1 * deviation[1] ** 2
    with pytest.raises(st.InvalidInput, match=r"^noise\[1\]: got 0"):
        st.TouchOnset(np.zeros(2), [1, 0])
    with pytest.raises(st.InvalidInput, match="^tau: got 3 numbers"):
        onset.update(np.zeros(3), 0.005)


def test_command_line_takes_rest_noise_and_sign(program: Path, tmp_path: Path) -> None:
    file = scenario(tmp_path, sign=1)

    def sense(*options: str) -> dict:
        done = children.run([program, "sense", file, *options, "--json"], limit=60)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["moments"]

    raw = sense("--turn")
    assert raw[0]["verdict"] != "BelowThreshold"  # the offset looks like a touch
    moments = sense("--turn", "--rest", "7.1", "7.3", "--noise", "0.1")
    assert [m["verdict"] for m in moments] == ["BelowThreshold", "BelowThreshold", "Explained", "Explained", "BelowThreshold"]
    assert moments[0]["largest"]["torque"] < moments[0]["largest"]["threshold"] == pytest.approx(0.4)
    posterior = moments[2]["posterior"]
    assert posterior["nothing"] + sum(posterior["links"].values()) == pytest.approx(1) and "robot/panda_link5" in posterior["credible"]
    assert sum(c["probability"] for c in moments[2]["candidates"]) <= 1 + 1e-9
    text = children.run([program, "sense", file, "--turn", "--rest", "7.1", "7.3", "--noise", "0.1"], limit=60).stdout
    assert "which shows a contact from 0.4 N·m on" in text and "probably: nothing" in text
    wrong = children.run([program, "sense", file, "--rest", "1", "2"], limit=60)
    assert wrong.returncode == 2 and "--rest: got 1 2, expected seconds of the record, which has 7.19" in wrong.stderr
    twice = children.run([program, "sense", scenario(tmp_path, sign=-1), "--turn"], limit=60)
    assert "--turn reverses sensing.sign: -1 of the scenario" in twice.stderr


def test_random_tables_say_the_same_of_the_same_joints(tmp_path: Path) -> None:
    """Columns in any order, columns of other things, lines without a number: never another joint, never a crash."""
    scenario(tmp_path)
    model, _ = real_touches.load_arm("panda")
    head, *lines = (tmp_path / "log.csv").read_text().splitlines()
    names = head.split(",")
    table = np.array([[float(x) for x in line.split(",")] for line in lines])
    joints = [f"panda_joint{j + 1}" for j in range(7)]
    random = np.random.default_rng(0)
    base = {"scene": {"robots": [{"name": "robot", "urdf": real_touches.PANDA}]}, "sensing": {"links": ["robot/panda_link7"], "unmeasured": [FINGER], "samples": 1}}
    for _ in range(60):
        style = random.integers(3)
        columns = [names, ["t", *(f"q_{j}" for j in joints), *(f"tau_{j}" for j in joints)], ["time", *(f"/arm/{j}/position" for j in joints), *(f"/arm/{j}/effort" for j in joints)]][style]
        order = random.permutation(15)
        extra = random.integers(3)
        rows = [[f"{x:.7f}" for x in row[order]] + ["x"] * extra for row in table]
        broken = set(random.choice(len(rows), random.integers(len(rows)), replace=False).tolist())
        for i in broken:
            rows[i][random.integers(15)] = random.choice(["nan", "", "NaN"])
        text = [",".join([*(columns[k] for k in order), *(f"other{k}" for k in range(extra))]), *map(",".join, rows)]
        (tmp_path / "log.csv").write_text("\n".join(text) + "\n")
        loaded = st.load_sensing_scenario(base | {"series": "log.csv"}, base=tmp_path)
        kept = [i for i in range(len(rows)) if i not in broken]
        assert np.allclose(loaded.times, table[kept, 0]) and np.allclose(loaded.q[:, :7], table[kept, 1:8]) and np.allclose(loaded.tau[:, :7], table[kept, 8:])
        assert any("lack a number" in note for note in loaded.notes) == bool(broken)


def test_moments_of_one_touch_are_put_together(sensor: st.Sensor, logs: dict) -> None:
    log = logs["link5/c10_8.csv"]
    rest = log["rest"][-1][2]
    q, tau = (np.array([row[k] for row in log["touched"]]) for k in (1, 2))
    options = {"rest": rest, "noise": 0.1, "sign": -1, "unmeasured": [FINGER]}
    both, one = sensor.sense_touch(q, tau, **options), sensor.sense_touch(q[1:], tau[1:], **options)
    assert one.posterior.links == sensor.sense(q[1], tau[1], posterior=True, **options).posterior.links
    assert both.candidates[0].link == next(iter(both.posterior.links)) and both.posterior.nothing < 1e-6
    assert both.posterior.links != one.posterior.links
    with pytest.raises(st.InvalidInput, match="^correlation: got 2"):
        sensor.sense_touch(q, tau, correlation=2.0, **options)
    with pytest.raises(st.InvalidInput, match="^tau: got 1 moments, and 2 of q"):
        sensor.sense_touch(q, tau[:1], **options)
