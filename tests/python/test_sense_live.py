"""The live page of `stiction sense`: moments in time, clicks that push, what is said and drawn."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import children
import numpy as np
import pytest
from studio_window import ADDRESS

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402

from stiction_view.studio.sense_live import HIGH, POKE, Live, find_sample  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402

TUTORIAL = ROOT / "docs" / "tutorials" / "touch.yaml"


@pytest.fixture()
def live() -> Iterator[Live]:
    with serving("127.0.0.1", 0) as server:
        yield Live(server, st.load_sensing_scenario(TUTORIAL))


def test_a_ray_means_the_first_sample_that_faces_it() -> None:
    front, back = np.array([[0.0, 0, 1], [0.3, 0, 1]]), np.array([[0.0, 0, 0.5], [0, 0, 2]])
    up, down = np.tile([0.0, 0, 1], (2, 1)), np.tile([0.0, 0, -1], (2, 1))
    samples = [("a", front, up, 0.02), ("b", back, up, 0.02), ("c", np.array([[0.0, 0, 3], [0, 0, 3]]), down, 0.02)]
    origin, towards = np.array([0.01, 0, 5]), np.array([0.0, 0, -1])
    assert find_sample(origin, towards, samples) == (1, 1), "of two points under the click the upper one; that above them looks away"
    assert find_sample(np.array([0.1, 0, 5]), towards, samples) is None
    assert find_sample(origin, -towards, samples) is None


def test_arm_is_drawn_as_its_file_shows_it_and_samples_lie_on_that(live: Live) -> None:
    drawing = live.drawing
    assert drawing.seen and all(node.visible for node in drawing.seen) and not any(node.visible for node in drawing.touched)
    lifts = []
    for link in live.sensor.links:
        lift = np.einsum("ij,ij->i", np.array(live.clouds[link.name].points) - link.p_L, link.n_L) / link.spacing
        assert lift.min() > 0.1 - 1e-3 and lift.max() < 1.1 + 1e-3
        lifts.append(lift)
    assert np.concatenate(lifts).max() > 0.2, "the file shows more than touches somewhere"
    live.touching.value = True
    live.tick(10.0)
    assert not any(node.visible for node in drawing.seen) and all(node.visible for node in drawing.touched)


def test_moments_pass_as_they_were_measured(live: Live) -> None:
    times = np.array(live.scenario.times)
    seen = []
    for now in np.arange(0, times[-1] - times[0] + 0.05, 0.01):
        live.tick(100 + now)
        if not seen or seen[-1] != live.moment:
            seen.append(live.moment)
    assert seen == list(range(len(times)))
    assert "a single contact explains the torques" in live.words.content and "wrist_2_link" in live.words.content
    live.tick(100 + times[-1] - times[0] + 1.5)
    assert live.moment == 0 and "below the threshold" in live.words.content and not live.arrows["explains"].visible


def test_what_is_drawn_is_what_the_library_says(live: Live) -> None:
    k = 5
    live.tick(10.0)
    live.tick(10.0 + live.scenario.times[k] - live.scenario.times[0] + 1e-6)
    assert live.moment == k
    q, tau = live.scenario.q[k], live.scenario.tau[k]
    explaining = [c for c in live.scenario.sense(q, tau).candidates if c.explains]
    assert explaining and live.arrows["explains"].visible
    heads = np.array(live.arrows["explains"].points)[:, 1]
    for c in explaining:
        assert np.linalg.norm(heads - c.p_W, axis=1).min() < 0.01, "from the candidates of the moment before, which moves an end in a valley a little"
    link = next(link for link in live.sensor.links if link.name == explaining[0].link)
    left = live.sensor.calc_residuals(q, tau, link.name, link.p_L, link.n_L, friction=0.5)
    colours = np.array(live.clouds[link.name].colors, dtype=float)
    darkest = np.argmin(left)
    assert np.linalg.norm(colours[darkest] - HIGH) > 0.9 * np.linalg.norm(colours - HIGH, axis=1).max()


def test_a_click_pushes_the_robot_and_the_push_is_found(live: Live) -> None:
    live.tick(0.0)
    X = live.model.body_poses(live.configuration(0))
    link = next(link for link in live.sensor.links if link.name == "arm/wrist_2_link")
    p_W, n_W = link.p_L[40] @ X[link.name].R.T + X[link.name].p, X[link.name].R @ link.n_L[40]
    live.events.put(lambda: live.poke(p_W + 0.01 * n_W, -n_W))
    live.tick(0.1)
    (push,) = live.pushes
    assert push.link == link.name
    assert "pushed at arm/wrist_2_link" in live.words.content and live.arrows["truth"].visible
    explaining = [c for c in live.last.candidates if c.explains]
    assert any(c.link == link.name and np.linalg.norm(c.p_L - push.p_L) < 0.02 for c in explaining)
    live.push_until = 0.2
    live.tick(0.2 + POKE)
    assert not live.pushes and live.moment == 0, "and the series goes on from its start"
    live.poke(np.array([0.0, 0, 50.0]), np.array([0.0, 0, 1.0]))
    assert not live.pushes, "a click beside the robot is no push"


def reported(tau: np.ndarray, rest: np.ndarray, sign: int, **sensing: object) -> st.SensingScenario:
    """One moment of a UR5 whose controller reports external torques with a rest and a sign."""
    robot = {"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}
    keys = {"rest": rest.tolist(), "sign": sign, "samples": 500} | sensing
    return st.load_sensing_scenario({"scene": {"robots": [robot]}, "sensing": keys, "joints": [0.3, -1.2, 1.4, -0.6, 0.5, 0.2], "torques": (rest + sign * tau).tolist()})


def test_rest_and_sign_of_the_scenario_change_nothing_that_is_shown() -> None:
    tau, rest = np.array([1.0, -2.0, 1.5, 0.5, -0.3, 0.0]), np.array([0.4, -3.0, 2.0, 0.2, -0.1, 0.3])
    shown = []
    for scenario in (reported(tau, 0 * rest, 1), reported(tau, rest, -1)):
        assert scenario.sign * (scenario.tau[0] - scenario.rest) == pytest.approx(tau)
        with serving("127.0.0.1", 0) as server:
            live = Live(server, scenario)
            live.tick(0.0)
            colours = [np.array(live.clouds[link.name].colors, dtype=int) for link in live.sensor.links]
            X = live.model.body_poses(live.configuration(0))
            link = next(link for link in live.sensor.links if link.name == "arm/wrist_2_link")
            p_W, n_W = link.p_L[40] @ X[link.name].R.T + X[link.name].p, X[link.name].R @ link.n_L[40]
            live.poke(p_W + 0.01 * n_W, -n_W)
            assert any(c.link == link.name and np.linalg.norm(c.p_L - link.p_L[40]) < 0.03 for c in live.last.candidates if c.explains)
            shown.append((np.concatenate(colours), [(c.link, c.p_L, c.f_L) for c in live.last.candidates]))
    (colours, candidates), (other_colours, other_candidates) = shown
    assert np.abs(colours - other_colours).max() <= 1, "rounded differently"
    for (link, p_L, f_L), (other_link, other_p_L, other_f_L) in zip(candidates, other_candidates, strict=True):
        assert link == other_link and p_L == pytest.approx(other_p_L, abs=1e-6) and f_L == pytest.approx(other_f_L, abs=1e-4)


def test_noise_of_a_push_is_that_of_each_joint() -> None:
    deviations = np.array([0.3, 0.2, 0.1, 0.05, 0.02, 0.01])
    scenario = reported(np.zeros(6), np.zeros(6), 1, noise=deviations.tolist())
    assert scenario.noise == pytest.approx(np.diag(deviations**2)) and reported(np.zeros(6), np.zeros(6), 1, noise=0.2).noise == 0.2
    with serving("127.0.0.1", 0) as server:
        live = Live(server, scenario)
        drawn = np.std([live.draw_noise() for _ in range(2000)], axis=0)
    assert drawn == pytest.approx(deviations, rel=0.1), "2000 draws know a deviation to 1.6 %"


@pytest.fixture(scope="module")
def two_pushes() -> st.SensingScenario:
    return st.load_sensing_scenario("ur5_two_pushes")


def test_two_contacts_pass_as_they_were_measured(two_pushes: st.SensingScenario) -> None:
    with serving("127.0.0.1", 0) as server:
        live = Live(server, two_pushes)
        start, links = two_pushes.times[0], [set(), set()]
        live.tick(0.0)
        for now, k in zip(two_pushes.times, range(len(two_pushes.times)), strict=True):
            live.tick(now - start + 1e-6)
            assert live.moment == k
            if len(two_pushes.pushed[k]) == 2 and len(two_pushes.pushed[k - 4]) == 2:  # torques follow with the observer's lag
                assert live.last_sets.count == 2 and "2 contacts at the same time explain" in live.words.content
                known = [two_pushes.contacts[i].link for i in two_pushes.pushed[k]]
                assert known in [[c.link for c in one.contacts] for one in live.last_sets.best]
                assert len(live.arrows["truth"].points) == len(live.arrows["explains"].points) == 2
                links[0].update(known)
            elif len(two_pushes.pushed[k]) == 1 and len(two_pushes.pushed[max(k - 4, 0)]) == 1:
                links[1].add(live.last_sets.count)
        assert len(links[0]) == 2 and links[1] == {1}, "one push is one contact, before the second and after it"


def test_two_clicks_push_at_the_same_time(two_pushes: st.SensingScenario) -> None:
    with serving("127.0.0.1", 0) as server:
        live = Live(server, two_pushes)
        live.tick(0.0)
        X = live.model.body_poses(live.configuration(0))
        for name, sample in (("arm/upper_arm_link", 40), ("arm/wrist_3_link", 90)):
            link = next(link for link in live.sensor.links if link.name == name)
            p_W, n_W = link.p_L[sample] @ X[name].R.T + X[name].p, X[name].R @ link.n_L[sample]
            live.poke(p_W + 0.01 * n_W, -n_W)
        assert [push.link for push in live.pushes] == ["arm/upper_arm_link", "arm/wrist_3_link"]
        assert live.last_sets.count == 2 and "pushed at arm/upper_arm_link and arm/wrist_3_link" in live.words.content
        assert ["arm/upper_arm_link", "arm/wrist_3_link"] in [[c.link for c in one.contacts] for one in live.last_sets.best]
        live.poke(p_W + 0.01 * n_W, -n_W)
        assert len(live.pushes) == 1, "a third one begins anew"


def test_program_serves_the_page_until_it_is_interrupted(program: Path) -> None:
    with children.Child([program, "sense", TUTORIAL, "--live", "--port", "0"]) as live:
        line = live.line()
        found = ADDRESS.match(line)
        assert found, line
        port = found.group(1)
        with socket.create_connection(("127.0.0.1", int(port)), timeout=10):
            pass
        taken = children.run([program, "sense", TUTORIAL, "--live", "--port", port])
        assert taken.returncode == 2 and f"--port: got {port} of 127.0.0.1, which is in use" in taken.stderr
        assert live.stop().returncode == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nothing_like_it", "--live", "--port", "0"], "nothing_like_it"),
        (["ur5_forearm", "--live", "--json"], "--json"),
        (["ur5_forearm", "--port", "1"], "--live"),
        (["ur5_forearm", "--live", "--turn"], "--turn"),
        (["ur5_forearm", "--live", "--noise", "0.2"], "--noise"),
        (["ur5_forearm", "--live", "--rest", "0", "1"], "--rest"),
        (["ur5_forearm", "--live", "--force", "3"], "--force"),
    ],
)
def test_mistakes_are_named(program: Path, words: list[str], message: str) -> None:
    done = children.run([program, "sense", *words])
    assert done.returncode == 2 and message in done.stderr, done.stderr
