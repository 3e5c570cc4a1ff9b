"""Efforts and forces on fragile things on the page of a plan: recomputed from the raw numbers of its file, and what `stiction check` finds."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import browser
import synthetic
from stiction_view import InvalidPlan, load_plan
from stiction_view.charts import charts, peaks, summary
from stiction_view.frames import choose_frames
from stiction_view.loads import read_loads


def knots_of(plan: dict[str, Any]) -> list[dict[str, Any]]:
    return [knot for segment in plan["segments"] for knot in segment["knots"]]


def on_page(text: str) -> dict[str, Any]:
    """What the charts of a page are drawn from, by title."""
    found = re.search(r'<script type="application/json" id="loads">(.*?)</script>', text)
    return json.loads(found[1]) if found else {"charts": []}


def rows_on_page(text: str) -> dict[str, str]:
    return dict(re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td></tr>", text))


@pytest.fixture(scope="module")
def made(root: Path, stiction, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], str, dict[str, Any]]:
    """Plan, page and verdict of a task with a motor without limit and a box that bears little."""
    folder = tmp_path_factory.mktemp("loads")
    task = yaml.safe_load((root / "tasks" / "planar_pushing.yaml").read_text(encoding="utf-8"))
    robot, box = task["scene"]["robots"][0], task["scene"]["objects"][0]
    robot.update(urdf=str(root / "models" / "planar_pusher.urdf"), effort={"y": None, "z": 0.8})
    box["max_force"] = 0.6
    (folder / "task.yaml").write_text(yaml.safe_dump(task, sort_keys=False))
    done = stiction("plan", folder / "task.yaml", "--seed", 0, "-o", folder, "--html")
    assert done.returncode == 0, done.stderr
    judged = stiction("check", folder / "plan.json", "--json")
    assert judged.returncode == 0, judged.stderr
    verdict = {row["name"]: row for row in json.loads(judged.stdout)["checks"]}
    return json.loads((folder / "plan.json").read_text()), (folder / "plan.html").read_text(encoding="utf-8"), verdict


def test_page_of_a_plan_holds_the_shares_of_its_raw_numbers(made) -> None:
    plan, page, verdict = made
    knots = knots_of(plan)
    data = on_page(page)
    effort, press = data["charts"]
    assert len(data["times"]) == len(knots), "few enough knots that each is a frame"

    z = plan["joints"].index("hand/z")
    share = [100 * abs(100.0 * (k["u"][z] - k["joints"][z])) / 0.8 for k in knots]  # the stiffness of the task is 100 N/m
    assert (effort["title"], effort["unit"], effort["names"]) == ("effort used", "%", ["hand/z"])
    np.testing.assert_allclose(effort["values"], [share], atol=0.005 + 1e-9)
    assert max(share) > 10 and max(share) == pytest.approx(100 * verdict["effort"]["value"], rel=1e-9)

    force = [sum(np.dot(c["force"], c["normal"]) for c in k["contacts"]) for k in knots]  # one ball, one box: one pair
    assert (press["title"], press["unit"], press["names"]) == ("max_force used", "%", ["box/box"])
    np.testing.assert_allclose(press["values"], [np.array(force) / 0.006], atol=0.005 + 1e-9)
    assert 10 < max(force) / 0.006 <= 100 * verdict["max_force"]["value"] + 1e-9

    rows = rows_on_page(page)
    assert rows["effort used"].startswith(f"at most {max(share):.1f} % (hand/z), ")
    assert rows["no effort limit"] == "hand/y"
    assert rows["max_force used"].startswith(f"at most {max(force) / 0.006:.1f} % (hand/ball/ball – box/box: {max(force):.3g} of 0.6 N), ")
    place = re.search(r"segment (\d+)", verdict["effort"]["where"])
    assert place and rows["effort used"].endswith(f" {int(place[1]) + 1}"), "pieces are counted from 1 on the page"


def parts(plan: dict[str, Any]) -> tuple[list[dict[str, Any]], dict[str, str]]:
    loads = read_loads(plan)
    places = [f"knot {k}" for k in range(len(loads.torque))]
    return charts(loads, np.arange(len(places))), dict(summary(loads, places))


def test_plan_without_efforts_says_so_and_draws_none() -> None:
    plan = synthetic.make_plan()
    plan["scene_text"] = synthetic.make_scene_text(effort=None)
    plan["segments"][1]["knots"][3]["u"] = [5.0]
    drawn, rows = parts(plan)
    assert drawn == [] and rows == {"effort used": "no motor has a limit"}


def test_plan_without_fragile_things_shows_none() -> None:
    drawn, rows = parts(synthetic.make_plan())
    assert [c["title"] for c in drawn] == ["effort used"] and set(rows) == {"effort used"}


def test_more_joints_without_effort_than_have_room_are_counted() -> None:
    plan = synthetic.make_plan()
    names = ["hand/sweep", *(f"hand/free_{k}" for k in range(6))]
    plan["joints"] = names
    for knot in knots_of(plan):
        knot["u"], knot["joints"] = [*knot["u"], *range(6)], [*knot["joints"], *[0.0] * 6]
    plan["scene_text"] += "".join(f"- {{name: {name}, lower: 0, upper: 1, stiffness: 5}}\n" for name in names[1:])
    drawn, rows = parts(plan)
    assert rows["no effort limit"] == "hand/free_0, hand/free_1, hand/free_2, hand/free_3 and 2 more"
    assert drawn[0]["names"] == ["hand/sweep"], "a joint without effort has no line"


def test_contacts_of_a_pair_press_together_and_pairs_do_not() -> None:
    plan = synthetic.make_plan(knots_per_segment=2, kinds=("settle", "contact"))
    plan["scene_text"] = synthetic.make_scene_text(max_force=5.0)
    first, second = plan["segments"][1]["knots"]
    left, right = second["contacts"]
    second["contacts"] = [left, right, {**right, "force": [0.5 * f for f in right["force"]]}]  # a second point of the right finger
    drawn, rows = parts(plan)
    # A finger of the synthetic plan presses with 4 N along the normal and 1 N across.
    assert drawn[1]["names"] == ["ball/ball"] and drawn[1]["values"] == [[0.0, 0.0, 80.0, 120.0]]
    assert rows["max_force used"] == "at most 120.0 % (hand/right/finger – ball/ball: 6 of 5 N), knot 3"
    second["contacts"] = []
    first["contacts"] = []
    assert parts(plan)[1]["max_force used"] == "at most 0.0 %, nothing touches"


def test_the_fragile_thing_may_be_either_side_and_both() -> None:
    plan = synthetic.make_plan(knots_per_segment=1, kinds=("contact",))
    finger = "- {name: hand/right/finger, shape: {cylinder: [0.012, 0.04]}, pose: {p: [0, 0, 0]}, friction: 0.8, max_force: 16}\n"
    plan["scene_text"] = synthetic.make_scene_text(max_force=8.0) + finger
    drawn, rows = parts(plan)
    assert dict(zip(drawn[1]["names"], drawn[1]["values"])) == {"hand/right/finger": [25.0], "ball/ball": [50.0]}
    assert rows["max_force used"].startswith("at most 50.0 % (hand/left/finger – ball/ball: 4 of 8 N)")


def test_largest_load_is_drawn_though_its_knot_is_no_frame(tmp_path: Path) -> None:
    plan = synthetic.make_plan(knots_per_segment=400, kinds=("settle",) + ("contact", "regrasp") * 4)
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(plan))
    frames = choose_frames(load_plan(file))
    hidden = int(np.setdiff1d(np.arange(frames[-1]), frames)[-7])
    knots_of(plan)[hidden]["u"][0] += 0.19
    (line,) = charts(read_loads(plan), frames)[0]["values"]
    assert len(line) == len(frames) and max(line) == 95.0
    assert frames[int(np.argmax(line)) - 1] < hidden < frames[int(np.argmax(line))]
    values = np.random.default_rng(0).uniform(size=(frames[-1] + 1, 3))
    np.testing.assert_array_equal(peaks(values, np.arange(len(values))), values)


def test_coordinate_that_the_scene_does_not_have_is_named(tmp_path: Path) -> None:
    plan = synthetic.make_plan()
    plan["scene_text"] = plan["scene_text"].replace("hand/sweep", "hand/swing")
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(plan))
    with pytest.raises(InvalidPlan, match=re.escape(f"{file}: scene_text: no coordinate 'hand/sweep', which is one of joints")):
        load_plan(file)


@browser.needed
def test_charts_follow_the_time_bar(made, tmp_path: Path) -> None:
    _, page, _ = made
    file = tmp_path / "plan.html"
    file.write_text(page, encoding="utf-8")
    data = on_page(page)
    effort = np.array(data["charts"][0]["values"][0])
    peak = int(effort.argmax())
    with browser.Browser() as window:
        window.open(file)
        window.wait_for(lambda: window.evaluate("document.querySelector('.mantine-Slider-track') !== null"), 90, "the time bar")

        def at_peak() -> bool:  # or beside it: a pixel of the bar may be more than a frame
            window.scrub((data["times"][peak] + 0.01) / data["end"])
            time = window.evaluate("Number(document.querySelector('.mantine-Slider-thumb').getAttribute('aria-valuenow'))")
            frame = int(np.searchsorted(data["times"], time + 1e-3, side="right")) - 1
            words = window.evaluate("document.querySelector('#stiction .now').textContent")
            return abs(time - data["times"][peak]) < 0.01 * data["end"] and words == f"{effort[frame]:.1f} % hand/z"

        window.wait_for(at_peak, 180, "the figures of that moment")
        cursor = window.evaluate("Number(document.querySelector('#stiction svg line:last-of-type').getAttribute('x1'))")
        assert cursor == pytest.approx(1000 * data["times"][peak] / data["end"], abs=10)
        assert window.evaluate("document.querySelectorAll('#stiction svg polyline').length") == 2
        assert window.evaluate("document.querySelector('#stiction .largest').textContent") == "— hand/z"
        assert window.errors == []
