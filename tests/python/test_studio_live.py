"""A closed loop in the studio that somebody pulls at with the mouse, without a browser."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402
from studio_driven import Driven  # noqa: E402

from stiction_view.studio import catalog, running  # noqa: E402
from stiction_view.studio.app import Studio  # noqa: E402
from stiction_view.studio.control_live import ControlLive  # noqa: E402
from stiction_view.studio.jobs import Job  # noqa: E402
from stiction_view.studio.live import LivePlant, Pull  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402

# A puck of 0.5 kg that nothing holds back, and a finger that is far away.
FREE = {
    "scene": {
        "gravity": [0, 0, 0],
        "robots": [{"name": "hand", "stiffness": 100, "urdf": """<robot name="finger"><link name="base"/><link name="tip"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
          <joint name="slide" type="prismatic"><parent link="base"/><child link="tip"/><origin xyz="0 0 2"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="50"/></joint></robot>"""}],
        "objects": [{"name": "puck", "joint": "free", "mass": 0.5, "shapes": [{"name": "disc", "sphere": {"radius": 0.05}, "friction": 0.5}]}],
    },
    "start": {"objects": {"puck": {"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}}},
    "goal": {"objects": {"puck": {"position": [0.1, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}}},
    "tolerance": {"position": 0.01, "angle": 0.1},
}


def free_plant(newton: float = 2.0) -> LivePlant:
    return LivePlant(st.Task(FREE), newton=newton, stretch=0.1, pace=0)


def rest(plant: LivePlant, seconds: float) -> None:
    for _ in range(round(seconds / 0.01)):
        assert plant.command(plant.read().u, 0.01)


def test_free_mass_that_is_pulled_from_afar_moves_with_constant_acceleration() -> None:
    """F = 2 N at 0.5 kg: x = ½ (F/m) t², and v stays after the hand lets go."""
    plant = free_plant()
    plant.hold.pull = Pull("puck", np.zeros(3), np.array([100.0, 0, 0]))
    rest(plant, 0.2)
    x = plant.now()[1][0]
    assert x == pytest.approx(0.5 * 4.0 * 0.2**2, rel=0.02)
    np.testing.assert_allclose(plant.now()[2], [2, 0, 0], atol=1e-6)
    plant.hold.pull = None
    rest(plant, 0.1)
    assert plant.now()[1][0] - x == pytest.approx(4.0 * 0.2 * 0.1, rel=0.02)
    assert not plant.now()[2].any() and plant.log.force_W[-1].shape == (3,)


def test_force_grows_with_the_way_up_to_the_limit() -> None:
    plant = free_plant(newton=3.0)
    for way, force in ((0.05, 1.5), (0.1, 3.0), (0.7, 3.0)):
        plant.hold.pull = Pull("puck", np.zeros(3), plant.now()[1][:3] + [0, 0, way])
        rest(plant, 0.01)
        assert plant.now()[2][2] == pytest.approx(force, rel=1e-6)


def test_force_beside_the_centre_turns_the_object() -> None:
    plant = free_plant()
    plant.hold.drag(plant.now()[1], "puck", np.array([0.0, 0.05, 0.0]), np.array([0.0, 0.05, 0.0]), "start")
    plant.hold.drag(plant.now()[1], "puck", np.zeros(3), np.array([100.0, 0.05, 0]), "update")
    rest(plant, 0.1)
    q = plant.now()[1]
    assert 2 * q[5] / q[6] < -0.05, "about −z: r × F = (0, r, 0) × (F, 0, 0)"
    assert np.linalg.norm(plant.log.point_W[-1] - plant.log.q[-2][:3]) == pytest.approx(0.05, abs=1e-6), "where it was taken"


def test_clock_of_the_plant_is_not_ahead_of_the_one_on_the_wall() -> None:
    plant = LivePlant(st.Task(FREE), newton=1, stretch=0.1, pace=2.0)
    plant.command(plant.read().u, 0.01)
    assert plant._begun is not None
    slept: list[float] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stiction_view.studio.live.time.monotonic", lambda: plant._begun)
        patch.setattr("stiction_view.studio.live.time.sleep", slept.append)
        plant.command(plant.read().u, 0.1)
    assert slept == [pytest.approx(plant.now()[0] / 2)]


@pytest.fixture
def driven(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Driven]:
    """As fast as it goes."""
    entries, first = catalog.find("planar_pushing")
    monkeypatch.setattr(running, "LivePlant", lambda task, newton, stretch: LivePlant(task, newton, stretch, pace=0))
    with serving("127.0.0.1", 0) as server:
        yield Driven(Studio(server, entries, first, tmp_path))


def test_object_that_is_pulled_away_is_brought_back_until_it_is_cancelled(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    studio.posing.problem.set_goal_numbers([0.0, 0.75, 0.0])
    studio.posing.moved()
    driven.press("run")
    assert driven.said == [] and studio.stage.running is not None and studio.stage.posed is None
    drawn = [handle for handle, _ in studio.stage.running.painted["box"]]
    assert drawn and all(handle._impl.drag_cb for handle in drawn), "the mouse can take it"
    plant = studio.running.plant
    driven.until(lambda: "at the goal" in panel.search.progress_text.content)
    point = np.array(studio.posing.pictures.model.object_pose(plant.now()[1], "box").p)
    panel.run.newton.value = 400.0
    driven.until(lambda: plant.hold.newton == 400.0)
    studio.running.pull("box", point, point, "start")
    studio.running.pull("box", point, point + [0, -3.0, 0], "update")
    driven.until(lambda: studio.stage._hand.visible)
    driven.until(lambda: plant.now()[1][0] < 0.6)
    studio.running.pull("box", point, point, "end")
    assert plant.hold.pull is None
    driven.until(lambda: "tolerances from the goal" in panel.search.progress_text.content)
    driven.until(lambda: "at the goal:" in panel.search.progress_text.content)
    driven.press("cancel")
    driven.until(lambda: studio.work.running is None)
    ended = panel.head.message.content
    assert "2 times at the goal" in ended and "pulled with up to 400 N" in ended and "⚠" not in ended
    assert studio.running.plant is None and studio.stage.running is None and studio.showing.played is not None
    assert {"distance from the goal", "force of the hand"} == set(studio.showing.played.charts)
    assert studio.showing.played.charts["force of the hand"][1].max() == pytest.approx(400, rel=1e-6)


def test_plan_that_is_shown_is_what_runs_and_another_pose_ends_it(driven: Driven) -> None:
    studio = driven.studio
    driven.panel.search.budget.value = 200.0
    driven.plan()
    driven.press("run")
    driven.until(lambda: studio.running.plant is not None and studio.running.plant.now()[0] > 1.0)
    studio.posing.problem.set_goal_numbers([0.0, 0.3, 0.0])
    studio.posing.moved()
    driven.until(lambda: studio.work.running is None)
    assert studio.stage.posed is not None and studio.showing.played is None, "what is posed stays on the stage"
    assert "run live" in driven.panel.head.message.content and driven.said == []


def test_run_is_refused_while_another_job_runs_and_without_a_task(driven: Driven) -> None:
    studio, gate = driven.studio, threading.Event()
    studio.work.start(Job("Waiting", lambda _: gate.wait(60), lambda _: None))
    driven.press("run")
    assert "another job runs (waiting)" in driven.said[-1] and studio.stage.posed is not None
    gate.set()
    driven.until(lambda: studio.work.running is None)
    driven.panel.head.pick.value = next(e.label for e in studio.entries if e.source == "panda_wrist")
    driven.until(lambda: studio.showing.played is not None)
    driven.press("run")
    assert driven.said[-1] == "run: no task is open; open one"


def test_weight_is_what_a_pull_begins_with(driven: Driven) -> None:
    assert driven.panel.run.newton.value == pytest.approx(9.81 * 5, rel=0.05)


# ---- an arm under control ----


def test_link_that_is_pulled_at_yields_and_is_a_contact_of_the_controller() -> None:
    """Away from everything: the only force is that of the hand, grows with its way, and goes when it lets go."""
    scenario = st.load_control_scenario("box_in_the_way")
    with serving("127.0.0.1", 0) as server:
        live = ControlLive(server, scenario, "/live", pace=0)
        try:
            poses = scenario.model.body_poses(np.array(live.loop.q))
            point = poses["arm/link_4"].p
            live.hold.newton = 10.0
            live.pull("arm/link_4", point, point, "start")
            live.pull("arm/link_4", point, point + [0, 0, 5.0], "update")
            wait_for(lambda: any(f.pair < 0 for f in live.sample().forces))
            force = next(f for f in live.sample().forces if f.pair < 0)
            np.testing.assert_allclose(np.linalg.norm(force.force_W), 10.0, rtol=1e-9)
            assert force.force_W[2] > 9.9
            live.tick(0.0)
            assert live.hand.visible and "N** of 15" in live.words.content
            live.pull("arm/link_4", point, point, "end")
            wait_for(lambda: not any(f.pair < 0 for f in live.sample().forces))
            live.tick(0.0)
            assert not live.hand.visible
        finally:
            live.remove()
        assert not live._thread.is_alive() and live.message == ""


def test_controlled_arm_is_bounded_at_the_wall_as_in_the_run_of_the_scenario() -> None:
    """Tick by tick the same as `stiction.control`, where nobody pulls."""
    scenario = st.load_control_scenario("box_in_the_way")
    whole, loop = st.control(scenario), st.ControlLoop(scenario)
    samples = [loop.tick() for _ in range(800)]
    np.testing.assert_array_equal([s.q for s in samples], whole.q[:800])
    np.testing.assert_array_equal([s.largest_force for s in samples], whole.largest_force[:800])
    assert whole.largest_force[:800].max() > 5, "it touches: otherwise this says nothing"


def test_scenario_of_control_is_opened_live_in_the_studio(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    panel.head.pick.value = next(e.label for e in studio.entries if e.source == "box_in_the_way")
    driven.until(lambda: studio.showing.played is not None)
    assert panel.playback.live.visible
    driven.press("live")
    live = studio.stage.guest
    assert isinstance(live, ControlLive) and driven.said == []
    assert panel.run.newton.order < live.folder.order < panel.playback.folder.order, "its controls stand where somebody looks"
    driven.until(lambda: live.sample().time > 0.02 and "t = " in live.words.content)
    panel.head.pick.value = "planar_hand"
    driven.until(lambda: studio.posing.problem is not None and studio.stage.guest is None)
    assert not live._thread.is_alive() and live.folder._impl.removed


def wait_for(condition: Callable[[], object], seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
