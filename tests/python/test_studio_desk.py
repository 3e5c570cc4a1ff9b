"""The studio without a browser: a server, the controls set as the page sets them, and the loop run by hand."""

from __future__ import annotations

import io
import json
import random
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402
from studio_driven import Driven  # noqa: E402

from stiction_view.studio import catalog, planning  # noqa: E402
from stiction_view.studio.app import Studio  # noqa: E402
from stiction_view.studio.cameras import is_seen  # noqa: E402
from stiction_view.studio.growing import Growing  # noqa: E402
from stiction_view.studio.panel import NOTHING  # noqa: E402
from stiction_view.studio.results import MAX_SAMPLES  # noqa: E402
from stiction_view.studio.sense_live import Live  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402
from stiction_view.studio.showing import IN_MUJOCO  # noqa: E402
from stiction_view.studio.stage import Grip, best_view, goal_of, plan_of  # noqa: E402


@pytest.fixture
def driven(tmp_path: Path) -> Iterator[Driven]:
    entries, first = catalog.find("planar_pushing")
    with serving("127.0.0.1", 0) as server:
        made = Driven(Studio(server, entries, first, tmp_path))
        made.panel.search.budget.value = 200.0  # on a busy machine a second is little
        yield made


def test_plan_check_simulate_and_compare(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    driven.until(lambda: "no fault" in panel.pose.faults.content)
    assert not panel.playback.folder.visible and studio.stage.posed is not None
    driven.plan()
    assert "**solved**" in panel.figures.words.content and "stiction plan planar_pushing --seed 0" in panel.export.command.content
    assert studio.stage.posed is None and len(studio.stage.shown) == 1 and len(panel.figures.charts) >= 3
    driven.until(lambda: studio.showing.knot >= 3)
    assert "motors" in panel.playback.line.content, "it plays, and says what the motors give"

    driven.press("check")
    driven.until(lambda: "**check** passed" in panel.figures.words.content and "**check** passed" in panel.head.message.content)
    panel.search.budget.value = 5.0  # of seven minutes of simulated time some are enough
    driven.press("simulate")
    panel.search.budget.value = 200.0
    driven.until(lambda: panel.playback.beside.value == IN_MUJOCO and len(studio.stage.shown) == 2)
    first, second = (d.root_node.position for d in studio.stage.shown if d.root_node is not None)
    assert np.linalg.norm(np.subtract(first, second)) > studio.stage.shown[0].view.radius, "beside each other"

    run = studio.showing.result.run
    assert run.planned.poses.shape == run.simulated.poses.shape and len(run.times) == len(run.planned.poses) <= MAX_SAMPLES
    assert 0 < np.abs(run.planned.poses - run.simulated.poses).max() < 1 and "**in MuJoCo**" in panel.figures.words.content and "**in MuJoCo**" in panel.head.message.content
    studio.posing.problem.set_goal_numbers([0.1, 0.4, 0.3])
    studio.posing.moved()
    assert studio.stage.posed is not None and studio.stage.shown == [] and panel.pose.goal[1].value == pytest.approx(0.4)
    driven.plan()
    assert "--goal '0.1 0.4 0.3'" in panel.export.command.content
    np.testing.assert_allclose(studio.showing.result.plan.task.goal.X_WG.p[1:], [0.1, 0.4], atol=1e-9)  # y and z
    panel.playback.beside.value = studio.showing.results[0].label
    driven.until(lambda: len(studio.stage.shown) == 2)
    panel.playback.which.value = studio.showing.results[0].label
    driven.until(lambda: studio.showing.result is studio.showing.results[0])
    assert driven.said == []


def test_tree_grows_while_it_plans_and_cancel_keeps_the_best_path(driven: Driven, monkeypatch: pytest.MonkeyPatch) -> None:
    studio, panel = driven.studio, driven.panel
    panel.head.pick.value = "allegro_cube_180"
    driven.until(lambda: studio.opened == "allegro_cube_180")
    above = [handle.value for handle in panel.pose.goal]
    above[2] += 0.1  # no hand throws the cube, so that the search goes on until it is cancelled
    studio.posing.problem.set_goal_numbers(above)
    studio.posing.moved()
    grown: list[Growing] = []
    start = planning.start_growing
    monkeypatch.setattr(planning, "start_growing", lambda *words: grown.append(start(*words)) or grown[-1])
    driven.press("plan")
    driven.until(lambda: grown[0].parts and grown[0].best is not None)
    lines = sum(len(part.points) for part in grown[0].parts)
    driven.until(lambda: sum(len(part.points) for part in grown[0].parts) > 1.5 * lines)
    assert len(grown[0].parts) <= 1 + np.log2(sum(len(part.points) for part in grown[0].parts)), "few parts"
    assert "tolerances from the goal" in panel.search.progress_text.content and panel.search.cancel.visible
    driven.press("cancel")
    driven.until(lambda: studio.work.running is None)
    assert grown[0].parts == [] and studio.stage.posed is None and studio.stage.shown and studio.showing.result.plan.status == st.Status.Cancelled
    assert "cancelled, best path so far" in panel.head.message.content


def test_plan_that_is_not_solved_says_so_in_words(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    studio.posing.problem.set_goal_numbers([30.0, -0.5, 0.0])
    studio.posing.moved()
    panel.search.budget.value = 1.0
    driven.plan()
    assert "**not solved in time, best path so far**" in panel.head.message.content
    driven.press("check")
    driven.until(lambda: "**check** failed: " in panel.head.message.content)
    assert "the search ended without a solution" in panel.head.message.content and "status" not in panel.head.message.content
    assert driven.said == []


def test_motion_that_is_over_plays_again_from_its_start(driven: Driven) -> None:
    studio, playback = driven.studio, driven.panel.playback
    driven.plan()
    last = int(playback.frame.max)
    playback.frame.value = last
    driven.until(lambda: not playback.play.value)
    assert studio.showing.knot == last
    playback.play.value = True
    driven.until(lambda: 0 < studio.showing.knot < last)
    assert playback.play.value and driven.said == []


def test_goal_far_away_and_the_start_show_in_a_narrow_picture(driven: Driven) -> None:
    problem, pictures = driven.studio.posing.problem, driven.studio.posing.pictures
    start = goal_of(problem).p
    problem.set_goal_numbers([30.0, -0.5, 0.0])
    view = best_view(plan_of(problem, pictures), pictures)
    for point in (start, goal_of(problem).p):
        assert is_seen(view, 1.5, point) and not is_seen(view, 0.5, point) and is_seen(view.for_picture(0.5), 0.5, point)
    assert view.for_picture(1.5) is view


def test_what_runs_is_dropped_when_another_task_is_picked(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    panel.head.pick.value = "allegro_cube_180"
    driven.until(lambda: studio.opened == "allegro_cube_180")
    driven.press("plan")
    with pytest.raises(ValueError, match=r"Checking: got it while another job runs \(planning\); cancel that first"):
        studio.work.must_be_free("Checking")
    panel.head.pick.value = next(e.label for e in studio.entries if e.source == "panda_wrist")
    driven.until(lambda: studio.showing.played is not None)
    assert studio.showing.results == () and driven.said == [], "the scenario waited for the end of the search, whose result nobody wants"


def test_goal_in_reach_of_nothing_is_marked_and_reset_brings_it_back(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    panel.head.pick.value = "planar_hand"
    driven.until(lambda: studio.opened == "planar_hand" and "no fault" in panel.pose.faults.content)
    given = [handle.value for handle in panel.pose.goal]
    panel.pose.goal[0].value = 50.0
    driven.until(lambda: "no robot reaches" in panel.pose.faults.content)
    assert len(studio.stage._marks) == 1, "where the goal is"
    panel.search.seed.value = 3
    driven.until(lambda: studio.posing.problem.seed == 3)
    panel.search.seed.value = -5
    driven.until(lambda: driven.said == ["Seed: got -5, expected a whole number from 0 on; 3 stays"])
    driven.press("reset")
    driven.until(lambda: "no fault" in panel.pose.faults.content)
    assert [handle.value for handle in panel.pose.goal] == pytest.approx(given)


def test_goal_that_moves_is_planned_anew_when_wanted(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    panel.search.again.value = True
    driven.until(lambda: "no fault" in panel.pose.faults.content)
    assert studio.work.running is None, "nothing moved yet"
    studio.posing.drag(Grip(0, at_goal=True), st.Pose(np.eye(3), [0.0, 0.5, 0.0]), True)
    driven.until(lambda: studio.showing.result is not None)
    np.testing.assert_allclose(studio.showing.result.plan.task.goal.X_WG.p[1], 0.5, atol=1e-9)


def test_options_are_named_refused_and_used(driven: Driven) -> None:
    studio, panel = driven.studio, driven.panel
    field, handle = panel.options.fields["goal_bias"]
    assert field.meaning.startswith("Probability")
    handle.value = 0.25
    driven.until(lambda: "goal_bias" in panel.options.fault.content)
    panel.options.fields["sample_box"][1].value = "{not json"
    driven.until(lambda: "⚠" in panel.options.fault.content)
    driven.press("options_reset")
    assert studio.posing.problem.options == {} and panel.options.fields["goal_bias"][1].value != 0.25
    panel.options.fields["goal_bias"][1].value = 0.25
    driven.until(lambda: studio.posing.problem.options == {"goal_bias": 0.25})
    driven.plan()
    assert studio.showing.result.plan.options.goal_bias == 0.25
    assert '"goal_bias": 0.25' in panel.export.command.content and "task.yaml" in panel.export.command.content


def test_problem_is_reported_with_and_without_a_plan(driven: Driven, monkeypatch: pytest.MonkeyPatch) -> None:
    studio, panel = driven.studio, driven.panel
    sent: list[tuple[str, bytes]] = []
    monkeypatch.setattr(studio.downloads._server, "send_file_download", lambda name, content, **_: sent.append((name, content)))

    def report() -> tuple[str, dict[str, bytes]]:
        sent.clear()
        driven.press("report", None)
        driven.until(lambda: sent and studio.work.running is None)
        with zipfile.ZipFile(io.BytesIO(sent[0][1])) as archive:
            return sent[0][0], {name: archive.read(name) for name in archive.namelist()}

    panel.export.note.value = "it goes through the wall"
    studio.posing.problem.seed = 4
    name, files = report()
    about = json.loads(files["report.json"])
    assert name == "planar_pushing-report.zip" and about["note"] == "it goes through the wall"
    assert about["tried"]["seed"] == 4 and about["tried"]["status"] == "Solved" and "lint" in about["tried"] and "plan.json" in files
    driven.plan()
    shown = studio.showing.result.plan
    assert json.loads(report()[1]["plan.json"])["seed"] == shown.seed and driven.said == []
    panel.head.pick.value = next(e.label for e in studio.entries if e.source == "panda_wrist")
    driven.until(lambda: studio.showing.played is not None)
    driven.press("report", None)
    assert "no task is open" in driven.said[-1]


@pytest.mark.parametrize(("name", "words"), [("panda_wrist", "N, leaves"), ("box_in_the_way", "** of 15")])
def test_scenarios_are_played(driven: Driven, name: str, words: str) -> None:
    panel, studio = driven.panel, driven.studio
    panel.head.pick.value = next(e.label for e in studio.entries if e.source == name)
    driven.until(lambda: studio.showing.played is not None and words in panel.playback.line.content)
    assert any(len(c) > 0 for c in studio.showing.played.drawn.contacts), "forces are drawn"
    driven.press("plan")
    assert driven.said[-1] == "plan: no task is open; open one"
    panel.head.pick.value = "planar_hand"
    driven.until(lambda: studio.posing.problem is not None and "Lint" in panel.pose.faults.content)


def test_scenario_is_sensed_live_and_leaves_nothing_behind(driven: Driven) -> None:
    panel, studio = driven.panel, driven.studio
    driven.press("live")
    assert driven.said == ["live: no scenario of sensing or control is shown; open one"] and not panel.playback.live.visible
    panel.head.pick.value = next(e.label for e in studio.entries if e.source == "panda_wrist")
    driven.until(lambda: studio.showing.played is not None)
    assert panel.playback.live.visible
    driven.press("live")
    live = studio.stage.guest
    assert isinstance(live, Live) and studio.stage.shown == []
    driven.until(lambda: live.words.content)
    link = live.sensor.links[-1]
    X = live.model.body_poses(live.configuration(0))[link.name]
    point, normal = X.R @ link.p_L[0] + X.p, X.R @ link.n_L[0]
    live.events.put(lambda: live.poke(point + 0.5 * normal, -normal))
    driven.until(lambda: "pushed at" in live.words.content)
    panel.head.pick.value = "planar_hand"
    driven.until(lambda: studio.posing.problem is not None and studio.stage.posed is not None)
    assert studio.stage.guest is None and live.folder._impl.removed and live.drawing.root_node._impl.removed
    assert not panel.playback.live.visible and len(driven.said) == 1


def test_a_hundred_things_pressed_at_random_are_no_fault_of_the_studio(driven: Driven) -> None:
    studio, panel, rng = driven.studio, driven.panel, random.Random(0)
    panel.search.budget.value = 1.0
    tasks = ["planar_pushing", "planar_hand", "allegro_door"]
    names = [n for n in studio.handlers.by_name if n not in ("upload", "pick", "view")]
    for _ in range(100):
        what = rng.randrange(8)
        if what == 0:
            panel.head.pick.value = rng.choice(tasks)
        elif what == 1 and panel.pose.goal:
            rng.choice(panel.pose.goal).value = rng.uniform(-1, 1)
        elif what == 2 and panel.pose.joints:
            slider = rng.choice(panel.pose.joints)
            slider.value = rng.uniform(slider.min, slider.max)
        elif what == 3:
            panel.playback.beside.value = rng.choice(panel.playback.beside.options)
        elif what == 4:
            panel.pose.handle.value = rng.choice(panel.pose.handle.options)
        elif what == 5:
            driven.press("view", rng.choice(["pose", "result"]))
        elif what == 6:
            content = bytes(rng.randrange(256) for _ in range(30))
            name = rng.choice(["a.urdf", "b.stl", "c.zip", "../d.xml", "e.obj"])
            driven.press("upload", name, content)
        else:
            driven.press(rng.choice(names))
        studio.step(0.0)
    driven.press("cancel")
    driven.until(lambda: studio.work.running is None)
    studio.step(0.01)
    assert not [text for text in driven.said if text.startswith("a fault of the studio")]
    assert (panel.playback.which.value == NOTHING) == (not studio.showing.results)
