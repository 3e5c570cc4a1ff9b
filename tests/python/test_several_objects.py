"""Tasks with several objects, tools and bystanders, from the file to the end of the run."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import referencing
from test_schema import load

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip("build/release/python does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

DATA = ROOT / "tests" / "tasks" / "data"
SCHEMAS = {path.name: json.loads(path.read_text()) for path in (ROOT / "tasks" / "schema").glob("*.json")}
REGISTRY = referencing.Registry().with_resources([(name, referencing.Resource.from_contents(schema)) for name, schema in SCHEMAS.items()])


def validator(name: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator({"$ref": name}, registry=REGISTRY)


@pytest.mark.parametrize("name", ["two_boxes", "stick", "clutter", "careful_clutter"])
def test_task_is_planned_and_accepted(stiction, tmp_path: Path, name: str) -> None:
    file = DATA / f"{name}.yaml"
    validator("task.schema.json").validate(load(file))
    done = stiction("plan", file, "--seed", 1, "-o", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    plan = json.loads((tmp_path / "plan.json").read_text())
    validator("plan.schema.json").validate(plan)
    checked = stiction("check", tmp_path)
    assert checked.returncode == 0, checked.stdout
    assert ("bystander_move" in checked.stdout) == ("bystanders" in plan["goal"]) == (name == "careful_clutter")


@pytest.mark.parametrize("name", ["two_boxes", "stick"])
def test_run_reaches_the_goal_of_all_objects(name: str) -> None:
    task = st.load_task(DATA / f"{name}.yaml")
    ran = st.run(task, seed=1)
    assert ran.reached
    assert ran.true_error.position <= task.goal.tol_position and ran.true_error.angle <= task.goal.tol_angle


def test_goal_of_several_objects_takes_the_numbers_of_all() -> None:
    goal = [-0.6, 0.6, 0.0, 0.8, 0.5, 0.0]
    task = st.load_task(DATA / "two_boxes.yaml").with_(goal=goal)
    assert list(task.q_goal) == goal
    there = [*goal, 0.0, -0.2]
    aside = list(there)
    aside[4] += 0.03
    assert task.goal_errors([there, aside])[:, 0] == pytest.approx([0, 0.03], abs=1e-12)
    with pytest.raises(st.InvalidInput, match="'left' and 'right'"):
        task.set_goal([0.0, 0.0, 0.0])


@pytest.mark.parametrize("values", [[0, -0.5, None], (0.0, -0.5, None), np.array([0, -0.5, None])], ids=["integers", "tuple", "array"])
def test_none_leaves_a_coordinate_of_the_goal_open(values: object) -> None:
    task = st.load_task("planar_pushing")
    other = task.with_(goal=values)
    task.set_goal(values)
    assert task.goal.open == other.goal.open == [False, False, True]
    for wrong, message in (([0, math.nan, None], r"goal\[1\]: got nan"), ([0, None], "got 2 numbers"), ([0.0, -0.5, math.nan], r"goal\[2\]: got nan")):
        with pytest.raises(st.InvalidInput, match=message):
            task.with_(goal=wrong)


def test_bystanders_stand_where_a_plan_starts() -> None:
    """Of a plan from elsewhere than the start of the task, `check` says no more than what the plan itself moves."""
    task = st.load_task(DATA / "careful_clutter.yaml")
    start = task.q_start.copy()
    start[3 + 3 * 7] -= 0.1  # can8, by more than it may move
    result = st.plan(task, q_start=start, seed=1)
    assert result.status == st.Status.Solved
    report = st.check_plan(result.plan)
    assert report.pass_ and report.at("bystander_move").value <= 0.05
