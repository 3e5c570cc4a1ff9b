"""Sensing from Python: known contacts are found, what is at given points, series, scenarios, threads, mistakes."""

from __future__ import annotations

import json
import math
import re
import sys
import threading
from pathlib import Path

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

UR5 = {"robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}]}
POSTURE = np.array([0.3, -1.2, 1.6, -1.97, -1.57, 0.4])
TUTORIAL = ROOT / "docs" / "tutorials" / "where_was_my_robot_touched.md"
WRIST = "arm/wrist_2_link"  # five joints before it: point and force are unique


@pytest.fixture(scope="module")
def sensor() -> st.Sensor:
    return st.Sensor(st.load_model(UR5), samples=300)


def link_of(sensor: st.Sensor, name: str) -> st.SensedLink:
    return next(link for link in sensor.links if link.name == name)


def push(sensor: st.Sensor, name: str, sample: int, newton: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A push along the inward normal at a sample: p_L, f_L, torques."""
    link = link_of(sensor, name)
    p_L, f_L = link.p_L[sample], -newton * link.n_L[sample]
    return p_L, f_L, st.calc_contact_torque(sensor.model, POSTURE, name, p_L, f_L)


# ---- values


def test_torque_of_a_force_is_its_moment_about_the_joint_axes(sensor: st.Sensor) -> None:
    p_L, f_L, tau = push(sensor, WRIST, 7, 20)
    kinematics = sensor.model.calc_kinematics(POSTURE)
    X_WL = sensor.model.body_poses(POSTURE)[WRIST]
    p_W, f_W = X_WL.R @ p_L + X_WL.p, X_WL.R @ f_L
    moments = [kinematics.axis_W[:, j] @ np.cross(p_W - kinematics.origin_W[:, j], f_W) for j in range(5)]
    assert np.abs(moments).max() > 0.1
    assert np.allclose(tau, [*moments, 0.0], atol=1e-12)


def test_samples_lie_on_the_link_with_unit_normals(sensor: st.Sensor) -> None:
    assert [link.joints for link in sensor.links] == [1, 2, 3, 4, 5, 6, 6]
    for link in sensor.links:
        assert link.p_L.shape == link.n_L.shape == (300, 3)
        assert np.allclose(np.linalg.norm(link.n_L, axis=1), 1, atol=1e-12)
        assert link.spacing == pytest.approx(math.sqrt(link.area / 300))
        assert np.ptp(link.p_L, axis=0).max() <= link.size


@pytest.mark.parametrize("sample", [3, 100, 250])
def test_known_contact_is_found_with_its_force(sensor: st.Sensor, sample: int) -> None:
    p_L, f_L, tau = push(sensor, WRIST, sample, 20)
    result = sensor.sense(POSTURE, tau, friction=0.5, noise=0.01)
    assert result.verdict == st.Verdict.Explained
    assert result.calc_distance(WRIST, p_L) < link_of(sensor, WRIST).spacing
    assert result.calc_distance("arm/shoulder_link", [0, 0, 0]) > 0.1
    X_WL = {name: pose for name, pose in sensor.model.body_poses(POSTURE).items()}
    for candidate in result.candidates:
        pose = X_WL[candidate.link]
        assert np.allclose(candidate.p_W, pose.R @ candidate.p_L + pose.p, atol=1e-12)
        assert np.allclose(candidate.f_W, pose.R @ candidate.f_L, atol=1e-9)
        made = st.calc_contact_torque(sensor.model, POSTURE, candidate.link, candidate.p_L, candidate.f_L)
        assert np.sum((made - tau) ** 2) == pytest.approx(candidate.residual, rel=1e-6, abs=1e-12)
        assert candidate.explains == (candidate.residual <= result.explained)
        # Inside the pyramid of (4.2), and so inside the cone.
        normal = -candidate.n_L @ candidate.f_L
        assert np.linalg.norm(candidate.f_L + normal * candidate.n_L) <= 0.5 * normal + 1e-9
        assert candidate.points.shape == (len(candidate.residuals), 3) and np.array_equal(candidate.points[0], candidate.p_L)
        assert np.all(np.diff(candidate.residuals) >= 0)


def test_residuals_at_points_vanish_where_the_contact_is_and_are_those_of_any_force_at_most(sensor: st.Sensor) -> None:
    link = link_of(sensor, WRIST)
    _, _, tau = push(sensor, WRIST, 40, 20)
    residuals = sensor.calc_residuals(POSTURE, tau, WRIST, link.p_L, 3 * link.n_L, friction=0.5)
    assert residuals.shape == (300,) and residuals[40] <= 1e-12 * (tau @ tau) and np.median(residuals) > 1e-3
    assert np.all(residuals <= tau @ tau * (1 + 1e-12))  # that of no force
    for i in (0, 150, 299):
        for newton in (1, 10, 30):
            made = st.calc_contact_torque(sensor.model, POSTURE, WRIST, link.p_L[i], -newton * link.n_L[i])
            assert residuals[i] <= np.sum((made - tau) ** 2) + 1e-12
    assert np.allclose(sensor.calc_residuals(POSTURE, tau, WRIST, link.p_L, link.n_L, friction=0.5), residuals, atol=1e-12)
    narrow = sensor.calc_residuals(POSTURE, tau, WRIST, link.p_L, link.n_L, friction=0)
    assert np.all(narrow >= residuals - 1e-9)


def test_weak_torques_are_below_the_threshold_and_impossible_ones_unexplained(sensor: st.Sensor) -> None:
    quiet = sensor.sense(POSTURE, np.full(6, 0.01))
    assert quiet.verdict == st.Verdict.BelowThreshold and quiet.candidates == []
    # A moment about the last joint alone: a single push would turn others as well.
    assert sensor.sense(POSTURE, [0, 0, 0, 0, 0, 50], noise=0.01).verdict == st.Verdict.Unexplained


def test_detectability_counts_directions_whose_torque_is_small(sensor: st.Sensor) -> None:
    link, epsilon, friction = link_of(sensor, WRIST), 0.01, 0.6
    found = sensor.calc_detectability(WRIST, friction=friction, epsilon=epsilon)
    assert len(found.kinds) == 300 and found.full == sum(kind == st.Detectability.Full for kind in found.kinds)
    eta = sensor.calc_undetectability(WRIST, link.p_L, link.n_L, friction=friction, epsilon=epsilon)
    assert np.allclose(eta, found.eta, atol=1e-12) and 0 < np.mean((eta > 0) & (eta < 1)) < 1
    # Against directions drawn in the cone: torque of the joint before the link, in its own axes.
    kinematics, X_WL = sensor.model.calc_kinematics(POSTURE), sensor.model.body_poses(POSTURE)[WRIST]
    axis, origin = X_WL.R.T @ kinematics.axis_W[:, 4], X_WL.R.T @ (kinematics.origin_W[:, 4] - X_WL.p)
    random = np.random.default_rng(0)
    for i in np.flatnonzero((eta > 0.1) & (eta < 0.9))[:5]:
        f = random.normal(size=(200_000, 3))
        f /= np.linalg.norm(f, axis=1)[:, None]
        f = f[-f @ link.n_L[i] >= 1 / math.hypot(1, friction)]
        share = np.mean(np.abs(f @ np.cross(axis, link.p_L[i] - origin)) <= epsilon)
        assert abs(share - eta[i]) < 4 * math.sqrt(0.25 / len(f))  # four standard deviations


@pytest.mark.parametrize(("name", "sample", "sideways"), [(WRIST, 200, 0.5), (WRIST, 100, 1.0), ("arm/forearm_link", 100, 0.5), ("arm/wrist_1_link", 3, 0.5)])
def test_motion_pulls_from_some_candidates_and_pushes_into_others(sensor: st.Sensor, name: str, sample: int, sideways: float) -> None:
    joint_step, travel = 0.04, 0.002  # [rad], [m]
    result = sensor.sense(POSTURE, push(sensor, name, sample, 25)[2], friction=0.5, noise=0.05)
    found = result.discriminate(POSTURE, joint_step=joint_step, travel=travel, sideways=sideways)
    explaining = [c for c in result.candidates if c.explains]
    assert found.status == st.Status.Solved and set(found.pull) == {0, 1} and len(found.pull) == len(explaining) >= 2
    assert np.abs(found.dq).max() <= joint_step * (1 + 1e-6)
    for candidate, pull in zip(explaining, found.pull):  # the point moves by J dq, and rows of J are torques of unit forces
        R_WL = sensor.model.body_poses(POSTURE)[candidate.link].R
        J = np.array([st.calc_contact_torque(sensor.model, POSTURE, candidate.link, candidate.p_L, R_WL.T @ axis) for axis in np.eye(3)])
        moved = J @ found.dq
        outward = candidate.n_W @ moved
        assert 0.1 - 1e-6 <= (-outward if pull else outward) / travel <= 1 + 1e-6
        assert np.abs(moved - outward * candidate.n_W).max() <= sideways * travel * (1 + 1e-6)


def test_motion_that_is_not_there_is_infeasible(sensor: st.Sensor) -> None:
    result = sensor.sense(POSTURE, push(sensor, WRIST, 100, 25)[2], friction=0.5, noise=0.05)
    assert result.discriminate(POSTURE, travel=0.002, sideways=0.5).status == st.Status.Infeasible


def solve_with_highs(sensor: st.Sensor, candidates: list, joint_step: float, travel: float, sideways: float, least: float = 0.1) -> float | None:
    """The objective (4.13a) by the branch and bound of HiGHS, in units of joint_step and travel; None: infeasible."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    count, joints = len(candidates), sensor.model.n_a
    rows, lower, upper = [], [], []

    def add(of_x: np.ndarray, of_b: np.ndarray, of_s: float, low: float, high: float) -> None:
        rows.append(np.concatenate([of_x, of_b, [of_s]]))
        lower.append(low)
        upper.append(high)

    for i, c in enumerate(candidates):
        R_WL = sensor.model.body_poses(POSTURE)[c.link].R
        J = joint_step / travel * np.array([st.calc_contact_torque(sensor.model, POSTURE, c.link, c.p_L, R_WL.T @ axis) for axis in np.eye(3)])
        pull = np.eye(count)[i]
        add(c.n_W @ J, (1 + least) * pull, 0, least, 1)  # least - (1 + least) b <= d <= 1 - (1 + least) b
        for row in J - np.outer(c.n_W, c.n_W @ J):
            add(row, 0 * pull, 0, -sideways, sideways)
    none, ones = np.zeros(joints), np.ones(count)
    add(none, ones, 0, 1, count - 1)
    add(none, -ones, 1, -(count // 2), np.inf)
    add(none, ones, 1, count // 2, np.inf)
    out = milp(
        np.r_[none, 0 * ones, 1],
        integrality=np.r_[none, ones, 0],
        bounds=Bounds(np.r_[none - 1, 0 * ones, 0], np.r_[none + 1, ones, count]),
        constraints=LinearConstraint(np.array(rows), lower, upper),
    )
    assert out.status in (0, 2), out.message
    return None if out.status == 2 else out.fun


def test_discrimination_is_as_good_as_that_of_highs(sensor: st.Sensor) -> None:
    joint_step, found = 0.04, []
    for sample in range(0, 300, 12):
        name = ("arm/wrist_1_link", WRIST, "arm/wrist_3_link")[sample % 3]
        result = sensor.sense(POSTURE, push(sensor, name, sample, 25)[2], friction=0.5, noise=0.05)
        candidates = result.candidates[:10]
        if len(candidates) < len(result.candidates) or len(candidates) < 2:
            continue
        for travel, sideways in ((0.002, 0.5), (0.004, 1.0), (0.004, 0.2)):
            ours = result.discriminate(POSTURE, all=True, joint_step=joint_step, travel=travel, sideways=sideways)
            theirs = solve_with_highs(sensor, candidates, joint_step, travel, sideways)
            assert ours.status == (st.Status.Infeasible if theirs is None else st.Status.Solved)
            if theirs is not None:
                assert ours.objective == round(theirs)
            found.append(theirs)
    assert sum(f is None for f in found) >= 3 and sum(f is not None for f in found) >= 10, found


# ---- series and scenarios


def test_series_is_one_measurement_after_the_other(sensor: st.Sensor) -> None:
    tau = np.vstack([np.zeros(6), push(sensor, WRIST, 3, 10)[2], push(sensor, WRIST, 3, 12)[2]])
    q = np.tile(POSTURE, (3, 1))
    results = sensor.sense_series(q, tau, friction=0.5)
    assert [r.verdict for r in results] == [st.Verdict.BelowThreshold, st.Verdict.Explained, st.Verdict.Explained]
    last = None
    for k, result in enumerate(results):
        last = sensor.sense(q[k], tau[k], last, friction=0.5)
        assert [c.residual for c in last.candidates] == [c.residual for c in result.candidates]


@pytest.mark.parametrize("method", [st.GaussNewton(), st.SteepestDescent(), st.RejectionSampling()], ids=repr)
def test_every_method_finds_the_link(sensor: st.Sensor, method: object) -> None:
    p_L, _, tau = push(sensor, WRIST, 3, 20)
    result = sensor.sense(POSTURE, tau, friction=0.5, noise=0.01, method=method)
    assert result.calc_distance(WRIST, p_L) < 2 * link_of(sensor, WRIST).spacing


def test_scenario_says_what_the_program_says(program: Path) -> None:
    done = children.run([program, "sense", "panda_wrist", "--json"], limit=120)
    (moment,) = json.loads(done.stdout)["moments"]
    (result,) = st.sense("panda_wrist")
    assert result.verdict.name == moment["verdict"]
    assert [c.residual for c in result.candidates] == [c["residual"] for c in moment["candidates"]]
    assert np.array_equal([c.p_W for c in result.candidates], [c["p_W"] for c in moment["candidates"]])
    scenario = st.load_sensing_scenario(ROOT / "scenarios" / "panda_wrist.yaml")
    assert scenario.q.shape == scenario.tau.shape == (1, scenario.sensor.model.n_a) and scenario.times[0] == 0
    assert st.sense(scenario)[0].calc_distance(scenario.contact.link, scenario.contact.p_L) == pytest.approx(moment["distance"], abs=1e-12)


def test_scenario_of_a_dict_is_that_of_its_file(tmp_path: Path) -> None:
    link = {"link": "arm/forearm_link", "point": [0.06, 0.02, 0.2], "force": 20}
    joints = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.6, "wrist_1_joint": -1.97, "wrist_2_joint": -1.57}
    scenario = st.load_sensing_scenario({"scene": UR5, "sensing": {"friction": 0.5, "noise": 0.1}, "joints": joints, "contact": link})
    (mine,), (built_in,) = st.sense(scenario), st.sense("ur5_forearm")
    assert [c.residual for c in mine.candidates] == [c.residual for c in built_in.candidates] and mine.candidates
    (tmp_path / "touch.csv").write_text((TUTORIAL.parent / "touch.csv").read_text())
    series = st.load_sensing_scenario({"scene": UR5, "series": "touch.csv"}, base=tmp_path)
    assert series.notes == [] and series.q.shape == (10, 6) and np.array_equal(series.tau, st.load_sensing_scenario(TUTORIAL.parent / "touch.yaml").tau)
    for mistake, message in (({"sensng": {}}, "^sensng: got an unknown key"), ({"sensing": {"links": ["arm/x"]}}, "^sensing.links: got 'arm/x'"), ({"joints": [0] * 6}, "neither 'torques' nor 'contact'")):
        with pytest.raises(st.InvalidInput, match=message):
            st.load_sensing_scenario({"scene": UR5, **mistake})


def test_threads_share_a_sensor(sensor: st.Sensor) -> None:
    tau = [push(sensor, WRIST, k, 15)[2] for k in range(8)]
    expected = [[c.residual for c in sensor.sense(POSTURE, t).candidates] for t in tau]
    got: dict[int, list[float]] = {}

    def work(k: int) -> None:
        got[k] = [c.residual for c in sensor.sense(POSTURE, tau[k]).candidates]

    threads = [threading.Thread(target=work, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [got[k] for k in range(8)] == expected


def test_push_on_a_simulated_arm_is_found_from_its_torques() -> None:
    model = st.load_control_scenario("box_in_the_way").model
    plant = st.DrivenPlant(st.Plant(model, damping_ratio=0))
    start = np.array([0, 0.6, 0, -1.4, 0, 1.1, 0])
    plant.reset(start)
    sensor = st.Sensor(model, samples=200)
    link = next(link for link in sensor.links if link.joints >= 6)
    p_L, n_L = link.p_L[50], link.n_L[50]
    X_WL = model.body_poses(start)[link.name]
    plant.set_push(link.name, p_L, X_WL.R @ (-15 * n_L))
    assert plant.advance(start, 3.0) == st.Status.Solved
    assert plant.time == pytest.approx(3) and np.abs(plant.v).max() < 1e-3 and plant.forces == []
    # At rest the springs bear it: K (q_cmd - q) + tau = 0.
    assert np.allclose(model.stiffness * (start - plant.q) + plant.external, 0, atol=0.02)
    assert np.abs(plant.external).max() > 1
    result = sensor.sense(plant.q, plant.external, friction=0.5, noise=0.01)
    assert result.verdict == st.Verdict.Explained and result.calc_distance(link.name, p_L) < link.spacing
    plant.set_push(link.name, [0, 0, 0], [0, 0, 0])
    assert plant.advance(start, 3.0) == st.Status.Solved
    assert sensor.sense(plant.q, plant.external, noise=0.01).verdict == st.Verdict.BelowThreshold


# ---- mistakes


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"links": ["arm/nothing"]}, "^links: got 'arm/nothing', expected one of"),
        ({"links": ["arm/base_link"]}, "^links: got 'arm/base_link', which no joint moves"),
        ({"samples": 0}, "^samples: got 0"),
        ({"surface": st.SurfaceOptions(segments=2)}, "segments: got 2"),
    ],
)
def test_mistakes_of_a_sensor_are_named(sensor: st.Sensor, options: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        st.Sensor(sensor.model, **options)


@pytest.mark.parametrize(
    ("q", "tau", "options", "message"),
    [
        (POSTURE[:5], np.ones(6), {}, "^q: got 5 numbers, expected 6"),
        (POSTURE * math.nan, np.ones(6), {}, r"^q\[0\]: got nan, expected a finite number"),
        (POSTURE, np.ones(5), {}, "^tau: got 5 numbers, expected 6"),
        (POSTURE, [1, 2, math.inf, 0, 0, 0], {}, r"^tau\[2\]: got inf"),
        (POSTURE, np.ones(6), {"noise": 0}, "^noise: got 0, expected a finite number > 0"),
        (POSTURE, np.ones(6), {"friction": -1}, "friction"),
        (POSTURE, np.ones(6), {"rays": 2}, "rays"),
    ],
)
def test_mistakes_of_a_measurement_are_named(sensor: st.Sensor, q: object, tau: object, options: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        sensor.sense(q, tau, **options)


def test_other_mistakes_are_named(sensor: st.Sensor) -> None:
    other = st.Sensor(sensor.model, links=[WRIST], samples=10)
    with pytest.raises(st.InvalidInput, match="^last: got a result of another sensor"):
        sensor.sense(POSTURE, np.ones(6), other.sense(POSTURE, np.ones(6)))
    with pytest.raises(st.InvalidInput, match="^tau: got 2 moments, expected those of q, 3"):
        sensor.sense_series(np.zeros((3, 6)), np.zeros((2, 6)))
    with pytest.raises(st.InvalidInput, match=r"^q\[1\]"):
        sensor.sense_series(np.vstack([POSTURE, POSTURE * math.nan]), np.ones((2, 6)))
    with pytest.raises(st.InvalidInput, match="^link: got 'wrist', expected one of"):
        sensor.calc_residuals(POSTURE, np.ones(6), "wrist", np.zeros((1, 3)), np.ones((1, 3)))
    with pytest.raises(st.InvalidInput, match=r"^p_L: got shape \(1, 2\), expected \(points, 3\)"):
        sensor.calc_residuals(POSTURE, np.ones(6), WRIST, np.zeros((1, 2)), np.ones((1, 3)))
    with pytest.raises(st.InvalidInput, match=r"^n_L\[0\]: got 0"):
        sensor.calc_residuals(POSTURE, np.ones(6), WRIST, np.zeros((1, 3)), np.zeros((1, 3)))
    with pytest.raises(st.InvalidInput, match="^candidates: got none"):
        sensor.sense(POSTURE, np.zeros(6)).discriminate(POSTURE)
    with pytest.raises(st.InvalidInput, match="^least: got 2"):
        sensor.sense(POSTURE, push(sensor, WRIST, 3, 20)[2]).discriminate(POSTURE, least=2)
    with pytest.raises(st.InvalidInput, match="^epsilon: got 0"):
        sensor.calc_detectability(WRIST, epsilon=0)
    with pytest.raises(st.InvalidInput, match="^scenario: got 'ur5', expected a file ending in .yaml or one of .*ur5_forearm"):
        st.sense("ur5")
    with pytest.raises(st.InvalidInput, match="no.yaml"):
        st.sense(Path("no.yaml"))


# ---- example


def test_example_finds_the_contact_that_it_made() -> None:
    example = ROOT / "python" / "examples" / "where_was_my_robot_touched.py"
    done = children.run([sys.executable, example], env={"PYTHONPATH": str(MODULE)}, limit=120)
    assert done.returncode == 0, done.stderr
    assert "Explained" in done.stdout and float(re.search(r"contact is ([0-9.]+) cm", done.stdout)[1]) < 2


# ---- tutorial


def test_series_of_the_tutorial_is_that_of_the_contact_that_it_states(sensor: st.Sensor) -> None:
    said = re.search(r"A force of (\d+) N pushes on `(\S+)` at\s+\((\S+), (\S+), (\S+)\) m", TUTORIAL.read_text(encoding="utf-8"))
    newton, link = float(said[1]), said[2]
    p_L = np.array([float(said[k].replace("−", "-")) for k in (3, 4, 5)])
    scenario = st.load_sensing_scenario(TUTORIAL.parent / "touch.yaml")
    sensed = next(s for s in scenario.sensor.links if s.name == link)
    n_L = sensed.n_L[np.argmin(np.linalg.norm(sensed.p_L - p_L, axis=1))]
    for q, tau in zip(scenario.q[scenario.times >= 0.2], scenario.tau[scenario.times >= 0.2]):
        error = tau - st.calc_contact_torque(scenario.sensor.model, q, link, p_L, -newton * n_L)
        assert np.abs(error).max() < 5 * 0.05 < np.abs(tau).max()
    results = st.sense(scenario)
    assert [r.verdict.name for r in results[:3]] == ["BelowThreshold"] * 3
    assert all(r.candidates[0].link == link and r.calc_distance(link, p_L) < 0.02 for r in results[4:])


def test_python_of_the_tutorial_runs_in_the_repository() -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```", TUTORIAL.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    # The page reads touch.csv from the folder where its reader has saved it. The repository has it beside the page.
    done = children.run([sys.executable, "-c", code], env={"PYTHONPATH": str(MODULE)}, cwd=TUTORIAL.parent, limit=120)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 10 and "BelowThreshold" in lines[0] and "arm/wrist_2_link" in lines[-1]


# ---- several contacts


def test_two_contacts_and_a_wrench_at_the_base_are_found(sensor: st.Sensor) -> None:
    places = [("arm/upper_arm_link", 40), ("arm/wrist_3_link", 90)]  # four joints between them, and six numbers of the wrench
    pushes = [push(sensor, name, sample, 15) for name, sample in places]
    poses = sensor.model.body_poses(POSTURE)
    wrenches = [st.calc_base_wrench(poses[name].R @ p + poses[name].p, poses[name].R @ f) for (name, _), (p, f, _) in zip(places, pushes)]
    base = st.BaseWrench(sum(w.force_W for w in wrenches), sum(w.moment_W for w in wrenches), force_noise=0.01, moment_noise=0.001)
    out = sensor.sense_contacts(POSTURE, sum(tau for _, _, tau in pushes), base, max_contacts=3, friction=0.5, noise=0.001, tolerance=0.001)
    assert out.verdict == st.Verdict.Explained and out.count == 2
    found = [s for s in out.sets if [c.link for c in s.contacts] == [name for name, _ in places]]
    assert found and found[0].freedom == 0
    for contact, (p, f, _) in zip(found[0].contacts, pushes):
        assert np.linalg.norm(contact.p_L - p) < 0.01 and contact.is_unique
        assert np.linalg.norm(contact.f_L - f) < 1


def test_rest_sign_noise_and_unmeasured_joints_of_several_contacts(sensor: st.Sensor) -> None:
    tau = sum(push(sensor, name, sample, 15)[2] for name, sample in [("arm/upper_arm_link", 40), ("arm/wrist_3_link", 90)])
    options = {"max_contacts": 2, "friction": 0.5, "tolerance": 0.001}
    rest, noise = np.linspace(-0.4, 0.3, 6), np.array([0.002, 0.001, 0.001, 0.002, 0.001, 0.001])
    plain = sensor.sense_contacts(POSTURE, tau, noise=noise, **options)
    told = sensor.sense_contacts(POSTURE, rest - tau, noise=noise, rest=rest, sign=-1, **options)
    assert plain.verdict == told.verdict == st.Verdict.Explained and plain.count == 2
    for a, b in zip(plain.best[0].contacts, told.best[0].contacts, strict=True):
        assert a.link == b.link and np.linalg.norm(a.p_L - b.p_L) < 1e-3
    as_matrix = sensor.sense_contacts(POSTURE, tau, noise=np.diag(noise**2), **options)
    assert as_matrix.sets[0].residual == pytest.approx(plain.sets[0].residual, rel=1e-6, abs=1e-12)

    single = push(sensor, "arm/wrist_3_link", 90, 15)[2]
    broken = single * np.array([1, -1, 1, 1, 1, 1])
    options["max_contacts"] = 1
    assert sensor.sense_contacts(POSTURE, broken, noise=0.001, **options).verdict == st.Verdict.Unexplained
    assert sensor.sense_contacts(POSTURE, broken, noise=0.001, unmeasured=[1], **options).verdict == st.Verdict.Explained
    loud = np.array([0.001, 20, 0.001, 0.001, 0.001, 0.001])
    assert sensor.sense_contacts(POSTURE, broken, noise=loud, **options).verdict == st.Verdict.Explained


def test_deviation_of_several_contacts_is_of_the_noise_that_is_given(sensor: st.Sensor) -> None:
    tau = push(sensor, "arm/wrist_3_link", 90, 15)[2]
    options = {"max_contacts": 1, "friction": 0.5, "tolerance": 1e-6}
    one = sensor.sense_contacts(POSTURE, tau, noise=0.001, **options).best[0].contacts[0].deviation
    nearly = np.full(6, 0.001) * np.array([1, 1, 1, 1, 1, 1 + 1e-6])
    assert sensor.sense_contacts(POSTURE, tau, noise=nearly, **options).best[0].contacts[0].deviation == pytest.approx(one, rel=1e-3)


def test_mistakes_about_several_contacts_name_the_argument(sensor: st.Sensor) -> None:
    for arguments, message in (({"max_contacts": 0}, "max_contacts: got 0"), ({"rays": 0}, "rays: got 0"), ({"starts": 0}, "starts: got 0")):
        with pytest.raises(st.InvalidInput, match=re.escape(message)):
            sensor.sense_contacts(POSTURE, np.ones(6), **arguments)
    for arguments, message in (({"rest": np.ones(5)}, "rest"), ({"sign": 0}, "sign: got 0"), ({"noise": np.zeros(6)}, "noise[0]: got 0")):
        with pytest.raises(st.InvalidInput, match=re.escape(message)):
            sensor.sense_contacts(POSTURE, np.ones(6), **arguments)
    with pytest.raises(st.InvalidInput, match=r"base_wrench\.force_noise: got -1"):
        st.BaseWrench(np.zeros(3), np.zeros(3), force_noise=-1)


def test_noise_of_one_joint_is_a_covariance_or_a_deviation_as_it_is_given() -> None:
    """Both have one number, as an array of one dimension or of two."""
    link = "<link name='l'><inertial><mass value='1'/><inertia ixx='.02' iyy='.03' izz='.025' ixy='0' ixz='0' iyz='0'/></inertial><collision><origin xyz='.15 0 0'/><geometry><box size='.3 .06 .05'/></geometry></collision></link>"
    joint = "<joint name='j' type='revolute'><parent link='b'/><child link='l'/><axis xyz='0 0 1'/><limit lower='-2' upper='2' effort='50' velocity='3'/></joint>"
    robot = {"name": "r", "urdf": f"<robot name='r'><link name='b'/>{link}{joint}</robot>"}
    sensor = st.Sensor(st.load_model({"robots": [robot]}), samples=100)
    random = np.random.default_rng(0)
    rest = st.calibrate(sensor.model, np.zeros((50, 1)), random.normal(0, 0.05, (50, 1)))
    by_covariance = sensor.sense([0.0], [0.12], noise=rest.noise)
    assert by_covariance.threshold == pytest.approx(4 * np.sqrt(rest.noise[0, 0])) and by_covariance.verdict == st.Verdict.BelowThreshold
    assert sensor.sense([0.0], [0.12], noise=np.sqrt(rest.noise[0])).threshold == pytest.approx(by_covariance.threshold)
    keys = {"scene": {"robots": [robot]}, "joints": [0], "torques": [0.12]}
    for noise in ([[0.0025]], [0.05]):
        (result,) = st.sense(st.load_sensing_scenario(keys | {"sensing": {"noise": noise}}))
        assert result.threshold == pytest.approx(0.2)
    onset = st.TouchOnset(rest.rest, rest.within)
    assert not any(onset.update(random.normal(0, 0.05, 1), 0.01) for _ in range(300))
    assert st.TouchOnset(rest.rest, np.sqrt(rest.within[0])).noise == pytest.approx(st.TouchOnset(rest.rest, rest.within).noise)
