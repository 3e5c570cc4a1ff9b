"""Plans as sequences, pages from Python, an arm that feels its way, and the examples that are notebooks."""

from __future__ import annotations

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
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402


@pytest.fixture(scope="module")
def plan() -> st.Plan:
    result = st.plan(st.load_task("planar_hand"), seed=3)
    assert result.status == st.Status.Solved and len(result.plan) > 3
    return result.plan


def test_a_plan_is_a_sequence_of_segments(plan: st.Plan) -> None:
    assert [segment.kind for segment in plan] == [segment.kind for segment in plan.segments]
    assert np.array_equal(plan[-1].q, plan.segments[-1].q)
    for index in (len(plan), -len(plan) - 1):
        with pytest.raises(IndexError, match=f"of {len(plan)} segments"):
            _ = plan[index]


def test_parts_of_a_plan_are_plans_that_follow_each_other(plan: st.Plan, tmp_path: Path) -> None:
    first, rest = plan[:2], plan[2:]
    assert np.array_equal(np.vstack([first.q, rest.q[1:]]), plan.q) and np.array_equal(np.vstack([first.u, rest.u[1:]]), plan.u)
    assert np.array_equal(rest.q[0], first.q[-1]) and np.array_equal(rest.task.q_start, rest.q[0])
    assert (first.status, rest.status) == (st.Status.MaxIterations, plan.status)
    assert np.array_equal(plan.task.q_start, plan.q[0]), "the plan itself stays as it is"
    rest.write(tmp_path / "plan.json")
    for again in (st.read_plan(tmp_path), pickle.loads(pickle.dumps(rest))):
        assert np.array_equal(again.q, rest.q) and np.array_equal(again.u, rest.u) and again.status == rest.status
    (file,) = first.export(tmp_path / "first.npz")
    with np.load(file) as motion:
        assert set(motion["kinds"]) == {segment.kind.name.lower() for segment in first}
    failed = {item.name for item in st.check_plan(first).items if not item.pass_}
    assert failed <= {"goal_position", "goal_angle", "status"}, "nothing but that it ends early"


@pytest.mark.parametrize("by", ["argument", "task"])
def test_a_plan_with_options_of_its_own_passes_the_check_once_read(by: str, stiction, tmp_path: Path) -> None:
    task, options = st.load_task("planar_pushing"), {"goal_bias": 0.3, "tolerance_fraction": 0.5}
    result = st.plan(task, options=options) if by == "argument" else st.plan(task.with_(options=options))
    assert result.status == st.Status.Solved and st.check_plan(result.plan).pass_
    result.plan.write(tmp_path / "plan.json")
    assert st.check_plan(st.read_plan(tmp_path)).pass_
    done = stiction("check", tmp_path)
    assert done.returncode == 0 and "the options were given by the caller" in done.stderr + done.stdout


def test_a_plan_from_a_start_of_its_own_passes_the_check_once_read(stiction, tmp_path: Path) -> None:
    task = st.load_task("planar_pushing")
    start = task.q_start.copy()
    start[0] += 0.05
    result = st.plan(task, q_start=start)
    assert result.status == st.Status.Solved
    result.plan.write(tmp_path / "plan.json")
    assert st.check_plan(st.read_plan(tmp_path)).pass_ and stiction("check", tmp_path).returncode == 0


@pytest.mark.parametrize(("part", "message"), [(slice(2, 2), r"^segments: got \[2, 2\)"), (slice(None, None, 2), "^slice: got a step of 2, expected neighbouring segments")])
def test_parts_that_are_no_plan_are_refused(plan: st.Plan, part: slice, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        _ = plan[part]


def test_pages_of_a_plan_and_of_a_task(plan: st.Plan, tmp_path: Path) -> None:
    page = st.view(plan, html=tmp_path / "new" / "plan.html")
    assert page is not None and page.stat().st_size > 1e5
    still = plan.task.as_plan()
    assert still.q.shape == (2, plan.task.model.n_q) and np.array_equal(still.q[1], plan.task.q_start) and still.status == st.Status.MaxIterations
    with pytest.raises(st.InvalidInput, match="^shown: got str, expected a Plan or a Task"):
        st.view("plan.json", html=tmp_path / "plan.html")  # type: ignore[arg-type]
    with pytest.raises(st.InvalidInput, match="plan.html: cannot be written|plan.html: got a folder|cannot be made"):
        st.view(plan, html="/proc/plan.html")


def test_the_viewer_that_is_not_there_is_named(tmp_path: Path) -> None:
    from stiction.pages import find_viewer

    assert (find_viewer(MODULE / "stiction") / "stiction_view").is_dir()
    with pytest.raises(ImportError, match="no package stiction_view beside"):
        find_viewer(tmp_path)


def test_page_of_the_command_that_cannot_be_written_is_refused_before_the_work(stiction, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for page in (tmp_path, tmp_path / "file" / "task.html"):
        done = stiction("view", "planar_pushing", "--html", page)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and str(page.name) in done.stderr or str(tmp_path) in done.stderr, done.stderr


def test_touch_says_what_it_met() -> None:
    scenario = st.load_touch_scenario("reach_past_pillar")
    run = st.touch(scenario, seed=0)
    assert run.status == st.Status.Solved and run.reached and run.outcome == st.TouchOutcome.Reached and run.goal_error <= scenario.tolerance
    assert run.touches and all(touch.link.startswith("arm/") or "/" in touch.link for touch in run.touches)
    assert run.run.q.shape == (len(run.run.times), scenario.model.n_a) and len(run.map.bodies) == len(scenario.model.bodies) + len(run.touches)
    assert [route.found for route in run.routes].count(True) >= 2 and run.routes[0].postures.shape[1] == scenario.model.n_a
    assert len(scenario.make_world(0).bodies) > len(scenario.model.bodies)


def test_scenarios_of_touch_that_are_not_there_are_named() -> None:
    with pytest.raises(st.InvalidInput, match="no_such_scenario"):
        st.touch("no_such_scenario")
    with pytest.raises(st.InvalidInput, match="timeout_s"):
        st.touch("reach_past_pillar", timeout_s=0)


@pytest.mark.parametrize(
    ("example", "expected"),
    [("panda_box.py", ["lint: []", "CheckReport: passed", "nearer goal: [ 0.5  -0.1   0.05] m"]), ("gradients_through_contact.py", ["exact 0.000, smoothed 0.3", "exact: the box ends"]), ("where_was_my_robot_touched.py", ["Explained"])],
)
def test_examples_that_are_notebooks_run(example: str, expected: list[str], tmp_path: Path) -> None:
    file = ROOT / "python" / "examples" / example
    assert file.read_text(encoding="utf-8").count("# %% ") >= 4, "cells"
    done = children.run([sys.executable, file], env={"PYTHONPATH": str(MODULE)}, cwd=tmp_path, limit=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert not [words for words in expected if words not in done.stdout], done.stdout
